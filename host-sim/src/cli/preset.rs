//! The presets of the open choices.

use amp::config::Config;
use arena::robot::TurretMode;
use clap::ValueEnum;

/// Presets as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// The best found
    Default,
    /// The best that keeps the paper's four steps
    Probe,
    /// The most literal reading of the paper
    Touzet,
    /// As default; a robot that comes no nearer to a place plans several steps over what it
    /// traversed
    Graph,
}

impl Preset {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Probe => "probe",
            Self::Touzet => "touzet",
            Self::Graph => "graph",
        }
    }

    /// Its configuration.
    #[must_use]
    pub fn config(self) -> Config<16> {
        match self {
            Self::Default => Config::recommended(),
            Self::Probe => Config::probing(),
            Self::Touzet => Config::touzet(),
            Self::Graph => Config::traversing(),
        }
    }

    /// Motion of its turret while the base steers.
    #[must_use]
    pub fn turret(self) -> TurretMode {
        match self {
            Self::Default | Self::Probe | Self::Graph => TurretMode::Held,
            Self::Touzet => TurretMode::Follow,
        }
    }
}
