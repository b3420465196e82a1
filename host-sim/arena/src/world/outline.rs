//! Which things may lie in a lobe: a first look in `f32`, eight at a time, that keeps too many rather than too few.
//!
//! Things are held relative to the middle of their surroundings and cut off at its reach, so that the numbers stay small
//! and rounding far below the slack.

use wide::f32x8;

use super::faces::{Face, LANES, clamp};
use super::geometry::Point;
use super::steady::Aim;

/// [`LANES`] points relative to a middle, m. A place without one is no number and lies nowhere.
#[derive(Debug, Clone, Copy)]
pub(super) struct Points {
    x: [f32; LANES],
    y: [f32; LANES],
}

impl Points {
    pub const NONE: Self = Self {
        x: [f32::NAN; LANES],
        y: [f32::NAN; LANES],
    };

    pub fn set(&mut self, lane: usize, point: Point) {
        (self.x[lane], self.y[lane]) = (point.x as f32, point.y as f32);
    }
}

/// [`LANES`] faces: their ends, and their lines by unit normals and distances from the middle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline {
    begin: Points,
    end: Points,
    normal: Points,
    distance: [f32; LANES],
}

impl Outline {
    pub const NONE: Self = Self {
        begin: Points::NONE,
        end: Points::NONE,
        normal: Points::NONE,
        distance: [f32::NAN; LANES],
    };

    /// Puts a piece of a face here.
    pub fn set(&mut self, lane: usize, piece: &Piece) {
        self.begin.set(lane, piece.begin);
        self.end.set(lane, piece.end);
        self.normal.set(lane, piece.normal);
        self.distance[lane] = piece.distance as f32;
    }
}

/// What of a face lies near a middle, and its line.
pub(super) struct Piece {
    pub begin: Point,
    pub end: Point,
    pub normal: Point,
    pub distance: f64,
}

impl Piece {
    /// What of a face lies within `reach` m of `middle`, which some of it does.
    pub fn of(face: &Face, middle: Point, reach: f64) -> Self {
        let offset = face.a - middle;
        let (p, q) = (offset.dot(face.u), offset.cross(face.u));
        let normal = Point::new(face.u.y, -face.u.x);
        let at = |p: f64| face.u * clamp(p, -reach, reach) + normal * q;
        Self {
            begin: at(p),
            end: at(p + face.length),
            normal,
            distance: q,
        }
    }
}

/// Far above the rounding of `f32` among things within `reach` m.
#[inline]
pub(super) fn slack(reach: f64) -> f32 {
    (1e-3 + 1e-6 * reach) as f32
}

/// A lobe as it lies in its surroundings.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sector {
    tip: [f32; 2],
    /// Unit vector along the axis, and how far behind the tip the middle lies.
    axis: [f32; 3],
    /// Unit vectors along the edges, and how far left of their lines the middle lies.
    left: [f32; 3],
    right: [f32; 3],
    slack: f32,
}

impl Sector {
    /// The cone so aimed, whose tip lies at `tip` from a middle, among things within `reach` m of it.
    #[inline]
    pub fn new(tip: Point, aim: &Aim, reach: f64) -> Self {
        let edge = |edge: Point| [edge.x, edge.y, edge.cross(-tip)].map(|part| part as f32);
        let axis = aim.axis;
        Self {
            tip: [tip.x as f32, tip.y as f32],
            axis: [axis.x, axis.y, axis.dot(-tip)].map(|part| part as f32),
            left: edge(aim.left),
            right: edge(aim.right),
            slack: slack(reach),
        }
    }

    /// The same for all tips within `room` m of this one at once.
    pub fn widened(mut self, room: f64) -> Self {
        self.slack += room as f32;
        self
    }

    /// Bit i: point i may lie in the cone, no farther than `most` m along the axis.
    #[inline]
    pub fn points(&self, points: &Points, most: f64) -> u32 {
        let slack = f32x8::splat(self.slack);
        let [x, y, middle] = self.axis.map(f32x8::splat);
        let along = x * f32x8::new(points.x) + y * f32x8::new(points.y) + middle;
        let inside = left_of(self.left, points).simd_le(slack)
            & left_of(self.right, points).simd_ge(-slack)
            & along.simd_le(f32x8::splat(most as f32) + slack);
        inside.to_bitmask()
    }

    /// Bit i: some of face i may lie in the cone and show its front to the tip.
    #[inline]
    pub fn faces(&self, faces: &Outline) -> u32 {
        let slack = f32x8::splat(self.slack);
        let [x, y] = self.tip;
        let across = f32x8::new(faces.normal.x) * f32x8::splat(x)
            + f32x8::new(faces.normal.y) * f32x8::splat(y);
        let front = (f32x8::new(faces.distance) - across).simd_ge(-slack);
        let right_of_left = left_of(self.left, &faces.begin).simd_le(slack)
            | left_of(self.left, &faces.end).simd_le(slack);
        let left_of_right = left_of(self.right, &faces.begin).simd_ge(-slack)
            | left_of(self.right, &faces.end).simd_ge(-slack);
        (front & right_of_left & left_of_right).to_bitmask()
    }
}

/// How far left of the line of an edge each point lies, m.
#[inline(always)]
fn left_of([x, y, middle]: [f32; 3], points: &Points) -> f32x8 {
    f32x8::splat(x) * f32x8::new(points.y) - f32x8::splat(y) * f32x8::new(points.x)
        + f32x8::splat(middle)
}
