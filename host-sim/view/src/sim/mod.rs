//! The simulator as a source: a body in a world that can be changed, and a mind here or elsewhere.
//!
//! Events come to the mind as in an [episode](sim::episode): with the same seed, exploring, learning and seeking one
//! after the other bring the same decisions. Time passes only while the robot does something.

mod orders;
mod parts;

use super::goal::Pursued;
use super::order::{Done, Order};
use super::seen::Knowing;
use super::snapshot::{Part, Scene, Snapshot};
use super::source::{Abilities, Refused, Source, Stepped};
use super::trail::{Trail, mark};
use amp::config::Config;
use amp::controller::{Command, Decision, Event};
use amp::scan::Situation;
use arena::robot::TurretMode;
use arena::world::{Point, Pose, World};
use files::error::BadInput;
use remote::link::{AnyController, ControllerPlace};
use remote::log::{LogOutput, LogWriter, LoggedController, SetupRecord, SharedLog, WorldLogger};
use sim::episode::{
    Body, Metrics, Observer as _, Seeds, Setup, StepFlags, StepResult, milliseconds,
};
use sim::error::EpisodeError;
use sim::pilot::Pilot as _;
use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

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

impl Start {
    /// What a log says about it.
    fn record(&self) -> SetupRecord {
        SetupRecord::of(&self.named, &self.setup)
    }
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
    mind: LoggedController,
    /// Writes down where the robot really is.
    watcher: Option<WorldLogger<LogOutput>>,
    doing: Doing,
    /// What a stop interrupted.
    interrupted: Doing,
    /// Why nothing can go on.
    failure: Option<String>,
    /// What there is to say besides.
    note: Option<String>,
    goal: Pursued,
    /// What was perceived before the first move, and where.
    nest: Option<(Situation<16>, Point)>,
    decision: Option<Decision<16>>,
    /// The situation before the latest one.
    before: Option<Situation<16>>,
    /// What the ring heard, and where it was then.
    ranges_m: [Option<f64>; 16],
    heard_at: Pose,
    learned: bool,
    learning: u32,
    touched: bool,
    step_s: f64,
    last_decision_s: f64,
    explorations: u64,
    explored: Metrics,
    seeking: Metrics,
    open: Option<StepFlags>,
    trail: Trail,
    shown: Shown,
}

/// Parts that were made already, and how often anything has changed.
#[derive(Default)]
struct Shown {
    revision: u64,
    scene: Option<Arc<Part<Scene>>>,
    knowing: Knowing,
}

impl Simulator {
    /// A robot at its world's start, with a mind that knows nothing; everything goes into a new file `log`, if one is named.
    ///
    /// # Errors
    /// When the mind cannot be reached, or the file cannot be written.
    pub fn new(start: Start, place: ControllerPlace, log: Option<&Path>) -> Result<Self, BadInput> {
        let mind = AnyController::new(&start.setup.config, place)?;
        let log = log.map(LogWriter::create).transpose()?;
        let mut mind = LoggedController::new(mind, log.map(SharedLog::new));
        mind.begin(&start.record(), Some(&start.world));
        Ok(Self::with_mind(start, mind))
    }

    fn with_mind(start: Start, mind: LoggedController) -> Self {
        let (setup, world) = (&start.setup, &start.world);
        let noise = Seeds::of(setup.seed).noise;
        let world = Cow::Owned(world.clone());
        let body = Body::within(world, setup.sonar, setup.turret, noise).with_faults(&setup.faults);
        let goal = Pursued::behavior(&setup.behavior);
        let ranges_m = body.look();
        let watcher = mind.log().cloned().map(WorldLogger::new);
        Self {
            config: setup.config.clone(),
            mind,
            watcher,
            doing: Doing::Idle,
            interrupted: Doing::Idle,
            failure: None,
            note: None,
            goal,
            nest: None,
            decision: None,
            before: None,
            ranges_m,
            heard_at: body.pose(),
            learned: false,
            learning: 0,
            touched: false,
            step_s: 0.0,
            last_decision_s: 0.0,
            explorations: 0,
            explored: Metrics::new(&start.world),
            seeking: Metrics::new(&start.world),
            open: None,
            trail: Trail::latest(),
            shown: Shown::default(),
            body,
            start,
        }
    }

