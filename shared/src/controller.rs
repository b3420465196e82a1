//! The whole robot as one function: [`handle`] takes an event and says what to do.
//!
//! | mode | what happens |
//! |---|---|
//! | *Idle* | nothing moves |
//! | *Explore* | random moves, each remembered as (S, a, S') |
//! | *Learn* | standing still; each tick teaches both maps a fixed number of samples |
//! | *Seek* | each complete ring becomes a decision towards the goal |
//! | *Stopped* | nothing moves until the next command, and the reason is kept |
//!
//! A *decision* is taken when every enabled transducer has been heard since the last motion ended. Between decisions
//! each echo passes the shield, which may shorten the motion under way. Time comes with the events; the only randomness is
//! the generator in the state, seeded by the command.
//!
//! A robot that explores or seeks stops by itself ([`StopReason`]) when an enabled transducer is not heard for two ring
//! periods, when three rings in a row hear nothing at all, and when a motion passes its deadline. The state also holds the
//! fault detector: a transducer that misbehaves is disabled.

use crate::action_map::ActionMap;
use crate::config::Config;
use crate::faults::Detector;
use crate::fixed::Mask;
use crate::memory::Memory;
use crate::planner::Memo;
use crate::scan::{Aligned, Echo, Scan};
use crate::shield::Shield;
use crate::som::kernels::Kernels;
use crate::som::{Grid, Som};
use crate::units::{Bearing, Displacement, Millis};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

mod decide;
mod learn;
mod message;
mod parts;
mod search;
pub(crate) mod supervise;
mod tracked;

pub use message::{Command, Decision, Event, Mode, Motion, Outputs, Progress, Refusal, StopReason};
pub use parts::{Part, PartError};
use search::Search;
pub use tracked::Tracked;

/// A motion under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Pending<const SENSORS: usize> {
    before: Aligned<SENSORS>,
    commanded: Displacement,
    /// Executed so far, in the ring's frame at the decision.
    executed: Displacement,
    /// Still to go.
    remaining: Tracked,
    /// How far the ring has turned since the decision.
    turned: Bearing,
    speed_mm_s: u16,
}

impl<const SENSORS: usize> Pending<SENSORS> {
    /// Less than half of it was carried out.
    fn was_cut(&self) -> bool {
        let half = u32::from(self.commanded.length_mm() / 2);
        self.executed.is_shorter_than(half)
    }

    /// The base has gone farther than it was to go: braking takes a way of its own.
    fn was_overrun(&self) -> bool {
        let left = self.remaining.now().rotated(self.turned.direction());
        left.opposes(self.commanded)
    }
}

/// Everything the robot knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct State<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize> {
    mode: Mode<SENSORS>,
    /// What a stop interrupted: exploring or seeking; idle if nothing.
    interrupted: Mode<SENSORS>,
    scan: Scan<SENSORS>,
    /// The latest time heard of.
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
    shield: Shield<SENSORS>,
    memory: Memory<SENSORS, SAMPLES>,
    situations: Som<NEURONS, SENSORS>,
    actions: ActionMap<NEURONS, SENSORS>,
    learned: bool,
    /// Moves the maps have learned from since they were made, as far as it counts.
    lessons: u16,
    /// Maps written from outside to their ends, bit by [`Part`].
    written: u8,
    /// Seeded by the command to explore.
    generator: Option<Xoshiro128PlusPlus>,
    pending: Option<Pending<SENSORS>>,
    /// The motion has not ended.
    moving: bool,
    /// The action neuron that asked for it, if one did.
    asked_by: Option<u8>,
    motion_id: u16,
    /// The last displacement.
    course: Tracked,
    /// Decisions in a row for which all ways that were tried were closed.
    closed: u8,
    /// Decisions for which each action neuron stays inhibited.
    inhibited: [u8; NEURONS],
    /// What the searches of the last decision found.
    last_plan: Memo,
    /// How the search for a place goes.
    search: Search,
}

