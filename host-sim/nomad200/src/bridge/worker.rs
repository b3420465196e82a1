//! The thread of the controller: takes tasks in order and returns a result for each.

use super::events::TimedEvent;
use amp::config::Config;
use amp::controller::{Command, Event, Motion, Outputs};
use amp::units::Millis;
use arena::world::Point;
use remote::log::LoggedController;
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, Pilot, SimState};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Echoes within this time are delivered together, ms: half a ring. With a longer time the ring
/// would look incomplete to the controller.
const SAME_TIME_MS: u32 = 320;

/// A task of the controller.
pub(super) enum WorkerTask {
    /// Handle these events in order.
    Events(Vec<TimedEvent>),
    /// Execute a command.
    Command(Millis, Command<16>),
    /// Learn the maps.
    Learn(Millis),
    /// Replace the configuration.
    Configure(Millis, Box<Config<16>>),
    /// Read the state.
    ReadState,
}

/// Kind of task that a result belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResultKind {
    /// Events.
    Events,
    /// A command.
    Command,
    /// Learning has ended.
    Learning,
    /// Another task.
    Other,
}

/// Result of a task.
pub struct WorkerResult {
    /// Kind of task.
    pub kind: ResultKind,
    /// The controller's outputs.
    pub outputs: Outputs<16>,
    /// The latest motion and its goal in the robot's frame, m.
    pub(super) motion: Option<(Point, Motion)>,
    /// The controller's state, if it was requested.
    pub state: Option<Box<SimState>>,
}

/// Handle of the thread.
pub(super) struct Worker {
    tasks: Option<Sender<WorkerTask>>,
    results: Receiver<Result<WorkerResult, EpisodeError>>,
    thread: Option<JoinHandle<()>>,
    /// Number of unfinished tasks, and since when the oldest one waits.
    pending: u32,
    since: Instant,
}

impl Worker {
    /// Starts the thread.
    pub(super) fn start(pilot: LoggedController) -> Self {
        let (tasks, task_queue) = channel();
        let (result_queue, results) = channel();
        let thread = std::thread::spawn(move || run(pilot, &task_queue, &result_queue));
        Self {
            tasks: Some(tasks),
            results,
            thread: Some(thread),
            pending: 0,
            since: Instant::now(),
        }
    }

    /// Queues a task.
    pub(super) fn submit(&mut self, task: WorkerTask) {
        if self.pending == 0 {
            self.since = Instant::now();
        }
        self.pending += 1;
        if let Some(tasks) = &self.tasks {
            // `poll` reports a thread that has ended.
            let _ = tasks.send(task);
        }
    }

    /// The next result, if there is one.
    pub(super) fn poll(&mut self) -> Option<Result<WorkerResult, EpisodeError>> {
        match self.results.try_recv() {
            Ok(result) => {
                self.pending = self.pending.saturating_sub(1);
                self.since = Instant::now();
                Some(result)
            }
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(EpisodeError::Silent)),
        }
    }

    /// Whether no task is unfinished.
    pub(super) fn is_idle(&self) -> bool {
        self.pending == 0
    }

    /// How long the current task has taken.
    pub(super) fn busy_for(&self) -> Duration {
        if self.is_idle() {
            Duration::ZERO
        } else {
            self.since.elapsed()
        }
    }

    /// Ends the thread; with `at`, the controller stops first.
    pub(super) fn finish(&mut self, at: Option<Millis>) {
        if let Some(at) = at {
            self.submit(WorkerTask::Command(at, Command::Stop));
        }
        self.tasks = None;
        if let Some(thread) = self.thread.take() {
            // An error here is a panic that was already printed.
            let _ = thread.join();
        }
    }
}

fn run(
    mut pilot: LoggedController,
    tasks: &Receiver<WorkerTask>,
    results: &Sender<Result<WorkerResult, EpisodeError>>,
) {
    while let Ok(task) = tasks.recv() {
        let result = execute(&mut pilot, task);
        let result = pilot.failure().map_or(result, Err);
        if results.send(result).is_err() {
            break;
        }
    }
}

fn execute(pilot: &mut LoggedController, task: WorkerTask) -> Result<WorkerResult, EpisodeError> {
    Ok(match task {
        WorkerTask::Events(events) => deliver(pilot, &events),
        WorkerTask::Command(at, command) => WorkerResult::of(
            ResultKind::Command,
            pilot.handle(at, Event::Command(command)),
        ),
        WorkerTask::Learn(at) => learn(pilot, at),
        WorkerTask::Configure(at, config) => {
            pilot.configure(at, &config).map_err(EpisodeError::from)?;
            WorkerResult::of(ResultKind::Other, Outputs::NONE)
        }
        WorkerTask::ReadState => {
            pilot.pilot().invalidate_cache(true);
            let state = Box::new(pilot.pilot().cached_state()?.clone());
            WorkerResult {
                state: Some(state),
                ..WorkerResult::of(ResultKind::Other, Outputs::NONE)
            }
        }
    })
}

/// Delivers events. Echoes of about the same place and time are delivered together, at the time of
/// the last one, each with its age.
pub(super) fn deliver(pilot: &mut impl Pilot, events: &[TimedEvent]) -> WorkerResult {
    let mut all = WorkerResult::of(ResultKind::Events, Outputs::NONE);
    for group in events.chunk_by(|_, next| is_echo(next)) {
        // Only the first event of a group may be no echo.
        let (first, echoes) = match group.split_first() {
            Some((first, echoes)) if !is_echo(first) => (Some(first), echoes),
            _ => (None, group),
        };
        if let Some(first) = first {
            all.add(first, pilot.handle(first.at, first.event));
        }
        let mut left = echoes;
        while let Some(first) = left.first() {
            let near = |event: &&TimedEvent| event.at.since(first.at) <= SAME_TIME_MS;
            let count = left.iter().take_while(near).count().max(1);
            let (together, rest) = left.split_at(count);
            all.deliver_echoes(pilot, together);
            left = rest;
        }
    }
    all
}

