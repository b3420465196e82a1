//! Straight motion of a disc up to its first contact.
//!
//! The distance from a moving point to a straight segment or a disc is a convex function of the
//! distance traveled. So the first contact has a closed form: the intersection of a ray with a
//! capsule or a circle. The closed form is computed only if the nearest surface is near enough.

use crate::geometry::{Point, clamp, max, min};
use crate::surfaces::{Circle, Distance, Face, FaceBlock, LANES, SLACK_M, Surfaces};

/// Depth in a surface up to which a disc does not touch it, m. A moving disc stops at distance
/// zero. The slack lets a disc at a wall leave it or slide along it despite rounding.
pub const TOUCH_SLACK_M: f64 = 1e-6;

/// Result of moving a disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// Distance traveled, m; less than commanded only after a contact.
    pub traveled_m: f64,
    /// Point of contact where the disc stopped; `None` without a contact.
    pub contact: Option<Point>,
    /// Smallest gap between the disc and any surface along the path traveled, m, never negative.
    pub min_clearance_m: f64,
}

impl Sweep {
    /// Whether the disc touched something.
    #[must_use]
    pub fn touched(&self) -> bool {
        self.contact.is_some()
    }
}

/// A straight path: from `start`, `length` meters along the unit vector `direction`.
pub(crate) struct Path {
    start: Point,
    direction: Point,
    pub length: f64,
}

impl Path {
    pub fn between(from: Point, to: Point) -> Self {
        let length = from.distance(to);
        let direction = if length > 0.0 {
            (to - from) * (1.0 / length)
        } else {
            Point::new(1.0, 0.0)
        };
        Self {
            start: from,
            direction,
            length,
        }
    }

    fn middle(&self) -> Point {
        self.at(self.length / 2.0)
    }

    fn at(&self, traveled: f64) -> Point {
        self.start + self.direction * traveled
    }

    /// Smallest distance between this path and a point, m.
    fn distance(&self, point: Point) -> f64 {
        let offset = point - self.start;
        let along = clamp(offset.dot(self.direction), 0.0, self.length);
        point.distance(self.at(along))
    }

    /// Distance at which this path enters the circle of `radius` around `point`, if it does.
    fn reaches(&self, point: Point, radius: f64) -> Option<f64> {
        let offset = point - self.start;
        let across = offset.cross(self.direction);
        let depth = radius * radius - across * across;
        let distance = offset.dot(self.direction) - max(depth, 0.0).sqrt();
        (depth >= 0.0 && distance >= 0.0).then_some(distance)
    }

    /// Whether a disc of `radius` m on this path touches a surface whose smallest distance from the
    /// path is `nearest` m.
    pub fn is_touched_at(&self, nearest: f64, radius: f64) -> bool {
        nearest < radius - TOUCH_SLACK_M
    }

    /// Squared distance between this path and a face, m².
    #[cfg(test)]
    pub fn to_face(&self, face: &Face) -> f64 {
        gap_squared(self, face.a, face.u, face.length)
    }
}

impl Distance for Path {
    #[inline]
    fn to_faces(&self, block: &FaceBlock) -> [f64; LANES] {
        let mut squared = [0.0; LANES];
        for (i, squared) in squared.iter_mut().enumerate() {
            let a = Point::new(block.ax[i], block.ay[i]);
            let u = Point::new(block.ux[i], block.uy[i]);
            *squared = gap_squared(self, a, u, block.length[i]);
        }
        squared
    }

    /// 0 inside the circle.
    fn to_circle(&self, circle: &Circle) -> f64 {
        max(self.distance(circle.center) - circle.radius, 0.0)
    }
}

/// Moves a disc of `radius` m straight `from` one point towards another, up to its first contact.
pub(super) fn sweep(
    surfaces: &Surfaces,
    posts: &[Circle],
    [from, to]: [Point; 2],
    radius: f64,
) -> Sweep {
    let path = Path::between(from, to);
    let nearest = gap(surfaces, posts, &path);
    let free = Sweep {
        traveled_m: path.length,
        contact: None,
        min_clearance_m: (nearest - radius).max(0.0),
    };
    if !path.is_touched_at(nearest, radius) {
        return free;
    }
    match first_touch(surfaces, posts, &path, radius) {
        None => free,
        Some(touch) => Sweep {
            traveled_m: min(touch.distance_m, path.length),
            contact: Some(touch.contact),
            min_clearance_m: 0.0,
        },
    }
}

/// Smallest distance between a path and any surface, m; 0 inside a circle.
fn gap(surfaces: &Surfaces, posts: &[Circle], path: &Path) -> f64 {
    let still = surfaces.nearest(path.middle(), path.length / 2.0, path);
    posts
        .iter()
        .fold(still, |nearest, post| min(nearest, path.to_circle(post)))
}

/// Contact of a disc with a surface.
struct Touch {
    /// Distance up to the contact, m.
    distance_m: f64,
    contact: Point,
    /// Number of the surface.
    number: f64,
}

impl Touch {
    fn comes_before(&self, other: &Self) -> bool {
        let same = self.distance_m == other.distance_m;
        self.distance_m < other.distance_m || (same && self.number < other.number)
    }
}

