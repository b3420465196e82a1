//! Step 1: finds the neuron whose code vector deviates least from the goal; never changes a map.
//!
//! The plain algorithm is [`search`]. [`SearchCache`] keeps the last result, because mostly one
//! neuron changes between decisions: it saves about 4000 of 20 000 instructions per decision.

use super::{Planner, argmin};
use crate::fixed::{Mask, to_weight16};
use crate::goal::{ValueBounds, cost_of};
use crate::som::Som;

/// Search results of the last decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SearchCache {
    neuron: u8,
    travel: u8,
    enabled: Mask,
    /// Cost of the neuron; valid while the goal is the same and only the planner's current neuron
    /// has changed.
    cost: Option<i64>,
}

impl SearchCache {
    /// An empty cache.
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

    /// Invalidates the cost: the goal or other neurons than the current one have changed.
    pub(crate) const fn forget_cost(&mut self) {
        self.cost = None;
    }

    /// The goal neuron for the goal's bounds, rotated to the travel sensor.
    pub(super) fn goal_neuron<const SENSORS: usize, const NEURONS: usize, S>(
        &mut self,
        planner: &Planner<'_, SENSORS, NEURONS, S>,
        travel: usize,
        bounds: &[ValueBounds; SENSORS],
    ) -> usize {
        let map = planner.situations;
        let is_same = usize::from(self.travel) == travel && self.enabled == planner.enabled;
        let cached = self.cost.filter(|_| is_same);
        let cached =
            cached.and_then(|cost| self.after_a_change(cost, planner.current, map, bounds));
        let (neuron, cost) = cached.unwrap_or_else(|| search(map, self.neuron.into(), bounds));
        *self = Self {
            neuron: neuron as u8,
            travel: travel as u8,
            enabled: planner.enabled,
            cost: Some(cost),
        };
        neuron
    }

    /// The goal neuron and its cost where only neuron `changed` has changed; `None` where a full
    /// search is needed.
    fn after_a_change<const SENSORS: usize, const NEURONS: usize>(
        &self,
        least: i64,
        changed: Option<usize>,
        map: &Som<NEURONS, SENSORS>,
        bounds: &[ValueBounds; SENSORS],
    ) -> Option<(usize, i64)> {
        let best = usize::from(self.neuron);
        let Some(changed) = changed else {
            return Some((best, least));
        };
        let limit = least.saturating_add(i64::from(changed <= best));
        let cost = cost(map, changed, bounds, limit);
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
    bounds: &[ValueBounds; SENSORS],
) -> (usize, i64) {
    argmin(NEURONS, first, |neuron, limit| {
        cost(map, neuron, bounds, limit)
    })
}

/// Deviation of a neuron's code vector from the bounds, in units of 2⁻²⁶ · weight; the sum may stop
/// once it reaches `limit`.
#[inline(never)]
pub(super) fn cost<const SENSORS: usize, const NEURONS: usize>(
    map: &Som<NEURONS, SENSORS>,
    neuron: usize,
    bounds: &[ValueBounds; SENSORS],
    limit: i64,
) -> i64 {
    let Some(code) = map.code().get(neuron) else {
        return i64::MAX;
    };
    let values = code
        .iter()
        .map(|value| i32::from(to_weight16(*value).to_bits()));
    cost_of(bounds.iter().copied().zip(values), i32::MAX, limit)
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
            let mut bounds = goal.asked(travel, Mask::ALL);
            let bounds = core::array::from_fn(|_| bounds.next().unwrap());
            let config = Config::recommended();
            let found = |situations: &Som<16, 16>, current: Option<usize>, mut cache: SearchCache| {
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
                let neuron = cache.goal_neuron(&planner, travel, &bounds);
                assert_eq!(usize::from(cache.neuron), neuron);
                cache
            };
            let guessed = SearchCache { neuron: guess, ..SearchCache::NONE };
            let before = found(&situations, None, guessed);
            prop_assert_eq!(before, found(&situations, None, SearchCache::NONE));
            if let Some(changed) = changed {
                let to: [Weight; 16] = core::array::from_fn(|i| Weight::from_bits(learned[i]));
                let wanted = goal.towards(travel).nearest(&to);
                situations.set_code_vector(changed, if near { &wanted } else { &to });
            }
            let current = changed.or(Some(3));
            let after = found(&situations, current, before);
            prop_assert_eq!(after, found(&situations, current, SearchCache::NONE));
            // Results for another travel sensor or other transducers are not reused.
            let wrong = SearchCache { neuron: guess % 16, cost: Some(0), ..before };
            let elsewhere = (travel as u8 + 1) % 16;
            for other in [SearchCache { travel: elsewhere, ..wrong }, SearchCache { enabled: Mask::NONE.with(3), ..wrong }] {
                prop_assert_eq!(found(&situations, current, other), after);
            }
            let deviation = |k: usize| goal.towards(travel).distance(&situations.code_vector(k), Mask::ALL);
            let nearest = (0..16).min_by_key(|&k| (deviation(k), k));
            prop_assert_eq!(Some(usize::from(after.neuron)), nearest);
            prop_assert_eq!(after.cost, nearest.map(deviation));
        }
    }
}
