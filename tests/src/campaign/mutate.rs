//! Kinds of damage to a frame.

use super::below;
use rand_core::Rng as _;
use rand_xoshiro::Xoshiro256PlusPlus;

/// A kind of damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameDamage {
    /// 1 to 3 bits flipped.
    FewBits,
    /// 4 to 8 bits flipped.
    ManyBits,
    /// 2 to 8 neighboring bytes replaced by noise.
    Burst,
    /// A part is missing: start, middle or end.
    Cut,
    /// A part is duplicated.
    Repeated,
    /// Two parts of equal length are swapped.
    Swapped,
    /// The start of one frame and the end of another.
    Spliced,
    /// Only noise.
    Noise,
}

impl FrameDamage {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::FewBits,
        Self::ManyBits,
        Self::Burst,
        Self::Cut,
        Self::Repeated,
        Self::Swapped,
        Self::Spliced,
        Self::Noise,
    ];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::FewBits => "1 to 3 bits flipped",
            Self::ManyBits => "4 to 8 bits flipped",
            Self::Burst => "2 to 8 bytes of noise in it",
            Self::Cut => "a part missing",
            Self::Repeated => "a part duplicated",
            Self::Swapped => "two parts swapped",
            Self::Spliced => "start of one, end of another",
            Self::Noise => "only noise",
        }
    }

    /// Damages a frame, given without its delimiter and at least two bytes long. The result may
    /// equal the original.
    pub fn inflict(self, frame: &mut Vec<u8>, other: &[u8], random: &mut Xoshiro256PlusPlus) {
        match self {
            Self::FewBits => flip(frame, 1, 3, random),
            Self::ManyBits => flip(frame, 4, 8, random),
            Self::Burst => {
                let (start, end) = piece(frame.len(), 8, random);
                noise(frame.get_mut(start..end).unwrap_or_default(), random);
            }
            Self::Cut => {
                let (start, end) = piece(frame.len(), frame.len(), random);
                frame.drain(start..end);
            }
            Self::Repeated => {
                let (start, end) = piece(frame.len(), 8, random);
                frame.extend_from_within(start..end);
                if let Some(behind) = frame.get_mut(end..) {
                    behind.rotate_right(end - start);
                }
            }
            Self::Swapped => {
                let length = 1 + below(random, (frame.len() / 2).min(8));
                let start = below(random, frame.len() - 2 * length + 1);
                let other = start + length + below(random, frame.len() - 2 * length - start + 1);
                for step in 0..length {
                    frame.swap(start + step, other + step);
                }
            }
            Self::Spliced => {
                frame.truncate(below(random, frame.len() + 1));
                frame.extend_from_slice(other.get(below(random, other.len())..).unwrap_or(other));
            }
            Self::Noise => noise(frame, random),
        }
    }
}

/// Flips `least` to `most` bits; the same bit may be flipped twice.
fn flip(frame: &mut [u8], least: usize, most: usize, random: &mut Xoshiro256PlusPlus) {
    for _ in 0..least + below(random, most - least + 1) {
        let bit = below(random, 8 * frame.len());
        if let Some(byte) = frame.get_mut(bit / 8) {
            *byte ^= 1 << (bit % 8);
        }
    }
}

fn noise(bytes: &mut [u8], random: &mut Xoshiro256PlusPlus) {
    for byte in bytes {
        *byte = (random.next_u64() >> 56) as u8;
    }
}

/// Ends of a part of 1 to `most` bytes of `length`.
fn piece(length: usize, most: usize, random: &mut Xoshiro256PlusPlus) -> (usize, usize) {
    let size = 1 + below(random, most.min(length));
    let start = below(random, length - size + 1);
    (start, start + size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::generator;

    #[test]
    fn every_damage_does_what_its_name_says() {
        let mut random = generator(1, 0);
        let whole: Vec<u8> = (1..=20).collect();
        let other: Vec<u8> = (101..=110).collect();
        for damage in FrameDamage::ALL {
            let mut damaged = 0;
            for _ in 0..200 {
                let mut frame = whole.clone();
                damage.inflict(&mut frame, &other, &mut random);
                damaged += u32::from(frame != whole);
                let length = frame.len();
                match damage {
                    FrameDamage::Cut => assert!(length < 20),
                    FrameDamage::Repeated => assert!((21..=28).contains(&length)),
                    FrameDamage::Swapped => {
                        frame.sort_unstable();
                        assert_eq!(frame, whole);
                    }
                    FrameDamage::Spliced => assert!((1..=30).contains(&length)),
                    _ => assert_eq!(length, 20),
                }
            }
            assert!(damaged > 150, "{damage:?}: {damaged}");
        }
        // The shortest possible frame.
        for damage in FrameDamage::ALL {
            damage.inflict(&mut vec![1, 2], &[3], &mut random);
        }
    }
}
