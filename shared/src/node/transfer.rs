//! Transfer of configuration, maps and memory in pieces, and their checksums.

use super::{FrameSink, MAX_CONFIG, Node};
use crate::checksum::{Checksum, checksum};
use crate::config::Config;
use crate::controller::{self, TransferError};
use crate::units::Millis;
use crate::wire::message::{DeviceMessage, MAX_CHUNK, Refusal, TransferPart};
use heapless::Vec;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    Node<SENSORS, NEURONS, SAMPLES>
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
        let mut bytes = Vec::<u8, MAX_CHUNK>::new();
        let start = usize::from(offset);
        let total = match controller_part(part) {
            Some(part) => {
                let mut buffer = [0; MAX_CHUNK];
                let count = self.state.read_part(part, start, &mut buffer);
                let _ = bytes.extend_from_slice(buffer.get(..count).unwrap_or(&[]));
                self.state.part_len(part)
            }
            None => {
                let mut buffer = [0; MAX_CONFIG];
                let whole = self.config.to_bytes(&mut buffer);
                let rest = whole.get(start..).unwrap_or(&[]);
                let _ = bytes.extend_from_slice(rest.get(..MAX_CHUNK).unwrap_or(rest));
                whole.len()
            }
        };
        let piece = DeviceMessage::Chunk {
            part,
            offset,
            total: total as u16,
            bytes,
        };
        self.send(piece, now, out);
    }

    /// Takes a piece of a part; a configuration takes effect with its last piece.
    pub(super) fn write_part(
        &mut self,
        part: TransferPart,
        offset: u16,
        bytes: &[u8],
        last: bool,
    ) -> Result<(), Refusal> {
        self.require_standing()?;
        if let Some(part) = controller_part(part) {
            let written = self.state.write_part(part, usize::from(offset), bytes);
            return written.map_err(Refusal::Transfer);
        }
        if offset == 0 {
            self.staged.clear();
        }
        if usize::from(offset) != self.staged.len() || self.staged.extend_from_slice(bytes).is_err()
        {
            return Err(Refusal::Transfer(TransferError::OutOfBounds));
        }
        if last {
            let config = Config::from_bytes(&self.staged).ok_or(Refusal::Config)?;
            self.replace_config(config);
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

/// The controller's part; `None` for the configuration, which is the node's.
const fn controller_part(part: TransferPart) -> Option<controller::StatePart> {
    match part {
        TransferPart::Config => None,
        TransferPart::Situations => Some(controller::StatePart::Situations),
        TransferPart::Changes => Some(controller::StatePart::Changes),
        TransferPart::Actions => Some(controller::StatePart::Actions),
        TransferPart::Memory => Some(controller::StatePart::Memory),
    }
}
