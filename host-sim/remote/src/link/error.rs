//! What can go wrong between here and a mind.

use super::words;
use amp::controller::StopReason;
use amp::wire::message::{Dimensions, Refusal, ResetCause};
use amp::wire::{PROTOCOL, SCHEMA};
use sim::error::EpisodeError;
use std::fmt;
use std::time::Duration;

/// Why a link failed. Displays as one sentence for the person in front of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkError {
    /// The way to the mind could not be opened.
    Open {
        /// What was to be opened, and why it could not.
        why: String,
    },
    /// The way to the mind broke.
    Broken {
        /// How.
        why: String,
    },
    /// Nothing was answered.
    Silent {
        /// How long it was waited for.
        waited: Duration,
    },
    /// The other end speaks another protocol, or is the mind of another robot.
    Incompatible(Dimensions),
    /// The other end sends sound frames that hold no message of this protocol.
    Foreign,
    /// The mind has started anew: what it knew is gone.
    Restarted(ResetCause),
    /// The mind refused what it was asked for.
    Refused(Refusal),
    /// What the mind reported was lost on the way.
    Lost {
        /// How many reports.
        reports: u32,
    },
    /// The mind stopped by itself.
    Stopped(StopReason),
    /// The mind learns and does not come to an end.
    Learning {
        /// How long it was waited for.
        waited: Duration,
    },
    /// The mind did not become what it was told to.
    Unlike {
        /// What differs.
        what: &'static str,
    },
}

impl LinkError {
    /// Whether opening the way and the session anew may help.
    #[must_use]
    pub fn may_pass(&self) -> bool {
        matches!(
            self,
            Self::Open { .. }
                | Self::Broken { .. }
                | Self::Silent { .. }
                | Self::Restarted(_)
                | Self::Lost { .. }
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
                "no answer within {} s: is the mind running, and this the right line and speed?",
                waited.as_secs_f32()
            ),
            Self::Incompatible(theirs) => incompatible(f, theirs),
            Self::Foreign => f.write_str(
                "the other end sends messages this program does not know: build firmware and host-sim from the same version",
            ),
            Self::Restarted(cause) => {
                write!(f, "the mind has started anew ({})", words::reset(*cause))
            }
            Self::Refused(why) => write!(f, "the mind refused: {}", words::refusal(*why)),
            Self::Lost { reports } => write!(
                f,
                "{reports} of the mind's reports were lost on the way: the link is too bad or too slow"
            ),
            Self::Stopped(reason) => write!(f, "the mind stopped: {}", sim::error::stop_reason(*reason)),
            Self::Learning { waited } => write!(
                f,
                "the mind has not learned within {} s",
                waited.as_secs_f32()
            ),
            Self::Unlike { what } => {
                write!(f, "the mind's {what} is not what was written to it")
            }
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
            "the mind speaks protocol {}, this program protocol {PROTOCOL}: update the {older}",
            theirs.protocol
        )
    } else if theirs.schema != SCHEMA {
        write!(
            f,
            "the mind's messages ({:08x}) are not this program's ({SCHEMA:08x}): build firmware and host-sim from the same version",
            theirs.schema
        )
    } else {
        write!(
            f,
            "the mind is that of a robot with {} sonars and {} neurons to a map, not of one with 16 and 16",
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
