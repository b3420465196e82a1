//! Whoever drives: takes what happens to the robot, says what the base is to do.

use crate::error::EpisodeError;
use amp::config::Config;
use amp::controller::{self, Event, Outputs, State};
use amp::faults::Verdict;
use amp::fixed::Mask;
use amp::som::Grid;
use amp::units::{Millis, Range};

/// Most random moves the simulator's memory holds.
pub const MAX_MOVES: u16 = 1_000;

/// The mind's state with the simulator's larger memory; all else as on the chip.
pub type SimState = State<16, 16, { MAX_MOVES as usize }>;

/// What a transducer heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HeardEcho {
    /// Transducer.
    pub sensor: u8,
    /// What it heard; `None` = nothing answered.
    pub range: Option<Range>,
    /// How long before it is told.
    pub age_ms: u32,
}

impl HeardEcho {
    /// One that is told at once.
    #[must_use]
    pub fn now(sensor: u8, range: Option<Range>) -> Self {
        Self {
            sensor,
            range,
            age_ms: 0,
        }
    }
}

/// Something that drives the robot by its echoes.
pub trait Pilot {
    /// Takes one event and says what to do.
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16>;

    /// Takes echoes that are told at the same moment, one after the other, up to the first that brings about a motion.
    /// Returns how many it took, at least one, and what they brought about together.
    fn echoes(&mut self, at: Millis, echoes: &[HeardEcho]) -> (usize, Outputs<16>) {
        let mut all = Outputs::NONE;
        // As at the end of a link: whoever hears of the past knows the present.
        if echoes.iter().any(|echo| echo.age_ms > 0) {
            all = self.handle(at, Event::Tick);
        }
        for (taken, echo) in (1..).zip(echoes) {
            let HeardEcho { sensor, range, .. } = *echo;
            let outputs = self.handle(at.minus_ms(echo.age_ms), Event::Echo { sensor, range });
            all.decision = all.decision.or(outputs.decision);
            all.mode_changed |= outputs.mode_changed;
            all.stopped = all.stopped.or(outputs.stopped);
            all.verdict = all.verdict.or(outputs.verdict);
            if outputs.motion.is_some() {
                all.motion = outputs.motion;
                return (taken, all);
            }
        }
        (echoes.len(), all)
    }

    /// Why it cannot go on driving; `None` while it can.
    fn failure(&self) -> Option<EpisodeError> {
        None
    }
}

/// A pilot whose maps can be looked at.
pub trait InspectableController: Pilot {
    /// What it knows.
    ///
    /// # Errors
    /// When that lies elsewhere and cannot be fetched.
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError>;
}

impl<P: Pilot> Pilot for &mut P {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        (**self).handle(at, event)
    }

    fn echoes(&mut self, at: Millis, echoes: &[HeardEcho]) -> (usize, Outputs<16>) {
        (**self).echoes(at, echoes)
    }

    fn failure(&self) -> Option<EpisodeError> {
        (**self).failure()
    }
}

impl<P: InspectableController> InspectableController for &mut P {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        (**self).knowledge()
    }
}

/// The robot's mind: the very crate that runs on the microcontroller.
pub struct LocalController {
    config: Config<16>,
    state: Box<SimState>,
    verdicts: Vec<Verdict>,
}

impl LocalController {
    /// A mind that knows nothing yet.
    #[must_use]
    pub fn new(config: Config<16>) -> Self {
        Self::with_state(config, State::new(Grid::rectangle(4, 4)))
    }

    /// A mind that knows this already.
    #[must_use]
    pub fn with_state(config: Config<16>, state: SimState) -> Self {
        Self {
            config,
            state: Box::new(state),
            verdicts: Vec::new(),
        }
    }

    /// Tells it something else; what it knows stays. Its fault detector starts anew with the transducers it has disabled.
    pub fn configure(&mut self, config: Config<16>) {
        self.state.trust(config.believed);
        self.config = config;
    }

    /// What it was told.
    #[must_use]
    pub fn config(&self) -> &Config<16> {
        &self.config
    }

    /// Transducers it uses.
    #[must_use]
    pub fn enabled(&self) -> Mask {
        self.state.enabled(&self.config)
    }

    /// Which transducers its fault detector has disabled, or enabled again, in order.
    #[must_use]
    pub fn verdicts(&self) -> &[Verdict] {
        &self.verdicts
    }

    /// What it knows.
    #[must_use]
    pub fn state(&self) -> &SimState {
        &self.state
    }
}

impl Pilot for LocalController {
    // Who calls it says which event it is: there it is only a call of what that event does.
    #[inline(always)]
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let outputs = controller::handle(&self.config, &mut self.state, at, event);
        if let Some(verdict) = outputs.verdict {
            self.verdicts.push(verdict);
        }
        outputs
    }
}

impl InspectableController for LocalController {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        Ok(&self.state)
    }
}
