//! The whole robot as one function: [`handle`] takes an event and returns what to do.
//!
//! | mode | what happens |
//! |---|---|
//! | *Idle* | nothing moves |
//! | *Explore* | random moves, each remembered as (S, a, S') |
//! | *Learn* | standing still; each tick teaches both maps a fixed number of samples |
//! | *Seek* | each complete ring becomes a decision towards the goal |
//! | *Stopped* | nothing moves until the next command; the reason is stored |
//! | *Babble* | random moves of a body that finds where its sensors look ([`body`](crate::body)) |
//! | *Calibrate* | standing still; each tick is a step to where they look |
//!
//! A *decision* is taken when every enabled transducer has been heard since the last motion ended.
//! Between decisions each echo passes the shield, which may shorten the motion under way. Time
//! comes with the events; the only randomness is the generator in the state, seeded by the command.
//!
//! A robot that explores or seeks stops by itself ([`StopReason`]) when an enabled transducer is
//! not heard for two ring periods, when three rings in a row hear nothing at all, and when a motion
//! passes its deadline. The state also holds the fault detector: a transducer that misbehaves is
//! disabled.

use crate::action_map::ActionMap;
use crate::config::Config;
use crate::faults::Detector;
use crate::fixed::Mask;
use crate::memory::Memory;
use crate::places::Leg;
use crate::planner::SearchCache;
use crate::scan::{Echo, Scan};
use crate::shield::Shield;
use crate::som::kernels::Kernels;
use crate::som::{Grid, Som};
use crate::units::Millis;
use rand_core::Rng;
#[cfg(feature = "store")]
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

mod calibrate;
mod commands;
mod decide;
mod learn;
mod message;
mod motion;
mod parts;
mod search;
pub(crate) mod supervise;
mod tracked;
#[cfg_attr(not(feature = "graph"), path = "controller/traverse/absent.rs")]
mod traverse;

pub(crate) use commands::refused;
pub use message::{
    Command, CommandRefusal, Decision, Event, Mode, Motion, Outputs, Progress, StopReason,
};
use motion::Pending;
pub(crate) use motion::stale;
pub use parts::{StatePart, TransferError};
use search::SearchProgress;
pub use tracked::Tracked;

/// Everything that changes while the robot runs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct State<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize> {
    mode: Mode<SENSORS>,
    /// What a stop interrupted: exploring or seeking; idle if nothing.
    interrupted: Mode<SENSORS>,
    scan: Scan<SENSORS>,
    /// The latest time of any event.
    now: Millis,
    /// Since when the ring has been awaited; while moving, when the motion began.
    waiting_since: Millis,
    /// The motion under way has to end before.
    deadline: Millis,
    /// Something was heard since the last decision.
    heard_any: bool,
    /// Rings in a row that heard nothing.
    silent_rings: u8,
    /// The session expects rings without any echo.
    open_space: bool,
    detector: Detector<SENSORS>,
    /// Sectors of a virtual turret of which nothing is known at present. Zero at first: a state of
    /// zeros takes no flash.
    hidden: Mask,
    shield: Shield<SENSORS>,
    memory: Memory<SENSORS, SAMPLES>,
    situations: Som<NEURONS, SENSORS>,
    actions: ActionMap<NEURONS, SENSORS>,
    learned: bool,
    /// Updates of the maps since they were made, saturating.
    updates: u16,
    /// Maps written from outside to their ends, bit by [`StatePart`].
    written: u8,
    /// Seeded by the command to explore.
    generator: Option<Xoshiro128PlusPlus>,
    pending: Option<Pending<SENSORS>>,
    /// The motion has not ended.
    moving: bool,
    /// The action neuron whose action it is, if there is one.
    acting_neuron: Option<u8>,
    motion_id: u16,
    /// The last displacement.
    course: Tracked,
    /// Decisions in a row for which the shield allowed no motion.
    blocked: u8,
    /// Decisions for which each action neuron stays inhibited.
    inhibited: [u8; NEURONS],
    /// What the searches of the last decision found.
    last_plan: SearchCache,
    /// How the search for a place goes.
    search: SearchProgress,
    /// The way on which a memory of places leads the robot, if it does. Zeros at first.
    leg: Leg,
    is_led: bool,
    /// What was traversed, for plans of several steps.
    #[cfg(feature = "graph")]
    graph: traverse::TraversedGraph<NEURONS>,
}

