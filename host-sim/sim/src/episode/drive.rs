//! Explore, learn, seek: the course of an episode.

use super::Seeds;
use super::body::{Body, Collision, StepResult, milliseconds};
use super::measure::Measure;
use super::record::Recorder;
use super::metrics::{Metrics, EpisodeReport, StepFlags, rounded};
use crate::error::EpisodeError;
use crate::pilot::{InspectableController, LocalController, Pilot};
use crate::recording::Recording;
use crate::behavior::Behavior;
use amp::config::Config;
use amp::controller::{Command, Decision, Event};
use amp::fixed::Weight;
use amp::scan::Situation;
use amp::units::Millis;
use arena::robot::TurretMode;
use arena::sonar::{SonarModel, TransducerFault};
use arena::world::{Point, World};

/// What an episode is made of, but for its world.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The mind's open choices.
    pub config: Config<16>,
    /// Name of the preset they came from.
    pub preset: String,
    /// What to do after exploring.
    pub behavior: Behavior,
    /// Random moves, 1 … [`MAX_MOVES`](crate::pilot::MAX_MOVES).
    pub explore_moves: u16,
    /// Decisions towards the goal, at least 1.
    pub steps: u32,
    /// Seed of all randomness.
    pub seed: u64,
    /// What the sonars return.
    pub sonar: SonarModel,
    /// What is wrong with single transducers.
    pub faults: Vec<TransducerFault>,
    /// What the ring does while the base steers.
    pub turret: TurretMode,
    /// Where the robot is set down after exploring; `None` = where its behavior says.
    pub set_down: Option<Point>,
    /// Keep every step for pictures.
    pub record: bool,
}

impl Setup {
    /// The same with another behavior.
    #[must_use]
    pub fn pursuing(self, behavior: Behavior) -> Self {
        Self { behavior, ..self }
    }
}

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

/// Looks on while an episode runs. What it does changes nothing.
pub trait Observer {
    /// The simulation went on by a turn, which ended its ring at `at` and left the body so.
    fn on_step(&mut self, at: Millis, happened: &StepResult, body: &Body<'_>);
}

/// What came of an episode.
#[derive(Debug, Clone)]
pub struct Episode {
    /// The figures.
    pub report: EpisodeReport,
    /// Every step, if it was to be recorded.
    pub recording: Option<Recording>,
}

/// Runs a whole episode; `progress` hears of each phase, what is done of it and what it takes.
///
/// # Errors
/// When the mind refuses a command or falls silent.
pub fn run(
    world: &World,
    setup: &Setup,
    progress: impl FnMut(Phase, u32, u32),
) -> Result<Episode, EpisodeError> {
    run_with(world, setup, &mut LocalController::new(setup.config.clone()), progress)
}

/// As [`run`], with any mind; it should have the setup's configuration and know nothing.
///
/// # Errors
/// When the mind refuses a command, falls silent or cannot be reached.
pub fn run_with(
    world: &World,
    setup: &Setup,
    mind: &mut impl InspectableController,
    progress: impl FnMut(Phase, u32, u32),
) -> Result<Episode, EpisodeError> {
    run_observed(world, setup, mind, None, progress)
}

/// As [`run_with`], while somebody looks on.
///
/// # Errors
/// As [`run_with`].
pub fn run_observed<'w>(
    world: &'w World,
    setup: &Setup,
    mind: &mut impl InspectableController,
    observer: Option<&'w mut dyn Observer>,
    mut progress: impl FnMut(Phase, u32, u32),
) -> Result<Episode, EpisodeError> {
    let (mut driver, exploration) = educated(world, setup, mind, observer, &mut progress)?;
    driver.set_scene(setup);
    let began_s = driver.body.time_s();
    driver.pursue(mind, setup, |done| progress(Phase::Seek, done, setup.steps))?;
    let time_s = driver.body.time_s() - began_s;
    let success = driver.measure.success(&setup.behavior, &driver.tally);
    let report = report(world, setup, &exploration, &driver.tally, time_s, success);
    let recording = match driver.recorder {
        Some(recorder) => {
            let place = setup.behavior.place(driver.measure.nest);
            Some(recorder.finish(world, setup, place, mind.knowledge()?))
        }
        None => None,
    };
    Ok(Episode { report, recording })
}

