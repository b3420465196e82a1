//! From the device to the host: motions, decisions, answers and notices.

use super::{Counters, Dimensions, FlashError, MAX_PIECE, Oscillator, Part, ResetCause};
use crate::controller::{CommandRefusal, Decision, Mode, Motion, PartError, StopReason};
use crate::faults::{SensorFault, SensorVerdict};
use crate::goal::{Goal, Name};
use crate::parameters::{Parameter, ParameterError, Spec};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// The device's hello.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MindHello {
    /// What both ends have to agree on.
    pub dimensions: Dimensions,
    /// Samples the memory holds.
    pub samples: u16,
    /// Build of the program.
    pub build: [u8; 8],
    /// Why it started last.
    pub reset: ResetCause,
    /// What clocks the processor.
    pub oscillator: Oscillator,
    /// CRC-32 of the configuration.
    pub config_crc: u32,
    /// CRC-32 of the three maps, and of the memory.
    pub maps_crc: u32,
    /// As above.
    pub memory_crc: u32,
}

/// A message of the device with its time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report<const SENSORS: usize> {
    /// Time by the session's clock.
    pub device_ms: u32,
    /// The message.
    pub said: FromMind<SENSORS>,
}

/// From the device to the host.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum FromMind<const SENSORS: usize> {
    /// Who this is. Also sent unasked after each start, in session 0.
    Hello(MindHello),
    /// What the base is to do.
    Motion(MotionOrder),
    /// How a decision came about.
    Decision(Decision<SENSORS>),
    /// The mode changed.
    Mode(ModeReport),
    /// The counters.
    Counters(Counters),
    /// Something was not done.
    Refusal {
        /// Number of the frame that asked for it.
        seq: u16,
        /// Why.
        why: Refusal,
    },
    /// A piece of a part.
    Piece {
        /// The part.
        part: Part,
        /// Where the piece begins.
        offset: u16,
        /// Bytes of the whole part.
        total: u16,
        /// The piece; empty beyond the end.
        bytes: Vec<u8, MAX_PIECE>,
    },
    /// A parameter's value and what it may be.
    Parameter {
        /// Which.
        parameter: Parameter,
        /// Its value.
        value: i32,
        /// What it may be.
        spec: Spec,
    },
    /// Something for a person to read.
    Log(Notice),
    /// A frame has been handled; all its results were sent before.
    Done {
        /// Its number.
        seq: u16,
    },
    /// The device neither receives nor sends for at most this long.
    Busy {
        /// How long.
        ms: u32,
    },
    /// A goal that is kept.
    Goal {
        /// Its name; none for the present goal.
        name: Name,
        /// The goal.
        goal: Goal<SENSORS>,
    },
}

/// A motion with its time to live: the base stops when it ends, and executes nothing older.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MotionOrder {
    /// Number of the motion.
    pub id: u16,
    /// Counts the motion's shortenings. The same number and revision again only renew the time to
    /// live.
    pub revision: u8,
    /// Where to, from where the base stood at its latest report, in the ring's frame there; (0, 0)
    /// stops.
    pub dx_mm: i16,
    /// Its y component.
    pub dy_mm: i16,
    /// At most this fast.
    pub speed_mm_s: u16,
    /// Time to live.
    pub ttl_ms: u16,
}

impl MotionOrder {
    /// The motion as the controller asks for it.
    #[must_use]
    pub const fn motion(self) -> Motion {
        Motion {
            id: self.id,
            displacement: crate::units::Displacement {
                dx_mm: self.dx_mm,
                dy_mm: self.dy_mm,
            },
            speed_mm_s: self.speed_mm_s,
        }
    }
}

/// What the robot is doing, without the goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ModeReport {
    /// Nothing.
    Idle,
    /// Random moves, so many left.
    Explore {
        /// Moves left.
        left: u16,
    },
    /// Learning.
    Learn,
    /// Towards the goal.
    Seek,
    /// Standing, for a reason.
    Stopped(StopReason),
}

impl<const SENSORS: usize> From<&Mode<SENSORS>> for ModeReport {
    fn from(mode: &Mode<SENSORS>) -> Self {
        match mode {
            Mode::Idle => Self::Idle,
            Mode::Explore { left } => Self::Explore { left: *left },
            Mode::Learn { .. } => Self::Learn,
            Mode::Seek { .. } => Self::Seek,
            Mode::Stopped(reason) => Self::Stopped(*reason),
        }
    }
}

/// Something for a person to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Notice {
    /// The host fell silent; the robot stood still from then on.
    LinkLost,
    /// Frames were lost because the link was too slow for them.
    FramesDropped {
        /// How many so far.
        count: u32,
    },
    /// A transducer is faulty and disabled.
    Disbelieved {
        /// Transducer.
        sensor: u8,
        /// What is wrong with it.
        fault: SensorFault,
    },
    /// A transducer is sound again and enabled.
    Believed {
        /// Transducer.
        sensor: u8,
    },
    /// An echo was too old to be used. Sent for the first one since the last decision.
    StaleEcho {
        /// Age of the echo, milliseconds.
        age_ms: u32,
    },
}

impl From<SensorVerdict> for Notice {
    fn from(SensorVerdict { sensor, fault }: SensorVerdict) -> Self {
        fault.map_or(Self::Believed { sensor }, |fault| Self::Disbelieved {
            sensor,
            fault,
        })
    }
}

/// Why something was not done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The other end speaks another protocol, other messages, or of another robot: this is ours.
    Incompatible(Dimensions),
    /// No session has been opened since the device started.
    NoSession,
    /// The command was past its time to live.
    Expired {
        /// Its age.
        age_ms: u32,
    },
    /// The controller refused.
    Command(CommandRefusal),
    /// The parameter was not set.
    Parameter(ParameterError),
    /// The piece was not taken.
    Piece(PartError),
    /// The bytes are no configuration.
    Config,
    /// Not while the robot may move.
    Moving,
    /// This program has no ring of its own.
    NoRing,
    /// Nothing has been heard of some transducers yet.
    NothingPerceived,
    /// What outlives a loss of power is as it was.
    Flash(FlashError),
    /// No goal is kept under this name.
    NoSuchGoal,
    /// The goal was not kept: a name that is none, or too many goals.
    GoalName,
}
