//! What can be seen or heard around one place: found once for a whole neighbourhood, used as long as the robot stays in it.

use std::sync::Arc;

use super::World;
use super::faces::{Face, FaceBlock, LANES, clamp, max, min};
use super::geometry::Point;
use super::nearby::Nearby;
use super::outline::Sector;
use super::surfaces::{Circle, Surfaces};
use super::tree::SLACK_M;
use super::view::ConeShape;

/// Places within this distance of where the surroundings were looked at need no new look, m.
const ROOM_M: f64 = 0.8;

/// How much farther is looked when it was not far enough.
const FARTHER: f64 = 1.5;

/// The surfaces that eyes near one place can see from the front and within their reach, and others: whoever uses them
/// tests each. Faces and corners stand from near to far and are known [only so far](Surroundings::known_m) as was asked
/// for: in a crowd what lies behind the nearest things is never looked at. Reusable.
#[derive(Debug, Clone, Default)]
pub(super) struct Surroundings {
    of: Option<Arc<Surfaces>>,
    middle: Point,
    offset_m: f64,
    reach_m: f64,
    faces_known_m: f64,
    corners_known_m: f64,
    /// How often faces or corners have been found.
    looks: u64,
    pub nearby: Nearby,
    pub circles: Vec<Circle>,
    /// Scratch.
    faces_found: Found<Face>,
    corners_found: Found<Point>,
}

/// Things found in any order, to be put in order of distance.
#[derive(Debug, Clone, Default)]
struct Found<T> {
    things: Vec<T>,
    /// Squared distance, m², and place among the things; distances as the bits of `f32`, whose order is theirs.
    order: Vec<u64>,
}

impl<T: Copy> Found<T> {
    fn clear(&mut self) {
        self.things.clear();
        self.order.clear();
    }

    fn push(&mut self, squared: f64, thing: T) {
        let key = u64::from((squared as f32).to_bits());
        self.order.push(key << 32 | self.things.len() as u64);
        self.things.push(thing);
    }

    /// The things and their distances, m, from near to far.
    fn sorted(&mut self) -> impl Iterator<Item = (f64, T)> {
        self.order.sort_unstable();
        self.order.iter().filter_map(|key| {
            let squared = f32::from_bits((key >> 32) as u32);
            let thing = self.things.get(*key as u32 as usize)?;
            Some((f64::from(squared).sqrt(), *thing))
        })
    }
}

