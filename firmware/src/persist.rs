//! What outlives a loss of power: images of the mind (see [`amp::store`]) in two sectors of flash.
//!
//! ```text
//! sector = mark slot slot …        mark = "ERAS" generation crc, written when the sector has been erased
//! slot   = an image, or nothing, or what is left of an image that was never finished
//! ```
//!
//! A save writes the next generation's image into the next free slot of the sector that has the newest image, and when that
//! is full into the other one. An image counts only with its last word; until then the one before is the newest, and it lies
//! untouched where it lay. A sector is erased only when the newest image lies in the other one. So a loss of power at any
//! moment leaves the old image or the new one.
//!
//! Erasing stops the processor for seconds, so it is done at the start, before the hello ([`Store::tidy`]); a save has to
//! erase only when the device has filled a sector since. A sector whose erasure was cut short may read as erased and not be:
//! the mark says that it ended. It names the newest generation at that time, so that no mark that has survived another
//! erasure is taken for it.
//!
//! Cost: a slot's bytes of flash an image, 3 words for a mark; memory for one record. Starting reads both sectors once.

use amp::store::{Contents, ImageError, ImageInfo, WORD, check};
use amp::wire::checksum;
use amp::wire::message::{Flash, FlashError};
use core::convert::Infallible;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Bytes of a slot for the Nomad's mind.
pub const SLOT_BYTES: u32 = amp::store::MAX_NOMAD as u32;

/// Longest time to erase a sector of 128 KiB by words, milliseconds (STM32F405 data sheet DS8626, flash memory programming;
/// half of it is typical).
pub const ERASE_MS: u32 = 2_000;

/// Longest time to write an image by words, milliseconds: 100 µs a word (as above; 16 µs are typical).
pub const WRITE_MS: u32 = (SLOT_BYTES / WORD as u32).div_ceil(10);

/// Bytes of a mark.
const MARK_BYTES: u32 = 12;

/// How a mark begins.
const MARK: [u8; 4] = *b"ERAS";

/// The flash of a board that has none: no value of this type exists.
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

/// Where an image lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    sector: u32,
    slot: u32,
}

/// Two sectors of flash: the first two units that `F` erases.
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    slot_bytes: u32,
    newest: Option<Place>,
    /// The newest image's; 0 = there is none.
    generation: u32,
}

impl<F: NorFlash> Store<F> {
    const SECTOR_BYTES: u32 = F::ERASE_SIZE as u32;

