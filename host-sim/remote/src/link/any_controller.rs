//! A controller in this process or at the end of a link.

use super::{Knowledge, LinkError, RemoteController, Session, next_number};
use amp::config::Config;
use amp::controller::{Event, Mode, Outputs};
use amp::fixed::Mask;
use amp::places::Aim;
use amp::turret::BodySpec;
use amp::units::{Displacement, Millis, Range};
use files::error::BadInput;
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, InspectableController as _, LocalController, Pilot, SimState};
use sim::robot::{AnyRobot, MAX_BEAMS};
use sim::senses::{Readings, SenseGoal};
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
    /// In this process, of the Nomad.
    Host(Box<LocalController>),
    /// In this process, of a robot whose sensors stand anywhere.
    Body(Box<TurretController>, Box<AnyRobot>),
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
                let body = robot.map(AnyRobot::body);
                let started = RemoteController::start(session, number, config, body.as_ref());
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
        match robot {
            None => Self::Host(Box::new(LocalController::new(config.clone()))),
            Some(robot) => {
                let controller = TurretController::new(config.clone(), robot);
                Self::Body(Box::new(controller), Box::new(robot.clone()))
            }
        }
    }

    /// Clears the knowledge and replaces the configuration.
    ///
    /// # Errors
    /// When it is remote and cannot be reached.
    pub fn reset(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        match self {
            Self::Host(_) => *self = Self::local(config, None),
            Self::Body(_, robot) => *self = Self::local(config, Some(robot)),
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
            Self::Host(_) | Self::Body(..) => "this process".to_owned(),
            Self::Link(remote) => remote.name.clone(),
        }
    }

    /// What a remote controller had before it was reset, in words.
    #[must_use]
    pub fn replaced(&self) -> Vec<&'static str> {
        match self {
            Self::Host(_) | Self::Body(..) => Vec::new(),
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
            Self::Host(controller) => Ok(controller.state()),
            Self::Body(controller, _) => Ok(controller.state()),
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
            Self::Host(controller) => controller.enabled(),
            Self::Body(controller, _) => controller.enabled(),
            Self::Link(remote) => remote.controller.enabled(),
        }
    }

    /// Ranges of a ring of sectors as they were at the last decision, and the body as it is known,
    /// of a robot in this process whose sensors stand anywhere.
    #[must_use]
    pub fn perceived_body(&self) -> Option<([Option<Range>; 16], BodySpec<MAX_BEAMS>)> {
        match self {
            Self::Body(controller, _) => Some((*controller.ring(), controller.known_body())),
            Self::Host(_) | Self::Link(_) => None,
        }
    }

    /// Points and places of a robot in this process that its places lead to goals.
    #[must_use]
    pub fn led_turret(&self) -> Option<&SimTurret> {
        match self {
            Self::Body(controller, _) => controller.led_turret(),
            Self::Host(_) | Self::Link(_) => None,
        }
    }

    /// Random moves left of a robot in this process that finds its sensors.
    #[must_use]
    pub fn babble_moves_left(&self) -> Option<u16> {
        match self {
            Self::Body(controller, _) => match controller.state().mode() {
                Mode::Babble { left } => Some(*left),
                _ => None,
            },
            Self::Host(_) | Self::Link(_) => None,
        }
    }

    /// The configuration.
    pub fn config(&self) -> &Config<16> {
        match self {
            Self::Host(controller) => controller.config(),
            Self::Body(controller, _) => controller.config(),
            Self::Link(remote) => remote.controller.config(),
        }
    }

    /// Replaces the configuration.
    ///
    /// # Errors
    /// When it is remote and moves, or cannot be reached.
    pub fn configure(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        match self {
            Self::Host(controller) => controller.configure(config.clone()),
            Self::Body(controller, _) => controller.configure(config.clone()),
            Self::Link(remote) => remote.controller.configure(config)?,
        }
        Ok(())
    }

    /// Where the robot perceived what is sought in another modality, in the frame of its places,
    /// and how strongly, 0 … 1.
    #[must_use]
    pub fn remembered(&self, goal: SenseGoal) -> Vec<(Displacement, f64)> {
        match self {
            Self::Body(controller, _) => controller.senses().remembered(goal),
            Self::Host(_) | Self::Link(_) => Vec::new(),
        }
    }

    /// Replaces configuration and knowledge; only in this process.
    pub fn replace(&mut self, knowledge: &Knowledge) {
        if let Self::Host(controller) = self {
            let (config, state) = (knowledge.config(), knowledge.state());
            **controller = LocalController::with_state(config.clone(), state.clone());
        }
    }
}

impl Pilot for AnyController {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match self {
            Self::Host(controller) => controller.handle(at, event),
            Self::Body(controller, _) => controller.handle(at, event),
            Self::Link(remote) => remote.controller.handle(at, event),
        }
    }

    fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
        match self {
            Self::Host(controller) => controller.echoes(at, echoes),
            Self::Body(controller, _) => controller.echoes(at, echoes),
            Self::Link(remote) => remote.controller.echoes(at, echoes),
        }
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        match self {
            Self::Host(controller) => controller.lead_to(aim),
            Self::Body(controller, _) => controller.lead_to(aim),
            Self::Link(remote) => remote.controller.lead_to(aim),
        }
    }

    fn sense(&mut self, at: Millis, readings: &Readings) {
        if let Self::Body(controller, _) = self {
            controller.sense(at, readings);
        }
    }

    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        match self {
            Self::Body(controller, _) => controller.seek_sense(goal),
            Self::Host(_) | Self::Link(_) => goal.map_or(Ok(()), |_| Err(EpisodeError::NoPlaces)),
        }
    }

    fn failure(&self) -> Option<EpisodeError> {
        match self {
            Self::Host(_) | Self::Body(..) => None,
            Self::Link(remote) => remote.controller.failure(),
        }
    }
}
