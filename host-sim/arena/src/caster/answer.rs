//! The nearest answer to a fan of rays, found by few of them.
//!
//! Of all rays that meet one face, those nearest to its normal are the shortest. Each face, the
//! nearest first, is tried by single rays from its normal outwards. Faces beyond the best answer
//! are skipped. All rays together give the same bits.

use super::rays::{Rays, SeenCircle, SeenFace};
use crate::geometry::{Point, clamp};

/// How much beyond an answer things are still looked at, m: far above any rounding.
const SLACK_M: f64 = 1e-3;

/// Rays at equal angles on either side of an axis.
#[derive(Debug, Clone)]
pub(crate) struct Fan {
    rays: Rays,
    count: usize,
    rays_per_rad: f64,
    /// Tangent of an angle a little beyond the outermost rays.
    most_tan: f64,
    half_angle: f64,
}

impl Fan {
    /// `count` rays, at least 2, from −`half_angle` to `half_angle` rad, which lies in (0, π/2).
    #[must_use]
    pub fn new(count: usize, half_angle: f64) -> Self {
        let step = 2.0 * half_angle / (count - 1) as f64;
        let mut rays = Rays::default();
        (0..count).for_each(|i| rays.push(Point::unit(step * i as f64 - half_angle)));
        Self {
            rays,
            count,
            rays_per_rad: 1.0 / step,
            most_tan: libm::tan(half_angle) * 1.02,
            half_angle,
        }
    }

    /// The rays, relative to the axis.
    #[must_use]
    pub fn rays(&self) -> &Rays {
        &self.rays
    }

    /// How many rays there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether [`NearestAnswer`] can compute the places of its rays well enough: up to a quarter of
    /// their distance.
    #[must_use]
    pub fn is_narrow(&self) -> bool {
        self.half_angle <= 0.5 && self.rays_per_rad <= 300.0
    }

    /// Which ray, counted with fractions, has the direction `across` to the left for `along` ahead;
    /// a little more than the outermost for any direction beyond.
    fn place(&self, along: f64, across: f64) -> f64 {
        let most = self.most_tan;
        let tan = if along > 0.0 {
            clamp(across / along, -most, most)
        } else {
            most.copysign(across)
        };
        let squared = tan * tan;
        let angle = tan * (1.0 - squared * (1.0 / 3.0 - squared * (0.2 - squared * (1.0 / 7.0))));
        (angle + self.half_angle) * self.rays_per_rad
    }
}

impl SeenFace {
    /// Whether a ray from the tip meets the face, and the cosine of the angle between it and the
    /// face's normal.
    #[inline]
    fn met_by(&self, ray: Point) -> (bool, f64) {
        let cos = ray.cross(self.u);
        let along = self.q * ray.dot(self.u);
        let end = self.p + self.length;
        let met = (cos > 0.0) & (along >= self.p * cos) & (along <= end * cos);
        (met, cos)
    }
}

impl SeenCircle {
    /// Length of a ray from the tip to the circle, m, if it meets it.
    #[inline]
    fn met_by(&self, ray: Point) -> Option<f64> {
        let across = ray.cross(self.center);
        let depth = self.radius * self.radius - across * across;
        if depth < 0.0 {
            return None;
        }
        let way = ray.dot(self.center) - depth.sqrt();
        (way > 0.0).then_some(way)
    }
}

/// All that a lobe holds; faces from near to far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Things<'a> {
    pub faces: &'a [SeenFace],
    pub circles: &'a [SeenCircle],
}

impl Things<'_> {
    /// Whether a ray meets anything before `way` m; at `way` itself, what comes before `number` in
    /// the world's list.
    #[inline]
    pub fn hide(&self, ray: Point, way: f64, number: f64) -> bool {
        let most = (way + SLACK_M) * (way + SLACK_M);
        let before = |other: f64, its: f64| other < way || (other == way && its < number);
        for face in self.faces {
            if face.near > most {
                break;
            }
            let (met, cos) = face.met_by(ray);
            if met && before(face.q / cos, face.number) {
                return true;
            }
        }
        self.circles.iter().any(|circle| {
            let met = circle.met_by(ray).filter(|_| circle.near <= most);
            met.is_some_and(|other| before(other, circle.number))
        })
    }
}

