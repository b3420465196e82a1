//! A Nomad 200 as a source, real or simulated, over its own line, with a mind here or elsewhere.
//!
//! Its time passes by itself, its surroundings are what its ring has heard.

mod orders;
mod parts;

use super::goal::Pursued;
use super::heard::Heard;
use super::order::{Done, Order};
use super::seen::Knowing;
use super::snapshot::{Part, Scene, Snapshot};
use super::source::{Abilities, Refused, Source, Stepped};
use super::trail::{Trail, mark};
use amp::config::Config;
use amp::controller::Decision;
use amp::scan::Situation;
use arena::world::{Point, Pose};
use nomad200::Host;
use nomad200::bridge::{
    Activity, BridgeError, BridgeSession, POLL_INTERVAL, ResultKind, WorkerResult,
};
use remote::log::{LogOutput, LoggedController, SharedLog};
use sim::behavior::Behavior;
use sim::episode::StepFlags;
use sim::error::EpisodeError;
use sim::pilot::SimState;
use std::sync::Arc;
use std::time::Duration;

/// What is watched, and how it is to begin.
#[derive(Debug, Clone)]
pub struct NomadStart {
    /// Where the robot is.
    pub name: String,
    /// The open choices of its mind.
    pub config: Config<16>,
    /// The same with shield and learning while behaving as they are when switched on.
    pub whole: Config<16>,
    /// Name of their preset.
    pub preset: String,
    /// What is pursued at first.
    pub behavior: Behavior,
    /// Random moves of an exploration.
    pub explore_moves: u16,
    /// Seed of the random moves.
    pub seed: u64,
    /// Sonars asked for at once.
    pub sonars_at_once: u32,
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

/// A Nomad that is watched and steered.
pub struct WatchedNomad {
    start: NomadStart,
    /// As it is now.
    config: Config<16>,
    session: BridgeSession,
    log: Option<SharedLog<LogOutput>>,
    mind: MindSeen,
    doing: Doing,
    interrupted: Doing,
    failure: Option<String>,
    note: Option<String>,
    goal: Pursued,
    nest: Option<(Situation<16>, Point)>,
    decision: Option<Decision<16>>,
    before: Option<Situation<16>>,
    decided_at: Pose,
    /// When each sonar was heard last, by the robot's clock.
    heard_ms: [Option<u32>; 16],
    explorations: u64,
    explored: [u32; 2],
    /// Of those towards goals: all, touched, shielded, with the goal held.
    steps: [u32; 4],
    distance_m: f64,
    open: Option<StepFlags>,
    trail: Trail,
    heard: Heard,
    bounds: [Point; 2],
    time_s: f64,
    shown: Shown,
}

/// What is known of the mind without asking it.
struct MindSeen {
    name: String,
    here: bool,
    known: Option<Box<SimState>>,
    /// It knows more by now; it has been asked.
    stale: bool,
    asked: bool,
}

/// Parts that were made already, and how often anything has changed.
#[derive(Default)]
struct Shown {
    revision: u64,
    scene: Option<Arc<Part<Scene>>>,
    knowing: Knowing,
}

impl WatchedNomad {
    /// Takes the session of a robot: it stands. Everything goes into the mind's log, if it has one.
    ///
    /// # Errors
    /// When the robot does not answer.
    pub fn new(start: NomadStart, host: Host, mind: LoggedController) -> Result<Self, BridgeError> {
        let seen = MindSeen {
            name: mind.inner().name(),
            here: mind.inner().is_local(),
            known: None,
            stale: true,
            asked: false,
        };
        let log = mind.log().cloned();
        let session = BridgeSession::open(host, mind, &start.config, start.sonars_at_once)?;
        let place = session.pose().position;
        Ok(Self {
            config: start.config.clone(),
            goal: Pursued::behavior(&start.behavior),
            decided_at: session.pose(),
            start,
            session,
            log,
            mind: seen,
            doing: Doing::Idle,
            interrupted: Doing::Idle,
            failure: None,
            note: None,
            nest: None,
            decision: None,
            before: None,
            heard_ms: [None; 16],
            explorations: 0,
            explored: [0; 2],
            steps: [0; 4],
            distance_m: 0.0,
            open: None,
            trail: Trail::latest(),
            heard: Heard::new(),
            bounds: around(place, [place; 2]),
            time_s: 0.0,
            shown: Shown::default(),
        })
    }

