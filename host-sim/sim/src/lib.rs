//! Episodes: a robot explores, learns and pursues a goal in a world.
//!
//! The body turns the [arena] into events of a [`Pilot`](pilot::Pilot) and carries out its motions.
//! This crate holds the options, metrics and recordings of an episode; it never draws or compares
//! them.

pub mod behavior;
pub mod braitenberg;
pub mod coverage;
pub mod demonstration;
pub mod episode;
pub mod error;
pub mod goal_file;
pub mod pilot;
pub mod recording;
pub mod ring_pilot;
pub mod robot;
pub mod senses;
pub mod settings;
pub mod sim_controller;
pub mod statistics;
pub mod turret_pilot;
