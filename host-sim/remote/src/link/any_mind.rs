//! A mind, in this process or at the end of a link.

use super::{Knowledge, LinkError, RemoteMind, Session, next_number};
use amp::config::Config;
use amp::controller::{Event, Outputs};
use amp::fixed::Mask;
use amp::units::Millis;
use files::error::BadInput;
use sim::error::EpisodeError;
use sim::pilot::{HeardEcho, InspectableController as _, LocalController, Pilot, SimState};

/// Where a mind is.
pub enum MindPlace {
    /// In this process.
    Host,
    /// At the other end of an open session, called so.
    Link(Box<Session>, String),
}

/// Decisions after which what a mind elsewhere has learned is fetched anew.
const FETCH: u32 = 20;

/// A mind, wherever it is.
pub enum AnyMind {
    /// In this process.
    Host(Box<LocalController>),
    /// At the end of a link.
    Link(Box<Elsewhere>),
}

/// A mind elsewhere, and what it was last known to know.
pub struct Elsewhere {
    mind: RemoteMind<Box<Session>>,
    name: String,
    known: Option<Box<SimState>>,
    decisions: u32,
}

impl AnyMind {
    /// A mind that knows nothing.
    ///
    /// # Errors
    /// When it cannot be reached or is of another kind.
    pub fn new(config: &Config<16>, place: MindPlace) -> Result<Self, BadInput> {
        match place {
            MindPlace::Host => Ok(Self::here(config)),
            MindPlace::Link(session, name) => {
                let number = next_number(session.number());
                let started = RemoteMind::start(session, number, config);
                let mind = started.map_err(|error| BadInput::new(format!("{name}: {error}")))?;
                Ok(Self::Link(Box::new(Elsewhere {
                    mind,
                    name,
                    known: None,
                    decisions: 0,
                })))
            }
        }
    }

    /// One in this process that knows nothing.
    #[must_use]
    pub fn here(config: &Config<16>) -> Self {
        Self::Host(Box::new(LocalController::new(config.clone())))
    }

    /// The same mind as when it knew nothing, with another configuration.
    ///
    /// # Errors
    /// When it is elsewhere and cannot be reached.
    pub fn afresh(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        match self {
            Self::Host(_) => *self = Self::here(config),
            Self::Link(elsewhere) => {
                elsewhere.mind.restart(config)?;
                elsewhere.known = None;
            }
        }
        Ok(())
    }

    /// Whether it is in this process.
    #[must_use]
    pub fn is_here(&self) -> bool {
        matches!(self, Self::Host(_))
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Host(_) => "this process".to_owned(),
            Self::Link(elsewhere) => elsewhere.name.clone(),
        }
    }

    /// What a mind elsewhere had instead of what it was told at the beginning; in words.
    #[must_use]
    pub fn replaced(&self) -> Vec<&'static str> {
        match self {
            Self::Host(_) => Vec::new(),
            Self::Link(elsewhere) => elsewhere.mind.replaced(),
        }
    }

    /// What a mind elsewhere knows is to be fetched anew: at once, or when enough decisions have been taken.
    pub fn forget_known(&mut self, at_once: bool) {
        if let Self::Link(elsewhere) = self {
            elsewhere.decisions += 1;
            if at_once || elsewhere.decisions >= FETCH {
                (elsewhere.known, elsewhere.decisions) = (None, 0);
            }
        }
    }

    /// What it knows, or last was known to know.
    ///
    /// # Errors
    /// When it is elsewhere and cannot be reached.
    pub fn known(&mut self) -> Result<&SimState, EpisodeError> {
        match self {
            Self::Host(mind) => Ok(mind.state()),
            Self::Link(elsewhere) => {
                let known = match elsewhere.known.take() {
                    Some(known) => known,
                    None => Box::new(elsewhere.mind.knowledge()?.clone()),
                };
                Ok(elsewhere.known.insert(known))
            }
        }
    }

    /// Transducers it uses.
    #[must_use]
    pub fn enabled(&self) -> Mask {
        match self {
            Self::Host(mind) => mind.enabled(),
            Self::Link(elsewhere) => elsewhere.mind.enabled(),
        }
    }

    /// What it was told.
    pub fn config(&self) -> &Config<16> {
        match self {
            Self::Host(mind) => mind.config(),
            Self::Link(elsewhere) => elsewhere.mind.config(),
        }
    }

    /// Tells it something else.
    ///
    /// # Errors
    /// When it is elsewhere and moves, or cannot be reached.
    pub fn configure(&mut self, config: &Config<16>) -> Result<(), LinkError> {
        match self {
            Self::Host(mind) => mind.configure(config.clone()),
            Self::Link(elsewhere) => elsewhere.mind.configure(config)?,
        }
        Ok(())
    }

    /// Replaces what it knows; only in this process.
    pub fn replace(&mut self, knowledge: &Knowledge) {
        if let Self::Host(mind) = self {
            let (config, state) = (knowledge.config(), knowledge.state());
            **mind = LocalController::with_state(config.clone(), state.clone());
        }
    }
}

impl Pilot for AnyMind {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match self {
            Self::Host(mind) => mind.handle(at, event),
            Self::Link(elsewhere) => elsewhere.mind.handle(at, event),
        }
    }

    fn echoes(&mut self, at: Millis, echoes: &[HeardEcho]) -> (usize, Outputs<16>) {
        match self {
            Self::Host(mind) => mind.echoes(at, echoes),
            Self::Link(elsewhere) => elsewhere.mind.echoes(at, echoes),
        }
    }

    fn failure(&self) -> Option<EpisodeError> {
        match self {
            Self::Host(_) => None,
            Self::Link(elsewhere) => elsewhere.mind.failure(),
        }
    }
}
