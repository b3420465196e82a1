//! The reference model of the caster: every query tests all surfaces.
//!
//! It is slow and only for tests. The caster's results must be bit-identical.

use crate::caster::{ConeShape, Path, Sweep, circle_in_cone, touch_circle, touch_face};
use crate::geometry::{Point, clamp, max, min};
use crate::surfaces::{Circle, Distance, Face, list_circles, list_faces};
use crate::world::World;

mod caster;
mod echoes;
pub(crate) mod worlds;

/// The first hit of a ray: number of the surface and cosine of the incidence (1 for circles).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ReferenceHit {
    pub distance_m: f64,
    pub number: f64,
    pub cos_incidence: f64,
    pub normal: Point,
}

/// All surfaces of a world, in its order.
pub(crate) struct Reference {
    faces: Vec<Face>,
    circles: Vec<Circle>,
    corners: Vec<Point>,
}

/// A face relative to the tip of a lobe: the face, `p` and `q`.
type RelativeFace = (Face, f64, f64);

/// The surfaces in one lobe.
pub(crate) struct ReferenceLobe {
    faces: Vec<RelativeFace>,
    circles: Vec<Circle>,
    /// Relative to the tip.
    pub corners: Vec<Point>,
}

fn towards(face: &Face) -> Point {
    Point::new(face.u.y, -face.u.x)
}

impl Reference {
    pub(crate) fn new(world: &World) -> Self {
        let mut corners = Vec::new();
        let shapes = world.shapes().iter();
        shapes.for_each(|shape| shape.for_each_corner(|corner| corners.push(corner)));
        Self {
            faces: list_faces(world.shapes()),
            // Posts are the last shapes.
            circles: list_circles(world.shapes()),
            corners,
        }
    }

    pub(crate) fn clearance(&self, point: Point) -> f64 {
        let face = |face: &Face| {
            let d = point - face.a;
            let (along, across) = (d.dot(face.u), d.cross(face.u));
            let beyond = along - clamp(along, 0.0, face.length);
            (beyond * beyond + across * across).sqrt()
        };
        let faces = self.faces.iter().map(face).fold(f64::INFINITY, min);
        self.circles
            .iter()
            .map(|circle| circle.distance(point))
            .fold(faces, min)
    }

    pub(crate) fn sweep(&self, from: Point, to: Point, radius: f64) -> Sweep {
        let path = Path::between(from, to);
        let gaps = self.faces.iter().map(|face| path.to_face(face).sqrt());
        let gaps = gaps.chain(self.circles.iter().map(|circle| path.to_circle(circle)));
        let nearest = gaps.fold(f64::INFINITY, min);
        let free = Sweep {
            traveled_m: path.length,
            contact: None,
            min_clearance_m: (nearest - radius).max(0.0),
        };
        if !path.is_touched_at(nearest, radius) {
            return free;
        }
        let faces = self
            .faces
            .iter()
            .filter_map(|face| touch_face(&path, face, radius));
        let circles = self
            .circles
            .iter()
            .filter_map(|circle| touch_circle(&path, circle, radius));
        match faces
            .chain(circles)
            .reduce(|a, b| if b.0 < a.0 { b } else { a })
        {
            None => free,
            Some((traveled_m, contact)) => Sweep {
                traveled_m: min(traveled_m, path.length),
                contact: Some(contact),
                min_clearance_m: 0.0,
            },
        }
    }

    /// As [`ConeView`](crate::caster::ConeView): selects faces in f64 and measures them in f32.
    pub(crate) fn nearest_in_cone(
        &self,
        middle: Point,
        offset_m: f64,
        reach_m: f64,
        axis: Point,
        cone: ConeShape,
    ) -> f64 {
        let reach = reach_m + offset_m;
        let mut best = 1e18_f32;
        for face in &self.faces {
            let d = face.a - middle;
            let (p, q) = (d.dot(face.u), d.cross(face.u));
            let nearest = clamp(0.0, p, p + face.length);
            if q > -offset_m && nearest * nearest + q * q <= reach * reach {
                best = best.min(in_cone_f32(face, p, q, axis, offset_m, cone));
            }
        }
        let near = |circle: &&Circle| (circle.center - middle).length() - circle.radius <= reach;
        self.circles
            .iter()
            .filter(near)
            .fold(f64::from(best).sqrt(), |nearest, circle| {
                let center = (circle.center - middle) - axis * offset_m;
                min(nearest, circle_in_cone(center, circle.radius, axis, cone))
            })
    }

    pub(crate) fn lobe(
        &self,
        tip: Point,
        axis: Point,
        cone: ConeShape,
        reach: f64,
    ) -> ReferenceLobe {
        let relative = |face: &Face| {
            let offset = face.a - tip;
            (*face, offset.dot(face.u), offset.cross(face.u))
        };
        let faces = self
            .faces
            .iter()
            .map(relative)
            .filter(|face| in_cone(face, axis, cone, reach));
        let circles = self.circles.iter().map(|circle| Circle {
            center: circle.center - tip,
            ..*circle
        });
        let circles = circles.filter(|c| circle_in_cone(c.center, c.radius, axis, cone) <= reach);
        let corners = self
            .corners
            .iter()
            .map(|&corner| corner - tip)
            .filter(|&corner| {
                let (along, across) = (axis.dot(corner), axis.cross(corner).abs());
                across * cone.cos <= along * cone.sin && corner.length() <= reach
            });
        ReferenceLobe {
            faces: faces.collect(),
            circles: circles.collect(),
            corners: corners.collect(),
        }
    }

