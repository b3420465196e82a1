//! Saved images in two sectors of flash: a loss of power at any moment leaves the old image or
//! the new one, whole. The format of an image is that of [`amp::store`].
//!
//! ```text
//! sector = mark slot slot …        mark = "ERAS" generation CRC, written after the erasure
//! slot   = an image, or blank, or the rest of an image that was not finished
//! ```

use amp::body::Body;
use amp::store::{Contents, ImageError, ImageInfo, WORD, check};
use amp::wire::checksum;
use amp::wire::message::{FlashError, FlashOperation};
use core::convert::Infallible;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Size of a slot for the image of a robot with this body, bytes.
#[must_use]
pub const fn slot_bytes<B: Body<16>>() -> u32 {
    amp::store::max_bytes::<B>() as u32
}

/// Longest time to erase a sector of 128 KiB by words, milliseconds; half of it is typical
/// (STM32F405 data sheet DS8626, flash memory programming).
pub const ERASE_MS: u32 = 2_000;

/// Longest time to write an image of so many bytes by words, milliseconds: 100 µs a word; 16 µs are
/// typical.
#[must_use]
pub const fn write_ms(image_bytes: u32) -> u32 {
    (image_bytes / WORD as u32).div_ceil(10)
}

/// Size of a mark, bytes.
const MARK_BYTES: u32 = 12;

/// The first bytes of a mark.
const MARK_MAGIC: [u8; 4] = *b"ERAS";

/// The flash of a board that has none; no value of this type exists.
#[derive(Debug)]
pub enum NoFlash {}

impl ErrorType for NoFlash {
    type Error = Infallible;
}

impl ReadNorFlash for NoFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, _: u32, _: &mut [u8]) -> Result<(), Infallible> {
        match *self {}
    }

    fn capacity(&self) -> usize {
        match *self {}
    }
}

impl NorFlash for NoFlash {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = 1;

    fn erase(&mut self, _: u32, _: u32) -> Result<(), Infallible> {
        match *self {}
    }

    fn write(&mut self, _: u32, _: &[u8]) -> Result<(), Infallible> {
        match *self {}
    }
}

/// Location of a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct SlotLocation {
    sector: u32,
    slot: u32,
}

/// The images in two sectors: the first two erase units of `F`.
///
/// - A save writes to the next free slot beside the newest image, or to the spare sector if there
///   is none. An image is valid only with its last word; the previous image stays untouched.
/// - Only the spare sector, which does not hold the newest image, is ever erased.
/// - A sector whose erasure was interrupted may read as blank. Its mark proves that the erasure
///   was completed, and names the newest generation then, so an older mark proves nothing.
/// - Erasing stops the processor for seconds. [`Store::ensure_free_slot`] does it at the start, so
///   a save erases only when the device has filled a sector since.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    slot_bytes: u32,
    newest: Option<SlotLocation>,
    /// Generation of the newest image; 0 = there is none.
    generation: u32,
}

impl<F: NorFlash> Store<F> {
    const SECTOR_BYTES: u32 = F::ERASE_SIZE as u32;

    /// Finds the newest image; writes nothing. `slot_bytes` is a multiple of four.
    pub fn mount(flash: F, slot_bytes: u32) -> Self {
        const {
            assert!(WORD.is_multiple_of(F::WRITE_SIZE) && WORD.is_multiple_of(F::READ_SIZE));
        }
        let mut store = Self {
            flash,
            slot_bytes,
            newest: None,
            generation: 0,
        };
        store.find_newest();
        store
    }

    /// Returns the flash.
    #[cfg(test)]
    pub(crate) fn into_flash(self) -> F {
        self.flash
    }

    fn find_newest(&mut self) {
        (self.newest, self.generation) = (None, 0);
        for sector in 0..2 {
            for slot in 0..self.slots() {
                let location = SlotLocation { sector, slot };
                if let Ok(found) = self.check_slot(location)
                    && found.generation > self.generation
                {
                    (self.newest, self.generation) = (Some(location), found.generation);
                }
            }
        }
    }

