use super::recall::scaled_to_unit;
use super::*;
use crate::som::Neighborhood;
use crate::units::Displacement;
use proptest::prelude::*;

const CHANGES: [[i16; 3]; 4] = [[800, 0, 0], [0, 8_192, 0], [6_000, 0, 0], [7_000, 8_000, 0]];
const ACTIONS: [[i16; 2]; 4] = [[8_192, 0], [0, 8_192], [-8_192, 0], [0, -8_192]];

fn map() -> ActionMap<4, 3> {
    ActionMap::new(
        Grid::chain(4),
        CHANGES.map(|row| row.map(Weight::from_bits)),
        ACTIONS.map(|row| row.map(Weight::from_bits)),
    )
}

fn answer(wanted: [i16; 3], recall: Recall, mask: Mask, allowed: Mask) -> Answer {
    let probe = Probe {
        recall,
        preference: None,
    };
    map().recall(&wanted.map(Weight::from_bits), mask, probe, allowed)
}

#[test]
fn maps_are_compared_by_changes_and_actions() {
    let with = |change, action| {
        let (mut changes, mut actions) = (CHANGES, ACTIONS);
        (changes[3][2], actions[3][0]) = (change, action);
        let weights = |row: [i16; 2]| row.map(Weight::from_bits);
        let changes = changes.map(|row| row.map(Weight::from_bits));
        ActionMap::new(Grid::chain(4), changes, actions.map(weights))
    };
    assert_eq!(with(0, 0), map());
    assert_ne!(with(1, 0), map());
    assert_ne!(with(0, 1), map());
}

#[test]
fn distance_direction_and_projection_select_different_neurons() {
    let recall = |recall| answer([1_000, 0, 0], recall, Mask::ALL, Mask::ALL).neuron;
    assert_eq!(recall(Recall::Distance), 0);
    assert_eq!(recall(Recall::Direction), 2);
    assert_eq!(recall(Recall::Projection), 3);
}

#[test]
fn inhibited_neurons_are_excluded_unless_all_are_inhibited() {
    let neuron = |allowed| answer([1_000, 0, 0], Recall::Direction, Mask::ALL, allowed).neuron;
    assert_eq!(neuron(Mask::ALL.without(2)), 3);
    assert_eq!(neuron(Mask::NONE), 2);
}

#[test]
fn masked_out_components_have_no_effect() {
    let neuron = |mask| answer([100, 8_192, 0], Recall::Direction, mask, Mask::ALL).neuron;
    assert_eq!(neuron(Mask::ALL), 1);
    assert_ne!(neuron(Mask::ALL.without(1)), 1);
}

#[test]
fn better_matches_have_more_weight_in_the_mean_action() {
    let together = |wanted, allowed| {
        answer(wanted, Recall::Direction, Mask::ALL, allowed)
            .together
            .map(|w| w.to_num::<f64>())
    };
    // Neuron 3 matches best, neurons 1 and 2 partly.
    let [x, y] = together([1_000, 1_000, 0], Mask::ALL);
    assert!(y < -0.5 && x.abs() < 0.2, "{x} {y}");
    let [x, y] = together([1_000, 1_000, 0], Mask::ALL.without(3));
    assert!(x < -0.1 && y > 0.1, "{x} {y}");
    assert_eq!(together([-1_000, -1_000, 0], Mask::ALL), [0.0; 2]);
    assert_eq!(together([0; 3], Mask::ALL), [0.0; 2]);
}

#[test]
fn a_preferred_action_breaks_a_tie() {
    let changes = [[4_000, 0, 0], [4_000, 0, 0], [4_000, 0, 0], [0, 0, 0]];
    let map = ActionMap::new(
        Grid::chain(4),
        changes.map(|row| row.map(Weight::from_bits)),
        ACTIONS.map(|row| row.map(Weight::from_bits)),
    );
    let wanted = [1_000, 0, 0].map(Weight::from_bits);
    let recall = |preferred: Option<usize>| {
        let preference = preferred.map(|k| Preference {
            code: ACTIONS[k].map(Weight::from_bits),
            weight_q8: 26,
        });
        let probe = Probe {
            recall: Recall::Direction,
            preference,
        };
        map.recall(&wanted, Mask::ALL, probe, Mask::ALL).neuron
    };
    assert_eq!((recall(None), recall(Some(1)), recall(Some(2))), (0, 1, 2));
    // A preference does not select a neuron that lacks the wanted change.
    assert_ne!(recall(Some(3)), 3);
}

#[test]
fn products_updated_in_training_equal_recomputed_ones() {
    let mut map = map();
    map.keep_products();
    let bmu_only = Update::from_q16(Neighborhood::Direct, 20_000, 0);
    for (index, (change, action)) in CHANGES.iter().zip(ACTIONS).enumerate() {
        let effect = Effect {
            change: change.map(|bits| Weight::from_bits(bits / 3 - 500)),
            action: action.map(Weight::from_bits),
            mask: Mask::ALL.without(index),
        };
        map.update((index + 1) % 4, &effect, &bmu_only);
        let updated = *map.products().unwrap();
        map.forget_products();
        map.keep_products();
        assert_eq!(map.products(), Some(&updated));
        assert_eq!(map.clone(), map);
    }
    // Updates of neighbors and writes discard the products.
    let with_neighbors = Update::from_q16(Neighborhood::Direct, 20_000, 20_000);
    let effect = Effect {
        change: CHANGES[0].map(Weight::from_bits),
        action: ACTIONS[0].map(Weight::from_bits),
        mask: Mask::ALL,
    };
    map.update(0, &effect, &with_neighbors);
    assert_eq!(map.products(), None);
    map.keep_products();
    map.actions_mut().set_component(0, Weight32::from_bits(5));
    assert_eq!(map.products(), None);
}

