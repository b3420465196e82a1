use super::examples::Examples;
use super::family::{FAMILIES, Family};
use super::likelihood::Fit;
use super::parameters::{COUNT, Parameters};
use super::*;
use amp::config::Config;
use amp::fixed::Weight;
use amp::goal::{GoalFrame, Side};
use amp::planner::Planner;
use amp::som::{Grid, Som};
use amp::units::{Bearing, Range};
use arena::noise::Noise;

/// A robot whose values grow by a twentieth per step towards what a sensor looks at.
fn actions() -> ActionMap<16, 16> {
    let unit = |neuron: usize, sensor: usize| {
        let angle = std::f64::consts::TAU * (sensor as f64 - neuron as f64) / 16.0;
        libm::cos(angle)
    };
    let changes = std::array::from_fn(|neuron| {
        std::array::from_fn(|sensor| Weight::from_num(0.05 * unit(neuron, sensor)))
    });
    let codes =
        std::array::from_fn(|neuron| [unit(neuron, 0), unit(neuron, 4)].map(Weight::from_num));
    ActionMap::new(grid(), changes, codes)
}

fn grid() -> Grid {
    Grid::rectangle(4, 4)
}

fn planned(goal: &Goal<16>, situation: &Situation<16>, course: Displacement) -> Displacement {
    let config = Config::recommended();
    let situations = Som::zeroed(grid());
    let actions = actions();
    let planner = Planner {
        config: &config,
        situations: &situations,
        actions: &actions,
        enabled: Mask::ALL,
        allowed: Mask::ALL,
        current: None,
        course,
        cut: false,
    };
    planner.plan(situation, goal).action
}

/// What an exact ring perceives `gap_m` from an endless wall whose normal is at `normal` turns.
fn beside_a_wall(gap_m: f64, normal: f64) -> Situation<16> {
    std::array::from_fn(|sensor| {
        let off = (sensor as f64 / 16.0 - normal) * std::f64::consts::TAU;
        let along = libm::cos(off);
        let range_m = if along > 0.05 { gap_m / along } else { 99.0 };
        Weight::from_num((1.0 - range_m / 4.5).clamp(0.0, 1.0))
    })
}

/// Steps beside walls at all gaps and bearings, as the goal plans them.
fn shown(goal: &Goal<16>, seed: u64, steps: usize) -> Vec<ShownStep> {
    shown_between(goal, seed, steps, [0.0, 1.0])
}

/// The same with the wall at these bearings.
fn shown_between(goal: &Goal<16>, seed: u64, steps: usize, [from, to]: [f64; 2]) -> Vec<ShownStep> {
    let mut noise = Noise::new(seed);
    let step = |_| {
        let situation = beside_a_wall(noise.uniform_in(0.2, 1.4), noise.uniform_in(from, to));
        let course = Bearing::from_turns((noise.uniform_in(0.0, 1.0) * 65_535.0) as u16);
        let course = Displacement::along(course, 250);
        ShownStep {
            situation,
            known: Mask::ALL,
            course,
            moved: planned(goal, &situation, course),
        }
    };
    (0..steps).map(step).collect()
}

fn wall() -> Goal<16> {
    Goal::wall(Side::Right, Range::from_mm(600), &Config::recommended())
}

fn demonstration<'a>(shown: &'a [ShownStep], actions: &'a ActionMap<16, 16>) -> Demonstration<'a> {
    Demonstration {
        shown,
        actions,
        step_mm: 250,
    }
}