    fn turn(&mut self) -> Result<bool, BridgeError> {
        let turn = self.session.update()?;
        if let (true, Some(open)) = (turn.touched, &mut self.open) {
            open.touched = true;
        }
        if self.doing == Doing::Seek {
            self.distance_m += turn.way_m;
        }
        self.look_around();
        let mut whole = false;
        if let Some(thought) = turn.result {
            whole = thought.outputs.decision.is_some() || thought.outputs.mode_changed;
            self.conclude(thought)?;
        }
        self.session.deliver_events(match self.doing {
            Doing::Explore | Doing::Seek => Activity::Moving,
            Doing::Learn => Activity::Learning,
            Doing::Idle | Doing::Stopped => Activity::Rest,
        })?;
        self.ask_mind();
        Ok(whole)
    }

    /// Notes where the robot is and where its sonars heard something.
    fn look_around(&mut self) {
        for (sensor, range_m) in self.session.ranges_m().into_iter().enumerate() {
            let (echo_origin, at_ms) = self.session.echo_origin(sensor);
            let new = self.heard_ms[sensor].replace(at_ms) != Some(at_ms);
            if let (true, Some(range_m)) = (new, range_m) {
                self.heard.hear(echo_origin, sensor, range_m);
            }
        }
        let bounds = around(self.session.pose().position, self.bounds);
        if bounds != self.bounds {
            (self.bounds, self.shown.scene) = (bounds, None);
        }
    }

    fn conclude(&mut self, thought: WorkerResult) -> Result<(), BridgeError> {
        let outputs = &thought.outputs;
        if outputs.decision.is_some() || outputs.mode_changed {
            self.close();
        } else if outputs.motion.is_some()
            && let Some(open) = &mut self.open
        {
            open.shielded = true;
        }
        if let Some(refusal) = outputs.refusal {
            self.note = Some(format!("the mind refused: {refusal:?}"));
            self.doing = Doing::Idle;
        }
        let happened = thought.kind == ResultKind::Events;
        match self.doing {
            Doing::Explore | Doing::Seek if outputs.stopped.is_some() && happened => {
                let why = outputs.stopped.map(EpisodeError::Stopped);
                self.note = why.map(|why| why.to_string());
                self.interrupted = self.doing;
                self.rest(Doing::Stopped);
            }
            Doing::Explore if outputs.mode_changed && happened => self.rest(Doing::Idle),
            Doing::Learn if thought.kind == ResultKind::Learning => {
                self.session.discard_events();
                self.rest(Doing::Idle);
            }
            _ => {}
        }
        if let Some(decision) = &outputs.decision {
            self.decide(decision);
        }
        if outputs.decision.is_some() && self.doing == Doing::Seek {
            self.go_on()?;
        }
        if let Some(known) = thought.state {
            self.mind.known = Some(known);
            self.mind.asked = false;
            self.shown.knowing.forget_maps();
        }
        Ok(())
    }

    fn rest(&mut self, doing: Doing) {
        self.doing = doing;
        self.mind.stale = true;
    }

    /// Asks what the mind knows; one elsewhere only while nobody waits for it.
    fn ask_mind(&mut self) {
        let moves = matches!(self.doing, Doing::Explore | Doing::Learn | Doing::Seek);
        let may = self.mind.here && self.doing != Doing::Learn || !moves;
        if may && self.mind.stale && !self.mind.asked {
            (self.mind.stale, self.mind.asked) = (false, true);
            self.session.request_state();
        }
    }

    fn decide(&mut self, decision: &Decision<16>) {
        let pose = self.session.pose();
        if self.nest.is_none() {
            self.nest = Some((decision.situation, pose.position));
        }
        self.before = self.decision.map(|before| before.situation);
        (self.decision, self.decided_at) = (Some(*decision), pose);
        self.mind.stale = true;
        self.open = Some(StepFlags {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
            touched_by: false,
        });
    }

