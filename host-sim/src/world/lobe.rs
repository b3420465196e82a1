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
use super::faces::{Face, max, min};
use super::feet::Parallel;
use super::geometry::Point;
use super::nearby::Nearby;
use super::neighbourhoods::Neighbourhoods;
use super::outline::Sector;
use super::rays::{Rays, SeenCircle, SeenFace};
use super::surfaces::Surfaces;
use super::view::{ConeShape, circle_in_cone};

/// How much farther than an answer things are still looked at, m: far above any rounding.
const SLACK_M: f64 = 1e-3;

/// How much nearer than a corner a ray may end and still be said to reach it, m.
const CORNER_SLACK_M: f64 = 1e-6;

/// A lobe: where it begins and where it points.
#[derive(Debug, Clone, Copy, Default)]
struct Lobe {
    tip: Point,
    offset: f64,
    axis: Point,
    cone: ConeShape,
    reach: f64,
}

/// One of several eyes, of which each may look along the same axis again and again.
#[derive(Debug, Clone, Default)]
struct Eye {
    offset: f64,
    axis: Point,
    cone: ConeShape,
    /// In which world.
    world: u64,
    /// Another number whenever one of those is another.
    aim: u64,
    /// Whether it has looked there before: whoever turns looks once.
    is_steady: bool,
    /// Where among all directions those of faces are that rays of the lobe can meet at right angles.
    upright: Vec<usize>,
}

impl Eye {
    fn aim(&mut self, lobe: &Lobe, around: &Neighbourhoods) {
        self.is_steady = self.world == around.worlds()
            && self.axis == lobe.axis
            && self.offset == lobe.offset
            && self.cone == lobe.cone;
        if !self.is_steady {
            (self.offset, self.axis, self.cone) = (lobe.offset, lobe.axis, lobe.cone);
            self.world = around.worlds();
            self.aim += 1;
            self.find_upright(around);
        }
    }

    fn find_upright(&mut self, around: &Neighbourhoods) {
        let (axis, cone) = (self.axis, self.cone);
        let edge = |sin: f64| axis.turned(Point::new(cone.cos, sin));
        self.upright.clear();
        if let Some(feet) = around.surfaces().map(|surfaces| &surfaces.feet) {
            let all = feet.between(edge(-cone.sin), edge(cone.sin));
            let inside = |place: &usize| {
                let group = feet.group(*place);
                group.is_some_and(|group| group.inward.dot(axis) >= cone.cos)
            };
            self.upright.extend(all.filter(inside));
        }
    }
}

/// What one lobe can meet. Reusable: building it again seldom allocates.
#[derive(Debug, Clone, Default)]
pub struct LobeView {
    around: Neighbourhoods,
    eyes: Vec<Eye>,
    eye: usize,
    lobe: Lobe,
    /// The lobe as it lies in its surroundings, and how far from their middle its tip.
    sector: Sector,
    apart_m: f64,
    /// Up to where faces and corners have been looked at, m from the tip.
    far_m: f64,
    /// From near to far.
    faces: Vec<SeenFace>,
    circles: Vec<SeenCircle>,
    corners: Vec<(Point, f64)>,
}

impl LobeView {
    /// Collects what lies in `world` inside the cone around the unit vector `axis`, within `reach_m` of its tip, `offset_m`
    /// from `middle` along the axis, and shows its front.
    pub fn build(
        &mut self,
        world: &World,
        middle: Point,
        offset_m: f64,
        axis: Point,
        cone: ConeShape,
        reach_m: f64,
    ) {
        self.aim(world, middle, offset_m, axis, cone, reach_m);
        self.look(reach_m);
    }

    /// The next lobes are those of this eye, counted from 0: one that looks along the same axis again is asked for less.
    pub fn for_eye(&mut self, eye: usize) -> &mut Self {
        self.eye = eye;
        self
    }

    /// As [`LobeView::build`], for the circles only: see [`LobeView::look`].
    pub fn aim(
        &mut self,
        world: &World,
        middle: Point,
        offset_m: f64,
        axis: Point,
        cone: ConeShape,
        reach_m: f64,
    ) {
        self.around.look(world, middle, offset_m, reach_m);
        let lobe = Lobe {
            tip: middle + axis * offset_m,
            offset: offset_m,
            axis,
            cone,
            reach: reach_m,
        };
        self.lobe = lobe;
        self.sector = self.around.here.sector(lobe.tip, axis, cone);
        self.apart_m = self.around.here.apart_m(lobe.tip);
        self.far_m = 0.0;
        if self.eyes.len() <= self.eye {
            self.eyes.resize_with(self.eye + 1, Eye::default);
        }
        if let Some(eye) = self.eyes.get_mut(self.eye) {
            eye.aim(&self.lobe, &self.around);
        }
        self.circles.clear();
        for circle in self.around.here.circles.iter().chain(&world.posts) {
            let center = circle.center - lobe.tip;
            let near = circle_in_cone(center, circle.radius, axis, cone);
            if near <= reach_m {
                self.circles.push(SeenCircle {
                    center,
                    radius: circle.radius,
                    number: circle.number,
                    near: near * near,
                });
            }
        }
    }

