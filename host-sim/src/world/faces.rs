//! Every flat surface of a world, laid out for queries.
//!
//! A *face* is one side of a straight piece: from `a`, `length` metres along the unit vector `u`, seen
//! only from its left. A solid's outline gives one face per piece, a thin wall two. Faces come in blocks
//! of [`LANES`] so that a loop over a block has a fixed length, no bounds check and no branch, and the
//! compiler turns it into vector instructions; the last block is filled up with faces far away.

use super::geometry::Point;
use super::shapes::Shape;

/// Faces per block.
pub(super) const LANES: usize = 8;

/// Coordinate of the faces that fill up the last block, m: beyond every query's reach.
const FAR_M: f64 = 1e9;

/// [`LANES`] faces, one array per quantity, m.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FaceBlock {
    pub ax: [f64; LANES],
    pub ay: [f64; LANES],
    pub ux: [f64; LANES],
    pub uy: [f64; LANES],
    pub length: [f64; LANES],
}

impl FaceBlock {
    const EMPTY: Self = Self {
        ax: [FAR_M; LANES],
        ay: [FAR_M; LANES],
        ux: [1.0; LANES],
        uy: [0.0; LANES],
        length: [0.0; LANES],
    };
}

/// One face taken out of its block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    /// Start.
    pub a: Point,
    /// Unit vector along the face.
    pub u: Point,
    /// Length, m.
    pub length: f64,
}

/// All faces of a world.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Faces {
    pub blocks: Vec<FaceBlock>,
    count: usize,
}

impl Faces {
    /// The faces of `shapes`, in their order.
    pub fn of(shapes: &[Shape]) -> Self {
        let mut faces = Self::default();
        for shape in shapes {
            let two_sided = matches!(shape, Shape::Wall { .. });
            shape.for_each_segment(|from, to| {
                faces.push(from, to);
                if two_sided {
                    faces.push(to, from);
                }
            });
        }
        faces
    }

    fn push(&mut self, from: Point, to: Point) {
        let lane = self.count % LANES;
        if lane == 0 {
            self.blocks.push(FaceBlock::EMPTY);
        }
        let Some(block) = self.blocks.last_mut() else {
            return;
        };
        let length = from.distance(to);
        let u = (to - from) * (1.0 / length);
        block.ax[lane] = from.x;
        block.ay[lane] = from.y;
        block.ux[lane] = u.x;
        block.uy[lane] = u.y;
        block.length[lane] = length;
        self.count += 1;
    }

    /// The faces one by one, without those that only fill up.
    pub fn iter(&self) -> impl Iterator<Item = Face> + '_ {
        let lanes = self.blocks.iter().flat_map(|block| {
            (0..LANES).map(move |i| Face {
                a: Point::new(block.ax[i], block.ay[i]),
                u: Point::new(block.ux[i], block.uy[i]),
                length: block.length[i],
            })
        });
        lanes.take(self.count)
    }

    /// Distance from `point` to the nearest face, m; infinite without faces.
    pub fn distance(&self, point: Point) -> f64 {
        let mut best = [f64::INFINITY; LANES];
        for block in &self.blocks {
            for (i, best) in best.iter_mut().enumerate() {
                let (dx, dy) = (point.x - block.ax[i], point.y - block.ay[i]);
                let along = dx * block.ux[i] + dy * block.uy[i];
                let across = dx * block.uy[i] - dy * block.ux[i];
                let beyond = along - clamp(along, 0.0, block.length[i]);
                let squared = beyond * beyond + across * across;
                *best = min(*best, squared);
            }
        }
        best.into_iter().fold(f64::INFINITY, min).sqrt()
    }
}

/// The lesser of two numbers that are not NaN: one instruction, unlike `f64::min`.
#[inline(always)]
pub(super) fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two numbers that are not NaN.
#[inline(always)]
pub(super) fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `x` brought into [`low`, `high`], for `low <= high`.
#[inline(always)]
pub(super) fn clamp(x: f64, low: f64, high: f64) -> f64 {
    max(low, min(x, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_filled_up_with_faces_nobody_meets() {
        let wall = Shape::Wall {
            points: (0..6).map(|i| Point::new(f64::from(i), 0.0)).collect(),
        };
        let faces = Faces::of(&[wall]);
        assert_eq!((faces.iter().count(), faces.blocks.len()), (10, 2));
        assert_eq!(faces.distance(Point::new(2.5, -0.75)), 0.75);
        assert_eq!(faces.distance(Point::new(-3.0, 4.0)), 5.0);
        assert_eq!(Faces::default().distance(Point::default()), f64::INFINITY);
    }
}
