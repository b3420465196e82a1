//! What is asked of values while a decision is taken: whole numbers, ready to be compared.

use super::Component;

/// What is asked of a value in units of 2⁻¹³.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ValueBounds {
    low: i32,
    high: i32,
    weight: i32,
}

impl ValueBounds {
    /// Any value is as asked.
    pub(crate) const ANYTHING: Self = Self {
        low: i32::MIN,
        high: i32::MAX,
        weight: 0,
    };

    pub(super) fn of(component: &Component) -> Self {
        Self {
            low: i32::from(component.low.to_bits()),
            high: i32::from(component.high.to_bits()),
            weight: i32::from(component.weight),
        }
    }

    /// Whether a value is as asked.
    pub(crate) const fn holds(&self, value: i32) -> bool {
        self.low <= value && value <= self.high
    }

    /// Whether a value misses what is asked by at most `tolerance`.
    pub(crate) const fn holds_within(&self, value: i32, tolerance: i32) -> bool {
        self.weight == 0
            || self.low.saturating_sub(tolerance) <= value
                && value <= self.high.saturating_add(tolerance)
    }

    /// How the deviation runs over the values from the least to the most, which may lie below 0 and
    /// count as 0 there.
    pub(crate) const fn over(&self, (least, most): (i32, i32), cap: i32) -> Over {
        let (low, high) = (self.low, self.high);
        let from = if least < 0 { 0 } else { least };
        let to = if most < 0 { 0 } else { most };
        if low <= from && to <= high {
            return Over::Met;
        }
        if from.saturating_sub(high) >= cap || low.saturating_sub(to) >= cap {
            return Over::Capped;
        }
        let (target, farthest) = if from >= high {
            (high, to.saturating_sub(high))
        } else if to <= low {
            (low, low.saturating_sub(from))
        } else if low == high {
            let (above, below) = (to.saturating_sub(high), low.saturating_sub(from));
            (high, if above > below { above } else { below })
        } else {
            return Over::Bent;
        };
        if least >= 0 && farthest <= cap {
            Over::Square(target)
        } else {
            Over::Bent
        }
    }

    /// Weight of the deviation.
    pub(crate) const fn weight(&self) -> i32 {
        self.weight
    }

    /// The deviation of what is at the cap or beyond.
    pub(crate) const fn most(&self, cap: i32) -> i64 {
        cap.wrapping_mul(cap) as i64 * self.weight as i64
    }

    /// Squared deviation of a value, at most that of the cap, in units of 2⁻²⁶ · weight.
    pub(crate) fn deviation(&self, value: i32, cap: i32) -> i64 {
        let nearest = value.max(self.low).min(self.high);
        let off = value.wrapping_sub(nearest).saturating_abs().min(cap);
        i64::from(off.wrapping_mul(off)).wrapping_mul(i64::from(self.weight))
    }
}

/// How the deviation runs over an interval of values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Over {
    /// All values are as asked.
    Met,
    /// All values deviate by the cap at least.
    Capped,
    /// The square of the distance from this value.
    Square(i32),
    /// One piece here, another there.
    Bent,
}

/// Squared deviation of values (2⁻¹³, which may leave [0, 1]) from what is asked of each, at most
/// that of the cap, in units of 2⁻²⁶ · weight; what reaches `limit` may be more.
#[inline(never)]
pub(crate) fn cost_of(
    values: impl Iterator<Item = (ValueBounds, i32)>,
    cap: i32,
    limit: i64,
) -> i64 {
    let mut total = 0_i64;
    for (asked, value) in values {
        // Most values are as asked: nothing to multiply.
        let off = if value < asked.low {
            asked.low.wrapping_sub(value)
        } else if value > asked.high {
            value.wrapping_sub(asked.high)
        } else {
            continue;
        };
        let off = off.min(cap);
        let squared = i64::from(off.wrapping_mul(off));
        total = total.wrapping_add(squared.wrapping_mul(i64::from(asked.weight)));
        if total >= limit {
            break;
        }
    }
    total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixed::{Mask, Weight};
    use crate::goal::Goal;
    use proptest::prelude::*;

    fn goal(bounds: [(i16, i16, u8); 8]) -> Goal<8> {
        Goal::of(bounds.map(|(a, b, weight)| Component {
            low: Weight::from_bits(a.min(b)),
            high: Weight::from_bits(a.max(b)),
            weight,
        }))
    }

    #[test]
    fn what_is_asked_holds_up_to_its_bounds_and_a_tolerance_beyond() {
        let asked = ValueBounds {
            low: 10,
            high: 20,
            weight: 1,
        };
        let holds = |value| asked.holds(value);
        assert_eq!([9, 10, 20, 21].map(holds), [false, true, true, false]);
        let within = |value| asked.holds_within(value, 5);
        assert_eq!([4, 5, 25, 26].map(within), [false, true, true, false]);
        assert!(ValueBounds::ANYTHING.holds_within(i32::MIN, 5));
        assert!(ValueBounds::ANYTHING.holds_within(i32::MAX, 5));
    }

    proptest! {
        #[test]
        fn what_is_missed_is_the_sum_of_all_deviations(
            bounds in prop::array::uniform8((0_i16..=8_192, 0_i16..=8_192, any::<u8>())),
            values in prop::array::uniform8(0_i16..=8_192),
            believed in prop_oneof![Just(u32::MAX), any::<u32>()], place in 0_usize..8, cap in 0_i32..=8_192,
        ) {
            let (goal, mask) = (goal(bounds), Mask::from_bits(believed));
            let asked = || goal.asked(place, mask);
            // Without a cap as of the goal turned that far.
            let situation = values.map(Weight::from_bits);
            let deviation = goal.towards(place).distance(&situation, mask);
            let pairs = || asked().zip(values.iter().copied().map(i32::from));
            prop_assert_eq!(cost_of(pairs(), i32::MAX, i64::MAX), deviation);
            prop_assert!(deviation == 0 || cost_of(pairs(), i32::MAX, deviation) >= deviation);
            let goal = Goal { cap: Weight::from_bits(cap as i16), ..goal };
            let exact: i64 = asked().zip(&values).map(|(asked, value)| asked.deviation(i32::from(*value), cap)).sum();
            prop_assert_eq!(goal.cost(place, mask, &situation, i64::MAX), exact);
        }
    }
}
