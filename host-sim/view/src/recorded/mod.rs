//! A log as a source: the mind is told again what it was told then, and everything it thinks can be seen, at any moment.
//!
//! Going back begins from the start: ten thousand decisions are told in a fifth of a second. Every answer is compared with
//! that of the log, as [`replay`](remote::log::replay()) does.

mod parts;
mod tape;

use super::choices::mind_file;
use super::goal::Pursued;
use super::heard::Heard;
use super::order::{Done, Order};
use super::seen::Knowing;
use super::snapshot::{Part, Scene, ShapeSeen, Snapshot};
use super::source::{Abilities, Refused, Source, Stepped};
use crate::snapshot::Counts;
use amp::controller::{Decision, Mode, Progress};
use amp::scan::Situation;
use arena::robot::COLLISION_RADIUS_M;
use arena::world::{Point, Pose};
use files::error::BadInput;
use remote::log::{AnswerRecord, EventKind, EventRecord, LogFile, Replayer, SetupRecord};
use sim::coverage::Coverage;
use std::sync::Arc;
use tape::{Item, Tape};

/// A longer time in which nothing happens passes like this one, s: somebody carried the robot.
const LONGEST_WAIT_S: f64 = 2.0;

/// What is without a pose for so long is a step all the same, s.
const LONGEST_STEP_S: f64 = 0.2;

/// A recorded robot.
pub struct Recorded {
    tape: Tape,
    /// Items that lie behind.
    at: usize,
    playing: Playing,
    shown: Shown,
}

/// Parts that were made already, and how often anything has changed.
#[derive(Default)]
struct Shown {
    revision: u64,
    scene: Option<(u32, Arc<Part<Scene>>)>,
    knowing: Knowing,
}

/// The robot and its mind at a moment of the recording.
struct Playing {
    setup: SetupRecord,
    replayer: Replayer,
    /// Starts so far.
    starts: usize,
    /// How often what stands around has changed.
    scene_changes: u32,
    /// Decisions so far.
    decided: usize,
    shapes: Arc<Vec<ShapeSeen>>,
    start: Option<Point>,
    pose: Pose,
    heard_at: Pose,
    leader: Option<Point>,
    ranges_m: [Option<f64>; 16],
    nest: Option<(Situation<16>, Point)>,
    decision: Option<Decision<16>>,
    before: Option<Situation<16>>,
    touched: bool,
    goal: Option<Pursued>,
    counts: Counts,
    distance_m: f64,
    coverage: Coverage,
    heard: Heard,
    time_s: f64,
    step_s: f64,
    /// Where the mind decides otherwise than the log says, in words.
    difference: Option<String>,
}

impl Recorded {
    /// A log from its beginning.
    ///
    /// # Errors
    /// When it cannot be read as one, or nothing was decided.
    pub fn new(log: &LogFile) -> Result<Self, BadInput> {
        let tape = Tape::read(log)?;
        let playing = Playing::new(log.setup(), &tape, Heard::new());
        let mut recorded = Self {
            tape,
            at: 0,
            playing,
            shown: Shown::default(),
        };
        recorded.set_scene();
        Ok(recorded)
    }

    /// What is there before anything happens; the robot stands where it will first be seen.
    fn set_scene(&mut self) {
        let mut items = self.tape.items.iter();
        let first = items.find_map(|(_, item)| match item {
            Item::Pose(pose) => Some(*pose),
            _ => None,
        });
        while let Some((_, item @ (Item::Start(_) | Item::Shapes(_) | Item::Leader(_)))) =
            self.tape.items.get(self.at)
        {
            self.playing.take(item, &self.tape);
            self.at += 1;
        }
        let pose = first.unwrap_or_default();
        (self.playing.pose, self.playing.heard_at) = (pose, pose);
    }

