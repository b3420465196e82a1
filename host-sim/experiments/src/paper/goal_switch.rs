//! Effect of a change of goal on memory, maps and the very next decision.

use super::PaperReading;
use super::rooms::setup;
use amp::controller::{Command, Decision, Event, Outputs, handle};
use amp::goal::Goal;
use amp::scan::Situation;
use amp::units::Millis;
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::run_with;
use sim::error::EpisodeError;
use sim::pilot::{InspectableController, LocalController, Pilot, SimState};

/// A goal is changed at every 50th decision.
const EVERY: usize = 50;
/// Decisions of an episode.
const STEPS: u32 = 500;
/// The transducer that completes an exact ring.
const LAST: u8 = 15;

/// Results of the changes of goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GoalSwitches {
    /// Number of changes.
    pub tried: u32,
    /// Changes after which memory and both maps were identical, to the bit.
    pub unchanged: u32,
    /// Changes after which the next decision, from the same echoes, was another action.
    pub other_action: u32,
}

impl GoalSwitches {
    fn plus(self, other: Self) -> Self {
        Self {
            tried: self.tried + other.tried,
            unchanged: self.unchanged + other.unchanged,
            other_action: self.other_action + other.other_action,
        }
    }
}

/// While a robot avoids, finds what it would do next with each of these goals.
struct GoalSwitchProbe {
    mind: LocalController,
    goals: Vec<Behavior>,
    /// Situation before the first move.
    nest: Option<Situation<16>>,
    decisions: usize,
    answers: Vec<GoalSwitches>,
}

impl GoalSwitchProbe {
    fn ask(&mut self, before: &SimState, at: Millis, echo: Event<16>, own: &Decision<16>) {
        let Some(nest) = self.nest else { return };
        for (behavior, answer) in self.goals.iter().zip(&mut self.answers) {
            let config = self.mind.config();
            let goal: Goal<16> = behavior.goal(config, &nest);
            let mut twin = before.clone();
            let command = Event::Command(Command::Seek(goal));
            let _ = handle(config, &mut twin, at, command);
            answer.tried += 1;
            let same = twin.memory() == before.memory()
                && twin.situations() == before.situations()
                && twin.actions() == before.actions();
            answer.unchanged += u32::from(same);
            let decision = handle(config, &mut twin, at, echo).decision;
            answer.other_action += u32::from(decision.is_some_and(|d| d.wanted != own.wanted));
        }
    }
}

impl Pilot for GoalSwitchProbe {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let last = matches!(event, Event::Echo { sensor: LAST, .. });
        let due = last && self.decisions % EVERY == EVERY - 1;
        let before = due.then(|| self.mind.state().clone());
        let outputs = self.mind.handle(at, event);
        if let Some(decision) = &outputs.decision {
            self.nest.get_or_insert(decision.situation);
            if decision.plan.is_some() {
                self.decisions += 1;
                if let Some(before) = before {
                    self.ask(&before, at, event, decision);
                }
            }
        }
        outputs
    }
}

impl InspectableController for GoalSwitchProbe {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.mind.knowledge()
    }
}

/// Effect of a change to each of `names`, over rooms in order.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    reading: &PaperReading,
    names: &[&str],
    rooms: u32,
    seed: u64,
) -> Result<Vec<GoalSwitches>, EpisodeError> {
    let goals: Vec<Behavior> = names.iter().filter_map(|name| name.parse().ok()).collect();
    let answers: Result<Vec<_>, EpisodeError> = (0..u64::from(rooms))
        .into_par_iter()
        .map(|room| {
            let world = World::random(room.wrapping_add(1));
            let mut setup = setup(reading, Behavior::Avoid, seed.wrapping_add(room), STEPS);
            setup.record = false;
            let mut probe = GoalSwitchProbe {
                mind: LocalController::new(reading.config.clone()),
                answers: vec![GoalSwitches::default(); goals.len()],
                goals: goals.clone(),
                nest: None,
                decisions: 0,
            };
            run_with(&world, &setup, &mut probe, |_, _, _| {})?;
            Ok(probe.answers)
        })
        .collect();
    let none = vec![GoalSwitches::default(); goals.len()];
    Ok(answers?.iter().fold(none, |sums, room| {
        sums.into_iter()
            .zip(room)
            .map(|(a, b)| a.plus(*b))
            .collect()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::readings;

    #[test]
    fn the_same_goal_changes_nothing_and_another_one_the_action_alone() {
        let names = ["avoid", "wall-right"];
        let answers = measure(&readings()[0], &names, 2, 1).expect("episodes");
        let probe = 2 * STEPS / EVERY as u32;
        for answer in &answers {
            assert_eq!((answer.tried, answer.unchanged), (probe, probe));
        }
        assert_eq!(answers[0].other_action, 0);
        assert!(answers[1].other_action > probe / 2);
    }
}
