//! What viewers are shown: plain values in meters, radians, seconds and map units, in parts that change one by one.

use super::source::Abilities;
use serde::{Serialize, Serializer};
use std::sync::{Arc, OnceLock};

/// Decisions in a piece of the trail.
pub const PIECE: usize = 64;
/// Most pieces of the trail that are kept.
pub const MAX_PIECES: usize = 100;

/// A value with four decimals: below a tenth of a millimeter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Short(pub f64);

impl Serialize for Short {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let short = libm::rint(self.0 * 1e4) / 1e4;
        serializer.serialize_f64(short)
    }
}

impl From<f64> for Short {
    fn from(value: f64) -> Self {
        Self(value)
    }
}

/// One value per transducer.
pub type Ring = [Short; 16];

/// A place or a displacement, meters.
pub type Xy = [Short; 2];

/// A part and how often it has changed.
pub struct Part<T> {
    name: &'static str,
    index: u64,
    revision: u64,
    value: T,
    text: OnceLock<Arc<str>>,
}

impl<T: Serialize> Part<T> {
    /// A part; of one name and index a higher revision is newer.
    #[must_use]
    pub fn new(name: &'static str, index: u64, revision: u64, value: T) -> Self {
        Self {
            name,
            index,
            revision,
            value,
            text: OnceLock::new(),
        }
    }
}

/// Any part: what a viewer's task needs to know of it.
pub trait Showable: Send + Sync {
    /// Name and index.
    fn key(&self) -> (&'static str, u64);
    /// Rises when it changes.
    fn revision(&self) -> u64;
    /// The message, made by the first who asks.
    fn text(&self) -> Arc<str>;
}

impl<T: Serialize + Send + Sync> Showable for Part<T> {
    fn key(&self) -> (&'static str, u64) {
        (self.name, self.index)
    }

    fn revision(&self) -> u64 {
        self.revision
    }

    fn text(&self) -> Arc<str> {
        let make = || message(self.name, self.index, &self.value).into();
        Arc::clone(self.text.get_or_init(make))
    }
}

/// A part's message.
pub fn message(part: &str, index: u64, value: &impl Serialize) -> String {
    #[derive(Serialize)]
    struct Message<'a, T> {
        part: &'a str,
        index: u64,
        value: &'a T,
    }
    // Plain structs of numbers and texts are always JSON.
    serde_json::to_string(&Message { part, index, value }).unwrap_or_default()
}

/// All there is to see at one moment.
#[derive(Clone)]
pub struct Snapshot {
    /// What changes seldom.
    pub parts: Vec<Arc<dyn Showable>>,
    /// What changes always.
    pub now: Box<Now>,
    /// The decisions so far.
    pub trail: Vec<Arc<dyn Showable>>,
    /// Counts the snapshots.
    pub revision: u64,
}

impl Snapshot {
    /// Says how time passes.
    pub fn set_pace(&mut self, pace: PaceNow) {
        self.now.pace = pace;
    }

    /// All its parts; the trail, which may be long for a newcomer, comes last.
    #[must_use]
    pub fn into_parts(self) -> Vec<Arc<dyn Showable>> {
        let now = Part::new("now", 0, self.revision, *self.now);
        let mut parts = self.parts;
        parts.push(Arc::new(now));
        parts.extend(self.trail);
        parts
    }
}

/// What changes seldom.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Scene {
    /// Name of the world.
    pub world: String,
    /// Lower left and upper right corner of everything, meters.
    pub bounds: [Xy; 2],
    /// What stands there.
    pub shapes: Vec<ShapeSeen>,
    /// Where the robot started.
    pub start: Xy,
    /// Radius of the disc that touches things, and of the transducers' faces, meters.
    pub radii_m: [Short; 2],
    /// Half the angle of a transducer's cone, radians.
    pub half_angle_rad: Short,
    /// Ranges at which a situation's value is 1 and 0, meters.
    pub near_far_m: [Short; 2],
    /// Longest displacement, meters.
    pub step_m: Short,
    /// What it runs with.
    pub seed: String,
    /// As above.
    pub preset: String,
    /// As above.
    pub sonar: String,
    /// As above.
    pub turret: String,
    /// Random moves of an exploration.
    pub moves: u16,
    /// Where the mind runs.
    pub mind: String,
    /// The paper's four steps find the action (else look-ahead does).
    pub recalls: bool,
    /// What can be asked for.
    pub abilities: Abilities,
    /// Behaviors: name and what it does.
    pub behaviors: Vec<[String; 2]>,
    /// Worlds to choose from.
    pub worlds: Vec<String>,
    /// Presets to choose from.
    pub presets: Vec<String>,
}

/// A thing in the world.
#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeSeen {
    /// A chain of straight pieces.
    Wall(Vec<Xy>),
    /// The corners of a box, which can be moved.
    Box(Vec<Xy>),
    /// Center and radius of a post, which can be moved.
    Circle(Xy, Short),
}

/// Both maps. Neurons row by row from the top.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Maps {
    /// Neurons along x and along y.
    pub grid: [usize; 2],
    /// They have been learned.
    pub learned: bool,
    /// Situations.
    pub situations: MapSeen,
    /// Changes of situation.
    pub changes: MapSeen,
    /// Actions, meters in the ring's frame.
    pub actions_m: Vec<Xy>,
    /// Per sample of the memory: the neurons that answer to it in either map.
    pub rows: Vec<[usize; 2]>,
}

/// One codebook.
#[derive(Debug, Clone, Default, Serialize)]
pub struct MapSeen {
    /// Code vectors.
    pub code: Vec<Vec<Short>>,
    /// Samples of the memory each neuron answers to.
    pub hits: Vec<u32>,
    /// Mean distance of each neuron to its direct neighbors.
    pub u_matrix: Vec<Short>,
}