    /// Goes on to the next place of the robot, or for as long as a step may be.
    fn go_on(&mut self) {
        let Some(&(began, _)) = self.tape.items.get(self.at) else {
            return;
        };
        let playing = &mut self.playing;
        while let Some((time_ns, item)) = self.tape.items.get(self.at) {
            let late = *time_ns > began.saturating_add((LONGEST_STEP_S * 1e9) as u64);
            let last = match item {
                Item::Event(_) | Item::Start(_) if late => break,
                Item::Pose(_) => true,
                _ => false,
            };
            playing.time_s = *time_ns as f64 / 1e9;
            playing.take(item, &self.tape);
            self.at += 1;
            if last || playing.difference.is_some() {
                break;
            }
        }
        let rest = self.tape.items.get(self.at..).unwrap_or(&[]);
        let now = rest.first().map_or(began, |(time_ns, _)| *time_ns);
        let took_s = now.saturating_sub(began) as f64 / 1e9;
        playing.step_s = took_s.min(LONGEST_WAIT_S);
        // As in a simulation, a step was made when it is shown.
        if took_s < LONGEST_WAIT_S {
            let mut places = rest
                .iter()
                .take_while(|(_, item)| !matches!(item, Item::Start(_)));
            let next = places.find_map(|(_, item)| match item {
                Item::Pose(pose) => Some(*pose),
                _ => None,
            });
            playing.pose = next.unwrap_or(playing.pose);
        }
    }

    /// Goes to where so many decisions have been taken.
    fn jump(&mut self, to: usize) {
        let to = to.min(self.tape.decisions);
        if to < self.playing.decided || self.playing.difference.is_some() {
            self.at = 0;
            let setup = self.playing.setup.clone();
            self.playing = Playing::new(&setup, &self.tape, self.playing.heard.afresh());
            self.set_scene();
        }
        while self.playing.decided < to && !self.is_over() {
            self.go_on();
        }
        self.shown.knowing.forget();
        self.shown.scene = None;
    }

    fn is_over(&self) -> bool {
        self.at >= self.tape.items.len() || self.playing.difference.is_some()
    }
}

impl Playing {
    fn new(setup: &SetupRecord, tape: &Tape, heard: Heard) -> Self {
        let [low, high] = tape.bounds;
        Self {
            setup: setup.clone(),
            replayer: Replayer::new(setup),
            starts: 0,
            scene_changes: 0,
            decided: 0,
            shapes: Arc::default(),
            start: None,
            pose: Pose::default(),
            heard_at: Pose::default(),
            leader: None,
            ranges_m: [None; 16],
            nest: None,
            decision: None,
            before: None,
            touched: false,
            goal: None,
            counts: Counts::default(),
            distance_m: 0.0,
            coverage: Coverage::new((low, high), COLLISION_RADIUS_M),
            heard,
            time_s: 0.0,
            step_s: 0.0,
            difference: None,
        }
    }

    fn take(&mut self, item: &Item, tape: &Tape) {
        match item {
            Item::Start(setup) => self.begin(setup, tape),
            Item::Event(record) => {
                self.unsaid();
                self.hear(record);
                let decision = &mut None;
                let told = self.replayer.apply(record, |outputs| {
                    *decision = outputs.decision.or(*decision);
                });
                if let Err(why) = told {
                    self.difference.get_or_insert(why);
                }
                if let Some(decision) = decision {
                    self.decide(decision);
                }
                self.pursue(&record.event);
            }
            Item::Answer(answer) => self.compare(answer),
            Item::Pose(pose) => self.stand(*pose),
            Item::Shapes(shapes) => {
                self.shapes = Arc::clone(shapes);
                self.scene_changes += 1;
            }
            Item::Leader(at) => self.leader = Some(*at),
        }
    }

    /// What it said and the log does not, before it is told something else.
    fn unsaid(&mut self) {
        if self.replayer.unlogged_answer().is_some() {
            self.differs();
        }
    }

    fn begin(&mut self, setup: &SetupRecord, tape: &Tape) {
        self.unsaid();
        let shapes = Arc::clone(&self.shapes);
        let mut next = Self::new(setup, tape, self.heard.afresh());
        next.difference = self.difference.take();
        (next.starts, next.decided) = (self.starts + 1, self.decided);
        (next.shapes, next.time_s) = (shapes, self.time_s);
        next.scene_changes = self.scene_changes + 1;
        *self = next;
    }