/// A robot whose mind has explored and learned, and the tally of its random moves.
pub(super) fn educated<'w>(
    world: &'w World,
    setup: &Setup,
    mind: &mut impl Pilot,
    observer: Option<&'w mut dyn Observer>,
    mut progress: impl FnMut(Phase, u32, u32),
) -> Result<(Driver<'w>, Metrics), EpisodeError> {
    let seeds = Seeds::of(setup.seed);
    let body = Body::new(world, setup.sonar, setup.turret, seeds.noise).with_faults(&setup.faults);
    let mut driver = Driver::new(world, body, setup.record);
    driver.observer = observer;

    let moves = u32::from(setup.explore_moves);
    driver.command(
        mind,
        Command::Explore {
            moves: setup.explore_moves,
            seed: seeds.exploration,
        },
    )?;
    driver.drive(
        mind,
        |_| false,
        |done| progress(Phase::Explore, done, moves),
    )?;
    let exploration = driver.next_phase(world);

    progress(Phase::Learn, 0, 1);
    driver.learn(mind)?;
    progress(Phase::Learn, 1, 1);
    Ok((driver, exploration))
}

/// Lets a mind explore and learn in a world, and nothing else.
///
/// # Errors
/// When the mind refuses a command or falls silent.
pub fn explore_and_learn(world: &World, setup: &Setup, mind: &mut impl Pilot) -> Result<(), EpisodeError> {
    educated(world, setup, mind, None, |_, _, _| {}).map(|_| ())
}

/// Lets any pilot drive `steps` steps from the world's start: the tally of a yardstick.
///
/// # Errors
/// When the pilot falls silent.
pub fn drive_pilot(
    world: &World,
    pilot: &mut impl Pilot,
    mut body: Body<'_>,
    steps: u32,
) -> Result<Metrics, EpisodeError> {
    body.restart();
    let mut driver = Driver::new(world, body, false);
    driver.drive(pilot, |tally| tally.steps >= steps, |_| {})?;
    Ok(driver.tally)
}

pub(super) fn report(
    world: &World,
    setup: &Setup,
    exploration: &Metrics,
    seeking: &Metrics,
    time_s: f64,
    (success, success_unit): (f64, &'static str),
) -> EpisodeReport {
    EpisodeReport {
        world: world.name().to_owned(),
        behavior: setup.behavior.name(),
        preset: setup.preset.clone(),
        sonar: setup.sonar.name().to_owned(),
        seed: setup.seed,
        explore_moves: exploration.steps,
        explore_contacts: exploration.contacts,
        steps: seeking.steps,
        contacts: seeking.contacts,
        touched_by: seeking.touched_by,
        distance_m: rounded(seeking.distance_m),
        min_clearance_m: rounded(seeking.min_clearance_m.unwrap_or(0.0)),
        coverage_m2: rounded(seeking.coverage_m2()),
        goal_steps: seeking.goal_steps,
        shield_stops: seeking.shield_stops,
        time_s: rounded(time_s),
        success: rounded(success),
        success_unit,
    }
}

pub(super) struct Driver<'w> {
    pub(super) world: &'w World,
    pub(super) body: Body<'w>,
    pub(super) tally: Metrics,
    pub(super) measure: Measure,
    /// What is being done now, and which part of a chain it is.
    pub(super) behavior: Behavior,
    pub(super) part: usize,
    /// What was perceived before the first move.
    pub(super) nest: Situation<16>,
    first: bool,
    /// The step under way.
    open: Option<StepFlags>,
    recorder: Option<Recorder>,
    observer: Option<&'w mut dyn Observer>,
}

impl<'w> Driver<'w> {
    /// Rings without a decision before the mind counts as silent.
    const PATIENCE: u32 = 100;

