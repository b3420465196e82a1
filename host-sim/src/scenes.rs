//! Behaviours: a goal situation with the measure by which it is judged.

use crate::episode::Tally;
use crate::error::BadInput;
use amp::config::Config;
use amp::goal::Goal;
use std::str::FromStr;

/// A behaviour by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Behavior {
    /// Obstacle avoidance, the paper's experiment: nothing nearer than the clearance.
    Avoid,
}

impl Behavior {
    /// Every behaviour's name.
    pub const NAMES: [&str; 1] = ["avoid"];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Avoid => "avoid",
        }
    }

    /// Its goal situation.
    #[must_use]
    pub fn goal(self, config: &Config<16>) -> Goal<16> {
        match self {
            Self::Avoid => Goal::avoiding(config),
        }
    }

    /// How well it went, and in which unit.
    #[must_use]
    pub fn success(self, tally: &Tally) -> (f64, &'static str) {
        match self {
            Self::Avoid => {
                let free = tally.steps.saturating_sub(tally.contacts);
                (
                    f64::from(free) / f64::from(tally.steps.max(1)),
                    "share of steps without contact",
                )
            }
        }
    }
}

impl FromStr for Behavior {
    type Err = BadInput;

    fn from_str(name: &str) -> Result<Self, BadInput> {
        match name {
            "avoid" => Ok(Self::Avoid),
            _ => Err(BadInput::unknown("behavior", name, &Self::NAMES)),
        }
    }
}
