//! Which faces are met at right angles from a place: found without looking at the others.
//!
//! The foot of the perpendicular from a place on a face lies where the place does, as measured along the face. Faces of one
//! direction stand in the order of their starts along it, so that those around a place are found by halving; those of
//! much different length stand apart, so that a long wall does not make neighbors of all. The directions stand in the order
//! of their angles.

use super::faces::{Face, Faces, max};
use super::geometry::Point;
use super::tree::SLACK_M;

/// How much the order of angles may be wrong by rounding.
const ROUNDING: f64 = 1e-9;

/// Faces of one direction and about one length.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Parallel {
    /// Unit vector towards the front of the faces, and against it: how a ray meets them.
    pub inward: Point,
    turn: f64,
    along: Point,
    longest_m: f64,
    /// Where each face begins along the direction, m, and its place in the world's list.
    starts: Vec<(f64, u32)>,
}

/// The faces of a world by their directions.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Feet {
    groups: Vec<Parallel>,
}

impl Feet {
    pub fn of(faces: &Faces) -> Self {
        let mut all: Vec<_> = faces.iter().zip(0..).map(Placed::new).collect();
        all.sort_unstable_by(|a, b| {
            let starts = a.start.total_cmp(&b.start);
            a.kind.cmp(&b.kind).then(starts).then(a.place.cmp(&b.place))
        });
        let groups = all.chunk_by(|a, b| a.kind == b.kind);
        Self {
            groups: groups.filter_map(Parallel::of).collect(),
        }
    }

    /// Faces of one direction and about one length, by their place among these.
    pub fn group(&self, place: usize) -> Option<&Parallel> {
        self.groups.get(place)
    }

    /// The places of the faces that are met at right angles by rays from the unit vector `right` on to the left up to
    /// `left`, less than half a turn.
    pub fn between(&self, right: Point, left: Point) -> impl Iterator<Item = usize> {
        let (from, to) = (turn(right) - ROUNDING, turn(left) + ROUNDING);
        let place = |turn: f64| self.groups.partition_point(|group| group.turn < turn);
        let (from, to, all) = (place(from), place(to), self.groups.len());
        // Across the direction from which turns are counted.
        let parts = if from <= to && turn(right) <= turn(left) {
            [from..to, 0..0]
        } else {
            [from..all, 0..to]
        };
        parts.into_iter().flatten()
    }
}

/// A face among all.
struct Placed {
    /// Its direction, in the order of the angle, and about its length.
    kind: (u64, u64, u64, i32),
    start: f64,
    place: u32,
    face: Face,
}

impl Placed {
    fn new((face, place): (Face, u32)) -> Self {
        let turn = turn(inward(&face)).to_bits();
        let [x, y] = [face.u.x, face.u.y].map(f64::to_bits);
        Self {
            kind: (turn, x, y, libm::ilogb(face.length)),
            start: face.a.dot(face.u),
            place,
            face,
        }
    }
}

impl Parallel {
    fn of(placed: &[Placed]) -> Option<Self> {
        let first = placed.first()?.face;
        let lengths = placed.iter().map(|placed| placed.face.length);
        let starts = placed.iter().map(|placed| (placed.start, placed.place));
        Some(Self {
            inward: inward(&first),
            turn: turn(inward(&first)),
            along: first.u,
            longest_m: lengths.fold(0.0, max),
            starts: starts.collect(),
        })
    }

    /// Places in the world's list of the faces that may have the foot of the perpendicular from `place`.
    pub fn around(&self, place: Point) -> impl Iterator<Item = usize> {
        let at = place.dot(self.along);
        let least = at - self.longest_m - SLACK_M;
        let first = self.starts.partition_point(|(start, _)| *start < least);
        let starts = self.starts.get(first..).unwrap_or(&[]).iter();
        let starts = starts.take_while(move |(start, _)| *start <= at + SLACK_M);
        starts.map(|(_, place)| *place as usize)
    }
}

fn inward(face: &Face) -> Point {
    Point::new(face.u.y, -face.u.x)
}

/// A number from 0 to 4 that grows with the angle of a unit vector, from the x axis to the left.
fn turn(direction: Point) -> f64 {
    let Point { x, y } = direction;
    // No zero below 0, whose bits are out of order.
    let part = y / (x.abs() + y.abs()) + 0.0;
    match (x < 0.0, y < 0.0) {
        (true, _) => 2.0 - part,
        (false, true) => 4.0 + part,
        (false, false) => part,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Shape;
    use core::f64::consts::TAU;

    #[test]
    fn faces_are_found_by_direction_and_place() {
        let side = |x: f64, y: f64| Shape::Box {
            center: Point::new(x, y),
            size: Point::new(1.0, 0.1),
            angle: 0.0,
        };
        let shapes: Vec<_> = (0..40)
            .map(|i| side(f64::from(i % 8) * 2.0, f64::from(i / 8)))
            .collect();
        let faces = Faces::of(&shapes).0;
        let feet = Feet::of(&faces);
        for axis in [0.0, 1.0, 1.57, 3.1, 4.7] {
            let edges = [axis - 0.3, axis + 0.3].map(Point::unit);
            let groups = feet.between(edges[0], edges[1]);
            let groups = groups.filter_map(|place| feet.group(place));
            let at = Point::new(4.3, 2.02);
            let is_upright = |face: &Face| {
                let p = (face.a - at).dot(face.u);
                let has_foot = p <= 0.0 && p + face.length >= 0.0;
                has_foot && inward(face).dot(Point::unit(axis)) > 0.96
            };
            let near = groups.flat_map(|group| group.around(at));
            let found = near.filter_map(|place| faces.get(place));
            assert_eq!(
                found.filter(is_upright).count(),
                faces.iter().filter(is_upright).count(),
                "{axis}"
            );
        }
    }

    #[test]
    fn turns_grow_with_the_angle() {
        let turns = (0..1_000).map(|i| turn(Point::unit(TAU * f64::from(i) / 1_000.0)));
        assert!(turns.is_sorted());
        assert_eq!(turn(Point::new(0.0, -1.0)), 3.0);
        assert_eq!(turn(Point::new(1.0, -0.0)).to_bits(), 0);
    }
}
