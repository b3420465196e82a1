//! What a host asks of the robot.
//!
//! Units as on the line: translation in 0.1 in, 0.1 in/s, 0.1 in/s²; steering and turret in 0.1°, 0.1°/s, 0.1°/s². Three
//! numbers are always translation, steering, turret.

use super::bytes::{Reader, WrongLength, put_i16, put_u16};
use super::{Kind, Mask, Packet};
use std::fmt;

/// What `mv` does with an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum AxisMode {
    /// Leave it as it is.
    Ignore = 0,
    /// Turn at this velocity.
    Velocity = 1,
    /// Move by this much.
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
    /// Never apply more torque than this.
    MostTorque = 8,
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
        Self::MostTorque,
    ];

    pub(super) fn of(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }
}

/// A group of readings with a `get_` command of its own, sent whatever the mask says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
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

impl Group {
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

    /// The type of the question and of its answer.
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

    /// The group a type asks for.
    #[must_use]
    pub fn of(kind: Kind) -> Option<Self> {
        Self::ALL.into_iter().find(|group| group.kind() == kind)
    }
}

/// What a host asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Command {
    /// `ac`: accelerations of all motions.
    Accelerations([u16; 3]),
    /// `sp`: speeds of `pr` and `pa`.
    Speeds([u16; 3]),
    /// `pr`: move by this much; the three axes run together.
    Relative([i16; 3]),
    /// `pa`: move to these positions.
    Absolute([i16; 3]),
    /// `vm`: move at these velocities until something else is said, or nothing for too long.
    Velocity([i16; 3]),
    /// `mv`: each axis in its own way.
    Move([(AxisMode, i16); 3]),
    /// `ct`: what state packets hold from now on, this one's answer included.
    Communicate(Mask),
    /// `gs`: the state.
    GetState,
    /// `st`: stop and hold.
    Stop,
    /// `lp`: motors off.
    Limp,
    /// `tk`: say this text.
    Talk(Vec<u8>),
    /// `dp`: the robot is here.
    DefinePosition([i16; 2]),
    /// `da`: these are the angles of steering and turret.
    DefineAngles([i16; 2]),
    /// `zr`: align steering and turret with bumper 0 and call that zero.
    Zero,
    /// `conf_ir`.
    ConfigureInfrared {
        /// Tenths of a reading that come from the one before, 0 … 10.
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
    /// `conf_tm`: seconds of silence after which motions end; 0 = never.
    ConfigureTimeout(u8),
    /// Speed of a Scout's serial port.
    ConfigureSerial {
        /// Which port.
        port: u8,
        /// Baud, as far as 16 bits hold it.
        baud: u16,
    },
    /// `get_…`.
    Get(Group),
    /// `ws`: answer when these axes stand, or after so many seconds.
    WaitForStop {
        /// Which axes.
        axes: [bool; 3],
        /// Seconds.
        timeout_s: u8,
    },
    /// A type whose payload is not known: set-up of the laser, obstacles and places of the original simulator, the user's
    /// own packets.
    Opaque(Kind, Vec<u8>),
}

/// A packet that is no command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoCommand {
    /// No such type.
    Kind(u8),
    /// A robot's answer, not a question.
    Nak,
    /// No such way to move an axis.
    AxisMode(u16),
    /// The payload is too short or too long.
    Length(Kind, WrongLength),
}

impl fmt::Display for NoCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kind(number) => write!(f, "there is no command {number}"),
            Self::Nak => f.write_str("NAK is an answer, not a command"),
            Self::AxisMode(number) => write!(f, "an axis has no mode {number}"),
            Self::Length(kind, wrong) => write!(f, "{kind:?}: {wrong}"),
        }
    }
}

impl std::error::Error for NoCommand {}

impl Command {
    /// The type of its packet, and of the answer.
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

    /// The packet that asks for it.
    #[must_use]
    pub fn to_packet(&self) -> Packet {
        let mut out = Vec::new();
        match self {
            Self::Accelerations(numbers) | Self::Speeds(numbers) => {
                numbers.iter().for_each(|&number| put_u16(&mut out, number));
            }
            Self::Relative(numbers) | Self::Absolute(numbers) | Self::Velocity(numbers) => {
                put_signed(&mut out, numbers);
            }
            Self::DefinePosition(numbers) | Self::DefineAngles(numbers) => {
                put_signed(&mut out, numbers);
            }
            Self::Move(axes) => {
                for &(mode, value) in axes {
                    put_u16(&mut out, mode as u16);
                    put_i16(&mut out, i32::from(value));
                }
            }
            Self::Communicate(mask) => out.extend(mask.to_bytes()),
            Self::Talk(text) => {
                out.extend(text);
                out.push(0);
            }
            Self::ConfigureInfrared {
                history: first,
                order,
            }
            | Self::ConfigureSonar { rate: first, order } => {
                out.push(*first);
                out.extend(order);
            }
            Self::ConfigureCompass(byte) | Self::ConfigureTimeout(byte) => out.push(*byte),
            Self::ConfigureLaser(bytes) => out.extend(bytes),
            Self::ConfigureSegments(bytes) => out.extend(bytes),
            Self::ConfigureSerial { port, baud } => {
                out.push(*port);
                put_u16(&mut out, *baud);
            }
            Self::WaitForStop { axes, timeout_s } => {
                out.extend(axes.map(u8::from));
                out.push(*timeout_s);
            }
            Self::Opaque(_, payload) => out.extend(payload),
            Self::GetState | Self::Stop | Self::Limp | Self::Zero | Self::Get(_) => {}
        }
        Packet::new(self.kind(), out)
    }

