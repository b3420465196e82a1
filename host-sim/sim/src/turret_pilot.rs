//! The controller behind a virtual turret: for robots whose sensors stand anywhere.

use crate::error::EpisodeError;
use crate::pilot::{InspectableController, Pilot, SimState};
use crate::robot::{AnyRobot, MAX_BEAMS};
use amp::config::Config;
use amp::controller::{Event, Outputs, State};
use amp::som::Grid;
use amp::turret::{self, BodySpec, VirtualTurret};
use amp::units::Millis;

/// Points that the robot remembers.
const POINTS: usize = 256;

/// The controller in this process, behind a virtual turret.
pub struct TurretController {
    config: Config<16>,
    body: BodySpec<MAX_BEAMS>,
    turret: Box<VirtualTurret<16, POINTS>>,
    state: Box<SimState>,
}

impl TurretController {
    /// A controller of this robot without any knowledge; `config` is
    /// [`AnyRobot::config`]'s.
    #[must_use]
    pub fn new(config: Config<16>, robot: &AnyRobot) -> Self {
        let mut state = State::new(Grid::rectangle(4, 4));
        state.expect_open_space(config.open_space);
        Self {
            config,
            body: robot.body(),
            turret: Box::default(),
            state: Box::new(state),
        }
    }
}

impl Pilot for TurretController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        turret::handle(
            &self.config,
            &self.body,
            &mut self.turret,
            &mut self.state,
            at,
            event,
        )
    }
}

impl InspectableController for TurretController {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        Ok(&self.state)
    }
}
