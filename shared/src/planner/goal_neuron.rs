//! Step 1: the neuron that stands for the goal, the one whose code vector costs least by what is
//! asked.
//!
//! A search over all neurons ([`search`]) is all there is to it. From one decision to the next
//! mostly one neuron has changed, and [`Memo`] keeps what the last search found: it spares about 4
//! 000 instructions of the 20 000 that a decision may take.

use super::{Planner, cheapest};
use crate::fixed::{Mask, to_weight16};
use crate::goal::{ValueBounds, cost_of};
use crate::som::Som;

/// What the last decision's searches found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Memo {
    neuron: u8,
    travel: u8,
    enabled: Mask,
    /// What the neuron costs, while the goal is the same and no other neuron has changed than the
    /// planner's current one.
    cost: Option<i64>,
}

impl Memo {
    /// Nothing is known.
    pub(crate) const NONE: Self = Self {
        neuron: 0,
        travel: 0,
        enabled: Mask::NONE,
        cost: None,
    };

    /// The travel sensor of the last decision.
    pub(crate) const fn travel(&self) -> usize {
        self.travel as usize
    }

    /// The goal is another, or more neurons have changed than the current one.
    pub(crate) const fn forget_cost(&mut self) {
        self.cost = None;
    }

    /// The goal neuron for what is asked of a robot that looks along its travel sensor.
    pub(super) fn goal_neuron<const SENSORS: usize, const NEURONS: usize>(
        &mut self,
        planner: &Planner<'_, SENSORS, NEURONS>,
        travel: usize,
        asked: &[ValueBounds; SENSORS],
    ) -> usize {
        let map = planner.situations;
        let is_same = usize::from(self.travel) == travel && self.enabled == planner.enabled;
        let known = self.cost.filter(|_| is_same);
        let known = known.and_then(|cost| self.after_a_change(cost, planner.current, map, asked));
        let (neuron, cost) = known.unwrap_or_else(|| search(map, self.neuron.into(), asked));
        *self = Self {
            neuron: neuron as u8,
            travel: travel as u8,
            enabled: planner.enabled,
            cost: Some(cost),
        };
        neuron
    }

    /// The goal neuron and its cost if no neuron but `changed` is another than before; `None` if it
    /// takes a search.
    fn after_a_change<const SENSORS: usize, const NEURONS: usize>(
        &self,
        least: i64,
        changed: Option<usize>,
        map: &Som<NEURONS, SENSORS>,
        asked: &[ValueBounds; SENSORS],
    ) -> Option<(usize, i64)> {
        let best = usize::from(self.neuron);
        let Some(changed) = changed else {
            return Some((best, least));
        };
        let limit = least.saturating_add(i64::from(changed <= best));
        let cost = cost(map, changed, asked, limit);
        if cost < limit {
            return Some((changed, cost));
        }
        (changed != best).then_some((best, least))
    }
}

/// The neuron of least cost, the lowest on ties, and its cost.
fn search<const SENSORS: usize, const NEURONS: usize>(
    map: &Som<NEURONS, SENSORS>,
    first: usize,
    asked: &[ValueBounds; SENSORS],
) -> (usize, i64) {
    cheapest(NEURONS, first, |neuron, limit| {
        cost(map, neuron, asked, limit)
    })
}

/// How far a neuron's code vector is from what is asked, in units of 2⁻²⁶ · weight; what reaches
/// `limit` may be more.
#[inline(never)]
pub(super) fn cost<const SENSORS: usize, const NEURONS: usize>(
    map: &Som<NEURONS, SENSORS>,
    neuron: usize,
    asked: &[ValueBounds; SENSORS],
    limit: i64,
) -> i64 {
    let Some(code) = map.code().get(neuron) else {
        return i64::MAX;
    };
    let values = code
        .iter()
        .map(|value| i32::from(to_weight16(*value).to_bits()));
    cost_of(asked.iter().copied(), values, i32::MAX, limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::action_map::ActionMap;
    use crate::config::Config;
    use crate::fixed::Weight;
    use crate::goal::{Component, Goal};
    use crate::som::Grid;
    use crate::units::Displacement;
    use proptest::prelude::*;

    /// Few different values make many ties.
    fn value() -> impl Strategy<Value = i16> {
        prop_oneof![Just(0_i16), Just(8_192), 0_i16..=8_192]
    }

    proptest! {
        #[test]
        fn the_goal_neuron_is_the_same_whatever_was_known(
            code in prop::collection::vec(value(), 16 * 16), learned in prop::collection::vec(value(), 16),
            bounds in prop::collection::vec((value(), value(), 0_u8..3), 16),
            changed in prop::option::of(0_usize..16), near in any::<bool>(), guess in any::<u8>(), travel in 0_usize..16,
        ) {
            let part = |index: usize| Weight::from_bits(code[index]);
            let code = core::array::from_fn(|k| core::array::from_fn(|i| part(16 * k + i)));
            let mut situations = Som::<16, 16>::new(Grid::rectangle(4, 4), code);
            let actions = ActionMap::<16, 16>::zeroed(Grid::rectangle(4, 4));
            let goal = Goal::of(core::array::from_fn(|i| {
                let (a, b, weight) = bounds[i];
                Component {
                    low: Weight::from_bits(a.min(b)),
                    high: Weight::from_bits(a.max(b)),
                    weight,
                }
            }));
            let mut asked = goal.asked(travel, Mask::ALL);
            let asked = core::array::from_fn(|_| asked.next().unwrap());
            let config = Config::recommended();
            let found = |situations: &Som<16, 16>, current: Option<usize>, mut memo: Memo| {
                let planner = Planner {
                    config: &config,
                    situations,
                    actions: &actions,
                    enabled: Mask::ALL,
                    allowed: Mask::ALL,
                    current,
                    course: Displacement::ZERO,
                    cut: false,
                };
                let neuron = memo.goal_neuron(&planner, travel, &asked);
                assert_eq!(usize::from(memo.neuron), neuron);
                memo
            };
            let guessed = Memo { neuron: guess, ..Memo::NONE };
            let before = found(&situations, None, guessed);
            prop_assert_eq!(before, found(&situations, None, Memo::NONE));
            if let Some(changed) = changed {
                let to: [Weight; 16] = core::array::from_fn(|i| Weight::from_bits(learned[i]));
                let wanted = goal.towards(travel).nearest(&to);
                situations.set_code_vector(changed, if near { &wanted } else { &to });
            }
            let current = changed.or(Some(3));
            let after = found(&situations, current, before);
            prop_assert_eq!(after, found(&situations, current, Memo::NONE));
            // What was known of another travel sensor, or of other transducers, counts for nothing.
            let wrong = Memo { neuron: guess % 16, cost: Some(0), ..before };
            let elsewhere = (travel as u8 + 1) % 16;
            for other in [Memo { travel: elsewhere, ..wrong }, Memo { enabled: Mask::NONE.with(3), ..wrong }] {
                prop_assert_eq!(found(&situations, current, other), after);
            }
            let deviation = |k: usize| goal.towards(travel).distance(&situations.code_vector(k), Mask::ALL);
            let nearest = (0..16).min_by_key(|&k| (deviation(k), k));
            prop_assert_eq!(Some(usize::from(after.neuron)), nearest);
            prop_assert_eq!(after.cost, nearest.map(deviation));
        }
    }
}
