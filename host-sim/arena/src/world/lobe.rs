//! What one lobe can meet.
//!
//! A [`LobeView`] holds the faces, circles and corners that one lobe can meet, so that a fan of rays pays only for those.
//! Rays meet them in two ways: all rays at once ([`LobeView::meet`]), or as few as tell the nearest answer
//! ([`LobeView::nearest_answer`]).
//!
//! A lobe is looked at from near to far. What lies no farther than some distance settles every answer from within it, for
//! what is farther hides nothing before it, with one exception: rays aimed at the feet of perpendiculars on hidden faces
//! meet what is before those, and perhaps better than others do. Such feet are looked up by [direction](super::feet).

use super::World;
use super::answer::{Fan, Search, Things};
use super::eye::Eye;
use super::faces::{Face, max, min};
use super::feet::Parallel;
use super::geometry::Point;
use super::neighborhoods::Neighborhoods;
use super::outline::Sector;
use super::rays::{Rays, SeenCircle, SeenFace};
use super::steady::Station;
use super::surfaces::{Circle, Surfaces};
use super::view::{ConeShape, circle_in_cone};

/// How much farther than an answer things are still looked at, m: far above any rounding.
const SLACK_M: f64 = 1e-3;

/// How much nearer than a corner a ray may end and still be said to reach it, m.
const CORNER_SLACK_M: f64 = 1e-6;

/// A lobe: a cone whose tip lies off a place, along its axis.
#[derive(Debug, Clone, Copy, Default)]
pub struct Lobe {
    /// The place.
    pub middle: Point,
    /// How far off the tip lies, m.
    pub offset_m: f64,
    /// A unit vector.
    pub axis: Point,
    /// How wide it is.
    pub cone: ConeShape,
    /// How far it reaches from its tip, m.
    pub reach_m: f64,
}

impl Lobe {
    /// Where its tip is.
    #[must_use]
    pub fn tip(&self) -> Point {
        self.middle + self.axis * self.offset_m
    }
}

/// The first look at what lies in a lobe.
#[derive(Debug, Clone, Copy)]
enum FirstLook {
    /// Of an eye whose things have been chosen.
    Steady(Station),
    Any(Sector),
}

impl Default for FirstLook {
    fn default() -> Self {
        Self::Any(Sector::default())
    }
}

/// What one lobe can meet. Reusable: building it again seldom allocates.
#[derive(Debug, Clone, Default)]
pub struct LobeView {
    around: Neighborhoods,
    eyes: Vec<Eye>,
    eye: usize,
    lobe: Lobe,
    tip: Point,
    first_look: FirstLook,
    /// How far from the middle of the surroundings the tip lies.
    apart_m: f64,
    /// Up to where faces and corners have been looked at, m from the tip.
    far_m: f64,
    /// From near to far.
    faces: Vec<SeenFace>,
    circles: Vec<SeenCircle>,
    corners: Vec<(Point, f64)>,
}

impl LobeView {
    /// Collects what lies in `world` inside a lobe and shows its front.
    pub fn build(&mut self, world: &World, lobe: &Lobe) {
        self.aim(world, lobe);
        self.look(lobe.reach_m);
    }

    /// The next lobes are those of this eye, counted from 0: one that looks along the same axis again is asked for less.
    pub fn for_eye(&mut self, eye: usize) -> &mut Self {
        self.eye = eye;
        if self.eyes.len() <= eye {
            self.eyes.resize_with(eye + 1, Eye::default);
        }
        self
    }

    /// As [`LobeView::build`], for the circles only: see [`LobeView::look`].
    pub fn aim(&mut self, world: &World, lobe: &Lobe) {
        self.around
            .look(world, lobe.middle, lobe.offset_m, lobe.reach_m);
        (self.lobe, self.tip) = (*lobe, lobe.tip());
        self.aim_eye();
        self.apart_m = self.around.here.apart_m(self.tip);
        self.far_m = 0.0;
        self.circles.clear();
        if !(self.around.here.circles.is_empty() && world.posts.is_empty()) {
            self.find_circles(&world.posts);
        }
    }

    #[inline(never)]
    fn find_circles(&mut self, posts: &[Circle]) {
        let Lobe { axis, cone, .. } = self.lobe;
        for circle in self.around.here.circles.iter().chain(posts) {
            let center = circle.center - self.tip;
            let near = circle_in_cone(center, circle.radius, axis, cone);
            if near <= self.lobe.reach_m {
                self.circles.push(SeenCircle {
                    center,
                    radius: circle.radius,
                    number: circle.number,
                    near: near * near,
                });
            }
        }
    }

