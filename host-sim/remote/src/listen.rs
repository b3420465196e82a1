//! Guards the addresses at which a server listens.

use files::error::BadInput;
use std::net::SocketAddr;

/// Refuses addresses that other machines can reach, unless `allowed`. `named` is the value of
/// `--listen`, `risk` what others could do there.
///
/// # Errors
/// A message that names the address and the flag.
pub fn check_reach(
    named: &str,
    addresses: &[SocketAddr],
    allowed: bool,
    risk: &str,
) -> Result<(), BadInput> {
    if allowed || addresses.iter().all(|address| address.ip().is_loopback()) {
        return Ok(());
    }
    Err(BadInput::new(format!(
        "--listen {named}: others could reach it: say --allow-remote if they may ({risk})"
    )))
}
