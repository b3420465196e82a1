//! Teachers by rule. They see the true world, as a person who steers would.

use super::measure::{corner, exit, obstacle, room};
use arena::sonar::FACE_RADIUS_M;
use arena::world::{Point, World};
use sim::ring_pilot::STEP_M;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Gap to both walls of a corner, m.
pub const CORNER_M: f64 = 0.6;
/// Gap to the wall at which the robot docks, m.
pub const DOCK_M: f64 = 0.3;
/// Gap to the leader, m.
pub const AHEAD_M: f64 = 0.8;
/// Gap to the obstacle that is circled, m.
pub const CIRCLE_M: f64 = 0.6;
/// Room ahead at which a corridor ends, m.
const BLOCKED_M: f64 = 0.9;

/// What a teacher sees.
#[derive(Debug, Clone, Copy)]
pub struct TeacherView<'w> {
    /// The world.
    pub world: &'w World,
    /// Where the robot is; the ring's bearing is that of the world.
    pub at: Point,
    /// Where the leader is.
    pub leader: Option<Point>,
    /// The last displacement that was not zero; along x at first.
    pub course: Point,
}

/// The next displacement, m.
pub type Rule = fn(&TeacherView<'_>) -> Point;

/// Towards a place; stands there.
fn towards(at: Point, to: Point) -> Point {
    let way = to - at;
    if way.length() <= STEP_M {
        way
    } else {
        way * (STEP_M / way.length())
    }
}

/// In the middle of a corridor; turns at its end to where there is more room.
pub fn center(view: &TeacherView<'_>) -> Point {
    // Along the walls: the nearest of the four directions of a world with right angles.
    let straight = |angle: f64| libm::rint(angle / FRAC_PI_2) * FRAC_PI_2;
    let free = |heading: f64| {
        let ray = view
            .world
            .sweep(view.at, view.at + Point::unit(heading) * 3.0, FACE_RADIUS_M);
        ray.traveled_m
    };
    let mut heading = straight(view.course.angle());
    if free(heading) < BLOCKED_M {
        let turns = [FRAC_PI_2, -FRAC_PI_2, 2.0 * FRAC_PI_2];
        let best = turns.into_iter().reduce(|best, turn| {
            if free(heading + turn) > free(heading + best) + 0.1 {
                turn
            } else {
                best
            }
        });
        heading += best.unwrap_or(0.0);
    }
    let side = |angle: f64| room(view.world, view.at, heading + angle).min(1.3);
    let off = (side(FRAC_PI_2) - side(-FRAC_PI_2)) / 2.0;
    let aside = (off / STEP_M).clamp(-0.7, 0.7);
    let way = Point::new((1.0 - aside * aside).sqrt(), aside) * STEP_M;
    way.turned(Point::unit(heading))
}

/// To the middle of the exit.
pub fn doorway(view: &TeacherView<'_>) -> Point {
    towards(view.at, exit(view.world))
}

/// Into the nearest corner.
pub fn into_corner(view: &TeacherView<'_>) -> Point {
    towards(view.at, corner(view.world, view.at, CORNER_M))
}

/// Straight to the nearest surface.
pub fn dock(view: &TeacherView<'_>) -> Point {
    let angles = (0..72).map(|index| f64::from(index) * TAU / 72.0);
    let cone = arena::world::ConeShape::new(0.06);
    let seen = view.world.view(view.at, 0.0, 20.0);
    let gap = |angle: f64| seen.nearest_in_cone(Point::unit(angle), cone) - FACE_RADIUS_M;
    let nearest = angles.reduce(|best, angle| if gap(angle) < gap(best) { angle } else { best });
    let angle = nearest.unwrap_or(0.0);
    Point::unit(angle) * (gap(angle) - DOCK_M).clamp(-STEP_M, STEP_M)
}

/// Gap between the ring and the leader's face, m.
pub fn gap_to_leader(at: Point, leader: Point) -> f64 {
    leader.distance(at) - 2.0 * FACE_RADIUS_M
}

/// Straight to the leader, or back.
pub fn keep_distance(view: &TeacherView<'_>) -> Point {
    let Some(leader) = view.leader else {
        return Point::default();
    };
    let off = gap_to_leader(view.at, leader) - AHEAD_M;
    Point::unit((leader - view.at).angle()) * off.clamp(-STEP_M, STEP_M)
}

/// Around the obstacle, which stays on the left.
pub fn circle(view: &TeacherView<'_>) -> Point {
    let to = obstacle(view.world) - view.at;
    let off = room(view.world, view.at, to.angle()) - CIRCLE_M;
    let nearer = (off / STEP_M).clamp(-0.9, 0.9);
    let way = Point::new((1.0 - nearer * nearer).sqrt(), nearer) * STEP_M;
    way.turned(Point::unit(to.angle() - FRAC_PI_2))
}
