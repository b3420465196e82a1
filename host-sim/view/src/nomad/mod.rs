//! Shows a real or simulated Nomad 200, driven by a local or remote controller.
//!
//! Its time is real time; its surroundings are the places of echoes.

mod commands;
mod parts;
mod source;

use super::dto::KnowledgeParts;
use super::echo_trail::EchoTrail;
use super::goal::ActiveGoal;
use super::history::{History, history_entry};
use super::snapshot::{SceneDto, SnapshotPart};
use amp::config::Config;
use amp::controller::Decision;
use amp::scan::Situation;
use arena::world::{Point, Pose};
use nomad200::Host;
use nomad200::bridge::{Activity, BridgeError, BridgeSession, ResultKind, WorkerResult};
use remote::log::{LogOutput, LoggedController, SharedLog};
use sim::behavior::Behavior;
use sim::episode::StepFlags;
use sim::error::EpisodeError;
use sim::pilot::SimState;
use std::sync::Arc;

/// What to watch, and the initial settings.
#[derive(Debug, Clone)]
pub struct NomadStart {
    /// Address of the robot.
    pub name: String,
    /// The controller's configuration.
    pub config: Config<16>,
    /// The same with shield and online learning switched on.
    pub whole: Config<16>,
    /// Name of the preset.
    pub preset: String,
    /// The first goal.
    pub behavior: Behavior,
    /// Random moves of an exploration.
    pub explore_moves: u16,
    /// Seed of the random moves.
    pub seed: u64,
    /// Sonars per poll.
    pub sonars_at_once: u32,
}

/// What the robot does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NomadActivity {
    Idle,
    Explore,
    Learn,
    Seek,
    Stopped,
}

/// A Nomad that is watched and steered.
pub struct WatchedNomad {
    start: NomadStart,
    /// The current configuration.
    config: Config<16>,
    session: BridgeSession,
    log: Option<SharedLog<LogOutput>>,
    controller: ControllerInfo,
    activity: NomadActivity,
    interrupted: NomadActivity,
    failure: Option<String>,
    note: Option<String>,
    goal: ActiveGoal,
    nest: Option<(Situation<16>, Point)>,
    decision: Option<Decision<16>>,
    before: Option<Situation<16>>,
    decided_at: Pose,
    /// Robot's time of each sonar's latest echo.
    echo_ms: [Option<u32>; 16],
    explorations: u64,
    explored: [u32; 2],
    /// Counts of steps with a goal: all, touched, shielded, at the goal.
    steps: [u32; 4],
    distance_m: f64,
    open: Option<StepFlags>,
    trail: History,
    echo_trail: EchoTrail,
    bounds: [Point; 2],
    time_s: f64,
    cache: NomadCache,
}

/// What is known of the controller without a query.
struct ControllerInfo {
    name: String,
    is_local: bool,
    known: Option<Box<SimState>>,
    /// The state has changed; it was requested.
    stale: bool,
    requested: bool,
}

impl ControllerInfo {
    fn of(controller: &LoggedController) -> Self {
        Self {
            name: controller.inner().name(),
            is_local: controller.inner().is_local(),
            known: None,
            stale: true,
            requested: false,
        }
    }
}

/// Parts of the latest snapshot, and the number of snapshots.
#[derive(Default)]
struct NomadCache {
    revision: u64,
    scene: Option<Arc<SnapshotPart<SceneDto>>>,
    knowledge: KnowledgeParts,
}

impl WatchedNomad {
    /// Opens the session of a robot; the robot stands.
    ///
    /// # Errors
    /// When the robot does not answer.
    pub fn new(
        start: NomadStart,
        host: Host,
        controller: LoggedController,
    ) -> Result<Self, BridgeError> {
        let info = ControllerInfo::of(&controller);
        let log = controller.log().cloned();
        let session = BridgeSession::open(host, controller, &start.config, start.sonars_at_once)?;
        let place = session.pose().position;
        Ok(Self {
            config: start.config.clone(),
            goal: ActiveGoal::behavior(&start.behavior),
            decided_at: session.pose(),
            start,
            session,
            log,
            controller: info,
            activity: NomadActivity::Idle,
            interrupted: NomadActivity::Idle,
            failure: None,
            note: None,
            nest: None,
            decision: None,
            before: None,
            echo_ms: [None; 16],
            explorations: 0,
            explored: [0; 2],
            steps: [0; 4],
            distance_m: 0.0,
            open: None,
            trail: History::latest(),
            echo_trail: EchoTrail::new(),
            bounds: around(place, [place; 2]),
            time_s: 0.0,
            cache: NomadCache::default(),
        })
    }

    fn update(&mut self) -> Result<bool, BridgeError> {
        let update = self.session.update()?;
        if let (true, Some(open)) = (update.touched, &mut self.open) {
            open.touched = true;
        }
        if self.activity == NomadActivity::Seek {
            self.distance_m += update.distance_m;
        }
        self.record_echoes();
        let mut whole = false;
        if let Some(result) = update.result {
            whole = result.outputs.decision.is_some() || result.outputs.mode_changed;
            self.handle_result(result)?;
        }
        self.session.deliver_events(match self.activity {
            NomadActivity::Explore | NomadActivity::Seek => Activity::Moving,
            NomadActivity::Learn => Activity::Learning,
            NomadActivity::Idle | NomadActivity::Stopped => Activity::Rest,
        })?;
        self.request_state();
        Ok(whole)
    }

