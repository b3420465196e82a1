//! Fig. 3: one real decision with every value in it.
//!
//! The paper shows a decision that aims at a neighbor, with an obstacle on the left. Here it is the one with most to the
//! left, compared with what is to the right, of the first episode (its seed and the following ones) that has such a
//! decision at all.

use super::watch::{Seen, Watched};
use super::{Reading, rooms};
use amp::fixed::{Weight, Weight32, to_weight16};
use amp::goal::Goal;
use amp::memory::from_bytes;
use amp::planner::Why;
use amp::units::Displacement;
use arena::world::World;
use sim::behavior::Behavior;
use sim::episode::run_with;
use sim::error::EpisodeError;
use sim::pilot::SimState;

/// Decisions of an episode: as long as the path in Fig. 5, several times over.
pub const STEPS: u32 = 300;
/// Episodes searched.
const EPISODES: u64 = 100;
/// Samples shown.
const SHOWN: usize = 3;

/// One random move as it is remembered.
#[derive(Debug, Clone, PartialEq)]
pub struct Remembered {
    /// Situation before it.
    pub before: Vec<f64>,
    /// Situation after it.
    pub after: Vec<f64>,
    /// What the base did, m in the ring's frame.
    pub moved_m: [f64; 2],
}

/// Everything Fig. 3 shows; letters as in the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct DecisionFigure {
    /// The preset.
    pub preset: &'static str,
    /// Seed of the episode.
    pub seed: u64,
    /// Which of its decisions, counted from 1.
    pub number: usize,
    /// How the neuron aimed at was chosen, as the mind names it.
    pub why: String,
    /// A: some of the samples, those that changed most.
    pub samples: Vec<Remembered>,
    /// How many samples there are.
    pub memory: usize,
    /// The situation map at that moment.
    pub situations: Vec<Vec<f64>>,
    /// The action map at that moment: changes.
    pub changes: Vec<Vec<f64>>,
    /// The action map at that moment: displacements, m.
    pub actions_m: Vec<[f64; 2]>,
    /// Neurons: of the goal, of the present situation, aimed at, that answered.
    pub neurons: [usize; 4],
    /// D: the present situation.
    pub present: Vec<f64>,
    /// E: the greatest value the goal allows each transducer.
    pub goal: Vec<f64>,
    /// F: the situation aimed at.
    pub aim: Vec<f64>,
    /// G: the change wanted.
    pub wanted: Vec<f64>,
    /// Components that already are as the goal wants them are left out of G.
    pub unmet_only: bool,
    /// The displacement asked for, m in the ring's frame.
    pub action_m: [f64; 2],
}

/// The decision, in the arena after Fig. 5.
///
/// # Errors
/// When an episode fails; [`EpisodeError::Silent`] when none of a hundred has a decision that aims at a neighbor.
pub fn decision(
    reading: &Reading,
    world: &World,
    seed: u64,
) -> Result<DecisionFigure, EpisodeError> {
    for seed in (0..EPISODES).map(|i| seed.wrapping_add(i)) {
        let setup = rooms::setup(reading, Behavior::Avoid, seed, STEPS);
        let watch = |keep_after| {
            let mut watched = Watched::new(reading.config.clone(), keep_after);
            run_with(world, &setup, &mut watched, |_, _, _| {}).map(|_| watched)
        };
        let Some(chosen) = telling(&watch(0)?.seen) else {
            continue;
        };
        // Once more: the maps go on learning, and are shown as they were at that moment.
        let watched = watch(chosen + 1)?;
        if let (Some(seen), Some(state)) = (watched.seen.get(chosen), &watched.later) {
            return Ok(figure(reading, seed, chosen + 1, seen, state));
        }
    }
    Err(EpisodeError::Silent)
}

