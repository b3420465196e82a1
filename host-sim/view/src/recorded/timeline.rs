//! A log as a list of items, with the history of its decisions.

use crate::dto::{shape_dto, source_dtos};
use crate::history::{History, history_entry};
use crate::snapshot::{ShapeDto, SourceDto};
use amp::controller::Progress;
use arena::world::{Point, Pose};
use files::error::BadInput;
use remote::log::{
    AnswerRecord, Ending, EventKind, EventRecord, LogFile, LogMessage, SceneChange, SetupRecord,
    channel, pose_of, scene_changes,
};
use sim::episode::StepFlags;
use std::sync::Arc;

/// An item of a log.
pub(super) enum TimelineItem {
    /// A controller without knowledge starts.
    Start(Box<SetupRecord>),
    /// An input of the controller.
    Event(EventRecord),
    /// Its answer.
    Answer(Box<AnswerRecord>),
    /// The true pose of the robot.
    Pose(Pose),
    /// The surroundings, and what else can be perceived there.
    World(Arc<Vec<ShapeDto>>, Arc<Vec<SourceDto>>),
    /// Position of a second robot.
    Leader(Point),
}

/// A log in memory.
pub(super) struct Timeline {
    /// The items with their time since the log began, ns.
    pub items: Vec<(u64, TimelineItem)>,
    /// Every decision; a chunk ends at each start.
    pub trail: History,
    /// Number of decisions.
    pub decisions: usize,
    /// First chunk of each start.
    pub starts: Vec<u64>,
    /// Lower left and upper right corner.
    pub bounds: [Point; 2],
    /// How the log ends.
    pub ending: Ending,
}

impl Timeline {
    /// Reads a log.
    ///
    /// # Errors
    /// When a message does not match its channel, or there is no decision.
    pub fn read(log: &LogFile) -> Result<Self, BadInput> {
        let mut items = Vec::new();
        for message in log.messages() {
            let added = items_of(&message).map_err(|why| BadInput::file(log.path(), why))?;
            items.extend(added.into_iter().map(|item| (message.time_ns, item)));
        }
        let mut builder = HistoryBuilder::new();
        items
            .iter()
            .for_each(|(time_ns, item)| builder.add(*time_ns, item));
        builder.end();
        if builder.decisions == 0 {
            return Err(BadInput::file(log.path(), "holds no decision"));
        }
        Ok(Self {
            bounds: bounds(&items),
            items,
            trail: builder.trail,
            decisions: builder.decisions,
            starts: builder.starts,
            ending: log.ending(),
        })
    }
}

/// The items of a message.
fn items_of(message: &LogMessage) -> Result<Vec<TimelineItem>, String> {
    Ok(match message.topic.as_str() {
        channel::SETUP => vec![TimelineItem::Start(Box::new(message.content()?))],
        channel::EVENT => vec![TimelineItem::Event(message.content()?)],
        channel::PLAN => vec![TimelineItem::Answer(Box::new(message.content()?))],
        channel::POSE => vec![TimelineItem::Pose(pose_of(message)?)],
        channel::SCENE => scene_changes(message)?
            .into_iter()
            .map(scene_item)
            .collect(),
        _ => Vec::new(),
    })
}

fn scene_item(change: SceneChange) -> TimelineItem {
    match change {
        SceneChange::World(shapes, sources) => TimelineItem::World(
            Arc::new(shapes.iter().map(shape_dto).collect()),
            Arc::new(source_dtos(&sources)),
        ),
        SceneChange::Leader(at) => TimelineItem::Leader(at),
    }
}

fn bounds(items: &[(u64, TimelineItem)]) -> [Point; 2] {
    let (mut low, mut high) = (
        Point::new(f64::INFINITY, f64::INFINITY),
        Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    );
    let mut extend = |x: f64, y: f64, room: f64| {
        low = Point::new(low.x.min(x - room), low.y.min(y - room));
        high = Point::new(high.x.max(x + room), high.y.max(y + room));
    };
    for (_, item) in items {
        match item {
            // Where the surroundings are not known, echoes are shown around the path.
            TimelineItem::Pose(pose) => extend(pose.position.x, pose.position.y, 0.3),
            TimelineItem::World(shapes, _) => {
                for shape in shapes.iter() {
                    match shape {
                        ShapeDto::Wall(points) | ShapeDto::Box(points) => {
                            points.iter().for_each(|[x, y]| extend(x.0, y.0, 0.0));
                        }
                        ShapeDto::Circle([x, y], radius) => extend(x.0, y.0, radius.0),
                    }
                }
            }
            _ => {}
        }
    }
    if low.x > high.x {
        return [Point::new(-1.0, -1.0), Point::new(1.0, 1.0)];
    }
    [low, high]
}

