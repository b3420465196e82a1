//! Encodes and decodes commands.

use super::{AxisMode, CommandError, NomadCommand, ReadingGroup};
use crate::bytes::{LengthError, PayloadReader, put_i16, put_u16};
use crate::{Kind, Packet, StateMask};

impl NomadCommand {
    /// Encodes the command.
    #[must_use]
    pub fn to_packet(&self) -> Packet {
        Packet::new(self.kind(), self.payload())
    }

    fn payload(&self) -> Vec<u8> {
        let mut out = Vec::new();
        match self {
            Self::Accelerations(numbers) | Self::Speeds(numbers) => put_unsigned(&mut out, numbers),
            Self::Relative(numbers) | Self::Absolute(numbers) | Self::Velocity(numbers) => {
                put_signed(&mut out, numbers);
            }
            Self::DefinePosition(numbers) | Self::DefineAngles(numbers) => {
                put_signed(&mut out, numbers);
            }
            Self::Move(axes) => put_axes(&mut out, axes),
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
        out
    }

    /// Decodes a packet.
    ///
    /// # Errors
    /// [`CommandError`].
    pub fn from_packet(packet: &Packet) -> Result<Self, CommandError> {
        let kind = Kind::from_byte(packet.kind).ok_or(CommandError::Kind(packet.kind))?;
        if let Some(opaque) = opaque(kind, &packet.payload) {
            return opaque;
        }
        let mut reader = PayloadReader::new(&packet.payload);
        let read = Self::read(kind, &mut reader).and_then(|command| {
            reader.end()?;
            Ok(command)
        });
        match read {
            Ok(command) => Ok(command),
            Err(PayloadError::Mode(number)) => Err(CommandError::AxisMode(number)),
            Err(PayloadError::Length(wrong)) => Err(CommandError::Length(kind, wrong)),
        }
    }

    fn read(kind: Kind, reader: &mut PayloadReader<'_>) -> Result<Self, PayloadError> {
        if let Some(group) = ReadingGroup::of(kind) {
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
            Kind::Ct => Self::Communicate(StateMask::from_bytes(reader.bytes()?)),
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
            Kind::Ws => wait_for_stop(reader)?,
            Kind::Mv => Self::Move([axis(reader)?, axis(reader)?, axis(reader)?]),
            // `gs`; all other types are opaque or groups.
            _ => Self::GetState,
        })
    }
}

fn put_unsigned(out: &mut Vec<u8>, numbers: &[u16]) {
    numbers.iter().for_each(|&number| put_u16(out, number));
}

fn put_signed(out: &mut Vec<u8>, numbers: &[i16]) {
    numbers
        .iter()
        .for_each(|&number| put_i16(out, i32::from(number)));
}

fn put_axes(out: &mut Vec<u8>, axes: &[(AxisMode, i16); 3]) {
    for &(mode, value) in axes {
        put_u16(out, mode as u16);
        put_i16(out, i32::from(value));
    }
}

/// Why a payload cannot be decoded.
enum PayloadError {
    Mode(u16),
    Length(LengthError),
}

impl From<LengthError> for PayloadError {
    fn from(wrong: LengthError) -> Self {
        Self::Length(wrong)
    }
}

fn wait_for_stop(reader: &mut PayloadReader<'_>) -> Result<NomadCommand, LengthError> {
    Ok(NomadCommand::WaitForStop {
        axes: reader.bytes()?.map(|flag: u8| flag != 0),
        timeout_s: reader.u8()?,
    })
}

fn axis(reader: &mut PayloadReader<'_>) -> Result<(AxisMode, i16), PayloadError> {
    let number = reader.u16()?;
    let mode = AxisMode::of(number).ok_or(PayloadError::Mode(number))?;
    Ok((mode, reader.i16()?))
}

/// Decodes types with a text, an unknown payload, or no command.
fn opaque(kind: Kind, payload: &[u8]) -> Option<Result<NomadCommand, CommandError>> {
    Some(match kind {
        Kind::Nak => Err(CommandError::Nak),
        Kind::Tk => {
            // The terminating zero is optional.
            let text = payload.strip_suffix(&[0]).unwrap_or(payload);
            Ok(NomadCommand::Talk(text.to_vec()))
        }
        Kind::SetupLs
        | Kind::AddObs
        | Kind::DeleteObs
        | Kind::MoveObs
        | Kind::PlaceRobot
        | Kind::Special => Ok(NomadCommand::Opaque(kind, payload.to_vec())),
        _ => return None,
    })
}
