//! Runs an episode: explore, learn, seek.

use super::Seeds;
use super::body::{Body, Collision, StepResult, milliseconds};
use super::measure::Measure;
use super::metrics::{EpisodeReport, Metrics, StepFlags};
use super::record::StepRecorder;
use super::setup::Setup;
use super::sources::completed_world;
use crate::behavior::Behavior;
use crate::error::EpisodeError;
use crate::pilot::{InspectableController, Pilot};
use crate::recording::Recording;
use crate::robot::Origin;
use crate::sim_controller::SimController;
use amp::controller::{Command, Decision, Event};
use amp::fixed::{Mask, Weight};
use amp::scan::Situation;
use amp::units::Millis;
use arena::sources::Sensed;
use arena::world::{Point, Pose, World};

/// The phases of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Random moves.
    Explore,
    /// Making the maps.
    Learn,
    /// Pursuing the goal.
    Seek,
}

/// Observes an episode without changing it.
pub trait Observer {
    /// Called after each simulation step; the step's ring ended at `at`.
    fn on_step(&mut self, at: Millis, result: &StepResult, body: &Body<'_>);
}

/// Result of an episode.
#[derive(Debug, Clone)]
pub struct Episode {
    /// The figures.
    pub report: EpisodeReport,
    /// Every step, if they were recorded.
    pub recording: Option<Recording>,
    /// Median and greatest error of the sensors' bearings, degrees, where they were learned.
    pub bearing_errors_deg: Option<[f64; 2]>,
}

/// Runs a whole episode. `progress` is called with the phase, the number of steps done and the
/// number of steps in all.
///
/// # Errors
/// When the controller refuses a command or is silent.
pub fn run(
    world: &World,
    setup: &Setup,
    progress: impl FnMut(Phase, u32, u32),
) -> Result<Episode, EpisodeError> {
    let mut controller = SimController::new(&setup.config, setup.robot.as_ref());
    run_with(world, setup, &mut controller, progress)
}

/// As [`run`], with any controller. It should have the setup's configuration and no knowledge.
///
/// # Errors
/// When the controller refuses a command, is silent or cannot be reached.
pub fn run_with(
    world: &World,
    setup: &Setup,
    controller: &mut impl InspectableController,
    progress: impl FnMut(Phase, u32, u32),
) -> Result<Episode, EpisodeError> {
    run_observed(world, setup, controller, None, progress)
}

/// As [`run_with`], with an observer.
///
/// # Errors
/// As [`run_with`].
pub fn run_observed<'w>(
    world: &'w World,
    setup: &Setup,
    controller: &mut impl InspectableController,
    observer: Option<&'w mut dyn Observer>,
    mut progress: impl FnMut(Phase, u32, u32),
) -> Result<Episode, EpisodeError> {
    let (mut runner, exploration) = explored(world, setup, controller, observer, &mut progress)?;
    runner.nest_known = controller.known_at_nest()?;
    if matches!(setup.behavior, Behavior::Nest { .. }) {
        runner.tour(controller, setup, |_| {})?;
        // Nobody carries a robot that drives.
        if setup.behavior.tour().is_some_and(|tour| tour.steps > 0) {
            runner.command(controller, Command::Stop)?;
        }
    }
    runner.set_scene(setup);
    runner.pursue(controller, setup, |done| {
        progress(Phase::Seek, done, setup.steps)
    })?;
    let time_s = runner.body.time_s() - runner.began_s;
    let report = EpisodeReport::of(
        world,
        setup,
        &exploration,
        &runner.metrics,
        time_s,
        &runner.measure,
    );
    let recording = match runner.recorder {
        Some(recorder) => {
            let place = setup.behavior.place(runner.measure.nest);
            Some(recorder.finish(
                runner.body.world(),
                setup,
                runner.body.radius_m(),
                place,
                controller.knowledge()?,
            ))
        }
        None => None,
    };
    let learns = setup
        .robot
        .as_ref()
        .filter(|robot| robot.geometry() == Origin::Learned);
    let bearing_errors_deg = match (learns, controller.body()?) {
        (Some(robot), Some(body)) => robot.bearing_errors_deg(&body),
        _ => None,
    };
    Ok(Episode {
        report,
        recording,
        bearing_errors_deg,
    })
}

