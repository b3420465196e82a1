//! Patterns of bits, and situations coded into them.

use crate::fixed::{ONE_BITS, Weight};

/// An element of a sequence: `N` bits as signs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pattern<const N: usize>([i8; N]);

impl<const N: usize> Pattern<N> {
    /// From its bits.
    #[must_use]
    pub fn from_bits(bits: [bool; N]) -> Self {
        Self(bits.map(|bit| if bit { 1 } else { -1 }))
    }

    /// Its bits.
    #[must_use]
    pub fn bits(&self) -> [bool; N] {
        self.0.map(|sign| sign > 0)
    }

    /// A situation in a thermometer code: each of the `SENSORS` values in [0, 1] has
    /// `N / SENSORS` bits, of which the first so many are set as the value has steps, rounded to
    /// the nearest, half a step down. Bits that are left over are not set.
    ///
    /// ```
    /// use amp::fixed::Weight;
    /// use amp::sequence::Pattern;
    ///
    /// let situation = [0.0, 0.3, 0.5, 1.0].map(Weight::from_num::<f64>);
    /// let pattern = Pattern::<16>::of_situation(&situation);
    /// let bits = pattern.bits().map(u8::from);
    /// assert_eq!(bits, [0, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 1, 1, 1, 1]);
    /// assert_eq!(pattern.situation::<4>()[1], Weight::from_num(0.25));
    /// ```
    #[must_use]
    pub fn of_situation<const SENSORS: usize>(situation: &[Weight; SENSORS]) -> Self {
        let steps = steps(N, SENSORS);
        let mut signs = [-1; N];
        for (bits, value) in signs.chunks_exact_mut(steps.max(1)).zip(situation) {
            let twice = i64::from(value.to_bits())
                .wrapping_mul(int(steps))
                .wrapping_mul(2);
            for (step, sign) in bits.iter_mut().enumerate() {
                let middle = int(step).wrapping_mul(2).wrapping_add(1);
                if twice > middle.wrapping_mul(i64::from(ONE_BITS)) {
                    *sign = 1;
                }
            }
        }
        Self(signs)
    }

    /// The situation of a thermometer code: each value is the share of its bits that are set, in
    /// units of 2⁻¹³, rounded down.
    #[must_use]
    pub fn situation<const SENSORS: usize>(&self) -> [Weight; SENSORS] {
        let steps = steps(N, SENSORS).max(1);
        let mut situation = [Weight::ZERO; SENSORS];
        for (value, bits) in situation.iter_mut().zip(self.0.chunks_exact(steps)) {
            let set = bits.iter().filter(|sign| **sign > 0).count();
            let bits = int(set).wrapping_mul(i64::from(ONE_BITS));
            let share = bits.checked_div(int(steps)).unwrap_or(0);
            *value = Weight::from_bits(i16::try_from(share).unwrap_or(ONE_BITS));
        }
        situation
    }

    /// Number of bits that differ.
    #[must_use]
    pub fn distance(&self, other: &Self) -> usize {
        let pairs = self.0.iter().zip(&other.0);
        pairs.filter(|(one, other)| one != other).count()
    }

    /// Turns a bit around; one that does not exist is ignored.
    pub fn flip(&mut self, index: usize) {
        if let Some(sign) = self.0.get_mut(index) {
            *sign = sign.wrapping_neg();
        }
    }

    pub(super) const fn signs(&self) -> &[i8; N] {
        &self.0
    }

    /// The bit gets the sign of its field; 0 leaves it. Returns whether it changed.
    pub(super) fn set(&mut self, index: usize, field: i32) -> bool {
        let Some(sign) = self.0.get_mut(index) else {
            return false;
        };
        let before = *sign;
        match field.signum() {
            1 => *sign = 1,
            -1 => *sign = -1,
            _ => {}
        }
        *sign != before
    }
}

/// Bits of each value.
fn steps(bits: usize, sensors: usize) -> usize {
    bits.checked_div(sensors).unwrap_or(0)
}

fn int(number: usize) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}
