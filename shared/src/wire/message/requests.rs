//! From the host to the device: requests, echoes, odometry and commands.

use super::{Clock, Dimensions, MAX_ECHOES, MAX_PIECE, Part, Source};
use crate::controller::Progress;
use crate::goal::{Goal, Name};
use crate::memory::SituationBytes;
use crate::parameters::Parameter;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// From the host to the device.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToMind<const SENSORS: usize> {
    /// Opens a session: the one in the frame's header. Answered with the device's hello, or
    /// refused.
    Hello(HostHello),
    /// The host is there. Not answered.
    Alive {
        /// Host's time.
        at_ms: u32,
    },
    /// Echoes in the order they were heard.
    Scan {
        /// Host's time of the last echo.
        at_ms: u32,
        /// The echoes.
        echoes: Vec<Heard, MAX_ECHOES>,
    },
    /// What the base has done since its last report.
    Odometry {
        /// Host's time.
        at_ms: u32,
        /// Motion it is carrying out or has carried out last.
        motion: u16,
        /// Displacement since the last report, in the ring's frame at that report.
        dx_mm: i16,
        /// Its y component.
        dy_mm: i16,
        /// How far the ring has turned since then, 65 536 = a turn, counter-clockwise.
        turned: u16,
        /// What became of the motion.
        progress: Progress,
    },
    /// Something to do. Not done when older than its time to live; [`Order::Stop`] is always done.
    Command {
        /// Host's time.
        at_ms: u32,
        /// Time to live.
        ttl_ms: u16,
        /// What to do.
        order: Order<SENSORS>,
    },
    /// Asks for a piece of a part; answered with [`FromMind::Piece`](super::FromMind::Piece).
    Read {
        /// The part.
        part: Part,
        /// First byte wanted.
        offset: u16,
    },
    /// Replaces a piece of a part.
    Write {
        /// The part.
        part: Part,
        /// Where the piece begins.
        offset: u16,
        /// The piece.
        bytes: Vec<u8, MAX_PIECE>,
        /// It is the last one: a configuration takes effect.
        last: bool,
    },
    /// Asks for the counters.
    Counters,
    /// Reads a parameter or, with a value, sets it.
    Parameter {
        /// Which.
        parameter: Parameter,
        /// The new value, in its unit.
        value: Option<i32>,
    },
    /// Where echoes come from in this session. Refused while the robot moves.
    Source(Source),
    /// Asks for the mode.
    Mode,
    /// Something to do with what outlives a loss of power. Refused while the robot may move; *Done*
    /// comes when it is over.
    Flash(Flash),
    /// Keeps the present goal under a name, in place of the one that had it.
    Keep {
        /// The name.
        name: Name,
    },
    /// Forgets the goal kept under a name.
    Drop {
        /// The name.
        name: Name,
    },
    /// Asks for the present goal and those kept; answered with a
    /// [`FromMind::Goal`](super::FromMind::Goal) for each.
    Goals,
}

/// What to do with what outlives a loss of power.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Flash {
    /// Save configuration, maps, memory and goals.
    Save,
    /// Replace them by those saved last, as a start does.
    Recall,
    /// Erase all that was saved.
    Erase,
}

/// Why that was not done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FlashError {
    /// This device keeps nothing.
    Absent,
    /// Nothing was saved.
    Empty,
    /// What was saved last was saved by another version of the program.
    Unreadable,
    /// The device could not erase, write or read; whatever was saved before still is.
    Failed,
}

impl core::fmt::Display for FlashError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Absent => "it has nothing to save to",
            Self::Empty => "nothing was saved",
            Self::Unreadable => "another version of its program saved last",
            Self::Failed => "its flash could not be erased, written or read",
        })
    }
}

impl core::error::Error for FlashError {}

/// Something to do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Order<const SENSORS: usize> {
    /// The goal from now on.
    Goal(GoalBy<SENSORS>),
    /// Random moves.
    Explore {
        /// How many.
        moves: u16,
        /// Seed of the controller's generator.
        seed: u64,
    },
    /// Make the maps.
    Learn,
    /// Pursue the goal.
    Seek,
    /// Stand still.
    Stop,
    /// Go on with what a stop interrupted.
    Resume,
    /// Forget samples, maps and goals. What was saved stays saved.
    Forget,
}

/// Ways to say a goal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum GoalBy<const SENSORS: usize> {
    /// Obstacle avoidance: nothing within the configured clearance.
    Avoid,
    /// What is perceived now, from the latest echoes.
    Perceived,
    /// A situation: 0 … 254 from the far to the near limit, 255 = any value will do.
    Situation(#[serde(with = "crate::arrays")] SituationBytes<SENSORS>),
    /// Interval and weight for each transducer.
    Components(Goal<SENSORS>),
    /// The goal kept under this name.
    Kept(Name),
}

/// An echo and when it was heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heard {
    /// Transducer.
    pub sensor: u8,
    /// Range; `None` = nothing answered.
    pub range_mm: Option<u16>,
    /// How long before the message's time it was heard.
    pub age_ms: u16,
}

/// The host's hello.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct HostHello {
    /// What both ends have to agree on.
    pub dimensions: Dimensions,
    /// Whose time counts in this session.
    pub clock: Clock,
    /// Rings without any echo are expected in this session: they do not stop the robot. See
    /// [`State::expects_open_space`](crate::controller::State::expects_open_space).
    pub open_space: bool,
}
