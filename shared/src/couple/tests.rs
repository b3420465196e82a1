use super::solver::{KeepOff, solve};
use super::*;
use crate::fixed::Weight32;
use crate::goal::Component;
use proptest::prelude::*;
use std::vec::Vec as List;

fn weights<const N: usize>(values: [f64; N]) -> [Weight; N] {
    values.map(Weight::from_num)
}

/// Two links of half a length in the plane: hand (x, y), then both joints, each in [0, 1].
fn arm([first, second]: [f64; 2]) -> [Weight; 4] {
    let x = 0.5 + (libm::cos(first) + libm::cos(first + second)) / 4.0;
    let y = 0.5 + (libm::sin(first) + libm::sin(first + second)) / 4.0;
    weights([x, y, first / 3.0 + 0.5, second / 2.5])
}

/// Joints move by 0.5 at most, and stop at ±1.5 and at 0 and 2.5.
fn moved([first, second]: [f64; 2], action: [Weight; 2]) -> [f64; 2] {
    let [a, b] = action.map(|share| share.to_num::<f64>() / 2.0);
    [(first + a).clamp(-1.5, 1.5), (second + b).clamp(0.0, 2.5)]
}

fn sample(from: [f64; 2], to: [f64; 2]) -> CoupleSample<4, 2> {
    CoupleSample {
        before: arm(from),
        action: weights([(to[0] - from[0]) * 2.0, (to[1] - from[1]) * 2.0]),
        after: arm(to),
    }
}

/// A generator of numbers in [0, 1).
struct Draws(Xoshiro128PlusPlus);

impl Draws {
    fn new(seed: u64) -> Self {
        Self(Xoshiro128PlusPlus::seed_from_u64(seed))
    }

    fn next(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / 4_294_967_296.0
    }
}

/// An arm after 100 random moves, and where it stands.
fn explored(seed: u64) -> (CoupleConfig, Couple<4, 2, 16, 100>, [f64; 2]) {
    let config = CoupleConfig::of_grid(4, 4);
    let mut couple = Couple::new(&config, seed);
    let (mut draws, mut posture) = (Draws::new(seed), [0.0, 1.25]);
    for _ in 0..100 {
        let action = [0, 1].map(|_| draws.next() * 2.0 - 1.0);
        let next = moved(posture, weights(action));
        assert!(couple.remember(sample(posture, next)));
        posture = next;
    }
    while !couple.learn(&config) {}
    (config, couple, posture)
}

fn hand_at(situation: [Weight; 4]) -> CoupleGoal<4> {
    let [x, y, ..] = situation.map(Component::equal);
    let free = Component {
        weight: 1,
        ..Component::ANY
    };
    let mut goal = CoupleGoal::of([x, y, free, free]);
    goal.goal.tolerance = Weight::from_num(0.005);
    goal
}

fn hand_gap(a: [Weight; 4], b: [Weight; 4]) -> f64 {
    let gap = |i: usize| a[i].to_num::<f64>() - b[i].to_num::<f64>();
    libm::hypot(gap(0), gap(1))
}

#[test]
fn an_arm_reaches_targets_after_100_random_moves() {
    let (config, mut couple, mut posture) = explored(5);
    let mut draws = Draws::new(6);
    let mut reached = 0;
    for _ in 0..100 {
        let target = arm([draws.next() * 3.0 - 1.5, draws.next() * 2.5]);
        let (goal, mut seek) = (hand_at(target), Seek::new());
        for _ in 0..30 {
            let plan = couple.plan(&config, &arm(posture), &goal, &mut seek);
            let next = moved(posture, plan.action);
            couple.correct(&config, &sample(posture, next));
            posture = next;
        }
        reached += u32::from(hand_gap(arm(posture), target) < 0.01);
    }
    assert!(reached >= 97, "{reached} of 100");
}

#[test]
fn the_same_seed_gives_the_same_maps_in_any_number_of_calls() {
    let (config, couple, _) = explored(1);
    assert_eq!(couple, explored(1).1);
    assert_ne!(couple, explored(2).1);
    let mut other = Couple::<4, 2, 16, 100>::new(&config, 1);
    for sample in couple.memory() {
        assert!(other.remember(*sample));
    }
    let calls = std::iter::repeat_with(|| other.learn(&config)).take_while(|is_over| !is_over);
    // 16 presentations by call, 10 000 in all.
    assert_eq!(calls.count(), 624);
    assert_eq!(other, couple);
    // Over is over.
    assert!(other.learn(&config));
    assert_eq!(other, couple);
}

#[test]
fn a_full_memory_takes_no_more_and_an_empty_one_teaches_nothing() {
    let config = CoupleConfig::of_grid(2, 2);
    let mut couple = Couple::<4, 2, 4, 1>::new(&config, 1);
    assert!(couple.learn(&config));
    let one = sample([0.0, 1.0], [0.3, 1.2]);
    assert!(couple.remember(one));
    assert!(!couple.remember(sample([0.3, 1.2], [0.0, 1.0])));
    assert_eq!(couple.memory(), [one]);
}

