//! Admits requests by their `Host` and `Origin` headers, and checks the token.
//!
//! A foreign page may open a socket to this machine, which `Origin` shows; by DNS rebinding its own
//! name may lead here, which `Host` shows. So `Host` must be `localhost` or an address, with this
//! port, and `Origin`, if present, must be the same.

use std::net::{IpAddr, SocketAddr};

/// Random bytes of a token.
pub const TOKEN_BYTES: usize = 16;

/// The secret for steering, new for each run.
#[derive(Clone, PartialEq, Eq)]
pub struct Token(String);

impl Token {
    /// The token of these bytes.
    #[must_use]
    pub fn of(bytes: [u8; TOKEN_BYTES]) -> Self {
        Self(files::hex::hex(&bytes))
    }

    /// The token as text in the address.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Compares in constant time.
    #[must_use]
    pub fn is(&self, shown: &str) -> bool {
        let pairs = self.0.bytes().zip(shown.bytes());
        let differing = pairs.fold(0, |bits, (a, b)| bits | (a ^ b));
        self.0.len() == shown.len() && differing == 0
    }
}

impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token(…)")
    }
}

/// Whether a request is for this server and from its own page. `host` and `origin` are header
/// values.
#[must_use]
pub fn admits(listening: SocketAddr, host: Option<&str>, origin: Option<&str>) -> bool {
    let Some(host) = host else { return false };
    let own = origin.is_none_or(|origin| origin.strip_prefix("http://") == Some(host));
    own && names_this_server(listening, host)
}

fn names_this_server(listening: SocketAddr, host: &str) -> bool {
    let port = listening.port();
    let name = match host.strip_suffix(&format!(":{port}")) {
        Some(name) => name,
        None if port == 80 => host,
        None => return false,
    };
    let number = name
        .strip_prefix('[')
        .and_then(|name| name.strip_suffix(']'));
    let address = number.unwrap_or(name).parse::<IpAddr>();
    match address {
        Ok(address) => address.is_loopback() || !listening.ip().is_loopback(),
        Err(_) => name.eq_ignore_ascii_case("localhost"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_page_on_this_machine_is_admitted() {
        fn admitted(host: Option<&str>, origin: Option<&str>) -> bool {
            admits(SocketAddr::from(([127, 0, 0, 1], 8016)), host, origin)
        }
        for host in ["127.0.0.1:8016", "localhost:8016", "[::1]:8016"] {
            let own = format!("http://{host}");
            assert!(admitted(Some(host), None), "{host}");
            assert!(admitted(Some(host), Some(&own)), "{host}");
            for foreign in ["http://evil.example", "null", "https://127.0.0.1:8016", ""] {
                assert!(!admitted(Some(host), Some(foreign)), "{host} {foreign}");
            }
        }
        for host in [
            "evil.example:8016",
            "127.0.0.1",
            "127.0.0.1:80",
            "192.168.1.5:8016",
            "localhost.evil.example:8016",
            "",
        ] {
            let own = format!("http://{host}");
            assert!(!admitted(Some(host), Some(&own)), "{host}");
        }
        assert!(!admitted(None, None));
        let anywhere: SocketAddr = "0.0.0.0:8016".parse().unwrap();
        assert!(admits(anywhere, Some("192.168.1.5:8016"), None));
        assert!(!admits(anywhere, Some("evil.example:8016"), None));
    }

    #[test]
    fn a_token_is_itself_alone_and_does_not_show_in_messages() {
        let token = Token::of([0xa5; TOKEN_BYTES]);
        assert!(token.is(&"a5".repeat(16)));
        assert!(!token.is(&"a5".repeat(15)) && !token.is("") && !token.is(&"a6".repeat(16)));
        assert!(!format!("{token:?}").contains("a5"));
    }
}
