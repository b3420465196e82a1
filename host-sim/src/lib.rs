//! The command line of the simulator: see `host-sim --help`.

pub mod cli;
