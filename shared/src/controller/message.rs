//! What goes into the controller and what comes out of it.

use crate::faults::SensorVerdict;
use crate::goal::Goal;
use crate::planner::Plan;
use crate::scan::Situation;
use crate::units::{Bearing, Displacement, Range};
use serde::{Deserialize, Serialize};

/// What the robot is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Mode<const SENSORS: usize> {
    /// Nothing.
    Idle,
    /// Random moves.
    Explore {
        /// Samples still to be taken.
        left: u16,
    },
    /// Learning from the memory.
    Learn {
        /// Presentations done.
        step: u32,
    },
    /// Towards a goal.
    Seek {
        /// The goal.
        goal: Goal<SENSORS>,
    },
    /// Standing, for a reason.
    Stopped(StopReason),
    /// Random moves that teach where the body's sensors look.
    Babble {
        /// Moves still to be made.
        left: u16,
    },
    /// Standing: finds from those where the sensors look.
    Calibrate,
}

/// Why the robot stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StopReason {
    /// A command.
    Commanded,
    /// The ring was not complete two ring periods after it began.
    RingIncomplete,
    /// The host fell silent.
    LinkLost,
    /// Three rings in a row heard no echo at all, and no open space is expected
    /// ([`State::expects_open_space`](super::State::expects_open_space)); or a body that was to
    /// find its sensors heard nothing by which to tell them apart.
    #[serde(alias = "NoEchoes")]
    NoEchoes,
    /// A motion had not ended at its deadline: twice its distance over its speed, plus 1 s.
    Overdue,
    /// The emergency stop was pressed, or its wire is broken.
    EmergencyStop,
    /// The supply voltage is too low.
    LowVoltage,
    /// The bumper does not close, or its wire is broken.
    BumperOpen,
}

/// Why a command was not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommandRefusal {
    /// More moves than the memory holds, or none.
    #[serde(alias = "Moves")]
    InvalidMoveCount {
        /// The most it holds.
        #[serde(alias = "most")]
        max: u16,
    },
    /// The memory is empty.
    NoSamples,
    /// The maps have not been learned.
    #[serde(alias = "NotLearned")]
    NotLearned,
    /// No stop interrupted anything.
    NothingToResume,
    /// The transducers are a ring, whose bearings are known.
    FixedRing,
}

/// A command to the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command<const SENSORS: usize> {
    /// Forget the samples and take so many new ones by random moves.
    Explore {
        /// Number of moves, at least 1.
        moves: u16,
        /// Seed of the robot's own generator.
        seed: u64,
    },
    /// Make the maps from the samples.
    Learn,
    /// Pursue a goal from now on.
    Seek(Goal<SENSORS>),
    /// Stand still.
    Stop,
    /// Resume what a stop interrupted.
    Resume,
    /// Find where the body's sensors look by so many random moves; only with
    /// [`MountedSensors`](crate::body::MountedSensors).
    Calibrate {
        /// Number of moves, at least 1.
        moves: u16,
        /// Seed of the moves.
        seed: u64,
        /// Whether to find as well what the base makes of its commands.
        actuators: bool,
    },
}

/// What became of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Progress {
    /// Still under way.
    Moving,
    /// The base stands, the motion is over.
    Ended,
    /// The base stands because something was touched.
    Touched,
    /// The base turns its wheels and has not begun to roll.
    Steering,
}

/// Something that happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event<const SENSORS: usize> {
    /// A transducer listened; `None` = nothing answered.
    Echo {
        /// Transducer.
        sensor: u8,
        /// What it heard.
        range: Option<Range>,
    },
    /// The base reports what it has done since its last report.
    Odometry {
        /// Motion it is carrying out or has carried out last.
        motion: u16,
        /// Displacement since the last report, in the ring's frame at that report.
        moved: Displacement,
        /// How far the ring has turned since then.
        turned: Bearing,
        /// What became of the motion.
        progress: Progress,
    },
    /// A command.
    Command(Command<SENSORS>),
    /// Time passes.
    Tick,
    /// Something outside the controller is wrong: a robot that may move stops.
    Alarm(StopReason),
    /// A bumper touched something: the motion under way ends here.
    Touched,
}

/// What the base is asked to do: a straight displacement in the ring's present frame. A newer
/// motion replaces an older one, zero stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Motion {
    /// Number of the motion; a shortened motion keeps its number.
    pub id: u16,
    /// Where to, from here.
    pub displacement: Displacement,
    /// At most this fast, millimeters per second.
    pub speed_mm_s: u16,
}

impl Motion {
    /// The base's report about this motion; the arguments are those of [`Event::Odometry`].
    #[must_use]
    pub const fn report<const SENSORS: usize>(
        self,
        moved: Displacement,
        turned: Bearing,
        progress: Progress,
    ) -> Event<SENSORS> {
        Event::Odometry {
            motion: self.id,
            moved,
            turned,
            progress,
        }
    }
}

/// The outputs of one event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outputs<const SENSORS: usize> {
    /// What the base is to do.
    pub motion: Option<Motion>,
    /// A decision was taken.
    pub decision: Option<Decision<SENSORS>>,
    /// The mode changed.
    pub mode_changed: bool,
    /// The robot stopped, for this reason.
    pub stopped: Option<StopReason>,
    /// A command was refused.
    pub refusal: Option<CommandRefusal>,
    /// A transducer is no longer enabled, or is enabled again.
    pub verdict: Option<SensorVerdict>,
    /// The echo was not used: its age in milliseconds.
    pub stale_ms: Option<u32>,
}

impl<const SENSORS: usize> Outputs<SENSORS> {
    /// Nothing.
    pub const NONE: Self = Self::none();

    /// As [`NONE`](Self::NONE), built in place: copying the constant costs the size of a decision.
    pub(super) const fn none() -> Self {
        Self {
            motion: None,
            decision: None,
            mode_changed: false,
            stopped: None,
            refusal: None,
            verdict: None,
            stale_ms: None,
        }
    }
}

/// A decision as telemetry: what was perceived, wanted and allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(align(4))]
pub struct Decision<const SENSORS: usize> {
    /// The situation it was taken in.
    #[serde(with = "crate::arrays")]
    pub situation: Situation<SENSORS>,
    /// How it came about; `None` for a random move.
    pub plan: Option<Plan<SENSORS>>,
    /// Displacement wanted.
    pub wanted: Displacement,
    /// Displacement the shield allowed.
    pub allowed: Displacement,
    /// The goal holds.
    pub at_goal: bool,
}
