//! The controller behind a virtual turret: for robots whose sensors stand anywhere.

use crate::error::EpisodeError;
use crate::pilot::{InspectableController, Pilot, SimState};
use crate::robot::{AnyRobot, MAX_BEAMS};
use amp::calibration::{Babble, BabbleLimits};
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
    /// While it learns where its sensors look.
    babbling: Option<Babbling>,
}

/// Random moves that teach where the sensors look.
struct Babbling {
    robot: AnyRobot,
    limits: BabbleLimits,
    babble: Box<Babble<MAX_BEAMS>>,
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
            babbling: None,
        }
    }

    /// The same, which first learns where its sensors look, by so many random moves.
    #[must_use]
    pub fn babbling(config: Config<16>, robot: &AnyRobot, moves: u16, seed: u64) -> Self {
        let babbling = Babbling {
            robot: robot.clone(),
            limits: robot.babble_limits(&config),
            babble: Box::new(Babble::new(moves, seed)),
        };
        Self {
            babbling: Some(babbling),
            ..Self::new(config, robot)
        }
    }

    /// The body as the controller knows it.
    #[must_use]
    pub fn body(&self) -> &BodySpec<MAX_BEAMS> {
        &self.body
    }
}

impl Pilot for TurretController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if let Some(Babbling {
            robot,
            limits,
            babble,
        }) = &mut self.babbling
        {
            let motion = babble.handle(limits, &event);
            if babble.is_over() {
                self.body = robot.learned_body(&babble.calibration().solve());
                self.babbling = None;
            }
            return Outputs {
                motion,
                ..Outputs::NONE
            };
        }
        turret::handle(
            &self.config,
            &self.body,
            &mut self.turret,
            &mut self.state,
            at,
            event,
        )
    }

    fn calibration_moves_left(&self) -> Option<u16> {
        let babbling = self.babbling.as_ref();
        babbling.map(|babbling| babbling.babble.moves_left())
    }
}

impl InspectableController for TurretController {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        Ok(&self.state)
    }
}
