//! The controller behind a virtual turret: for robots whose sensors stand anywhere.

use crate::error::EpisodeError;
use crate::pilot::{InspectableController, Pilot, SimState};
use crate::ring_pilot::{Policy, RingPilot};
use crate::robot::{AnyRobot, MAX_BEAMS, ToldRobot};
use crate::senses::{Readings, SavedSenses, SenseGoal, Senses};
use amp::body::{Body as _, MountedSensors};
use amp::config::Config;
use amp::controller::{Command, Event, Mode, Outputs, State};
use amp::fixed::Mask;
use amp::places::Aim;
use amp::shield::ShieldConfig;
use amp::som::Grid;
use amp::turret::{self, BodySpec, VirtualTurret};
use amp::units::{Millis, Range};

/// Points that the robot remembers.
const POINTS: usize = 256;
/// Places that it remembers.
const RECORDS: usize = 256;

/// A robot's body as the controller in this process has it, as large as on the chip.
pub type SimBody = MountedSensors<16, MAX_BEAMS, POINTS, RECORDS>;

/// What such a controller knows of its surroundings.
pub type SimTurret = VirtualTurret<16, POINTS, RECORDS>;

/// The controller in this process, of a robot whose sensors stand anywhere.
pub struct TurretController {
    config: Config<16>,
    body: Box<SimBody>,
    state: Box<SimState>,
    /// What it was told.
    robot: ToldRobot,
    /// What else it perceived.
    senses: Box<Senses>,
}

impl TurretController {
    /// A controller of this robot without any knowledge; `config` is
    /// [`AnyRobot::config`]'s.
    #[must_use]
    pub fn new(config: Config<16>, robot: &AnyRobot) -> Self {
        Self::told(config, &robot.told())
    }

    /// As [`new`](Self::new), by what the controller is told.
    #[must_use]
    pub fn told(config: Config<16>, robot: &ToldRobot) -> Self {
        let mut state = State::new(Grid::rectangle(4, 4));
        state.expect_open_space(config.open_space);
        let mut body = Box::<SimBody>::default();
        body.tell(&robot.body);
        let _ = body.lead_to(None);
        Self {
            config,
            body,
            state: Box::new(state),
            robot: robot.clone(),
            senses: Box::default(),
        }
    }

    /// Replaces configuration and knowledge, and what is known of the body and its places by what
    /// was saved of them: the robot may be anywhere among those.
    pub fn replace(&mut self, config: &Config<16>, state: &SimState, saved: &SimBody) {
        *self.state = state.clone();
        *self.body = saved.clone();
        let _ = self.body.lead_to(None);
        self.senses.forget();
        self.configure(config.clone());
    }

    /// It perceived this before, among the places that it has now; `at` is now.
    pub fn restore_senses(&mut self, saved: &SavedSenses, at: Millis) {
        self.senses.restore(saved, at);
    }

    /// The body, what it knows of itself, and its places.
    #[must_use]
    pub fn body_state(&self) -> &SimBody {
        &self.body
    }

    /// Takes what another controller has learned, and nothing of where that was.
    pub fn take_knowledge(&mut self, other: Self) {
        self.state = other.state;
    }

    /// Replaces the configuration and keeps the knowledge.
    pub fn configure(&mut self, config: Config<16>) {
        self.state.trust(config.enabled);
        self.state.expect_open_space(config.open_space);
        self.config = config;
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &Config<16> {
        &self.config
    }

    /// Maps and memory.
    #[must_use]
    pub fn state(&self) -> &SimState {
        &self.state
    }

    /// Sectors of which something is known.
    #[must_use]
    pub fn enabled(&self) -> Mask {
        self.state.enabled(&self.config)
    }

    /// Ranges of the sectors at the last decision.
    #[must_use]
    pub fn ring(&self) -> &[Option<Range>; 16] {
        self.body.turret().ring()
    }

    /// What it perceived beside ranges.
    #[must_use]
    pub fn senses(&self) -> &Senses {
        &self.senses
    }

    /// Points and places.
    #[must_use]
    pub fn turret(&self) -> &SimTurret {
        self.body.turret()
    }

    /// The same, if the places lead it to goals.
    #[must_use]
    pub fn led_turret(&self) -> Option<&SimTurret> {
        self.robot.is_led.then(|| self.turret())
    }

    /// Whether each tick is a step of learning or of finding its sensors.
    #[must_use]
    pub fn thinks(&self) -> bool {
        matches!(self.state.mode(), Mode::Learn { .. }) || self.body.is_solving()
    }

    /// What else its sensors read, where it is now. Returns where a robot that looks for something
    /// there is to be led.
    pub fn perceive(&mut self, at: Millis, readings: &Readings) -> Option<Aim> {
        let places = self.body.turret().places();
        // One that was carried, and does not know where it is, has no position for what it senses.
        if !self.robot.is_led || places.aside().is_some() {
            return None;
        }
        self.senses.perceive(readings, places.here(), at);
        self.senses.aim(places, at)
    }

    /// The body as it is known; while it finds its sensors, as far as it has found them.
    #[must_use]
    pub fn known_body(&self) -> BodySpec<MAX_BEAMS> {
        match self.state.mode() {
            Mode::Babble { .. } | Mode::Calibrate => self.body.sketch(),
            _ => self.body.known().clone(),
        }
    }
}

/// A rule that decides by rings, behind a virtual turret.
pub struct TurretPolicy<P> {
    config: Config<16>,
    body: BodySpec<MAX_BEAMS>,
    turret: Box<VirtualTurret<16, POINTS, 0>>,
    ring: RingPilot<P>,
}

impl<P: Policy> TurretPolicy<P> {
    /// A pilot of this robot that follows `policy`; `config` is [`AnyRobot::config`]'s.
    #[must_use]
    pub fn new(config: Config<16>, robot: &AnyRobot, policy: P) -> Self {
        Self {
            ring: RingPilot::of_robot(policy, config.clone()),
            config,
            body: robot.body(),
            turret: Box::default(),
        }
    }