/// A sample of the lazy memory.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Situation before, per transducer; none = not believed.
    pub before: [Option<Short>; 16],
    /// Situation after.
    pub after: [Option<Short>; 16],
    /// Displacement carried out, meters in the ring's frame.
    pub moved_m: Xy,
}

/// One decision of the past: time, s; place, m; 0 = exploring, 1 = seeking; 1 = touched + 2 = shielded + 4 = the goal held;
/// neuron of the situation, -1 = none; nearest range, m, -1 = nothing heard.
pub type Mark = (Short, Short, Short, u8, u8, i16, Short);

/// What changes always.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Now {
    /// Simulated time, seconds.
    pub time_s: Short,
    /// Duration of the latest step, seconds.
    pub step_s: Short,
    /// Where the robot is: x, y and the ring's bearing (m, rad).
    pub pose: [Short; 3],
    /// Where it was when the ring was heard.
    pub heard_at: [Short; 3],
    /// What it does: `idle`, `explore`, `learn`, `seek`, `stopped`, `failed`.
    pub mode: &'static str,
    /// Why it failed.
    pub why: Option<String>,
    /// What there is to say besides.
    pub note: Option<String>,
    /// What can be gone on with.
    pub resumes: bool,
    /// How much of exploring or learning is done, 0 to 1.
    pub done: Short,
    /// Latest ranges, meters.
    pub ranges_m: [Option<Short>; 16],
    /// Transducers that are on.
    pub on: [bool; 16],
    /// The situation of the latest decision, or as perceived while standing.
    pub situation: Ring,
    /// What the latest move has changed.
    pub changed: Option<Ring>,
    /// How the latest decision came about.
    pub plan: Option<PlanSeen>,
    /// Displacement wanted and allowed by the shield, meters in the ring's frame.
    pub wanted_m: Xy,
    /// As above.
    pub allowed_m: Xy,
    /// The latest step touched something.
    pub touched: bool,
    /// The goal.
    pub goal: GoalSeen,
    /// Counted since the start.
    pub counts: Counts,
    /// The sonars limit motion.
    pub shield: bool,
    /// The maps go on learning while behaving.
    pub online: bool,
    /// A robot that is followed.
    pub leader: Option<Xy>,
    /// The ways to a mind or a robot elsewhere.
    pub link: Option<String>,
    /// How time passes.
    pub pace: PaceNow,
    /// First piece of the trail of this start that is kept, and last piece.
    pub trail: [u64; 2],
    /// How many of the trail's decisions lie behind; none = all.
    pub at: Option<usize>,
    /// First and last piece of the places where something was heard.
    pub heard: [u64; 2],
}

/// How time passes.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct PaceNow {
    /// Simulated seconds per second; none = as fast as it goes.
    pub speed: Option<f64>,
    /// Time stands still.
    pub paused: bool,
    /// Nothing goes on.
    pub standing: bool,
}

/// A plan (see [`amp::planner::Plan`]).
#[derive(Debug, Clone, Default, Serialize)]
pub struct PlanSeen {
    /// Neuron that stands for the goal.
    pub goal: usize,
    /// Neuron of the present situation.
    pub current: usize,
    /// Neuron aimed at, or expected.
    pub intermediate: usize,
    /// From the present neuron to the goal's over direct neighbors.
    pub walk: Vec<usize>,
    /// Neuron of the action map that answers.
    pub action: usize,
    /// Change wanted (or expected, with look-ahead).
    pub wanted: Ring,
    /// Change the answering neuron knows.
    pub known: Ring,
    /// The goal holds.
    pub at_goal: bool,
    /// Why.
    pub why: String,
}

/// A goal.
#[derive(Debug, Clone, Default, Serialize)]
pub struct GoalSeen {
    /// What it is called.
    pub name: String,
    /// Which part of a chain, from 0; none for what is no chain.
    pub part: Option<usize>,
    /// Least and greatest value asked of each transducer; none where any will do.
    pub asked: Vec<Option<[Short; 2]>>,
    /// Its components are counted from where the robot goes.
    pub travels: bool,
    /// The neuron whose situation it is.
    pub neuron: Option<usize>,
    /// Where it was captured, if that is known.
    pub place: Option<Xy>,
}

/// What is counted.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Counts {
    /// Random moves, and how many of them touched something.
    pub explored: [u32; 2],
    /// Decisions towards goals.
    pub steps: u32,
    /// Of these, those that touched something.
    pub contacts: u32,
    /// Those the shield shortened.
    pub shielded: u32,
    /// Those taken while the goal held.
    pub at_goal: u32,
    /// Way, meters.
    pub distance_m: Short,
    /// Least gap to anything, meters.
    pub clearance_m: Option<Short>,
    /// Area swept, square meters, if its measure is known.
    pub coverage_m2: Option<Short>,
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A snapshot of nothing.
    pub fn empty() -> Snapshot {
        Snapshot {
            parts: Vec::new(),
            now: Box::default(),
            trail: Vec::new(),
            revision: 1,
        }
    }

    #[test]
    fn a_part_is_a_message_with_four_decimals() {
        let part = Part::new("x", 2, 3, [Short(1.234_56), Short(-0.000_01)]);
        assert_eq!(
            &*part.text(),
            r#"{"part":"x","index":2,"value":[1.2346,-0.0]}"#
        );
        assert_eq!((part.key(), part.revision()), (("x", 2), 3));
        assert!(Arc::ptr_eq(&part.text(), &part.text()));
    }
}
