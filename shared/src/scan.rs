//! From echoes to a situation: ranges with age and validity, and their encoding as values in [0,
//! 1].
//!
//! A *situation* is what the paper's maps know: one value per transducer, 1.0 for an obstacle at
//! the near limit or nearer, 0.0 for none within the far limit (Fig. 2 of the paper), linear in
//! between. A transducer without an echo hears nothing and reads 0.0; one that is masked out does
//! not count at all.

use crate::fixed::{Mask, ONE_BITS, Weight};
use crate::units::{Millis, Range};
use serde::{Deserialize, Serialize};

/// A situation: one value in [0, 1] per transducer.
pub type Situation<const SENSORS: usize> = [Weight; SENSORS];

/// A situation aligned to words: the chip copies it by words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(4))]
pub(crate) struct Aligned<const SENSORS: usize>(pub(crate) Situation<SENSORS>);

/// The latest echo of one transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Echo {
    /// Range heard; `None` when nothing answered.
    pub range: Option<Range>,
    /// When it was heard.
    pub at: Millis,
}

/// The latest echo of every transducer, and which of them came since the last decision.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scan<const SENSORS: usize> {
    echoes: [Echo; SENSORS],
    fresh: u32,
    ever: u32,
}

impl<const SENSORS: usize> Default for Scan<SENSORS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const SENSORS: usize> Scan<SENSORS> {
    /// Nothing heard yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            echoes: [Echo {
                range: None,
                at: Millis::from_ms(0),
            }; SENSORS],
            fresh: 0,
            ever: 0,
        }
    }

    /// Takes an echo; one of a transducer that does not exist is ignored.
    pub fn hear(&mut self, sensor: usize, echo: Echo) {
        if let Some(place) = self.echoes.get_mut(sensor) {
            *place = echo;
            self.fresh |= 1_u32.wrapping_shl(sensor as u32);
            self.ever |= self.fresh;
        }
    }

    /// Begins a new ring: every transducer has to be heard again.
    pub fn renew(&mut self) {
        self.fresh = 0;
    }

    /// When a transducer was heard last, if it was since the last [`renew`](Self::renew).
    #[must_use]
    pub fn heard_at(&self, sensor: usize) -> Option<Millis> {
        let echo = self.echoes.get(sensor)?;
        (self.fresh & 1_u32.wrapping_shl(sensor as u32) != 0).then_some(echo.at)
    }

    /// Whether every enabled transducer has been heard since the last [`renew`](Self::renew).
    #[must_use]
    pub fn is_complete(&self, believed: Mask) -> bool {
        Mask::from_bits(self.fresh | !believed.to_bits()).covers(SENSORS)
    }

    /// Whether every enabled transducer has ever been heard.
    #[must_use]
    pub fn has_heard_all(&self, believed: Mask) -> bool {
        Mask::from_bits(self.ever | !believed.to_bits()).covers(SENSORS)
    }

    /// The echoes by transducer.
    #[must_use]
    pub const fn echoes(&self) -> &[Echo; SENSORS] {
        &self.echoes
    }
}

/// How a range becomes a value of the situation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Encoding {
    /// At this range and nearer the value is 1, millimeters.
    pub near_mm: u16,
    /// From this range on the value is 0, millimeters; above `near_mm`.
    pub far_mm: u16,
}

impl Encoding {
    /// The value of one range, rounded down to 2⁻¹³.
    #[must_use]
    pub fn value(self, range: Option<Range>) -> Weight {
        Self::value_within(u32::from(self.far_mm), self.width(), range)
    }

    /// The transducers whose range changed by no more than `largest_mm`, as far as their values
    /// tell.
    #[must_use]
    pub fn changed_within<const SENSORS: usize>(
        self,
        before: &Situation<SENSORS>,
        after: &Situation<SENSORS>,
        largest_mm: u16,
    ) -> Mask {
        let largest = self.change_bits(largest_mm);
        let mut within = Mask::ALL;
        for (index, (before, after)) in before.iter().zip(after).enumerate() {
            if before.to_bits().abs_diff(after.to_bits()) > largest {
                within = within.without(index);
            }
        }
        within
    }

    /// By how much a value changes with a range that changes by this, in units of 2⁻¹³. No value
    /// changes by more than with one that changes by the far limit.
    pub(crate) fn change_bits(self, range_mm: u16) -> u16 {
        let ones = u32::from(range_mm).wrapping_mul(u32::from(ONE_BITS.unsigned_abs()));
        let change = ones.wrapping_div(self.width());
        u16::try_from(change).unwrap_or(u16::MAX)
    }

    /// By how much a thing is nearer whose value is greater by this, in units of 2⁻¹³; millimeters.
    pub(crate) fn nearer_mm(self, change: i32) -> i32 {
        change.wrapping_mul(self.width().cast_signed()) / i32::from(ONE_BITS)
    }

    /// From the far to the near limit, at least 1.
    fn width(self) -> u32 {
        u32::from(self.far_mm.saturating_sub(self.near_mm)).max(1)
    }

    fn value_within(far: u32, width: u32, range: Option<Range>) -> Weight {
        let range = range.map_or(u16::MAX, Range::as_mm);
        let nearer = far.saturating_sub(u32::from(range)).min(width);
        let ones = nearer.wrapping_mul(u32::from(ONE_BITS.unsigned_abs()));
        Weight::from_bits(ones.wrapping_div(width) as i16)
    }

