//! The Nomad 200's own protocol: a robot that speaks it, simulated, and a host that drives one.
//!
//! Facts from the manufacturer's client library (Nomadic Technologies, `Nclient.h` and `Ndirect.c` 2.6.13 as kept in CARMEN);
//! where the library leaves something open, what this module does about it is written where it does it, and in
//! `docs/nomad.md`.
//!
//! | | |
//! |---|---|
//! | [`Packet`], [`Decoder`] | bytes on a serial line (8N1) or a TCP connection |
//! | [`Command`] | what a host asks |
//! | [`Mask`], [`Greeting`] | what the robot is to say |
//! | [`State`] | what it says |
//! | [`Simulated`] | a robot in a world, by the millisecond |
//! | [`Line`] | that robot behind a line, also by the protocol of [`nserver`] |
//! | [`Host`] | the other end: asks a robot |
//! | [`bridge`] | a mind drives a robot |
//! | [`Server`], [`Pty`] | that line in real time: a TCP socket, a serial port |

pub mod bridge;
mod bytes;
mod command;
mod firing;
mod host;
mod kind;
mod line;
mod mask;
pub mod nserver;
mod packet;
#[cfg(unix)]
mod pty;
mod reckoning;
mod server;
mod simulated;
mod state;
pub mod units;

pub use bytes::WrongLength;
pub use command::{AxisMode, Command, Group, NoCommand};
pub use host::{Host, PATIENCE, RobotError};
pub use kind::Kind;
pub use line::{Line, Protocol};
pub use mask::{
    Greeting, LaserSetup, Mask, WITH_BUMPER, WITH_COMPASS, WITH_INFRARED, WITH_LASER, WITH_SONAR,
};
pub use packet::{Decoder, MAX_FROM_ROBOT, MAX_TO_ROBOT, Packet};
#[cfg(unix)]
pub use pty::Pty;
pub use server::{Pace, Server};
pub use simulated::{Ledger, Simulated};
pub use state::{MAX_LASER_POINTS, PosData, State};