    fn command(&mut self, command: Command<16>) -> Result<(), Refused> {
        let outputs = self.mind.handle(self.body.now(), Event::Command(command));
        let refused = outputs.refusal.map(EpisodeError::Refused);
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
            (self.doing, self.learned) = (Doing::Idle, true);
        }
        self.shown.knowing.forget_maps();
        self.mind.pilot().invalidate_cache(whole);
        Stepped::Took { took_s, whole }
    }

    fn drive(&mut self) -> Stepped {
        let began_s = self.body.time_s();
        let happened = self.body.advance(&mut self.mind);
        if let Some(watcher) = &mut self.watcher {
            let at = milliseconds(happened.time_s);
            watcher.on_step(at, &happened, &self.body);
        }
        self.check_mind();
        (self.ranges_m, self.heard_at) = (*self.body.ranges_m(), happened.pose);
        self.step_s = self.body.time_s() - began_s;
        let whole = happened.decision.is_some() || happened.mode_changed;
        if whole {
            self.close();
            self.last_decision_s = self.body.time_s();
        }
        if let Some(reason) = happened.stopped {
            self.interrupted = std::mem::replace(&mut self.doing, Doing::Stopped);
            self.note = Some(EpisodeError::Stopped(reason).to_string());
        } else if happened.mode_changed && self.doing == Doing::Explore {
            self.doing = Doing::Idle;
            self.mind.pilot().invalidate_cache(true);
        }
        if let Some(decision) = &happened.decision {
            self.open(decision, &happened);
        }
        self.follow(&happened);
        if whole {
            self.go_on();
        }
        let silent = self.body.time_s() - self.last_decision_s > PATIENCE * self.body.ring_s();
        if silent && matches!(self.doing, Doing::Explore | Doing::Seek) {
            self.fail(EpisodeError::Silent.to_string());
        }
        Stepped::Took {
            took_s: self.step_s,
            whole,
        }
    }

    fn open(&mut self, decision: &Decision<16>, happened: &StepResult) {
        if self.nest.is_none() {
            self.nest = Some((decision.situation, happened.pose.position));
        }
        self.before = self.decision.map(|before| before.situation);
        self.decision = Some(*decision);
        self.touched = false;
        self.open = Some(StepFlags {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
            touched_by: false,
        });
        self.mind.pilot().invalidate_cache(false);
        if self.doing == Doing::Seek && self.config.online.is_some() {
            self.shown.knowing.forget_maps();
        }
    }

    /// Goes on to the next part of a chain when the present one is reached; after the last it stands.
    fn go_on(&mut self) {
        if self.doing != Doing::Seek || self.failure.is_some() {
            return;
        }
        let (steps, held) = (self.seeking.steps, self.seeking.goal_steps);
        let done = match self.goal.go_on(steps, held) {
            None => return,
            Some(true) => self.pursue(),
            Some(false) => {
                let note = format!("{}: the last goal is reached", self.goal.name());
                self.stop().map(|()| self.note = Some(note))
            }
        };
        if let Err(refused) = done {
            self.fail(refused.0);
        }
    }

    fn tally(&mut self) -> &mut Metrics {
        match self.doing {
            Doing::Explore => &mut self.explored,
            _ => &mut self.seeking,
        }
    }

    fn follow(&mut self, happened: &StepResult) {
        let Some(moved) = &happened.moved else { return };
        self.tally()
            .moved(moved.from, moved.to, moved.traveled_m, moved.clearance_m);
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
        let time_s = self.body.time_s();
        let mark = mark(time_s, place, seeks, stride, neuron, nearest);
        self.trail.push(mark);
    }

    /// Whether the robot does something or still rolls.
    fn is_busy(&self) -> bool {
        let driven = matches!(self.doing, Doing::Explore | Doing::Seek);
        self.failure.is_none() && (driven || self.body.is_moving())
    }
}

impl Source for Simulator {
    fn abilities(&self) -> Abilities {
        Abilities {
            drive: true,
            pace: true,
            carry: true,
            reset: true,
            configure: true,
            save: true,
            load: self.mind.inner().is_local(),
            ..Abilities::default()
        }
    }

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

    fn end(&mut self) -> Result<(), String> {
        self.mind.log().map_or(Ok(()), SharedLog::finish)
    }
}

#[cfg(test)]
mod tests;
