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
//! A *decision* is taken when every believed transducer has been heard since the last motion ended. Between decisions
//! each echo passes the shield, which may shorten the motion under way. Time comes with the events; the only randomness is
//! the generator in the state, seeded by the command.

use crate::action_map::{ActionMap, Effect};
use crate::config::{Config, Taught};
use crate::fixed::{Dither, Mask};
use crate::goal::Goal;
use crate::memory::{self, Memory, Sample};
use crate::planner::{Plan, Planner, difference};
use crate::scan::{Echo, Scan, Situation};
use crate::shield::Shield;
use crate::som::neighbourhood::Pull;
use crate::som::{Grid, Neighbourhood, Som};
use crate::units::{Bearing, Displacement, Millis, Range};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

mod learn;

/// What the robot is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode<const SENSORS: usize> {
    /// Nothing.
    Idle,
    /// Random moves.
    Explore {
        /// Samples still to be taken.
        left: u16,
    },
    /// Learning from the memory.
    Learn {
        /// Presentations done.
        step: u32,
    },
    /// Towards a goal.
    Seek {
        /// The goal.
        goal: Goal<SENSORS>,
    },
    /// Standing, for a reason.
    Stopped(StopReason),
}

/// Why the robot stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// It was told to.
    Commanded,
}

/// Why a command was not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// More moves than the memory holds, or none.
    Moves {
        /// The most it holds.
        most: u16,
    },
    /// There is nothing to learn from.
    NoSamples,
    /// The maps have not been learnt.
    NotLearnt,
}

/// What somebody wants of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command<const SENSORS: usize> {
    /// Forget the samples and take so many new ones by random moves.
    Explore {
        /// Number of moves, at least 1.
        moves: u16,
        /// Seed of the robot's own generator.
        seed: u64,
    },
    /// Make the maps from the samples.
    Learn,
    /// Pursue a goal from now on.
    Seek(Goal<SENSORS>),
    /// Stand still.
    Stop,
}

/// What became of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// Still under way.
    Moving,
    /// The base stands, the motion is over.
    Ended,
    /// The base stands because something was touched.
    Touched,
}

/// Something that happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event<const SENSORS: usize> {
    /// A transducer listened; `None` = nothing answered.
    Echo {
        /// Transducer.
        sensor: u8,
        /// What it heard.
        range: Option<Range>,
    },
    /// The base reports what it has done since its last report.
    Odometry {
        /// Motion it is carrying out or has carried out last.
        motion: u16,
        /// Displacement since the last report, in the ring's frame at that report.
        moved: Displacement,
        /// How far the ring has turned since then.
        turned: Bearing,
        /// What became of the motion.
        progress: Progress,
    },
    /// Somebody wants something.
    Command(Command<SENSORS>),
    /// Time passes.
    Tick,
}

/// What the base is asked to do: a straight displacement in the ring's present frame. A newer motion replaces an older
/// one, zero stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Motion {
    /// Number of the motion; a shortened motion keeps its number.
    pub id: u16,
    /// Where to, from here.
    pub displacement: Displacement,
    /// At most this fast, millimetres per second.
    pub speed_mm_s: u16,
}

/// What one event brought about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outputs<const SENSORS: usize> {
    /// What the base is to do.
    pub motion: Option<Motion>,
    /// A decision was taken.
    pub decision: Option<Decision<SENSORS>>,
    /// The mode changed.
    pub mode_changed: bool,
    /// A command was refused.
    pub refusal: Option<Refusal>,
}

impl<const SENSORS: usize> Outputs<SENSORS> {
    /// Nothing.
    pub const NONE: Self = Self {
        motion: None,
        decision: None,
        mode_changed: false,
        refusal: None,
    };
}

/// A decision as telemetry: what was perceived, wanted and allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Decision<const SENSORS: usize> {
    /// The situation it was taken in.
    pub situation: Situation<SENSORS>,
    /// How it came about; `None` for a random move.
    pub plan: Option<Plan<SENSORS>>,
    /// Displacement wanted.
    pub wanted: Displacement,
    /// Displacement the shield allowed.
    pub allowed: Displacement,
    /// The goal holds.
    pub at_goal: bool,
}

/// A motion under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Pending<const SENSORS: usize> {
    before: Situation<SENSORS>,
    commanded: Displacement,
    /// Executed so far, in the ring's frame at the decision.
    executed: Displacement,
    /// Still to go, in the ring's present frame.
    remaining: Displacement,
    /// How far the ring has turned since the decision.
    turned: Bearing,
    speed_mm_s: u16,
    action_neuron: Option<u8>,
    ended: bool,
}

