//! Shows a log: the controller is replayed, and its maps and plans are visible at any time.
//!
//! Going back replays from the beginning; ten thousand decisions take a fifth of a second. Every
//! answer is compared with the log's, as [`replay`](remote::log::replay()) does.

mod parts;
mod timeline;

use super::command::{CommandOutcome, PageCommand};
use super::configure::knowledge_file;
use super::dto::KnowledgeParts;
use super::echo_trail::EchoTrail;
use super::goal::ActiveGoal;
use super::snapshot::{SceneDto, ShapeDto, Snapshot, SnapshotPart};
use super::source::{Capabilities, CommandRefused, StepOutcome, ViewSource};
use crate::snapshot::DriveCounts;
use amp::controller::{Decision, Mode, Progress};
use amp::scan::Situation;
use arena::robot::COLLISION_RADIUS_M;
use arena::world::{Point, Pose};
use files::error::BadInput;
use remote::log::{AnswerRecord, EventKind, EventRecord, LogFile, Replayer, SetupRecord};
use sim::coverage::Coverage;
use std::sync::Arc;
use timeline::{Timeline, TimelineItem};

/// Longer pauses are shortened to this, s; the robot was carried.
const LONGEST_WAIT_S: f64 = 2.0;

/// A time without a pose is divided into steps of this length, s.
const LONGEST_STEP_S: f64 = 0.2;

/// A log that is watched.
pub struct WatchedLog {
    timeline: Timeline,
    /// Index of the next item.
    at: usize,
    playback: Playback,
    cache: LogCache,
}

/// Parts of the latest snapshot, and the number of snapshots.
#[derive(Default)]
struct LogCache {
    revision: u64,
    scene: Option<(u32, Arc<SnapshotPart<SceneDto>>)>,
    knowledge: KnowledgeParts,
}

/// Robot and controller at the current position.
struct Playback {
    setup: SetupRecord,
    replayer: Replayer,
    /// Number of starts so far.
    starts: usize,
    /// Number of changes of the surroundings.
    scene_changes: u32,
    /// Number of decisions so far.
    decided: usize,
    shapes: Arc<Vec<ShapeDto>>,
    start: Option<Point>,
    pose: Pose,
    scan_pose: Pose,
    leader: Option<Point>,
    ranges_m: [Option<f64>; 16],
    nest: Option<(Situation<16>, Point)>,
    decision: Option<Decision<16>>,
    before: Option<Situation<16>>,
    touched: bool,
    goal: Option<ActiveGoal>,
    counts: DriveCounts,
    distance_m: f64,
    coverage: Coverage,
    echo_trail: EchoTrail,
    time_s: f64,
    step_s: f64,
    /// The first difference between controller and log, in words.
    difference: Option<String>,
}

impl WatchedLog {
    /// Opens a log at its beginning.
    ///
    /// # Errors
    /// When it cannot be read or holds no decision.
    pub fn new(log: &LogFile) -> Result<Self, BadInput> {
        let timeline = Timeline::read(log)?;
        let playback = Playback::new(log.setup(), &timeline, EchoTrail::new());
        let mut recorded = Self {
            timeline,
            at: 0,
            playback,
            cache: LogCache::default(),
        };
        recorded.set_scene();
        Ok(recorded)
    }

    /// Applies the items before the first event; the robot stands at its first pose.
    fn set_scene(&mut self) {
        let mut items = self.timeline.items.iter();
        let first = items.find_map(|(_, item)| match item {
            TimelineItem::Pose(pose) => Some(*pose),
            _ => None,
        });
        while let Some((
            _,
            item @ (TimelineItem::Start(_) | TimelineItem::Shapes(_) | TimelineItem::Leader(_)),
        )) = self.timeline.items.get(self.at)
        {
            self.playback.take(item, &self.timeline);
            self.at += 1;
        }
        let pose = first.unwrap_or_default();
        (self.playback.pose, self.playback.scan_pose) = (pose, pose);
    }

