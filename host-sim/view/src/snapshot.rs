//! The messages for viewers: plain values in meters, radians, seconds and map units.
//!
//! A snapshot consists of parts with the fields `part`, `index` and `value`; each part is sent when
//! it has changed. All field names are part of the protocol.

pub use super::counts::DriveCounts;
pub use super::known_places::PlacesDto;
pub use super::part::{PartMessage, SnapshotPart, message};
use super::source::Capabilities;
pub use super::things::{SensedDto, ShapeDto, SourceDto};
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// Decisions per chunk.
pub const CHUNK_LENGTH: usize = 64;
/// Maximum number of chunks.
pub const MAX_CHUNKS: usize = 100;

/// A value that is sent with four decimals.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rounded(pub f64);

impl Serialize for Rounded {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let short = libm::rint(self.0 * 1e4) / 1e4;
        serializer.serialize_f64(short)
    }
}

impl From<f64> for Rounded {
    fn from(value: f64) -> Self {
        Self(value)
    }
}

/// One value per transducer.
pub type RingValues = [Rounded; 16];

/// A sensor on a body: x ahead, y to the left, m; bearing from the front, rad.
pub type SensorDto = [Rounded; 3];

/// A position or a displacement, meters.
pub type Xy = [Rounded; 2];

/// Everything that is visible at one time. Its messages are JSON texts over the WebSocket
/// `/socket`, such as `{"part": "now", "index": 0, "value": {"time_s": 12.8, "mode": "seek"}}`:
///
/// | part | value | changes with |
/// |---|---|---|
/// | `scene` | [`SceneDto`]: world, ring, menus, abilities | the world |
/// | `maps` | [`Maps`]: both maps, hits, U-matrices, best neurons of each sample | learning |
/// | `memory` | [`MemoryRow`]s of the lazy memory | each sample |
/// | `places` | [`PlacesDto`]: a memory of places, if one leads the robot | places, links, open ways |
/// | `trail` | [`HistoryEntry`]s of the decisions, in chunks of 64 (`index`) | each decision |
/// | `heard` | places of echoes, in chunks of 64, if the surroundings are not known | each echo |
/// | `now` | [`LiveState`]: pose, ranges, situation, plan, goal, counts, clock, link | always |
/// | `seat` | `{"you", "taken", "viewers"}`: the control lock | viewers and the lock |
#[derive(Clone)]
pub struct Snapshot {
    /// Parts that change rarely.
    pub parts: Vec<Arc<dyn PartMessage>>,
    /// The part that always changes.
    pub now: Box<LiveState>,
    /// The history.
    pub trail: Vec<Arc<dyn PartMessage>>,
    /// Number of the snapshot.
    pub revision: u64,
}

impl Snapshot {
    /// Sets the state of the playback clock.
    pub fn set_playback(&mut self, playback: PlaybackDto) {
        self.now.playback = playback;
    }

    /// All parts; the history comes last, because it may be long.
    #[must_use]
    pub fn into_parts(self) -> Vec<Arc<dyn PartMessage>> {
        let now = SnapshotPart::new("now", 0, self.revision, *self.now);
        let mut parts = self.parts;
        parts.push(Arc::new(now));
        parts.extend(self.trail);
        parts
    }
}

