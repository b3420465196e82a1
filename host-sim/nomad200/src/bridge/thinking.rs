//! The mind's thread: takes tasks one by one, says what came of each.

use super::feed::Happening;
use amp::config::Config;
use amp::controller::{Command, Event, Motion, Outputs};
use amp::units::Millis;
use arena::world::Point;
use remote::log::LoggedController;
use sim::error::EpisodeError;
use sim::pilot::{HeardEcho, Pilot, SimState};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Echoes within this time are told together, ms: half a ring. A mind that is told of more at once believes that its ring
/// has been silent.
const SAME_TIME_MS: u32 = 320;

/// What the mind is given to do.
pub(super) enum Task {
    /// To take note of what happened, in this order.
    Happenings(Vec<Happening>),
    /// To obey.
    Command(Millis, Command<16>),
    /// To make the maps; takes its time.
    Learn(Millis),
    /// To choose otherwise from now on.
    Configure(Millis, Box<Config<16>>),
    /// To tell what it knows.
    Tell,
}

/// What a thought is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// What happened.
    Happenings,
    /// A command.
    Command,
    /// The maps are made.
    Learning,
    /// Other open choices, or a question.
    Else,
}

/// What came of a task.
pub struct Thought {
    /// What the task was.
    pub about: About,
    /// What it brought about.
    pub outputs: Outputs<16>,
    /// The last motion asked for, and where it leads to in the robot's frame, m.
    pub(super) motion: Option<(Point, Motion)>,
    /// What the mind knows, if it was asked.
    pub known: Option<Box<SimState>>,
}

/// The other end of the mind's thread, which ends with it.
pub(super) struct Mind {
    tasks: Option<Sender<Task>>,
    thoughts: Receiver<Result<Thought, EpisodeError>>,
    thread: Option<JoinHandle<()>>,
    /// Tasks in the air, and since when the eldest is.
    pending: u32,
    since: Instant,
}

impl Mind {
    /// Starts the thread.
    pub(super) fn start(pilot: LoggedController) -> Self {
        let (tasks, todo) = channel();
        let (done, thoughts) = channel();
        let thread = std::thread::spawn(move || think(pilot, &todo, &done));
        Self {
            tasks: Some(tasks),
            thoughts,
            thread: Some(thread),
            pending: 0,
            since: Instant::now(),
        }
    }

    /// Gives it something to do; it does so in turn.
    pub(super) fn give(&mut self, task: Task) {
        if self.pending == 0 {
            self.since = Instant::now();
        }
        self.pending += 1;
        if let Some(tasks) = &self.tasks {
            // A thread that is gone says so in `thought`.
            let _ = tasks.send(task);
        }
    }

    /// What came of a task, if something has.
    pub(super) fn thought(&mut self) -> Option<Result<Thought, EpisodeError>> {
        match self.thoughts.try_recv() {
            Ok(thought) => {
                self.pending = self.pending.saturating_sub(1);
                self.since = Instant::now();
                Some(thought)
            }
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(EpisodeError::Silent)),
        }
    }

    /// Whether it has nothing to do.
    pub(super) fn is_idle(&self) -> bool {
        self.pending == 0
    }

    /// How long it has been at what it does.
    pub(super) fn busy_for(&self) -> Duration {
        if self.is_idle() {
            Duration::ZERO
        } else {
            self.since.elapsed()
        }
    }

    /// Ends its thread; before, it is told to stand still at a time, and waited for until it has heard that.
    pub(super) fn finish(&mut self, at: Option<Millis>) {
        if let Some(at) = at {
            self.give(Task::Command(at, Command::Stop));
        }
        self.tasks = None;
        if let Some(thread) = self.thread.take() {
            // It has panicked at worst, and said so.
            let _ = thread.join();
        }
    }
}

fn think(
    mut pilot: LoggedController,
    todo: &Receiver<Task>,
    done: &Sender<Result<Thought, EpisodeError>>,
) {
    while let Ok(task) = todo.recv() {
        let thought = obey(&mut pilot, task);
        let thought = pilot.failure().map_or(thought, Err);
        if done.send(thought).is_err() {
            break;
        }
    }
}

fn obey(pilot: &mut LoggedController, task: Task) -> Result<Thought, EpisodeError> {
    Ok(match task {
        Task::Happenings(happenings) => hear(pilot, &happenings),
        Task::Command(at, command) => {
            Thought::of(About::Command, pilot.handle(at, Event::Command(command)))
        }
        Task::Learn(at) => learn(pilot, at),
        Task::Configure(at, config) => {
            pilot.configure(at, &config).map_err(EpisodeError::from)?;
            Thought::of(About::Else, Outputs::NONE)
        }
        Task::Tell => {
            pilot.pilot().invalidate_cache(true);
            let known = Box::new(pilot.pilot().cached_state()?.clone());
            Thought {
                known: Some(known),
                ..Thought::of(About::Else, Outputs::NONE)
            }
        }
    })
}

/// Tells the mind what happened; echoes from one place and about one time go together, at the time of the last, each with
/// its age.
pub(super) fn hear(pilot: &mut impl Pilot, happenings: &[Happening]) -> Thought {
    let mut all = Thought::of(About::Happenings, Outputs::NONE);
    for group in happenings.chunk_by(|_, next| is_echo(next)) {
        // What is no echo begins a group.
        let (first, echoes) = match group.split_first() {
            Some((first, echoes)) if !is_echo(first) => (Some(first), echoes),
            _ => (None, group),
        };
        if let Some(first) = first {
            all.add(first, pilot.handle(first.at, first.event));
        }
        let mut left = echoes;
        while let Some(first) = left.first() {
            let near = |happening: &&Happening| happening.at.since(first.at) <= SAME_TIME_MS;
            let count = left.iter().take_while(near).count().max(1);
            let (together, rest) = left.split_at(count);
            all.hear(pilot, together);
            left = rest;
        }
    }
    all
}

