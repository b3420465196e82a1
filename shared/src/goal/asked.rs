//! What is asked of values while a decision is taken: whole numbers, ready to be compared.

use super::Component;
use crate::fixed::{Fine, Mask, coarse};
use core::slice::from_ref;

/// What is asked of a value in units of 2⁻¹³.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Asked {
    low: i32,
    high: i32,
    weight: i32,
}

impl Asked {
    /// Any value is as asked.
    pub(crate) const ANYTHING: Self = Self {
        low: i32::MIN,
        high: i32::MAX,
        weight: 0,
    };

    #[inline(always)]
    pub(super) fn of(component: &Component) -> Self {
        Self {
            low: i32::from(component.low.to_bits()),
            high: i32::from(component.high.to_bits()),
            weight: i32::from(component.weight),
        }
    }

    /// Whether a value is as asked.
    #[inline(always)]
    pub(crate) const fn holds(&self, value: i32) -> bool {
        self.low <= value && value <= self.high
    }

    /// Whether a value misses what is asked by at most `tolerance`.
    #[inline(always)]
    pub(crate) const fn holds_within(&self, value: i32, tolerance: i32) -> bool {
        self.weight == 0
            || self.low.saturating_sub(tolerance) <= value
                && value <= self.high.saturating_add(tolerance)
    }

    /// How the deviation runs over the values from the least to the most, which may lie below 0 and count as 0 there.
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
    #[inline(always)]
    pub(crate) fn deviation(&self, value: i32, cap: i32) -> i64 {
        let nearest = value.max(self.low).min(self.high);
        let off = value.wrapping_sub(nearest).saturating_abs().min(cap);
        i64::from(off.wrapping_mul(off)).wrapping_mul(i64::from(self.weight))
    }
}