    /// The policy.
    pub fn policy(&self) -> &P {
        self.ring.policy()
    }

    /// The policy, without its pilot.
    pub fn into_policy(self) -> P {
        self.ring.into_policy()
    }
}

/// A rule that decides by rings, on any robot.
pub enum PolicyPilot<P> {
    /// The Nomad with its ring on a held turret.
    Ring(Box<RingPilot<P>>),
    /// A robot whose sensors stand anywhere.
    Turret(Box<TurretPolicy<P>>),
}

impl<P: Policy> PolicyPilot<P> {
    /// As [`RingPilot::new`].
    #[must_use]
    pub fn of_nomad(policy: P, shield: Option<ShieldConfig>) -> Self {
        Self::Ring(Box::new(RingPilot::new(policy, shield)))
    }

    /// As [`TurretPolicy::new`].
    #[must_use]
    pub fn of_robot(config: Config<16>, robot: &AnyRobot, policy: P) -> Self {
        Self::Turret(Box::new(TurretPolicy::new(config, robot, policy)))
    }

    /// The policy.
    pub fn policy(&self) -> &P {
        match self {
            Self::Ring(pilot) => pilot.policy(),
            Self::Turret(pilot) => pilot.policy(),
        }
    }

    /// The policy, without its pilot.
    pub fn into_policy(self) -> P {
        match self {
            Self::Ring(pilot) => pilot.into_policy(),
            Self::Turret(pilot) => pilot.into_policy(),
        }
    }
}

impl<P: Policy> Pilot for PolicyPilot<P> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match self {
            Self::Ring(pilot) => pilot.handle(at, event),
            Self::Turret(pilot) => pilot.handle(at, event),
        }
    }
}

impl<P: Policy> Pilot for TurretPolicy<P> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let Self {
            config,
            body,
            turret,
            ring,
        } = self;
        turret::handle(config, body, turret, ring, at, event)
    }
}

impl Pilot for TurretController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let Self {
            config,
            body,
            state,
            ..
        } = self;
        let explores = matches!(event, Event::Command(Command::Explore { .. }));
        let places = |body: &SimBody| body.turret().places().positions().len();
        let known = places(body);
        let mut outputs = body.handle(config, state, at, event);
        // With too few places a robot that was carried begins anew, and so does their frame.
        let begins_anew = known > 0 && places(body) == 0;
        if begins_anew || (explores && outputs.refusal.is_none()) {
            self.senses.forget();
        }
        // In no simulated time.
        while body.is_thinking() {
            outputs = body.think(config, state, at);
        }
        outputs
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        let _ = self.body.lead_to(self.robot.led(aim));
        Ok(())
    }

    fn sense(&mut self, at: Millis, readings: &Readings) {
        if let Some(aim) = self.perceive(at, readings) {
            let _ = self.body.lead_to(Some(aim));
        }
    }

    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        if goal.is_some() && !self.robot.is_led {
            return Err(EpisodeError::NoPlaces);
        }
        self.senses.seek(goal);
        Ok(())
    }
}

impl InspectableController for TurretController {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        Ok(&self.state)
    }

    fn body(&mut self) -> Result<Option<BodySpec<MAX_BEAMS>>, EpisodeError> {
        Ok(Some(self.body.known().clone()))
    }
}

#[cfg(test)]
mod tests;