/// The state for the Nomad 200 with the paper's sizes.
pub type NomadState = State<16, 16, 100>;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// A robot that knows nothing; `grid` should have `NEURONS` places.
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
            shield: Shield::new(),
            memory: Memory::new(),
            situations: Som::zeroed(grid),
            actions: ActionMap::zeroed(grid),
            learned: false,
            lessons: 0,
            written: 0,
            generator: None,
            pending: None,
            moving: false,
            asked_by: None,
            motion_id: 0,
            course: Tracked::ZERO,
            closed: 0,
            inhibited: [0; NEURONS],
            last_plan: Memo::NONE,
            search: Search::NEW,
        }
    }

    /// Has the processor's own kernels do what they can; it comes to the same.
    pub const fn use_kernels(&mut self, kernels: &'static Kernels) {
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

    /// A seed for whoever is to go on from here with randomness of his own; the same until the next random number.
    pub(crate) fn next_seed(&self) -> Option<u64> {
        let mut generator = self.generator.clone()?;
        Some(generator.next_u64())
    }

    /// Starts the generator anew.
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

/// Handles one event that happened at `at`. Worst case: the echo that completes a ring while seeking (one decision plus one
/// update of each map), or a tick while learning.
#[must_use]
pub fn handle<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>(
    config: &Config<SENSORS>,
    state: &mut State<SENSORS, NEURONS, SAMPLES>,
    at: Millis,
    event: Event<SENSORS>,
) -> Outputs<SENSORS> {
    let is_present = matches!(event, Event::Tick | Event::Command(_));
    state.pass_time(config, at, is_present);
    // A decision, on an echo, is where the stack is deepest: what the other events need of it lies in functions of their own.
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

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    fn echo(&mut self, config: &Config<SENSORS>, sensor: u8, echo: Echo) -> Outputs<SENSORS> {
        let age_ms = self.now.since(echo.at);
        if age_ms > patience_ms(config) {
            return stale(age_ms);
        }
        // The robot was elsewhere, or it knows better already.
        if !self.moving && echo.at.is_before(self.waiting_since) {
            return stale(age_ms);
        }
        let index = usize::from(sensor);
        if (self.scan.heard_at(index)).is_some_and(|heard| echo.at.is_before(heard)) {
            return stale(age_ms);
        }
        if self.enabled(config).contains(index) {
            self.shield.hear(config, index, echo);
            self.heard_any |= echo.range.is_some();
        }
        let verdict = self.detector.hear(config, sensor, echo.range);
        self.scan.hear(index, echo);
        let mut outputs = if self.moving {
            self.guard(config, index, echo.at)
        } else if self.scan.is_complete(self.enabled(config)) {
            self.decide(config, echo.at)
        } else {
            Outputs::none()
        };
        outputs.verdict = verdict;
        outputs
    }

    /// Transducers that are used: those configured, less those the fault detector has disabled.
    #[must_use]
    pub fn enabled(&self, config: &Config<SENSORS>) -> Mask {
        self.detector.enabled(config)
    }

    /// The fault detector.
    #[must_use]
    pub const fn detector(&self) -> &Detector<SENSORS> {
        &self.detector
    }

    /// Enables transducers that the fault detector has disabled; it starts anew with them.
    pub fn trust(&mut self, sensors: Mask) {
        self.detector.trust(sensors);
    }

    /// Shortens the motion under way where the newest echo asks for it.
    fn guard(&mut self, config: &Config<SENSORS>, sensor: usize, now: Millis) -> Outputs<SENSORS> {
        let Some(pending) = &mut self.pending else {
            return Outputs::none();
        };
        let remaining = pending.remaining.now();
        let enabled = self.detector.enabled(config);
        let Some(allowed) = self.shield.shorten(config, enabled, remaining, now, sensor) else {
            return Outputs::none();
        };
        // A base that has gone too far stands; it does not turn round and come back.
        let left_mm = if pending.was_overrun() {
            0
        } else {
            allowed.distance_mm
        };
        let shorter = remaining.with_length(left_mm);
        pending.remaining = Tracked::new(shorter);
        let faster = Motion {
            id: self.motion_id,
            displacement: shorter,
            speed_mm_s: pending.speed_mm_s,
        };
        pending.speed_mm_s = allowed.speed_mm_s.min(pending.speed_mm_s);
        let motion = Motion {
            speed_mm_s: pending.speed_mm_s,
            ..faster
        };
        // No more than what the lower speed takes: something that comes nearer and nearer must not put it off for ever.
        let slower_ms = motion.longest_ms().saturating_sub(faster.longest_ms());
        self.deadline = self.deadline.plus_ms(slower_ms);
        Outputs {
            motion: Some(motion),
            ..Outputs::none()
        }
    }

    #[inline(never)]
    fn odometry(
        &mut self,
        config: &Config<SENSORS>,
        at: Millis,
        motion: u16,
        moved: Displacement,
        turned: Bearing,
        progress: Progress,
    ) {
        if progress == Progress::Touched {
            self.detector.touched(config, moved);
        }
        self.detector.moved(config, moved, turned);
        self.shield.moved(moved, turned);
        self.course.turn(turned);
        let Some(pending) = &mut self.pending else {
            return;
        };
        let since_decision = if pending.turned == Bearing::ZERO {
            moved
        } else {
            moved.rotated(pending.turned.direction())
        };
        pending.executed = pending.executed.plus(since_decision);
        pending.remaining.go(moved, turned);
        pending.turned = pending.turned.plus(turned);
        if motion != self.motion_id || !self.moving {
            return;
        }
        match progress {
            Progress::Moving => {}
            Progress::Steering => self.allow_steering(config, at),
            Progress::Ended | Progress::Touched => {
                self.moving = false;
                self.await_ring(at);
            }
        }
    }

    #[inline(never)]
    fn command(
        &mut self,
        config: &Config<SENSORS>,
        at: Millis,
        command: Command<SENSORS>,
    ) -> Outputs<SENSORS> {
        self.last_plan.forget_cost();
        let most = u16::try_from(SAMPLES).unwrap_or(u16::MAX);
        let mode = match command {
            Command::Explore { moves, .. } if moves == 0 || moves > most => {
                return refused(Refusal::Moves { most });
            }
            Command::Learn if self.memory.samples().is_empty() => {
                return refused(Refusal::NoSamples);
            }
            Command::Seek(_) if !self.learned => return refused(Refusal::NotLearnt),
            Command::Explore { moves, seed } => {
                self.generator = Some(Xoshiro128PlusPlus::seed_from_u64(seed));
                self.memory.clear();
                Mode::Explore { left: moves }
            }
            Command::Learn => {
                self.start_maps(config);
                Mode::Learn { step: 0 }
            }
            Command::Seek(goal) => {
                self.search = Search::NEW;
                Mode::Seek { goal }
            }
            Command::Stop => {
                let stopped = self.stop(at, StopReason::Commanded);
                // Said each time: the order before may have been lost.
                let motion = stopped.motion.or(Some(self.standing()));
                return Outputs { motion, ..stopped };
            }
            Command::Resume => match (self.mode, self.interrupted) {
                (Mode::Stopped(_), interrupted @ (Mode::Explore { .. } | Mode::Seek { .. })) => {
                    interrupted
                }
                _ => return refused(Refusal::NothingToResume),
            },
        };
        self.enter(at, mode)
    }

    /// Stands still and keeps what that interrupts for [`Command::Resume`].
    #[inline(never)]
    fn stop(&mut self, at: Millis, reason: StopReason) -> Outputs<SENSORS> {
        self.interrupted = match self.mode {
            Mode::Explore { .. } | Mode::Seek { .. } => self.mode,
            Mode::Stopped(_) => self.interrupted,
            Mode::Idle | Mode::Learn { .. } => Mode::Idle,
        };
        self.enter(at, Mode::Stopped(reason))
    }

    /// Something outside is wrong: whoever may move stops, anybody else goes on.
    fn alarm(&mut self, at: Millis, reason: StopReason) -> Outputs<SENSORS> {
        match self.mode {
            Mode::Explore { .. } | Mode::Seek { .. } => self.stop(at, reason),
            Mode::Idle | Mode::Learn { .. } | Mode::Stopped(_) => Outputs::none(),
        }
    }

    /// From now on every transducer has to be heard again.
    fn await_ring(&mut self, at: Millis) {
        self.scan.renew();
        self.waiting_since = at;
    }

    /// The order to stand.
    const fn standing(&self) -> Motion {
        Motion {
            id: self.motion_id,
            displacement: Displacement::ZERO,
            speed_mm_s: 0,
        }
    }

    /// Changes the mode. A motion under way is stopped, except from one goal to the next. One copy of it in a program.
    #[inline(never)]
    fn enter(&mut self, at: Millis, mode: Mode<SENSORS>) -> Outputs<SENSORS> {
        let goes_on = matches!((&self.mode, &mode), (Mode::Seek { .. }, Mode::Seek { .. }));
        let stopped = match mode {
            Mode::Stopped(reason) => Some(reason),
            _ => None,
        };
        self.mode = mode;
        let motion = (self.moving && !goes_on).then(|| {
            self.motion_id = self.motion_id.wrapping_add(1);
            self.standing()
        });
        if !goes_on {
            self.pending = None;
            self.moving = false;
            self.silent_rings = 0;
            self.heard_any = false;
            self.await_ring(at);
        }
        Outputs {
            motion,
            mode_changed: true,
            stopped,
            ..Outputs::none()
        }
    }

    #[inline(never)]
    fn tick(&mut self, config: &Config<SENSORS>, at: Millis) -> Outputs<SENSORS> {
        let Mode::Learn { step } = self.mode else {
            return self.supervise(config, at);
        };
        let steps = self.learning_steps(config);
        let step = self.learn_slice(config, step, steps);
        if step < steps {
            self.mode = Mode::Learn { step };
            return Outputs::none();
        }
        self.learned = true;
        self.enter(at, Mode::Idle)
    }
}

/// The longest time a whole ring may take, milliseconds; an older echo is stale.
fn patience_ms<const SENSORS: usize>(config: &Config<SENSORS>) -> u32 {
    u32::from(config.robot.ring_period_ms).saturating_mul(2)
}

fn stale<const SENSORS: usize>(age_ms: u32) -> Outputs<SENSORS> {
    Outputs {
        stale_ms: Some(age_ms),
        ..Outputs::none()
    }
}

fn refused<const SENSORS: usize>(refusal: Refusal) -> Outputs<SENSORS> {
    Outputs {
        refusal: Some(refusal),
        ..Outputs::none()
    }
}

#[cfg(test)]
mod tests;
