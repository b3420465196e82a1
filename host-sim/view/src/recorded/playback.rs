//! The robot and the controller of a log, at one moment of it.

use super::timeline::{Timeline, TimelineItem};
use crate::echo_trail::EchoTrail;
use crate::goal::ActiveGoal;
use crate::place_frames::{PlaceFrames, SeenPlaces, heading};
use crate::snapshot::{DriveCounts, ShapeDto, SourceDto, Xy};
use amp::controller::{Decision, Mode, Progress};
use amp::places::Aim;
use amp::scan::Situation;
use amp::units::{Displacement, Millis};
use arena::robot::COLLISION_RADIUS_M;
use arena::world::{Point, Pose};
use remote::log::{AnswerRecord, EventKind, EventRecord, Replayer, SetupRecord};
use sim::behavior::{Behavior, Tour};
use sim::coverage::Coverage;
use sim::senses::SenseGoal;
use sim::turret_pilot::SimTurret;
use std::sync::Arc;

/// A robot that heard nothing for so long may have been carried, ms.
const SILENCE_MS: u32 = 600_000;

/// What happens to the frame of the places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FrameChange {
    Begins,
    Carried,
    /// Its places are those of a file: it is carried among them, and knows with the next echo.
    Loaded,
}

/// Robot and controller at the current position.
pub(super) struct Playback {
    pub setup: SetupRecord,
    pub replayer: Replayer,
    /// Number of starts so far.
    pub starts: usize,
    /// Number of changes of the surroundings.
    pub scene_changes: u32,
    /// Number of decisions so far.
    pub decided: usize,
    pub shapes: Arc<Vec<ShapeDto>>,
    pub sources: Arc<Vec<SourceDto>>,
    pub start: Option<Point>,
    pub pose: Pose,
    /// Bearing of its front in its own frame when it was in that pose, rad. While a robot turns
    /// around the log has no pose of it.
    front: f64,
    pub scan_pose: Pose,
    pub leader: Option<Point>,
    pub ranges_m: [Option<f64>; 16],
    pub nest: Option<(Situation<16>, Point)>,
    pub decision: Option<Decision<16>>,
    pub before: Option<Situation<16>>,
    pub touched: bool,
    pub goal: Option<ActiveGoal>,
    pub counts: DriveCounts,
    pub distance_m: f64,
    pub coverage: Coverage,
    pub echo_trail: EchoTrail,
    pub time_s: f64,
    pub step_s: f64,
    /// Where its places lead the robot, and what it seeks in another modality.
    pub aim: Option<Aim>,
    pub sought: Option<SenseGoal>,
    frames: PlaceFrames,
    /// Its places begin anew, or it was carried, where the next pose is; the bearing of its
    /// front in its own frame, rad.
    moves_frame: Option<(FrameChange, f64)>,
    last_echo: Option<Millis>,
    /// The first difference between controller and log, in words.
    pub difference: Option<String>,
}

impl Playback {
    pub fn new(setup: &SetupRecord, timeline: &Timeline, echo_trail: EchoTrail) -> Self {
        let [low, high] = timeline.bounds;
        let robot = setup.robot.as_ref();
        let radius_m = robot.map_or(COLLISION_RADIUS_M, |robot| robot.radius_m);
        let is_mirrored = robot.is_some_and(|robot| robot.is_mirrored);
        let side = if is_mirrored { -1.0 } else { 1.0 };
        Self {
            setup: setup.clone(),
            replayer: Replayer::new(setup),
            starts: 0,
            scene_changes: 0,
            decided: 0,
            shapes: Arc::default(),
            sources: Arc::default(),
            start: None,
            pose: Pose::default(),
            front: 0.0,
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
            coverage: Coverage::new((low, high), radius_m),
            echo_trail,
            time_s: 0.0,
            step_s: 0.0,
            aim: None,
            sought: None,
            frames: PlaceFrames::new(Pose::default(), side),
            moves_frame: None,
            last_echo: None,
            difference: None,
        }
    }

    /// Points and places of a robot that its places lead to goals.
    fn turret(&self) -> Option<&SimTurret> {
        self.replayer.controller().as_turret()?.led_turret()
    }