#[test]
fn a_goal_that_holds_needs_no_action() {
    let (config, couple, posture) = explored(3);
    let goal = hand_at(arm(posture));
    let plan = couple.plan(&config, &arm(posture), &goal, &mut Seek::new());
    assert!(plan.at_goal);
    assert_eq!(plan.action, [Weight::ZERO; 2]);
    assert_eq!(plan.expected, arm(posture));
    assert_eq!(plan.subgoal_neuron, None);
}

#[test]
fn where_progress_ends_neurons_are_pursued_one_after_the_other() {
    let (config, couple, _) = explored(4);
    let target = arm([1.4, 0.2]);
    let (goal, mut seek) = (hand_at(target), Seek::new());
    // The arm is held: nothing is ever reached.
    let stuck = arm([-1.4, 2.4]);
    let pursued: List<_> = (0..400)
        .map(|_| {
            couple
                .plan(&config, &stuck, &goal, &mut seek)
                .subgoal_neuron
        })
        .collect();
    let best = (0..16).min_by_key(|k| goal.deviation(&couple.situations().code_vector(*k)));
    assert_eq!(pursued[0], best);
    // Four moves without progress, then the goal, then another neuron.
    assert_eq!(pursued[5], None);
    let mut order: List<_> = pursued.iter().flatten().copied().collect();
    order.dedup();
    let mut first: List<_> = order[..16].to_vec();
    let deviations: List<_> = (first.iter())
        .map(|k| goal.deviation(&couple.situations().code_vector(*k)))
        .collect();
    assert!(deviations.is_sorted(), "{deviations:?}");
    first.sort_unstable();
    assert_eq!(first, (0..16).collect::<List<_>>());
    // All were tried: from the beginning.
    assert_eq!(order[16], order[0]);
}

#[test]
fn a_region_is_a_ball_or_a_box_with_round_edges() {
    let half = Component::equal(Weight::from_num(0.5));
    let wide = Component {
        low: Weight::from_num(0.25),
        high: Weight::from_num(0.75),
        weight: 1,
    };
    let region = |components| Avoided {
        components,
        distance: Weight::from_num(0.125),
    };
    let ball = region([half, half, Component::ANY]);
    let rounded = region([wide, half, Component::ANY]);
    let at = |x: f64, y: f64| weights([x, y, 0.0]);
    // 3-4-5: 0.25 away.
    assert_eq!(ball.clearance(&at(0.65, 0.7)), 1_023);
    assert_eq!(ball.clearance(&at(0.5, 0.5)), -1_024);
    assert_eq!(rounded.clearance(&at(0.7, 0.5)), -1_024);
    assert_eq!(rounded.clearance(&at(0.75, 0.75)), 1_024);
    assert_eq!(rounded.clearance(&at(0.9, 0.7)), 1_023);
}

#[test]
fn the_hand_goes_around_what_is_to_be_avoided() {
    let (config, mut couple, _) = explored(7);
    let (start, target) = ([-0.9, 1.3], arm([0.9, 1.3]));
    let entered = |avoids: bool, couple: &mut Couple<4, 2, 16, 100>| {
        let mut goal = hand_at(target);
        let middle = arm([0.0, 1.3]);
        let region = Avoided {
            components: [
                Component::equal(middle[0]),
                Component::equal(middle[1]),
                Component::ANY,
                Component::ANY,
            ],
            distance: Weight::from_num(0.07),
        };
        goal.avoided = avoids.then_some(region);
        let (mut posture, mut seek, mut entered) = (start, Seek::new(), 0);
        for _ in 0..40 {
            let plan = couple.plan(&config, &arm(posture), &goal, &mut seek);
            let next = moved(posture, plan.action);
            couple.correct(&config, &sample(posture, next));
            posture = next;
            entered += u32::from(region.clearance(&arm(posture)) < 0);
        }
        assert!(hand_gap(arm(posture), target) < 0.01, "{avoids}");
        entered
    };
    assert!(entered(false, &mut couple) > 0);
    assert_eq!(entered(true, &mut couple), 0);
}

/// What an action costs, in floats.
fn cost(rows: &[[f64; 4]; 3], from: &[f64; 4], bounds: &[[f64; 3]; 4], action: &[f64; 3]) -> f64 {
    let value = |v: usize| from[v] + (0..3).map(|a| rows[a][v] * action[a]).sum::<f64>();
    let gap = |v: usize| value(v) - value(v).clamp(bounds[v][0], bounds[v][1]);
    let deviations: f64 = (0..4).map(|v| bounds[v][2] * gap(v) * gap(v)).sum();
    deviations
        + action
            .iter()
            .map(|share| 1.2e-4 * share * share)
            .sum::<f64>()
}

