//! Simulated flash, stricter than the chip's, that loses power on request.
//!
//! It panics when a word is written that is not blank, was written before or was partly erased,
//! and at an unaligned address. At a loss of power the word or sector in progress keeps any
//! mixture of old and new bits.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::vec::Vec;

const WORD: usize = 4;
const ERASED: u32 = u32::MAX;

/// What has happened to a word since its erasure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WordHistory {
    Erased,
    Written,
    TornWrite,
    TornErase,
}

/// The power is off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NoPower;

impl NorFlashError for NoPower {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Two sectors of `SECTOR` bytes.
#[derive(Debug, Clone)]
pub struct SimFlash<const SECTOR: usize> {
    words: Vec<(u32, WordHistory)>,
    rng: Xoshiro128PlusPlus,
    /// Operations until the power is lost; a word written or a sector erased is one.
    operations_left: Option<u32>,
    has_power: bool,
    /// Operations so far.
    pub writes: u32,
    /// Erasures so far, by sector.
    pub erasures: [u32; 2],
}

impl<const SECTOR: usize> SimFlash<SECTOR> {
    /// Flash with random content.
    pub fn new(seed: u64) -> Self {
        let mut rng = Xoshiro128PlusPlus::seed_from_u64(seed);
        let word = |_| (rng.next_u32(), WordHistory::Written);
        Self {
            words: (0..2 * SECTOR / WORD).map(word).collect(),
            rng,
            operations_left: None,
            has_power: true,
            writes: 0,
            erasures: [0; 2],
        }
    }

    /// Loses power during the next operation after `operations` of them.
    pub fn cut_after(&mut self, operations: u32) {
        self.operations_left = Some(operations);
    }

    /// Switches the power on.
    pub fn power_on(&mut self) {
        (self.has_power, self.operations_left) = (true, None);
    }

    /// Whether the power is on.
    pub fn has_power(&self) -> bool {
        self.has_power
    }

    /// A random number below `bound`.
    pub fn below(&mut self, bound: u32) -> u32 {
        ((u64::from(self.rng.next_u32()) * u64::from(bound)) >> 32) as u32
    }

    /// Counts an operation; returns whether the power is lost during it.
    fn is_cut(&mut self) -> bool {
        self.writes += 1;
        match &mut self.operations_left {
            Some(0) => self.has_power = false,
            Some(operations_left) => *operations_left -= 1,
            None => {}
        }
        !self.has_power
    }

    fn write_word(&mut self, index: usize, new: u32) -> Result<(), NoPower> {
        let (old, past) = self.words[index];
        assert!(
            old == ERASED && matches!(past, WordHistory::Erased | WordHistory::TornWrite),
            "word {index:#x}: {new:#010x} over {old:#010x}, {past:?}"
        );
        if self.is_cut() {
            let torn = match self.below(4) {
                0 => new,
                1 => old,
                _ => new | self.rng.next_u32(),
            };
            self.words[index] = (torn, WordHistory::TornWrite);
            return Err(NoPower);
        }
        self.words[index] = (new, WordHistory::Written);
        Ok(())
    }
}

impl<const SECTOR: usize> ErrorType for SimFlash<SECTOR> {
    type Error = NoPower;
}

impl<const SECTOR: usize> ReadNorFlash for SimFlash<SECTOR> {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NoPower> {
        let offset = offset as usize;
        assert!(offset.is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD));
        if !self.has_power {
            return Err(NoPower);
        }
        let words = &self.words[offset / WORD..][..bytes.len() / WORD];
        for (out, (word, _)) in bytes.chunks_exact_mut(WORD).zip(words) {
            out.copy_from_slice(&word.to_le_bytes());
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        2 * SECTOR
    }
}

impl<const SECTOR: usize> NorFlash for SimFlash<SECTOR> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), NoPower> {
        let (from, to) = (from as usize, to as usize);
        assert!(from.is_multiple_of(SECTOR) && to == from + SECTOR);
        if !self.has_power {
            return Err(NoPower);
        }
        let cut = self.is_cut();
        let kind = self.below(4);
        self.erasures[from / SECTOR] += 1;
        for index in from / WORD..to / WORD {
            let old = self.words[index].0;
            self.words[index] = match (cut, kind) {
                (false, _) => (ERASED, WordHistory::Erased),
                // Reads as blank, but is only partly erased.
                (true, 0) => (ERASED, WordHistory::TornErase),
                (true, 1) => (old, WordHistory::TornErase),
                (true, 2) if self.below(8) > 0 => (ERASED, WordHistory::TornErase),
                (true, _) => (old | self.rng.next_u32(), WordHistory::TornErase),
            };
        }
        if cut { Err(NoPower) } else { Ok(()) }
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NoPower> {
        let offset = offset as usize;
        assert!(offset.is_multiple_of(WORD) && bytes.len().is_multiple_of(WORD));
        if !self.has_power {
            return Err(NoPower);
        }
        for (index, word) in (offset / WORD..).zip(bytes.chunks_exact(WORD)) {
            self.write_word(
                index,
                u32::from_le_bytes(*word.first_chunk().expect("a word")),
            )?;
        }
        Ok(())
    }
}
