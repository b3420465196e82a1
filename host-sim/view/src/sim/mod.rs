//! Shows the simulator: a body in a world that can be changed, and a local or remote controller.
//!
//! The controller receives the same events as in an [episode](sim::episode), so the same seed gives
//! the same decisions. Time advances only while the robot does something.

mod commands;
mod mind;
mod parts;
mod places;
mod record;
mod senses;
mod think;

use super::command::{CommandOutcome, PageCommand};
use super::dto::KnowledgeParts;
use super::goal::ActiveGoal;
use super::history::{History, history_entry};
use super::place_frames::PlaceFrames;
use super::snapshot::{PlacesDto, SceneDto, Snapshot, SnapshotPart};
use super::source::{Capabilities, CommandRefused, StepOutcome, ViewSource};
use amp::config::Config;
use amp::controller::{Command, Decision, Event};
use amp::scan::Situation;
use arena::robot::TurretMode;
use arena::world::{Point, Pose, World};
use files::error::BadInput;
use record::Recorder;
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

/// Rings without a decision after which the controller counts as silent.
const MAX_SILENT_RINGS: f64 = 100.0;

/// The initial settings of a simulation.
#[derive(Debug, Clone)]
pub struct SimulatorStart {
    /// The world.
    pub world: World,
    /// Its name as given by the user.
    pub named: String,
    /// All other settings.
    pub setup: Setup,
    /// The configuration with shield and online learning switched on.
    pub whole: Config<16>,
    /// Presets for a restart.
    pub presets: Vec<PresetChoice>,
}

impl SimulatorStart {
    /// The settings as a log records them.
    fn record(&self) -> SetupRecord {
        SetupRecord::of(&self.named, &self.setup)
    }
}

/// A preset of the menu.
#[derive(Debug, Clone)]
pub struct PresetChoice {
    /// Its name.
    pub name: &'static str,
    /// Its configuration.
    pub config: Config<16>,
    /// Its turret mode.
    pub turret: TurretMode,
}

/// What the robot does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SimulatorActivity {
    Idle,
    /// Random moves that find the body's sensors.
    Babble,
    /// Working out where they are.
    Calibrate,
    Explore,
    Learn,
    Seek,
    Stopped,
}

/// A simulated robot.
pub struct Simulator {
    start: SimulatorStart,
    /// The current configuration.
    config: Config<16>,
    body: Body<'static>,
    controller: LoggedController,
    /// Logs the true state of the world.
    watcher: Option<WorldLogger<LogOutput>>,
    activity: SimulatorActivity,
    /// The activity that a stop interrupted.
    interrupted: SimulatorActivity,
    /// Why the simulation cannot continue.
    failure: Option<String>,
    /// A remark for the page.
    note: Option<String>,
    goal: ActiveGoal,
    /// Situation and place before the first move.
    nest: Option<(Situation<16>, Point)>,
    decision: Option<Decision<16>>,
    /// The situation before the latest decision.
    before: Option<Situation<16>>,
    /// Where the robot's places lie in the world.
    frames: PlaceFrames,
    /// Latest ranges, and the ring's pose at that time.
    ranges_m: [Option<f64>; 16],
    scan_pose: Pose,
    learned: bool,
    /// Nothing of its body is left to be found.
    is_calibrated: bool,
    learning: u32,
    touched: bool,
    step_s: f64,
    last_decision_s: f64,
    explorations: u64,
    explored: Metrics,
    seeking: Metrics,
    open: Option<StepFlags>,
    trail: History,
    recorder: Recorder,
    cache: SimulatorCache,
}

/// Parts of the latest snapshot, and the number of snapshots.
#[derive(Default)]
struct SimulatorCache {
    revision: u64,
    scene: Option<Arc<SnapshotPart<SceneDto>>>,
    places: Option<Arc<SnapshotPart<PlacesDto>>>,
    knowledge: KnowledgeParts,
}