/// Makes a controller explore and learn; returns the runner and the metrics of the random moves.
pub(super) fn explored<'w>(
    world: &'w World,
    setup: &Setup,
    controller: &mut impl Pilot,
    observer: Option<&'w mut dyn Observer>,
    mut progress: impl FnMut(Phase, u32, u32),
) -> Result<(EpisodeRunner<'w>, Metrics), EpisodeError> {
    let seeds = Seeds::of(setup.seed);
    let body = match &setup.robot {
        None => Body::new(world, setup.sonar, setup.turret, seeds.noise),
        Some(robot) => Body::of_robot(world, robot, setup.sonar, seeds.noise),
    };
    let mut body = body.with_faults(&setup.faults).sensing(seeds.sources);
    if let Some(completed) = completed_world(world, setup)? {
        body.set_world(completed);
    }
    let mut runner = EpisodeRunner::new(world, body, setup.record);
    runner.observer = observer;

    runner.calibrate(controller, setup)?;
    runner.start = runner.body.pose();
    let explore_moves = setup.explore_moves - setup.calibration_moves();
    let moves = u32::from(explore_moves);
    runner.command(
        controller,
        Command::Explore {
            moves: explore_moves,
            seed: seeds.exploration,
        },
    )?;
    runner.drive(
        controller,
        |_| false,
        |done| progress(Phase::Explore, done, moves),
    )?;
    let exploration = runner.next_phase(world);

    progress(Phase::Learn, 0, 1);
    runner.learn(controller)?;
    progress(Phase::Learn, 1, 1);
    Ok((runner, exploration))
}

/// Makes a controller explore and learn in a world.
///
/// # Errors
/// When the controller refuses a command or is silent.
pub fn explore_and_learn(
    world: &World,
    setup: &Setup,
    controller: &mut impl Pilot,
) -> Result<(), EpisodeError> {
    explored(world, setup, controller, None, |_, _, _| {}).map(|_| ())
}

/// Drives a reference pilot for `steps` steps from the world's start.
///
/// # Errors
/// When the pilot is silent.
pub fn drive_pilot(
    world: &World,
    pilot: &mut impl Pilot,
    mut body: Body<'_>,
    steps: u32,
) -> Result<Metrics, EpisodeError> {
    body.restart();
    let mut runner = EpisodeRunner::new(world, body, false);
    runner.drive(pilot, |metrics| metrics.steps >= steps, |_| {})?;
    Ok(runner.metrics)
}

pub(super) struct EpisodeRunner<'w> {
    pub(super) world: &'w World,
    pub(super) body: Body<'w>,
    pub(super) metrics: Metrics,
    pub(super) measure: Measure,
    /// The current behavior, and its index in a chain.
    pub(super) behavior: Behavior,
    pub(super) part: usize,
    /// Where the random moves for the maps began.
    pub(super) start: Pose,
    /// Situation before the first of them, and what was known of it.
    pub(super) nest: Situation<16>,
    pub(super) nest_known: Mask,
    first: bool,
    /// When the robot was told its goal.
    pub(super) began_s: f64,
    /// What could be perceived beside ranges, and where.
    pub(super) sensed: Vec<(Point, Sensed)>,
    /// The current step.
    pub(super) open: Option<StepFlags>,
    recorder: Option<StepRecorder>,
    observer: Option<&'w mut dyn Observer>,
}

impl<'w> EpisodeRunner<'w> {
    /// A controller that takes no decision for this many rings is silent.
    pub(super) const MAX_SILENT_RINGS: u32 = 100;

    fn new(world: &'w World, body: Body<'w>, record: bool) -> Self {
        Self {
            world,
            metrics: Metrics::new(world, body.radius_m()),
            body,
            measure: Measure::new(world, world.start().position),
            behavior: Behavior::Avoid,
            part: 0,
            start: world.start(),
            nest: [Weight::ZERO; 16],
            nest_known: Mask::ALL,
            first: true,
            began_s: 0.0,
            sensed: Vec::new(),
            open: None,
            recorder: record.then(StepRecorder::default),
            observer: None,
        }
    }