/// A search for the nearest answer.
pub(super) struct NearestAnswer<'a> {
    pub things: Things<'a>,
    pub fan: &'a Fan,
    /// Where the fan points: a unit vector.
    pub axis: Point,
    /// More rays.
    pub others: &'a [Point],
    /// A face answers where the ray meets it with this cosine at least.
    pub least_cos: f64,
    /// A face whose normal has less than this along the axis answers no ray of the lobe.
    pub least_facing: f64,
    /// The nearest answer so far, m.
    pub best: f64,
}

impl NearestAnswer<'_> {
    /// Finds the nearest answer, m; infinite if there is none.
    pub fn run(&mut self) {
        for face in self.things.faces {
            if self.is_beyond(face.near) {
                break;
            }
            self.ask_face(face);
        }
        for circle in self.things.circles {
            if !self.is_beyond(circle.near) {
                self.ask_circle(circle);
            }
        }
    }

    fn is_beyond(&self, near: f64) -> bool {
        let most = self.best + SLACK_M;
        near > most * most
    }

    fn ray(&self, index: usize) -> Point {
        self.fan.rays.direction(index).turned(self.axis)
    }

    fn ask_face(&mut self, face: &SeenFace) {
        let (axis_u, axis_n) = (self.axis.dot(face.u), self.axis.cross(face.u));
        if axis_n < self.least_facing {
            return;
        }
        for &ray in self.others {
            self.try_face(face, ray);
        }
        let place = |p: f64| {
            let (along, across) = (p * axis_u + face.q * axis_n, p * axis_n - face.q * axis_u);
            self.fan.place(along, across)
        };
        // One ray too early, for rounding. Casts of what is below 0 saturate.
        if face.p > 0.0 {
            let first = (place(face.p) - 1.0) as usize;
            self.ask_left(face, first);
        } else if face.p + face.length < 0.0 {
            let last = (place(face.p + face.length) + 2.0) as usize;
            self.ask_right(face, last + 1);
        } else {
            let left = (place(0.0) + 1.0) as usize;
            self.ask_right(face, left);
            self.ask_left(face, left);
        }
    }

    /// Asks a face by the rays to the left from `first` on, away from its normal.
    fn ask_left(&mut self, face: &SeenFace, first: usize) {
        let end = face.p + face.length;
        for index in first..self.fan.count {
            let ray = self.ray(index);
            if face.q * ray.dot(face.u) > end * ray.cross(face.u) || self.try_face(face, ray) {
                break;
            }
        }
    }

    /// Asks a face by the rays to the right of `left`, away from its normal.
    fn ask_right(&mut self, face: &SeenFace, left: usize) {
        for index in (0..left.min(self.fan.count)).rev() {
            let ray = self.ray(index);
            if face.q * ray.dot(face.u) < face.p * ray.cross(face.u) || self.try_face(face, ray) {
                break;
            }
        }
    }

    /// Takes a face's answer to a ray if it is the best so far. Returns whether rays farther from
    /// the face's normal cannot be better.
    fn try_face(&mut self, face: &SeenFace, ray: Point) -> bool {
        if ray.cross(face.u) < self.least_cos {
            return true;
        }
        let (met, cos) = face.met_by(ray);
        if !met {
            return false;
        }
        let way = face.q / cos;
        if way >= self.best {
            return true;
        }
        let heard = !self.things.hide(ray, way, face.number);
        if heard {
            self.best = way;
        }
        heard
    }

    fn ask_circle(&mut self, circle: &SeenCircle) {
        for &ray in self.others {
            self.try_circle(circle, ray);
        }
        for index in 0..self.fan.count {
            self.try_circle(circle, self.ray(index));
        }
    }

    fn try_circle(&mut self, circle: &SeenCircle, ray: Point) {
        if let Some(way) = circle.met_by(ray).filter(|way| *way < self.best)
            && !self.things.hide(ray, way, circle.number)
        {
            self.best = way;
        }
    }
}
