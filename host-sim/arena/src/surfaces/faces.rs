//! Flat surfaces, laid out for queries.
//!
//! A *face* is one side of a straight segment: from `a`, `length` meters along the unit vector `u`,
//! visible only from its left. A solid's outline has one face per segment, a thin wall two.

use super::tree::{Bounds, LANES};
use crate::geometry::{Point, clamp};
use crate::shapes::Shape;

/// Coordinate of the padding faces of the last block, m: beyond the reach of every query.
const FAR_M: f64 = 1e9;

/// One face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Face {
    /// Start.
    pub a: Point,
    /// Unit vector along the face.
    pub u: Point,
    /// Length, m.
    pub length: f64,
    /// Its index in the world's list, as `f64` like the other lanes of a block.
    pub number: f64,
}

impl Face {
    fn between(from: Point, to: Point, number: usize) -> Self {
        let length = from.distance(to);
        Self {
            a: from,
            u: (to - from) * (1.0 / length),
            length,
            number: number as f64,
        }
    }

    /// Its bounding box.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.a, self.a + self.u * self.length)
    }
}

/// The faces of `shapes`, numbered in their order.
pub(crate) fn list_faces(shapes: &[Shape]) -> Vec<Face> {
    let mut faces = Vec::new();
    for shape in shapes {
        let two_sided = matches!(shape, Shape::Wall { .. });
        shape.for_each_segment(|from, to| {
            faces.push(Face::between(from, to, faces.len()));
            if two_sided {
                faces.push(Face::between(to, from, faces.len()));
            }
        });
    }
    faces
}

/// [`LANES`] faces, one array per quantity, m, so that the compiler vectorizes a loop over them.
/// Faces far away pad the last block of a list.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FaceBlock {
    pub ax: [f64; LANES],
    pub ay: [f64; LANES],
    pub ux: [f64; LANES],
    pub uy: [f64; LANES],
    pub length: [f64; LANES],
    pub number: [f64; LANES],
}

impl FaceBlock {
    /// A block of padding faces.
    pub const EMPTY: Self = Self {
        ax: [FAR_M; LANES],
        ay: [FAR_M; LANES],
        ux: [1.0; LANES],
        uy: [0.0; LANES],
        length: [0.0; LANES],
        number: [FAR_M; LANES],
    };

    /// A block of at most [`LANES`] faces.
    pub fn of(faces: &[Face]) -> Self {
        let mut block = Self::EMPTY;
        for (lane, face) in faces.iter().enumerate() {
            block.ax[lane] = face.a.x;
            block.ay[lane] = face.a.y;
            block.ux[lane] = face.u.x;
            block.uy[lane] = face.u.y;
            block.length[lane] = face.length;
            block.number[lane] = face.number;
        }
        block
    }

    /// Squared distance of each face from `point`, m².
    #[inline]
    pub fn distances_squared(&self, point: Point) -> [f64; LANES] {
        let mut squared = [0.0; LANES];
        for (i, squared) in squared.iter_mut().enumerate() {
            let (dx, dy) = (point.x - self.ax[i], point.y - self.ay[i]);
            let along = dx * self.ux[i] + dy * self.uy[i];
            let across = dx * self.uy[i] - dy * self.ux[i];
            let beyond = along - clamp(along, 0.0, self.length[i]);
            *squared = beyond * beyond + across * across;
        }
        squared
    }

    /// The face in a lane.
    #[inline]
    pub fn face(&self, lane: usize) -> Face {
        Face {
            a: Point::new(self.ax[lane], self.ay[lane]),
            u: Point::new(self.ux[lane], self.uy[lane]),
            length: self.length[lane],
            number: self.number[lane],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::min;

    #[test]
    fn a_wall_has_two_sides_and_padding_has_no_effect() {
        let wall = Shape::Wall {
            points: (0..6).map(|i| Point::new(f64::from(i), 0.0)).collect(),
        };
        let faces = list_faces(&[wall]);
        assert_eq!(faces.len(), 10);
        let blocks: Vec<_> = faces.chunks(LANES).map(FaceBlock::of).collect();
        assert_eq!(blocks.len(), 2);
        let distance = |point: Point| {
            let blocks = blocks.iter();
            let all = blocks.flat_map(|block| block.distances_squared(point));
            all.fold(f64::INFINITY, min).sqrt()
        };
        assert_eq!(distance(Point::new(2.5, -0.75)), 0.75);
        assert_eq!(distance(Point::new(-3.0, 4.0)), 5.0);
    }
}