impl Surroundings {
    /// Makes ready for eyes which are at most `offset_m` from `middle` and see `reach_m` far: holds all circles afterwards.
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
        if !same {
            self.of = Some(Arc::clone(&world.surfaces));
        }
        (self.faces_known_m, self.corners_known_m) = (0.0, 0.0);
        self.nearby.clear_corners();
        self.find_circles(&world.surfaces);
        self.know_faces(offset_m + ROOM_M + world.surfaces.crowd_m);
    }

    /// How far eyes can be from the middle, m.
    fn wide_m(&self) -> f64 {
        self.offset_m + ROOM_M + SLACK_M
    }

    /// How far from the middle whatever eyes can see lies, m.
    fn whole_m(&self) -> f64 {
        self.reach_m + self.wide_m()
    }

    /// Up to which distance from the middle faces are known, m; infinite if all are that eyes can see.
    pub fn known_m(&self) -> f64 {
        if self.faces_known_m < self.whole_m() {
            self.faces_known_m
        } else {
            f64::INFINITY
        }
    }

    /// All that stands still in the world.
    pub fn surfaces(&self) -> Option<&Surfaces> {
        self.of.as_deref()
    }

    /// How far a place is from the middle, m.
    pub fn apart_m(&self, place: Point) -> f64 {
        self.middle.distance(place)
    }

    /// Knows the faces up to `far_m` from the middle afterwards, and perhaps more.
    pub fn know_faces(&mut self, far_m: f64) {
        if let Some(far_m) = farther(self.faces_known_m, far_m, self.whole_m())
            && let Some(surfaces) = self.of.take()
        {
            self.faces_known_m = far_m;
            self.find_faces(&surfaces);
            self.of = Some(surfaces);
        }
    }

    /// As [`Surroundings::know_faces`], of corners.
    pub fn know_corners(&mut self, far_m: f64) {
        if let Some(far_m) = farther(self.corners_known_m, far_m, self.whole_m())
            && let Some(surfaces) = self.of.take()
        {
            self.corners_known_m = far_m;
            self.find_corners(&surfaces);
            self.of = Some(surfaces);
        }
    }

    fn find_circles(&mut self, surfaces: &Surfaces) {
        let (middle, reach) = (self.middle, self.whole_m());
        self.circles.clear();
        surfaces.circles_near(middle, reach, |circle| {
            if middle.distance(circle.center) - circle.radius <= reach {
                self.circles.push(*circle);
            }
        });
    }

    fn find_faces(&mut self, surfaces: &Surfaces) {
        let (middle, reach, wide) = (self.middle, self.faces_known_m, self.wide_m());
        self.faces_found.clear();
        surfaces.faces_near(middle, reach, |block| {
            let squared = may_answer(block, middle, wide);
            for (lane, squared) in squared.into_iter().enumerate() {
                if squared <= reach * reach {
                    self.faces_found.push(squared, block.face(lane));
                }
            }
        });
        let whole = self.whole_m();
        self.nearby.clear_faces();
        for (distance, face) in self.faces_found.sorted() {
            self.nearby.push_face(distance, &face, middle, whole);
        }
        self.looks += 1;
    }

    fn find_corners(&mut self, surfaces: &Surfaces) {
        let (middle, reach) = (self.middle, self.corners_known_m);
        self.corners_found.clear();
        surfaces.corners_near(middle, reach, |&corner| {
            let offset = corner - middle;
            let squared = offset.dot(offset);
            if squared <= reach * reach {
                self.corners_found.push(squared, corner);
            }
        });
        self.nearby.clear_corners();
        for (distance, corner) in self.corners_found.sorted() {
            self.nearby.push_corner(distance, corner, middle);
        }
        self.looks += 1;
    }

    /// Another number whenever faces or corners are others.
    pub fn looks(&self) -> u64 {
        self.looks
    }

    /// Chooses into `chosen` what is nearby and may lie in the cone around `axis` of any eye `offset_m` along that axis.
    pub fn choose(&self, offset_m: f64, axis: Point, cone: ConeShape, chosen: &mut Nearby) {
        let (middle, whole) = (self.middle, self.whole_m());
        let sector = Sector::new(axis * offset_m, axis, cone, whole).widened(ROOM_M);
        chosen.clear_faces();
        chosen.clear_corners();
        let all = f64::INFINITY;
        self.nearby.faces_in(&sector, all, |face, distance| {
            chosen.push_face(distance, &face, middle, whole);
        });
        self.nearby
            .corners_in(&sector, all, all, |corner, distance| {
                chosen.push_corner(distance, corner, middle);
            });
    }

    /// The cone whose tip and axis are given, as it lies here.
    pub fn sector(&self, tip: Point, axis: Point, cone: ConeShape) -> Sector {
        Sector::new(tip - self.middle, axis, cone, self.whole_m())
    }
}

/// How far to look so that things are known up to `far` m and no farther than `whole`, where `known` m are known; `None` if
/// they are.
fn farther(known: f64, far: f64, whole: f64) -> Option<f64> {
    let enough = known >= min(far, whole);
    (!enough).then(|| min(max(far, FARTHER * known), whole))
}

/// Squared distance from `middle` to each face of a block that shows its front to a place within `wide` m of it, m²;
/// infinite for the others.
fn may_answer(block: &FaceBlock, middle: Point, wide: f64) -> [f64; LANES] {
    let mut squared = [0.0; LANES];
    for (i, squared) in squared.iter_mut().enumerate() {
        let (dx, dy) = (block.ax[i] - middle.x, block.ay[i] - middle.y);
        let p = dx * block.ux[i] + dy * block.uy[i];
        let q = dx * block.uy[i] - dy * block.ux[i];
        let nearest = clamp(0.0, p, p + block.length[i]);
        let shown = nearest * nearest + q * q;
        *squared = if q > -wide { shown } else { f64::INFINITY };
    }
    squared
}
