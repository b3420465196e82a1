//! The Nomad 200's own protocol: a simulated robot that speaks it, a host that drives a robot, and
//! a bridge between a robot and the controller.
//!
//! The facts come from the manufacturer's client library (Nomadic Technologies, `Nclient.h` and
//! `Ndirect.c` 2.6.13, copy in CARMEN). Where the library leaves something open, the comments
//! and `docs/nomad.md` state the choice.

pub mod bridge;
mod bytes;
mod command;
mod dead_reckoning;
mod firing;
mod host;
mod kind;
mod line;
mod mask;
pub mod nserver;
mod packet;
#[cfg(unix)]
mod pty;
mod server;
mod simulated;
mod state;
pub mod units;

pub use bytes::LengthError;
pub use command::{AxisMode, CommandError, NomadCommand, ReadingGroup};
pub use host::{ANSWER_TIMEOUT, Host, RobotError};
pub use kind::Kind;
pub use line::{Protocol, RobotLine};
pub use mask::{
    Greeting, LaserSetup, StateMask, WITH_BUMPER, WITH_COMPASS, WITH_INFRARED, WITH_LASER,
    WITH_SONAR,
};
pub use packet::{Decoder, MAX_FROM_ROBOT, MAX_TO_ROBOT, Packet};
#[cfg(unix)]
pub use pty::PseudoTerminal;
pub use server::{Server, SimClock};
pub use simulated::{GroundTruth, SimulatedNomad};
pub use state::{MAX_LASER_POINTS, NomadReadings, PosData};