    /// Generation of the newest image; 0 = nothing is saved.
    #[must_use]
    pub const fn generation(&self) -> u32 {
        self.generation
    }

    /// Longest time for which the task stops the processor, milliseconds.
    pub fn pause_ms(&mut self, task: FlashOperation) -> u32 {
        match task {
            FlashOperation::Load => 0,
            FlashOperation::Save => write_ms(self.slot_bytes) + self.erase_count(task) * ERASE_MS,
            FlashOperation::Erase => self.erase_count(task) * ERASE_MS,
        }
    }

    /// Number of sectors that the task will erase.
    fn erase_count(&mut self, task: FlashOperation) -> u32 {
        match task {
            FlashOperation::Load => 0,
            FlashOperation::Save => u32::from(self.free_slot().is_none()),
            FlashOperation::Erase => 2,
        }
    }

    /// Erases the spare sector if no slot is free. For the start, when no host waits.
    ///
    /// # Errors
    /// [`FlashError::Failed`].
    pub fn ensure_free_slot(&mut self) -> Result<(), FlashError> {
        self.claim_slot().map(drop)
    }

    /// Saves a new image; the previous one stays where it is.
    ///
    /// # Errors
    /// [`FlashError::Failed`]: the previous image is still the newest.
    pub fn save<
        const SENSORS: usize,
        const NEURONS: usize,
        const SAMPLES: usize,
        B: Body<SENSORS>,
    >(
        &mut self,
        contents: &Contents<'_, SENSORS, NEURONS, SAMPLES, B>,
    ) -> Result<(), FlashError> {
        let slot = self.claim_slot()?;
        let (from, end) = (self.address(slot), self.address(slot) + self.slot_bytes);
        let generation = self.generation.wrapping_add(1);
        let (flash, mut at) = (&mut self.flash, from);
        contents.write(generation, &mut |bytes| {
            let next = at.saturating_add(bytes.len() as u32);
            if next > end {
                return Err(FlashError::Failed);
            }
            flash.write(at, bytes).map_err(failed)?;
            at = next;
            Ok(())
        })?;
        match self.check_slot(slot) {
            Ok(found) if found.generation == generation => {
                (self.newest, self.generation) = (Some(slot), generation);
                Ok(())
            }
            _ => Err(FlashError::Failed),
        }
    }

    /// Passes the newest image to `into`: a function that reads it, and its greatest length.
    ///
    /// # Errors
    /// [`FlashError`]: nothing is saved, or the image cannot be read.
    pub fn load<T>(
        &mut self,
        into: impl FnOnce(&mut dyn FnMut(usize, &mut [u8]) -> bool, usize) -> Result<T, ImageError>,
    ) -> Result<T, FlashError> {
        let slot = self.newest.ok_or(FlashError::Empty)?;
        let (from, most) = (self.address(slot), self.slot_bytes as usize);
        let flash = &mut self.flash;
        let mut read = |at: usize, out: &mut [u8]| flash.read(from + at as u32, out).is_ok();
        into(&mut read, most).map_err(|fault| match fault {
            ImageError::Source | ImageError::Torn => FlashError::Failed,
            ImageError::Version | ImageError::Dimensions => FlashError::OtherVersion,
        })
    }

    /// Erases both sectors, the one with the newest image last.
    ///
    /// # Errors
    /// [`FlashError::Failed`]: an image may be left.
    pub fn erase(&mut self) -> Result<(), FlashError> {
        let spare = self.spare();
        let erased = self.erase_sector(spare);
        let erased = erased.and_then(|()| self.erase_sector(1 - spare));
        self.find_newest();
        erased?;
        self.write_spare_mark()
    }

    /// The sector without the newest image.
    fn spare(&self) -> u32 {
        self.newest.map_or(0, |newest| 1 - newest.sector)
    }