    fn aim_eye(&mut self) {
        if self.eyes.is_empty() {
            self.for_eye(self.eye);
        }
        let Some(eye) = self.eyes.get_mut(self.eye) else {
            return;
        };
        let (tip, here) = (self.tip, &self.around.here);
        self.first_look = if eye.looks(&self.lobe, &self.around) {
            FirstLook::Steady(here.station(tip, &eye.aim))
        } else {
            FirstLook::Any(here.sector(tip, &eye.aim))
        };
    }

    /// Collects the faces that come within `far_m` of the tip.
    pub fn look(&mut self, far_m: f64) {
        let far = min(far_m, self.lobe.reach_m);
        let most = far + self.apart_m + SLACK_M;
        self.around.know_faces(most);
        self.around.know_corners();
        self.faces.clear();
        let (lobe, tip) = (&self.lobe, self.tip);
        let (faces, here) = (&mut self.faces, &mut self.around.here);
        if let (FirstLook::Steady(_), Some(eye)) = (&self.first_look, self.eyes.get(self.eye)) {
            here.choose(self.eye, &eye.aim);
        }
        let mut see = |number| {
            if let Some(face) = here.nearby.face(number)
                && let Some(face) = lobe.see(tip, &face, far)
            {
                faces.push(face);
            }
        };
        match self.first_look {
            FirstLook::Any(sector) => here.nearby.faces_in(&sector, most, |number, _| see(number)),
            FirstLook::Steady(station) => {
                if let Some(chosen) = here.chosen(self.eye) {
                    chosen.faces.each_in(&station, most, far, see);
                }
            }
        }
        if self.faces.len() > 1 {
            self.faces
                .sort_unstable_by(|a, b| a.near.total_cmp(&b.near));
        }
        self.far_m = far;
    }

    /// Whether nothing in the lobe lies beyond what has been looked at.
    #[must_use]
    pub fn sees_all(&self) -> bool {
        self.far_m >= self.lobe.reach_m
    }

    /// Whether nothing that has not been looked at can change an answer from so far, m, or hide it.
    #[must_use]
    pub fn is_settled(&self, range_m: f64) -> bool {
        self.sees_all() || range_m + SLACK_M <= self.far_m
    }

    /// Collects the corners in the lobe that are from `least` to `most` m from its tip, hidden or not: where they are,
    /// relative to the tip, and how far.
    pub fn corners(&mut self, least: f64, most: f64) -> &mut [(Point, f64)] {
        let (Lobe { axis, cone, .. }, tip) = (self.lobe, self.tip);
        let most = min(most, self.far_m);
        let limit = most + self.apart_m + SLACK_M;
        self.corners.clear();
        let (corners, here) = (&mut self.corners, &self.around.here);
        let mut keep = |number| {
            let Some(corner) = here.nearby.corner(number) else {
                return;
            };
            let corner = corner - tip;
            let (along, across) = (axis.dot(corner), axis.cross(corner).abs());
            if across * cone.cos <= along * cone.sin {
                let range = corner.length();
                if range >= least && range <= most {
                    corners.push((corner, range));
                }
            }
        };
        match self.first_look {
            FirstLook::Any(sector) => here
                .nearby
                .corners_in(&sector, limit, most, |number, _| keep(number)),
            FirstLook::Steady(station) => {
                if let Some(chosen) = here.chosen(self.eye) {
                    chosen.corners.each_in(&station, limit, most, keep);
                }
            }
        }
        &mut self.corners
    }

    /// How far the nearest corner is that is from `least` to `most` m from the tip and that nothing hides, m.
    pub fn nearest_corner(&mut self, least: f64, most: f64) -> Option<f64> {
        let axis = self.lobe.axis;
        let corners = self.corners(least, most);
        match corners {
            [] => return None,
            [_] => {}
            _ => corners.sort_unstable_by(|a, b| a.1.total_cmp(&b.1)),
        }
        let things = Things {
            faces: &self.faces,
            circles: &self.circles,
        };
        let shown = self.corners.iter().find(|&&(corner, range)| {
            let towards = if range > 0.0 {
                corner * (1.0 / range)
            } else {
                axis
            };
            !things.hide(towards, range - CORNER_SLACK_M, f64::NEG_INFINITY)
        });
        shown.map(|(_, range)| *range)
    }

    /// Length, m, of the shortest of the rays of a [narrow](Fan::is_narrow) fan along the lobe's axis, as wide as the
    /// lobe, and of those at the [places most likely to answer](LobeView::promising) in the lobe, that meets a circle, or
    /// a face with a cosine of at least `least_cos`, before anything else; infinite if none does. `least_facing` is the
    /// least cosine between the axis and a normal that any ray of the lobe meets so. The answer holds as far as it
    /// [is settled](LobeView::is_settled); `others` are the directions of [`LobeView::promising`] in the lobe.
    #[must_use]
    pub fn nearest_answer(
        &self,
        fan: &Fan,
        others: &[Point],
        least_cos: f64,
        least_facing: f64,
    ) -> f64 {
        let axis = self.lobe.axis;
        let mut search = Search {
            things: Things {
                faces: &self.faces,
                circles: &self.circles,
            },
            fan,
            axis,
            others,
            least_cos,
            least_facing,
            best: f64::INFINITY,
        };
        search.run();
        let eye = self.eyes.get(self.eye);
        if let Some(eye) = eye.filter(|eye| !eye.upright.is_empty() && !self.sees_all()) {
            self.ask_upright(eye, &mut search);
        }
        search.best
    }

