//! The simulator as a source: a body in a world that can be changed, and a mind here or elsewhere.
//!
//! Events come to the mind as in an [episode](crate::episode): with the same seed, exploring, learning and seeking one
//! after the other bring the same decisions. Time passes only while the robot does something.

mod goal;
mod mind;
mod orders;
mod parts;
mod trail;

use super::order::{Done, Order};
use super::snapshot::{Part, Scene, Snapshot};
use super::source::{Refused, Source, Stepped};
use crate::episode::{Body, Happened, Seeds, Setup, Stride, Tally};
use crate::error::BadInput;
use crate::pilot::Pilot as _;
use crate::robot::TurretMode;
use crate::world::{Point, Pose, World};
use amp::config::Config;
use amp::controller::{Command, Decision, Event};
use amp::scan::Situation;
use goal::Pursued;
use mind::AnyMind;
pub use mind::MindPlace;
use std::borrow::Cow;
use std::sync::Arc;
use trail::Trail;

/// Ticks of learning that are one step of the view, and how long it is made to seem, seconds.
const LEARNING: (u32, f64) = (50, 0.04);

/// Rings without a decision before the mind counts as silent.
const PATIENCE: f64 = 100.0;

/// What a simulation is made of.
#[derive(Debug, Clone)]
pub struct Start {
    /// The world.
    pub world: World,
    /// How the user named it.
    pub named: String,
    /// Everything else.
    pub setup: Setup,
    /// The configuration with shield and learning while behaving as they are when switched on.
    pub whole: Config<16>,
    /// What a new start may be made with instead.
    pub presets: Vec<PresetChoice>,
}

/// A preset of the menu.
#[derive(Debug, Clone)]
pub struct PresetChoice {
    /// Its name.
    pub name: &'static str,
    /// Its open choices.
    pub config: Config<16>,
    /// What its ring does while the base steers.
    pub turret: TurretMode,
}

/// What the robot does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Doing {
    Idle,
    Explore,
    Learn,
    Seek,
    Stopped,
}

/// A simulated robot.
pub struct Simulator {
    start: Start,
    /// As it is now.
    config: Config<16>,
    body: Body<'static>,
    mind: AnyMind,
    doing: Doing,
    /// What a stop interrupted.
    interrupted: Doing,
    /// Why nothing can go on.
    failure: Option<String>,
    goal: Pursued,
    /// What was perceived before the first move, and where.
    nest: Option<(Situation<16>, Point)>,
    decision: Option<Decision<16>>,
    /// The situation before the latest one.
    before: Option<Situation<16>>,
    /// What the ring heard, and where it was then.
    ranges_m: [Option<f64>; 16],
    heard_at: Pose,
    learnt: bool,
    learning: u32,
    touched: bool,
    step_s: f64,
    last_decision_s: f64,
    explorations: u64,
    explored: Tally,
    seeking: Tally,
    open: Option<Stride>,
    trail: Trail,
    shown: Shown,
}

/// Parts that were made already, and how often anything has changed.
#[derive(Default)]
struct Shown {
    revision: u64,
    scene: Option<Arc<Part<Scene>>>,
    maps: Option<Arc<Part<super::snapshot::Maps>>>,
    memory: Option<Arc<Part<Vec<super::snapshot::Row>>>>,
    samples: usize,
}

impl Simulator {
    /// A robot at its world's start, with a mind that knows nothing.
    ///
    /// # Errors
    /// When the mind cannot be reached.
    pub fn new(start: Start, place: MindPlace) -> Result<Self, BadInput> {
        let mind = AnyMind::new(&start.setup.config, place)?;
        Ok(Self::with_mind(start, mind))
    }

    fn with_mind(start: Start, mind: AnyMind) -> Self {
        let (setup, world) = (&start.setup, &start.world);
        let noise = Seeds::of(setup.seed).noise;
        let world = Cow::Owned(world.clone());
        let body = Body::within(world, setup.sonar, setup.turret, noise).with_faults(&setup.faults);
        let goal = Pursued::behavior(&setup.behavior);
        let ranges_m = body.look();
        Self {
            config: setup.config.clone(),
            mind,
            doing: Doing::Idle,
            interrupted: Doing::Idle,
            failure: None,
            goal,
            nest: None,
            decision: None,
            before: None,
            ranges_m,
            heard_at: body.pose(),
            learnt: false,
            learning: 0,
            touched: false,
            step_s: 0.0,
            last_decision_s: 0.0,
            explorations: 0,
            explored: Tally::new(&start.world),
            seeking: Tally::new(&start.world),
            open: None,
            trail: Trail::default(),
            shown: Shown::default(),
            body,
            start,
        }
    }