/// Where nothing was shown the robot goes as the goal that was not told would have it.
#[test]
fn the_goal_of_a_wall_is_found_from_its_moves() {
    let actions = actions();
    let steps = shown(&wall(), 1, 120);
    let mut calls = Vec::new();
    let found = goal_of_demonstrations(&[demonstration(&steps, &actions)], |done, all| {
        calls.push((done, all));
    });
    let found = found.unwrap();
    assert_eq!(found.frame, GoalFrame::Travel);
    let off = |goal: &Goal<16>| {
        let tests = shown(&wall(), 2, 200);
        let off = tests.iter().filter(|step| {
            let moved = planned(goal, &step.situation, step.course);
            let turns = moved.bearing().minus(step.moved.bearing());
            turns.as_signed_turns().unsigned_abs() > 4_200
        });
        off.count()
    };
    let (found_off, avoiding_off) = (off(&found), off(&Goal::free_of_obstacles()));
    assert!(found_off <= 30, "{found_off} of 200 moves differ");
    assert!(avoiding_off >= 100, "{avoiding_off}");
    let (done, all) = calls.last().unwrap();
    assert_eq!((done, calls.len()), (all, *all as usize));
    // The same demonstration, the same goal.
    let again = goal_of_demonstrations(&[demonstration(&steps, &actions)], |_, _| {});
    assert_eq!(again, Ok(found));
}

/// Standing where it is right and shorter steps towards it: a goal without progress.
#[test]
fn a_goal_that_is_stood_at_has_no_progress() {
    let actions = actions();
    let place = Goal {
        cap: Weight::ONE,
        ..Goal::perceived(&beside_a_wall(0.6, 0.25))
    };
    let steps = shown_between(&place, 3, 80, [0.2, 0.3]);
    let found = goal_of_demonstrations(&[demonstration(&steps, &actions)], |_, _| {});
    assert_eq!(found.unwrap().progress_q16, 0);
}

/// A corner looks the same from all bearings once it is turned, though neither its nearest place
/// nor the motion tells by how much.
#[test]
fn a_start_turns_situations_to_their_common_pattern() {
    let actions = actions();
    let mut corner = [Weight::from_num(0.1); 16];
    corner[..5].copy_from_slice(&[0.8, 0.5, 0.3, 0.5, 0.8].map(Weight::from_num));
    let step = |index: usize| {
        let mut situation = corner;
        situation.rotate_right(index % 16);
        let bearing = Bearing::of_place(index * 7 % 16, 16);
        ShownStep {
            situation,
            known: Mask::ALL,
            course: Displacement::ZERO,
            moved: Displacement::along(bearing, if index < 16 { 250 } else { 0 }),
        }
    };
    let steps: Vec<_> = (0..32).map(step).collect();
    let examples = Examples::new(&[demonstration(&steps, &actions)]);
    let widest = |stands: bool| {
        let frame = GoalFrame::Travel;
        let starts = start::starts(&examples, Family { frame, stands });
        let widths = starts.iter().map(|start| {
            let widths = (0..16).map(|component| start.high[component] - start.low[component]);
            widths.fold(0.0, f64::max)
        });
        widths.collect::<Vec<_>>()
    };
    let (onward, standing) = (widest(false), widest(true));
    // All situations, then those alone in which it stood.
    assert_eq!((onward.len(), standing.len()), (10, 20));
    for widths in [&onward[..], &standing[..10], &standing[10..]] {
        // By the motion and by the nearest thing, then by three patterns; each start twice, with
        // less and with more left out.
        assert!(widths[..3].iter().all(|width| *width > 0.1), "{widths:?}");
        assert!(widths[4..].iter().all(|width| *width < 0.01), "{widths:?}");
    }
}

/// The control asks for what was common, and does not explain the moves.
#[test]
fn the_spread_alone_is_another_goal() {
    let actions = actions();
    let steps = shown(&wall(), 1, 120);
    let demonstrations = [demonstration(&steps, &actions)];
    let spread = goal_of_spread(&demonstrations).unwrap();
    assert_ne!(
        goal_of_demonstrations(&demonstrations, |_, _| {}),
        Ok(spread)
    );
    assert_eq!(
        goal_of_spread(&[demonstration(&steps[..5], &actions)]),
        Err(DemonstrationError::TooFewMoves { moves: 5 })
    );
}

