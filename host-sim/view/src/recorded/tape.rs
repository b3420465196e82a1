//! A log as a series of things that happened, and its decisions at a glance.

use crate::seen::shape_seen;
use crate::snapshot::ShapeSeen;
use crate::trail::{Trail, mark};
use amp::controller::Progress;
use arena::world::{Point, Pose};
use files::error::BadInput;
use remote::log::{
    AnswerRecord, Ending, EventKind, EventRecord, LogFile, SceneChange, SetupRecord, channel,
    pose_of, scene_changes,
};
use sim::episode::StepFlags;
use std::sync::Arc;

/// Something of a log.
pub(super) enum Item {
    /// A mind that knows nothing starts.
    Start(Box<SetupRecord>),
    /// It is told something.
    Event(EventRecord),
    /// It answered.
    Answer(Box<AnswerRecord>),
    /// Where the robot really is.
    Pose(Pose),
    /// What stands around.
    Shapes(Arc<Vec<ShapeSeen>>),
    /// Where a second robot is.
    Leader(Point),
}

/// A log in memory.
pub(super) struct Tape {
    /// What happened, with its time since the log began, ns.
    pub items: Vec<(u64, Item)>,
    /// Every decision; a piece ends with each start.
    pub trail: Trail,
    /// Decisions in it.
    pub decisions: usize,
    /// First piece of each start.
    pub starts: Vec<u64>,
    /// Lower left and upper right corner of everything.
    pub bounds: [Point; 2],
    /// How the log ends.
    pub ending: Ending,
}

impl Tape {
    /// Reads a whole log.
    ///
    /// # Errors
    /// When a message is not what its channel should hold, or nothing was decided.
    pub fn read(log: &LogFile) -> Result<Self, BadInput> {
        let mut items = Vec::new();
        for message in log.messages() {
            let refuse = |why| BadInput::file(log.path(), why);
            let mut put = |item| items.push((message.time_ns, item));
            match message.topic.as_str() {
                channel::SETUP => put(Item::Start(Box::new(message.content().map_err(refuse)?))),
                channel::EVENT => put(Item::Event(message.content().map_err(refuse)?)),
                channel::PLAN => put(Item::Answer(Box::new(message.content().map_err(refuse)?))),
                channel::POSE => put(Item::Pose(pose_of(&message).map_err(refuse)?)),
                channel::SCENE => {
                    for change in scene_changes(&message).map_err(refuse)? {
                        put(match change {
                            SceneChange::Shapes(shapes) => {
                                Item::Shapes(Arc::new(shapes.iter().map(shape_seen).collect()))
                            }
                            SceneChange::Leader(at) => Item::Leader(at),
                        });
                    }
                }
                _ => {}
            }
        }
        let mut marking = Marking::new();
        items
            .iter()
            .for_each(|(time_ns, item)| marking.take(*time_ns, item));
        marking.end();
        if marking.decisions == 0 {
            return Err(BadInput::file(log.path(), "holds no decision"));
        }
        Ok(Self {
            bounds: bounds(&items),
            items,
            trail: marking.trail,
            decisions: marking.decisions,
            starts: marking.starts,
            ending: log.ending(),
        })
    }
}

fn bounds(items: &[(u64, Item)]) -> [Point; 2] {
    let (mut low, mut high) = (
        Point::new(f64::INFINITY, f64::INFINITY),
        Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    );
    let mut stretch = |x: f64, y: f64, room: f64| {
        low = Point::new(low.x.min(x - room), low.y.min(y - room));
        high = Point::new(high.x.max(x + room), high.y.max(y + room));
    };
    for (_, item) in items {
        match item {
            // Where nobody said what stands around, what was heard is to be seen.
            Item::Pose(pose) => stretch(pose.position.x, pose.position.y, 0.3),
            Item::Shapes(shapes) => {
                for shape in shapes.iter() {
                    match shape {
                        ShapeSeen::Wall(points) | ShapeSeen::Box(points) => {
                            points.iter().for_each(|[x, y]| stretch(x.0, y.0, 0.0));
                        }
                        ShapeSeen::Circle([x, y], radius) => stretch(x.0, y.0, radius.0),
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

/// A decision that is being carried out.
#[derive(Default)]
struct Open {
    seeks: bool,
    stride: StepFlags,
    neuron: Option<usize>,
    /// It has ended: when, and what was nearest then.
    ended: Option<(f64, Option<f64>)>,
}

/// Goes through a log and marks its decisions.
struct Marking {
    trail: Trail,
    decisions: usize,
    starts: Vec<u64>,
    /// The latest decision, and one that waits to be told where it ended.
    open: Option<Open>,
    ending: Option<Open>,
    place: Point,
    ranges_m: [Option<f64>; 16],
    time_s: f64,
}

impl Marking {
    fn new() -> Self {
        Self {
            trail: Trail::whole(),
            decisions: 0,
            starts: Vec::new(),
            open: None,
            ending: None,
            place: Point::default(),
            ranges_m: [None; 16],
            time_s: 0.0,
        }
    }

    fn take(&mut self, time_ns: u64, item: &Item) {
        self.time_s = time_ns as f64 / 1e9;
        match item {
            Item::Start(_) => {
                self.end();
                self.trail.begin();
                self.starts.push(self.trail.ends()[0]);
                self.ranges_m = [None; 16];
            }
            Item::Event(record) => self.event(&record.event),
            Item::Answer(answer) => self.answer(answer),
            Item::Pose(pose) => {
                self.place = pose.position;
                self.put();
            }
            Item::Shapes(_) | Item::Leader(_) => {}
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
                    open.stride.touched = true;
                }
            }
            // What was begun ends here.
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
                self.open = Some(Open {
                    seeks: plan.is_some(),
                    stride: StepFlags {
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
                    open.stride.shielded = true;
                }
            }
        }
    }

    /// The decision under way has been carried out.
    fn close(&mut self) {
        self.put();
        if let Some(mut open) = self.open.take() {
            let nearest = self.ranges_m.iter().flatten().copied().reduce(f64::min);
            open.ended = Some((self.time_s, nearest));
            self.ending = Some(open);
        }
    }

    /// Marks what has ended, where the robot is now.
    fn put(&mut self) {
        let Some(ended) = self.ending.take() else {
            return;
        };
        let (time_s, nearest) = ended.ended.unwrap_or_default();
        let mark = mark(
            time_s,
            self.place,
            ended.seeks,
            ended.stride,
            ended.neuron,
            nearest,
        );
        self.trail.push(mark);
    }

    /// Nothing more comes, or a new start.
    fn end(&mut self) {
        self.close();
        self.put();
    }
}
