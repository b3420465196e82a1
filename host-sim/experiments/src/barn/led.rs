//! A robot that is led to the goal by its memory of places.

use super::{RunConditions, learning};
use amp::controller::{Command, Event};
use amp::goal::Goal;
use amp::places::Aim;
use amp::shield::ShieldConfig;
use amp::units::{Displacement, Millis};
use arena::robot_model::RobotModel;
use arena::world::{Point, World};
use files::error::BadInput;
use sim::episode::{self, Setup};
use sim::error::EpisodeError;
use sim::pilot::Pilot as _;
use sim::robot::{AnyRobot, Ranges};
use sim::turret_pilot::TurretController;

/// The Nomad, whose ring on the held turret is read through points; its guard keeps the margin of
/// the shield.
pub(super) fn robot(shield: Option<ShieldConfig>) -> Result<AnyRobot, BadInput> {
    let nomad = AnyRobot::new(RobotModel::builtin("nomad200")?, Ranges::Own, false)?;
    Ok(match shield {
        Some(shield) => nomad.with_margin(f64::from(shield.margin_mm) * 1e-3),
        None => nomad,
    })
}

/// A controller of that robot that has explored a random room and learned, and knows no place yet;
/// it is led to `target`, m from where it will stand, in the ring's frame.
pub(super) fn controller(
    rules: &RunConditions,
    robot: &AnyRobot,
    seed: u64,
    target: Point,
) -> Result<TurretController, EpisodeError> {
    let setup = Setup {
        config: robot.config(rules.config.clone()),
        robot: Some(robot.clone()),
        ..learning(rules, seed)
    };
    let mut learner = TurretController::new(setup.config.clone(), robot);
    episode::explore_and_learn(&World::random(seed), &setup, &mut learner)?;
    let mut led = TurretController::new(setup.config.clone(), robot);
    led.take_knowledge(learner);
    let mm = |m: f64| libm::rint(m * 1e3) as i32;
    let position = Displacement::saturating(mm(target.x), mm(target.y));
    led.lead_to(Some(Aim::Position(position)))?;
    let seek = Event::Command(Command::Seek(Goal::avoiding(&setup.config)));
    match led.handle(Millis::from_ms(0), seek).refusal {
        Some(refusal) => Err(EpisodeError::Refused(refusal)),
        None => Ok(led),
    }
}