/// The decision that aims at a neighbor with most to the left, the first of equals.
fn telling(seen: &[Seen]) -> Option<usize> {
    let to_the_left = |now: &Seen| -> i32 {
        let sum = |places: std::ops::Range<usize>| -> i32 {
            let values = now.situation.get(places).unwrap_or_default();
            values.iter().map(|value| i32::from(value.to_bits())).sum()
        };
        sum(2..7) - sum(10..15)
    };
    let decisions = seen.iter().enumerate();
    decisions
        .filter(|(_, now)| now.plan.why == Why::Neighbour && to_the_left(now) > 0)
        .max_by_key(|(i, now)| (to_the_left(now), std::cmp::Reverse(*i)))
        .map(|(i, _)| i)
}

fn figure(
    reading: &Reading,
    seed: u64,
    number: usize,
    seen: &Seen,
    state: &SimState,
) -> DecisionFigure {
    let config = &reading.config;
    let goal = Goal::avoiding(config);
    let plan = &seen.plan;
    let rows = |code: &[[Weight32; 16]; 16]| -> Vec<Vec<f64>> {
        code.iter()
            .map(|row| row.iter().map(|value| value.to_num()).collect())
            .collect()
    };
    let actions = state.actions().actions().code();
    let decode = |code: &[Weight32; 2]| {
        let step = config.robot.step_mm;
        meters(config.action_code.decode(code.map(to_weight16), step))
    };
    DecisionFigure {
        preset: reading.name,
        seed,
        number,
        why: plan.why.to_string(),
        samples: samples(state),
        memory: state.memory().samples().len(),
        situations: rows(state.situations().code()),
        changes: rows(state.actions().changes().code()),
        actions_m: actions.iter().map(decode).collect(),
        neurons: [
            plan.goal_neuron,
            plan.current_neuron,
            plan.intermediate_neuron,
            plan.action_neuron,
        ]
        .map(usize::from),
        present: values(&seen.situation),
        goal: goal.components.iter().map(|c| c.high.to_num()).collect(),
        aim: values(&seen.aim),
        wanted: values(&plan.wanted),
        unmet_only: config.planning.unmet_only,
        action_m: meters(plan.action),
    }
}

/// Those samples of the memory that changed most, in their order.
fn samples(state: &SimState) -> Vec<Remembered> {
    let all: Vec<_> = state
        .memory()
        .samples()
        .iter()
        .map(|sample| Remembered {
            before: values(&from_bytes(&sample.before).0),
            after: values(&from_bytes(&sample.after).0),
            moved_m: meters(sample.executed),
        })
        .collect();
    let changed = |sample: &Remembered| -> f64 {
        let pairs = sample.before.iter().zip(&sample.after);
        pairs.map(|(a, b)| (a - b).abs()).sum()
    };
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by(|&a, &b| changed(&all[b]).total_cmp(&changed(&all[a])));
    order.truncate(SHOWN);
    order.sort_unstable();
    order.into_iter().map(|i| all[i].clone()).collect()
}

fn values(weights: &[Weight]) -> Vec<f64> {
    weights.iter().map(|value| value.to_num()).collect()
}

fn meters(displacement: Displacement) -> [f64; 2] {
    [displacement.dx_mm, displacement.dy_mm].map(|mm| f64::from(mm) / 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::readings;

    #[test]
    fn the_values_of_a_decision_belong_together() {
        let world = World::paper().expect("the arena");
        for reading in &readings()[1..] {
            let shown = decision(reading, &world, 1).expect("an episode");
            assert_eq!((shown.memory, shown.samples.len()), (100, SHOWN));
            assert_eq!(
                (shown.preset, shown.why.as_str()),
                (reading.name, "neighbor")
            );
            assert_ne!(shown.neurons[1], shown.neurons[2]);
            for (i, wanted) in shown.wanted.iter().enumerate() {
                let gap = shown.aim[i] - shown.present[i];
                let left_out = shown.unmet_only && *wanted == 0.0;
                assert!(
                    left_out || (gap - wanted).abs() < 1e-9,
                    "{} {i}",
                    reading.name
                );
            }
            assert_eq!(shown, decision(reading, &world, 1).expect("an episode"));
        }
    }
}