    /// Looks for the newest image; writes nothing. Slots take `slot_bytes`, a multiple of four.
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
        store.look();
        store
    }

    /// The flash.
    #[cfg(test)]
    pub(crate) fn into_flash(self) -> F {
        self.flash
    }

    fn look(&mut self) {
        (self.newest, self.generation) = (None, 0);
        for sector in 0..2 {
            for slot in 0..self.slots() {
                let place = Place { sector, slot };
                if let Ok(found) = self.check(place)
                    && found.generation > self.generation
                {
                    (self.newest, self.generation) = (Some(place), found.generation);
                }
            }
        }
    }

    /// Generation of the newest image; 0 = nothing was saved.
    #[must_use]
    pub const fn generation(&self) -> u32 {
        self.generation
    }

    /// Longest time this will take and nothing else can be done, milliseconds; with an erasure if it needs one.
    pub fn pause_ms(&mut self, task: Flash) -> u32 {
        match task {
            Flash::Recall => 0,
            Flash::Save => WRITE_MS + self.erasures(task) * ERASE_MS,
            Flash::Erase => self.erasures(task) * ERASE_MS,
        }
    }

    /// How many sectors this will erase.
    fn erasures(&mut self, task: Flash) -> u32 {
        match task {
            Flash::Recall => 0,
            Flash::Save => u32::from(self.free().is_none()),
            Flash::Erase => 2,
        }
    }

    /// Erases the spare sector if the next image has no room; for the start, when nobody waits.
    ///
    /// # Errors
    /// [`FlashError::Failed`].
    pub fn tidy(&mut self) -> Result<(), FlashError> {
        self.make_room().map(drop)
    }

    /// Saves; the newest image until now stays where it is.
    ///
    /// # Errors
    /// [`FlashError::Failed`]; what was saved before still is.
    pub fn save<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>(
        &mut self,
        contents: &Contents<'_, SENSORS, NEURONS, SAMPLES>,
    ) -> Result<(), FlashError> {
        let place = self.make_room()?;
        let (from, end) = (self.address(place), self.address(place) + self.slot_bytes);
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
        match self.check(place) {
            Ok(found) if found.generation == generation => {
                (self.newest, self.generation) = (Some(place), generation);
                Ok(())
            }
            _ => Err(FlashError::Failed),
        }
    }

    /// Hands the newest image to `into`: how to read it, and its most bytes.
    ///
    /// # Errors
    /// [`FlashError`]: nothing was saved, or it cannot be read.
    pub fn recall<T>(
        &mut self,
        into: impl FnOnce(&mut dyn FnMut(usize, &mut [u8]) -> bool, usize) -> Result<T, ImageError>,
    ) -> Result<T, FlashError> {
        let place = self.newest.ok_or(FlashError::Empty)?;
        let (from, most) = (self.address(place), self.slot_bytes as usize);
        let flash = &mut self.flash;
        let mut read = |at: usize, out: &mut [u8]| flash.read(from + at as u32, out).is_ok();
        into(&mut read, most).map_err(|fault| match fault {
            ImageError::Source | ImageError::Torn => FlashError::Failed,
            ImageError::Version | ImageError::Dimensions => FlashError::Unreadable,
        })
    }

    /// Erases everything, the newest image last.
    ///
    /// # Errors
    /// [`FlashError::Failed`]; something may still be there.
    pub fn erase(&mut self) -> Result<(), FlashError> {
        let spare = self.spare();
        let erased = self.erase_sector(spare);
        let erased = erased.and_then(|()| self.erase_sector(1 - spare));
        self.look();
        erased?;
        self.mark_spare()
    }

    /// The sector that does not have the newest image.
    fn spare(&self) -> u32 {
        self.newest.map_or(0, |newest| 1 - newest.sector)
    }

    /// A free slot, after erasing the spare sector if there is none.
    fn make_room(&mut self) -> Result<Place, FlashError> {
        if let Some(place) = self.free() {
            return Ok(place);
        }
        let spare = self.spare();
        self.erase_sector(spare)?;
        self.mark_spare()?;
        self.free().ok_or(FlashError::Failed)
    }

    /// Notes that the spare sector has been erased to the end.
    fn mark_spare(&mut self) -> Result<(), FlashError> {
        let from = self.spare() * Self::SECTOR_BYTES;
        let written = self.flash.write(from, &mark(self.generation));
        written.map_err(failed)
    }

    fn erase_sector(&mut self, sector: u32) -> Result<(), FlashError> {
        let from = sector * Self::SECTOR_BYTES;
        self.flash
            .erase(from, from + Self::SECTOR_BYTES)
            .map_err(failed)
    }

    /// Where the next image goes without erasing anything.
    fn free(&mut self) -> Option<Place> {
        let beside = self.newest.and_then(|newest| self.free_in(newest.sector));
        beside.or_else(|| {
            let spare = self.spare();
            let ready = self.is_erased_for(spare, self.generation);
            ready.then(|| self.free_in(spare)).flatten()
        })
    }

    /// The first slot behind everything that has been written to a sector.
    #[inline(never)]
    fn free_in(&mut self, sector: u32) -> Option<Place> {
        let places = (0..self.slots()).map(|slot| Place { sector, slot });
        let mut free = None;
        for place in places.rev() {
            if !self.is_blank(place) {
                break;
            }
            free = Some(place);
        }
        free
    }

    /// Whether a sector was erased to the end when this generation was the newest.
    fn is_erased_for(&mut self, sector: u32, generation: u32) -> bool {
        let mut found = [0; MARK_BYTES as usize];
        let from = sector * Self::SECTOR_BYTES;
        self.flash.read(from, &mut found).is_ok() && found == mark(generation)
    }

    fn is_blank(&mut self, place: Place) -> bool {
        let from = self.address(place);
        let mut buffer = [0; 64];
        (0..self.slot_bytes).step_by(buffer.len()).all(|at| {
            let count = (self.slot_bytes - at).min(buffer.len() as u32) as usize;
            let piece = buffer.get_mut(..count).unwrap_or_default();
            self.flash.read(from + at, piece).is_ok() && piece.iter().all(|byte| *byte == 0xff)
        })
    }

    fn check(&mut self, place: Place) -> Result<ImageInfo, ImageError> {
        let from = self.address(place);
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

    const fn address(&self, place: Place) -> u32 {
        place.sector * Self::SECTOR_BYTES + MARK_BYTES + place.slot * self.slot_bytes
    }
}

fn failed<E>(_: E) -> FlashError {
    FlashError::Failed
}

/// Says that the sector was erased to the end when this generation was the newest.
fn mark(generation: u32) -> [u8; MARK_BYTES as usize] {
    let [g, h, i, j] = generation.to_le_bytes();
    let [m, n, o, p] = MARK;
    let text = [m, n, o, p, g, h, i, j];
    let [c, d, e, f] = checksum(&text).to_le_bytes();
    [m, n, o, p, g, h, i, j, c, d, e, f]
}

#[cfg(test)]
pub(crate) mod sim;
#[cfg(test)]
mod tests;
