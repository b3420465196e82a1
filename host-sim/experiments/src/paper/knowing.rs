//! What the maps and the memory know: recall by a part of the content, samples alike, discreteness where it is needed.

use super::watch::{Seen, change, length};
use amp::action_map::Probe;
use amp::config::Config;
use amp::fixed::{Mask, Weight};
use amp::memory::from_bytes;
use amp::planner::difference;
use amp::som::Som;
use sim::pilot::SimState;

/// Recall of actions from changes that were not learned.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recalled {
    /// Angle between the displacement recalled and the one that brought the change, degrees in [0, 180], move by move.
    pub errors_deg: Vec<f64>,
}

impl Recalled {
    /// Probes the action map of `state` with the changes of another memory's moves.
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

/// Samples in the memory that are like the present situation: nearer to it than a move changes a situation on the average.
/// Every tenth situation of an episode is looked at.
#[must_use]
pub fn samples_alike(state: &SimState, seen: &[Seen]) -> Vec<usize> {
    let samples: Vec<_> = state
        .memory()
        .samples()
        .iter()
        .map(|sample| (from_bytes(&sample.before).0, from_bytes(&sample.after).0))
        .collect();
    let changes = samples
        .iter()
        .map(|(before, after)| length(&change(after, before)));
    let usual = changes.sum::<f64>() / samples.len().max(1) as f64;
    let alike = |now: &Seen| {
        let near = |before: &[Weight]| length(&change(before, &now.situation)) < usual;
        samples.iter().filter(|(before, _)| near(before)).count()
    };
    seen.iter().step_by(10).map(alike).collect()
}

/// A situation map before and after it went on learning, judged by what was perceived later on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Discreteness {
    /// Mean distance of situations to their code vectors, with the map as the random moves made it.
    pub error_before: f64,
    /// The same with the map as the behavior made it.
    pub error_after: f64,
    /// Neurons that answer, before.
    pub used_before: usize,
    /// Neurons that answer, after.
    pub used_after: usize,
}

impl Discreteness {
    /// Judges both maps by the same situations.
    #[must_use]
    pub fn of(before: &SimState, after: &SimState, seen: &[Seen]) -> Self {
        let situations: Vec<_> = seen.iter().map(|seen| seen.situation).collect();
        let judge = |map: &Som<16, 16>| {
            let (quality, hits) = map.quality(&situations);
            let error = quality.quantization_error_q21() as f64 / f64::from(1 << 21);
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
    use crate::paper::{readings, rooms, watch::Watched};
    use arena::world::World;
    use sim::behavior::Behavior;

    #[test]
    fn maps_recall_what_they_have_learned_and_memory_knows_its_samples() {
        let reading = &readings()[1];
        let world = World::random(1);
        let setup = rooms::setup(reading, Behavior::Avoid, 1, 20);
        let mut watched = Watched::new(reading.config.clone(), 10);
        sim::episode::run_with(&world, &setup, &mut watched, |_, _, _| {}).expect("an episode");
        let (Some(learned), Some(later)) = (watched.learned, watched.later) else {
            panic!("both states are kept");
        };
        let own = Recalled::of(&learned, &learned, &reading.config);
        assert!(own.errors_deg.len() >= 90);
        // Chance would be 90° off on the average.
        let mean = own.errors_deg.iter().sum::<f64>() / own.errors_deg.len() as f64;
        assert!(mean < 80.0, "{mean}");
        assert!(
            own.errors_deg
                .iter()
                .all(|error| (0.0..=180.0).contains(error))
        );
        // Put back to where a sample began, the robot finds at least that sample.
        let mut there = watched.seen.first().copied().expect("a decision");
        there.situation = from_bytes(&learned.memory().samples()[7].before).0;
        assert!(samples_alike(&learned, &[there])[0] >= 1);
        let same = Discreteness::of(&learned, &learned, &watched.seen);
        assert_eq!(same.error_before, same.error_after);
        assert_ne!(Discreteness::of(&learned, &later, &watched.seen), same);
    }
}
