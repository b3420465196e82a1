//! The nearest echo for a fan of rays, with few ray casts.
//!
//! Of all rays that hit a face, those nearest to its normal are the shortest. The search tests each
//! face, the nearest first, with single rays from its normal outwards. It skips faces beyond the
//! best echo. The result is bit-identical to that of casting all rays.

use super::seen::{SLACK_M, SeenCircle, SeenFace, Things};
use crate::geometry::{Point, clamp};

/// Rays at equal angles on either side of an axis.
#[derive(Debug, Clone)]
pub(crate) struct Fan {
    /// Unit vectors, relative to the axis.
    directions: Vec<Point>,
    rays_per_rad: f64,
    /// Tangent of an angle slightly beyond the outermost rays.
    most_tan: f64,
    half_angle: f64,
}

impl Fan {
    /// `count` rays, at least 2, from −`half_angle` to `half_angle` rad, which lies in (0, π/2).
    #[must_use]
    pub fn new(count: usize, half_angle: f64) -> Self {
        let step = 2.0 * half_angle / (count - 1) as f64;
        let direction = |i: usize| Point::unit(step * i as f64 - half_angle);
        Self {
            directions: (0..count).map(direction).collect(),
            rays_per_rad: 1.0 / step,
            most_tan: libm::tan(half_angle) * 1.02,
            half_angle,
        }
    }

    /// The rays as unit vectors, relative to the axis.
    #[must_use]
    pub fn directions(&self) -> &[Point] {
        &self.directions
    }

    /// Whether [`NearestAnswer`] can compute the indices of its rays with an error of at most a
    /// quarter of a ray.
    #[must_use]
    pub fn is_narrow(&self) -> bool {
        self.half_angle <= 0.5 && self.rays_per_rad <= 300.0
    }

    /// Fractional index of the ray with the direction (`along`, `across`), where `across` is to the
    /// left. Directions beyond the fan give an index slightly beyond the outermost ray.
    fn index(&self, along: f64, across: f64) -> f64 {
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

/// A search for the nearest echo.
pub(super) struct NearestAnswer<'a> {
    pub things: Things<'a>,
    pub fan: &'a Fan,
    /// Unit vector in the middle of the fan.
    pub axis: Point,
    /// Additional rays.
    pub others: &'a [Point],
    /// Smallest cosine of the incidence at which a face returns an echo.
    pub least_cos: f64,
    /// Smallest cosine between normal and axis at which a face can return an echo.
    pub least_facing: f64,
    /// The nearest echo so far, m.
    pub best: f64,
}

impl NearestAnswer<'_> {
    /// Finds the nearest echo, m; infinite if there is none.
    pub fn run(&mut self) {
        for face in self.things.faces {
            if self.is_beyond(face.near) {
                break;
            }
            self.test_face(face);
        }
        for circle in self.things.circles {
            if !self.is_beyond(circle.near) {
                self.test_circle(circle);
            }
        }
    }

    fn is_beyond(&self, near: f64) -> bool {
        let most = self.best + SLACK_M;
        near > most * most
    }

    fn test_face(&mut self, face: &SeenFace) {
        let (axis_u, axis_n) = (self.axis.dot(face.u), self.axis.cross(face.u));
        if axis_n < self.least_facing {
            return;
        }
        for &ray in self.others {
            self.try_face(face, ray);
        }
        let ray_index = |p: f64| {
            let (along, across) = (p * axis_u + face.q * axis_n, p * axis_n - face.q * axis_u);
            self.fan.index(along, across)
        };
        // Starts one ray earlier because of rounding. The cast of a negative number gives 0.
        if face.p > 0.0 {
            let first = (ray_index(face.p) - 1.0) as usize;
            self.test_left(face, first);
        } else if face.p + face.length < 0.0 {
            let last = (ray_index(face.p + face.length) + 2.0) as usize;
            self.test_right(face, last + 1);
        } else {
            let left = (ray_index(0.0) + 1.0) as usize;
            self.test_right(face, left);
            self.test_left(face, left);
        }
    }

    /// Tests a face with the rays to the left from `first` on, away from its normal.
    fn test_left(&mut self, face: &SeenFace, first: usize) {
        let end = face.p + face.length;
        let fan = self.fan.directions();
        for direction in fan.get(first..).unwrap_or(&[]) {
            let ray = direction.turned(self.axis);
            if face.q * ray.dot(face.u) > end * ray.cross(face.u) || self.try_face(face, ray) {
                break;
            }
        }
    }

    /// Tests a face with the rays to the right of `left`, away from its normal.
    fn test_right(&mut self, face: &SeenFace, left: usize) {
        let fan = self.fan.directions();
        for direction in fan.iter().take(left).rev() {
            let ray = direction.turned(self.axis);
            if face.q * ray.dot(face.u) < face.p * ray.cross(face.u) || self.try_face(face, ray) {
                break;
            }
        }
    }

    /// Takes a face's echo for a ray if it is the nearest so far. Returns whether rays farther from
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
        let is_visible = !self.things.hide(ray, way, face.number);
        if is_visible {
            self.best = way;
        }
        is_visible
    }

    fn test_circle(&mut self, circle: &SeenCircle) {
        for &ray in self.others {
            self.try_circle(circle, ray);
        }
        for direction in self.fan.directions() {
            self.try_circle(circle, direction.turned(self.axis));
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
