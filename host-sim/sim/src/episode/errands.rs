//! Errands: a robot is sent from place to place, round after round, and its world changes.

use super::drive::{EpisodeRunner, explored};
use super::measure::NEST_RADIUS_M;
use super::metrics::Metrics;
use super::setup::Setup;
use crate::error::EpisodeError;
use crate::pilot::Pilot as _;
use crate::turret_pilot::TurretController;
use amp::controller::Command;
use amp::goal::Goal;
use amp::places::Aim;
use amp::units::Displacement;
use arena::route::{self, route};
use arena::world::{Point, Pose, World};
use serde::Serialize;

/// Room between the body and an obstacle that appears, m.
const APPEARS_M: f64 = 0.05;
/// Seconds of an hour.
const HOUR_S: f64 = 3600.0;

/// What the periods are of which results are summed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Period {
    /// Once to all places and home.
    Round,
    /// An hour of simulated time, in which an errand begins.
    Hour,
}

/// Something that stands in the way in every other run of periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstacle {
    /// Its center, in the world.
    pub center: Point,
    /// Its radius, m.
    pub radius_m: f64,
    /// It comes and goes after so many periods, at least 1.
    pub every: u32,
}

impl Obstacle {
    /// Whether it is to stand in the way in this period.
    #[must_use]
    pub const fn stands_in(&self, period: u32) -> bool {
        period / self.every % 2 == 1
    }
}

/// Where a robot is sent.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrandPlan {
    /// Places in the world, in this order; from the last one it is sent home.
    pub places: Vec<Point>,
    /// What a period is.
    pub period: Period,
    /// Number of periods.
    pub periods: u32,
    /// Decisions of one errand, at most.
    pub steps: u32,
    /// What stands in the way now and then.
    pub obstacle: Option<Obstacle>,
}

/// One drive to one place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Errand {
    /// Period in which it began, from 0.
    pub period: u32,
    /// Index of the place; their number for home.
    pub place: usize,
    /// The obstacle stood in the way.
    pub is_obstructed: bool,
    /// The robot thought at the end that it was there.
    pub has_ended: bool,
    /// It was within 0.3 m of the place at the end.
    pub is_there: bool,
    /// Shortest way of its body, m; `None` if there is none.
    pub shortest_m: Option<f64>,
    /// What it drove, m.
    pub distance_m: f64,
    /// Time it took, s.
    pub took_s: f64,
    /// Steps with a contact.
    pub contacts: u32,
    /// How far the robot was at the end from where it thought it was, m.
    pub error_m: f64,
    /// Places that it knew at the end.
    pub known: usize,
}

/// Explores and learns, and goes on errands. The robot knows where its sensors look.
///
/// Returns the errands, and why they ended early if they did.
///
/// # Errors
/// When the controller refuses a command or is silent before the first errand.
pub fn errands(
    world: &World,
    setup: &Setup,
    controller: &mut TurretController,
    plan: &ErrandPlan,
) -> Result<(Vec<Errand>, Option<EpisodeError>), EpisodeError> {
    let (runner, _) = explored(world, setup, controller, None, |_, _, _| {})?;
    let mut messenger = Messenger {
        world,
        goal: Goal::avoiding(&setup.config),
        plan,
        frame: runner.start,
        began_s: runner.body.time_s(),
        runner,
        controller,
    };
    let mut errands = Vec::new();
    for round in 0.. {
        for place in 0..=plan.places.len() {
            let period = messenger.period(round);
            if period >= plan.periods {
                return Ok((errands, None));
            }
            match messenger.run(period, place) {
                Ok(errand) => errands.push(errand),
                Err(why) => return Ok((errands, Some(why))),
            }
        }
    }
    Ok((errands, None))
}

/// A place in the frame of a robot that began there.
pub(super) fn in_frame(frame: Pose, place: Point) -> Displacement {
    let way = (place - frame.position).turned_back(Point::unit(frame.heading));
    let mm = |m: f64| libm::rint(m * 1e3) as i32;
    Displacement::saturating(mm(way.x), mm(way.y))
}

/// A robot that goes on errands.
struct Messenger<'p, 'w> {
    /// Without the obstacle.
    world: &'w World,
    /// On its way it keeps away from everything.
    goal: Goal<16>,
    plan: &'p ErrandPlan,
    /// That of the positions that it is told.
    frame: Pose,
    began_s: f64,
    runner: EpisodeRunner<'w>,
    controller: &'p mut TurretController,
}

impl Messenger<'_, '_> {
    fn period(&self, round: u32) -> u32 {
        match self.plan.period {
            Period::Round => round,
            Period::Hour => ((self.runner.body.time_s() - self.began_s) / HOUR_S) as u32,
        }
    }

    /// Where a place is, in the world.
    fn target(&self, place: usize) -> Point {
        let places = &self.plan.places;
        places.get(place).copied().unwrap_or(self.frame.position)
    }

    /// The obstacle comes or goes; it does not come where the robot stands. Returns whether it is
    /// there.
    fn obstruct(&mut self, period: u32) -> bool {
        let body = &mut self.runner.body;
        let Some(obstacle) = self.plan.obstacle else {
            return false;
        };
        let apart_m = obstacle.center.distance(body.pose().position);
        let has_room = apart_m > obstacle.radius_m + body.radius_m() + APPEARS_M;
        let stands = obstacle.stands_in(period) && has_room;
        body.set_world(match stands {
            true => self.world.with_post(obstacle.center, obstacle.radius_m),
            false => self.world.clone(),
        });
        stands
    }

    /// Drives to a place.
    fn run(&mut self, period: u32, place: usize) -> Result<Errand, EpisodeError> {
        let is_obstructed = self.obstruct(period);
        let (target, steps) = (self.target(place), self.plan.steps);
        let position = in_frame(self.frame, target);
        let body = &self.runner.body;
        let (from, began_s) = (body.pose().position, body.time_s());
        // Worlds too large to be searched have no shortest way.
        let path = route(body.world(), from, target, body.radius_m());
        self.controller.lead_to(Some(Aim::Position(position)))?;
        let seek = Command::Seek(self.goal);
        self.runner.command(self.controller, seek)?;
        let is_over = |now: &Metrics| now.goal_steps > 0 || now.steps >= steps;
        self.runner.drive(self.controller, is_over, |_| {})?;
        let metrics = self.runner.next_phase(self.world);
        let at = self.runner.body.pose().position;
        let places = self.controller.turret().places();
        Ok(Errand {
            period,
            place,
            is_obstructed,
            has_ended: metrics.goal_steps > 0,
            is_there: at.distance(target) <= NEST_RADIUS_M,
            shortest_m: path.ok().flatten().map(|path| route::length(&path)),
            distance_m: metrics.distance_m,
            took_s: self.runner.body.time_s() - began_s,
            contacts: metrics.contacts,
            error_m: f64::from(in_frame(self.frame, at).minus(places.here()).length_mm()) / 1e3,
            known: places.positions().len(),
        })
    }
}

#[cfg(test)]
mod tests;