fn is_echo(event: &TimedEvent) -> bool {
    matches!(event.event, Event::Echo { .. })
}

impl WorkerResult {
    /// Result of a task without a position: its only motion can be a stop.
    fn of(kind: ResultKind, outputs: Outputs<16>) -> Self {
        Self {
            kind,
            outputs,
            motion: outputs.motion.map(|motion| (Point::default(), motion)),
            state: None,
        }
    }

    /// Delivers echoes that were sensed at one place.
    fn deliver_echoes(&mut self, pilot: &mut impl Pilot, events: &[TimedEvent]) {
        let Some(last) = events.last() else {
            return;
        };
        let echo = |event: &TimedEvent| match event.event {
            Event::Echo { sensor, range } => Some(AgedEcho {
                sensor,
                range,
                age_ms: last.at.since(event.at) + event.age_ms,
            }),
            _ => None,
        };
        let echoes: Vec<_> = events.iter().filter_map(echo).collect();
        let mut rest = &echoes[..];
        while !rest.is_empty() {
            let (taken, outputs) = pilot.echoes(last.at, rest);
            rest = rest.get(taken.max(1)..).unwrap_or(&[]);
            self.add(last, outputs);
        }
    }

    fn add(&mut self, event: &TimedEvent, outputs: Outputs<16>) {
        self.outputs.decision = self.outputs.decision.or(outputs.decision);
        self.outputs.mode_changed |= outputs.mode_changed;
        self.outputs.stopped = self.outputs.stopped.or(outputs.stopped);
        self.outputs.refusal = self.outputs.refusal.or(outputs.refusal);
        if let Some(motion) = outputs.motion {
            let [x, y] = [motion.displacement.dx_mm, motion.displacement.dy_mm];
            let displacement_m = Point::new(f64::from(x), f64::from(y)) * 1e-3;
            let goal = event.place + displacement_m.turned(Point::unit(event.ring));
            self.outputs.motion = Some(motion);
            self.motion = Some((goal, motion));
        }
    }
}

fn learn(pilot: &mut impl Pilot, at: Millis) -> WorkerResult {
    let mut outputs = pilot.handle(at, Event::Command(Command::Learn));
    outputs.mode_changed = false;
    while pilot.failure().is_none() && outputs.refusal.is_none() && !outputs.mode_changed {
        outputs = pilot.handle(at, Event::Tick);
    }
    WorkerResult::of(ResultKind::Learning, outputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::controller::Progress;
    use amp::units::{Bearing, Displacement};

    /// Records its inputs as (time, transducers with ages) and commands a motion at one transducer.
    struct RecordingPilot {
        inputs: Vec<(u32, Vec<(u8, u32)>)>,
        moves_at: u8,
    }

    impl Pilot for RecordingPilot {
        fn handle(&mut self, at: Millis, _: Event<16>) -> Outputs<16> {
            self.inputs.push((at.as_ms(), Vec::new()));
            Outputs::NONE
        }

        fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
            let sensors = echoes.iter().map(|echo| (echo.sensor, echo.age_ms));
            let sensors: Vec<_> = sensors.collect();
            let moves = echoes.iter().any(|echo| echo.sensor == self.moves_at);
            let motion = moves.then_some(Motion {
                id: 1,
                displacement: Displacement {
                    dx_mm: 100,
                    dy_mm: 0,
                },
                speed_mm_s: 500,
            });
            self.inputs.push((at.as_ms(), sensors));
            let outputs = Outputs {
                motion,
                ..Outputs::NONE
            };
            (echoes.len(), outputs)
        }
    }

    fn event(at_ms: u32, x: f64, event: Event<16>) -> TimedEvent {
        TimedEvent {
            at: Millis::from_ms(at_ms),
            age_ms: 0,
            place: Point::new(x, 0.0),
            ring: core::f64::consts::FRAC_PI_2,
            event,
        }
    }

    #[test]
    fn echoes_of_one_place_and_time_are_delivered_together_with_the_motion_goal_there() {
        let echo = |at_ms, x, sensor| {
            event(
                at_ms,
                x,
                Event::Echo {
                    sensor,
                    range: None,
                },
            )
        };
        let odometry = event(
            100,
            0.1,
            Event::Odometry {
                motion: 1,
                moved: Displacement::ZERO,
                turned: Bearing::ZERO,
                progress: Progress::Ended,
            },
        );
        let mut pilot = RecordingPilot {
            inputs: Vec::new(),
            moves_at: 5,
        };
        let events = [
            echo(40, 0.0, 0),
            echo(80, 0.0, 2),
            odometry,
            echo(120, 0.1, 3),
            echo(440, 0.1, 4),
            echo(441, 0.1, 5),
            TimedEvent {
                age_ms: 7,
                ..echo(900, 0.1, 6)
            },
        ];
        let result = deliver(&mut pilot, &events);
        assert_eq!(
            pilot.inputs,
            [
                (80, vec![(0, 40), (2, 0)]),
                (100, vec![]),
                (440, vec![(3, 320), (4, 0)]),
                (441, vec![(5, 0)]),
                (900, vec![(6, 7)]),
            ]
        );
        // 100 mm along a ring that points along y.
        let goal = result.motion.map(|(goal, _)| goal);
        assert!(goal.is_some_and(|goal| goal.distance(Point::new(0.1, 0.1)) < 1e-12));
    }
}
