//! Every flat surface of a world, laid out for queries.
//!
//! A *face* is one side of a straight piece: from `a`, `length` meters along the unit vector `u`, seen
//! only from its left. A solid's outline gives one face per piece, a thin wall two. Faces come in blocks
//! of [`LANES`] so that a loop over a block has a fixed length, no bounds check and no branch, and the
//! compiler turns it into vector instructions; the last block is filled up with faces far away.

use super::geometry::Point;
use super::shapes::Shape;
use super::tree::{self, Bounds};

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
    /// Its place in the world's list: a whole number, which vectors hold best as one of their own kind.
    pub number: [f64; LANES],
}

impl FaceBlock {
    const EMPTY: Self = Self {
        ax: [FAR_M; LANES],
        ay: [FAR_M; LANES],
        ux: [1.0; LANES],
        uy: [0.0; LANES],
        length: [0.0; LANES],
        number: [FAR_M; LANES],
    };

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

    /// One of the faces.
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

/// One face taken out of its block.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Face {
    /// Start.
    pub a: Point,
    /// Unit vector along the face.
    pub u: Point,
    /// Length, m.
    pub length: f64,
    /// Its place in the world's list.
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

    fn bounds(&self) -> Bounds {
        Bounds::of(self.a, self.a + self.u * self.length)
    }
}

/// Faces in blocks.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Faces {
    pub blocks: Vec<FaceBlock>,
    count: usize,
}

impl Faces {
    /// The faces of `shapes`, numbered in their order, sorted so that neighbors stand together, and the box around each
    /// block.
    pub fn of(shapes: &[Shape]) -> (Self, Vec<Bounds>) {
        let mut all = Vec::new();
        for shape in shapes {
            let two_sided = matches!(shape, Shape::Wall { .. });
            shape.for_each_segment(|from, to| {
                all.push(Face::between(from, to, all.len()));
                if two_sided {
                    all.push(Face::between(to, from, all.len()));
                }
            });
        }
        tree::sort(&mut all, Face::bounds);
        let mut faces = Self::default();
        all.iter().for_each(|face| faces.push(*face));
        let blocks = all
            .chunks(LANES)
            .map(|block| Bounds::all(block.iter().map(Face::bounds)));
        (faces, blocks.collect())
    }

    /// Forgets all faces; the memory stays.
    pub fn clear(&mut self) {
        self.blocks.clear();
        self.count = 0;
    }

    /// How many there are, without those that only fill up.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The face at a place of this list.
    #[inline]
    pub fn get(&self, place: usize) -> Option<Face> {
        let block = self.blocks.get(place / LANES)?;
        (place < self.count).then(|| block.face(place % LANES))
    }

    /// Appends a face.
    pub fn push(&mut self, face: Face) {
        let lane = self.count % LANES;
        if lane == 0 {
            self.blocks.push(FaceBlock::EMPTY);
        }
        let Some(block) = self.blocks.last_mut() else {
            return;
        };
        block.ax[lane] = face.a.x;
        block.ay[lane] = face.a.y;
        block.ux[lane] = face.u.x;
        block.uy[lane] = face.u.y;
        block.length[lane] = face.length;
        block.number[lane] = face.number;
        self.count += 1;
    }

    /// Appends those faces of a block that come within `reach` m of `place`.
    pub fn keep(&mut self, block: &FaceBlock, place: Point, reach: f64) {
        let squared = block.distances_squared(place);
        for (lane, squared) in squared.into_iter().enumerate() {
            if squared <= reach * reach {
                self.push(block.face(lane));
            }
        }
    }

    /// The faces one by one, without those that only fill up.
    pub fn iter(&self) -> impl Iterator<Item = Face> + '_ {
        let lanes = self
            .blocks
            .iter()
            .flat_map(|block| (0..LANES).map(|lane| block.face(lane)));
        lanes.take(self.count)
    }
}

/// The lesser of two numbers that are not NaN: one instruction, unlike `f64::min`.
#[inline(always)]
pub(crate) fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two numbers that are not NaN.
#[inline(always)]
pub(crate) fn max(a: f64, b: f64) -> f64 {
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
        let (faces, bounds) = Faces::of(&[wall]);
        assert_eq!(
            (faces.iter().count(), faces.blocks.len(), bounds.len()),
            (10, 2, 2)
        );
        let distance = |point: Point| {
            let all = faces
                .blocks
                .iter()
                .flat_map(|block| block.distances_squared(point));
            all.fold(f64::INFINITY, min).sqrt()
        };
        assert_eq!(distance(Point::new(2.5, -0.75)), 0.75);
        assert_eq!(distance(Point::new(-3.0, 4.0)), 5.0);
    }
}
