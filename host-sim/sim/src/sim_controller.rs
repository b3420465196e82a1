//! The controller in this process, of any robot.

use crate::error::EpisodeError;
use crate::pilot::{AgedEcho, InspectableController, LocalController, Pilot, SimState};
use crate::robot::{AnyRobot, MAX_BEAMS, ToldRobot};
use crate::senses::{Readings, SavedSenses, SenseGoal};
use crate::turret_pilot::{SimBody, TurretController};
use amp::config::Config;
use amp::controller::{Event, Outputs};
use amp::fixed::Mask;
use amp::places::Aim;
use amp::turret::BodySpec;
use amp::units::Millis;

/// The controller in this process, of any robot.
pub enum SimController {
    /// Of the Nomad, whose ring keeps its bearing.
    Ring(Box<LocalController>),
    /// Of a robot whose sensors stand anywhere.
    Turret(Box<TurretController>),
}

impl SimController {
    /// A controller of a robot (`None` = the Nomad) without any knowledge.
    #[must_use]
    pub fn new(config: &Config<16>, robot: Option<&AnyRobot>) -> Self {
        Self::told(config, robot.map(AnyRobot::told).as_ref())
    }

    /// A controller that was told this of its robot (`None` = the Nomad), without any knowledge.
    #[must_use]
    pub fn told(config: &Config<16>, robot: Option<&ToldRobot>) -> Self {
        let config = config.clone();
        match robot {
            None => Self::Ring(Box::new(LocalController::new(config))),
            Some(robot) => Self::Turret(Box::new(TurretController::told(config, robot))),
        }
    }

    /// The controller of a robot whose sensors stand anywhere.
    #[must_use]
    pub fn as_turret(&self) -> Option<&TurretController> {
        match self {
            Self::Ring(_) => None,
            Self::Turret(controller) => Some(controller),
        }
    }

    /// Maps and memory.
    #[must_use]
    pub fn state(&self) -> &SimState {
        match self {
            Self::Ring(controller) => controller.state(),
            Self::Turret(controller) => controller.state(),
        }
    }

    /// Transducers that it uses; of a robot whose sensors stand anywhere, sectors of which
    /// something is known.
    #[must_use]
    pub fn enabled(&self) -> Mask {
        match self {
            Self::Ring(controller) => controller.enabled(),
            Self::Turret(controller) => controller.enabled(),
        }
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &Config<16> {
        match self {
            Self::Ring(controller) => controller.config(),
            Self::Turret(controller) => controller.config(),
        }
    }

    /// Replaces the configuration and keeps the knowledge.
    pub fn configure(&mut self, config: Config<16>) {
        match self {
            Self::Ring(controller) => controller.configure(config),
            Self::Turret(controller) => controller.configure(config),
        }
    }

    /// Replaces configuration and knowledge by what was saved of a robot of the same kind; `body`
    /// is `None` for the Nomad. Those of another kind change nothing.
    pub fn replace(&mut self, config: &Config<16>, state: &SimState, body: Option<&SimBody>) {
        match (self, body) {
            (Self::Ring(controller), None) => {
                **controller = LocalController::with_state(config.clone(), state.clone());
            }
            (Self::Turret(controller), Some(body)) => controller.replace(config, state, body),
            (Self::Ring(_), Some(_)) | (Self::Turret(_), None) => {}
        }
    }

    /// As [`TurretController::restore_senses`]; one without places perceives nothing there.
    pub fn restore_senses(&mut self, saved: &SavedSenses, at: Millis) {
        if let Self::Turret(controller) = self {
            controller.restore_senses(saved, at);
        }
    }
}

impl Pilot for SimController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match self {
            Self::Ring(controller) => controller.handle(at, event),
            Self::Turret(controller) => controller.handle(at, event),
        }
    }

    fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
        match self {
            Self::Ring(controller) => controller.echoes(at, echoes),
            Self::Turret(controller) => controller.echoes(at, echoes),
        }
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        match self {
            Self::Ring(controller) => controller.lead_to(aim),
            Self::Turret(controller) => controller.lead_to(aim),
        }
    }

    fn sense(&mut self, at: Millis, readings: &Readings) {
        match self {
            Self::Ring(controller) => controller.sense(at, readings),
            Self::Turret(controller) => controller.sense(at, readings),
        }
    }

    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        match self {
            Self::Ring(controller) => controller.seek_sense(goal),
            Self::Turret(controller) => controller.seek_sense(goal),
        }
    }
}

impl InspectableController for SimController {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        Ok(self.state())
    }

    fn body(&mut self) -> Result<Option<BodySpec<MAX_BEAMS>>, EpisodeError> {
        match self {
            Self::Ring(controller) => controller.body(),
            Self::Turret(controller) => controller.body(),
        }
    }
}
