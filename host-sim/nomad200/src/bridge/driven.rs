//! What is to be done with a robot, what came of it, and why it ended early.

use crate::RobotError;
use amp::config::Config;
use serde::Serialize;
use sim::behavior::Behavior;
use sim::error::EpisodeError;
use std::fmt;

/// What is to be done with the robot.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The mind's open choices.
    pub config: Config<16>,
    /// Random moves.
    pub explore_moves: u16,
    /// Decisions towards the goal.
    pub steps: u32,
    /// What to do after exploring.
    pub behavior: Behavior,
    /// Seed of the random moves.
    pub seed: u64,
    /// Sonars asked for at once; fewer are faster over a serial line.
    pub sonars_at_once: u32,
}

/// Why the drive ended early. The base stands, if it could still be told to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Trouble {
    /// The robot.
    Robot(RobotError),
    /// The mind.
    Mind(EpisodeError),
    /// Somebody wanted it to end.
    Interrupted,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Robot(error) => error.fmt(f),
            Self::Mind(failure) => failure.fmt(f),
            Self::Interrupted => f.write_str("interrupted; the base was told to stand"),
        }
    }
}

impl From<RobotError> for Trouble {
    fn from(error: RobotError) -> Self {
        Self::Robot(error)
    }
}

/// What came of the drive, as far as it went.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct Driven {
    /// Random moves made.
    pub explore_moves: u32,
    /// Random moves in which a bumper was pressed.
    pub explore_contacts: u32,
    /// Steps towards the goal.
    pub steps: u32,
    /// Steps in which a bumper was pressed.
    pub contacts: u32,
    /// Way rolled in all by the robot's odometry, m.
    pub distance_m: f64,
    /// Steps in which the goal held.
    pub goal_steps: u32,
    /// Steps the shield shortened or stopped.
    pub shield_stops: u32,
    /// Motions cut off because the mind had not confirmed in time.
    pub expired: u32,
    /// Time by the robot's clock, s.
    pub time_s: f64,
}