/// The first contact on a path; of several at once, that of the first surface in the world's list.
fn first_touch(surfaces: &Surfaces, posts: &[Circle], path: &Path, radius: f64) -> Option<Touch> {
    let mut first: Option<Touch> = None;
    let mut offer = |touch: Option<(f64, Point)>, number: f64| {
        let Some((distance_m, contact)) = touch else {
            return;
        };
        let touch = Touch {
            distance_m,
            contact,
            number,
        };
        if first.as_ref().is_none_or(|first| touch.comes_before(first)) {
            first = Some(touch);
        }
    };
    let (middle, reach) = (path.middle(), path.length / 2.0 + radius + SLACK_M);
    surfaces.faces_near(middle, reach, |block| {
        for face in (0..LANES).map(|lane| block.face(lane)) {
            offer(touch_face(path, &face, radius), face.number);
        }
    });
    surfaces.circles_near(middle, reach, |circle| {
        offer(touch_circle(path, circle, radius), circle.number);
    });
    for post in posts {
        offer(touch_circle(path, post, radius), post.number);
    }
    first
}

/// Squared distance between a path and a face, m². Two segments that do not cross are nearest at
/// one of their four ends. The code has no branches, so a loop over a block is vectorized.
#[inline(always)]
fn gap_squared(path: &Path, a: Point, u: Point, length: f64) -> f64 {
    let (e, reach, d) = (path.direction, path.length, a - path.start);
    let (dot, cross) = (u.dot(e), u.cross(e));
    // The path's ends in the face's coordinates.
    let (first, first_off) = (-d.dot(u), d.cross(u));
    let (last, last_off) = (first + reach * dot, first_off + reach * cross);
    let first_beyond = first - clamp(first, 0.0, length);
    let last_beyond = last - clamp(last, 0.0, length);
    let from_path = min(
        first_beyond * first_beyond + first_off * first_off,
        last_beyond * last_beyond + last_off * last_off,
    );
    // The face's ends in the path's coordinates.
    let (a_along, a_off) = (d.dot(e), d.cross(e));
    let (b_along, b_off) = (a_along + length * dot, a_off + length * cross);
    let a_beyond = a_along - clamp(a_along, 0.0, reach);
    let b_beyond = b_along - clamp(b_along, 0.0, reach);
    let from_face = min(
        a_beyond * a_beyond + a_off * a_off,
        b_beyond * b_beyond + b_off * b_off,
    );
    let apart = max(first_off * last_off, a_off * b_off) >= 0.0;
    if apart {
        min(from_path, from_face)
    } else {
        0.0
    }
}

/// First contact of a disc with a face: distance traveled and point of contact.
pub(crate) fn touch_face(path: &Path, face: &Face, radius: f64) -> Option<(f64, Point)> {
    let end = face.a + face.u * face.length;
    let nearest_to = |p: Point| face.a + face.u * clamp((p - face.a).dot(face.u), 0.0, face.length);
    let start_gap = nearest_to(path.start) - path.start;
    if start_gap.dot(path.direction) <= 0.0 {
        return None;
    }
    if gap_squared(path, face.a, face.u, face.length).sqrt() >= radius - TOUCH_SLACK_M {
        return None;
    }
    let distance = if start_gap.length() <= radius {
        0.0
    } else {
        let flat = distance_to_side(path, face, radius);
        let ends = [path.reaches(face.a, radius), path.reaches(end, radius)];
        flat.into_iter()
            .chain(ends.into_iter().flatten())
            .fold(path.length, min)
    };
    Some((distance, nearest_to(path.at(distance))))
}

/// Distance at which the path comes within `radius` of the face between its ends.
fn distance_to_side(path: &Path, face: &Face, radius: f64) -> Option<f64> {
    let offset = path.start - face.a;
    let across = face.u.cross(offset);
    let closing = face.u.cross(path.direction) * if across > 0.0 { -1.0 } else { 1.0 };
    if across.abs() <= radius || closing <= 0.0 {
        return None;
    }
    let distance = (across.abs() - radius) / closing;
    let along = (path.at(distance) - face.a).dot(face.u);
    (0.0..=face.length).contains(&along).then_some(distance)
}

/// First contact of a disc with a circle: distance traveled and point of contact.
pub(crate) fn touch_circle(path: &Path, circle: &Circle, radius: f64) -> Option<(f64, Point)> {
    let distance = touch_point(path, circle.center, radius + circle.radius)?;
    let inward = circle.center - path.at(distance);
    let share = (1.0 - circle.radius / max(inward.length(), circle.radius)).max(0.0);
    Some((distance, path.at(distance) + inward * share))
}

/// Distance at which a disc of `radius` (the sum of the robot's and the post's) first touches a
/// point.
fn touch_point(path: &Path, point: Point, radius: f64) -> Option<f64> {
    let approaching = (point - path.start).dot(path.direction) > 0.0;
    if !approaching || path.distance(point) >= radius - TOUCH_SLACK_M {
        return None;
    }
    if path.start.distance(point) <= radius {
        return Some(0.0);
    }
    path.reaches(point, radius)
}