#[test]
fn a_high_action_weight_lets_the_action_decide() {
    let effect = Effect {
        change: CHANGES[0].map(Weight::from_bits),
        action: ACTIONS[2].map(Weight::from_bits),
        mask: Mask::ALL,
    };
    assert_eq!(map().bmu(&effect, 0), 0);
    assert_eq!(map().bmu(&effect, 2_560), 2);
}

proptest! {
    /// Tests neurons that differ by a few units, with any action weight.
    #[test]
    fn the_bmu_is_nearest_by_change_and_action(
        middle in prop::collection::vec(-8_100_i16..=8_100, 18), shifts in prop::collection::vec(-40_i32..=40, 16 * 18),
        probe in prop::collection::vec(-8_192_i16..=8_192, 18), weight in prop_oneof![0_u16..600, any::<u16>()],
    ) {
        let mut map = ActionMap::<16, 16>::zeroed(Grid::rectangle(4, 4));
        for (k, shifts) in shifts.chunks_exact(18).enumerate() {
            for (i, shift) in shifts.iter().enumerate() {
                let value = Weight32::from_bits((i32::from(middle[i]) << 16) + shift * 30_001);
                match i.checked_sub(16) {
                    None => map.changes_mut().set_component(k * 16 + i, value),
                    Some(i) => map.actions_mut().set_component(k * 2 + i, value),
                }
            }
        }
        let component = |i: usize| Weight::from_bits(probe[i]);
        let effect = Effect {
            change: core::array::from_fn(component),
            action: [component(16), component(17)],
            mask: Mask::ALL,
        };
        let distance = |k: usize| {
            let action = map.actions().distance(k, &effect.action, Mask::ALL) >> 8;
            map.changes().distance(k, &effect.change, Mask::ALL) + action * u64::from(weight)
        };
        let nearest = (0..16).min_by_key(|&k| (distance(k), k));
        prop_assert_eq!(Some(map.bmu(&effect, weight)), nearest);
    }
}

#[test]
fn short_probes_are_scaled_to_unit() {
    let scaled = |bits: [i16; 3]| scaled_to_unit(&bits.map(Weight::from_bits)).map(Weight::to_bits);
    assert_eq!(scaled([0; 3]), [0; 3]);
    assert_eq!(scaled([2, -1, 0]), [8_192, -4_096, 0]);
    assert_eq!(scaled([-4_096, 1_024, 8]), [-8_192, 2_048, 16]);
}

#[test]
fn codes_are_relative_to_the_longest_step() {
    let bits = |code: ActionCode, dx_mm, dy_mm| {
        code.encode(Displacement { dx_mm, dy_mm }, 200)
            .map(Weight::to_bits)
    };
    assert_eq!(bits(ActionCode::Displacement, 100, -50), [4_096, -2_048]);
    assert_eq!(
        bits(ActionCode::Displacement, 201, -32_000),
        [8_192, -8_192]
    );
    // Half a turn is 1.0.
    assert_eq!(bits(ActionCode::TurnStep, 100, 0), [0, 4_096]);
    let [turn, length] = bits(ActionCode::TurnStep, 0, 200);
    assert!((turn - 4_096).abs() < 8 && length == 8_192, "{turn}");
    let decode = |code: ActionCode, bits: [i16; 2]| code.decode(bits.map(Weight::from_bits), 200);
    assert_eq!(
        decode(ActionCode::Displacement, [4_096, -21]),
        Displacement {
            dx_mm: 100,
            dy_mm: -1
        }
    );
    // Rounds to nearest: 21/8192 of 200 mm is 0.51 mm, 20/8192 is 0.49 mm.
    for (bits, mm) in [(21, 1), (20, 0), (-20, 0), (-21, -1)] {
        assert_eq!(decode(ActionCode::Displacement, [bits, 0]).dx_mm, mm);
    }
    // A negative length decodes to zero.
    assert_eq!(
        decode(ActionCode::TurnStep, [4_096, -100]),
        Displacement::ZERO
    );
}

#[test]
fn decode_reverts_encode() {
    for code in [ActionCode::Displacement, ActionCode::TurnStep] {
        for (dx_mm, dy_mm) in [(250, 0), (-100, 90), (0, -250), (-170, -170), (3, 1)] {
            let original = Displacement { dx_mm, dy_mm };
            let decoded = code.decode(code.encode(original, 250), 250);
            assert!(
                decoded.minus(original).length_mm() <= 2,
                "{code:?} {original:?} {decoded:?}"
            );
        }
    }
}
