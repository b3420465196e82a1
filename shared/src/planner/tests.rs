//! What a planner is told of the last decision spares work and changes nothing.

use super::*;
use crate::goal::Component;
use crate::som::Grid;
use proptest::prelude::*;

proptest! {
    #[test]
    fn the_goal_s_neuron_is_the_same_whatever_was_known(
        code in prop::collection::vec(0_i16..=8_192, 16 * 16),
        learnt in prop::collection::vec(0_i16..=8_192, 16),
        asked in prop::collection::vec((0_i16..=8_192, 0_i16..=8_192, 0_u8..3), 16),
        changed in prop::option::of(0_usize..16), near in any::<bool>(), likely in any::<u8>(),
    ) {
        let part = |index: usize| Weight::from_bits(code[index]);
        let code = core::array::from_fn(|k| core::array::from_fn(|i| part(16 * k + i)));
        let mut situations = Som::<16, 16>::new(Grid::rectangle(4, 4), code);
        let actions = ActionMap::<16, 16>::zeroed(Grid::rectangle(4, 4));
        let goal = Goal::of(core::array::from_fn(|i| {
            let (a, b, weight) = asked[i];
            Component {
                low: Weight::from_bits(a.min(b)),
                high: Weight::from_bits(a.max(b)),
                weight,
            }
        }));
        let config = Config::recommended();
        let situation = [Weight::ZERO; 16];
        let found = |situations: &Som<16, 16>, current: Option<usize>, likely: GoalNeuron| {
            let planner = Planner {
                config: &config,
                situations,
                actions: &actions,
                allowed: Mask::ALL,
                current,
                likely,
                course: Displacement::ZERO,
                cut: false,
            };
            planner.plan_on_way(&situation, &goal, 0).1
        };
        let any = GoalNeuron { neuron: likely, ..GoalNeuron::UNKNOWN };
        let before = found(&situations, None, any);
        prop_assert_eq!(before, found(&situations, None, GoalNeuron::UNKNOWN));
        if let Some(changed) = changed {
            let to: [Weight; 16] = core::array::from_fn(|i| Weight::from_bits(learnt[i]));
            let wanted = goal.nearest(&to);
            situations.set_code_vector(changed, if near { &wanted } else { &to });
        }
        let current = changed.or(Some(3));
        let after = found(&situations, current, before);
        prop_assert_eq!(after, found(&situations, current, GoalNeuron::UNKNOWN));
        // Wherever the comparison begins.
        let begun = found(&situations, current, GoalNeuron { heaviest: likely, ..before });
        prop_assert_eq!((begun.neuron, begun.deviation), (after.neuron, after.deviation));
        let deviation = |k: usize| goal.distance(&situations.code_vector(k), Mask::ALL);
        let nearest = (0..16).min_by_key(|&k| (deviation(k), k));
        prop_assert_eq!(Some(usize::from(after.neuron)), nearest);
    }
}
