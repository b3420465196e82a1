//! Ray casting: first hit and angle of incidence of a thin beam of sound, in f64.

use crate::geometry::{Point, max, min};
use crate::surfaces::{Boxes, Circle, FIRST_CIRCLE, FaceBlock, LANES, Surfaces, TreeSearch};

/// A ray does not hit surfaces nearer than this, m: it may start on a surface.
const SELF_M: f64 = 1e-9;

/// A surface of a world, by its index in the world's list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Surface {
    /// One side of a straight segment.
    Face(usize),
    /// The side of a circle.
    Circle(usize),
}

/// The first hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Length of the ray, m.
    pub distance_m: f64,
    /// The surface.
    pub surface: Surface,
    /// Cosine of the angle between the ray and the surface's normal: 1 head on, 0 grazing.
    pub cos_incidence: f64,
    /// Normal of the surface, a unit vector towards the ray's side.
    pub normal: Point,
}

/// The first hit of a ray from `origin` along the unit vector `direction`.
pub(super) fn cast(
    surfaces: &Surfaces,
    posts: &[Circle],
    origin: Point,
    direction: Point,
) -> Option<Hit> {
    let mut face = FirstFace {
        surfaces,
        origin,
        direction,
        best: f64::INFINITY,
        found: None,
    };
    surfaces.search_faces(&mut face);
    let mut circle = FirstCircle {
        surfaces,
        origin,
        direction,
        best: face.best,
        found: None,
    };
    surfaces.search_circles(&mut circle);
    posts.iter().for_each(|post| circle.meet(post));
    match circle.found {
        Some(found) => Some(circle.hit(found)),
        None => face.hit(),
    }
}

/// Search for the first face that a ray hits.
struct FirstFace<'w> {
    surfaces: &'w Surfaces,
    origin: Point,
    direction: Point,
    best: f64,
    /// Block and lane, and the face's number.
    found: Option<(usize, usize, f64)>,
}

impl FirstFace<'_> {
    /// Length of the ray to each face of a block, m; infinite if it misses.
    fn distances(&self, block: &FaceBlock) -> [f64; LANES] {
        let (origin, direction) = (self.origin, self.direction);
        let mut distances = [f64::INFINITY; LANES];
        for (i, distance) in distances.iter_mut().enumerate() {
            let offset = Point::new(block.ax[i], block.ay[i]) - origin;
            let u = Point::new(block.ux[i], block.uy[i]);
            let (p, q) = (offset.dot(u), offset.cross(u));
            let cos = direction.cross(u);
            let along = q * direction.dot(u);
            let beyond = max(p * cos - along, along - (p + block.length[i]) * cos);
            let met = (q > SELF_M) & (cos > 0.0) & (beyond <= 0.0);
            *distance = if met { q / cos } else { f64::INFINITY };
        }
        distances
    }

    fn hit(&self) -> Option<Hit> {
        let (block, lane, number) = self.found?;
        let block = self.surfaces.face_block(block);
        let towards = Point::new(block.uy[lane], -block.ux[lane]);
        Some(Hit {
            distance_m: self.best,
            surface: Surface::Face(number as usize),
            cos_incidence: self.direction.dot(towards),
            normal: -towards,
        })
    }
}

/// The order of faces at the same distance: by number modulo [`LANES`], then by number.
fn rank(number: f64) -> (usize, usize) {
    let number = number as usize;
    (number % LANES, number)
}

impl TreeSearch for FirstFace<'_> {
    fn wants(&self, boxes: &Boxes) -> [bool; LANES] {
        boxes.met_by_ray(self.origin, self.direction, self.best)
    }

    fn look(&mut self, block: usize) {
        let faces = self.surfaces.face_block(block);
        let distances = self.distances(faces);
        let best = distances.into_iter().fold(self.best, min);
        if best == f64::INFINITY {
            return;
        }
        for (lane, &number) in faces.number.iter().enumerate() {
            let first = |known: f64| rank(number) < rank(known);
            let better =
                distances[lane] < self.best || self.found.is_none_or(|(_, _, known)| first(known));
            if distances[lane] == best && better {
                self.best = best;
                self.found = Some((block, lane, number));
            }
        }
    }
}

/// Search for the first circle that a ray hits, nearer than `best`.
struct FirstCircle<'w> {
    surfaces: &'w Surfaces,
    origin: Point,
    direction: Point,
    best: f64,
    found: Option<Circle>,
}

impl FirstCircle<'_> {
    fn meet(&mut self, circle: &Circle) {
        let Some(distance) =
            distance_to_circle(circle.center - self.origin, circle.radius, self.direction)
        else {
            return;
        };
        let first =
            distance == self.best && self.found.is_some_and(|known| circle.number < known.number);
        if distance > SELF_M && (distance < self.best || first) {
            self.best = distance;
            self.found = Some(*circle);
        }
    }

    fn hit(&self, found: Circle) -> Hit {
        let center = found.center - self.origin;
        let normal = (self.direction * self.best - center) * (1.0 / found.radius);
        Hit {
            distance_m: self.best,
            surface: Surface::Circle((found.number - FIRST_CIRCLE) as usize),
            cos_incidence: -normal.dot(self.direction),
            normal,
        }
    }
}

impl TreeSearch for FirstCircle<'_> {
    fn wants(&self, boxes: &Boxes) -> [bool; LANES] {
        boxes.met_by_ray(self.origin, self.direction, self.best)
    }

    fn look(&mut self, block: usize) {
        let surfaces = self.surfaces;
        surfaces
            .circle_block(block)
            .iter()
            .for_each(|circle| self.meet(circle));
    }
}

/// Length of a ray from the origin to a circle, m.
fn distance_to_circle(center: Point, radius: f64, direction: Point) -> Option<f64> {
    let across = direction.cross(center);
    let depth = radius * radius - across * across;
    let distance = direction.dot(center) - max(depth, 0.0).sqrt();
    (depth >= 0.0 && distance > 0.0).then_some(distance)
}
