//! The bench view: a web page that shows a robot's controller at work and lets one person steer it.
//!
//! The robot's loop runs in its own thread: [`Runner`] steps a [`ViewSource`] and publishes at most
//! ten [`Snapshot`]s per second, of which a slow viewer receives only the latest. Only commands
//! flow back, so viewers never change decisions. `docs/view.md` and [`snapshot`] describe the
//! messages.

mod board;
pub mod command;
mod configure;
mod connections;
pub mod control_lock;
pub mod counts;
mod dto;
mod echo_trail;
mod goal;
pub mod guard;
mod history;
pub mod known_places;
mod nomad;
mod page;
pub mod part;
mod place_frames;
pub mod playback_clock;
mod recorded;
mod runner;
mod server;
mod sim;
pub mod snapshot;
pub mod source;
pub mod things;
mod viewer;

pub use board::WatchedBoard;
pub use guard::Token;
pub use nomad::{NomadStart, WatchedNomad};
pub use recorded::WatchedLog;
pub use runner::Runner;
pub use server::{BoundServer, ServeOptions, serve};
pub use sim::{PresetChoice, Simulator, SimulatorStart};
pub use snapshot::Snapshot;
pub use source::{Capabilities, CommandRefused, StepOutcome, ViewSource};
