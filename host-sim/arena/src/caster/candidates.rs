//! Surfaces that may be in a lobe, cached for all tips near one position.
//!
//! It is the caster's only cache. Most transducers keep their direction while the robot moves by
//! millimeters; without the cache a whole step takes more than twice as long. No result depends on
//! it.

use std::sync::Arc;

use super::seen::{FaceInCone, SonarLobe};
use crate::geometry::{Point, max, min};
use crate::surfaces::{Circle, FaceBlock, LANES, SLACK_M, Surfaces};

/// Radius around a tip in which other tips share its candidates, m.
const ROOM_M: f64 = 0.7;

/// The radius plus a margin for rounding, m.
const MARGIN_M: f64 = ROOM_M + SLACK_M;

/// The surfaces that may be in the prepared lobe or one near it.
#[derive(Debug, Clone, Default)]
pub(super) struct Candidates {
    of: Option<Arc<Surfaces>>,
    lobe: SonarLobe,
    pub faces: Vec<FaceInCone>,
    pub circles: Vec<Circle>,
    pub corners: Vec<Point>,
}

impl Candidates {
    /// Collects all surfaces that may be in `lobe`, unless they are cached.
    pub fn prepare(&mut self, surfaces: &Arc<Surfaces>, lobe: &SonarLobe) {
        if !self.are_valid_for(surfaces, lobe) {
            self.find(surfaces, lobe);
            self.of = Some(Arc::clone(surfaces));
            self.lobe = *lobe;
        }
    }

    /// Whether the cached candidates are valid for a lobe.
    fn are_valid_for(&self, surfaces: &Arc<Surfaces>, lobe: &SonarLobe) -> bool {
        let known = self.of.as_ref();
        let moved = lobe.tip - self.lobe.tip;
        let shifted = SonarLobe {
            tip: self.lobe.tip,
            ..*lobe
        };
        known.is_some_and(|known| Arc::ptr_eq(known, surfaces))
            && shifted == self.lobe
            && moved.dot(moved) <= ROOM_M * ROOM_M
    }

    fn find(&mut self, surfaces: &Surfaces, lobe: &SonarLobe) {
        // The disc around the lobe, which is smaller than the one around its tip.
        let middle = lobe.tip + lobe.axis * (lobe.reach_m / 2.0);
        let far = lobe.reach_m * max(0.5, (1.25 - lobe.cone.cos).sqrt()) + MARGIN_M;
        let edges = LobeEdges::of(lobe);
        self.faces.clear();
        surfaces.faces_near(middle, far, |block| {
            let held = edges.may_hold(block);
            let lanes = (0..LANES).filter(|&lane| held[lane]);
            self.faces
                .extend(lanes.filter_map(|lane| lobe.edges_on(block.face(lane))));
        });
        self.circles.clear();
        surfaces.circles_near(middle, far, |circle| self.circles.push(*circle));
        self.corners.clear();
        surfaces.corners_near(middle, far, |corner| {
            if edges.may_hold_corner(corner) {
                self.corners.push(corner);
            }
        });
    }
}

/// The edges of all lobes whose tips are within [`ROOM_M`] of one.
struct LobeEdges {
    tip: Point,
    /// Unit vectors.
    left: Point,
    right: Point,
}

impl LobeEdges {
    fn of(lobe: &SonarLobe) -> Self {
        let edge = |sin: f64| lobe.axis.turned(Point::new(lobe.cone.cos, sin));
        Self {
            tip: lobe.tip,
            left: edge(lobe.cone.sin),
            right: edge(-lobe.cone.sin),
        }
    }

    /// Which faces of a block may be in a lobe with their front to its tip. A shift of the tip
    /// shifts the edges by at most the same distance.
    fn may_hold(&self, block: &FaceBlock) -> [bool; LANES] {
        let mut held = [false; LANES];
        for (i, held) in held.iter_mut().enumerate() {
            let begin = Point::new(block.ax[i], block.ay[i]) - self.tip;
            let side = Point::new(block.ux[i], block.uy[i]);
            let end = begin + side * block.length[i];
            let left = min(self.left.cross(begin), self.left.cross(end));
            let right = max(self.right.cross(begin), self.right.cross(end));
            *held = (begin.cross(side) >= -MARGIN_M) & (left <= MARGIN_M) & (right >= -MARGIN_M);
        }
        held
    }

    fn may_hold_corner(&self, corner: Point) -> bool {
        let corner = corner - self.tip;
        self.left.cross(corner) <= MARGIN_M && self.right.cross(corner) >= -MARGIN_M
    }
}
