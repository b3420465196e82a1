//! What there is to say over the link. Quantities are integers with their unit in the name; enumerations only grow at
//! their ends.

use crate::controller::{
    Decision, Mode, Motion, PartError, Progress, Refusal as Refused, StopReason,
};
use crate::faults::{Fault, Verdict};
use crate::goal::{Goal, Name};
use crate::memory::SituationBytes;
use crate::parameters::{Parameter, ParameterError, Spec};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most bytes of a part in one message.
pub const MAX_PIECE: usize = 160;
/// Most echoes in one message.
pub const MAX_ECHOES: usize = 16;

/// From the base (or a computer in its place) to the mind.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToMind<const SENSORS: usize> {
    /// Opens a session: the one in the frame's header. Answered with the mind's hello, or refused.
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
    /// Asks for a piece of a part; answered with [`FromMind::Piece`].
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
    /// Something to do with what outlives a loss of power. Refused while the robot may move; *Done* comes when it is over.
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
    /// Asks for the present goal and those kept; answered with a [`FromMind::Goal`] for each.
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
        /// Seed of the mind's generator.
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

/// A part that can be read and written in pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Part {
    /// The configuration, in postcard's form; written from its beginning on, it takes effect with the last piece.
    Config,
    /// The situation map.
    Situations,
    /// The changes of the action map.
    Changes,
    /// The actions of the action map.
    Actions,
    /// The lazy memory.
    Memory,
}

/// Where echoes come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// From the host, over the link.
    Link,
    /// From the ring at the chip's own pins.
    Ring,
}

/// Whose time counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Clock {
    /// The host's: time is that of its latest message. For simulators: a slow host changes nothing.
    Host,
    /// The mind's own: a silent host stops the robot.
    Device,
}

/// What both ends have to agree on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dimensions {
    /// Version of the protocol.
    pub protocol: u16,
    /// CRC-32 of the messages' grammar.
    pub schema: u32,
    /// Transducers.
    pub sensors: u8,
    /// Neurons of each map.
    pub neurons: u8,
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

/// The mind's hello.
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

/// What clocks the processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Oscillator {
    /// Not known: a simulator, or a board with one oscillator.
    #[default]
    Unknown,
    /// The crystal.
    Crystal,
    /// The internal oscillator, because the crystal failed or has an unexpected frequency. It is accurate to 1 % at 25 °C.
    Internal,
}

/// Why the program started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ResetCause {
    /// Not known.
    #[default]
    Unknown,
    /// Power came on.
    PowerOn,
    /// The reset pin.
    Pin,
    /// It was asked for.
    Requested,
    /// The watchdog was not fed.
    Watchdog,
    /// The program panicked.
    Panic,
    /// The processor faulted.
    HardFault,
    /// The stack left its region.
    StackOverflow,
}

/// What the mind says, and when by its own time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report<const SENSORS: usize> {
    /// Time by the session's clock.
    pub device_ms: u32,
    /// What it says.
    pub said: FromMind<SENSORS>,
}

/// From the mind to the base.
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
    /// A frame has been dealt with; whatever it brought about has been said before.
    Done {
        /// Its number.
        seq: u16,
    },
    /// Nothing will be heard or said from here for so long at most.
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
    /// Counts the motion's shortenings. The same number and revision again only renew the time to live.
    pub revision: u8,
    /// Where to, from where the base stood at its latest report, in the ring's frame there; (0, 0) stops.
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
    /// A transducer is out of order and no longer believed.
    Disbelieved {
        /// Transducer.
        sensor: u8,
        /// What is wrong with it.
        fault: Fault,
    },
    /// A transducer is in order again and believed.
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

impl From<Verdict> for Notice {
    fn from(Verdict { sensor, fault }: Verdict) -> Self {
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
    /// No session has been opened since the mind started.
    NoSession,
    /// The command was past its time to live.
    Expired {
        /// Its age.
        age_ms: u32,
    },
    /// The controller refused.
    Command(Refused),
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

/// What has been counted since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// Frames accepted.
    pub accepted: u32,
    /// Frames with wrong COBS or of a wrong length.
    pub misshapen: u32,
    /// Frames with a wrong CRC.
    pub damaged: u32,
    /// Sound frames without a message of this protocol.
    pub unknown: u32,
    /// Frames too long for the buffer.
    pub oversized: u32,
    /// Frames of another session or none.
    pub strangers: u32,
    /// Frames that came again or too late.
    pub replayed: u32,
    /// Commands past their time to live.
    pub expired: u32,
    /// Requests refused.
    pub refused: u32,
    /// Frames sent.
    pub sent: u32,
    /// Frames that found no room on the way out.
    pub dropped: u32,
    /// Times the host was lost.
    pub link_losses: u32,
    /// Echoes that were too old to be used.
    pub stale_echoes: u32,
    /// How far the host's clock has fallen behind the device's in this session, milliseconds; negative: it is ahead.
    pub clock_drift_ms: i32,
    /// What the device counted.
    pub device: DeviceCounters,
}

impl Counters {
    /// Nothing counted.
    pub const NONE: Self = Self {
        accepted: 0,
        misshapen: 0,
        damaged: 0,
        unknown: 0,
        oversized: 0,
        strangers: 0,
        replayed: 0,
        expired: 0,
        refused: 0,
        sent: 0,
        dropped: 0,
        link_losses: 0,
        stale_echoes: 0,
        clock_drift_ms: 0,
        device: DeviceCounters {
            overruns: 0,
            queue_losses: 0,
            stack_peak_bytes: 0,
            ticks: 0,
            longest_tick_ms: 0,
            ring_faults: 0,
        },
    };
}

/// What the device itself counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct DeviceCounters {
    /// Bytes the receiver's hardware lost.
    pub overruns: u32,
    /// Bytes that found no room in the receive queue.
    pub queue_losses: u32,
    /// Most bytes of stack used.
    pub stack_peak_bytes: u32,
    /// Control ticks.
    pub ticks: u32,
    /// Longest time between two control ticks.
    pub longest_tick_ms: u32,
    /// Firings of the chip's own ring that its ECHO line spoilt, and readings for which there was no room.
    pub ring_faults: u32,
}
