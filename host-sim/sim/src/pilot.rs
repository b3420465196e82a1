//! A pilot drives the robot: events go in, motions come out.

use crate::error::EpisodeError;
use crate::robot::MAX_BEAMS;
use crate::senses::{Readings, SenseGoal};
use amp::action_map::ActionMap;
use amp::config::Config;
use amp::controller::{self, Event, Outputs, State};
use amp::faults::SensorVerdict;
use amp::fixed::Mask;
use amp::memory;
use amp::places::Aim;
use amp::som::Grid;
use amp::turret::BodySpec;
use amp::units::{Millis, Range};
use std::any::Any;

/// Capacity of the simulator's memory for random moves.
pub const MAX_MOVES: u16 = 1_000;

/// The controller's state, with a larger memory than on the chip.
pub type SimState = SizedState<16>;

/// As [`SimState`], with maps of this many neurons.
pub type SizedState<const NEURONS: usize> = State<16, NEURONS, { MAX_MOVES as usize }>;

/// What was known in the situation before the first move. A body's sensors do not see all at once,
/// and a range that jumped during the first move (`Learning::largest_change_mm`) belonged to an
/// edge or was noise: a place is not recognized by it.
#[must_use]
pub fn nest_known<const NEURONS: usize>(knowledge: &SizedState<NEURONS>) -> Mask {
    let first = knowledge.memory().samples().first();
    first.map_or(Mask::ALL, |sample| memory::from_bytes(&sample.before).1)
}

/// An echo with its age, as a pilot receives it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AgedEcho {
    /// Transducer.
    pub sensor: u8,
    /// `None` = no echo.
    pub range: Option<Range>,
    /// Age of the echo when it is delivered.
    pub age_ms: u32,
}

impl AgedEcho {
    /// An echo of age 0.
    #[must_use]
    pub fn now(sensor: u8, range: Option<Range>) -> Self {
        Self {
            sensor,
            range,
            age_ms: 0,
        }
    }
}

/// Drives the robot by its echoes.
pub trait Pilot {
    /// Handles one event.
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16>;

    /// Handles echoes that are delivered together, in order, up to the first that causes a motion.
    /// Returns how many it handled, at least one, and their joint outputs.
    fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
        let mut all = Outputs::NONE;
        // As over a link: the current time is known before an old echo.
        if echoes.iter().any(|echo| echo.age_ms > 0) {
            all = self.handle(at, Event::Tick);
        }
        for (taken, echo) in (1..).zip(echoes) {
            let AgedEcho { sensor, range, .. } = *echo;
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

    /// From now on a robot that pursues a goal is led by its memory of places; `None`: it is not.
    ///
    /// # Errors
    /// When it has no memory of places.
    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        aim.map_or(Ok(()), |_| Err(EpisodeError::NoPlaces))
    }

    /// As [`lead_to`](Self::lead_to); without a memory of places it finds its way by the goal
    /// alone.
    ///
    /// # Errors
    /// When it cannot be reached.
    fn lead_if_it_can(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        match self.lead_to(aim) {
            Err(EpisodeError::NoPlaces) => Ok(()),
            answer => answer,
        }
    }

    /// What else its sensors read, where it is now.
    fn sense(&mut self, _at: Millis, _readings: &Readings) {}

    /// From now on a robot that pursues a goal is led to what is sought in another modality;
    /// `None`: it is not.
    ///
    /// # Errors
    /// When it has no memory of places.
    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        goal.map_or(Ok(()), |_| Err(EpisodeError::NoPlaces))
    }

    /// Why it cannot continue; `None` while it can.
    fn failure(&self) -> Option<EpisodeError> {
        None
    }
}

/// A pilot whose maps can be read.
pub trait InspectableController: Pilot {
    /// Maps and memory.
    ///
    /// # Errors
    /// When they are remote and cannot be read.
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError>;