    /// A free slot. Erases the spare sector if there is none.
    fn claim_slot(&mut self) -> Result<SlotLocation, FlashError> {
        if let Some(slot) = self.free_slot() {
            return Ok(slot);
        }
        let spare = self.spare();
        self.erase_sector(spare)?;
        self.write_spare_mark()?;
        self.free_slot().ok_or(FlashError::Failed)
    }

    /// Writes the mark of the spare sector, which has just been erased.
    fn write_spare_mark(&mut self) -> Result<(), FlashError> {
        let from = self.spare() * Self::SECTOR_BYTES;
        let written = self.flash.write(from, &erase_mark(self.generation));
        written.map_err(failed)
    }

    fn erase_sector(&mut self, sector: u32) -> Result<(), FlashError> {
        let from = sector * Self::SECTOR_BYTES;
        self.flash
            .erase(from, from + Self::SECTOR_BYTES)
            .map_err(failed)
    }

    /// The slot for the next image, if no erasure is needed.
    fn free_slot(&mut self) -> Option<SlotLocation> {
        let beside = self
            .newest
            .and_then(|newest| self.free_slot_in(newest.sector));
        beside.or_else(|| {
            let spare = self.spare();
            let ready = self.has_mark_of(spare, self.generation);
            ready.then(|| self.free_slot_in(spare)).flatten()
        })
    }

    /// The first slot behind all written ones.
    #[inline(never)]
    fn free_slot_in(&mut self, sector: u32) -> Option<SlotLocation> {
        let slots = (0..self.slots()).map(|slot| SlotLocation { sector, slot });
        let mut free_slot = None;
        for slot in slots.rev() {
            if !self.is_blank(slot) {
                break;
            }
            free_slot = Some(slot);
        }
        free_slot
    }

    /// Whether the sector's erasure was completed while this generation was the newest.
    fn has_mark_of(&mut self, sector: u32, generation: u32) -> bool {
        let mut found = [0; MARK_BYTES as usize];
        let from = sector * Self::SECTOR_BYTES;
        self.flash.read(from, &mut found).is_ok() && found == erase_mark(generation)
    }

    fn is_blank(&mut self, slot: SlotLocation) -> bool {
        let from = self.address(slot);
        let mut buffer = [0; 64];
        (0..self.slot_bytes).step_by(buffer.len()).all(|at| {
            let count = (self.slot_bytes - at).min(buffer.len() as u32) as usize;
            let piece = buffer.get_mut(..count).unwrap_or_default();
            self.flash.read(from + at, piece).is_ok() && piece.iter().all(|byte| *byte == 0xff)
        })
    }

    fn check_slot(&mut self, slot: SlotLocation) -> Result<ImageInfo, ImageError> {
        let from = self.address(slot);
        let flash = &mut self.flash;
        let mut read = |at: usize, out: &mut [u8]| flash.read(from + at as u32, out).is_ok();
        check(&mut read, self.slot_bytes as usize)
    }

    fn slots(&self) -> u32 {
        Self::SECTOR_BYTES
            .saturating_sub(MARK_BYTES)
            .checked_div(self.slot_bytes)
            .unwrap_or(0)
    }

    const fn address(&self, slot: SlotLocation) -> u32 {
        slot.sector * Self::SECTOR_BYTES + MARK_BYTES + slot.slot * self.slot_bytes
    }
}

fn failed<E>(_: E) -> FlashError {
    FlashError::Failed
}

/// The mark of a sector whose erasure was completed while this generation was the newest.
fn erase_mark(generation: u32) -> [u8; MARK_BYTES as usize] {
    let [g, h, i, j] = generation.to_le_bytes();
    let [m, n, o, p] = MARK_MAGIC;
    let text = [m, n, o, p, g, h, i, j];
    let [c, d, e, f] = checksum(&text).to_le_bytes();
    [m, n, o, p, g, h, i, j, c, d, e, f]
}

#[cfg(test)]
pub(crate) mod sim;
#[cfg(test)]
mod tests;