    fn command(&mut self, command: Command<16>) -> Result<(), Refused> {
        let outputs = self.mind.handle(self.body.now(), Event::Command(command));
        let refused = outputs.refusal.map(crate::episode::Failure::Refused);
        self.check_mind();
        match refused {
            Some(why) => Err(why.into()),
            None => self.failure.clone().map_or(Ok(()), |why| Err(why.into())),
        }
    }

    /// Notices that the mind cannot go on.
    fn check_mind(&mut self) {
        if let Some(failure) = self.mind.failure() {
            self.fail(failure.to_string());
        }
    }

    fn fail(&mut self, why: String) {
        self.body.halt();
        self.failure = Some(why);
    }

    fn learn(&mut self) -> Stepped {
        let (ticks, took_s) = LEARNING;
        let now = self.body.now();
        let mut whole = false;
        for _ in 0..ticks {
            self.learning += 1;
            whole = self.mind.handle(now, Event::Tick).mode_changed;
            self.check_mind();
            if whole || self.failure.is_some() {
                break;
            }
        }
        if whole {
            (self.doing, self.learnt) = (Doing::Idle, true);
        }
        self.shown.maps = None;
        self.mind.forget_known(whole);
        Stepped::Took { took_s, whole }
    }

    fn drive(&mut self) -> Stepped {
        let began_s = self.body.time_s();
        let happened = self.body.advance(&mut self.mind);
        self.config.believed = self.mind.config().believed;
        self.check_mind();
        (self.ranges_m, self.heard_at) = (happened.ranges_m, happened.pose);
        self.step_s = self.body.time_s() - began_s;
        let whole = happened.decision.is_some() || happened.mode_changed;
        if whole {
            self.close();
            self.last_decision_s = self.body.time_s();
        }
        if happened.mode_changed && self.doing == Doing::Explore {
            self.doing = Doing::Idle;
            self.mind.forget_known(true);
        }
        if let Some(decision) = &happened.decision {
            self.open(decision, &happened);
        }
        self.follow(&happened);
        let silent = self.body.time_s() - self.last_decision_s > PATIENCE * self.body.ring_s();
        if silent && matches!(self.doing, Doing::Explore | Doing::Seek) {
            self.fail(crate::episode::Failure::Silent.to_string());
        }
        Stepped::Took {
            took_s: self.step_s,
            whole,
        }
    }

    fn open(&mut self, decision: &Decision<16>, happened: &Happened) {
        if self.nest.is_none() {
            self.nest = Some((decision.situation, happened.pose.position));
        }
        self.before = self.decision.map(|before| before.situation);
        self.decision = Some(*decision);
        self.touched = false;
        self.open = Some(Stride {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
        });
        self.mind.forget_known(false);
        if self.doing == Doing::Seek && self.config.online.is_some() {
            self.shown.maps = None;
        }
    }

    fn tally(&mut self) -> &mut Tally {
        match self.doing {
            Doing::Explore => &mut self.explored,
            _ => &mut self.seeking,
        }
    }

    fn follow(&mut self, happened: &Happened) {
        let Some(moved) = &happened.moved else { return };
        self.tally()
            .moved(moved.from, moved.to, moved.travelled_m, moved.clearance_m);
        self.touched |= moved.touched;
        if let Some(open) = &mut self.open {
            open.touched |= moved.touched;
            open.shielded |= happened.shortened;
        }
    }

    /// The step under way has ended.
    fn close(&mut self) {
        let Some(stride) = self.open.take() else {
            return;
        };
        self.tally().step(stride);
        let neuron = self.decision.and_then(|decision| decision.plan);
        let neuron = neuron.map(|plan| usize::from(plan.current_neuron));
        let nearest = self.ranges_m.iter().flatten().copied().reduce(f64::min);
        let place = self.body.pose().position;
        let seeks = self.doing == Doing::Seek;
        self.trail
            .mark(self.body.time_s(), place, seeks, stride, neuron, nearest);
    }

    /// Whether the robot does something or still rolls.
    fn is_busy(&self) -> bool {
        let driven = matches!(self.doing, Doing::Explore | Doing::Seek);
        self.failure.is_none() && (driven || self.body.is_moving())
    }
}

impl Source for Simulator {
    fn step(&mut self) -> Stepped {
        match self.doing {
            Doing::Learn if self.failure.is_none() => self.learn(),
            _ if self.is_busy() => self.drive(),
            _ => Stepped::Standing,
        }
    }

    fn carry_out(&mut self, order: &Order) -> Result<Done, Refused> {
        self.obey(order)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.parts()
    }
}

#[cfg(test)]
mod tests;
