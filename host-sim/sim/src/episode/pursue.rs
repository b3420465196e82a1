//! The last phase of an episode: one behavior, or several one after the other.

use super::drive::{Driver, Setup, educated, report};
use super::metrics::{Metrics, EpisodeReport};
use crate::error::EpisodeError;
use crate::pilot::{LocalController, Pilot};
use crate::behavior::{self, Behavior};
use amp::controller::Command;
use arena::world::World;

/// Carrying the robot takes so long that its shield has forgotten what it heard before, s.
pub const CARRIED_S: f64 = 601.0;

/// Explores and learns once, then pursues the behavior `times` times, each from a new scene: the reports of all.
///
/// # Errors
/// When the mind refuses a command or falls silent.
pub fn repeat(world: &World, setup: &Setup, times: u32) -> Result<Vec<EpisodeReport>, EpisodeError> {
    let mut mind = LocalController::new(setup.config.clone());
    let (mut driver, exploration) = educated(world, setup, &mut mind, None, |_, _, _| {})?;
    let mut reports = Vec::new();
    for _ in 0..times {
        driver.set_scene(setup);
        let began_s = driver.body.time_s();
        driver.pursue(&mut mind, setup, |_| {})?;
        let time_s = driver.body.time_s() - began_s;
        let success = driver.measure.success(&setup.behavior, &driver.tally);
        let tally = driver.next_phase(world);
        reports.push(report(world, setup, &exploration, &tally, time_s, success));
    }
    Ok(reports)
}

impl Driver<'_> {
    /// Sets the scene of a behavior: the robot elsewhere, a leader ahead of it.
    pub(super) fn set_scene(&mut self, setup: &Setup) {
        let behavior = &setup.behavior;
        let start = self.world.start().position;
        let nest = behavior.place(start).unwrap_or(start);
        if setup.set_down.is_some() || behavior.is_set_down_elsewhere() {
            self.body.wait(CARRIED_S);
            match setup.set_down {
                Some(place) => self.body.set_down_at(place),
                None => self.body.set_down_elsewhere(nest),
            }
        }
        if behavior.has_leader() {
            self.body.add_leader();
        }
        self.measure_from(nest);
    }

    /// Pursues the behavior's goals for `setup.steps` decisions in all.
    pub(super) fn pursue(
        &mut self,
        pilot: &mut impl Pilot,
        setup: &Setup,
        mut progress: impl FnMut(u32),
    ) -> Result<(), EpisodeError> {
        let parts = setup.behavior.parts();
        let alone = parts.len() == 1;
        for (number, part) in parts.iter().enumerate() {
            (self.behavior, self.part) = (part.clone(), number);
            let goal = part.goal(&setup.config, &self.nest);
            self.command(pilot, Command::Seek(goal))?;
            let begun = self.tally.clone();
            // Alone, a behavior goes on to the end; in a chain each decision may be its last.
            let is_over =
                |now: &Metrics| now.steps >= setup.steps || !alone && is_reached(part, &begun, now);
            self.drive(pilot, is_over, &mut progress)?;
            if !is_reached(part, &begun, &self.tally) {
                return Ok(());
            }
            let there = !matches!(part, Behavior::Nest) || self.measure.at_nest();
            self.measure.reached += u32::from(there);
        }
        Ok(())
    }
}

/// As [`is_reached`](scenes::is_reached), by the tallies when it was begun and now.
fn is_reached(part: &Behavior, begun: &Metrics, now: &Metrics) -> bool {
    let held = now.goal_steps.saturating_sub(begun.goal_steps);
    scenes::is_reached(part, now.steps.saturating_sub(begun.steps), held)
}
