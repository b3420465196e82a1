//! Episodes: a robot explores, learns and pursues a goal in a world.
//!
//! The body turns what happens in the [arena] into events of a [`Pilot`](pilot::Pilot) and carries out its motions. Options,
//! figures and recordings of an episode are here; how they are drawn or compared is not.

pub mod braitenberg;
pub mod coverage;
pub mod episode;
pub mod error;
pub mod goal_file;
pub mod pilot;
pub mod recording;
pub mod ring_pilot;
pub mod behavior;
pub mod settings;
pub mod statistics;
