//! The mind's thread: takes tasks one by one, says what came of each.

use super::feed::Happening;
use crate::episode::Failure;
use crate::pilot::Pilot;
use crate::world::Point;
use amp::controller::{Command, Event, Motion, Outputs};
use amp::units::{Millis, Range};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::Scope;
use std::time::{Duration, Instant};

/// What the mind is given to do.
pub(super) enum Task {
    /// To take note of what happened, in this order.
    Happenings(Vec<Happening>),
    /// To obey.
    Command(Millis, Command<16>),
    /// To make the maps; takes its time.
    Learn(Millis),
}

/// What came of a task.
pub(super) struct Thought {
    pub(super) outputs: Outputs<16>,
    /// The last motion asked for, and where it leads to in the robot's frame, m.
    pub(super) motion: Option<(Point, Motion)>,
}

/// The other end of the mind's thread, which ends with it.
pub(super) struct Mind {
    tasks: Sender<Task>,
    thoughts: Receiver<Result<Thought, Failure>>,
    /// Tasks in the air, and since when the eldest is.
    pending: u32,
    since: Instant,
    /// A thought on anything but the first command has come.
    begun: bool,
    answered: u32,
}

impl Mind {
    /// Starts the thread.
    pub(super) fn start<'scope>(
        scope: &'scope Scope<'scope, '_>,
        pilot: &'scope mut (impl Pilot + Send),
    ) -> Self {
        let (tasks, todo) = channel();
        let (done, thoughts) = channel();
        scope.spawn(move || think(pilot, &todo, &done));
        Self {
            tasks,
            thoughts,
            pending: 0,
            since: Instant::now(),
            begun: false,
            answered: 0,
        }
    }

    /// Gives it something to do; it does so in turn.
    pub(super) fn give(&mut self, task: Task) {
        if self.pending == 0 {
            self.since = Instant::now();
        }
        self.pending += 1;
        // A thread that is gone says so in `thought`.
        let _ = self.tasks.send(task);
    }

    /// What came of a task, if something has.
    pub(super) fn thought(&mut self) -> Option<Result<Thought, Failure>> {
        match self.thoughts.try_recv() {
            Ok(thought) => {
                self.pending = self.pending.saturating_sub(1);
                self.since = Instant::now();
                // The first is about the command to begin.
                self.begun = self.answered > 0;
                self.answered += 1;
                Some(thought)
            }
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(Failure::Silent)),
        }
    }

    /// Whether it has nothing to do.
    pub(super) fn is_idle(&self) -> bool {
        self.pending == 0
    }

    /// Whether the command to begin lies behind it.
    pub(super) fn has_begun(&self) -> bool {
        self.begun
    }

    /// How long it has been at what it does.
    pub(super) fn busy_for(&self) -> Duration {
        if self.is_idle() {
            Duration::ZERO
        } else {
            self.since.elapsed()
        }
    }

    /// Tells it to stand still, and waits until it has heard that.
    pub(super) fn finish(&mut self, at: Millis) {
        self.give(Task::Command(at, Command::Stop));
        while self.pending > 0 && self.thoughts.recv().is_ok() {
            self.pending -= 1;
        }
    }
}

fn think(pilot: &mut impl Pilot, todo: &Receiver<Task>, done: &Sender<Result<Thought, Failure>>) {
    while let Ok(task) = todo.recv() {
        let thought = match task {
            Task::Happenings(happenings) => hear(pilot, &happenings),
            Task::Command(at, command) => alone(pilot.handle(at, Event::Command(command))),
            Task::Learn(at) => learn(pilot, at),
        };
        let refused = thought.outputs.refusal.map(Failure::Refused);
        let failure = pilot.failure().or(refused);
        if done.send(failure.map_or(Ok(thought), Err)).is_err() {
            break;
        }
    }
}

fn alone(outputs: Outputs<16>) -> Thought {
    // A command asks for no motion but to stand.
    let motion = outputs.motion.map(|motion| (Point::default(), motion));
    Thought { outputs, motion }
}

/// Tells the mind what happened; echoes from one place go together.
fn hear(pilot: &mut impl Pilot, happenings: &[Happening]) -> Thought {
    let mut all = Thought {
        outputs: Outputs::NONE,
        motion: None,
    };
    let mut echoes: Vec<(u8, Option<Range>)> = Vec::new();
    for (number, happening) in happenings.iter().enumerate() {
        let Event::Echo { sensor, range } = happening.event else {
            all.add(happening, pilot.handle(happening.at, happening.event));
            continue;
        };
        echoes.push((sensor, range));
        let next = happenings.get(number + 1);
        if next.is_some_and(|next| matches!(next.event, Event::Echo { .. })) {
            continue;
        }
        let mut left = &echoes[..];
        while !left.is_empty() {
            let (taken, outputs) = pilot.echoes(happening.at, left);
            left = left.get(taken.max(1)..).unwrap_or(&[]);
            all.add(happening, outputs);
        }
        echoes.clear();
    }
    all
}

impl Thought {
    fn add(&mut self, happening: &Happening, outputs: Outputs<16>) {
        self.outputs.decision = self.outputs.decision.or(outputs.decision);
        self.outputs.mode_changed |= outputs.mode_changed;
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
    alone(outputs)
}
