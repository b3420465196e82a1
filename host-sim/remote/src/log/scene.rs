//! The messages that other tools draw: Foxglove's well-known schemas in JSON.

use super::read::LogMessage;
use arena::robot::COLLISION_RADIUS_M;
use arena::robot_model::SensorMount;
use arena::sonar::RingGeometry;
use arena::sources::Sources;
use arena::world::{Point, Pose, Shape, World};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Frame of the world.
const WORLD: &str = "world";
/// Frame of the ring: x along transducer 0, y to its left.
const RING: &str = "ring";
/// The entity of all surfaces, and the metadata keys of their shapes and of what else can be
/// perceived.
const SURFACES: &str = "surfaces";
const SHAPES: &str = "shapes";
const SOURCES: &str = "sources";
/// The entity of what the sensors of a body hear.
const BEAMS: &str = "beams";
/// The entity of the second robot.
const LEADER: &str = "leader";
/// Height of the drawn bodies, meters: about that of a Nomad 200.
const HEIGHT_M: f64 = 0.9;
/// A missing echo is drawn at the longest range of the ring, 255 in, meters.
const LONGEST_M: f64 = 6.477;

fn stamp(time: u64) -> Value {
    json!({"sec": time / 1_000_000_000, "nsec": time % 1_000_000_000})
}

fn point(at: Point, z: f64) -> Value {
    json!({"x": at.x, "y": at.y, "z": z})
}

/// Rotation by `heading` around z.
fn orientation(heading: f64) -> Value {
    let (sin, cos) = libm::sincos(heading / 2.0);
    json!({"x": 0.0, "y": 0.0, "z": sin, "w": cos})
}

fn unrotated_pose(at: Point, z: f64) -> Value {
    json!({"position": point(at, z), "orientation": orientation(0.0)})
}

fn color(rgb: [f64; 3], a: f64) -> Value {
    let [r, g, b] = rgb;
    json!({"r": r, "g": g, "b": b, "a": a})
}

pub(super) fn laser_scan(time: u64, ranges_m: &[Option<f64>; 16]) -> Value {
    // From the ring's center, as the frame is.
    let face_radius_m = RingGeometry::default().face_radius_m;
    let reach = |range: &Option<f64>| range.unwrap_or(LONGEST_M).min(LONGEST_M) + face_radius_m;
    let ranges: Vec<f64> = ranges_m.iter().map(reach).collect();
    json!({
        "timestamp": stamp(time), "frame_id": RING,
        "pose": unrotated_pose(Point::new(0.0, 0.0), 0.0),
        "start_angle": 0.0, "end_angle": TAU * 15.0 / 16.0,
        "ranges": ranges, "intensities": [],
    })
}

pub(super) fn pose_in_frame(time: u64, pose: Pose) -> Value {
    json!({
        "timestamp": stamp(time), "frame_id": WORLD,
        "pose": {"position": point(pose.position, 0.0), "orientation": orientation(pose.heading)},
    })
}

pub(super) fn frame_transform(time: u64, pose: Pose) -> Value {
    json!({
        "timestamp": stamp(time), "parent_frame_id": WORLD, "child_frame_id": RING,
        "translation": point(pose.position, 0.0), "rotation": orientation(pose.heading),
    })
}

/// The world, if it is known, and a body of this radius, meters, as a cylinder that moves with the
/// ring. `replace_all` deletes everything drawn before.
pub(super) fn begin(time: u64, world: Option<&World>, radius_m: f64, replace_all: bool) -> Value {
    let mut body = entity(time, RING, "robot");
    body["frame_locked"] = json!(true);
    let middle = Point::new(0.0, 0.0);
    body["cylinders"] = json!([cylinder(middle, radius_m, [0.1, 0.45, 0.8], 0.8)]);
    let surfaces = world.map(|world| surfaces(time, world));
    let entities: Vec<_> = surfaces.into_iter().chain([body]).collect();
    // Type 1 deletes everything.
    let all = json!({"timestamp": stamp(time), "type": 1, "id": ""});
    let deletions: Vec<_> = replace_all.then_some(all).into_iter().collect();
    json!({"deletions": deletions, "entities": entities})
}

/// Replaces the surfaces.
pub(super) fn changed(time: u64, world: &World) -> Value {
    json!({"deletions": [], "entities": [surfaces(time, world)]})
}

/// A line from each sensor that hears something to where it is straight ahead, in the frame of the
/// ring.
pub(super) fn beams(time: u64, sensors: &[SensorMount], ranges_m: &[Option<f64>; 16]) -> Value {
    let heard = sensors.iter().zip(ranges_m);
    let ends = heard.filter_map(|(sensor, range_m)| {
        let from = sensor.position;
        let to = from + Point::unit(sensor.bearing_rad) * (*range_m)?;
        Some([point(from, 0.0), point(to, 0.0)])
    });
    let ends: Vec<_> = ends.flatten().collect();
    let mut beams = entity(time, RING, BEAMS);
    beams["lines"] = json!([lines(&ends, 1.0, color([0.1, 0.45, 0.8], 0.6))]);
    json!({"deletions": [], "entities": [beams]})
}

/// Lines of this thickness in pixels between each two points.
fn lines(ends: &[Value], thickness: f64, color: Value) -> Value {
    json!({
        "type": 2, "pose": unrotated_pose(Point::new(0.0, 0.0), 0.0), "thickness": thickness, "scale_invariant": true,
        "points": ends, "color": color, "colors": [], "indices": [],
    })
}

