//! The last phase of an episode: one behavior, or several in a row.

use super::drive::{EpisodeRunner, explored};
use super::metrics::{EpisodeReport, Metrics};
use super::setup::Setup;
use crate::behavior::{self, Behavior};
use crate::error::EpisodeError;
use crate::pilot::{LocalController, Pilot};
use amp::controller::Command;
use amp::goal::Goal;
use amp::places::Aim;
use amp::units::Displacement;
use arena::world::World;

/// Time of carrying the robot, s: after this time the shield has discarded all echoes.
pub const CARRY_TIME_S: f64 = 601.0;
/// Where the random moves began.
const START: Aim = Aim::Position(Displacement::ZERO);

/// Explores and learns once, then pursues the behavior `times` times, each from a new start.
/// Returns one report for each.
///
/// # Errors
/// When the controller refuses a command or is silent.
pub fn repeat(
    world: &World,
    setup: &Setup,
    times: u32,
) -> Result<Vec<EpisodeReport>, EpisodeError> {
    let mut controller = LocalController::new(setup.config.clone());
    let (mut runner, exploration) = explored(world, setup, &mut controller, None, |_, _, _| {})?;
    let mut reports = Vec::new();
    for _ in 0..times {
        runner.set_scene(setup);
        runner.pursue(&mut controller, setup, |_| {})?;
        let time_s = runner.body.time_s() - runner.began_s;
        let metrics = runner.next_phase(world);
        let measure = &runner.measure;
        reports.push(EpisodeReport::of(
            world,
            setup,
            &exploration,
            &metrics,
            time_s,
            measure,
        ));
    }
    Ok(reports)
}

impl EpisodeRunner<'_> {
    /// Places the robot and the leader as the behavior requires.
    pub(super) fn set_scene(&mut self, setup: &Setup) {
        let behavior = &setup.behavior;
        let home = self.start.position;
        let nest = behavior.place(home).unwrap_or(home);
        if setup.set_down.is_some() || behavior.is_set_down_elsewhere() {
            self.body.wait(CARRY_TIME_S);
            match setup.set_down {
                Some(place) => self.body.set_down_at(place),
                None => self.body.set_down_elsewhere(nest),
            }
            if behavior.is_turned() {
                self.body.turn_anywhere();
            }
        }
        if setup.second_robot || behavior.has_leader() {
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
        if setup.behavior.has_end() {
            self.tour(pilot, setup, &mut progress)?;
        }
        let parts = setup.behavior.parts();
        let alone = parts.len() == 1;
        for (number, part) in parts.iter().enumerate() {
            (self.behavior, self.part) = (part.clone(), number);
            let has_end = part.has_end();
            if let Behavior::Sense { goal, .. } = part {
                self.measure.sought = Some(self.sought(*goal));
            }
            if has_end && alone {
                let (from, radius_m) = (self.body.pose().position, self.body.radius_m());
                self.measure.begin_way(self.world, from, radius_m);
            }
            let sense_goal = part.sense_goals().next();
            pilot.seek_sense(sense_goal)?;
            match part {
                // What it senses leads it.
                Behavior::Sense { .. } => self.sense(pilot),
                Behavior::Home { .. } => pilot.lead_to(Some(START))?,
                Behavior::Nest { .. } => pilot.lead_if_it_can(Some(START))?,
                _ => pilot.lead_if_it_can(Some(Aim::Situation))?,
            }
            let mut goal = part.goal(&setup.config, &self.nest);
            if matches!(part, Behavior::Nest { .. } | Behavior::Home { .. }) {
                goal = goal.for_known(self.nest_known);
            }
            if let Some(file) = &setup.goal {
                goal = file.goal;
            }
            self.command(pilot, Command::Seek(goal))?;
            let begun = self.metrics.clone();
            // A single behavior uses all steps; in a chain each decision may be the last.
            let is_over = |now: &Metrics| {
                let ends = !alone || has_end;
                now.steps >= setup.steps || ends && is_reached(part, &begun, now)
            };
            self.drive(pilot, is_over, &mut progress)?;
            self.measure.is_found = sense_goal.is_some_and(|goal| self.is_at(goal));
            if !is_reached(part, &begun, &self.metrics) {
                return Ok(());
            }
            let is_there = match part {
                Behavior::Nest { .. } => self.measure.at_nest(),
                Behavior::Sense { .. } => self.measure.is_found,
                _ => true,
            };
            self.measure.reached += u32::from(is_there);
        }
        Ok(())
    }

    /// Drives around, to where it has not been, if the behavior begins so.
    pub(super) fn tour(
        &mut self,
        pilot: &mut impl Pilot,
        setup: &Setup,
        mut progress: impl FnMut(u32),
    ) -> Result<(), EpisodeError> {
        let steps = setup.behavior.tour().map_or(0, |tour| tour.steps);
        if steps == 0 {
            return Ok(());
        }
        pilot.lead_to(setup.behavior.tour_aim())?;
        self.command(pilot, Command::Seek(Goal::avoiding(&setup.config)))?;
        self.drive(pilot, |now| now.steps >= steps, &mut progress)?;
        self.next_phase(self.world);
        self.measure_from(self.measure.nest);
        Ok(())
    }
}

/// As [`behavior::is_reached`], by the metrics at the begin of the part and now.
fn is_reached(part: &Behavior, begun: &Metrics, now: &Metrics) -> bool {
    let held = now.goal_steps.saturating_sub(begun.goal_steps);
    behavior::is_reached(part, now.steps.saturating_sub(begun.steps), held)
}
