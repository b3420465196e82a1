//! What runs seldom, compiled for size: reading and writing what a device knows and is told, for
//! images and for a host.
//!
//! Generic code is compiled in the crate that uses it first, at that crate's level of optimization.
//! The boards are at level "s", for what runs with each event, and this crate is at level "z". What
//! is called here is compiled here, also for the boards. They never call this function itself, and
//! the linker drops it.

use amp::config::{Config, MAX_CONFIG};
use amp::goal::Goal;
use amp::places::Places;
use amp::turret::BodySpec;

/// Reads all from `bytes` and writes what was read; returns how many bytes were written.
#[must_use]
pub fn read_and_write(
    places: &mut Places<16, 256>,
    bytes: &[u8],
    buffer: &mut [u8; MAX_CONFIG],
) -> usize {
    let config = Config::<16>::from_bytes(bytes);
    let config = config.map_or(0, |config| config.to_bytes(buffer).len());
    let body = BodySpec::<16>::from_bytes(bytes);
    let body = body.map_or(0, |body| body.to_bytes(buffer).len());
    let goal = postcard::from_bytes::<Goal<16>>(bytes);
    let goal = goal.and_then(|goal| postcard::to_slice(&goal, buffer).map(|bytes| bytes.len()));
    let _ = places.write_saved(0, bytes);
    let saved = places.read_saved(0, buffer);
    let lengths = [config, body, goal.unwrap_or(0), saved];
    lengths.into_iter().fold(0, usize::saturating_add)
}
