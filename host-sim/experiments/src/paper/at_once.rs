//! Another behavior at once: what a change of goal does to memory, maps and the very next decision.

use super::Reading;
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

/// Decisions from one question to the next: every 50th.
const EVERY: usize = 50;
/// Decisions of an episode.
const STEPS: u32 = 500;
/// The transducer that completes an exact ring.
const LAST: u8 = 15;

/// Changes of goal that were tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AtOnce {
    /// How many.
    pub tried: u32,
    /// After how many memory and both maps were the same, to the bit.
    pub unchanged: u32,
    /// After how many the next decision, from the same echoes, was another action.
    pub other_action: u32,
}

impl AtOnce {
    fn plus(self, other: Self) -> Self {
        Self {
            tried: self.tried + other.tried,
            unchanged: self.unchanged + other.unchanged,
            other_action: self.other_action + other.other_action,
        }
    }
}

/// Asks, while a robot avoids, what it would do next if it were given each of these goals now.
struct Asked {
    mind: LocalController,
    goals: Vec<Behavior>,
    /// What was perceived before the first move.
    nest: Option<Situation<16>>,
    decisions: usize,
    answers: Vec<AtOnce>,
}

impl Asked {
    fn ask(&mut self, before: &SimState, at: Millis, echo: Event<16>, own: &Decision<16>) {
        let Some(nest) = self.nest else { return };
        for (behavior, answer) in self.goals.iter().zip(&mut self.answers) {
            let config = self.mind.config();
            let goal: Goal<16> = behavior.goal(config, &nest);
            let mut twin = before.clone();
            let told = Event::Command(Command::Seek(goal));
            let _ = handle(config, &mut twin, at, told);
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

impl Pilot for Asked {
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

impl InspectableController for Asked {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.mind.knowledge()
    }
}

/// What a change to each of `names` does, over rooms in order.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    reading: &Reading,
    names: &[&str],
    rooms: u32,
    seed: u64,
) -> Result<Vec<AtOnce>, EpisodeError> {
    let goals: Vec<Behavior> = names.iter().filter_map(|name| name.parse().ok()).collect();
    let answers: Result<Vec<_>, EpisodeError> = (0..u64::from(rooms))
        .into_par_iter()
        .map(|room| {
            let world = World::random(room.wrapping_add(1));
            let mut setup = setup(reading, Behavior::Avoid, seed.wrapping_add(room), STEPS);
            setup.record = false;
            let mut asked = Asked {
                mind: LocalController::new(reading.config.clone()),
                answers: vec![AtOnce::default(); goals.len()],
                goals: goals.clone(),
                nest: None,
                decisions: 0,
            };
            run_with(&world, &setup, &mut asked, |_, _, _| {})?;
            Ok(asked.answers)
        })
        .collect();
    let none = vec![AtOnce::default(); goals.len()];
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
        let asked = 2 * STEPS / EVERY as u32;
        for answer in &answers {
            assert_eq!((answer.tried, answer.unchanged), (asked, asked));
        }
        assert_eq!(answers[0].other_action, 0);
        assert!(answers[1].other_action > asked / 2);
    }
}