/// Scene: changes rarely.
#[derive(Debug, Clone, Default, Serialize)]
pub struct SceneDto {
    /// Name of the world.
    pub world: String,
    /// Lower left and upper right corner of everything, meters.
    pub bounds: [Xy; 2],
    /// Shapes of the world.
    pub shapes: Vec<ShapeDto>,
    /// What else can be perceived in it.
    pub sources: Vec<SourceDto>,
    /// Start position of the robot.
    pub start: Xy,
    /// Radii of the collision disc and of the transducers' faces, meters.
    pub radii_m: [Rounded; 2],
    /// The robot, if it is not the Nomad.
    pub robot: Option<String>,
    /// Where the sensors of a body stand and look; `None` for a ring on a turret.
    pub sensors: Option<Vec<SensorDto>>,
    /// Half the angle of a transducer's cone, radians.
    pub half_angle_rad: Rounded,
    /// Ranges at which a situation's value is 1 and 0, meters.
    pub near_far_m: [Rounded; 2],
    /// Longest displacement, meters.
    pub step_m: Rounded,
    /// Seed of all randomness.
    pub seed: String,
    /// Name of the preset.
    pub preset: String,
    /// Sonar model.
    pub sonar: String,
    /// Turret mode.
    pub turret: String,
    /// Random moves of an exploration.
    pub moves: u16,
    /// Name of the controller.
    #[serde(rename = "mind")]
    pub controller: String,
    /// The action comes from the paper's four steps, not from look-ahead.
    pub recalls: bool,
    /// What the source can do.
    pub abilities: Capabilities,
    /// Behaviors: name and description.
    pub behaviors: Vec<[String; 2]>,
    /// Worlds to choose from.
    pub worlds: Vec<String>,
    /// Presets to choose from.
    pub presets: Vec<String>,
}

/// Both maps, with neurons row by row from the top.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Maps {
    /// Neurons along x and along y.
    pub grid: [usize; 2],
    /// The maps are learned.
    pub learned: bool,
    /// Situations.
    pub situations: MapDto,
    /// Changes of situation.
    pub changes: MapDto,
    /// Actions, meters in the ring's frame.
    pub actions_m: Vec<Xy>,
    /// Best neurons of each sample in both maps.
    pub rows: Vec<[usize; 2]>,
}

/// A map.
#[derive(Debug, Clone, Default, Serialize)]
pub struct MapDto {
    /// Code vectors.
    pub code: Vec<Vec<Rounded>>,
    /// Number of samples per neuron.
    pub hits: Vec<u32>,
    /// Mean distance of each neuron to its direct neighbors.
    pub u_matrix: Vec<Rounded>,
}

/// A sample of the lazy memory.
#[derive(Debug, Clone, Serialize)]
pub struct MemoryRow {
    /// Situation before, per transducer; `None` = disabled.
    pub before: [Option<Rounded>; 16],
    /// Situation after.
    pub after: [Option<Rounded>; 16],
    /// Executed displacement, meters in the ring's frame.
    pub moved_m: Xy,
}

/// A past decision: time, s; place, m; 0 = exploring, 1 = seeking; flags 1 = touched, 2 = shielded,
/// 4 = at the goal; neuron of the situation, -1 = none; nearest range, m, -1 = no echo.
pub type HistoryEntry = (Rounded, Rounded, Rounded, u8, u8, i16, Rounded);

