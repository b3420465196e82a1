//! Links to controllers: on a chip at a serial port, behind a TCP socket, or in an emulator.
//!
//! This is the host's end of the protocol of [`amp::wire`]. A *request* is a frame that the
//! controller confirms. The host repeats it, with the same number, until it is confirmed and all
//! reports have come, or the retry policy ends. A controller does not execute a repeated request
//! again. Reports are numbered, so the host notices lost ones.

mod address;
mod any_controller;
mod deadline;
pub mod display;
mod error;
mod fingerprint;
mod image;
mod knowledge;
mod lossy;
mod machine;
mod node_server;
mod opening;
mod qemu;
mod queries;
mod remote_controller;
mod session;
mod transport;
mod twin;

pub use address::{Address, BAUD};
pub use any_controller::{AnyController, CachedRemote, ControllerPlace};
pub use deadline::Deadline;
pub use display::{build, describe, oscillator, refusal, reset};
pub use error::LinkError;
pub use fingerprint::Fingerprint;
pub use image::build as build_image;
pub use knowledge::Knowledge;
pub use lossy::{Flood, Lossy, Silent};
pub use machine::Machine;
pub use node_server::{InProcessNode, NodeServer};
pub use opening::{fresh_number, next_number};
pub use qemu::Qemu;
pub use remote_controller::RemoteController;
pub use session::{Response, RetryPolicy, Session};
pub use transport::{Serial, Tcp, Transport};

use files::error::BadInput;
use sim::robot::AnyRobot;
use std::path::PathBuf;
use std::str::FromStr;

/// Options of the emulator.
#[derive(Debug, Clone, Default)]
pub struct Emulation {
    /// Image of the firmware; without one it is built from the project's sources.
    pub firmware: Option<PathBuf>,
    /// What it is built for.
    pub program: Program,
    /// Copy the emulator's messages to standard error.
    pub verbose: bool,
}

/// What the firmware is built for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Program {
    /// A ring on a held turret.
    #[default]
    Ring,
    /// Sensors anywhere on the body.
    AnyBody,
    /// The same, with a memory of places.
    Places,
}

impl FromStr for Program {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "ring" => Ok(Self::Ring),
            "any-body" => Ok(Self::AnyBody),
            "places" => Ok(Self::Places),
            _ => Err(BadInput::unknown(
                "program",
                text,
                &["ring", "any-body", "places"],
            )),
        }
    }
}

impl Program {
    /// The program for a robot; `None` = the Nomad with its own ring.
    #[must_use]
    pub fn of(robot: Option<&AnyRobot>) -> Self {
        match robot {
            None => Self::Ring,
            Some(robot) if robot.is_led() => Self::Places,
            Some(_) => Self::AnyBody,
        }
    }

    /// The machine that runs it.
    fn machine(self) -> &'static Machine {
        match self {
            Self::Ring => &Machine::OLIMEX_H405,
            Self::AnyBody => &Machine::OLIMEX_H405_ANY_BODY,
            Self::Places => &Machine::OLIMEX_H405_PLACES,
        }
    }
}

/// Opens a transport to the controller at `address`.
///
/// # Errors
/// [`LinkError::Open`] without a connection, an emulator or an image.
pub fn connect(address: &Address, emulation: &Emulation) -> Result<Box<dyn Transport>, LinkError> {
    Ok(match address {
        Address::Serial { path, baud } => Box::new(Serial::open(path, *baud)?),
        Address::Tcp(host) => Box::new(Tcp::open(host)?),
        Address::Qemu => {
            let machine = emulation.program.machine();
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