    /// Records new echoes and extends the bounds.
    fn record_echoes(&mut self) {
        for (sensor, range_m) in self.session.ranges_m().into_iter().enumerate() {
            let (echo_origin, at_ms) = self.session.echo_origin(sensor);
            let new = self.echo_ms[sensor].replace(at_ms) != Some(at_ms);
            if let (true, Some(range_m)) = (new, range_m) {
                self.echo_trail.add(echo_origin, sensor, range_m);
            }
        }
        let bounds = around(self.session.pose().position, self.bounds);
        if bounds != self.bounds {
            (self.bounds, self.cache.scene) = (bounds, None);
        }
    }

    fn handle_result(&mut self, result: WorkerResult) -> Result<(), BridgeError> {
        let outputs = &result.outputs;
        if outputs.decision.is_some() || outputs.mode_changed {
            self.close();
        } else if outputs.motion.is_some()
            && let Some(open) = &mut self.open
        {
            open.shielded = true;
        }
        if let Some(refusal) = outputs.refusal {
            self.note = Some(format!("the controller refused: {refusal:?}"));
            self.activity = NomadActivity::Idle;
        }
        self.update_activity(&result);
        if let Some(decision) = &outputs.decision {
            self.decide(decision);
        }
        if outputs.decision.is_some() && self.activity == NomadActivity::Seek {
            self.advance_goal()?;
        }
        if let Some(known) = result.state {
            self.controller.known = Some(known);
            self.controller.requested = false;
            self.cache.knowledge.invalidate_maps();
        }
        Ok(())
    }

    /// Ends an activity that the controller has stopped or completed.
    fn update_activity(&mut self, result: &WorkerResult) {
        let outputs = &result.outputs;
        let is_event = result.kind == ResultKind::Events;
        match self.activity {
            NomadActivity::Explore | NomadActivity::Seek
                if outputs.stopped.is_some() && is_event =>
            {
                let why = outputs.stopped.map(EpisodeError::Stopped);
                self.note = why.map(|why| why.to_string());
                self.interrupted = self.activity;
                self.rest(NomadActivity::Stopped);
            }
            NomadActivity::Explore if outputs.mode_changed && is_event => {
                self.rest(NomadActivity::Idle)
            }
            NomadActivity::Learn if result.kind == ResultKind::Learning => {
                self.session.discard_events();
                self.rest(NomadActivity::Idle);
            }
            _ => {}
        }
    }

    fn rest(&mut self, activity: NomadActivity) {
        self.activity = activity;
        self.controller.stale = true;
    }

    /// Requests the controller's state; from a remote controller only while the robot stands.
    fn request_state(&mut self) {
        let moves = matches!(
            self.activity,
            NomadActivity::Explore | NomadActivity::Learn | NomadActivity::Seek
        );
        let is_allowed =
            self.controller.is_local && self.activity != NomadActivity::Learn || !moves;
        if is_allowed && self.controller.stale && !self.controller.requested {
            (self.controller.stale, self.controller.requested) = (false, true);
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
        self.controller.stale = true;
        self.open = Some(StepFlags {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
            touched_by: false,
        });
    }

    /// Ends the current step.
    fn close(&mut self) {
        let Some(flags) = self.open.take() else {
            return;
        };
        let seeking = self.activity == NomadActivity::Seek;
        if seeking {
            let counted = [true, flags.touched, flags.shielded, flags.at_goal];
            for (count, add) in self.steps.iter_mut().zip(counted) {
                *count += u32::from(add);
            }
        } else {
            self.explored[0] += 1;
            self.explored[1] += u32::from(flags.touched);
        }
        let neuron = self.decision.and_then(|decision| decision.plan);
        let neuron = neuron.map(|plan| usize::from(plan.current_neuron));
        let ranges_m = self.session.ranges_m();
        let nearest = ranges_m.iter().flatten().copied().reduce(f64::min);
        let (time_s, place) = (self.session.time_s(), self.session.pose().position);
        self.trail.push(history_entry(
            time_s, place, seeking, flags, neuron, nearest,
        ));
    }

    /// Starts the next part of a chain when the current one is reached; stops after the last.
    fn advance_goal(&mut self) -> Result<(), BridgeError> {
        let [steps, _, _, held] = self.steps;
        match self.goal.advance(steps, held) {
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
            _ => &self.controller.name,
        };
        self.failure = Some(format!("{which}: {trouble}; the robot was stopped"));
    }

    fn knows_maps(&self) -> bool {
        let known = self.controller.known.as_deref();
        known.is_some_and(SimState::has_learned)
    }
}

/// Bounds with some meters around a place; they grow by whole meters.
fn around(place: Point, [low, high]: [Point; 2]) -> [Point; 2] {
    const ROOM_M: f64 = 2.0;
    let down = |m: f64| libm::floor(m - ROOM_M);
    let up = |m: f64| libm::ceil(m + ROOM_M);
    [
        Point::new(low.x.min(down(place.x)), low.y.min(down(place.y))),
        Point::new(high.x.max(up(place.x)), high.y.max(up(place.y))),
    ]
}
