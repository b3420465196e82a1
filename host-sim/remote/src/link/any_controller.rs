//! A controller in this process or at the end of a link.

use super::{Knowledge, LinkError, RemoteController, Session, next_number};
use amp::config::Config;
use amp::controller::{Event, Mode, Outputs};
use amp::fixed::Mask;
use amp::places::Aim;
use amp::units::{Displacement, Millis};
use files::error::BadInput;
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, InspectableController as _, Pilot, SimState};
use sim::robot::AnyRobot;
use sim::senses::{Readings, SenseGoal};
use sim::sim_controller::SimController;
use sim::turret_pilot::{SimTurret, TurretController};

/// Place of a controller.
pub enum ControllerPlace {
    /// In this process.
    Host,
    /// At the other end of an open session, with a name for messages.
    Link(Box<Session>, String),
}

/// A remote controller's state is read again after this many decisions.
const DECISIONS_PER_READ: u32 = 20;

/// A controller, local or remote.
pub enum AnyController {
    /// In this process, of a robot (`None` = the Nomad).
    Host(SimController, Option<Box<AnyRobot>>),
    /// At the end of a link.
    Link(Box<CachedRemote>),
}

/// A remote controller and a cached copy of its state.
pub struct CachedRemote {
    controller: RemoteController<Box<Session>>,
    name: String,
    state: Option<Box<SimState>>,
    decisions: u32,
}

impl AnyController {
    /// A controller of a robot (`None` = the Nomad) without any knowledge.
    ///
    /// # Errors
    /// When it cannot be reached or is incompatible.
    pub fn new(
        config: &Config<16>,
        robot: Option<&AnyRobot>,
        place: ControllerPlace,
    ) -> Result<Self, BadInput> {
        match place {
            ControllerPlace::Host => Ok(Self::local(config, robot)),
            ControllerPlace::Link(session, name) => {
                let number = next_number(session.number());
                let robot = robot.map(AnyRobot::told);
                let started = RemoteController::start(session, number, config, robot.as_ref());
                let controller =
                    started.map_err(|error| BadInput::new(format!("{name}: {error}")))?;
                Ok(Self::Link(Box::new(CachedRemote {
                    controller,
                    name,
                    state: None,
                    decisions: 0,
                })))
            }
        }
    }

    /// A controller in this process without any knowledge.
    #[must_use]
    pub fn local(config: &Config<16>, robot: Option<&AnyRobot>) -> Self {
        let controller = SimController::new(config, robot);
        Self::Host(controller, robot.cloned().map(Box::new))
    }

    /// Clears the knowledge and replaces the configuration.
    ///
    /// # Errors
    /// When it is remote and cannot be reached.
    pub fn reset(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        match self {
            Self::Host(_, robot) => *self = Self::local(config, robot.as_deref()),
            Self::Link(remote) => {
                remote.controller.restart(config)?;
                remote.state = None;
            }
        }
        Ok(())
    }

    /// Whether it is in this process.
    #[must_use]
    pub fn is_local(&self) -> bool {
        !matches!(self, Self::Link(_))
    }