    /// Collects the faces that come within `far_m` of the tip.
    pub fn look(&mut self, far_m: f64) {
        let far = min(far_m, self.lobe.reach);
        let most = far + self.apart_m + SLACK_M;
        self.around.know_faces(most);
        self.around.know_corners();
        self.faces.clear();
        let (lobe, faces) = (&self.lobe, &mut self.faces);
        let eye = self.eyes.get(self.eye);
        nearby(&mut self.around, self.eye, eye).faces_in(&self.sector, most, |face, _| {
            faces.extend(lobe.see(&face, far));
        });
        self.faces
            .sort_unstable_by(|a, b| a.near.total_cmp(&b.near));
        self.far_m = far;
    }

    /// Whether nothing in the lobe lies beyond what has been looked at.
    #[must_use]
    pub fn sees_all(&self) -> bool {
        self.far_m >= self.lobe.reach
    }

    /// Whether nothing that has not been looked at can change an answer from so far, m, or hide it.
    #[must_use]
    pub fn is_settled(&self, range_m: f64) -> bool {
        self.sees_all() || range_m + SLACK_M <= self.far_m
    }

    /// Collects the corners in the lobe that are from `least` to `most` m from its tip, hidden or not: where they are,
    /// relative to the tip, and how far.
    pub fn corners(&mut self, least: f64, most: f64) -> &mut [(Point, f64)] {
        let Lobe {
            tip,
            axis,
            cone,
            reach,
            ..
        } = self.lobe;
        let most = min(most, self.far_m);
        let limit = most + self.apart_m + SLACK_M;
        self.corners.clear();
        let corners = &mut self.corners;
        let keep = |corner: Point, _| {
            let corner = corner - tip;
            let (along, across) = (axis.dot(corner), axis.cross(corner).abs());
            let range = corner.length();
            let inside = across * cone.cos <= along * cone.sin && range <= reach;
            if inside && range >= least && range <= most {
                corners.push((corner, range));
            }
        };
        let eye = self.eyes.get(self.eye);
        nearby(&mut self.around, self.eye, eye).corners_in(&self.sector, limit, most, keep);
        &mut self.corners
    }

    /// How far the nearest corner is that is from `least` to `most` m from the tip and that nothing hides, m.
    pub fn nearest_corner(&mut self, least: f64, most: f64) -> Option<f64> {
        let axis = self.lobe.axis;
        let corners = self.corners(least, most);
        corners.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
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
        if let Some(surfaces) = self.around.surfaces().filter(|_| !self.sees_all()) {
            // Rays towards faces farther off, too, which meet something before.
            let upright = self.eyes.get(self.eye).map(|eye| &eye.upright);
            for &place in upright.into_iter().flatten() {
                let group = surfaces.feet.group(place);
                let Some(group) = group.filter(|group| !others.contains(&group.inward)) else {
                    continue;
                };
                let answer = search.answer_to(group.inward);
                if answer < search.best && self.lobe.sees_foot(group, surfaces) {
                    search.best = answer;
                }
            }
        }
        search.best
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

/// What may lie in a lobe of an eye, and other things.
fn nearby<'a>(around: &'a mut Neighbourhoods, number: usize, eye: Option<&Eye>) -> &'a Nearby {
    match eye.filter(|eye| eye.is_steady) {
        Some(eye) => around.here.chosen(number, eye.aim, eye.offset, eye.axis, eye.cone),
        None => &around.here.nearby,
    }
}

impl Lobe {
    /// A face as it is seen, if any part of it lies in the lobe within `far` m of its tip.
    #[inline]
    fn see(&self, face: &Face, far: f64) -> Option<SeenFace> {
        let ConeShape { sin, cos } = self.cone;
        let offset = face.a - self.tip;
        let (p, q) = (offset.dot(face.u), offset.cross(face.u));
        let (axis_u, axis_n) = (self.axis.dot(face.u), self.axis.cross(face.u));
        let (left_n, left_u) = (axis_n * cos - axis_u * sin, axis_u * cos + axis_n * sin);
        let (right_n, right_u) = (axis_n * cos + axis_u * sin, axis_u * cos - axis_n * sin);
        let (met_left, met_right) = (left_n > 0.0, right_n > 0.0);
        if q <= 0.0 || q * q > far * far || !(met_left || met_right) {
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
        let faces = group.around(self.tip);
        let faces = faces.filter_map(|place| surfaces.faces.get(place));
        let mut seen = faces.filter_map(|face| self.see(&face, self.reach));
        seen.any(|face| face.has_foot())
    }
}
