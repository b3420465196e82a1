//! What can be seen or heard around one place: found once for a whole neighborhood, used as long as the robot stays in it.

use super::faces::{FaceBlock, LANES, clamp, max, min};
use super::geometry::Point;
use super::nearby::Nearby;
use super::outline::{Piece, Sector};
use super::steady::{Aim, Station, Steady};
use super::surfaces::{Circle, Surfaces};
use super::tree::SLACK_M;

/// Places within this distance of where the surroundings were looked at need no new look, m.
const ROOM_M: f64 = 0.7;

/// How much farther is looked when it was not far enough.
const FARTHER: f64 = 1.5;

/// The surfaces that eyes near one place can see from the front and within their reach, and others: whoever uses them
/// tests each. Faces and corners stand from near to far and are known [only so far](Surroundings::known_m) as was asked
/// for: in a crowd what lies behind the nearest things is never looked at. Reusable.
#[derive(Debug, Clone, Default)]
pub(super) struct Surroundings {
    middle: Point,
    offset_m: f64,
    reach_m: f64,
    faces_known_m: f64,
    corners_known_m: f64,
    /// How often faces or corners have been found.
    looks: u64,
    pub nearby: Nearby,
    pub circles: Vec<Circle>,
    /// Of each eye.
    chosen: Vec<Chosen>,
}

/// What is nearby and may lie in the lobes of one steady eye from anywhere here.
#[derive(Debug, Clone, Default)]
pub(super) struct Chosen {
    /// For which aim, and after how many looks: another choice is none.
    made: (u64, u64),
    pub faces: Steady,
    pub corners: Steady,
}

/// Things found in any order, to be put in order of distance.
struct Found<T> {
    things: Vec<T>,
    /// Squared distance, m², and place among the things; distances as the bits of `f32`, whose order is theirs.
    order: Vec<u64>,
}

impl<T> Default for Found<T> {
    fn default() -> Self {
        Self {
            things: Vec::new(),
            order: Vec::new(),
        }
    }
}

impl<T: Copy> Found<T> {
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
    /// Begins anew, for eyes which are at most `offset_m` from `middle` and see `reach_m` far: holds all circles afterwards.
    pub fn begin(&mut self, surfaces: &Surfaces, middle: Point, offset_m: f64, reach_m: f64) {
        (self.middle, self.offset_m, self.reach_m) = (middle, offset_m, reach_m);
        (self.faces_known_m, self.corners_known_m) = (0.0, 0.0);
        self.nearby.clear_corners();
        self.find_circles(surfaces);
        self.know_faces(surfaces, offset_m + ROOM_M + surfaces.crowd_m);
    }

    /// Whether they are those of such eyes.
    #[inline]
    pub fn holds(&self, middle: Point, offset_m: f64, reach_m: f64) -> bool {
        let apart = middle - self.middle;
        offset_m <= self.offset_m && reach_m == self.reach_m && apart.dot(apart) <= ROOM_M * ROOM_M
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

    /// Knows the faces up to `far_m` from the middle afterwards, and perhaps more.
    #[inline]
    pub fn know_faces(&mut self, surfaces: &Surfaces, far_m: f64) {
        let (known, whole) = (self.faces_known_m, self.whole_m());
        if known < min(far_m, whole) {
            self.faces_known_m = min(max(far_m, FARTHER * known), whole);
            self.find_faces(surfaces);
        }
    }

    /// Knows the corners as far as the faces afterwards, and the faces one by one.
    #[inline]
    pub fn know_corners(&mut self, surfaces: &Surfaces) {
        if self.corners_known_m < self.faces_known_m {
            self.corners_known_m = self.faces_known_m;
            self.nearby.single_out();
            self.find_corners(surfaces);
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

    #[cold]
    fn find_faces(&mut self, surfaces: &Surfaces) {
        let (middle, reach, wide) = (self.middle, self.faces_known_m, self.wide_m());
        let mut found = Found::default();
        surfaces.faces_near(middle, reach, |block| {
            let squared = may_answer(block, middle, wide);
            for (lane, squared) in squared.into_iter().enumerate() {
                if squared <= reach * reach {
                    found.push(squared, block.face(lane));
                }
            }
        });
        let whole = self.whole_m();
        self.nearby.clear_faces();
        for (distance, face) in found.sorted() {
            self.nearby.push_face(distance, &face, middle, whole);
        }
        self.looks += 1;
    }

    #[cold]
    fn find_corners(&mut self, surfaces: &Surfaces) {
        let (middle, reach) = (self.middle, self.corners_known_m);
        let mut found = Found::default();
        surfaces.corners_near(middle, reach, |&corner| {
            let offset = corner - middle;
            let squared = offset.dot(offset);
            if squared <= reach * reach {
                found.push(squared, corner);
            }
        });
        self.nearby.clear_corners();
        for (distance, corner) in found.sorted() {
            self.nearby.push_corner(distance, corner, middle);
        }
        self.looks += 1;
    }

    /// What is nearby and may lie in the lobes of eye number `eye` from anywhere here, once [chosen](Surroundings::choose).
    #[inline]
    pub fn chosen(&self, eye: usize) -> Option<&Chosen> {
        self.chosen.get(eye)
    }

    /// Chooses for eye number `eye`.
    #[inline]
    pub fn choose(&mut self, eye: usize, aim: &Aim) {
        let made = (aim.number, self.looks);
        let chosen = self.chosen.get(eye);
        if chosen.is_none_or(|chosen| chosen.made != made) {
            self.choose_anew(eye, aim);
        }
    }

    #[cold]
    fn choose_anew(&mut self, eye: usize, aim: &Aim) {
        let (middle, whole) = (self.middle, self.whole_m());
        if self.chosen.len() <= eye {
            self.chosen.resize_with(eye + 1, Chosen::default);
        }
        let Some(chosen) = self.chosen.get_mut(eye) else {
            return;
        };
        chosen.made = (aim.number, self.looks);
        chosen.faces.clear();
        chosen.corners.clear();
        let sector = Sector::new(aim.axis * aim.offset_m, aim, whole).widened(ROOM_M);
        let all = f64::INFINITY;
        self.nearby.faces_in(&sector, all, |number, distance| {
            if let Some(face) = self.nearby.face(number) {
                let piece = Piece::of(&face, middle, whole);
                let ends = [piece.begin, piece.end];
                chosen.faces.push(distance, number, ends, aim);
            }
        });
        self.nearby
            .corners_in(&sector, all, all, |number, distance| {
                if let Some(corner) = self.nearby.corner(number) {
                    chosen
                        .corners
                        .push(distance, number, [corner - middle; 2], aim);
                }
            });
    }

    /// How far from the middle a place is, m.
    pub fn apart_m(&self, place: Point) -> f64 {
        self.middle.distance(place)
    }

    /// The cone that points as aimed from `tip`, as it lies here.
    #[inline]
    pub fn sector(&self, tip: Point, aim: &Aim) -> Sector {
        Sector::new(tip - self.middle, aim, self.whole_m())
    }

    /// A steady eye at `tip`, as it stands here.
    #[inline]
    pub fn station(&self, tip: Point, aim: &Aim) -> Station {
        Station::new(tip - self.middle, aim, self.whole_m())
    }
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