    fn hear(&mut self, record: &EventRecord) {
        match &record.event {
            EventKind::Echoes(echoes) => {
                for echo in echoes {
                    let sensor = usize::from(echo.sensor);
                    let range_m = echo.range_mm.map(|mm| f64::from(mm) / 1e3);
                    if let Some(range) = self.ranges_m.get_mut(sensor) {
                        *range = range_m;
                    }
                    if let (true, Some(range_m)) = (self.shapes.is_empty(), range_m) {
                        self.heard.hear(self.pose, sensor, range_m);
                    }
                }
            }
            EventKind::Odometry {
                progress: Progress::Touched,
                ..
            } => {
                self.touched = true;
                match self.seeks() {
                    true => self.counts.contacts += 1,
                    false => self.counts.explored[1] += 1,
                }
            }
            _ => {}
        }
    }

    fn seeks(&self) -> bool {
        self.decision
            .is_some_and(|decision| decision.plan.is_some())
    }

    fn decide(&mut self, decision: &Decision<16>) {
        self.decided += 1;
        self.before = self.decision.map(|before| before.situation);
        self.decision = Some(*decision);
        self.touched = false;
        if !self.seeks() {
            self.counts.explored[0] += 1;
            return;
        }
        self.counts.steps += 1;
        self.counts.at_goal += u32::from(decision.at_goal);
        self.counts.shielded += u32::from(decision.allowed != decision.wanted);
    }

    /// Finds out what is pursued when that has changed.
    fn pursue(&mut self, event: &EventKind) {
        if !matches!(event, EventKind::Seek(_) | EventKind::Resume) {
            return;
        }
        let mind = self.replayer.controller();
        if let Mode::Seek { goal } = mind.state().mode() {
            let nest = self
                .nest
                .map_or([amp::fixed::Weight::ZERO; 16], |(nest, _)| nest);
            let goal = Pursued::recognized(goal, mind.config(), &nest, mind.state());
            self.goal = Some(goal);
        }
    }

    fn compare(&mut self, logged: &AnswerRecord) {
        if self.replayer.compare(logged).is_some() {
            self.differs();
        }
    }

    fn differs(&mut self) {
        self.difference.get_or_insert_with(|| {
            format!(
                "after {} decisions, at {:.1} s, this program's mind does not do what the log says",
                self.decided, self.time_s
            )
        });
    }

    fn stand(&mut self, pose: Pose) {
        let way_m = pose.position.distance(self.heard_at.position);
        // The first place is where it starts; what is farther than a step was carried.
        let driven = self.start.is_some() && way_m < 0.6;
        if driven && self.seeks() {
            self.distance_m += way_m;
            self.coverage.sweep(self.heard_at.position, pose.position);
        }
        (self.pose, self.heard_at) = (pose, pose);
        if self.start.is_none() {
            self.start = Some(pose.position);
            self.scene_changes += 1;
        }
        if let (None, Some(decision)) = (&self.nest, &self.decision) {
            self.nest = Some((decision.situation, pose.position));
        }
    }
}

impl Source for Recorded {
    fn abilities(&self) -> Abilities {
        Abilities {
            pace: true,
            save: true,
            jump: true,
            ..Abilities::default()
        }
    }

    fn step(&mut self) -> Stepped {
        if self.is_over() {
            return Stepped::Standing;
        }
        let (decided, starts) = (self.playing.decided, self.playing.starts);
        let learned = self.learns();
        self.go_on();
        let whole = self.playing.decided > decided;
        if whole || learned != self.learns() {
            self.shown.knowing.forget_maps();
        }
        if starts != self.playing.starts {
            self.shown.knowing.forget();
        }
        Stepped::Took {
            took_s: self.playing.step_s,
            whole,
        }
    }

    fn carry_out(&mut self, order: &Order) -> Result<Done, Refused> {
        let mind = self.playing.replayer.controller();
        match order {
            Order::Jump { to } => self.jump(*to),
            Order::SaveMind => return Ok(mind_file(mind.config(), mind.state())),
            // Whoever may stop a robot may press the key here too.
            Order::Stop => {}
            _ => return Err("this is a recording: it cannot be steered".into()),
        }
        Ok(Done::Well)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.parts()
    }
}

#[cfg(test)]
mod tests;
