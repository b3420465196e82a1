//! How well a task is done, from the true path. The robot never sees these values.

use amp::units::Millis;
use arena::sonar::FACE_RADIUS_M;
use arena::world::{ConeShape, Point, Shape, World};
use sim::episode::{Body, Observer, StepResult};
use std::f64::consts::FRAC_PI_2;

/// The room on each side counts up to this, m.
const MAX_ROOM_M: f64 = 1.3;
/// A shorter move has no direction, m.
const MIN_MOVE_M: f64 = 0.01;
/// At the end: within this distance, m.
const THERE_M: f64 = 0.3;

/// Where the robot was after each decision.
#[derive(Debug, Clone, Default)]
pub struct Path {
    /// Positions, and that of the leader.
    pub places: Vec<(Point, Option<Point>)>,
    /// Decisions in which it touched something.
    pub contacts: u32,
}

impl Path {
    fn end(&self) -> Point {
        self.places.last().map_or(Point::default(), |(at, _)| *at)
    }

    /// Mean of a value over all steps that moved, with their direction.
    fn mean_of_moves(&self, value: impl Fn(Point, f64) -> f64) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for pair in self.places.windows(2) {
            let way = pair[1].0 - pair[0].0;
            if way.length() > MIN_MOVE_M {
                sum += value(pair[1].0, way.angle());
                count += 1.0;
            }
        }
        // A robot that stands is as far off as one can be.
        if count > 0.0 { sum / count } else { MAX_ROOM_M }
    }
}

/// Follows the positions of an episode.
#[derive(Debug, Default)]
pub struct PathObserver(Path);

impl PathObserver {
    /// The last steps: without those of exploring.
    pub fn last(&self, steps: u32) -> Path {
        let skip = self.0.places.len().saturating_sub(steps as usize);
        Path {
            places: self.0.places[skip..].to_vec(),
            contacts: 0,
        }
    }
}

impl Observer for PathObserver {
    fn on_step(&mut self, _: Millis, result: &StepResult, body: &Body<'_>) {
        if result.decision.is_some() {
            self.0.places.push((body.pose().position, body.leader()));
        }
    }
}

/// Gap from the ring to the nearest surface on one side, m.
pub fn room(world: &World, at: Point, side: f64) -> f64 {
    // One degree less than a half plane: the limit of the cone query.
    let half = ConeShape::new(FRAC_PI_2 - 0.0175);
    let view = world.view(at, 0.0, 20.0);
    view.nearest_in_cone(Point::unit(side), half).min(20.0) - FACE_RADIUS_M
}

/// Mean distance from the middle between left and right, m.
pub fn off_center(world: &World, path: &Path) -> f64 {
    path.mean_of_moves(|at, heading| {
        let room = |side: f64| room(world, at, heading + side).min(MAX_ROOM_M);
        (room(FRAC_PI_2) - room(-FRAC_PI_2)).abs() / 2.0
    })
}

/// The middle of the exit of a world `with_exit`.
pub fn exit(world: &World) -> Point {
    let end = |shape: usize, point: usize| match world.shapes().get(shape) {
        Some(Shape::Wall { points }) => points.get(point).copied().unwrap_or_default(),
        _ => Point::default(),
    };
    (end(2, 1) + end(3, 0)) * 0.5
}

/// 1 = within 0.3 m of the middle of the exit at the end.
pub fn in_doorway(world: &World, path: &Path) -> f64 {
    f64::from(u8::from(path.end().distance(exit(world)) <= THERE_M))
}

/// Where a robot stands in the nearest corner of a room, `gap_m` from both walls.
pub fn corner(world: &World, at: Point, gap_m: f64) -> Point {
    let (low, high) = world.bounds();
    let off = gap_m + FACE_RADIUS_M;
    let nearer = |at: f64, low: f64, high: f64| {
        if at - low < high - at {
            low + off
        } else {
            high - off
        }
    };
    Point::new(nearer(at.x, low.x, high.x), nearer(at.y, low.y, high.y))
}

/// Distance at the end from where both walls of the nearest corner are 0.6 m away, m.
pub fn off_corner(world: &World, path: &Path) -> f64 {
    path.end()
        .distance(corner(world, path.end(), super::rules::CORNER_M))
}

/// Difference at the end between the gap to the nearest surface and 0.3 m, m.
pub fn off_dock(world: &World, path: &Path) -> f64 {
    let gap = world.clearance(path.end()) - FACE_RADIUS_M;
    (gap - super::rules::DOCK_M).abs()
}

/// Mean difference between the gap to the leader and 0.8 m, m.
pub fn off_distance(_: &World, path: &Path) -> f64 {
    let gaps = path.places.iter().filter_map(|(at, leader)| {
        let gap = super::rules::gap_to_leader(*at, (*leader)?);
        Some((gap - super::rules::AHEAD_M).abs())
    });
    let gaps: Vec<_> = gaps.collect();
    gaps.iter().sum::<f64>() / gaps.len().max(1) as f64
}

/// Center of the last obstacle of a world.
pub fn obstacle(world: &World) -> Point {
    let mut centers = world.shapes().iter().rev().filter_map(|shape| match shape {
        Shape::Box { center, .. } | Shape::Circle { center, .. } => Some(*center),
        Shape::Wall { .. } | Shape::Outline { .. } => None,
    });
    centers.next().unwrap_or_default()
}

/// Mean difference between the gap to the obstacle and 0.6 m, m. A robot that does not keep it on
/// its left is off by as much as one can be.
pub fn off_circle(world: &World, path: &Path) -> f64 {
    let center = obstacle(world);
    path.mean_of_moves(|at, heading| {
        let to = center - at;
        let is_left = to.turned_back(Point::unit(heading)).y > 0.0;
        let off = (room(world, at, to.angle()) - super::rules::CIRCLE_M).abs();
        if is_left {
            off.min(MAX_ROOM_M)
        } else {
            MAX_ROOM_M
        }
    })
}

/// A measure of a path.
pub type Measure = fn(&World, &Path) -> f64;