    /// The situation of a scan.
    #[must_use]
    pub fn situation<const SENSORS: usize>(self, scan: &Scan<SENSORS>) -> Situation<SENSORS> {
        let mut situation = [Weight::ZERO; SENSORS];
        self.values(&scan.echoes, &mut situation);
        situation
    }

    /// Apart and on slices, so that the compiler does not unroll the loop.
    #[inline(never)]
    fn values(self, echoes: &[Echo], values: &mut [Weight]) {
        let (far, width) = (u32::from(self.far_mm), self.width());
        for (value, echo) in values.iter_mut().zip(echoes) {
            *value = Self::value_within(far, width, echo.range);
        }
    }
}

/// A situation rotated by ring steps: value `i` becomes value `i + steps`.
#[must_use]
pub fn rotated<const SENSORS: usize, T: Copy + Default>(
    values: &[T; SENSORS],
    steps: usize,
) -> [T; SENSORS] {
    let back = SENSORS.wrapping_sub(steps.checked_rem(SENSORS).unwrap_or(0));
    core::array::from_fn(|place| {
        let from = place.wrapping_add(back).checked_rem(SENSORS).unwrap_or(0);
        values.get(from).copied().unwrap_or_default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENCODING: Encoding = Encoding {
        near_mm: 200,
        far_mm: 1_000,
    };

    #[test]
    fn values_fall_linearly_between_the_limits() {
        let value = |mm| ENCODING.value(Some(Range::from_mm(mm))).to_num::<f64>();
        assert_eq!(
            (value(0), value(200), value(600), value(1_000), value(6_000)),
            (1.0, 1.0, 0.5, 0.0, 0.0)
        );
        assert_eq!(ENCODING.value(None), Weight::ZERO);
    }

    #[test]
    fn a_transducer_was_heard_at_a_time_or_not() {
        let mut scan = Scan::<2>::new();
        let at = Millis::from_ms(7);
        scan.hear(1, Echo { range: None, at });
        assert_eq!(
            [0, 1, 2].map(|sensor| scan.heard_at(sensor)),
            [None, Some(at), None]
        );
        scan.renew();
        assert_eq!(scan.heard_at(1), None);
    }

    #[test]
    fn values_are_rounded_down() {
        let encoding = Encoding {
            near_mm: 0,
            far_mm: 3,
        };
        let bits = [3, 2, 1, 0].map(|mm| encoding.value(Some(Range::from_mm(mm))).to_bits());
        assert_eq!(bits, [0, 2_730, 5_461, 8_192]);
        let mut scan = Scan::<2>::new();
        scan.hear(
            1,
            Echo {
                range: Some(Range::from_mm(1)),
                at: Millis::from_ms(3),
            },
        );
        assert_eq!(encoding.situation(&scan).map(Weight::to_bits), [0, 5_461]);
        assert_eq!(scan.echoes().map(|echo| echo.at.as_ms()), [0, 3]);
    }

    #[test]
    fn who_was_heard_once_stays_heard() {
        let mut scan = Scan::<3>::new();
        scan.hear(0, Echo::default());
        scan.renew();
        scan.hear(2, Echo::default());
        assert!(!scan.has_heard_all(Mask::ALL) && !scan.is_complete(Mask::ALL.without(1)));
        assert!(scan.has_heard_all(Mask::ALL.without(1)));
        assert!(scan.is_complete(Mask::NONE.with(2)) && scan.is_complete(Mask::NONE));
    }

    #[test]
    fn a_larger_change_than_asked_for_is_told_from_the_others() {
        let values = |mm: [u16; 4]| mm.map(|mm| ENCODING.value(Some(Range::from_mm(mm))));
        // Beyond the far limit nothing changes.
        let (before, after) = (values([500, 500, 500, 950]), values([500, 250, 801, 1_500]));
        let within = |mm| ENCODING.changed_within(&before, &after, mm);
        assert_eq!(within(300), Mask::ALL.without(2));
        assert_eq!(within(249), Mask::ALL.without(1).without(2));
        assert_eq!(within(u16::MAX), Mask::ALL);
    }

    #[test]
    fn limits_that_meet_do_not_divide_by_zero() {
        let step = Encoding {
            near_mm: 500,
            far_mm: 500,
        };
        assert_eq!(step.value(Some(Range::from_mm(499))).to_num::<f64>(), 1.0);
        assert_eq!(step.value(Some(Range::from_mm(500))).to_num::<f64>(), 0.0);
    }

    #[test]
    fn a_ring_is_complete_when_every_believed_transducer_was_heard() {
        let mut scan = Scan::<3>::default();
        scan.hear(0, Echo::default());
        scan.hear(7, Echo::default());
        assert!(!scan.is_complete(Mask::ALL));
        scan.hear(2, Echo::default());
        assert!(scan.is_complete(Mask::ALL.without(1)) && !scan.is_complete(Mask::ALL));
        scan.renew();
        assert!(!scan.is_complete(Mask::ALL.without(1)));
    }

    #[test]
    fn turning_moves_each_value_to_the_next_transducer() {
        assert_eq!(rotated(&[1, 2, 3, 4], 1), [4, 1, 2, 3]);
        assert_eq!(rotated(&[1, 2, 3, 4], 6), [3, 4, 1, 2]);
    }
}