    /// Its name in messages.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Host(..) => "this process".to_owned(),
            Self::Link(remote) => remote.name.clone(),
        }
    }

    /// What a remote controller had before it was reset, in words.
    #[must_use]
    pub fn replaced(&self) -> Vec<&'static str> {
        match self {
            Self::Host(..) => Vec::new(),
            Self::Link(remote) => remote.controller.replaced(),
        }
    }

    /// Marks the cached state as old: at once, or after some decisions.
    pub fn invalidate_cache(&mut self, at_once: bool) {
        if let Self::Link(remote) = self {
            remote.decisions += 1;
            if at_once || remote.decisions >= DECISIONS_PER_READ {
                (remote.state, remote.decisions) = (None, 0);
            }
        }
    }

    /// Maps and memory; those of a remote controller come from the cache.
    ///
    /// # Errors
    /// When it is remote and cannot be reached.
    pub fn cached_state(&mut self) -> Result<&SimState, EpisodeError> {
        match self {
            Self::Host(controller, _) => Ok(controller.state()),
            Self::Link(remote) => {
                let state = match remote.state.take() {
                    Some(state) => state,
                    None => Box::new(remote.controller.knowledge()?.clone()),
                };
                Ok(remote.state.insert(state))
            }
        }
    }

    /// Transducers it uses.
    #[must_use]
    pub fn enabled(&self) -> Mask {
        match self {
            Self::Host(controller, _) => controller.enabled(),
            Self::Link(remote) => (remote.controller.twin())
                .map_or_else(|| remote.controller.enabled(), TurretController::enabled),
        }
    }

    /// The controller of a robot whose sensors stand anywhere; of a remote one with a memory of
    /// places, that in this process which decides the same.
    #[must_use]
    pub fn as_turret(&self) -> Option<&TurretController> {
        match self {
            Self::Host(controller, _) => controller.as_turret(),
            Self::Link(remote) => remote.controller.twin(),
        }
    }

    /// Points and places of a robot that its places lead to goals.
    #[must_use]
    pub fn led_turret(&self) -> Option<&SimTurret> {
        self.as_turret()?.led_turret()
    }

    /// Random moves left of a robot that finds its sensors.
    #[must_use]
    pub fn babble_moves_left(&self) -> Option<u16> {
        match self.as_turret()?.state().mode() {
            Mode::Babble { left } => Some(*left),
            _ => None,
        }
    }

    /// The configuration.
    pub fn config(&self) -> &Config<16> {
        match self {
            Self::Host(controller, _) => controller.config(),
            Self::Link(remote) => remote.controller.config(),
        }
    }

    /// Replaces the configuration.
    ///
    /// # Errors
    /// When it is remote and moves, or cannot be reached.
    pub fn configure(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        match self {
            Self::Host(controller, _) => controller.configure(config.clone()),
            Self::Link(remote) => remote.controller.configure(config)?,
        }
        Ok(())
    }

    /// Where the robot perceived what is sought in another modality, in the frame of its places,
    /// and how strongly, 0 … 1.
    #[must_use]
    pub fn remembered(&self, goal: SenseGoal) -> Vec<(Displacement, f64)> {
        let controller = self.as_turret();
        controller.map_or_else(Vec::new, |controller| controller.senses().remembered(goal))
    }

    /// Replaces configuration and knowledge by those of a robot of the same kind; only in this
    /// process.
    pub fn replace(&mut self, knowledge: &Knowledge, at: Millis) {
        if let Self::Host(controller, _) = self {
            knowledge.give_to(controller, at);
        }
    }

    /// All that it knows but its goals, to be saved; maps and memory of a remote controller come
    /// from the cache.
    ///
    /// # Errors
    /// When it is remote and cannot be reached.
    pub fn saved(&mut self) -> Result<Knowledge, EpisodeError> {
        if let Self::Host(controller, _) = self {
            return Ok(Knowledge::of_controller(controller));
        }
        let state = self.cached_state()?.clone();
        let mut knowledge = Knowledge::of(self.config(), &state);
        if let Some(twin) = self.as_turret() {
            knowledge.add_senses(twin.senses().saved());
        }
        if let Self::Link(remote) = self {
            remote.controller.read_body(&mut knowledge)?;
        }
        Ok(knowledge)
    }
}

impl Pilot for AnyController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match self {
            Self::Host(controller, _) => controller.handle(at, event),
            Self::Link(remote) => remote.controller.handle(at, event),
        }
    }

    fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
        match self {
            Self::Host(controller, _) => controller.echoes(at, echoes),
            Self::Link(remote) => remote.controller.echoes(at, echoes),
        }
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        match self {
            Self::Host(controller, _) => controller.lead_to(aim),
            Self::Link(remote) => remote.controller.lead_to(aim),
        }
    }

    fn sense(&mut self, at: Millis, readings: &Readings) {
        match self {
            Self::Host(controller, _) => controller.sense(at, readings),
            Self::Link(remote) => remote.controller.sense(at, readings),
        }
    }

    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        match self {
            Self::Host(controller, _) => controller.seek_sense(goal),
            Self::Link(remote) => remote.controller.seek_sense(goal),
        }
    }

    fn failure(&self) -> Option<EpisodeError> {
        match self {
            Self::Host(..) => None,
            Self::Link(remote) => remote.controller.failure(),
        }
    }
}
