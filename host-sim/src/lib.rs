//! Simulator of a Nomad 200 driven by the `amp` crate.
pub mod baselines;
pub mod cli;
pub mod coverage;
pub mod episode;
pub mod error;
pub mod experiments;
pub mod link;
pub mod noise;
pub mod pilot;
pub mod plot;
pub mod recording;
pub mod robot;
pub mod scenes;
pub mod settings;
pub mod som;
pub mod sonar;
pub mod world;
