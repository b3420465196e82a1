//! A robot that is asked after each drive where it goes next.

use super::drive::explored;
use super::errands::in_frame;
use super::metrics::Metrics;
use super::setup::Setup;
use crate::error::EpisodeError;
use crate::pilot::Pilot as _;
use crate::turret_pilot::TurretController;
use amp::controller::Command;
use amp::goal::Goal;
use amp::places::Aim;
use amp::scan::Situation;
use amp::units::Displacement;
use arena::world::{Point, World};

/// Where a robot is sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Destination {
    /// Somebody leads it to this point of the world.
    InWorld(Point),
    /// It goes to this position, from where it began to explore.
    InFrame(Displacement),
}

/// The end of one drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// What the robot perceived at its last decision.
    pub situation: Situation<16>,
    /// Where it thinks that it is, from where it began to explore.
    pub believed: Displacement,
    /// Where it is.
    pub at: Point,
    /// It thinks that it is there.
    pub has_ended: bool,
    /// What it drove, m.
    pub distance_m: f64,
    /// Steps with a contact.
    pub contacts: u32,
}

/// Explores and learns, and goes where `next` says, of what it perceived at the end of the last
/// drive; `None` ends the patrol. A drive takes `steps` decisions at most. The robot knows where
/// its sensors look, and its memory of places leads it.
///
/// Returns why the patrol ended early, if it did.
///
/// # Errors
/// When the controller refuses a command or is silent before the first drive.
pub fn patrol(
    world: &World,
    setup: &Setup,
    controller: &mut TurretController,
    steps: u32,
    mut next: impl FnMut(Option<&Arrival>) -> Option<Destination>,
) -> Result<Option<EpisodeError>, EpisodeError> {
    let (mut runner, _) = explored(world, setup, controller, None, |_, _, _| {})?;
    let (frame, goal) = (runner.start, Goal::avoiding(&setup.config));
    let mut arrival = None;
    while let Some(destination) = next(arrival.as_ref()) {
        let position = match destination {
            Destination::InWorld(point) => in_frame(frame, point),
            Destination::InFrame(position) => position,
        };
        controller.lead_to(Some(Aim::Position(position)))?;
        let is_over = |now: &Metrics| now.goal_steps > 0 || now.steps >= steps;
        let driven = runner.command(controller, Command::Seek(goal));
        let driven = driven.and_then(|()| runner.drive(controller, is_over, |_| {}));
        if let Err(why) = driven {
            return Ok(Some(why));
        }
        let metrics = runner.next_phase(world);
        let encoding = setup.config.encoding;
        arrival = Some(Arrival {
            situation: controller.ring().map(|range| encoding.value(range)),
            believed: controller.turret().places().here(),
            at: runner.body.pose().position,
            has_ended: metrics.goal_steps > 0,
            distance_m: metrics.distance_m,
            contacts: metrics.contacts,
        });
    }
    Ok(None)
}