/// The state for the Nomad 200 with the paper's sizes.
pub type NomadState = State<16, 16, 100>;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// A robot that has learned nothing; `grid` should have `NEURONS` places.
    #[must_use]
    pub const fn new(grid: Grid) -> Self {
        Self {
            mode: Mode::Idle,
            interrupted: Mode::Idle,
            scan: Scan::new(),
            now: Millis::from_ms(0),
            waiting_since: Millis::from_ms(0),
            deadline: Millis::from_ms(0),
            heard_any: false,
            silent_rings: 0,
            open_space: false,
            detector: Detector::new(),
            hidden: Mask::NONE,
            shield: Shield::new(),
            memory: Memory::new(),
            situations: Som::zeroed(grid),
            actions: ActionMap::zeroed(grid),
            learned: false,
            updates: 0,
            written: 0,
            generator: None,
            pending: None,
            moving: false,
            acting_neuron: None,
            motion_id: 0,
            course: Tracked::ZERO,
            blocked: 0,
            inhibited: [0; NEURONS],
            last_plan: SearchCache::NONE,
            search: SearchProgress::NEW,
            leg: Leg::ZERO,
            is_led: false,
            #[cfg(feature = "graph")]
            graph: traverse::TraversedGraph::new(),
        }
    }

    /// Uses CPU-specific kernels; results are bit-identical.
    pub fn use_kernels(&mut self, kernels: &'static Kernels) {
        self.situations.use_kernels(kernels);
        self.actions.use_kernels(kernels);
    }

    /// Puts the maps on another grid; it should have `NEURONS` places.
    pub(crate) const fn set_grid(&mut self, grid: Grid) {
        self.situations.set_grid(grid);
        self.actions.changes_mut().set_grid(grid);
        self.actions.actions_mut().set_grid(grid);
    }

    /// What the robot is doing.
    #[must_use]
    pub const fn mode(&self) -> &Mode<SENSORS> {
        &self.mode
    }

    /// What it knows of near things.
    pub(crate) const fn shield_mut(&mut self) -> &mut Shield<SENSORS> {
        &mut self.shield
    }

    /// Whether the base has been sent on its way and has not reported its end.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        self.moving
    }

    /// The lazy memory.
    #[must_use]
    pub const fn memory(&self) -> &Memory<SENSORS, SAMPLES> {
        &self.memory
    }

    /// The situation map.
    #[must_use]
    pub const fn situations(&self) -> &Som<NEURONS, SENSORS> {
        &self.situations
    }

    /// The action map.
    #[must_use]
    pub const fn actions(&self) -> &ActionMap<NEURONS, SENSORS> {
        &self.actions
    }

    /// Replaces the action map, in any mode: what the planner predicts with is then not what was
    /// learned. For experiments.
    pub fn replace_actions(&mut self, actions: ActionMap<NEURONS, SENSORS>) {
        self.actions = actions;
    }

    /// The latest scan.
    #[must_use]
    pub const fn scan(&self) -> &Scan<SENSORS> {
        &self.scan
    }

    /// Whether there are maps to seek with.
    #[must_use]
    pub const fn has_learned(&self) -> bool {
        self.learned
    }

    /// Whether the session expects rings without any echo; otherwise three in a row stop the robot.
    #[must_use]
    pub const fn expects_open_space(&self) -> bool {
        self.open_space
    }

    /// Begins a session that expects rings without any echo, or does not.
    pub const fn expect_open_space(&mut self, expected: bool) {
        self.open_space = expected;
    }

    /// Transducers in use: those configured, less those that the fault detector has disabled or
    /// that a virtual turret knows nothing of.
    #[must_use]
    pub fn enabled(&self, config: &Config<SENSORS>) -> Mask {
        let enabled = self.detector.enabled(config).to_bits();
        Mask::from_bits(enabled & !self.hidden.to_bits())
    }

    /// Limits what is used of the ring to these, until the next call.
    pub(crate) const fn set_visible(&mut self, visible: Mask) {
        self.hidden = Mask::from_bits(!visible.to_bits());
    }

    /// Whether it pursues a place and comes no nearer.
    pub(crate) const fn is_stuck(&self) -> bool {
        self.search.wanders()
    }

    /// At the next decision it goes about along this way, if there is one, while it seeks. At the
    /// end of the way it begins anew to come nearer to its goal.
    pub(crate) const fn lead(&mut self, leg: Option<Leg>) {
        if self.is_led && leg.is_none() {
            self.search = SearchProgress::NEW;
        }
        self.is_led = leg.is_some();
        if let Some(leg) = leg {
            self.leg = leg;
        }
    }

    /// Whether its memory of places led it at the last decision.
    #[must_use]
    pub const fn is_led(&self) -> bool {
        self.is_led
    }

    /// The fault detector.
    #[must_use]
    pub const fn detector(&self) -> &Detector<SENSORS> {
        &self.detector
    }

    /// Enables transducers that the fault detector has disabled, and resets their scores.
    pub fn trust(&mut self, sensors: Mask) {
        self.detector.trust(sensors);
    }

    /// A seed for the saved image; the same until the next random number.
    #[cfg(feature = "store")]
    pub(crate) fn next_seed(&self) -> Option<u64> {
        let mut generator = self.generator.clone()?;
        Some(generator.next_u64())
    }

    /// Seeds the generator.
    #[cfg(feature = "store")]
    pub(crate) fn seed(&mut self, seed: u64) {
        self.generator = Some(Xoshiro128PlusPlus::seed_from_u64(seed));
    }

    /// A uniform number below `bound`; 0 for a bound of 0.
    fn below(&mut self, bound: u32) -> u32 {
        ((u64::from(self.random()) * u64::from(bound)) >> 32) as u32
    }

    /// A uniform number of 32 bits; 0 before the first command to explore.
    fn random(&mut self) -> u32 {
        self.generator
            .as_mut()
            .map_or(0, Xoshiro128PlusPlus::next_u32)
    }
}

