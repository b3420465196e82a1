//! Faces and corners around a place, from near to far, in blocks for a first look.

use super::faces::{Face, Faces, LANES};
use super::geometry::Point;
use super::outline::{Outline, Piece, Points, Sector};

/// Faces and corners around a middle, from near to far.
#[derive(Debug, Clone, Default)]
pub(super) struct Nearby {
    pub faces: Faces,
    /// The same one by one, once they have been [singled out](Nearby::single_out).
    single: Vec<Face>,
    /// Of each block of faces.
    outlines: Vec<Outline>,
    /// Distance from the middle to the nearest face of each block, m.
    pub faces_m: Vec<f64>,
    corners: Vec<Point>,
    /// The corners in blocks, relative to the middle.
    corner_blocks: Vec<Points>,
    /// Distance from the middle to the nearest corner of each block, m.
    corners_m: Vec<f64>,
}

impl Nearby {
    /// Forgets all faces.
    pub fn clear_faces(&mut self) {
        self.faces.clear();
        self.single.clear();
        self.outlines.clear();
        self.faces_m.clear();
    }

    /// Forgets all corners.
    pub fn clear_corners(&mut self) {
        self.corners.clear();
        self.corner_blocks.clear();
        self.corners_m.clear();
    }

    /// Appends a face `distance` m from the middle; what counts of it lies within `reach` m of that.
    pub fn push_face(&mut self, distance: f64, face: &Face, middle: Point, reach: f64) {
        let lane = self.faces.count() % LANES;
        if lane == 0 {
            self.outlines.push(Outline::NONE);
            self.faces_m.push(distance);
        }
        if let Some(outline) = self.outlines.last_mut() {
            outline.set(lane, &Piece::of(face, middle, reach));
        }
        self.faces.push(*face);
    }

    /// Makes the faces ready to be asked for one by one.
    pub fn single_out(&mut self) {
        self.single.clear();
        self.single.extend(self.faces.iter());
    }

    /// Appends a corner `distance` m from the middle.
    pub fn push_corner(&mut self, distance: f64, corner: Point, middle: Point) {
        let lane = self.corners.len() % LANES;
        if lane == 0 {
            self.corner_blocks.push(Points::NONE);
            self.corners_m.push(distance);
        }
        if let Some(block) = self.corner_blocks.last_mut() {
            block.set(lane, corner - middle);
        }
        self.corners.push(corner);
    }

    /// A face, by its number here.
    #[inline]
    pub fn face(&self, number: usize) -> Option<Face> {
        self.single.get(number).copied()
    }

    /// A corner, by its number here.
    #[inline]
    pub fn corner(&self, number: usize) -> Option<Point> {
        self.corners.get(number).copied()
    }

    /// Shows the numbers of the faces up to `most` m from the middle that may lie in a sector, and others, with the
    /// distance of their block.
    #[inline]
    pub fn faces_in(&self, sector: &Sector, most: f64, mut look: impl FnMut(usize, f64)) {
        let outlines = self.outlines.iter().zip(&self.faces_m);
        for ((outline, &distance), first) in outlines.zip((0..).step_by(LANES)) {
            if distance > most {
                break;
            }
            for lane in lanes(sector.faces(outline)) {
                look(first + lane, distance);
            }
        }
    }

    /// As [`Nearby::faces_in`], of corners, no farther than `along` m along the axis of the sector.
    #[inline]
    pub fn corners_in(
        &self,
        sector: &Sector,
        most: f64,
        along: f64,
        mut look: impl FnMut(usize, f64),
    ) {
        let blocks = self.corner_blocks.iter().zip(&self.corners_m);
        for ((block, &distance), first) in blocks.zip((0..).step_by(LANES)) {
            if distance > most {
                break;
            }
            for lane in lanes(sector.points(block, along)) {
                look(first + lane, distance);
            }
        }
    }
}

/// The places of the ones in a mask, from the lowest.
pub(super) fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (mask != 0).then(|| mask.trailing_zeros() as usize);
        mask &= mask.wrapping_sub(1);
        lane
    })
}