/// What a goal asks in the ring's frame of a robot that goes towards a place of the ring, begun with the component that weighs
/// most: what deviates much is soon seen to.
pub(crate) struct Heaviest<'a, const SENSORS: usize> {
    goal: &'a [Component; SENSORS],
    place: usize,
    believed: Mask,
    /// All of them in order, and the transducer that each piece begins with, counted on around the ring.
    pieces: [(&'a [Component], usize); 3],
}

impl<'a, const SENSORS: usize> Heaviest<'a, SENSORS> {
    /// Begins with this component.
    pub(crate) fn from(
        goal: &'a [Component; SENSORS],
        place: usize,
        believed: Mask,
        first: usize,
    ) -> Self {
        let place = place.checked_rem(SENSORS).unwrap_or(0);
        let first = first.min(SENSORS);
        // From this component on they look at the row's beginning.
        let turn = SENSORS.wrapping_sub(place);
        let pieces = if first <= turn {
            [first..turn, turn..SENSORS, 0..first]
        } else {
            [first..SENSORS, 0..turn, turn..first]
        };
        let pieces = pieces.map(|piece| {
            let sensor = piece.start.wrapping_add(place);
            (goal.get(piece).unwrap_or(&[]), sensor)
        });
        Self {
            goal,
            place,
            believed,
            pieces,
        }
    }

    /// How far a code vector deviates from what is asked, in units of 2⁻²⁶ · weight; what reaches `limit` may be more.
    #[inline(never)]
    pub(crate) fn missed_by(&self, row: &[Fine; SENSORS], limit: i64) -> i64 {
        if !self.believed.covers(SENSORS) {
            return self.missed_by_believed(row);
        }
        let mut total = 0_i64;
        for (components, sensor) in &self.pieces {
            if !components.is_empty() {
                let sensor = sensor.checked_rem(SENSORS).unwrap_or(0);
                let row = row.get(sensor..).unwrap_or(&[]);
                total = total.wrapping_add(missed_in(components, row, limit.wrapping_sub(total)));
                if total >= limit {
                    break;
                }
            }
        }
        total
    }

    /// The same where some transducers do not count.
    #[inline(never)]
    fn missed_by_believed(&self, row: &[Fine; SENSORS]) -> i64 {
        let mut total = 0_i64;
        for (index, component) in self.goal.iter().enumerate() {
            let sensor = index.wrapping_add(self.place).checked_rem(SENSORS);
            let believed = sensor.filter(|sensor| self.believed.contains(*sensor));
            if let Some(value) = believed.and_then(|sensor| row.get(sensor)) {
                total =
                    total.wrapping_add(missed_in(from_ref(component), from_ref(value), i64::MAX));
            }
        }
        total
    }
}

/// [`Heaviest::missed_by`] of one piece.
#[inline(never)]
fn missed_in(components: &[Component], row: &[Fine], limit: i64) -> i64 {
    let mut total = 0_i64;
    for (component, value) in components.iter().zip(row) {
        let value = i32::from(coarse(*value).to_bits());
        let low = i32::from(component.low.to_bits());
        let high = i32::from(component.high.to_bits());
        // Most are as asked: nothing to multiply.
        if value < low || value > high {
            // At most five times 2¹³.
            let off = if value < low {
                low.wrapping_sub(value)
            } else {
                value.wrapping_sub(high)
            };
            let squared = i64::from(off.wrapping_mul(off));
            total = total.wrapping_add(squared.wrapping_mul(i64::from(component.weight)));
            if total >= limit {
                break;
            }
        }
    }
    total
}

/// The component that weighs most, the first on ties.
#[inline(never)]
pub(crate) fn heaviest(goal: &[Component]) -> usize {
    let (mut first, mut most) = (0, 0);
    for (index, component) in goal.iter().enumerate() {
        if component.weight > most {
            (first, most) = (index, component.weight);
        }
    }
    first
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

/// Squared deviation of values (2⁻¹³, which may leave [0, 1]) from what is asked of them, each at most that of the cap, in
/// units of 2⁻²⁶ · weight; what reaches `limit` may be more.
#[inline(never)]
pub(crate) fn missed(
    asked: impl Iterator<Item = Asked>,
    values: impl Iterator<Item = i32>,
    cap: i32,
    limit: i64,
) -> i64 {
    let mut total = 0_i64;
    for (asked, value) in asked.zip(values) {
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
    use crate::fixed::Weight;
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
        let asked = Asked {
            low: 10,
            high: 20,
            weight: 1,
        };
        let holds = |value| asked.holds(value);
        assert_eq!([9, 10, 20, 21].map(holds), [false, true, true, false]);
        let within = |value| asked.holds_within(value, 5);
        assert_eq!([4, 5, 25, 26].map(within), [false, true, true, false]);
        assert!(Asked::ANYTHING.holds_within(i32::MIN, 5));
        assert!(Asked::ANYTHING.holds_within(i32::MAX, 5));
    }

    #[test]
    fn the_first_of_those_that_weigh_most_is_begun_with() {
        let goal = |weights: [u8; 4]| {
            weights.map(|weight| Component {
                weight,
                ..Component::ANY
            })
        };
        assert_eq!(heaviest(&goal([0, 3, 1, 3])), 1);
        assert_eq!(heaviest(&goal([0; 4])), 0);
    }

    proptest! {
        #[test]
        fn begun_with_the_heaviest_it_is_the_same(
            bounds in prop::array::uniform8((0_i16..=8_192, 0_i16..=8_192, any::<u8>())),
            values in prop::array::uniform8(0_i16..=8_192),
            believed in prop_oneof![Just(u32::MAX), any::<u32>()], place in 0_usize..8, cap in 0_i32..=8_192,
            begin in 0_usize..8,
        ) {
            let (goal, mask) = (goal(bounds), Mask::from_bits(believed));
            let asked = || goal.asked(place, mask);
            let heaviest = Heaviest::from(&goal.components, place, mask, begin);
            let situation = values.map(Weight::from_bits);
            let turned = goal.towards(place);
            let deviation = turned.distance(&situation, mask);
            let row = situation.map(|value| Fine::from_bits(i32::from(value.to_bits()) << 16));
            prop_assert_eq!(heaviest.missed_by(&row, i64::MAX), deviation);
            prop_assert!(deviation == 0 || heaviest.missed_by(&row, deviation) >= deviation);
            let exact: i64 = asked().zip(&values).map(|(asked, value)| asked.deviation(i32::from(*value), cap)).sum();
            prop_assert_eq!(missed(asked(), values.iter().copied().map(i32::from), cap, i64::MAX), exact);
        }
    }
}