impl<const SENSORS: usize> Pending<SENSORS> {
    /// Less than half of it was carried out.
    fn was_cut(&self) -> bool {
        self.executed.length_mm() < self.commanded.length_mm() / 2
    }
}

/// Everything the robot knows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct State<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize> {
    mode: Mode<SENSORS>,
    scan: Scan<SENSORS>,
    shield: Shield<SENSORS>,
    memory: Memory<SENSORS, SAMPLES>,
    situations: Som<NEURONS, SENSORS>,
    actions: ActionMap<NEURONS, SENSORS>,
    learnt: bool,
    generator: Xoshiro128PlusPlus,
    pending: Option<Pending<SENSORS>>,
    motion_id: u16,
    dither: Dither,
    /// The last displacement, in the ring's present frame.
    course: Displacement,
    /// Decisions for which each action neuron stays inhibited.
    inhibited: [u8; NEURONS],
}

/// The state for the Nomad 200 with the paper's sizes.
pub type NomadState = State<16, 16, 100>;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    /// A robot that knows nothing; `grid` should have `NEURONS` places.
    #[must_use]
    pub fn new(grid: Grid) -> Self {
        Self {
            mode: Mode::Idle,
            scan: Scan::default(),
            shield: Shield::default(),
            memory: Memory::default(),
            situations: Som::zeroed(grid),
            actions: ActionMap::new(
                grid,
                [[crate::fixed::Weight::ZERO; SENSORS]; NEURONS],
                [[crate::fixed::Weight::ZERO; 2]; NEURONS],
            ),
            learnt: false,
            generator: Xoshiro128PlusPlus::seed_from_u64(0),
            pending: None,
            motion_id: 0,
            dither: Dither::default(),
            course: Displacement::ZERO,
            inhibited: [0; NEURONS],
        }
    }

    /// What the robot is doing.
    #[must_use]
    pub const fn mode(&self) -> &Mode<SENSORS> {
        &self.mode
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

    /// A uniform number below `bound`; 0 for a bound of 0.
    fn below(&mut self, bound: u32) -> u32 {
        ((u64::from(self.generator.next_u32()) * u64::from(bound)) >> 32) as u32
    }
}

