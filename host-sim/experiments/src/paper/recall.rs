//! Measures what maps and memory recall: actions from changes, samples like the present, map error.

use super::observer::{ObservedDecision, change, length};
use amp::action_map::Probe;
use amp::config::Config;
use amp::fixed::{Mask, Weight};
use amp::memory::from_bytes;
use amp::planner::difference;
use amp::som::Som;
use sim::pilot::SimState;
use sim::statistics::mean;

/// Recall of actions from changes that were not learned.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ActionRecall {
    /// Angle between the recalled and the true displacement, degrees in [0, 180], by move.
    pub errors_deg: Vec<f64>,
}

impl ActionRecall {
    /// Probes the action map of `state` with the changes in another memory.
    #[must_use]
    pub fn of(state: &SimState, others: &SimState, config: &Config<16>) -> Self {
        let probe = Probe {
            recall: config.planning.recall,
            preference: None,
        };
        let mut errors_deg = Vec::new();
        for sample in others.memory().samples() {
            let wanted = difference(&from_bytes(&sample.after).0, &from_bytes(&sample.before).0);
            if wanted.iter().all(|value| *value == Weight::ZERO) || sample.executed.length_mm() == 0
            {
                continue;
            }
            let answer = state.actions().recall(&wanted, Mask::ALL, probe, Mask::ALL);
            let code = if config.planning.together {
                answer.together
            } else {
                answer.alone
            };
            let action = config.action_code.decode(code, config.robot.step_mm);
            let off = action.bearing().minus(sample.executed.bearing());
            let turns = f64::from(off.as_signed_turns()).abs() / 65_536.0;
            errors_deg.push(turns * 360.0);
        }
        Self { errors_deg }
    }
}

/// Number of samples that resemble the present situation: nearer than the mean change of a move.
/// Looks at every tenth situation of an episode.
#[must_use]
pub fn samples_alike(state: &SimState, observed: &[ObservedDecision]) -> Vec<usize> {
    let samples: Vec<_> = state
        .memory()
        .samples()
        .iter()
        .map(|sample| (from_bytes(&sample.before).0, from_bytes(&sample.after).0))
        .collect();
    let changes = samples
        .iter()
        .map(|(before, after)| length(&change(after, before)));
    let usual = mean(changes);
    let alike = |now: &ObservedDecision| {
        let near = |before: &[Weight]| length(&change(before, &now.situation)) < usual;
        samples.iter().filter(|(before, _)| near(before)).count()
    };
    observed.iter().step_by(10).map(alike).collect()
}

/// A situation map before and after online learning, evaluated on later situations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discreteness {
    /// Mean quantization error of the map after the random moves.
    pub error_before: f64,
    /// The same for the map after the behavior.
    pub error_after: f64,
    /// Number of neurons that win a situation, before.
    pub used_before: usize,
    /// Number of neurons that win a situation, after.
    pub used_after: usize,
}

impl Discreteness {
    /// Evaluates both maps on the same situations.
    #[must_use]
    pub fn of(before: &SimState, after: &SimState, observed: &[ObservedDecision]) -> Self {
        let situations: Vec<_> = observed.iter().map(|observed| observed.situation).collect();
        let judge = |map: &Som<16, 16>| {
            let (quality, hits) = map.quality(&situations);
            let error = quality.quantization_error();
            (error, hits.iter().filter(|&&hit| hit > 0).count())
        };
        let (error_before, used_before) = judge(before.situations());
        let (error_after, used_after) = judge(after.situations());
        Self {
            error_before,
            error_after,
            used_before,
            used_after,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::{observer::ObservedController, readings, rooms};
    use arena::world::World;
    use sim::behavior::Behavior;

    #[test]
    fn maps_recall_what_they_have_learned_and_memory_knows_its_samples() {
        let reading = &readings()[1];
        let world = World::random(1);
        let setup = rooms::setup(reading, Behavior::Avoid, 1, 20);
        let mut observer = ObservedController::new(reading.config.clone(), 10);
        sim::episode::run_with(&world, &setup, &mut observer, |_, _, _| {}).expect("an episode");
        let (Some(learned), Some(later)) = (observer.learned, observer.later) else {
            panic!("both states are kept");
        };
        let own = ActionRecall::of(&learned, &learned, &reading.config);
        assert!(own.errors_deg.len() >= 90);
        // The mean error of a random answer is 90°.
        let mean = mean(own.errors_deg.iter().copied());
        assert!(mean < 80.0, "{mean}");
        assert!(
            own.errors_deg
                .iter()
                .all(|error| (0.0..=180.0).contains(error))
        );
        // At the start of a sample the robot finds at least that sample.
        let mut there = observer.observed.first().copied().expect("a decision");
        there.situation = from_bytes(&learned.memory().samples()[7].before).0;
        assert!(samples_alike(&learned, &[there])[0] >= 1);
        let same = Discreteness::of(&learned, &learned, &observer.observed);
        assert_eq!(same.error_before, same.error_after);
        assert_ne!(Discreteness::of(&learned, &later, &observer.observed), same);
    }
}