/// The best action by projected gradients, in floats.
fn reference(rows: &[[f64; 4]; 3], from: &[f64; 4], bounds: &[[f64; 3]; 4]) -> [f64; 3] {
    let mut action = [0.0; 3];
    for _ in 0..20_000 {
        let slope: [f64; 3] = core::array::from_fn(|a| {
            let mut shifted = [action, action];
            shifted[0][a] += 1e-5;
            shifted[1][a] -= 1e-5;
            let [above, below] = shifted.map(|action| cost(rows, from, bounds, &action));
            (above - below) / 2e-5
        });
        for (share, slope) in action.iter_mut().zip(slope) {
            *share = (*share - slope * 0.05).clamp(-1.0, 1.0);
        }
    }
    action
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_action_is_that_of_least_squares_within_bounds(
        rows in prop::array::uniform3(prop::array::uniform4(-0.5_f64..0.5)),
        from in prop::array::uniform4(0.0_f64..1.0),
        low in prop::array::uniform4(0.0_f64..1.0),
        width in prop::array::uniform4(0.0_f64..0.3),
        weight in prop::array::uniform4(0_u8..4),
    ) {
        let bits = |value: f64| Weight::from_num(value);
        let component = |v: usize| Component { low: bits(low[v]), high: bits(low[v] + width[v]), weight: weight[v] };
        let rows32 = rows.map(|row| row.map(Weight32::from_num));
        let found = solve(&rows32, &from.map(bits), &core::array::from_fn(component), None);
        let bounds = core::array::from_fn(|v| [low[v], low[v] + width[v], f64::from(weight[v])]);
        let exact = reference(&rows, &from, &bounds);
        let found = found.map(|share| share.to_num::<f64>());
        let (found, exact) = (cost(&rows, &from, &bounds, &found), cost(&rows, &from, &bounds, &exact));
        prop_assert!(found <= exact + 2e-3 + 0.02 * exact, "{} {}", found, exact);
    }

    #[test]
    fn a_correction_follows_the_formula(
        action in prop::array::uniform2(-1.0_f64..1.0),
        rows in prop::array::uniform2(prop::array::uniform4(-0.4_f64..0.4)),
        change in prop::array::uniform4(-0.3_f64..0.3),
    ) {
        prop_assume!(action[0].abs() + action[1].abs() > 0.2);
        let (whole, grid) = (Update::new(Neighborhood::Direct, 1.0, 0.0), Grid::chain(1));
        let mut effects = Effects::<4, 2, 1>::zeroed(grid);
        // Each row by a move of one actuator.
        let taken = |action: [f64; 2], change: [f64; 4]| CoupleSample {
            before: weights([0.5; 4]),
            action: weights(action),
            after: weights(change.map(|part| 0.5 + part)),
        };
        effects.correct(0, &taken([1.0, 0.0], rows[0]), &whole);
        effects.correct(0, &taken([0.0, 1.0], rows[1]), &whole);
        effects.correct(0, &taken(action, change), &whole);
        let squared = action[0] * action[0] + action[1] * action[1];
        for (a, row) in effects.rows(0).iter().enumerate() {
            for (v, found) in row.iter().enumerate() {
                let error = change[v] - action[0] * rows[0][v] - action[1] * rows[1][v];
                let exact = rows[a][v] + action[a] * error / squared;
                let limited = exact.clamp(-1.0, 1.0);
                prop_assert!((found.to_num::<f64>() - limited).abs() < 4e-3, "{} {}", found, exact);
            }
        }
        // The move is predicted now.
        let expected = effects.expected(0, &weights([0.5; 4]), &weights(action));
        let is_limited = effects.rows(0).as_flattened().iter().any(|part| part.to_num::<f64>().abs() > 0.99);
        for (value, part) in expected.iter().zip(change) {
            prop_assert!(is_limited || (value.to_num::<f64>() - 0.5 - part).abs() < 1e-3, "{} {}", value, part);
        }
    }
}

#[test]
fn an_action_stays_outside_a_half_space_and_within_its_length() {
    let one = Weight32::from_num(0.4);
    let rows = [[one, Weight32::ZERO], [Weight32::ZERO, one]];
    let bounds = [
        Component::equal(Weight::from_num(0.9)),
        Component::equal(Weight::from_num(0.7)),
    ];
    let from = weights([0.5, 0.5]);
    let free = solve(&rows, &from, &bounds, None).map(|share| share.to_num::<f64>());
    assert!(
        (free[0] - 1.0).abs() < 0.01 && (free[1] - 0.5).abs() < 0.01,
        "{free:?}"
    );
    // Along −x by 0.1 at least: x must not rise.
    let keep_off = KeepOff {
        normal: [-(1 << 20), 0],
        least: (1 << 20) / 10,
        longest: 1 << 18,
    };
    let kept = solve(&rows, &from, &bounds, Some(&keep_off)).map(|share| share.to_num::<f64>());
    assert!(
        (kept[0] + 0.25).abs() < 0.02 && (kept[1] - 0.25).abs() < 0.01,
        "{kept:?}"
    );
}

#[test]
fn a_move_that_hardly_happened_teaches_nothing() {
    let mut effects = Effects::<4, 2, 1>::zeroed(Grid::chain(1));
    let mut taken = sample([0.0, 1.0], [0.3, 1.2]);
    taken.action = [Weight::from_bits(40), Weight::from_bits(40)];
    effects.correct(0, &taken, &Update::new(Neighborhood::Direct, 1.0, 0.0));
    assert_eq!(effects, Effects::zeroed(Grid::chain(1)));
}