fn is_echo(happening: &Happening) -> bool {
    matches!(happening.event, Event::Echo { .. })
}

impl Thought {
    /// What came of something that happened nowhere: it asks for no motion but to stand.
    fn of(about: About, outputs: Outputs<16>) -> Self {
        Self {
            about,
            outputs,
            motion: outputs.motion.map(|motion| (Point::default(), motion)),
            known: None,
        }
    }

    /// Echoes heard from one place.
    fn hear(&mut self, pilot: &mut impl Pilot, happenings: &[Happening]) {
        let Some(last) = happenings.last() else {
            return;
        };
        let echo = |happening: &Happening| match happening.event {
            Event::Echo { sensor, range } => Some(HeardEcho {
                sensor,
                range,
                age_ms: last.at.since(happening.at) + happening.age_ms,
            }),
            _ => None,
        };
        let echoes: Vec<_> = happenings.iter().filter_map(echo).collect();
        let mut left = &echoes[..];
        while !left.is_empty() {
            let (taken, outputs) = pilot.echoes(last.at, left);
            left = left.get(taken.max(1)..).unwrap_or(&[]);
            self.add(last, outputs);
        }
    }

    fn add(&mut self, happening: &Happening, outputs: Outputs<16>) {
        self.outputs.decision = self.outputs.decision.or(outputs.decision);
        self.outputs.mode_changed |= outputs.mode_changed;
        self.outputs.stopped = self.outputs.stopped.or(outputs.stopped);
        self.outputs.refusal = self.outputs.refusal.or(outputs.refusal);
        if let Some(motion) = outputs.motion {
            let [x, y] = [motion.displacement.dx_mm, motion.displacement.dy_mm];
            let way = Point::new(f64::from(x), f64::from(y)) * 1e-3;
            let goal = happening.place + way.turned(Point::unit(happening.ring));
            self.outputs.motion = Some(motion);
            self.motion = Some((goal, motion));
        }
    }
}

fn learn(pilot: &mut impl Pilot, at: Millis) -> Thought {
    let mut outputs = pilot.handle(at, Event::Command(Command::Learn));
    outputs.mode_changed = false;
    while pilot.failure().is_none() && outputs.refusal.is_none() && !outputs.mode_changed {
        outputs = pilot.handle(at, Event::Tick);
    }
    Thought::of(About::Learning, outputs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::controller::Progress;
    use amp::units::{Bearing, Displacement};

    /// Notes what it is told, as (time, transducers with the ages of what they heard), and asks for a motion at the sonar of
    /// that number.
    struct Noting {
        told: Vec<(u32, Vec<(u8, u32)>)>,
        moves_at: u8,
    }

    impl Pilot for Noting {
        fn handle(&mut self, at: Millis, _: Event<16>) -> Outputs<16> {
            self.told.push((at.as_ms(), Vec::new()));
            Outputs::NONE
        }

        fn echoes(&mut self, at: Millis, echoes: &[HeardEcho]) -> (usize, Outputs<16>) {
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
            self.told.push((at.as_ms(), sensors));
            let outputs = Outputs {
                motion,
                ..Outputs::NONE
            };
            (echoes.len(), outputs)
        }
    }

    fn happening(at_ms: u32, x: f64, event: Event<16>) -> Happening {
        Happening {
            at: Millis::from_ms(at_ms),
            age_ms: 0,
            place: Point::new(x, 0.0),
            ring: core::f64::consts::FRAC_PI_2,
            event,
        }
    }

    #[test]
    fn echoes_of_one_place_and_time_go_together_and_a_motion_begins_where_it_was_asked_for() {
        let echo = |at_ms, x, sensor| {
            happening(
                at_ms,
                x,
                Event::Echo {
                    sensor,
                    range: None,
                },
            )
        };
        let odometry = happening(
            100,
            0.1,
            Event::Odometry {
                motion: 1,
                moved: Displacement::ZERO,
                turned: Bearing::ZERO,
                progress: Progress::Ended,
            },
        );
        let mut pilot = Noting {
            told: Vec::new(),
            moves_at: 5,
        };
        let happenings = [
            echo(40, 0.0, 0),
            echo(80, 0.0, 2),
            odometry,
            echo(120, 0.1, 3),
            echo(440, 0.1, 4),
            echo(441, 0.1, 5),
            Happening {
                age_ms: 7,
                ..echo(900, 0.1, 6)
            },
        ];
        let thought = hear(&mut pilot, &happenings);
        assert_eq!(
            pilot.told,
            [
                (80, vec![(0, 40), (2, 0)]),
                (100, vec![]),
                (440, vec![(3, 320), (4, 0)]),
                (441, vec![(5, 0)]),
                (900, vec![(6, 7)]),
            ]
        );
        // 100 mm along a ring that looks along y.
        let goal = thought.motion.map(|(goal, _)| goal);
        assert!(goal.is_some_and(|goal| goal.distance(Point::new(0.1, 0.1)) < 1e-12));
    }
}