    /// Advances to the next pose, or by the longest step.
    fn advance(&mut self) {
        let Some(&(began, _)) = self.timeline.items.get(self.at) else {
            return;
        };
        let playback = &mut self.playback;
        while let Some((time_ns, item)) = self.timeline.items.get(self.at) {
            let late = *time_ns > began.saturating_add((LONGEST_STEP_S * 1e9) as u64);
            let last = match item {
                TimelineItem::Event(_) | TimelineItem::Start(_) if late => break,
                TimelineItem::Pose(_) => true,
                _ => false,
            };
            playback.time_s = *time_ns as f64 / 1e9;
            playback.take(item, &self.timeline);
            self.at += 1;
            if last || playback.difference.is_some() {
                break;
            }
        }
        let rest = self.timeline.items.get(self.at..).unwrap_or(&[]);
        let now = rest.first().map_or(began, |(time_ns, _)| *time_ns);
        let took_s = now.saturating_sub(began) as f64 / 1e9;
        playback.step_s = took_s.min(LONGEST_WAIT_S);
        // As in a simulation, a step is executed when it is shown.
        if took_s < LONGEST_WAIT_S {
            let mut places = rest
                .iter()
                .take_while(|(_, item)| !matches!(item, TimelineItem::Start(_)));
            let next = places.find_map(|(_, item)| match item {
                TimelineItem::Pose(pose) => Some(*pose),
                _ => None,
            });
            playback.pose = next.unwrap_or(playback.pose);
        }
    }

    /// Jumps to a number of decisions.
    fn jump(&mut self, to: usize) {
        let to = to.min(self.timeline.decisions);
        if to < self.playback.decided || self.playback.difference.is_some() {
            self.at = 0;
            let setup = self.playback.setup.clone();
            self.playback =
                Playback::new(&setup, &self.timeline, self.playback.echo_trail.restarted());
            self.set_scene();
        }
        while self.playback.decided < to && !self.is_over() {
            self.advance();
        }
        self.cache.knowledge.invalidate();
        self.cache.scene = None;
    }

    fn is_over(&self) -> bool {
        self.at >= self.timeline.items.len() || self.playback.difference.is_some()
    }
}

impl Playback {
    fn new(setup: &SetupRecord, timeline: &Timeline, echo_trail: EchoTrail) -> Self {
        let [low, high] = timeline.bounds;
        Self {
            setup: setup.clone(),
            replayer: Replayer::new(setup),
            starts: 0,
            scene_changes: 0,
            decided: 0,
            shapes: Arc::default(),
            start: None,
            pose: Pose::default(),
            scan_pose: Pose::default(),
            leader: None,
            ranges_m: [None; 16],
            nest: None,
            decision: None,
            before: None,
            touched: false,
            goal: None,
            counts: DriveCounts::default(),
            distance_m: 0.0,
            coverage: Coverage::new((low, high), COLLISION_RADIUS_M),
            echo_trail,
            time_s: 0.0,
            step_s: 0.0,
            difference: None,
        }
    }

    fn take(&mut self, item: &TimelineItem, timeline: &Timeline) {
        match item {
            TimelineItem::Start(setup) => self.begin(setup, timeline),
            TimelineItem::Event(record) => {
                self.check_unlogged();
                self.add_echoes(record);
                let decision = &mut None;
                let applied = self.replayer.apply(record, |outputs| {
                    *decision = outputs.decision.or(*decision);
                });
                if let Err(why) = applied {
                    self.difference.get_or_insert(why);
                }
                if let Some(decision) = decision {
                    self.decide(decision);
                }
                self.pursue(&record.event);
            }
            TimelineItem::Answer(answer) => self.compare(answer),
            TimelineItem::Pose(pose) => self.set_pose(*pose),
            TimelineItem::Shapes(shapes) => {
                self.shapes = Arc::clone(shapes);
                self.scene_changes += 1;
            }
            TimelineItem::Leader(at) => self.leader = Some(*at),
        }
    }

    /// Reports an answer that the log lacks, before the next event.
    fn check_unlogged(&mut self) {
        if self.replayer.unlogged_answer().is_some() {
            self.differs();
        }
    }

    fn begin(&mut self, setup: &SetupRecord, timeline: &Timeline) {
        self.check_unlogged();
        let shapes = Arc::clone(&self.shapes);
        let mut next = Self::new(setup, timeline, self.echo_trail.restarted());
        next.difference = self.difference.take();
        (next.starts, next.decided) = (self.starts + 1, self.decided);
        (next.shapes, next.time_s) = (shapes, self.time_s);
        next.scene_changes = self.scene_changes + 1;
        *self = next;
    }

