//! The lazy memory: samples of situation, move and next situation, stored as they were.
//!
//! Situations are kept as bytes: 0 … 254 is the way from the far to the near limit, 255 a disabled
//! transducer. A sample of a 16-sonar ring takes 40 bytes, a hundred of them 4 kB.

use crate::fixed::{Mask, ONE_BITS, Weight};
use crate::scan::Situation;
use crate::units::Displacement;
use heapless::Vec;

/// A situation as bytes.
pub type SituationBytes<const SENSORS: usize> = [u8; SENSORS];

/// The byte of 1.0.
const NEAR: u32 = 254;
/// 1.0 as bits of a weight.
const ONE: u32 = ONE_BITS.unsigned_abs() as u32;
/// The byte of a disabled transducer.
pub(crate) const UNKNOWN: u8 = 255;

/// The value of each byte, the nearest to its share; the last one's is 0. A table, because learning
/// reads a million of them.
static VALUES: [Weight; 256] = {
    let mut values = [Weight::ZERO; 256];
    let mut byte = 0;
    while byte < UNKNOWN as usize {
        let bits = (byte as u32 * ONE + NEAR / 2) / NEAR;
        values[byte] = Weight::from_bits(bits as i16);
        byte += 1;
    }
    values
};

/// The nearest byte to each value of an enabled transducer.
#[must_use]
pub fn to_bytes<const SENSORS: usize>(
    situation: &Situation<SENSORS>,
    believed: Mask,
) -> SituationBytes<SENSORS> {
    let mut bytes = [UNKNOWN; SENSORS];
    for (index, (byte, value)) in bytes.iter_mut().zip(situation).enumerate() {
        if believed.contains(index) {
            let bits = u32::from(value.to_bits().max(0).unsigned_abs()).min(ONE);
            *byte = ((bits * NEAR + ONE / 2) >> 13) as u8;
        }
    }
    bytes
}

/// The values of a situation stored as bytes, and which transducers were enabled; the others'
/// values are 0.
#[must_use]
pub fn from_bytes<const SENSORS: usize>(
    bytes: &SituationBytes<SENSORS>,
) -> (Situation<SENSORS>, Mask) {
    let mut believed = Mask::ALL;
    let mut situation = [Weight::ZERO; SENSORS];
    for (index, (value, &byte)) in situation.iter_mut().zip(bytes).enumerate() {
        *value = value_of(byte);
        if byte == UNKNOWN {
            believed = believed.without(index);
        }
    }
    (situation, believed)
}

/// The value of a byte; 0 for a disabled transducer.
fn value_of(byte: u8) -> Weight {
    VALUES.get(usize::from(byte)).copied().unwrap_or_default()
}

/// A sample's situations turned by ring places: writes the values after and their change; returns
/// the transducers enabled both times. Without `gaps` these are all.
pub(crate) fn turned_change<const SENSORS: usize>(
    Sample { before, after, .. }: &Sample<SENSORS>,
    places: usize,
    gaps: bool,
    values: &mut Situation<SENSORS>,
    changes: &mut Situation<SENSORS>,
) -> Mask {
    // Twice in a row: turned ones lie in one piece, and no place needs a remainder.
    let (twice_before, twice_after) = ([*before; 2], [*after; 2]);
    let back = SENSORS.wrapping_sub(places.checked_rem(SENSORS).unwrap_or(0));
    let turned_before = turned(&twice_before, back).unwrap_or(before);
    let turned_after = turned(&twice_after, back).unwrap_or(after);
    let turned = turned_before.iter().zip(turned_after);
    for ((value, change), (before, after)) in values.iter_mut().zip(changes).zip(turned.clone()) {
        *value = value_of(*after);
        // Both lie in [0, 1].
        *change = value.wrapping_sub(value_of(*before));
    }
    let mut believed = Mask::ALL;
    if gaps {
        for (place, (before, after)) in turned.enumerate() {
            if *before == UNKNOWN || *after == UNKNOWN {
                believed = believed.without(place);
            }
        }
    }
    believed
}

fn turned<const SENSORS: usize>(
    twice: &[SituationBytes<SENSORS>; 2],
    from: usize,
) -> Option<&SituationBytes<SENSORS>> {
    twice.as_flattened().get(from..)?.first_chunk()
}

/// One random move: (S, a, S').
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sample<const SENSORS: usize> {
    /// Situation before the move.
    pub before: SituationBytes<SENSORS>,
    /// Situation after it.
    pub after: SituationBytes<SENSORS>,
    /// The commanded displacement, in the ring's frame before the move.
    pub commanded: Displacement,
    /// The executed displacement, in the same frame.
    pub executed: Displacement,
}