fn parameters(seed: u64) -> Parameters {
    let mut noise = Noise::new(seed);
    let low: [f64; 16] = std::array::from_fn(|_| noise.uniform_in(0.1, 0.5));
    Parameters {
        weights: std::array::from_fn(|_| noise.uniform_in(0.5, 9.0)),
        high: low.map(|low| low + 0.1),
        low,
        progress: 0.7,
        heading_hold: 1.3,
    }
}

/// Each derivative against a small difference of the loss.
#[test]
fn the_gradient_is_that_of_the_loss() {
    let actions = actions();
    let mut steps = shown(&wall(), 4, 12);
    // Unknown values, standing and half steps have derivatives too.
    steps[3].known = Mask::ALL.without(5);
    steps[4].moved = Displacement::ZERO;
    steps[5].moved = steps[5].moved.with_length(125);
    let examples = Examples::new(&[demonstration(&steps, &actions)]);
    for family in FAMILIES {
        let loss = |parameters: Parameters| {
            let mut gradient = [0.0; COUNT];
            let fit = Fit::new(family, parameters);
            (fit.loss_of(&examples, &mut gradient), gradient)
        };
        let at = parameters(5);
        let (_, gradient) = loss(at.clone());
        for (index, expected) in gradient.into_iter().enumerate() {
            let shifted = |by: f64| loss(shifted(&at, index, by)).0;
            let slope = 12.0 * (shifted(1e-5) - shifted(-1e-5)) / 2e-5;
            // Less probable directions are left out of both, at thresholds.
            let off = (slope - expected).abs();
            assert!(
                off < 2e-3,
                "{family:?} {index}: {slope} {}",
                gradient[index]
            );
        }
    }
}

/// One parameter shifted: weights and preferences by their logarithms.
fn shifted(at: &Parameters, index: usize, by: f64) -> Parameters {
    let mut next = at.clone();
    match index {
        0..16 => next.weights[index] *= libm::exp(by),
        16..32 => next.low[index - 16] += by,
        32..48 => next.high[index - 32] += by,
        48 => next.progress *= libm::exp(by),
        _ => next.heading_hold *= libm::exp(by),
    }
    next
}

#[test]
fn situations_in_common_are_intervals_weighted_by_their_spread() {
    let one: Situation<16> = std::array::from_fn(|sensor| Weight::from_num(sensor as f64 / 16.0));
    let known = Mask::ALL.without(2);
    let goal = goal_of_situations(&[(one, known)]).unwrap();
    assert_eq!(goal, Goal::perceived(&one).for_known(known));
    let mut other = one;
    other[4] = Weight::from_num(0.5);
    let goal = goal_of_situations(&[(one, known), (other, known)]).unwrap();
    let [unknown, same, varied] = [2, 5, 4].map(|sensor| goal.components[sensor]);
    assert_eq!(unknown, Component::ANY);
    assert_eq!((same.low, same.high, same.weight), (one[5], one[5], 16));
    assert_eq!(
        (varied.low, varied.high, varied.weight),
        (one[4], other[4], 1)
    );
    assert_eq!((goal.frame, goal.progress_q16), (GoalFrame::Ring, 0));
}

#[test]
fn too_little_is_refused_in_a_sentence() {
    let actions = actions();
    let goal =
        |steps: &[ShownStep]| goal_of_demonstrations(&[demonstration(steps, &actions)], |_, _| {});
    let steps = shown(&wall(), 6, 9);
    let refused = goal(&steps).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "a demonstration needs at least 10 moves, not 9"
    );
    let blind = ShownStep {
        known: Mask::NONE,
        ..steps[0]
    };
    assert_eq!(
        goal(&[blind; 20]),
        Err(DemonstrationError::NothingPerceived)
    );
    assert_eq!(
        goal_of_situations(&[]),
        Err(DemonstrationError::NothingPerceived)
    );
    let family = Family {
        frame: GoalFrame::Ring,
        stands: true,
    };
    assert_eq!(family.directions(), 1);
}
