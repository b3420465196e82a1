//! The lazy memory: what the robot saw, did and saw then, kept as it was for whatever is to be learnt from it.
//!
//! Situations are kept as bytes (1/255 of the way from the far to the near limit): a sample of a 16-sonar ring takes
//! 44 bytes, a hundred of them 4.4 kB.

use crate::fixed::{Mask, ONE_BITS, Weight};
use crate::scan::Situation;
use crate::units::Displacement;
use heapless::Vec;

/// A situation as bytes.
pub type SituationBytes<const SENSORS: usize> = [u8; SENSORS];

/// The nearest byte to each value.
#[must_use]
pub fn to_bytes<const SENSORS: usize>(situation: &Situation<SENSORS>) -> SituationBytes<SENSORS> {
    situation.map(|w| {
        let bits = i32::from(w.to_bits()).clamp(0, i32::from(ONE_BITS));
        ((bits * 255 + i32::from(ONE_BITS) / 2) >> 13) as u8
    })
}

/// The values of a situation kept as bytes.
#[must_use]
pub fn from_bytes<const SENSORS: usize>(bytes: &SituationBytes<SENSORS>) -> Situation<SENSORS> {
    bytes
        .map(|byte| Weight::from_bits(((i32::from(byte) * i32::from(ONE_BITS) + 127) / 255) as i16))
}

/// One random move: (S, a, S').
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample<const SENSORS: usize> {
    /// Situation before the move.
    pub before: SituationBytes<SENSORS>,
    /// Situation after it.
    pub after: SituationBytes<SENSORS>,
    /// Transducers believed both times.
    pub mask: Mask,
    /// What the mind asked for, in the ring's frame before the move.
    pub commanded: Displacement,
    /// What the base carried out, in the same frame.
    pub executed: Displacement,
}

/// Samples in the order they came; a full memory takes no more.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Memory<const SENSORS: usize, const SAMPLES: usize> {
    samples: Vec<Sample<SENSORS>, SAMPLES>,
}

/// The memory holds as many samples as it can.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full;

impl core::fmt::Display for Full {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("the memory is full")
    }
}

impl core::error::Error for Full {}

impl<const SENSORS: usize, const SAMPLES: usize> Memory<SENSORS, SAMPLES> {
    /// Keeps a sample.
    ///
    /// # Errors
    /// [`Full`] when there is no room; the memory is unchanged.
    pub fn keep(&mut self, sample: Sample<SENSORS>) -> Result<(), Full> {
        self.samples.push(sample).map_err(|_| Full)
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// The samples in the order they came.
    #[must_use]
    pub fn samples(&self) -> &[Sample<SENSORS>] {
        &self.samples
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_keep_both_ends_and_every_byte() {
        let all: [u8; 256] = core::array::from_fn(|i| i as u8);
        assert_eq!(to_bytes(&from_bytes(&all)), all);
        assert_eq!(from_bytes(&[0, 255]), [Weight::ZERO, Weight::ONE]);
    }

    #[test]
    fn a_full_memory_refuses_and_stays() {
        let sample = Sample {
            before: [1; 2],
            after: [2; 2],
            mask: Mask::ALL,
            commanded: Displacement::ZERO,
            executed: Displacement::ZERO,
        };
        let mut memory = Memory::<2, 1>::default();
        assert_eq!(memory.keep(sample), Ok(()));
        assert_eq!(
            memory.keep(Sample {
                before: [9; 2],
                ..sample
            }),
            Err(Full)
        );
        assert_eq!(memory.samples(), [sample]);
        memory.clear();
        assert!(memory.samples().is_empty());
    }
}
