//! Reasons for the early end of an episode.

use amp::controller::{CommandRefusal, StopReason};

/// Why an episode ended early.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EpisodeError {
    /// The controller refused a command.
    Refused(CommandRefusal),
    /// The controller has taken no decision for a hundred rings.
    Silent,
    /// The robot stopped by itself.
    Stopped(StopReason),
    /// The link to a remote controller failed.
    Link(String),
    /// The world cannot be as the behavior needs it.
    World(String),
    /// The log could not be written.
    Log(String),
    /// The robot has no memory of places.
    NoPlaces,
    /// Its maps do not have 16 neurons, so they cannot be read or drawn.
    OtherNeurons,
}

impl std::fmt::Display for EpisodeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Refused(why) => write!(f, "the controller refused a command: {why:?}"),
            Self::Silent => f.write_str("the controller took no decision for a hundred rings"),
            Self::Stopped(StopReason::NoEchoes) => f.write_str(
                "the robot stopped: no sonar received an echo in three rings (use --set open-space=on in open space)",
            ),
            Self::Stopped(reason) => write!(f, "the robot stopped: {}", stop_reason(*reason)),
            Self::Link(why) | Self::World(why) | Self::Log(why) => f.write_str(why),
            Self::NoPlaces => f.write_str("the controller has no memory of places"),
            Self::OtherNeurons => f.write_str("only maps of 16 neurons can be read or drawn"),
        }
    }
}

impl std::error::Error for EpisodeError {}

/// Why a robot stopped, as a clause.
#[must_use]
pub fn stop_reason(reason: StopReason) -> &'static str {
    match reason {
        StopReason::Commanded => "on command",
        StopReason::RingIncomplete => "a sonar did not report in time",
        StopReason::LinkLost => "the host was silent for too long",
        StopReason::NoEchoes => "no sonar received an echo in three rings",
        StopReason::Overdue => "its motion did not end in time: the wheels may be blocked",
        StopReason::EmergencyStop => "the emergency stop was pressed, or its wire is broken",
        StopReason::LowVoltage => "its supply voltage is too low",
        StopReason::BumperOpen => "the bumper does not close, or its wire is broken",
    }
}
