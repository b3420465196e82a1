//! The way to a mind that runs elsewhere: on a chip at a serial port, behind a TCP socket, or in an emulator.
//!
//! The frames and messages are those of [`amp::wire`]; this module has the host's end of them.
//!
//! | | |
//! |---|---|
//! | [`Address`] | where the mind is, as typed: `serial:/dev/ttyUSB0@115200`, `tcp:HOST:PORT`, `qemu` |
//! | [`Transport`] | carries bytes: a serial port, a socket, an emulated chip, a mind in this process |
//! | [`Session`] | hello, requests with confirmation and repetition, parts, parameters, counters |
//! | [`RemoteMind`] | a [`Pilot`](sim::pilot::Pilot): any episode, driven by the mind at the other end |
//! | [`AnyMind`] | a mind here or there |
//! | [`Knowledge`] | configuration, maps and memory as one file |
//!
//! A *request* is a frame the mind confirms. Whatever the mind says is numbered, so that a report that was lost is noticed.
//! A request is repeated, with the same number, until it is confirmed and nothing is missing, or patience ends: the mind
//! says again what it said, without doing it again.

mod address;
mod any_mind;
mod deadline;
mod error;
mod image;
mod knowledge;
mod lossy;
mod machine;
mod opening;
mod parts;
mod qemu;
mod remote;
mod served;
mod session;
mod transport;
pub mod words;

pub use address::{Address, BAUD};
pub use any_mind::{AnyMind, Elsewhere, MindPlace};
pub use deadline::Deadline;
pub use error::LinkError;
pub use image::build as build_image;
pub use knowledge::Knowledge;
pub use lossy::{Flood, Lossy, Silent};
pub use machine::Machine;
pub use opening::{fresh_number, next_number};
pub use qemu::Qemu;
pub use remote::{Fingerprint, RemoteMind};
pub use served::{Local, Served};
pub use session::{Answer, Patience, Session};
pub use transport::{Serial, Tcp, Transport};
pub use words::{build, describe, oscillator, refusal, reset};

use std::path::PathBuf;

/// How the emulator is to be started.
#[derive(Debug, Clone, Default)]
pub struct Emulation {
    /// A ready image of the firmware; without one it is built from the project's sources.
    pub firmware: Option<PathBuf>,
    /// Pass the emulator's messages on to standard error.
    pub verbose: bool,
}

/// Opens the way to the mind at `address`.
///
/// # Errors
/// [`LinkError::Open`] when there is no way, no emulator, or no image for it.
pub fn connect(address: &Address, emulation: &Emulation) -> Result<Box<dyn Transport>, LinkError> {
    Ok(match address {
        Address::Serial { path, baud } => Box::new(Serial::open(path, *baud)?),
        Address::Tcp(host) => Box::new(Tcp::open(host)?),
        Address::Qemu => {
            let machine = &Machine::OLIMEX_H405;
            let image = match &emulation.firmware {
                Some(image) => image.clone(),
                None => image::build(machine)?,
            };
            Box::new(Qemu::start(machine, &image, emulation.verbose)?)
        }
    })
}

#[cfg(test)]
mod tests;