    pub(super) fn command(
        &mut self,
        controller: &mut impl Pilot,
        command: Command<16>,
    ) -> Result<(), EpisodeError> {
        let outputs = controller.handle(self.body.now(), Event::Command(command));
        let refused = outputs.refusal.map(EpisodeError::Refused);
        controller.failure().or(refused).map_or(Ok(()), Err)
    }

    fn learn(&mut self, controller: &mut impl Pilot) -> Result<(), EpisodeError> {
        self.command(controller, Command::Learn)?;
        self.think(controller)
    }

    /// Drives until `is_over` or until the pilot changes its mode.
    pub(super) fn drive(
        &mut self,
        pilot: &mut impl Pilot,
        is_over: impl Fn(&Metrics) -> bool,
        mut progress: impl FnMut(u32),
    ) -> Result<(), EpisodeError> {
        let mut last_decision_s = self.body.time_s();
        while !is_over(&self.metrics) {
            let least_m = self.metrics.min_clearance_m;
            self.body
                .ignore_gaps_above(least_m.unwrap_or(f64::INFINITY));
            let result = self.body.advance(pilot);
            self.sense(pilot);
            if let Some(observer) = &mut self.observer {
                observer.on_step(milliseconds(result.time_s), &result, &self.body);
            }
            pilot.failure().map_or(Ok(()), Err)?;
            if let Some(reason) = result.stopped {
                return Err(EpisodeError::Stopped(reason));
            }
            if result.decision.is_some() || result.mode_changed {
                self.close();
                progress(self.metrics.steps);
                last_decision_s = self.body.time_s();
            }
            if result.mode_changed || is_over(&self.metrics) {
                return Ok(());
            }
            if self.body.time_s() - last_decision_s
                > f64::from(Self::MAX_SILENT_RINGS) * self.body.ring_s()
            {
                return Err(EpisodeError::Silent);
            }
            if let Some(decision) = &result.decision {
                self.open(decision, &result);
            }
            self.follow(&result);
        }
        Ok(())
    }

    fn open(&mut self, decision: &Decision<16>, result: &StepResult) {
        if self.first {
            self.first = false;
            self.nest = decision.situation;
        }
        self.open = Some(StepFlags {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
            touched_by: false,
        });
        if let Some(recorder) = &mut self.recorder {
            recorder.open(decision, result, &self.body, self.part);
        }
    }

    pub(super) fn follow(&mut self, result: &StepResult) {
        if let Some(open) = &mut self.open {
            open.touched |= result.collision == Some(Collision::ByRobot);
            open.touched_by |= result.collision == Some(Collision::ByOther);
        }
        if let Some(moved) = &result.moved {
            self.metrics
                .moved(moved.from, moved.to, moved.traveled_m, moved.clearance_m);
            self.measure.moved(
                moved.to,
                moved.touched,
                self.body.time_s() - result.time_s,
                self.body.leader(),
            );
            if let Some(open) = &mut self.open {
                open.touched |= moved.touched;
                open.shielded |= result.shortened;
            }
            if let Some(recorder) = &mut self.recorder {
                recorder.moved(moved);
            }
        }
    }

    pub(super) fn close(&mut self) {
        if let Some(flags) = self.open.take() {
            self.metrics.step(flags);
            self.measure.step(self.world, &self.behavior);
            if let Some(recorder) = &mut self.recorder {
                recorder.close(flags);
            }
        }
    }

    /// Restarts the measurement with a nest.
    pub(super) fn measure_from(&mut self, nest: Point) {
        self.began_s = self.body.time_s();
        self.measure = Measure::new(self.world, nest);
    }

    /// Starts new metrics and returns the old ones.
    pub(super) fn next_phase(&mut self, world: &World) -> Metrics {
        if let Some(recorder) = &mut self.recorder {
            recorder.next_phase();
        }
        std::mem::replace(&mut self.metrics, Metrics::new(world, self.body.radius_m()))
    }
}