/// Live state: always changes.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LiveState {
    /// Simulated time, seconds.
    pub time_s: Rounded,
    /// Duration of the latest step, seconds.
    pub step_s: Rounded,
    /// Pose: x, y and the ring's bearing (m, rad).
    pub pose: [Rounded; 3],
    /// Pose that a robot with a memory of places takes to be its own.
    pub thinks: Option<[Rounded; 3]>,
    /// The way that its places lead it now: the next sub-goal first, its end last.
    pub way: Option<Vec<Xy>>,
    /// Pose at the time of the ring.
    #[serde(rename = "heard_at")]
    pub scan_pose: [Rounded; 3],
    /// Mode: `idle`, `babble`, `calibrate`, `explore`, `learn`, `seek`, `stopped`, `failed`.
    pub mode: &'static str,
    /// Why the source failed.
    pub why: Option<String>,
    /// A remark.
    pub note: Option<String>,
    /// An interrupted activity can be resumed.
    pub resumes: bool,
    /// Progress of exploring or learning, 0 to 1.
    #[serde(rename = "done")]
    pub progress: Rounded,
    /// Latest ranges, meters.
    pub ranges_m: [Option<Rounded>; 16],
    /// Transducers that are enabled.
    #[serde(rename = "on")]
    pub enabled: [bool; 16],
    /// Latest ranges of a body's sensors, meters; `ranges_m` are then those of its ring of sectors.
    pub beams_m: Option<Vec<Option<Rounded>>>,
    /// Where the controller takes a body's sensors to stand and look; `None` = not found.
    pub found: Option<Vec<Option<SensorDto>>>,
    /// Situation of the latest decision; the current one at rest.
    pub situation: RingValues,
    /// Change of situation by the latest move.
    pub changed: Option<RingValues>,
    /// Plan of the latest decision.
    pub plan: Option<PlanDto>,
    /// Wanted displacement, meters in the ring's frame.
    pub wanted_m: Xy,
    /// Displacement after the shield, meters in the ring's frame.
    pub allowed_m: Xy,
    /// The latest step touched something.
    pub touched: bool,
    /// The goal.
    pub goal: GoalDto,
    /// Whether a demonstration is recorded now, and its number of steps.
    pub shown: Option<(bool, usize)>,
    /// Counts since the start.
    pub counts: DriveCounts,
    /// The shield is on.
    pub shield: bool,
    /// Online learning is on.
    pub online: bool,
    /// What its sensors read beside ranges, if there is anything.
    pub sensed: Option<SensedDto>,
    /// Position of the leader.
    pub leader: Option<Xy>,
    /// Addresses of a remote controller or robot.
    pub link: Option<String>,
    /// State of the playback clock.
    #[serde(rename = "pace")]
    pub playback: PlaybackDto,
    /// First and last chunk of the history since the start.
    pub trail: [u64; 2],
    /// Number of decisions before the current position; `None` = all.
    pub at: Option<usize>,
    /// First and last chunk of the places of echoes.
    #[serde(rename = "heard")]
    pub echo_trail: [u64; 2],
}

/// State of the playback clock.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct PlaybackDto {
    /// Simulated seconds per second; `None` = maximum.
    pub speed: Option<f64>,
    /// Time is paused.
    pub paused: bool,
    /// The source is idle.
    pub standing: bool,
}

/// A plan (see [`amp::planner::Plan`]).
#[derive(Debug, Clone, Default, Serialize)]
pub struct PlanDto {
    /// Goal neuron.
    pub goal: usize,
    /// Neuron of the current situation.
    pub current: usize,
    /// Subgoal, or the expected neuron.
    pub intermediate: usize,
    /// From the current neuron to the goal neuron over direct neighbors.
    pub walk: Vec<usize>,
    /// Best neuron of the action map.
    pub action: usize,
    /// Wanted change, or the expected one with look-ahead.
    pub wanted: RingValues,
    /// Change stored in that neuron.
    pub known: RingValues,
    /// The goal holds.
    pub at_goal: bool,
    /// Reason, in words.
    pub why: String,
}

/// A goal.
#[derive(Debug, Clone, Default, Serialize)]
pub struct GoalDto {
    /// Its name.
    pub name: String,
    /// Index of the part of a chain; `None` for other goals.
    pub part: Option<usize>,
    /// Steps of driving around before the way home: driven, and in all.
    pub tour: Option<[u32; 2]>,
    /// Bounds for each transducer; `None` = any value.
    #[serde(rename = "asked")]
    pub bounds: Vec<Option<[Rounded; 2]>>,
    /// Components count from the direction of travel.
    pub travels: bool,
    /// The neuron of the situation.
    pub neuron: Option<usize>,
    /// Where it was captured, if known.
    pub place: Option<Xy>,
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A snapshot without content.
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
        let part = SnapshotPart::new("x", 2, 3, [Rounded(1.234_56), Rounded(-0.000_01)]);
        assert_eq!(
            &*part.text(),
            r#"{"part":"x","index":2,"value":[1.2346,-0.0]}"#
        );
        assert_eq!((part.key(), part.revision()), (("x", 2), 3));
        assert!(Arc::ptr_eq(&part.text(), &part.text()));
    }
}