    /// Reads a packet.
    ///
    /// # Errors
    /// [`NoCommand`].
    pub fn from_packet(packet: &Packet) -> Result<Self, NoCommand> {
        let kind = Kind::from_byte(packet.kind).ok_or(NoCommand::Kind(packet.kind))?;
        if let Some(opaque) = opaque(kind, &packet.payload) {
            return opaque;
        }
        let mut reader = Reader::new(&packet.payload);
        let read = Self::read(kind, &mut reader).and_then(|command| {
            reader.end()?;
            Ok(command)
        });
        match read {
            Ok(command) => Ok(command),
            Err(Unread::Mode(number)) => Err(NoCommand::AxisMode(number)),
            Err(Unread::Length(wrong)) => Err(NoCommand::Length(kind, wrong)),
        }
    }

    fn read(kind: Kind, reader: &mut Reader<'_>) -> Result<Self, Unread> {
        if let Some(group) = Group::of(kind) {
            return Ok(Self::Get(group));
        }
        Ok(match kind {
            Kind::Ac => Self::Accelerations(reader.u16s()?),
            Kind::Sp => Self::Speeds(reader.u16s()?),
            Kind::Pr => Self::Relative(reader.i16s()?),
            Kind::Pa => Self::Absolute(reader.i16s()?),
            Kind::Vm => Self::Velocity(reader.i16s()?),
            Kind::Dp => Self::DefinePosition(reader.i16s()?),
            Kind::Da => Self::DefineAngles(reader.i16s()?),
            Kind::Ct => Self::Communicate(Mask::from_bytes(reader.bytes()?)),
            Kind::St => Self::Stop,
            Kind::Lp => Self::Limp,
            Kind::Zr => Self::Zero,
            Kind::ConfIr => Self::ConfigureInfrared {
                history: reader.u8()?,
                order: reader.bytes()?,
            },
            Kind::ConfSn => Self::ConfigureSonar {
                rate: reader.u8()?,
                order: reader.bytes()?,
            },
            Kind::ConfCp => Self::ConfigureCompass(reader.u8()?),
            Kind::ConfLs => Self::ConfigureLaser(reader.bytes()?),
            Kind::ConfSg => Self::ConfigureSegments(reader.bytes()?),
            Kind::ConfTm => Self::ConfigureTimeout(reader.u8()?),
            Kind::ConfSer => Self::ConfigureSerial {
                port: reader.u8()?,
                baud: reader.u16()?,
            },
            Kind::Ws => Self::WaitForStop {
                axes: reader.bytes()?.map(|flag: u8| flag != 0),
                timeout_s: reader.u8()?,
            },
            Kind::Mv => Self::Move([axis(reader)?, axis(reader)?, axis(reader)?]),
            // Gs; the others are opaque or groups.
            _ => Self::GetState,
        })
    }
}

fn put_signed(out: &mut Vec<u8>, numbers: &[i16]) {
    numbers
        .iter()
        .for_each(|&number| put_i16(out, i32::from(number)));
}

/// Why a payload was not read.
enum Unread {
    Mode(u16),
    Length(WrongLength),
}

impl From<WrongLength> for Unread {
    fn from(wrong: WrongLength) -> Self {
        Self::Length(wrong)
    }
}

fn axis(reader: &mut Reader<'_>) -> Result<(AxisMode, i16), Unread> {
    let number = reader.u16()?;
    let mode = AxisMode::of(number).ok_or(Unread::Mode(number))?;
    Ok((mode, reader.i16()?))
}

/// Types whose payload is a text, not known, or none of a command's.
fn opaque(kind: Kind, payload: &[u8]) -> Option<Result<Command, NoCommand>> {
    Some(match kind {
        Kind::Nak => Err(NoCommand::Nak),
        Kind::Tk => {
            // With its closing zero, if it has one.
            let text = payload.strip_suffix(&[0]).unwrap_or(payload);
            Ok(Command::Talk(text.to_vec()))
        }
        Kind::SetupLs
        | Kind::AddObs
        | Kind::DeleteObs
        | Kind::MoveObs
        | Kind::PlaceRobot
        | Kind::Special => Ok(Command::Opaque(kind, payload.to_vec())),
        _ => return None,
    })
}

#[cfg(test)]
mod tests;
