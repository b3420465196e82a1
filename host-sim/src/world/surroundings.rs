//! What can be seen or heard around one place: found once for a whole neighbourhood, used as long as the robot stays in it.

use std::sync::Arc;

use super::World;
use super::faces::{FaceBlock, Faces, LANES, clamp};
use super::geometry::Point;
use super::outline::{Outline, Points, Sector};
use super::surfaces::{Circle, Surfaces};
use super::tree::SLACK_M;
use super::view::ConeShape;

/// Places within this distance of where the surroundings were looked at need no new look, m.
const ROOM_M: f64 = 0.5;

/// The surfaces that eyes near one place can see from the front and within their reach, and others: whoever uses them
/// tests each. Reusable.
#[derive(Debug, Clone, Default)]
pub(super) struct Surroundings {
    of: Option<Arc<Surfaces>>,
    middle: Point,
    offset_m: f64,
    reach_m: f64,
    pub faces: Faces,
    /// Of each block of faces.
    pub outlines: Vec<Outline>,
    pub circles: Vec<Circle>,
    pub corners: Vec<Point>,
    /// The corners in blocks, relative to the middle.
    pub corner_blocks: Vec<Points>,
}

impl Surroundings {
    /// Holds afterwards all that eyes can see which are at most `offset_m` from `middle` and see `reach_m` far.
    pub fn look(&mut self, world: &World, middle: Point, offset_m: f64, reach_m: f64) {
        let same = self
            .of
            .as_ref()
            .is_some_and(|of| Arc::ptr_eq(of, &world.surfaces));
        let enough = offset_m <= self.offset_m && reach_m == self.reach_m;
        if same && enough && self.middle.distance(middle) <= ROOM_M {
            return;
        }
        (self.middle, self.offset_m, self.reach_m) = (middle, offset_m, reach_m);
        self.find(&world.surfaces);
        if !same {
            self.of = Some(Arc::clone(&world.surfaces));
        }
    }

    fn find(&mut self, surfaces: &Surfaces) {
        let wide = self.offset_m + ROOM_M + SLACK_M;
        let (middle, reach) = (self.middle, self.reach_m + wide);
        self.faces.clear();
        surfaces.faces_near(middle, reach, |block| {
            let keep = may_answer(block, middle, wide, reach);
            for (lane, _) in keep.into_iter().enumerate().filter(|(_, keep)| *keep) {
                self.faces.push(block.face(lane));
            }
        });
        self.circles.clear();
        surfaces.circles_near(middle, reach, |circle| {
            if middle.distance(circle.center) - circle.radius <= reach {
                self.circles.push(*circle);
            }
        });
        self.corners.clear();
        self.corner_blocks.clear();
        surfaces.corners_near(middle, reach, |corner| {
            if middle.distance(*corner) <= reach {
                self.push_corner(*corner);
            }
        });
        self.outlines.clear();
        for (index, block) in self.faces.blocks.iter().enumerate() {
            let used = LANES.min(self.faces.count() - LANES * index);
            self.outlines.push(Outline::of(block, used, middle, reach));
        }
    }

    fn push_corner(&mut self, corner: Point) {
        let lane = self.corners.len() % LANES;
        if lane == 0 {
            self.corner_blocks.push(Points::NONE);
        }
        if let Some(block) = self.corner_blocks.last_mut() {
            block.set(lane, corner - self.middle);
        }
        self.corners.push(corner);
    }

    /// The cone whose tip and axis are given, as it lies here.
    pub fn sector(&self, tip: Point, axis: Point, cone: ConeShape) -> Sector {
        let reach = self.reach_m + self.offset_m + ROOM_M;
        Sector::new(tip - self.middle, axis, cone, reach)
    }
}

/// Which faces come within `reach` m of `middle` and show their front to a place within `wide` m of it.
fn may_answer(block: &FaceBlock, middle: Point, wide: f64, reach: f64) -> [bool; LANES] {
    let mut keep = [false; LANES];
    for (i, keep) in keep.iter_mut().enumerate() {
        let (dx, dy) = (block.ax[i] - middle.x, block.ay[i] - middle.y);
        let p = dx * block.ux[i] + dy * block.uy[i];
        let q = dx * block.uy[i] - dy * block.ux[i];
        let nearest = clamp(0.0, p, p + block.length[i]);
        *keep = (q > -wide) & (nearest * nearest + q * q <= reach * reach);
    }
    keep
}