    /// As [`World::cast`], with its order of surfaces at the same distance.
    pub(crate) fn cast(&self, origin: Point, direction: Point) -> Option<ReferenceHit> {
        let mut faces = self.faces.clone();
        faces.sort_by_key(|face| (face.number as usize % 8, face.number as usize));
        let hit = |face: &Face| {
            let offset = face.a - origin;
            let (p, q) = (offset.dot(face.u), offset.cross(face.u));
            let cos = direction.cross(face.u);
            let along = q * direction.dot(face.u);
            let beyond = max(p * cos - along, along - (p + face.length) * cos);
            (q > 1e-9 && cos > 0.0 && beyond <= 0.0).then(|| ReferenceHit {
                distance_m: q / cos,
                number: face.number,
                cos_incidence: direction.dot(towards(face)),
                normal: -towards(face),
            })
        };
        let circles = self.circles.iter().filter_map(|circle| {
            let circle = Circle {
                center: circle.center - origin,
                ..*circle
            };
            hit_circle(&circle, direction).filter(|hit| hit.distance_m > 1e-9)
        });
        nearest(faces.iter().filter_map(hit).chain(circles))
    }
}

impl ReferenceLobe {
    pub(crate) fn cast(&self, direction: Point) -> Option<ReferenceHit> {
        let hit = |(face, p, q): &RelativeFace| {
            let cos = direction.dot(towards(face));
            let along = q * direction.dot(face.u);
            let (from, to) = (p * cos, (p + face.length) * cos);
            (cos > 0.0 && along >= from && along <= to).then(|| ReferenceHit {
                distance_m: q / cos,
                number: face.number,
                cos_incidence: cos,
                normal: -towards(face),
            })
        };
        let circles = self
            .circles
            .iter()
            .filter_map(|circle| hit_circle(circle, direction));
        nearest(self.faces.iter().filter_map(hit).chain(circles))
    }

    pub(crate) fn promising(&self) -> Vec<Point> {
        let feet = self
            .faces
            .iter()
            .filter(|(face, p, _)| *p <= 0.0 && p + face.length >= 0.0);
        let middles = self
            .circles
            .iter()
            .map(|c| c.center * (1.0 / c.center.length()));
        feet.map(|(face, ..)| towards(face))
            .chain(middles)
            .collect()
    }
}

fn nearest(hits: impl Iterator<Item = ReferenceHit>) -> Option<ReferenceHit> {
    hits.reduce(|a, b| if b.distance_m < a.distance_m { b } else { a })
}

fn hit_circle(circle: &Circle, direction: Point) -> Option<ReferenceHit> {
    let across = direction.cross(circle.center);
    let depth = circle.radius * circle.radius - across * across;
    let distance_m = direction.dot(circle.center) - max(depth, 0.0).sqrt();
    (depth >= 0.0 && distance_m > 0.0).then(|| ReferenceHit {
        distance_m,
        number: circle.number,
        cos_incidence: 1.0,
        normal: (direction * distance_m - circle.center) * (1.0 / circle.radius),
    })
}

fn in_cone((face, p, q): &RelativeFace, axis: Point, cone: ConeShape, reach: f64) -> bool {
    let (axis_u, axis_n) = (axis.dot(face.u), axis.dot(towards(face)));
    let meets = |u: f64, n: f64, beyond: f64| if n > 0.0 { q * u / n } else { beyond };
    let left_n = axis_n * cone.cos - axis_u * cone.sin;
    let right_n = axis_n * cone.cos + axis_u * cone.sin;
    let left = meets(axis_u * cone.cos + axis_n * cone.sin, left_n, f64::INFINITY);
    let right = meets(
        axis_u * cone.cos - axis_n * cone.sin,
        right_n,
        -f64::INFINITY,
    );
    let (from, to) = (max(*p, right), min(p + face.length, left));
    let nearest = max(from, min(to, 0.0));
    let near = nearest * nearest + q * q <= reach * reach;
    *q > 0.0 && max(left_n, right_n) > 0.0 && from <= to && near
}

/// Squared distance of a face within a cone, m²; 1e18 if it is not in the cone.
fn in_cone_f32(face: &Face, p: f64, q: f64, axis: Point, offset_m: f64, cone: ConeShape) -> f32 {
    let (ux, uy, length) = (face.u.x as f32, face.u.y as f32, face.length as f32);
    let (cx, cy, offset) = (axis.x as f32, axis.y as f32, offset_m as f32);
    let (sin, cos) = (cone.sin as f32, cone.cos as f32);
    let (axis_u, axis_n) = (cx * ux + cy * uy, cx * uy - cy * ux);
    let (q, p) = (q as f32 - offset * axis_n, p as f32 - offset * axis_u);
    let (left_n, left_u) = (axis_n * cos - axis_u * sin, axis_u * cos + axis_n * sin);
    let (right_n, right_u) = (axis_n * cos + axis_u * sin, axis_u * cos - axis_n * sin);
    let left = if left_n > 0.0 {
        q * left_u / left_n
    } else {
        1e9
    };
    let right = if right_n > 0.0 {
        q * right_u / right_n
    } else {
        -1e9
    };
    let (from, to) = (p.max(right), (p + length).min(left));
    let nearest = from.max(to.min(0.0));
    if q > 0.0 && from <= to && left_n.max(right_n) > 0.0 {
        nearest * nearest + q * q
    } else {
        1e18
    }
}
