//! Plan, report and errors of a bridge.

use crate::RobotError;
use amp::config::Config;
use serde::Serialize;
use sim::behavior::Behavior;
use sim::error::EpisodeError;
use std::fmt;

/// Plan of a drive.
#[derive(Debug, Clone)]
pub struct BridgePlan {
    /// The controller's configuration.
    pub config: Config<16>,
    /// Random moves.
    pub explore_moves: u16,
    /// Decisions towards the goal.
    pub steps: u32,
    /// Behavior after exploring.
    pub behavior: Behavior,
    /// Seed of the random moves.
    pub seed: u64,
    /// Sonars per poll; fewer are faster over a serial line.
    pub sonars_at_once: u32,
}

/// Why a drive ended early. The base stands if it could still be reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BridgeError {
    /// An error of the robot.
    Robot(RobotError),
    /// An error of the controller.
    Controller(EpisodeError),
    /// Interrupted by the user.
    Interrupted,
}

impl fmt::Display for BridgeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robot(error) => error.fmt(f),
            Self::Controller(failure) => failure.fmt(f),
            Self::Interrupted => f.write_str("interrupted; the base was stopped"),
        }
    }
}

impl From<RobotError> for BridgeError {
    fn from(error: RobotError) -> Self {
        Self::Robot(error)
    }
}

/// Report of a drive, also of an incomplete one.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct BridgeReport {
    /// Random moves made.
    pub explore_moves: u32,
    /// Random moves in which a bumper was pressed.
    pub explore_contacts: u32,
    /// Steps towards the goal.
    pub steps: u32,
    /// Steps in which a bumper was pressed.
    pub contacts: u32,
    /// Path length by the robot's odometry, m.
    pub distance_m: f64,
    /// Steps in which the goal held.
    pub goal_steps: u32,
    /// Steps whose motion the shield shortened or stopped.
    pub shield_stops: u32,
    /// Motions that were cut off because the controller did not confirm a report in time.
    pub expired: u32,
    /// Time by the robot's clock, s.
    pub time_s: f64,
}
