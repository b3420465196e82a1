//! Requests for the parts that a controller knows, its parameters and its counters.

use super::knowledge::PLACES_PIECE;
use super::{LinkError, Session};
use amp::parameters::{Parameter, ParameterSpec};
use amp::wire::HostMessage;
use amp::wire::message::{Counters, DeviceMessage, MAX_CHUNK, ModeReport, TransferPart};

impl Session {
    /// Reads a whole part.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn read_part(&mut self, part: TransferPart) -> Result<Vec<u8>, LinkError> {
        let mut whole = Vec::new();
        loop {
            let (piece, total) = self.read_piece(part, whole.len() as u16)?;
            whole.extend_from_slice(&piece);
            if whole.len() >= total || piece.is_empty() {
                return Ok(whole);
            }
        }
    }

    fn read_piece(
        &mut self,
        wanted: TransferPart,
        from: u16,
    ) -> Result<(Vec<u8>, usize), LinkError> {
        let message = HostMessage::Read {
            part: wanted,
            offset: from,
        };
        self.find(&message, |said| match said {
            DeviceMessage::Chunk {
                part,
                offset,
                total,
                bytes,
            } if part == wanted && offset == from => Some((bytes.to_vec(), usize::from(total))),
            _ => None,
        })
    }

    /// Writes a whole part. Pieces end on whole components and samples.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn write_part(&mut self, part: TransferPart, bytes: &[u8]) -> Result<(), LinkError> {
        let most = match part {
            TransferPart::Places => PLACES_PIECE,
            _ => MAX_CHUNK,
        };
        let mut offset = 0_usize;
        loop {
            let rest = bytes.get(offset..).unwrap_or(&[]);
            let piece = rest.get(..most).unwrap_or(rest);
            let end = offset + piece.len();
            let last = end >= bytes.len();
            let answer = self.request(&HostMessage::Write {
                part,
                offset: offset as u16,
                bytes: piece.iter().copied().collect(),
                last,
            })?;
            if let Some(why) = answer.refusal {
                return Err(LinkError::Refused(why));
            }
            if last {
                return Ok(());
            }
            offset = end;
        }
    }

    /// Counters since the controller started.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn counters(&mut self) -> Result<Counters, LinkError> {
        self.find(&HostMessage::Counters, |said| match said {
            DeviceMessage::Counters(counters) => Some(counters),
            _ => None,
        })
    }

    /// The mode.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn mode(&mut self) -> Result<ModeReport, LinkError> {
        self.find(&HostMessage::Mode, |said| match said {
            DeviceMessage::Mode(mode) => Some(mode),
            _ => None,
        })
    }

    /// Reads a parameter, or sets it; returns its value and its specification.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn parameter(
        &mut self,
        wanted: Parameter,
        value: Option<i32>,
    ) -> Result<(i32, ParameterSpec), LinkError> {
        let message = HostMessage::Parameter {
            parameter: wanted,
            value,
        };
        self.find(&message, |said| match said {
            DeviceMessage::Parameter {
                parameter,
                value,
                spec,
            } if parameter == wanted => Some((value, spec)),
            _ => None,
        })
    }

    /// Repeats a request until a report matches.
    fn find<T>(
        &mut self,
        message: &HostMessage<16>,
        mut pick: impl FnMut(DeviceMessage<16>) -> Option<T>,
    ) -> Result<T, LinkError> {
        let mut missing = 1;
        // More often than the request itself is repeated: each time only the report may be lost.
        for _ in 0..8 {
            let answer = self.request(message)?;
            if let Some(why) = answer.refusal {
                return Err(LinkError::Refused(why));
            }
            let mut said = answer.reports.into_iter().map(|report| report.message);
            if let Some(found) = said.find_map(&mut pick) {
                return Ok(found);
            }
            missing = answer.missing.max(1);
        }
        Err(LinkError::ReportsLost { reports: missing })
    }
}
