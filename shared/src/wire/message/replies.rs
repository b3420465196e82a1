//! From the device to the host: motions, decisions, answers and notices.

use super::{Counters, Dimensions, FlashError, MAX_CHUNK, Oscillator, ResetCause, TransferPart};
use crate::controller::{CommandRefusal, Decision, Mode, Motion, StopReason, TransferError};
use crate::faults::{SensorFault, SensorVerdict};
use crate::goal::{Goal, Name};
use crate::parameters::{Parameter, ParameterError, ParameterSpec};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// The device's hello.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct DeviceHello {
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
    pub message: DeviceMessage<SENSORS>,
}

/// From the device to the host.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum DeviceMessage<const SENSORS: usize> {
    /// Who this is. Also sent unasked after each start, in session 0.
    Hello(DeviceHello),
    /// What the base has to do.
    Motion(MotionCommand),
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
        /// The reason.
        reason: Refusal,
    },
    /// A chunk of a part.
    Chunk {
        /// The part.
        part: TransferPart,
        /// Where the chunk begins.
        offset: u16,
        /// Bytes of the whole part.
        total: u16,
        /// The chunk; empty beyond the end.
        bytes: Vec<u8, MAX_CHUNK>,
    },
    /// A parameter's value and what it may be.
    Parameter {
        /// Which.
        parameter: Parameter,
        /// Its value.
        value: i32,
        /// What it may be.
        spec: ParameterSpec,
    },
    /// An event for the host's log.
    Log(LogEvent),
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
    /// A goal.
    Goal {
        /// Its name; none for the present goal.
        name: Name,
        /// The goal.
        goal: Goal<SENSORS>,
    },
}

/// A motion with its time to live: the base stops when it ends, and executes nothing older.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct MotionCommand {
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

impl MotionCommand {
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
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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
    /// Random moves that teach where the sensors look, so many left.
    Babble {
        /// Moves left.
        left: u16,
    },
    /// Finding where they look.
    Calibrate,
}

impl<const SENSORS: usize> From<&Mode<SENSORS>> for ModeReport {
    fn from(mode: &Mode<SENSORS>) -> Self {
        match mode {
            Mode::Idle => Self::Idle,
            Mode::Explore { left } => Self::Explore { left: *left },
            Mode::Learn { .. } => Self::Learn,
            Mode::Seek { .. } => Self::Seek,
            Mode::Stopped(reason) => Self::Stopped(*reason),
            Mode::Babble { left } => Self::Babble { left: *left },
            Mode::Calibrate => Self::Calibrate,
        }
    }
}

/// An event for the host's log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum LogEvent {
    /// No frame of the host for too long; the robot stopped.
    LinkLost,
    /// Frames were lost because the link was too slow for them.
    FramesDropped {
        /// How many so far.
        count: u32,
    },
    /// A transducer is faulty and disabled.
    SensorDisabled {
        /// Transducer.
        sensor: u8,
        /// What is wrong with it.
        fault: SensorFault,
    },
    /// A transducer is sound again and enabled.
    SensorEnabled {
        /// Transducer.
        sensor: u8,
    },
    /// An echo was too old to be used. Sent for the first one since the last decision.
    StaleEcho {
        /// Age of the echo, milliseconds.
        age_ms: u32,
    },
}

impl From<SensorVerdict> for LogEvent {
    fn from(SensorVerdict { sensor, fault }: SensorVerdict) -> Self {
        fault.map_or(Self::SensorEnabled { sensor }, |fault| {
            Self::SensorDisabled { sensor, fault }
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
    /// The chunk was not accepted.
    Transfer(TransferError),
    /// The bytes are no configuration.
    Config,
    /// Not while the robot may move.
    Moving,
    /// This program has no ring of its own.
    NoRing,
    /// Some transducers have not been heard yet.
    NoSituation,
    /// The flash operation failed; what was saved is as it was.
    Flash(FlashError),
    /// No goal is saved under this name.
    NoSuchGoal,
    /// The goal was not saved: an invalid name, or too many goals.
    InvalidGoalName,
    /// The bytes are no body, or this program is for a held ring only.
    Body,
    /// This program has no memory of places.
    NoPlaces,
}