impl Simulator {
    /// A robot at its world's start, with a controller without knowledge; logs into a new file
    /// `log`.
    ///
    /// # Errors
    /// When the controller cannot be reached or the file cannot be written.
    pub fn new(
        start: SimulatorStart,
        place: ControllerPlace,
        log: Option<&Path>,
    ) -> Result<Self, BadInput> {
        let robot = start.setup.robot.as_ref();
        let controller = AnyController::new(&start.setup.config, robot, place)?;
        let log = log.map(LogWriter::create).transpose()?;
        let mut controller = LoggedController::new(controller, log.map(SharedLog::new));
        controller.begin(&start.record(), Some(&start.world));
        Ok(Self::with_controller(start, controller))
    }

    fn with_controller(start: SimulatorStart, controller: LoggedController) -> Self {
        let (setup, world) = (&start.setup, &start.world);
        let noise = Seeds::of(setup.seed).noise;
        let world = Cow::Owned(world.clone());
        let body = match &setup.robot {
            None => Body::within(world, setup.sonar, setup.turret, noise),
            Some(robot) => Body::of_robot_within(world, robot, setup.sonar, noise),
        };
        let body = body.with_faults(&setup.faults);
        let body = body.sensing(Seeds::of(setup.seed).sources);
        let goal = ActiveGoal::behavior(&setup.behavior);
        let ranges_m = body.look();
        let robot = setup.robot.as_ref();
        let miswiring = robot.and_then(|robot| robot.miswiring());
        let side = miswiring.map_or(1.0, |wrong| wrong.side());
        let nothing = Metrics::new(&start.world, body.radius_m());
        let watcher = controller.log().cloned().map(WorldLogger::new);
        let mut simulator = Self {
            config: setup.config.clone(),
            controller,
            watcher,
            activity: SimulatorActivity::Idle,
            interrupted: SimulatorActivity::Idle,
            failure: None,
            note: None,
            goal,
            nest: None,
            decision: None,
            before: None,
            ranges_m,
            scan_pose: body.pose(),
            frames: PlaceFrames::new(body.pose(), side),
            learned: false,
            is_calibrated: false,
            learning: 0,
            touched: false,
            step_s: 0.0,
            last_decision_s: 0.0,
            explorations: 0,
            explored: nothing.clone(),
            seeking: nothing,
            open: None,
            trail: History::latest(),
            recorder: Recorder::default(),
            cache: SimulatorCache::default(),
            body,
            start,
        };
        if let Err(CommandRefused(why)) = simulator.add_missing_sources() {
            simulator.fail(why);
        }
        simulator
    }

    fn command(&mut self, command: Command<16>) -> Result<(), CommandRefused> {
        let outputs = self
            .controller
            .handle(self.body.now(), Event::Command(command));
        let refused = outputs.refusal.map(EpisodeError::Refused);
        self.check_controller();
        match refused {
            Some(why) => Err(why.into()),
            None => self.failure.clone().map_or(Ok(()), |why| Err(why.into())),
        }
    }

    /// Stops after a failure of the controller.
    fn check_controller(&mut self) {
        if let Some(failure) = self.controller.failure() {
            self.fail(failure.to_string());
        }
    }

    fn fail(&mut self, why: String) {
        self.body.halt();
        self.failure = Some(why);
    }

    fn drive(&mut self) -> StepOutcome {
        let began_s = self.body.time_s();
        let result = self.body.advance(&mut self.controller);
        self.sense();
        self.settle_places();
        if let Some(watcher) = &mut self.watcher {
            let at = milliseconds(result.time_s);
            watcher.on_step(at, &result, &self.body);
        }
        self.check_controller();
        (self.ranges_m, self.scan_pose) = (*self.body.ranges_m(), result.pose);
        self.step_s = self.body.time_s() - began_s;
        let whole = result.decision.is_some() || result.mode_changed;
        if whole {
            self.close();
            self.last_decision_s = self.body.time_s();
        }
        if let Some(reason) = result.stopped {
            self.interrupted = std::mem::replace(&mut self.activity, SimulatorActivity::Stopped);
            self.note = Some(EpisodeError::Stopped(reason).to_string());
        } else if result.mode_changed && self.activity == SimulatorActivity::Babble {
            self.activity = SimulatorActivity::Calibrate;
        } else if result.mode_changed && self.activity == SimulatorActivity::Explore {
            self.activity = SimulatorActivity::Idle;
            self.controller.pilot().invalidate_cache(true);
        }
        if let Some(decision) = &result.decision {
            self.open(decision, &result);
        }
        self.follow(&result);
        if whole {
            self.advance_goal();
        }
        self.check_silence();
        StepOutcome::Took {
            took_s: self.step_s,
            whole,
        }
    }

