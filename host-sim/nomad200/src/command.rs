//! The commands of a host to the robot.
//!
//! Units as on the line: translation in 0.1 in, 0.1 in/s, 0.1 in/s²; steering and turret in 0.1°,
//! 0.1°/s, 0.1°/s². Three numbers are always translation, steering, turret.

use super::bytes::LengthError;
use super::{Kind, StateMask};
use std::fmt;

mod codec;

/// Mode of an axis in `mv`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum AxisMode {
    /// Leave the axis alone.
    Ignore = 0,
    /// Turn at this velocity.
    Velocity = 1,
    /// Move by this amount.
    Relative = 2,
    /// Motor off.
    Limp = 3,
    /// Set the acceleration.
    Acceleration = 4,
    /// Set the speed of moves.
    Speed = 5,
    /// Move to this position.
    Absolute = 6,
    /// Apply this torque.
    Torque = 7,
    /// Limit the torque.
    MaxTorque = 8,
}

impl AxisMode {
    const ALL: [Self; 9] = [
        Self::Ignore,
        Self::Velocity,
        Self::Relative,
        Self::Limp,
        Self::Acceleration,
        Self::Speed,
        Self::Absolute,
        Self::Torque,
        Self::MaxTorque,
    ];

    pub(super) fn of(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }
}

/// A group of readings with its own `get_` command, independent of the mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReadingGroup {
    /// `get_ir`.
    Infrared,
    /// `get_sn`.
    Sonar,
    /// `get_rc`: the pose.
    Pose,
    /// `get_rv`.
    Velocity,
    /// `get_ra`.
    Acceleration,
    /// `get_cp`.
    Compass,
    /// `get_ls`: laser points.
    Laser,
    /// `get_bp`.
    Bumper,
    /// `get_sg`: laser line segments.
    Segments,
}

impl ReadingGroup {
    /// Every group.
    pub const ALL: [Self; 9] = [
        Self::Infrared,
        Self::Sonar,
        Self::Pose,
        Self::Velocity,
        Self::Acceleration,
        Self::Compass,
        Self::Laser,
        Self::Bumper,
        Self::Segments,
    ];

    /// The packet type of request and answer.
    #[must_use]
    pub fn kind(self) -> Kind {
        match self {
            Self::Infrared => Kind::GetIr,
            Self::Sonar => Kind::GetSn,
            Self::Pose => Kind::GetRc,
            Self::Velocity => Kind::GetRv,
            Self::Acceleration => Kind::GetRa,
            Self::Compass => Kind::GetCp,
            Self::Laser => Kind::GetLs,
            Self::Bumper => Kind::GetBp,
            Self::Segments => Kind::GetSg,
        }
    }

    /// The group that belongs to a packet type.
    #[must_use]
    pub fn of(kind: Kind) -> Option<Self> {
        Self::ALL.into_iter().find(|group| group.kind() == kind)
    }
}

/// A command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NomadCommand {
    /// `ac`: accelerations of all motions.
    Accelerations([u16; 3]),
    /// `sp`: speeds of `pr` and `pa`.
    Speeds([u16; 3]),
    /// `pr`: move by these amounts; the axes run together.
    Relative([i16; 3]),
    /// `pa`: move to these positions.
    Absolute([i16; 3]),
    /// `vm`: move at these velocities until another command or a time-out.
    Velocity([i16; 3]),
    /// `mv`: each axis in its own mode.
    Move([(AxisMode, i16); 3]),
    /// `ct`: the content of state packets, including the answer to this command.
    Communicate(StateMask),
    /// `gs`: the state.
    GetState,
    /// `st`: stop and hold.
    Stop,
    /// `lp`: motors off.
    Limp,
    /// `tk`: speak this text.
    Talk(Vec<u8>),
    /// `dp`: set the position.
    DefinePosition([i16; 2]),
    /// `da`: set the angles of steering and turret.
    DefineAngles([i16; 2]),
    /// `zr`: align steering and turret with bumper 0 and set the angles to zero.
    Zero,
    /// `conf_ir`.
    ConfigureInfrared {
        /// Tenths of a reading that come from the previous one, 0 … 10.
        history: u8,
        /// Order, ended by 255.
        order: [u8; 16],
    },
    /// `conf_sn`.
    ConfigureSonar {
        /// Time from one firing to the next, in 4 ms.
        rate: u8,
        /// Order of firing, ended by 255.
        order: [u8; 16],
    },
    /// `conf_cp`: 0 off, 1 on, 2 calibrate.
    ConfigureCompass(u8),
    /// `conf_ls`: mode, threshold, width, number of points (two bytes), processing.
    ConfigureLaser([u8; 6]),
    /// `conf_sg`: threshold, points, gap.
    ConfigureSegments([u8; 3]),
    /// `conf_tm`: time-out of motions without a command, seconds; 0 = none.
    ConfigureTimeout(u8),
    /// Speed of a Scout's serial port.
    ConfigureSerial {
        /// Number of the port.
        port: u8,
        /// Baud, limited to 16 bits.
        baud: u16,
    },
    /// `get_…`.
    Get(ReadingGroup),
    /// `ws`: answer when these axes stand, or after a time-out.
    WaitForStop {
        /// Axes to wait for.
        axes: [bool; 3],
        /// Time-out, seconds.
        timeout_s: u8,
    },
    /// A packet with an unknown payload: laser setup, obstacles of the original simulator, user
    /// packets.
    Opaque(Kind, Vec<u8>),
}

/// A packet that is not a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandError {
    /// An unknown type.
    Kind(u8),
    /// An answer of the robot.
    Nak,
    /// An unknown mode of an axis.
    AxisMode(u16),
    /// The payload is too short or too long.
    Length(Kind, LengthError),
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kind(number) => write!(f, "there is no command {number}"),
            Self::Nak => f.write_str("NAK is an answer, not a command"),
            Self::AxisMode(number) => write!(f, "an axis has no mode {number}"),
            Self::Length(kind, wrong) => write!(f, "{kind:?}: {wrong}"),
        }
    }
}

impl std::error::Error for CommandError {}

impl NomadCommand {
    /// The packet type of the command and of its answer.
    #[must_use]
    pub fn kind(&self) -> Kind {
        match self {
            Self::Accelerations(_) => Kind::Ac,
            Self::Speeds(_) => Kind::Sp,
            Self::Relative(_) => Kind::Pr,
            Self::Absolute(_) => Kind::Pa,
            Self::Velocity(_) => Kind::Vm,
            Self::Move(_) => Kind::Mv,
            Self::Communicate(_) => Kind::Ct,
            Self::GetState => Kind::Gs,
            Self::Stop => Kind::St,
            Self::Limp => Kind::Lp,
            Self::Talk(_) => Kind::Tk,
            Self::DefinePosition(_) => Kind::Dp,
            Self::DefineAngles(_) => Kind::Da,
            Self::Zero => Kind::Zr,
            Self::ConfigureInfrared { .. } => Kind::ConfIr,
            Self::ConfigureSonar { .. } => Kind::ConfSn,
            Self::ConfigureCompass(_) => Kind::ConfCp,
            Self::ConfigureLaser(_) => Kind::ConfLs,
            Self::ConfigureSegments(_) => Kind::ConfSg,
            Self::ConfigureTimeout(_) => Kind::ConfTm,
            Self::ConfigureSerial { .. } => Kind::ConfSer,
            Self::Get(group) => group.kind(),
            Self::WaitForStop { .. } => Kind::Ws,
            Self::Opaque(kind, _) => *kind,
        }
    }
}

#[cfg(test)]
mod tests;
