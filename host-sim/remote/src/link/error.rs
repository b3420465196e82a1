//! Errors of a link to a controller.

use super::display;
use amp::controller::StopReason;
use amp::units::Millis;
use amp::wire::message::{Dimensions, Refusal, ResetCause};
use amp::wire::{PROTOCOL, SCHEMA};
use sim::error::EpisodeError;
use std::fmt;
use std::time::Duration;

/// Why a link failed; displays as one sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkError {
    /// The transport cannot be opened.
    Open {
        /// What cannot be opened, and why.
        why: String,
    },
    /// The transport failed.
    Broken {
        /// How.
        why: String,
    },
    /// No answer.
    Silent {
        /// How long it waited.
        waited: Duration,
    },
    /// The other end has another protocol, or the controller of another robot.
    Incompatible(Dimensions),
    /// The other end sends valid frames with unknown messages.
    UnknownMessages,
    /// The controller has restarted and lost its knowledge.
    Restarted(ResetCause),
    /// The controller refused a request.
    Refused(Refusal),
    /// Reports of the controller were lost.
    ReportsLost {
        /// How many reports.
        reports: u32,
    },
    /// The controller stopped by itself.
    Stopped(StopReason),
    /// The controller does not finish learning.
    Learning {
        /// How long it waited.
        waited: Duration,
    },
    /// The controller does not have what was written to it.
    Mismatch {
        /// What differs.
        what: &'static str,
    },
    /// The controller, which was told the same, decided otherwise than one in this process.
    DecidesOtherwise {
        /// When, by the time of the messages.
        at: Millis,
    },
}

impl LinkError {
    /// Whether reconnecting may help.
    #[must_use]
    pub fn is_transient(&self) -> bool {
        matches!(
            self,
            Self::Open { .. }
                | Self::Broken { .. }
                | Self::Silent { .. }
                | Self::Restarted(_)
                | Self::ReportsLost { .. }
        )
    }
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open { why } => f.write_str(why),
            Self::Broken { why } => write!(f, "the link broke: {why}"),
            Self::Silent { waited } => write!(
                f,
                "no answer within {} s: is the controller running, and are line and speed right?",
                waited.as_secs_f32()
            ),
            Self::Incompatible(theirs) => incompatible(f, theirs),
            Self::UnknownMessages => f.write_str(
                "the other end sends messages this program does not know: build firmware and host-sim from the same version",
            ),
            Self::Restarted(cause) => {
                write!(f, "the controller has restarted ({})", display::reset(*cause))
            }
            Self::Refused(why) => write!(f, "the controller refused: {}", display::refusal(*why)),
            Self::ReportsLost { reports } => write!(
                f,
                "{reports} of the controller's reports were lost on the way: the link is too bad or too slow"
            ),
            Self::Stopped(reason) => write!(f, "the controller stopped: {}", sim::error::stop_reason(*reason)),
            Self::Learning { waited } => write!(
                f,
                "the controller has not learned within {} s",
                waited.as_secs_f32()
            ),
            Self::Mismatch { what } => {
                write!(f, "the controller's {what} is not what was written to it")
            }
            Self::DecidesOtherwise { at } => write!(
                f,
                "at {:.1} s the controller decided otherwise than this program does: build firmware and host-sim from the same version",
                f64::from(at.as_ms()) / 1e3
            ),
        }
    }
}

fn incompatible(f: &mut fmt::Formatter<'_>, theirs: &Dimensions) -> fmt::Result {
    if theirs.protocol != PROTOCOL {
        let older = if theirs.protocol < PROTOCOL {
            "firmware"
        } else {
            "host-sim"
        };
        write!(
            f,
            "the controller speaks protocol {}, this program protocol {PROTOCOL}: update the {older}",
            theirs.protocol
        )
    } else if theirs.schema != SCHEMA {
        write!(
            f,
            "the controller's messages ({:08x}) are not this program's ({SCHEMA:08x}): build firmware and host-sim from the same version",
            theirs.schema
        )
    } else {
        write!(
            f,
            "the controller is that of a robot with {} sonars and {} neurons to a map, not of one with 16 and 16",
            theirs.sensors, theirs.neurons
        )
    }
}

impl std::error::Error for LinkError {}

impl From<LinkError> for EpisodeError {
    fn from(error: LinkError) -> Self {
        Self::Link(error.to_string())
    }
}