/// Surfaces as lines and posts as cylinders, with their shapes as metadata.
fn surfaces(time: u64, world: &World) -> Value {
    let ends = world
        .segments()
        .flat_map(|(from, to)| [point(from, 0.0), point(to, 0.0)]);
    let ends: Vec<_> = ends.collect();
    let posts = world.shapes().iter().filter_map(|shape| match *shape {
        Shape::Circle { center, radius } => Some(cylinder(center, radius, [0.5, 0.5, 0.55], 0.6)),
        _ => None,
    });
    let mut surfaces = entity(time, WORLD, SURFACES);
    surfaces["lines"] = json!([lines(&ends, 2.0, color([0.5, 0.5, 0.55], 1.0))]);
    surfaces["cylinders"] = posts.collect();
    let mut metadata = vec![json!({"key": SHAPES, "value": json!(world.shapes()).to_string()})];
    let sources = world.sources();
    if !sources.is_empty() {
        metadata.push(json!({"key": SOURCES, "value": json!(sources).to_string()}));
        surfaces["spheres"] = bulbs(sources).collect();
    }
    surfaces["metadata"] = json!(metadata);
    surfaces
}

/// Scents and lamps as spheres.
fn bulbs(sources: &Sources) -> impl Iterator<Item = Value> {
    let scents = sources.scents.iter();
    let scents = scents.map(|scent| sphere(scent.position, 0.1, [0.3, 0.7, 0.3]));
    let lights = sources.lights.iter();
    scents.chain(lights.map(|light| sphere(light.position, 2.0, [0.95, 0.85, 0.3])))
}

pub(super) fn leader(time: u64, at: Point) -> Value {
    let mut entity = entity(time, WORLD, LEADER);
    entity["cylinders"] = json!([cylinder(at, COLLISION_RADIUS_M, [0.85, 0.5, 0.1], 0.8)]);
    json!({"deletions": [], "entities": [entity]})
}

pub(super) fn contact(time: u64, at: Point, number: usize) -> Value {
    let mut entity = entity(time, WORLD, &format!("contact {number}"));
    entity["spheres"] = json!([sphere(at, HEIGHT_M, [0.85, 0.1, 0.1])]);
    json!({"deletions": [], "entities": [entity]})
}

fn sphere(at: Point, z: f64, rgb: [f64; 3]) -> Value {
    json!({
        "pose": unrotated_pose(at, z), "size": {"x": 0.12, "y": 0.12, "z": 0.12}, "color": color(rgb, 1.0),
    })
}

fn cylinder(at: Point, radius: f64, rgb: [f64; 3], alpha: f64) -> Value {
    json!({
        "pose": unrotated_pose(at, HEIGHT_M / 2.0), "size": {"x": 2.0 * radius, "y": 2.0 * radius, "z": HEIGHT_M},
        "bottom_scale": 1.0, "top_scale": 1.0, "color": color(rgb, alpha),
    })
}

/// A change of the scene.
#[derive(Debug, Clone, PartialEq)]
pub enum SceneChange {
    /// All shapes of the world, and what else can be perceived in it.
    World(Vec<Shape>, Sources),
    /// Position of the second robot.
    Leader(Point),
}

#[derive(Deserialize)]
struct SceneUpdate {
    entities: Vec<Entity>,
}

#[derive(Deserialize)]
struct Entity {
    id: String,
    metadata: Vec<Pair>,
    cylinders: Vec<Cylinder>,
}

impl Entity {
    fn value<T: DeserializeOwned>(&self, key: &str) -> Result<Option<T>, String> {
        let pair = self.metadata.iter().find(|pair| pair.key == key);
        let value = pair.map(|pair| serde_json::from_str(&pair.value));
        value.transpose().map_err(|why| why.to_string())
    }
}

#[derive(Deserialize)]
struct Pair {
    key: String,
    value: String,
}

#[derive(Deserialize)]
struct Cylinder {
    pose: Positioned,
}

#[derive(Deserialize)]
struct Positioned {
    position: Point,
}

#[derive(Deserialize)]
struct PoseInFrame {
    pose: Oriented,
}

#[derive(Deserialize)]
struct Oriented {
    position: Point,
    orientation: Quaternion,
}

#[derive(Deserialize)]
struct Quaternion {
    z: f64,
    w: f64,
}

/// The changes in a message of this program.
pub fn scene_changes(message: &LogMessage) -> Result<Vec<SceneChange>, String> {
    let update: SceneUpdate = message.content()?;
    let mut changes = Vec::new();
    for entity in update.entities {
        let shapes = entity.value(SHAPES)?;
        if let Some(shapes) = shapes {
            let sources = entity.value(SOURCES)?.unwrap_or_default();
            changes.push(SceneChange::World(shapes, sources));
        }
        if let (LEADER, Some(leader)) = (entity.id.as_str(), entity.cylinders.first()) {
            changes.push(SceneChange::Leader(leader.pose.position));
        }
    }
    Ok(changes)
}

/// The pose in a message of the channel of poses.
pub fn pose_of(message: &LogMessage) -> Result<Pose, String> {
    let PoseInFrame { pose } = message.content()?;
    let heading = 2.0 * libm::atan2(pose.orientation.z, pose.orientation.w);
    Ok(Pose::new(pose.position, heading))
}

/// An entity that remains until it is replaced.
fn entity(time: u64, frame: &str, id: &str) -> Value {
    json!({
        "timestamp": stamp(time), "frame_id": frame, "id": id, "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": false, "metadata": [], "arrows": [], "cubes": [], "spheres": [], "cylinders": [],
        "lines": [], "triangles": [], "texts": [], "models": [],
    })
}
