//! A lobe, faces and circles relative to its tip, and ray casts from there.

use super::cone::{ConeShape, circle_in_cone};
use crate::geometry::{Point, max, min};
use crate::surfaces::{Circle, Face};

/// Margin for rounding behind the end of a ray, m.
pub(super) const SLACK_M: f64 = 1e-3;

/// A lobe: the cone in which a transducer receives echoes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SonarLobe {
    /// Position of its tip.
    pub tip: Point,
    /// A unit vector.
    pub axis: Point,
    /// Its half angle.
    pub cone: ConeShape,
    /// Its length from the tip, m.
    pub reach_m: f64,
}

impl SonarLobe {
    /// A circle relative to the tip, if any part of it is in the lobe.
    pub(super) fn see_circle(&self, circle: &Circle) -> Option<SeenCircle> {
        let center = circle.center - self.tip;
        let near = circle_in_cone(center, circle.radius, self.axis, self.cone);
        (near <= self.reach_m).then_some(SeenCircle {
            center,
            radius: circle.radius,
            number: circle.number,
            near: near * near,
        })
    }

    /// A face with the edges of the lobe, if its front can face them. Both are the same for all
    /// lobes in this direction.
    pub(super) fn edges_on(&self, face: Face) -> Option<FaceInCone> {
        let ConeShape { sin, cos } = self.cone;
        let (axis_u, axis_n) = (self.axis.dot(face.u), self.axis.cross(face.u));
        let (left_n, left_u) = (axis_n * cos - axis_u * sin, axis_u * cos + axis_n * sin);
        let (right_n, right_u) = (axis_n * cos + axis_u * sin, axis_u * cos - axis_n * sin);
        // An edge of the cone that points away from the face is no limit.
        let (meets_left, meets_right) = (left_n > 0.0, right_n > 0.0);
        (meets_left || meets_right).then(|| FaceInCone {
            face,
            left: if meets_left {
                left_u / left_n
            } else {
                f64::INFINITY
            },
            right: if meets_right {
                right_u / right_n
            } else {
                f64::NEG_INFINITY
            },
        })
    }

    /// A face relative to the tip, if any part of it is in the lobe.
    #[inline]
    pub(super) fn see(&self, FaceInCone { face, left, right }: &FaceInCone) -> Option<SeenFace> {
        let far = self.reach_m;
        let offset = face.a - self.tip;
        let (p, q) = (offset.dot(face.u), offset.cross(face.u));
        if q <= 0.0 || q * q > far * far {
            return None;
        }
        let (from, to) = (max(p, q * right), min(p + face.length, q * left));
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
}

/// A face, and where the edges of a cone intersect its line: along the face from the foot of the
/// perpendicular from the tip, per meter of distance from the tip.
#[derive(Debug, Clone, Copy)]
pub(super) struct FaceInCone {
    face: Face,
    left: f64,
    right: f64,
}

/// A face relative to the tip of a lobe.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenFace {
    /// Unit vector along the face.
    pub u: Point,
    /// Its start along `u`, from the foot of the perpendicular from the tip, m.
    pub p: f64,
    /// Distance of its line from the tip, m.
    pub q: f64,
    pub length: f64,
    pub number: f64,
    /// Squared distance of the nearest point within the lobe, m².
    pub near: f64,
}

impl SeenFace {
    /// Whether it contains the foot of the perpendicular from the tip.
    pub fn has_foot(&self) -> bool {
        self.p <= 0.0 && self.p + self.length >= 0.0
    }

    /// Whether a ray from the tip hits the face, and the cosine of the angle between it and the
    /// face's normal.
    #[inline]
    pub fn met_by(&self, ray: Point) -> (bool, f64) {
        let cos = ray.cross(self.u);
        let along = self.q * ray.dot(self.u);
        let end = self.p + self.length;
        let met = (cos > 0.0) & (along >= self.p * cos) & (along <= end * cos);
        (met, cos)
    }
}

/// A circle relative to the tip of a lobe.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenCircle {
    pub center: Point,
    pub radius: f64,
    pub number: f64,
    pub near: f64,
}

impl SeenCircle {
    /// Length of a ray from the tip to the circle, m, if it hits it.
    #[inline]
    pub fn met_by(&self, ray: Point) -> Option<f64> {
        let across = ray.cross(self.center);
        let depth = self.radius * self.radius - across * across;
        if depth < 0.0 {
            return None;
        }
        let distance_m = ray.dot(self.center) - depth.sqrt();
        (distance_m > 0.0).then_some(distance_m)
    }
}

/// The first hit of a ray in a lobe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LobeHit {
    /// Length of the ray, m.
    pub distance_m: f64,
    /// Cosine of the angle between the ray and the normal of a face; 1 for a circle.
    pub cos_incidence: f64,
    /// Number of the surface: a face's or, higher than those, a circle's.
    pub number: f64,
    /// Normal of a face, a unit vector towards its front; `None` for a circle.
    pub normal: Option<Point>,
}

impl LobeHit {
    /// Whether a surface at `distance_m` comes before this one; at the same distance, the first in
    /// the world's list does.
    fn comes_after(&self, distance_m: f64, number: f64) -> bool {
        let same = distance_m == self.distance_m;
        distance_m < self.distance_m || (same && number < self.number)
    }
}

/// All surfaces in a lobe; faces from near to far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Things<'a> {
    pub faces: &'a [SeenFace],
    pub circles: &'a [SeenCircle],
}

impl Things<'_> {
    /// The first hit of a ray.
    pub fn cast(&self, ray: Point) -> Option<LobeHit> {
        let mut first: Option<LobeHit> = None;
        let mut offer = |hit: LobeHit| {
            let comes_first = |first: LobeHit| first.comes_after(hit.distance_m, hit.number);
            if first.is_none_or(comes_first) {
                first = Some(hit);
            }
        };
        for face in self.faces {
            let (met, cos) = face.met_by(ray);
            if met {
                offer(LobeHit {
                    distance_m: face.q / cos,
                    cos_incidence: cos,
                    number: face.number,
                    normal: Some(Point::new(-face.u.y, face.u.x)),
                });
            }
        }
        for circle in self.circles {
            if let Some(distance_m) = circle.met_by(ray) {
                offer(LobeHit {
                    distance_m,
                    cos_incidence: 1.0,
                    number: circle.number,
                    normal: None,
                });
            }
        }
        first
    }

    /// Whether a ray hits a surface before `distance_m` m, or at `distance_m` one that precedes
    /// `number` in the world's list.
    #[inline]
    pub fn hide(&self, ray: Point, distance_m: f64, number: f64) -> bool {
        let most = (distance_m + SLACK_M) * (distance_m + SLACK_M);
        let before =
            |other: f64, its: f64| other < distance_m || (other == distance_m && its < number);
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