    /// Its places, in the world, once it is known where they are.
    pub fn seen_places(&self) -> Option<SeenPlaces<'_>> {
        Some((self.frames).seen(self.turret()?, self.pose, self.front))
    }

    /// The way that its places lead it, if they do.
    pub fn way(&self) -> Option<Vec<Xy>> {
        let stays = self.decision.is_some_and(|decision| decision.at_goal);
        let state = self.replayer.controller().state();
        let seeks = matches!(state.mode(), Mode::Seek { .. }) && self.frames.is_current();
        let places = self.seen_places()?;
        (seeks && !stays && state.is_led()).then(|| places.way())
    }

    pub fn take(&mut self, item: &TimelineItem, timeline: &Timeline) {
        match item {
            TimelineItem::Start(setup) => self.begin(setup, timeline),
            TimelineItem::Event(record) => {
                self.check_unlogged();
                self.add_echoes(record);
                self.note_silence(record);
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
                self.note_places(&record.event);
                self.pursue(&record.event);
            }
            TimelineItem::Answer(answer) => self.compare(answer),
            TimelineItem::Pose(pose) => self.set_pose(*pose),
            TimelineItem::World(shapes, sources) => {
                (self.shapes, self.sources) = (Arc::clone(shapes), Arc::clone(sources));
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
        let (shapes, sources) = (Arc::clone(&self.shapes), Arc::clone(&self.sources));
        let mut next = Self::new(setup, timeline, self.echo_trail.restarted());
        next.difference = self.difference.take();
        (next.starts, next.decided) = (self.starts + 1, self.decided);
        (next.shapes, next.sources, next.time_s) = (shapes, sources, self.time_s);
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

    /// A robot that heard nothing for so long may have been carried.
    fn note_silence(&mut self, record: &EventRecord) {
        if !matches!(record.event, EventKind::Echoes(_)) {
            return;
        }
        let at = Millis::from_ms(record.at_ms);
        let silence = self.last_echo.map(|last| at.since(last));
        if silence.is_some_and(|silence| silence >= SILENCE_MS) {
            self.moves_frame = Some((FrameChange::Carried, self.heading()));
            self.frames.lose();
        }
        self.last_echo = Some(at);
    }

    /// What the event changes of where the robot is led.
    fn note_places(&mut self, event: &EventKind) {
        match event {
            EventKind::Explore { .. } if self.explores() => {
                self.moves_frame = Some((FrameChange::Begins, self.heading()));
            }
            EventKind::Know(_) => {
                self.moves_frame = Some((FrameChange::Loaded, self.heading()));
                self.frames.lose();
            }
            EventKind::Echoes(_) if self.moves_frame.is_none() => self.settle_places(),
            EventKind::LeadTo(aim) => self.aim = *aim,
            EventKind::SeekSense(goal) => {
                self.sought = goal.as_ref().and_then(|goal| goal.parse().ok());
            }
            _ => {}
        }
    }

    fn explores(&self) -> bool {
        let mode = self.replayer.controller().state().mode();
        matches!(mode, Mode::Explore { .. })
    }

    fn heading(&self) -> f64 {
        self.turret().map_or(0.0, heading)
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
            let goal = self.led_goal().unwrap_or_else(|| {
                ActiveGoal::recognize(goal, controller.config(), &nest, controller.state())
            });
            self.goal = Some(goal);
        }
    }

    /// The goal that its places lead the robot to, if it is no situation.
    fn led_goal(&self) -> Option<ActiveGoal> {
        let tour = Tour::NONE;
        if let Some(goal) = self.sought {
            return Some(ActiveGoal::behavior(&Behavior::Sense { goal, tour }));
        }
        let Some(Aim::Position(position)) = self.aim else {
            return None;
        };
        if position != Displacement::ZERO {
            let place = self.seen_places()?.reached(position);
            return Some(ActiveGoal::position_of(place));
        }
        let behavior = self.setup.behavior.parse::<Behavior>().ok();
        let nest = behavior.filter(|behavior| matches!(behavior, Behavior::Nest { .. }));
        let behavior = nest.unwrap_or(Behavior::Home { tour });
        Some(ActiveGoal::behavior(&behavior))
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
        let was_carried = self.move_frame(pose);
        let driven = self.start.is_some() && way_m < 0.6 && !was_carried;
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

    /// The step that was taken ended here.
    pub fn end_step(&mut self, pose: Pose) {
        (self.pose, self.front) = (pose, self.heading());
    }

    /// Returns whether the robot was carried here.
    fn move_frame(&mut self, pose: Pose) -> bool {
        let Some((change, heading)) = self.moves_frame.take() else {
            return false;
        };
        match change {
            FrameChange::Begins => self.frames.begin(pose, heading),
            FrameChange::Carried => {
                self.frames.carry(pose, heading);
                self.settle_places();
            }
            FrameChange::Loaded => {
                self.frames.begin(pose, heading);
                self.frames.carry(pose, heading);
            }
        }
        change != FrameChange::Begins
    }

    fn settle_places(&mut self) {
        let mut frames = self.frames;
        if let Some(turret) = self.turret() {
            frames.settle(turret);
        }
        self.frames = frames;
    }
}
