//! Fig. 3: one real decision with all its values.
//!
//! The paper's decision aims at a neighbor, with an obstacle on the left. Here: the decision with
//! the largest difference between left and right, in the first episode that has such a decision.

use super::observer::{ObservedController, ObservedDecision};
use super::{PaperReading, rooms};
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

/// Decisions of an episode: several times the length of the path in Fig. 5.
pub const STEPS: u32 = 300;
/// Largest number of episodes searched.
const EPISODES: u64 = 100;
/// Number of samples shown.
const SHOWN: usize = 3;

/// One random move from the memory.
#[derive(Debug, Clone, PartialEq)]
pub struct MemorySample {
    /// Situation before it.
    pub before: Vec<f64>,
    /// Situation after it.
    pub after: Vec<f64>,
    /// What the base did, m in the ring's frame.
    pub moved_m: [f64; 2],
}

/// All values of Fig. 3; letters as in the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct DecisionFigure {
    /// The preset.
    pub preset: &'static str,
    /// Seed of the episode.
    pub seed: u64,
    /// Number of the decision in its episode, counted from 1.
    pub number: usize,
    /// How the subgoal was chosen, in the controller's words.
    pub why: String,
    /// A: the samples that changed most.
    pub samples: Vec<MemorySample>,
    /// Number of samples in the memory.
    pub memory: usize,
    /// Code vectors of the situation map at that moment.
    pub situations: Vec<Vec<f64>>,
    /// Changes of the action map at that moment.
    pub changes: Vec<Vec<f64>>,
    /// Displacements of the action map at that moment, m.
    pub actions_m: Vec<[f64; 2]>,
    /// Neurons: goal, present situation, subgoal, answer of the action map.
    pub neurons: [usize; 4],
    /// D: the present situation.
    pub present: Vec<f64>,
    /// E: the largest value that the goal allows each transducer.
    pub goal: Vec<f64>,
    /// F: the situation of the subgoal.
    pub aim: Vec<f64>,
    /// G: the wanted change.
    pub wanted: Vec<f64>,
    /// G leaves out the components that already meet the goal.
    pub unmet_only: bool,
    /// The displacement commanded, m in the ring's frame.
    pub action_m: [f64; 2],
}

/// Finds the decision, in the arena of Fig. 5.
///
/// # Errors
/// When an episode fails; [`EpisodeError::Silent`] when none of a hundred episodes has a decision
/// that aims at a neighbor.
pub fn decision(
    reading: &PaperReading,
    world: &World,
    seed: u64,
) -> Result<DecisionFigure, EpisodeError> {
    for seed in (0..EPISODES).map(|i| seed.wrapping_add(i)) {
        let setup = rooms::setup(reading, Behavior::Avoid, seed, STEPS);
        let run_observed = |keep_after| {
            let mut observer = ObservedController::new(reading.config.clone(), keep_after);
            run_with(world, &setup, &mut observer, |_, _, _| {}).map(|_| observer)
        };
        let Some(chosen) = most_lateral(&run_observed(0)?.observed) else {
            continue;
        };
        // Second run: the maps keep learning, and the figure shows them at that decision.
        let observer = run_observed(chosen + 1)?;
        if let (Some(observed), Some(state)) = (observer.observed.get(chosen), &observer.later) {
            return Ok(figure(reading, seed, chosen + 1, observed, state));
        }
    }
    Err(EpisodeError::Silent)
}

/// The decision toward a neighbor with the largest values on the left; the first among equals.
fn most_lateral(observed: &[ObservedDecision]) -> Option<usize> {
    let to_the_left = |now: &ObservedDecision| -> i32 {
        let sum = |places: std::ops::Range<usize>| -> i32 {
            let values = now.situation.get(places).unwrap_or_default();
            values.iter().map(|value| i32::from(value.to_bits())).sum()
        };
        sum(2..7) - sum(10..15)
    };
    let decisions = observed.iter().enumerate();
    decisions
        .filter(|(_, now)| now.plan.why == Why::Neighbor && to_the_left(now) > 0)
        .max_by_key(|(i, now)| (to_the_left(now), std::cmp::Reverse(*i)))
        .map(|(i, _)| i)
}

fn figure(
    reading: &PaperReading,
    seed: u64,
    number: usize,
    observed: &ObservedDecision,
    state: &SimState,
) -> DecisionFigure {
    let config = &reading.config;
    let goal = Goal::avoiding(config);
    let plan = &observed.plan;
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
            plan.subgoal_neuron,
            plan.action_neuron,
        ]
        .map(usize::from),
        present: values(&observed.situation),
        goal: goal.components.iter().map(|c| c.high.to_num()).collect(),
        aim: values(&observed.aim),
        wanted: values(&plan.wanted),
        unmet_only: config.planning.unmet_only,
        action_m: meters(plan.action),
    }
}

/// The samples of the memory that changed most, in their order.
fn samples(state: &SimState) -> Vec<MemorySample> {
    let all: Vec<_> = state
        .memory()
        .samples()
        .iter()
        .map(|sample| MemorySample {
            before: values(&from_bytes(&sample.before).0),
            after: values(&from_bytes(&sample.after).0),
            moved_m: meters(sample.executed),
        })
        .collect();
    let changed = |sample: &MemorySample| -> f64 {
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