    /// Asks by rays towards faces farther off, too, which meet something before.
    fn ask_upright(&self, eye: &Eye, search: &mut Search) {
        let Some(surfaces) = self.around.surfaces() else {
            return;
        };
        for upright in &eye.upright {
            if search.others.contains(&upright.inward) {
                continue;
            }
            let answer = search.answer_to(upright.inward);
            if answer < search.best {
                let mut groups = upright
                    .places
                    .clone()
                    .filter_map(|place| surfaces.feet.group(place));
                if groups.any(|group| self.lobe.sees_foot(group, surfaces)) {
                    search.best = answer;
                }
            }
        }
    }

    /// The lobe aimed at.
    #[must_use]
    pub fn lobe(&self) -> &Lobe {
        &self.lobe
    }

    /// Lets the rays, which must not leave the lobe, meet what lies in it up to `far` m from its tip, and perhaps more.
    pub fn meet(&self, rays: &mut Rays, far: f64) {
        let most = (far + SLACK_M) * (far + SLACK_M);
        for face in self.faces.iter().filter(|face| face.near <= most) {
            rays.meet_face(face);
        }
        for circle in self.circles.iter().filter(|circle| circle.near <= most) {
            rays.meet_circle(circle);
        }
    }

    /// Unit vectors from the tip towards the places most likely to answer: the foot of the perpendicular
    /// on each face that has one, and the middle of each circle. They may lie outside the lobe.
    pub fn promising(&self) -> impl Iterator<Item = Point> + '_ {
        let feet = self.faces.iter();
        let feet = feet.filter(|face| face.has_foot());
        let feet = feet.map(|face| Point::new(face.u.y, -face.u.x));
        let middles = self.circles.iter().map(|circle| {
            let length = circle.center.length();
            circle.center * (1.0 / length)
        });
        feet.chain(middles)
    }

    /// Unit vector from a face of the lobe, by its number, at right angles to it; `None` for what is no such face.
    #[must_use]
    pub fn normal(&self, number: f64) -> Option<Point> {
        let face = self.faces.iter().find(|face| face.number == number);
        face.map(|face| Point::new(-face.u.y, face.u.x))
    }
}

impl Lobe {
    /// A face as it is seen, if any part of it lies in the lobe within `far` m of its tip, which is `tip`.
    #[inline]
    fn see(&self, tip: Point, face: &Face, far: f64) -> Option<SeenFace> {
        let ConeShape { sin, cos } = self.cone;
        let offset = face.a - tip;
        let (p, q) = (offset.dot(face.u), offset.cross(face.u));
        if q <= 0.0 || q * q > far * far {
            return None;
        }
        let (axis_u, axis_n) = (self.axis.dot(face.u), self.axis.cross(face.u));
        let (left_n, left_u) = (axis_n * cos - axis_u * sin, axis_u * cos + axis_n * sin);
        let (right_n, right_u) = (axis_n * cos + axis_u * sin, axis_u * cos - axis_n * sin);
        let (met_left, met_right) = (left_n > 0.0, right_n > 0.0);
        if !(met_left || met_right) {
            return None;
        }
        // An edge of the cone that runs away from the face bounds nothing.
        let left = if met_left {
            q * left_u / left_n
        } else {
            f64::INFINITY
        };
        let right = if met_right {
            q * right_u / right_n
        } else {
            f64::NEG_INFINITY
        };
        let (from, to) = (max(p, right), min(p + face.length, left));
        let nearest = max(from, min(to, 0.0));
        let near = nearest * nearest + q * q;
        (from <= to && near <= far * far).then_some(SeenFace {
            u: face.u,
            p,
            q,
            length: face.length,
            number: face.number,
            near,
        })
    }

    /// Whether a face of this direction lies in the lobe with the foot of the perpendicular from its tip.
    fn sees_foot(&self, group: &Parallel, surfaces: &Surfaces) -> bool {
        let tip = self.tip();
        let faces = group.around(tip);
        let faces = faces.filter_map(|place| surfaces.faces.get(place));
        let mut seen = faces.filter_map(|face| self.see(tip, &face, self.reach_m));
        seen.any(|face| face.has_foot())
    }
}