    fn new(world: &'w World, body: Body<'w>, record: bool) -> Self {
        Self {
            world,
            body,
            tally: Metrics::new(world),
            measure: Measure::new(world, world.start().position),
            behavior: Behavior::Avoid,
            part: 0,
            nest: [Weight::ZERO; 16],
            first: true,
            open: None,
            recorder: record.then(Recorder::default),
            observer: None,
        }
    }

    pub(super) fn command(
        &mut self,
        mind: &mut impl Pilot,
        command: Command<16>,
    ) -> Result<(), EpisodeError> {
        let outputs = mind.handle(self.body.now(), Event::Command(command));
        let refused = outputs.refusal.map(EpisodeError::Refused);
        mind.failure().or(refused).map_or(Ok(()), Err)
    }

    fn learn(&mut self, mind: &mut impl Pilot) -> Result<(), EpisodeError> {
        self.command(mind, Command::Learn)?;
        while !mind.handle(self.body.now(), Event::Tick).mode_changed {
            mind.failure().map_or(Ok(()), Err)?;
        }
        Ok(())
    }

    /// Drives until the steps that were done are enough or the pilot changes its mode.
    pub(super) fn drive(
        &mut self,
        pilot: &mut impl Pilot,
        is_over: impl Fn(&Metrics) -> bool,
        mut progress: impl FnMut(u32),
    ) -> Result<(), EpisodeError> {
        let mut last_decision_s = self.body.time_s();
        while !is_over(&self.tally) {
            let least_m = self.tally.min_clearance_m;
            self.body.tell_gaps_below(least_m.unwrap_or(f64::INFINITY));
            let happened = self.body.advance(pilot);
            if let Some(observer) = &mut self.observer {
                observer.on_step(milliseconds(happened.time_s), &happened, &self.body);
            }
            pilot.failure().map_or(Ok(()), Err)?;
            if let Some(reason) = happened.stopped {
                return Err(EpisodeError::Stopped(reason));
            }
            if happened.decision.is_some() || happened.mode_changed {
                self.close();
                progress(self.tally.steps);
                last_decision_s = self.body.time_s();
            }
            if happened.mode_changed || is_over(&self.tally) {
                return Ok(());
            }
            if self.body.time_s() - last_decision_s > f64::from(Self::PATIENCE) * self.body.ring_s()
            {
                return Err(EpisodeError::Silent);
            }
            if let Some(decision) = &happened.decision {
                self.open(decision, &happened);
            }
            self.follow(&happened);
        }
        Ok(())
    }

    fn open(&mut self, decision: &Decision<16>, happened: &StepResult) {
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
            recorder.open(decision, happened, &self.body, self.part);
        }
    }

    fn follow(&mut self, happened: &StepResult) {
        if let Some(open) = &mut self.open {
            open.touched |= happened.collision == Some(Collision::ByRobot);
            open.touched_by |= happened.collision == Some(Collision::ByOther);
        }
        if let Some(moved) = &happened.moved {
            self.tally
                .moved(moved.from, moved.to, moved.traveled_m, moved.clearance_m);
            self.measure.moved(
                moved.to,
                moved.touched,
                self.body.time_s() - happened.time_s,
                self.body.leader(),
            );
            if let Some(open) = &mut self.open {
                open.touched |= moved.touched;
                open.shielded |= happened.shortened;
            }
            if let Some(recorder) = &mut self.recorder {
                recorder.moved(moved);
            }
        }
    }

    fn close(&mut self) {
        if let Some(stride) = self.open.take() {
            self.tally.step(stride);
            self.measure.step(self.world, &self.behavior);
            if let Some(recorder) = &mut self.recorder {
                recorder.close(stride);
            }
        }
    }

    /// Measures from now on, with the nest here.
    pub(super) fn measure_from(&mut self, nest: Point) {
        self.measure = Measure::new(self.world, nest);
    }

    /// Begins a new tally; returns the old one.
    pub(super) fn next_phase(&mut self, world: &World) -> Metrics {
        if let Some(recorder) = &mut self.recorder {
            recorder.next_phase();
        }
        std::mem::replace(&mut self.tally, Metrics::new(world))
    }
}