/// A decision that is being executed.
#[derive(Default)]
struct OpenStep {
    seeking: bool,
    flags: StepFlags,
    neuron: Option<usize>,
    /// Time and nearest range at its end.
    ended: Option<(f64, Option<f64>)>,
}

/// Builds the history of a log's decisions.
struct HistoryBuilder {
    trail: History,
    decisions: usize,
    starts: Vec<u64>,
    /// The current decision, and one that waits for its final position.
    open: Option<OpenStep>,
    ending: Option<OpenStep>,
    place: Point,
    ranges_m: [Option<f64>; 16],
    time_s: f64,
}

impl HistoryBuilder {
    fn new() -> Self {
        Self {
            trail: History::whole(),
            decisions: 0,
            starts: Vec::new(),
            open: None,
            ending: None,
            place: Point::default(),
            ranges_m: [None; 16],
            time_s: 0.0,
        }
    }

    fn add(&mut self, time_ns: u64, item: &TimelineItem) {
        self.time_s = time_ns as f64 / 1e9;
        match item {
            TimelineItem::Start(_) => {
                self.end();
                self.trail.begin();
                self.starts.push(self.trail.ends()[0]);
                self.ranges_m = [None; 16];
            }
            TimelineItem::Event(record) => self.event(&record.event),
            TimelineItem::Answer(answer) => self.answer(answer),
            TimelineItem::Pose(pose) => {
                self.place = pose.position;
                self.record_ended();
            }
            TimelineItem::World(..) | TimelineItem::Leader(_) => {}
        }
    }

    fn event(&mut self, event: &EventKind) {
        match event {
            EventKind::Echoes(echoes) => {
                for echo in echoes {
                    if let Some(range) = self.ranges_m.get_mut(usize::from(echo.sensor)) {
                        *range = echo.range_mm.map(|mm| f64::from(mm) / 1e3);
                    }
                }
            }
            EventKind::Odometry {
                progress: Progress::Touched,
                ..
            } => {
                if let Some(open) = &mut self.open {
                    open.flags.touched = true;
                }
            }
            // A stop ends the step.
            EventKind::Stop => self.close(),
            _ => {}
        }
    }

    fn answer(&mut self, answer: &AnswerRecord) {
        match &answer.decision {
            Some(decision) => {
                self.close();
                let plan = decision.plan.as_ref();
                self.decisions += 1;
                self.open = Some(OpenStep {
                    seeking: plan.is_some(),
                    flags: StepFlags {
                        at_goal: decision.at_goal,
                        shielded: decision.allowed_mm != decision.wanted_mm,
                        touched: false,
                        touched_by: false,
                    },
                    neuron: plan.map(|plan| usize::from(plan.current_neuron)),
                    ended: None,
                });
            }
            None if answer.mode_changed => self.close(),
            None => {
                if let (Some(open), Some(_)) = (&mut self.open, answer.motion) {
                    open.flags.shielded = true;
                }
            }
        }
    }

    /// Ends the current decision.
    fn close(&mut self) {
        self.record_ended();
        if let Some(mut open) = self.open.take() {
            let nearest = self.ranges_m.iter().flatten().copied().reduce(f64::min);
            open.ended = Some((self.time_s, nearest));
            self.ending = Some(open);
        }
    }

    /// Adds the ended decision at the current position.
    fn record_ended(&mut self) {
        let Some(ended) = self.ending.take() else {
            return;
        };
        let (time_s, nearest) = ended.ended.unwrap_or_default();
        let entry = history_entry(
            time_s,
            self.place,
            ended.seeking,
            ended.flags,
            ended.neuron,
            nearest,
        );
        self.trail.push(entry);
    }

    /// Ends the history, or a start.
    fn end(&mut self) {
        self.close();
        self.record_ended();
    }
}
