//! What may lie in the lobes of an eye that looks the same way again and again, chosen and prepared once for a neighbourhood.
//!
//! The transducers of a turret that is held are such eyes. What of the first look at a thing does not depend on where the eye
//! is within the neighbourhood is worked out beforehand; what is left are comparisons.

use wide::f32x8;

use super::faces::{Face, LANES, max, min};
use super::geometry::Point;
use super::lobe::Edges;
use super::outline::{Piece, slack};
use super::view::ConeShape;

/// Where an eye points: its axis and the edges of its cone, unit vectors.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Directions {
    pub axis: Point,
    pub left: Point,
    pub right: Point,
    pub cone: ConeShape,
}

impl Directions {
    pub fn new(axis: Point, cone: ConeShape) -> Self {
        let edge = |sin: f64| axis.turned(Point::new(cone.cos, sin));
        Self {
            axis,
            left: edge(cone.sin),
            right: edge(-cone.sin),
            cone,
        }
    }
}

/// Where the eye is, from the middle: also how far left of the edges through the middle, and how far along the axis, m.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Station {
    tip: [f32; 2],
    left: f32,
    right: f32,
    along: f32,
    slack: f32,
}

impl Station {
    /// An eye at `tip` from a middle, among things within `reach` m of it.
    #[inline]
    pub fn new(tip: Point, directions: &Directions, reach: f64) -> Self {
        Self {
            tip: [tip.x as f32, tip.y as f32],
            left: directions.left.cross(tip) as f32,
            right: directions.right.cross(tip) as f32,
            along: directions.axis.dot(tip) as f32,
            slack: slack(reach),
        }
    }
}

/// Where [`LANES`] things lie as the eye looks: of each how far left of the edges through the middle, for faces the
/// rightmost end of one and the leftmost of the other, and how far along the axis it begins, m. A place without one is no
/// number and lies nowhere.
#[derive(Debug, Clone, Copy)]
struct Lie {
    left: [f32; LANES],
    right: [f32; LANES],
    along: [f32; LANES],
}

impl Lie {
    const NONE: Self = Self {
        left: [f32::NAN; LANES],
        right: [f32::NAN; LANES],
        along: [f32::NAN; LANES],
    };

    fn set(&mut self, lane: usize, [begin, end]: [Point; 2], to: &Directions) {
        self.left[lane] = min(to.left.cross(begin), to.left.cross(end)) as f32;
        self.right[lane] = max(to.right.cross(begin), to.right.cross(end)) as f32;
        self.along[lane] = min(to.axis.dot(begin), to.axis.dot(end)) as f32;
    }

    /// Which may lie in the lobe, no farther than `most` m along its axis.
    #[inline(always)]
    fn inside(&self, station: &Station, most: f64) -> f32x8 {
        let Station {
            left,
            right,
            along,
            slack,
            ..
        } = *station;
        f32x8::new(self.left).simd_le(f32x8::splat(left + slack))
            & f32x8::new(self.right).simd_ge(f32x8::splat(right - slack))
            & f32x8::new(self.along).simd_le(f32x8::splat(along + slack + most as f32))
    }
}

/// [`LANES`] faces.
#[derive(Debug, Clone, Copy)]
struct Faces {
    /// Distance from the middle to the nearest of them, m.
    from_m: f64,
    lie: Lie,
    /// Unit normals and distances of their lines from the middle.
    normal_x: [f32; LANES],
    normal_y: [f32; LANES],
    distance: [f32; LANES],
    faces: [(Face, Edges); LANES],
}

/// [`LANES`] corners.
#[derive(Debug, Clone, Copy)]
struct Corners {
    /// Distance from the middle to the nearest of them, m.
    from_m: f64,
    lie: Lie,
    corners: [Point; LANES],
}

/// Faces and corners from near to far.
#[derive(Debug, Clone, Default)]
pub(super) struct Steady {
    faces: Vec<Faces>,
    face_count: usize,
    corners: Vec<Corners>,
    corner_count: usize,
}

impl Steady {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.faces.clear();
        self.corners.clear();
        (self.face_count, self.corner_count) = (0, 0);
    }

    /// Appends a face `distance` m from the middle, of which this piece counts.
    pub fn push_face(&mut self, distance: f64, face: &Face, piece: &Piece, to: &Directions) {
        let lane = self.face_count % LANES;
        if lane == 0 {
            self.faces.push(Faces {
                from_m: distance,
                lie: Lie::NONE,
                normal_x: [f32::NAN; LANES],
                normal_y: [f32::NAN; LANES],
                distance: [f32::NAN; LANES],
                faces: [Default::default(); LANES],
            });
        }
        if let Some(block) = self.faces.last_mut() {
            block.lie.set(lane, [piece.begin, piece.end], to);
            block.normal_x[lane] = piece.normal.x as f32;
            block.normal_y[lane] = piece.normal.y as f32;
            block.distance[lane] = piece.distance as f32;
            block.faces[lane] = (*face, Edges::of(face, to.axis, to.cone));
        }
        self.face_count += 1;
    }

    /// Appends a corner `distance` m from the middle, which lies there.
    pub fn push_corner(&mut self, distance: f64, corner: Point, middle: Point, to: &Directions) {
        let lane = self.corner_count % LANES;
        if lane == 0 {
            self.corners.push(Corners {
                from_m: distance,
                lie: Lie::NONE,
                corners: [Point::default(); LANES],
            });
        }
        if let Some(block) = self.corners.last_mut() {
            block.lie.set(lane, [corner - middle; 2], to);
            block.corners[lane] = corner;
        }
        self.corner_count += 1;
    }

    /// Shows the faces up to `most` m from the middle that may lie in the lobe within `far` m along its axis and show it
    /// their front, and others.
    #[inline]
    pub fn faces_in(
        &self,
        station: &Station,
        most: f64,
        far: f64,
        mut look: impl FnMut(&Face, &Edges),
    ) {
        let [x, y] = station.tip.map(f32x8::splat);
        for block in &self.faces {
            if block.from_m > most {
                break;
            }
            let across = f32x8::new(block.normal_x) * x + f32x8::new(block.normal_y) * y;
            let front = (f32x8::new(block.distance) - across).simd_ge(f32x8::splat(-station.slack));
            let mut mask = (front & block.lie.inside(station, far)).to_bitmask();
            while let Some((face, edges)) = next(&mut mask, &block.faces) {
                look(face, edges);
            }
        }
    }

    /// As [`Steady::faces_in`], of corners.
    #[inline]
    pub fn corners_in(
        &self,
        station: &Station,
        most: f64,
        far: f64,
        mut look: impl FnMut(Point),
    ) {
        for block in &self.corners {
            if block.from_m > most {
                break;
            }
            let mut mask = block.lie.inside(station, far).to_bitmask();
            while let Some(corner) = next(&mut mask, &block.corners) {
                look(*corner);
            }
        }
    }
}

/// The thing at the lowest one of a mask, which goes.
#[inline(always)]
fn next<'a, T>(mask: &mut u32, things: &'a [T; LANES]) -> Option<&'a T> {
    let thing = things.get(mask.trailing_zeros() as usize);
    *mask &= mask.wrapping_sub(1);
    thing
}