    /// Fails if the controller should decide and has not done so for several rings.
    fn check_silence(&mut self) {
        let silent_s = self.body.time_s() - self.last_decision_s;
        let deciding = matches!(
            self.activity,
            SimulatorActivity::Explore | SimulatorActivity::Seek
        );
        if deciding && silent_s > MAX_SILENT_RINGS * self.body.ring_s() {
            self.fail(EpisodeError::Silent.to_string());
        }
    }

    fn open(&mut self, decision: &Decision<16>, result: &StepResult) {
        if self.nest.is_none() {
            self.nest = Some((decision.situation, result.pose.position));
        }
        self.before = self.decision.map(|before| before.situation);
        self.decision = Some(*decision);
        let enabled = self.controller.inner().enabled();
        self.recorder
            .decided(decision, result.pose.heading, enabled);
        self.touched = false;
        self.open = Some(StepFlags {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
            touched_by: false,
        });
        self.controller.pilot().invalidate_cache(false);
        if self.activity == SimulatorActivity::Seek && self.config.online.is_some() {
            self.cache.knowledge.invalidate_maps();
        }
    }

    fn metrics(&mut self) -> &mut Metrics {
        match self.activity {
            SimulatorActivity::Explore | SimulatorActivity::Babble => &mut self.explored,
            _ => &mut self.seeking,
        }
    }

    fn follow(&mut self, result: &StepResult) {
        let Some(moved) = &result.moved else { return };
        self.recorder.moved(moved);
        self.metrics()
            .moved(moved.from, moved.to, moved.traveled_m, moved.clearance_m);
        self.touched |= moved.touched;
        if let Some(open) = &mut self.open {
            open.touched |= moved.touched;
            open.shielded |= result.shortened;
        }
    }

    /// Ends the current step.
    fn close(&mut self) {
        let Some(flags) = self.open.take() else {
            return;
        };
        self.metrics().step(flags);
        let neuron = self.decision.and_then(|decision| decision.plan);
        let neuron = neuron.map(|plan| usize::from(plan.current_neuron));
        let nearest = self.ranges_m.iter().flatten().copied().reduce(f64::min);
        let place = self.body.pose().position;
        let seeking = self.activity == SimulatorActivity::Seek;
        let time_s = self.body.time_s();
        let entry = history_entry(time_s, place, seeking, flags, neuron, nearest);
        self.trail.push(entry);
    }

    /// Whether the robot does something or still rolls.
    fn is_busy(&self) -> bool {
        let driven = matches!(
            self.activity,
            SimulatorActivity::Explore | SimulatorActivity::Seek | SimulatorActivity::Babble
        );
        self.failure.is_none() && (driven || self.body.is_moving())
    }
}

impl ViewSource for Simulator {
    fn abilities(&self) -> Capabilities {
        Capabilities {
            drive: true,
            pace: true,
            carry: true,
            places: self.has_places(),
            reset: true,
            show: self.start.setup.robot.is_none(),
            configure: self.start.setup.robot.is_none(),
            save: true,
            load: self.controller.inner().is_local(),
            ..Capabilities::default()
        }
    }

    fn step(&mut self) -> StepOutcome {
        match self.activity {
            SimulatorActivity::Learn | SimulatorActivity::Calibrate if self.failure.is_none() => {
                self.think()
            }
            _ if self.is_busy() => self.drive(),
            _ => StepOutcome::Idle,
        }
    }

    fn execute(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused> {
        self.execute_command(command)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.parts()
    }

    fn end(&mut self) -> Result<(), String> {
        self.controller.log().map_or(Ok(()), SharedLog::finish)
    }
}

#[cfg(test)]
mod tests;
