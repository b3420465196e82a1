//! Why an episode ends before its time.

use amp::controller::{Refusal, StopReason};

/// Why an episode ended early.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EpisodeError {
    /// The mind refused a command.
    Refused(Refusal),
    /// The mind has not decided anything for a hundred rings.
    Silent,
    /// The robot stopped by itself.
    Stopped(StopReason),
    /// The controller is elsewhere, and the link to it failed.
    Link(String),
    /// The log could not be written on.
    Log(String),
}

impl std::fmt::Display for EpisodeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Refused(why) => write!(f, "the mind refused a command: {why:?}"),
            Self::Silent => f.write_str("the mind has decided nothing for a hundred rings"),
            Self::Stopped(StopReason::NothingHeard) => f.write_str(
                "the robot stopped: no sonar heard any echo in three rings (--set open-space=on where that is expected)",
            ),
            Self::Stopped(reason) => write!(f, "the robot stopped: {}", stop_reason(*reason)),
            Self::Link(why) | Self::Log(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for EpisodeError {}

/// Why a robot stopped.
#[must_use]
pub fn stop_reason(reason: StopReason) -> &'static str {
    match reason {
        StopReason::Commanded => "it was told to",
        StopReason::RingIncomplete => "not every sonar was heard in time",
        StopReason::LinkLost => "it heard nothing from here for too long",
        StopReason::NothingHeard => "no sonar heard any echo in three rings",
        StopReason::Overdue => "its motion did not end in time: the wheels may be blocked",
        StopReason::EmergencyStop => "the emergency stop was pressed, or its wire is broken",
        StopReason::LowVoltage => "its supply voltage is too low",
        StopReason::BumperOpen => "the bumper does not close, or its wire is broken",
    }
}