    /// What was known in the situation before the first move: [`nest_known`].
    ///
    /// # Errors
    /// As [`knowledge`](Self::knowledge).
    fn known_at_nest(&mut self) -> Result<Mask, EpisodeError> {
        Ok(nest_known(self.knowledge()?))
    }

    /// The body as it is known; `None` for a ring on a held turret.
    ///
    /// # Errors
    /// As [`knowledge`](Self::knowledge).
    fn body(&mut self) -> Result<Option<BodySpec<MAX_BEAMS>>, EpisodeError> {
        Ok(None)
    }
}

impl<P: Pilot> Pilot for &mut P {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        (**self).handle(at, event)
    }

    fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
        (**self).echoes(at, echoes)
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        (**self).lead_to(aim)
    }

    fn sense(&mut self, at: Millis, readings: &Readings) {
        (**self).sense(at, readings);
    }

    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        (**self).seek_sense(goal)
    }

    fn failure(&self) -> Option<EpisodeError> {
        (**self).failure()
    }
}

impl<P: InspectableController> InspectableController for &mut P {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        (**self).knowledge()
    }

    fn known_at_nest(&mut self) -> Result<Mask, EpisodeError> {
        (**self).known_at_nest()
    }

    fn body(&mut self) -> Result<Option<BodySpec<MAX_BEAMS>>, EpisodeError> {
        (**self).body()
    }
}

/// The controller in this process: the same crate as on the microcontroller, with maps of any size.
pub struct LocalController<const NEURONS: usize = 16> {
    config: Config<16>,
    state: Box<SizedState<NEURONS>>,
    verdicts: Vec<SensorVerdict>,
}

impl LocalController {
    /// A controller without any knowledge, with maps of 16 neurons.
    #[must_use]
    pub fn new(config: Config<16>) -> Self {
        Self::sized(config, Grid::rectangle(4, 4))
    }

    /// A controller with this knowledge.
    #[must_use]
    pub fn with_state(config: Config<16>, state: SimState) -> Self {
        Self::of(config, state)
    }
}

impl<const NEURONS: usize> LocalController<NEURONS> {
    /// A controller without any knowledge; its maps have this grid of `NEURONS` places.
    #[must_use]
    pub fn sized(config: Config<16>, grid: Grid) -> Self {
        Self::of(config, State::new(grid))
    }

    fn of(config: Config<16>, mut state: SizedState<NEURONS>) -> Self {
        state.expect_open_space(config.open_space);
        Self {
            config,
            state: Box::new(state),
            verdicts: Vec::new(),
        }
    }

    /// Replaces the configuration and keeps the knowledge. The fault detector restarts with the
    /// transducers that it has disabled.
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

    /// Transducers that it uses.
    #[must_use]
    pub fn enabled(&self) -> Mask {
        self.state.enabled(&self.config)
    }

    /// Verdicts of its fault detector, in order.
    #[must_use]
    pub fn verdicts(&self) -> &[SensorVerdict] {
        &self.verdicts
    }

    /// Maps and memory.
    #[must_use]
    pub fn state(&self) -> &SizedState<NEURONS> {
        &self.state
    }

    /// Replaces the action map by one that was not learned; everything else stays.
    pub fn replace_actions(&mut self, actions: ActionMap<NEURONS, 16>) {
        self.state.replace_actions(actions);
    }
}

impl<const NEURONS: usize> Pilot for LocalController<NEURONS> {
    // Callers pass a constant kind of event, so inlining leaves only the code for that kind.
    #[inline(always)]
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let outputs = controller::handle(&self.config, &mut self.state, at, event);
        if let Some(verdict) = outputs.verdict {
            self.verdicts.push(verdict);
        }
        outputs
    }
}

impl<const NEURONS: usize> InspectableController for LocalController<NEURONS> {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        let state: &dyn Any = &*self.state;
        state.downcast_ref().ok_or(EpisodeError::OtherNeurons)
    }

    fn known_at_nest(&mut self) -> Result<Mask, EpisodeError> {
        Ok(nest_known(&self.state))
    }
}
