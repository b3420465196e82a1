//! Address of a controller, as it is written on the command line.

use files::error::BadInput;
use std::fmt;
use std::str::FromStr;

/// Default speed of a serial line, baud.
pub const BAUD: u32 = 115_200;

/// Address of a controller.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    /// At a serial port.
    Serial {
        /// The port's path or name.
        path: String,
        /// Its speed.
        baud: u32,
    },
    /// A TCP socket, as `HOST:PORT`.
    Tcp(String),
    /// An emulated chip, started on demand.
    Qemu,
}

impl Address {
    /// The accepted forms.
    pub const FORMS: &'static str = "serial:PORT[@BAUD], tcp:HOST:PORT or qemu";
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial { path, baud } if *baud == BAUD => write!(f, "serial:{path}"),
            Self::Serial { path, baud } => write!(f, "serial:{path}@{baud}"),
            Self::Tcp(host) => write!(f, "tcp:{host}"),
            Self::Qemu => f.write_str("qemu"),
        }
    }
}

impl FromStr for Address {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text.split_once(':') {
            None if text == "qemu" => Ok(Self::Qemu),
            Some(("serial", port)) => serial(port),
            Some(("tcp", host)) => tcp(host),
            _ => Err(BadInput::new(format!(
                "\"{text}\" is no address of a controller: use {}",
                Self::FORMS
            ))),
        }
    }
}

fn serial(port: &str) -> Result<Address, BadInput> {
    let (path, baud) = match port.rsplit_once('@') {
        None => (port, BAUD),
        Some((path, baud)) => {
            let number = baud.parse().ok().filter(|&baud| baud > 0);
            let bad = || BadInput::new(format!("\"{baud}\" in serial:{port} is no speed in baud"));
            (path, number.ok_or_else(bad)?)
        }
    };
    if path.is_empty() {
        return Err(BadInput::new(
            "serial: needs a port, as in serial:/dev/ttyUSB0",
        ));
    }
    Ok(Address::Serial {
        path: path.to_owned(),
        baud,
    })
}

fn tcp(host: &str) -> Result<Address, BadInput> {
    let sound = host
        .rsplit_once(':')
        .is_some_and(|(name, port)| !name.is_empty() && port.parse::<u16>().is_ok());
    if sound {
        Ok(Address::Tcp(host.to_owned()))
    } else {
        Err(BadInput::new(format!(
            "tcp:{host} needs a host and a port, as in tcp:localhost:4000"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_as_they_are_written() {
        for text in [
            "qemu",
            "tcp:localhost:4000",
            "tcp:[::1]:4000",
            "serial:/dev/ttyUSB0",
            "serial:COM3@9600",
        ] {
            assert_eq!(text.parse::<Address>().unwrap().to_string(), text);
        }
        let spelled_out = "serial:/dev/ttyS1@115200".parse::<Address>().unwrap();
        assert_eq!(spelled_out.to_string(), "serial:/dev/ttyS1");
    }

    #[test]
    fn what_is_no_address_is_named() {
        for (text, part) in [
            ("quemu", "\"quemu\" is no address"),
            ("tcp:4000", "tcp:4000 needs a host and a port"),
            ("tcp:host:99999", "needs a host and a port"),
            ("serial:", "needs a port"),
            ("serial:/dev/ttyS0@fast", "\"fast\""),
            ("serial:/dev/ttyS0@0", "\"0\""),
        ] {
            let error = text.parse::<Address>().unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }
}
