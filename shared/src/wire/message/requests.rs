//! From the host to the device: requests, echoes, odometry and commands.

use super::{Clock, Dimensions, MAX_CHUNK, MAX_ECHOES, Source, TransferPart};
use crate::controller::Progress;
use crate::goal::{Goal, Name};
use crate::memory::SituationBytes;
use crate::parameters::Parameter;
use crate::places::Aim;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// From the host to the device.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum HostMessage<const SENSORS: usize> {
    /// Opens a session: the one in the frame's header. Answered with the device's hello, or
    /// refused.
    Hello(HostHello),
    /// The host is there. Not answered.
    Alive {
        /// Host's time.
        at_ms: u32,
    },
    /// Echoes in the order they were received.
    Scan {
        /// Host's time of the last echo.
        at_ms: u32,
        /// The echoes.
        echoes: Vec<TimedEcho, MAX_ECHOES>,
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
    /// A command to the robot. Refused when older than its time to live, except
    /// [`RobotCommand::Stop`].
    Command {
        /// Host's time.
        at_ms: u32,
        /// Time to live.
        ttl_ms: u16,
        /// The command.
        command: RobotCommand<SENSORS>,
    },
    /// Asks for a chunk of a part; answered with
    /// [`DeviceMessage::Chunk`](super::DeviceMessage::Chunk).
    Read {
        /// The part.
        part: TransferPart,
        /// First byte wanted.
        offset: u16,
    },
    /// Replaces a chunk of a part.
    Write {
        /// The part.
        part: TransferPart,
        /// Where the chunk begins.
        offset: u16,
        /// The chunk.
        bytes: Vec<u8, MAX_CHUNK>,
        /// It is the last one: a configuration or a body takes effect.
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
    /// Saves to, loads from or erases the flash. Refused while the robot may move; *Done* comes
    /// when it is over.
    Flash(FlashOperation),
    /// Saves the present goal under a name, in place of the one that had it.
    SaveGoal {
        /// The name.
        name: Name,
    },
    /// Deletes the goal saved under a name.
    DeleteGoal {
        /// The name.
        name: Name,
    },
    /// Asks for the present goal and those saved; answered with a
    /// [`DeviceMessage::Goal`](super::DeviceMessage::Goal) for each.
    ListGoals,
}

/// What to do with the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FlashOperation {
    /// Save configuration, body, maps, memory, places and goals.
    Save,
    /// Load those saved last, as a start does.
    Load,
    /// Erase all that was saved.
    Erase,
}

/// Why a [`FlashOperation`] failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FlashError {
    /// This device has no flash to save to.
    NoFlash,
    /// Nothing was saved.
    Empty,
    /// What was saved last was saved by another version of the program.
    OtherVersion,
    /// The device could not erase, write or read; whatever was saved before still is.
    Failed,
}

impl core::fmt::Display for FlashError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NoFlash => "it has nothing to save to",
            Self::Empty => "nothing was saved",
            Self::OtherVersion => "another version of its program saved last",
            Self::Failed => "its flash could not be erased, written or read",
        })
    }
}

impl core::error::Error for FlashError {}

/// A command to the robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum RobotCommand<const SENSORS: usize> {
    /// The goal from now on.
    Goal(GoalSpec<SENSORS>),
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
    /// Forget samples, maps, places and goals. What was saved stays saved.
    Forget,
    /// Find where the body's sensors look.
    Calibrate {
        /// Number of random moves for that.
        moves: u16,
        /// Their seed.
        seed: u64,
        /// Whether to find as well what the base makes of its commands.
        actuators: bool,
    },
    /// Where places lead the robot from now on while it pursues a goal; `None`: nowhere.
    Lead(Option<Aim>),
    /// The robot was carried elsewhere, where it stands now.
    SetDown,
}

/// Ways to specify a goal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum GoalSpec<const SENSORS: usize> {
    /// Obstacle avoidance: nothing within the configured clearance.
    Avoid,
    /// What is perceived now, from the latest echoes.
    Perceived,
    /// A situation: 0 … 254 from the far to the near limit, 255 = any value will do.
    Situation(#[serde(with = "crate::arrays")] SituationBytes<SENSORS>),
    /// Interval and weight for each transducer.
    Components(Goal<SENSORS>),
    /// The goal saved under this name.
    Saved(Name),
}

/// An echo with its age.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TimedEcho {
    /// Transducer.
    pub sensor: u8,
    /// Range; `None` = nothing answered.
    pub range_mm: Option<u16>,
    /// How long before the message's time it was received.
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