    /// The step under way has ended.
    fn close(&mut self) {
        let Some(stride) = self.open.take() else {
            return;
        };
        let seeks = self.doing == Doing::Seek;
        if seeks {
            let counted = [true, stride.touched, stride.shielded, stride.at_goal];
            for (count, add) in self.steps.iter_mut().zip(counted) {
                *count += u32::from(add);
            }
        } else {
            self.explored[0] += 1;
            self.explored[1] += u32::from(stride.touched);
        }
        let neuron = self.decision.and_then(|decision| decision.plan);
        let neuron = neuron.map(|plan| usize::from(plan.current_neuron));
        let ranges_m = self.session.ranges_m();
        let nearest = ranges_m.iter().flatten().copied().reduce(f64::min);
        let (time_s, place) = (self.session.time_s(), self.session.pose().position);
        self.trail
            .push(mark(time_s, place, seeks, stride, neuron, nearest));
    }

    /// Goes on to the next part of a chain when the present one is reached; after the last it stands.
    fn go_on(&mut self) -> Result<(), BridgeError> {
        let [steps, _, _, held] = self.steps;
        match self.goal.go_on(steps, held) {
            None => {}
            Some(true) => self.pursue(),
            Some(false) => {
                let note = format!("{}: the last goal is reached", self.goal.name());
                self.stop()?;
                self.note = Some(note);
            }
        }
        Ok(())
    }

    fn fail(&mut self, trouble: &BridgeError) {
        self.session
            .finish(matches!(trouble, BridgeError::Controller(_)));
        let which = match trouble {
            BridgeError::Robot(_) => &self.start.name,
            _ => &self.mind.name,
        };
        self.failure = Some(format!("{which}: {trouble}; the robot was stopped"));
    }

    fn knows_maps(&self) -> bool {
        let known = self.mind.known.as_deref();
        known.is_some_and(SimState::has_learned)
    }
}

/// Bounds that hold a place and some meters around it; they grow by whole meters.
fn around(place: Point, [low, high]: [Point; 2]) -> [Point; 2] {
    const ROOM_M: f64 = 2.0;
    let down = |m: f64| libm::floor(m - ROOM_M);
    let up = |m: f64| libm::ceil(m + ROOM_M);
    [
        Point::new(low.x.min(down(place.x)), low.y.min(down(place.y))),
        Point::new(high.x.max(up(place.x)), high.y.max(up(place.y))),
    ]
}

impl Source for WatchedNomad {
    fn abilities(&self) -> Abilities {
        Abilities {
            drive: true,
            configure: true,
            save: true,
            ..Abilities::default()
        }
    }

    fn step(&mut self) -> Stepped {
        if self.failure.is_some() {
            return Stepped::Standing;
        }
        std::thread::sleep(POLL_INTERVAL);
        let whole = match self.turn() {
            Ok(whole) => whole,
            Err(trouble) => {
                self.fail(&trouble);
                return Stepped::Standing;
            }
        };
        let before_s = std::mem::replace(&mut self.time_s, self.session.time_s());
        Stepped::Took {
            took_s: self.time_s - before_s,
            whole,
        }
    }

    fn carry_out(&mut self, order: &Order) -> Result<Done, Refused> {
        if let Some(why) = &self.failure {
            return Err(why.clone().into());
        }
        self.obey(order)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.parts()
    }

    fn steering_lost(&mut self, silence: Duration) {
        if self.failure.is_some() || !matches!(self.doing, Doing::Explore | Doing::Seek) {
            return;
        }
        match self.stop() {
            Ok(()) => {
                let seconds = silence.as_secs_f64();
                self.note = Some(format!(
                    "It stopped: no page has steered it for {seconds} s"
                ));
            }
            Err(trouble) => self.fail(&trouble),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        if self.failure.is_none() {
            self.session.finish(false);
        }
        self.log.as_ref().map_or(Ok(()), SharedLog::finish)
    }
}
