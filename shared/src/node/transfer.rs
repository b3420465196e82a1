//! Transfer of configuration, maps, memory, body and places in pieces, and their checksums.

use super::{FrameSink, MAX_CONFIG, Node};
use crate::body::Body;
use crate::checksum::{Checksum, checksum};
use crate::config::Config;
use crate::controller::{self, TransferError};
use crate::units::Millis;
use crate::wire::message::{DeviceMessage, MAX_CHUNK, Refusal, TransferPart};
use heapless::Vec;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    Node<SENSORS, NEURONS, SAMPLES, B>
{
    /// Answers with a piece of a part.
    // Apart, so that its large buffers add nothing to the stack of every request.
    #[inline(never)]
    pub(super) fn read_part(
        &mut self,
        part: TransferPart,
        offset: u16,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        let mut bytes = Vec::<u8, MAX_CHUNK>::from_array([0; MAX_CHUNK]);
        let start = usize::from(offset);
        let (count, total) = match owner(part) {
            Owner::Controller(part) => (
                self.state.read_part(part, start, &mut bytes),
                self.state.part_len(part),
            ),
            Owner::Body => (
                self.body.read_places(start, &mut bytes),
                self.body.places_len(),
            ),
            Owner::Node(part) => {
                let mut buffer = [0; MAX_CONFIG];
                let whole = match part {
                    StagedPart::Config => self.config.to_bytes(&mut buffer),
                    StagedPart::Body => self.body.to_bytes(&mut buffer),
                };
                let rest = whole.get(start..).unwrap_or(&[]);
                for (place, byte) in bytes.iter_mut().zip(rest) {
                    *place = *byte;
                }
                (rest.len(), whole.len())
            }
        };
        bytes.truncate(count);
        let piece = DeviceMessage::Chunk {
            part,
            offset,
            total: total as u16,
            bytes,
        };
        self.send(piece, now, out);
    }

    /// Takes a piece of a part; a configuration or a body takes effect with its last piece.
    pub(super) fn write_part(
        &mut self,
        part: TransferPart,
        offset: u16,
        bytes: &[u8],
        last: bool,
    ) -> Result<(), Refusal> {
        self.require_standing()?;
        let part = match owner(part) {
            Owner::Controller(part) => {
                let written = self.state.write_part(part, usize::from(offset), bytes);
                return written.map_err(Refusal::Transfer);
            }
            Owner::Body if B::MAX_PLACES_BYTES == 0 => return Err(Refusal::NoPlaces),
            Owner::Body => {
                let written = self.body.write_places(usize::from(offset), bytes);
                return written.map_err(Refusal::Transfer);
            }
            Owner::Node(part) => part,
        };
        if offset == 0 {
            self.staged.clear();
            self.staged_part = part;
        }
        let continues = part == self.staged_part && usize::from(offset) == self.staged.len();
        if !continues || self.staged.extend_from_slice(bytes).is_err() {
            return Err(Refusal::Transfer(TransferError::OutOfBounds));
        }
        match part {
            _ if !last => {}
            StagedPart::Config => {
                let config = Config::from_bytes(&self.staged).ok_or(Refusal::Config)?;
                self.replace_config(config);
            }
            StagedPart::Body if self.body.replace(&self.staged) => {}
            StagedPart::Body => return Err(Refusal::Body),
        }
        Ok(())
    }

    pub(super) fn config_crc(&self) -> u32 {
        checksum(self.config.to_bytes(&mut [0; MAX_CONFIG]))
    }

    pub(super) fn maps_crc(&self) -> u32 {
        use controller::StatePart::{Actions, Changes, Situations};
        self.crc_of(&[Situations, Changes, Actions])
    }

    pub(super) fn memory_crc(&self) -> u32 {
        self.crc_of(&[controller::StatePart::Memory])
    }

    #[inline(never)]
    fn crc_of(&self, parts: &[controller::StatePart]) -> u32 {
        let mut digest = Checksum::new();
        for &part in parts {
            let mut offset = 0;
            let mut buffer = [0; 64];
            loop {
                let count = self.state.read_part(part, offset, &mut buffer);
                if count == 0 {
                    break;
                }
                digest.update(buffer.get(..count).unwrap_or(&[]));
                offset = offset.saturating_add(count);
            }
        }
        digest.finalize()
    }
}

/// A part that is collected before it takes effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StagedPart {
    Config,
    Body,
}

/// Who has a part.
enum Owner {
    Controller(controller::StatePart),
    /// It has the places.
    Body,
    Node(StagedPart),
}

const fn owner(part: TransferPart) -> Owner {
    match part {
        TransferPart::Config => Owner::Node(StagedPart::Config),
        TransferPart::Situations => Owner::Controller(controller::StatePart::Situations),
        TransferPart::Changes => Owner::Controller(controller::StatePart::Changes),
        TransferPart::Actions => Owner::Controller(controller::StatePart::Actions),
        TransferPart::Memory => Owner::Controller(controller::StatePart::Memory),
        TransferPart::Body => Owner::Node(StagedPart::Body),
        TransferPart::Places => Owner::Body,
    }
}
