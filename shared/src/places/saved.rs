//! Places as bytes, for an image and for a host.
//!
//! ```text
//! places = head place…       items of the same length; numbers little-endian; nothing without a place
//! head   = shift:u8 [weight:u8; 32] apart:u16 x:i16 y:i16 is_lost:u8 zeros
//!                            weights of walls by direction, times 2^shift
//! place  = x:i16 y:i16 free:[u8; 16] open:u32 tried:u32 links:[u16; 6] view:[u8; SECTORS]
//! ```
//!
//! *apart* is how far places are to stand apart since there was no room for more, *x* and *y* where
//! the robot is, millimeters. *x*, *y* and *is_lost* are written and not read back: the robot may
//! be anywhere then. Not written: which ways are blocked, and the places that a lost robot has
//! found since it was set down.

use super::Places;
use super::record::{BYTES_BESIDE_VIEW, Record};
use crate::controller::TransferError;
use crate::store::RecordFields;
use heapless::Vec;

/// Most bytes of an item: a place with a view of 32 sectors.
const MAX_ITEM: usize = 72;

/// An item.
pub(super) type Item = Vec<u8, MAX_ITEM>;

/// An item of these fields.
#[inline(never)]
pub(super) fn item_of(fields: &[&[u8]]) -> Item {
    let mut item = Item::new();
    for field in fields {
        // No view has more than 32 sectors.
        let _ = item.extend_from_slice(field);
    }
    item
}

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// Bytes of an item.
    pub const ITEM_BYTES: usize = BYTES_BESIDE_VIEW + SECTORS;

    /// Most bytes of all places.
    pub const MAX_BYTES: usize = match RECORDS {
        0 => 0,
        places => Self::ITEM_BYTES * (places + 1),
    };

    /// Length in bytes.
    #[must_use]
    pub fn saved_len(&self) -> usize {
        match self.known_for_good().len() {
            0 => 0,
            places => Self::ITEM_BYTES.saturating_mul(places.saturating_add(1)),
        }
    }

    /// Copies the bytes from `offset` on into `out`, as far as both reach; returns their number.
    // One copy in the program.
    #[inline(never)]
    pub fn read_saved(&self, offset: usize, out: &mut [u8]) -> usize {
        let count = self.saved_len().saturating_sub(offset).min(out.len());
        for (place, index) in out.iter_mut().zip(offset..offset.saturating_add(count)) {
            let item = self.item(index / Self::ITEM_BYTES);
            *place = item.get(index % Self::ITEM_BYTES).copied().unwrap_or(0);
        }
        count
    }

    fn item(&self, index: usize) -> Item {
        match index.checked_sub(1) {
            None => self.head(),
            Some(place) => {
                let record = self.graph.records().get(place);
                record.map(Record::item).unwrap_or_default()
            }
        }
    }

    fn head(&self) -> Item {
        let (shift, weights) = self.compass.saved_walls();
        let mut head = item_of(&[
            &[shift],
            &weights,
            &self.graph.least_mm().to_le_bytes(),
            &self.here.dx_mm.to_le_bytes(),
            &self.here.dy_mm.to_le_bytes(),
            &[self.aside().is_some().into()],
        ]);
        let _ = head.resize_default(Self::ITEM_BYTES);
        head
    }

    /// Undoes [`head`](Self::head), but for where the robot is; `None` for too few bytes.
    fn restore_head(&mut self, mut fields: RecordFields<'_>) -> Option<()> {
        let [shift] = fields.take()?;
        self.compass.restore_walls(shift, fields.take()?);
        self.graph.keep_apart(u16::from_le_bytes(fields.take()?));
        Some(())
    }

    /// Replaces a piece. Pieces are whole items and come in order, the first one with a place; one
    /// at offset 0 forgets all that was known. The robot may then be [anywhere](Self::set_down).
    ///
    /// # Errors
    /// [`TransferError::OutOfBounds`]; nothing has changed then.
    // One copy in the program.
    #[inline(never)]
    pub fn write_saved(&mut self, offset: usize, bytes: &[u8]) -> Result<(), TransferError> {
        let written = if offset == 0 { 0 } else { self.saved_len() };
        let room = Self::MAX_BYTES.saturating_sub(offset);
        let is_whole = bytes.len().is_multiple_of(Self::ITEM_BYTES) && bytes.len() <= room;
        let is_head_alone = offset == 0 && bytes.len() == Self::ITEM_BYTES;
        // Since it was set down it has places that may be anywhere: none can follow.
        let is_lost = offset > 0 && self.lost.first_uncertain().is_some();
        if offset != written || !is_whole || is_head_alone || is_lost {
            return Err(TransferError::OutOfBounds);
        }
        let mut items = bytes.chunks_exact(Self::ITEM_BYTES);
        if offset == 0 {
            self.forget();
            let _ = self.restore_head(RecordFields(items.next().unwrap_or(&[])));
        }
        for record in items.filter_map(|item| Record::from_item(RecordFields(item))) {
            self.graph.restore(record);
        }
        Ok(())
    }
}