/// Samples in the order they came; a full memory takes no more.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Memory<const SENSORS: usize, const SAMPLES: usize> {
    samples: Vec<Sample<SENSORS>, SAMPLES>,
    /// A transducer was disabled in one of them. Cached, because learning asks 10 000 times.
    gaps: bool,
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
    /// An empty memory.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            samples: Vec::new(),
            gaps: false,
        }
    }

    /// Stores a sample.
    ///
    /// # Errors
    /// [`Full`] when there is no room; the memory is unchanged.
    pub fn keep(&mut self, sample: Sample<SENSORS>) -> Result<(), Full> {
        let gaps = sample.before.contains(&UNKNOWN) || sample.after.contains(&UNKNOWN);
        self.samples.push(sample).map_err(|_| Full)?;
        self.gaps |= gaps;
        Ok(())
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.samples.clear();
        self.gaps = false;
    }

    /// Whether a transducer was disabled in one of the samples.
    pub(crate) const fn has_gaps(&self) -> bool {
        self.gaps
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
        let all: [u8; 255] = core::array::from_fn(|i| i as u8);
        let (values, believed) = from_bytes(&all);
        assert_eq!(to_bytes(&values, believed), all);
        assert_eq!(from_bytes(&[0, 254]).0, [Weight::ZERO, Weight::ONE]);
    }

    #[test]
    fn what_was_not_believed_stays_unknown() {
        let believed = Mask::ALL.without(1);
        let bytes = to_bytes(&[Weight::ONE, Weight::ONE], believed);
        assert_eq!(from_bytes(&bytes), ([Weight::ONE, Weight::ZERO], believed));
    }

    #[test]
    fn a_value_becomes_the_nearest_byte_and_a_byte_the_nearest_value() {
        for bits in (-3_i16..=8_195).step_by(if cfg!(miri) { 97 } else { 1 }) {
            let share = f64::from(bits.clamp(0, 8_192)) / 8_192.0 * 254.0;
            let [byte] = to_bytes(&[Weight::from_bits(bits)], Mask::ALL);
            assert!((f64::from(byte) - share).abs() <= 0.5, "{bits}: {byte}");
        }
        for byte in 0..UNKNOWN {
            let exact = f64::from(byte) / 254.0 * 8_192.0;
            let bits = f64::from(value_of(byte).to_bits());
            assert!((bits - exact).abs() <= 0.5, "{byte}: {bits}");
        }
        assert_eq!(value_of(UNKNOWN), Weight::ZERO);
    }

    #[test]
    fn a_change_turns_with_the_ring_and_counts_where_both_were_believed() {
        let (before, after) = ([0, 254, 254, UNKNOWN, 127], [254, 254, 0, 254, UNKNOWN]);
        let sample = |before, after| Sample {
            before,
            after,
            commanded: Displacement::ZERO,
            executed: Displacement::ZERO,
        };
        let one = f64::from;
        for places in 0..12 {
            let (mut values, mut changes) = ([Weight::ONE; 5], [Weight::ONE; 5]);
            let mask = turned_change(
                &sample(before, after),
                places,
                true,
                &mut values,
                &mut changes,
            );
            let at = |place: usize| (place + places) % 5;
            let found = |row: &[Weight; 5], place: usize| row[at(place)].to_num::<f64>();
            for (place, value, change) in [(0, 1, 1), (1, 1, 0), (2, 0, -1)] {
                assert_eq!(
                    (found(&values, place), found(&changes, place)),
                    (one(value), one(change))
                );
            }
            assert_eq!(mask, Mask::ALL.without(at(3)).without(at(4)), "{places}");
        }
        let (mut values, mut changes) = ([Weight::ONE; 5], [Weight::ONE; 5]);
        assert_eq!(
            turned_change(&sample([1; 5], [2; 5]), 3, true, &mut values, &mut changes),
            Mask::ALL
        );
    }

    #[test]
    fn what_was_unknown_once_is_found_wherever_it_is_turned() {
        let mut sample = Sample {
            before: [10, 20, 30, 40],
            after: [50, 60, 70, 80],
            commanded: Displacement::ZERO,
            executed: Displacement::ZERO,
        };
        let mut memory = Memory::<4, 2>::new();
        assert_eq!(memory.keep(sample), Ok(()));
        assert!(!memory.has_gaps());
        sample.before[1] = UNKNOWN;
        sample.after[3] = UNKNOWN;
        assert_eq!(memory.keep(sample), Ok(()));
        assert!(memory.has_gaps());
        for places in 0..4 {
            let (mut values, mut changes) = ([Weight::ONE; 4], [Weight::ONE; 4]);
            let believed = turned_change(&sample, places, true, &mut values, &mut changes);
            let unknown = |place: usize| (place + places) % 4;
            let two = Mask::ALL.without(unknown(1)).without(unknown(3));
            assert_eq!(believed, two, "{places}");
            let turned = crate::scan::rotated(&[50, 60, 70, 0], places);
            let expected = turned.map(|byte| {
                if byte == 0 {
                    Weight::ZERO
                } else {
                    value_of(byte)
                }
            });
            assert_eq!(values, expected, "{places}");
            let change = value_of(50).wrapping_sub(value_of(10));
            assert_eq!(changes[unknown(0)], change, "{places}");
        }
        memory.clear();
        assert!(!memory.has_gaps());
    }

    #[test]
    fn one_gap_in_one_sample_is_remembered() {
        let whole = Sample {
            before: [10, 20],
            after: [50, 60],
            commanded: Displacement::ZERO,
            executed: Displacement::ZERO,
        };
        let gap = [UNKNOWN, 20];
        let (before, after) = (
            Sample {
                before: gap,
                ..whole
            },
            Sample {
                after: gap,
                ..whole
            },
        );
        for samples in [[before, whole, whole], [whole, after, before]] {
            let mut memory = Memory::<2, 3>::new();
            let mut gaps = false;
            for sample in samples {
                gaps |= sample != whole;
                assert_eq!(memory.keep(sample), Ok(()));
                assert_eq!(memory.has_gaps(), gaps);
            }
        }
    }

    #[test]
    fn a_full_memory_refuses_and_stays() {
        let sample = Sample {
            before: [1; 2],
            after: [2; 2],
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
        assert_eq!(std::format!("{Full}"), "the memory is full");
        memory.clear();
        assert!(memory.samples().is_empty());
    }
}
