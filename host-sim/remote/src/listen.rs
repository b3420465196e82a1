//! Addresses to listen at.

use files::error::BadInput;
use std::net::SocketAddr;

/// Refuses addresses that other machines can reach, unless `allowed`. `named` is what the user gave to `--listen`, `risk`
/// what others could do there.
///
/// # Errors
/// A sentence that names the address and the flag.
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