    fn add_echoes(&mut self, record: &EventRecord) {
        match &record.event {
            EventKind::Echoes(echoes) => {
                for echo in echoes {
                    let sensor = usize::from(echo.sensor);
                    let range_m = echo.range_mm.map(|mm| f64::from(mm) / 1e3);
                    if let Some(range) = self.ranges_m.get_mut(sensor) {
                        *range = range_m;
                    }
                    if let (true, Some(range_m)) = (self.shapes.is_empty(), range_m) {
                        self.echo_trail.add(self.pose, sensor, range_m);
                    }
                }
            }
            EventKind::Odometry {
                progress: Progress::Touched,
                ..
            } => {
                self.touched = true;
                match self.is_seeking() {
                    true => self.counts.contacts += 1,
                    false => self.counts.explored[1] += 1,
                }
            }
            _ => {}
        }
    }

    fn is_seeking(&self) -> bool {
        self.decision
            .is_some_and(|decision| decision.plan.is_some())
    }

    fn decide(&mut self, decision: &Decision<16>) {
        self.decided += 1;
        self.before = self.decision.map(|before| before.situation);
        self.decision = Some(*decision);
        self.touched = false;
        if !self.is_seeking() {
            self.counts.explored[0] += 1;
            return;
        }
        self.counts.steps += 1;
        self.counts.at_goal += u32::from(decision.at_goal);
        self.counts.shielded += u32::from(decision.allowed != decision.wanted);
    }

    /// Determines the goal after a change.
    fn pursue(&mut self, event: &EventKind) {
        if !matches!(event, EventKind::Seek(_) | EventKind::Resume) {
            return;
        }
        let controller = self.replayer.controller();
        if let Mode::Seek { goal } = controller.state().mode() {
            let nest = self
                .nest
                .map_or([amp::fixed::Weight::ZERO; 16], |(nest, _)| nest);
            let goal = ActiveGoal::recognize(goal, controller.config(), &nest, controller.state());
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
                "after {} decisions, at {:.1} s, this program's controller does not do what the log says",
                self.decided, self.time_s
            )
        });
    }

    fn set_pose(&mut self, pose: Pose) {
        let way_m = pose.position.distance(self.scan_pose.position);
        // The first pose is the start; a longer distance than a step was carried.
        let driven = self.start.is_some() && way_m < 0.6;
        if driven && self.is_seeking() {
            self.distance_m += way_m;
            self.coverage.sweep(self.scan_pose.position, pose.position);
        }
        (self.pose, self.scan_pose) = (pose, pose);
        if self.start.is_none() {
            self.start = Some(pose.position);
            self.scene_changes += 1;
        }
        if let (None, Some(decision)) = (&self.nest, &self.decision) {
            self.nest = Some((decision.situation, pose.position));
        }
    }
}

impl ViewSource for WatchedLog {
    fn abilities(&self) -> Capabilities {
        Capabilities {
            pace: true,
            save: true,
            jump: true,
            ..Capabilities::default()
        }
    }

    fn step(&mut self) -> StepOutcome {
        if self.is_over() {
            return StepOutcome::Idle;
        }
        let (decided, starts) = (self.playback.decided, self.playback.starts);
        let learned = self.learns();
        self.advance();
        let whole = self.playback.decided > decided;
        if whole || learned != self.learns() {
            self.cache.knowledge.invalidate_maps();
        }
        if starts != self.playback.starts {
            self.cache.knowledge.invalidate();
        }
        StepOutcome::Took {
            took_s: self.playback.step_s,
            whole,
        }
    }

    fn execute(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused> {
        let controller = self.playback.replayer.controller();
        match command {
            PageCommand::Jump { to } => self.jump(*to),
            PageCommand::SaveMind => {
                return Ok(knowledge_file(controller.config(), controller.state()));
            }
            // Stop is allowed for all, so it is no error here.
            PageCommand::Stop => {}
            _ => return Err("this is a recording: it cannot be steered".into()),
        }
        Ok(CommandOutcome::Done)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.parts()
    }
}

#[cfg(test)]
mod tests;