/// Handles one event that happened at `at`. Worst case: one decision plus one update of each map,
/// or a tick while learning.
#[must_use]
pub fn handle<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>(
    config: &Config<SENSORS>,
    state: &mut State<SENSORS, NEURONS, SAMPLES>,
    at: Millis,
    event: Event<SENSORS>,
) -> Outputs<SENSORS> {
    let is_present = matches!(event, Event::Tick | Event::Command(_));
    state.pass_time(config, at, is_present);
    // The stack is deepest in a decision, on an echo: the other events are handled in functions of
    // their own.
    match event {
        Event::Echo { sensor, range } => state.echo(config, sensor, Echo { range, at }),
        Event::Odometry {
            motion,
            moved,
            turned,
            progress,
        } => {
            state.odometry(config, at, motion, moved, turned, progress);
            Outputs::none()
        }
        Event::Command(command) => state.command(config, at, command),
        Event::Tick => state.tick(config, at),
        Event::Alarm(reason) => state.alarm(at, reason),
        Event::Touched => state.touched(config, at),
    }
}

/// The longest time a whole ring may take, milliseconds; an older echo is stale.
fn patience_ms<const SENSORS: usize>(config: &Config<SENSORS>) -> u32 {
    u32::from(config.robot.ring_period_ms).saturating_mul(2)
}

#[cfg(test)]
mod tests;