/// Takes one event that happened at `at` and says what to do. Total work is bounded: the dearest event is the echo that
/// completes a ring while seeking (one decision and one step of learning of both maps), or a tick while learning.
#[must_use]
pub fn handle<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>(
    config: &Config<SENSORS>,
    state: &mut State<SENSORS, NEURONS, SAMPLES>,
    at: Millis,
    event: Event<SENSORS>,
) -> Outputs<SENSORS> {
    match event {
        Event::Echo { sensor, range } => {
            state.echo(config, usize::from(sensor), Echo { range, at })
        }
        Event::Odometry {
            motion,
            moved,
            turned,
            progress,
        } => {
            state.odometry(motion, moved, turned, progress);
            Outputs::NONE
        }
        Event::Command(command) => state.command(config, command),
        Event::Tick => state.tick(config),
    }
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    fn echo(&mut self, config: &Config<SENSORS>, sensor: usize, echo: Echo) -> Outputs<SENSORS> {
        self.scan.hear(sensor, echo);
        self.shield.hear(config, sensor, echo);
        match self.pending {
            Some(pending) if !pending.ended => self.guard(config, sensor, echo.at),
            _ if self.scan.is_complete(config.believed) => self.decide(config, echo.at),
            _ => Outputs::NONE,
        }
    }

    /// Shortens the motion under way where the newest echo asks for it.
    fn guard(&mut self, config: &Config<SENSORS>, sensor: usize, now: Millis) -> Outputs<SENSORS> {
        let Some(pending) = &mut self.pending else {
            return Outputs::NONE;
        };
        let left = pending.remaining.length_mm();
        let heard = Mask::NONE.with(sensor);
        let allowed = self.shield.allow_by(config, pending.remaining, now, heard);
        if allowed.distance_mm >= left {
            return Outputs::NONE;
        }
        pending.remaining = pending.remaining.with_length(allowed.distance_mm);
        pending.speed_mm_s = allowed.speed_mm_s.min(pending.speed_mm_s);
        Outputs {
            motion: Some(Motion {
                id: self.motion_id,
                displacement: pending.remaining,
                speed_mm_s: pending.speed_mm_s,
            }),
            ..Outputs::NONE
        }
    }

    fn odometry(&mut self, motion: u16, moved: Displacement, turned: Bearing, progress: Progress) {
        self.shield.moved(moved, turned);
        let back = (turned != Bearing::ZERO).then(|| Bearing::ZERO.minus(turned).direction());
        let into_present = |d: Displacement| back.map_or(d, |back| d.rotated(back));
        self.course = into_present(self.course);
        let Some(pending) = &mut self.pending else {
            return;
        };
        let since_decision = if pending.turned == Bearing::ZERO {
            moved
        } else {
            moved.rotated(pending.turned.direction())
        };
        pending.executed = pending.executed.plus(since_decision);
        pending.remaining = into_present(pending.remaining.minus(moved));
        pending.turned = pending.turned.plus(turned);
        if motion == self.motion_id && progress != Progress::Moving && !pending.ended {
            pending.ended = true;
            self.scan.renew();
        }
    }

    fn command(&mut self, config: &Config<SENSORS>, command: Command<SENSORS>) -> Outputs<SENSORS> {
        let most = u16::try_from(SAMPLES).unwrap_or(u16::MAX);
        let mode = match command {
            Command::Explore { moves, .. } if moves == 0 || moves > most => {
                return refused(Refusal::Moves { most });
            }
            Command::Learn if self.memory.samples().is_empty() => {
                return refused(Refusal::NoSamples);
            }
            Command::Seek(_) if !self.learnt => return refused(Refusal::NotLearnt),
            Command::Explore { moves, seed } => {
                self.generator = Xoshiro128PlusPlus::seed_from_u64(seed);
                self.memory.clear();
                Mode::Explore { left: moves }
            }
            Command::Learn => {
                self.start_maps(config);
                Mode::Learn { step: 0 }
            }
            Command::Seek(goal) => Mode::Seek { goal },
            Command::Stop => Mode::Stopped(StopReason::Commanded),
        };
        self.enter(mode)
    }

    /// Changes the mode. A motion under way is stopped, except from one goal to the next.
    fn enter(&mut self, mode: Mode<SENSORS>) -> Outputs<SENSORS> {
        let goes_on = matches!((&self.mode, &mode), (Mode::Seek { .. }, Mode::Seek { .. }));
        self.mode = mode;
        let moving = self.pending.is_some_and(|pending| !pending.ended);
        let motion = (moving && !goes_on).then(|| {
            self.motion_id = self.motion_id.wrapping_add(1);
            Motion {
                id: self.motion_id,
                displacement: Displacement::ZERO,
                speed_mm_s: 0,
            }
        });
        if !goes_on {
            self.pending = None;
            self.scan.renew();
        }
        Outputs {
            motion,
            mode_changed: true,
            ..Outputs::NONE
        }
    }

    fn tick(&mut self, config: &Config<SENSORS>) -> Outputs<SENSORS> {
        let Mode::Learn { step } = self.mode else {
            return Outputs::NONE;
        };
        let step = self.learn_slice(config, step);
        if step < self.learning_steps(config) {
            self.mode = Mode::Learn { step };
            return Outputs::NONE;
        }
        self.learnt = true;
        self.enter(Mode::Idle)
    }

    /// A ring is complete and the base stands.
    fn decide(&mut self, config: &Config<SENSORS>, now: Millis) -> Outputs<SENSORS> {
        let situation = config.encoding.situation(&self.scan);
        let pending = self.pending.take();
        match self.mode {
            Mode::Explore { left } => self.explore(config, now, situation, pending, left),
            Mode::Seek { goal } => self.seek(config, now, situation, pending, &goal),
            Mode::Idle | Mode::Learn { .. } | Mode::Stopped(_) => Outputs::NONE,
        }
    }

    fn explore(
        &mut self,
        config: &Config<SENSORS>,
        now: Millis,
        situation: Situation<SENSORS>,
        pending: Option<Pending<SENSORS>>,
        left: u16,
    ) -> Outputs<SENSORS> {
        let mut left = left;
        if let Some(pending) = pending {
            // The command was refused unless the memory holds all the samples.
            let _ = self.memory.keep(Sample {
                before: memory::to_bytes(&pending.before),
                after: memory::to_bytes(&situation),
                mask: config.believed,
                commanded: pending.commanded,
                executed: pending.executed,
            });
            left = left.saturating_sub(1);
        }
        if left == 0 {
            return self.enter(Mode::Idle);
        }
        self.mode = Mode::Explore { left };
        let wanted = self.random_move(config, now);
        self.go(config, now, situation, wanted, None)
    }

    /// A random displacement; drawn anew a few times while the shield would take more than half of it.
    fn random_move(&mut self, config: &Config<SENSORS>, now: Millis) -> Displacement {
        let (shortest, longest) = (config.exploration.shortest_mm, config.robot.step_mm);
        let span = u32::from(longest.saturating_sub(shortest));
        let mut wanted = Displacement::ZERO;
        for _ in 0..config.exploration.draws.max(1) {
            let bearing = Bearing::from_turns((self.generator.next_u32() >> 16) as u16);
            let length = u32::from(shortest).saturating_add(self.below(span.saturating_add(1)));
            wanted = Displacement::along(bearing, length as i32);
            let allowed = self.shield.allow(config, wanted, now);
            if allowed.distance_mm >= wanted.length_mm() / 2 {
                break;
            }
        }
        wanted
    }

    fn seek(
        &mut self,
        config: &Config<SENSORS>,
        now: Millis,
        situation: Situation<SENSORS>,
        pending: Option<Pending<SENSORS>>,
        goal: &Goal<SENSORS>,
    ) -> Outputs<SENSORS> {
        for left in &mut self.inhibited {
            *left = left.saturating_sub(1);
        }
        let cut = pending.is_some_and(|pending| pending.was_cut());
        if let Some(pending) = pending {
            self.learn_online(config, &pending, &situation);
            self.inhibit(config, &pending);
        }
        let mut allowed = Mask::ALL;
        for (neuron, _) in self
            .inhibited
            .iter()
            .enumerate()
            .filter(|(_, left)| **left > 0)
        {
            allowed = allowed.without(neuron);
        }
        let planner = Planner {
            config,
            situations: &self.situations,
            actions: &self.actions,
            allowed,
            course: self.course,
            cut,
        };
        let plan = planner.plan(&situation, goal);
        self.go(config, now, situation, plan.action, Some(plan))
    }

    /// A move cut below half inhibits the neuron that asked for it.
    fn inhibit(&mut self, config: &Config<SENSORS>, pending: &Pending<SENSORS>) {
        let asked = pending.action_neuron.filter(|_| pending.was_cut());
        let neuron = asked.map(usize::from);
        if let Some(left) = neuron.and_then(|neuron| self.inhibited.get_mut(neuron)) {
            *left = config.planning.inhibition;
        }
    }

    fn learn_online(
        &mut self,
        config: &Config<SENSORS>,
        pending: &Pending<SENSORS>,
        after: &Situation<SENSORS>,
    ) {
        let Some(online) = config.online else {
            return;
        };
        let taught = match config.learning.taught {
            Taught::Commanded => pending.commanded,
            Taught::Executed => pending.executed,
        };
        let effect = Effect {
            change: difference(after, &pending.before),
            action: config.action_code.encode(taught, config.robot.step_mm),
            mask: config.believed,
        };
        let pull = |rate| Pull::new(Neighbourhood::Direct, rate, online.share_q16);
        self.dither = self.dither.next();
        let winner = match pending.action_neuron {
            Some(neuron) if online.blame_recalled => usize::from(neuron),
            _ => self
                .actions
                .winner(&effect, config.learning.action_weight_q8),
        };
        self.actions
            .learn(winner, &effect, &pull(online.action_rate_q16), self.dither);
        let winner = self.situations.winner(after, config.believed);
        self.situations.learn(
            winner,
            after,
            config.believed,
            &pull(online.situation_rate_q16),
            self.dither,
        );
    }

    /// Sends the base on its way as far as the shield allows.
    fn go(
        &mut self,
        config: &Config<SENSORS>,
        now: Millis,
        situation: Situation<SENSORS>,
        wanted: Displacement,
        plan: Option<Plan<SENSORS>>,
    ) -> Outputs<SENSORS> {
        let limit = self.shield.allow(config, wanted, now);
        let allowed = if limit.distance_mm >= wanted.length_mm() {
            wanted
        } else {
            wanted.with_length(limit.distance_mm)
        };
        self.motion_id = self.motion_id.wrapping_add(1);
        self.course = wanted;
        self.scan.renew();
        self.pending = Some(Pending {
            before: situation,
            commanded: wanted,
            executed: Displacement::ZERO,
            remaining: allowed,
            turned: Bearing::ZERO,
            speed_mm_s: limit.speed_mm_s,
            action_neuron: plan.and_then(|plan| plan.recalled.then_some(plan.action_neuron)),
            ended: false,
        });
        Outputs {
            motion: Some(Motion {
                id: self.motion_id,
                displacement: allowed,
                speed_mm_s: limit.speed_mm_s,
            }),
            decision: Some(Decision {
                situation,
                plan,
                wanted,
                allowed,
                at_goal: plan.is_some_and(|plan| plan.at_goal),
            }),
            ..Outputs::NONE
        }
    }
}

fn refused<const SENSORS: usize>(refusal: Refusal) -> Outputs<SENSORS> {
    Outputs {
        refusal: Some(refusal),
        ..Outputs::NONE
    }
}

#[cfg(test)]
mod tests;
