//! Single rays: what does a thin beam of sound meet first, and under what angle?
//!
//! A [`LobeView`] holds the faces, circles and corners that one lobe can meet, so that a fan of rays pays
//! only for those. Rays are exact and in f64.

use super::World;
use super::faces::{LANES, max, min};
use super::geometry::Point;
use super::view::{ConeShape, circle_in_cone};

/// A ray that starts on a surface, give or take rounding, does not meet it, m.
const SELF_M: f64 = 1e-9;

/// A surface of a world, by its place in the world's own list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Surface {
    /// One side of a straight piece.
    Face(usize),
    /// The side of a circle.
    Circle(usize),
}

/// Where a ray ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Length of the ray, m.
    pub distance_m: f64,
    /// What it meets.
    pub surface: Surface,
    /// Cosine of the angle between the ray and the surface's normal: 1 head on, 0 grazing.
    pub cos_incidence: f64,
    /// Unit vector from the surface, at right angles to it, towards the side the ray came from.
    pub normal: Point,
}

/// A face as seen from the tip of a lobe; see [`super::View`].
#[derive(Debug, Clone, Copy)]
struct SeenFace {
    index: usize,
    u: Point,
    p: f64,
    q: f64,
    length: f64,
}

impl SeenFace {
    /// Unit vector towards the face, at right angles to it.
    fn towards(&self) -> Point {
        Point::new(self.u.y, -self.u.x)
    }

    fn hit(&self, direction: Point) -> Option<Hit> {
        let cos_incidence = direction.dot(self.towards());
        // Where the ray meets the face's line, times the cosine: most rays miss, without a division.
        let along = self.q * direction.dot(self.u);
        let (from, to) = (
            self.p * cos_incidence,
            (self.p + self.length) * cos_incidence,
        );
        let met = (cos_incidence > 0.0) & (along >= from) & (along <= to);
        met.then(|| Hit {
            distance_m: self.q / cos_incidence,
            surface: Surface::Face(self.index),
            cos_incidence,
            normal: -self.towards(),
        })
    }

    /// Whether any part of the face lies in the cone around `axis`, and within `reach`.
    fn in_cone(&self, axis: Point, cone: ConeShape, reach: f64) -> bool {
        let (axis_u, axis_n) = (axis.dot(self.u), axis.dot(self.towards()));
        let meets = |u: f64, n: f64, beyond: f64| if n > 0.0 { self.q * u / n } else { beyond };
        let left_n = axis_n * cone.cos - axis_u * cone.sin;
        let right_n = axis_n * cone.cos + axis_u * cone.sin;
        let left = meets(axis_u * cone.cos + axis_n * cone.sin, left_n, f64::INFINITY);
        let right = meets(
            axis_u * cone.cos - axis_n * cone.sin,
            right_n,
            -f64::INFINITY,
        );
        let (from, to) = (max(self.p, right), min(self.p + self.length, left));
        let nearest = max(from, min(to, 0.0));
        let near = nearest * nearest + self.q * self.q <= reach * reach;
        self.q > 0.0 && max(left_n, right_n) > 0.0 && from <= to && near
    }
}

/// A circle as seen from the tip of a lobe.
#[derive(Debug, Clone, Copy)]
struct SeenCircle {
    index: usize,
    center: Point,
    radius: f64,
}

impl SeenCircle {
    fn hit(&self, direction: Point) -> Option<Hit> {
        let across = direction.cross(self.center);
        let depth = self.radius * self.radius - across * across;
        let distance_m = direction.dot(self.center) - max(depth, 0.0).sqrt();
        (depth >= 0.0 && distance_m > 0.0).then(|| {
            let normal = (direction * distance_m - self.center) * (1.0 / self.radius);
            Hit {
                distance_m,
                surface: Surface::Circle(self.index),
                cos_incidence: -normal.dot(direction),
                normal,
            }
        })
    }
}

/// What one lobe can meet. Reusable: building it again seldom allocates.
#[derive(Debug, Clone, Default)]
pub struct LobeView {
    faces: Vec<SeenFace>,
    circles: Vec<SeenCircle>,
    corners: Vec<Point>,
}

impl LobeView {
    /// Collects what lies in `world` inside the cone around the unit vector `axis` from `tip`, within
    /// `reach_m`, and shows its front.
    pub fn build(&mut self, world: &World, tip: Point, axis: Point, cone: ConeShape, reach_m: f64) {
        self.faces.clear();
        self.circles.clear();
        self.corners.clear();
        for (index, face) in world.faces.iter().enumerate() {
            let offset = face.a - tip;
            let seen = SeenFace {
                index,
                u: face.u,
                p: offset.dot(face.u),
                q: offset.cross(face.u),
                length: face.length,
            };
            if seen.in_cone(axis, cone, reach_m) {
                self.faces.push(seen);
            }
        }
        for (index, circle) in world.circles.iter().enumerate() {
            let (center, radius) = (circle.center - tip, circle.radius);
            if circle_in_cone(center, radius, axis, cone) <= reach_m {
                self.circles.push(SeenCircle {
                    index,
                    center,
                    radius,
                });
            }
        }
        self.corners.extend(
            world
                .corners
                .iter()
                .map(|&corner| corner - tip)
                .filter(|&corner| {
                    let (along, across) = (axis.dot(corner), axis.cross(corner).abs());
                    across * cone.cos <= along * cone.sin && corner.length() <= reach_m
                }),
        );
    }

    /// The first thing a ray from the tip along the unit vector `direction` meets.
    #[must_use]
    pub fn cast(&self, direction: Point) -> Option<Hit> {
        // Plain loops: a chain of iterators is not always inlined, and this runs for every ray.
        let mut first: Option<Hit> = None;
        let mut take = |hit: Hit| {
            if first.is_none_or(|first| hit.distance_m < first.distance_m) {
                first = Some(hit);
            }
        };
        for face in &self.faces {
            if let Some(hit) = face.hit(direction) {
                take(hit);
            }
        }
        for circle in &self.circles {
            if let Some(hit) = circle.hit(direction) {
                take(hit);
            }
        }
        first
    }

    /// The corners in the lobe, relative to its tip, m, hidden or not.
    pub fn corners(&self) -> impl Iterator<Item = Point> + '_ {
        self.corners.iter().copied()
    }

    /// Unit vectors from the tip towards the places most likely to answer: the foot of the perpendicular
    /// on each face that has one, and the middle of each circle. They may lie outside the lobe.
    pub fn promising(&self) -> impl Iterator<Item = Point> + '_ {
        let feet = self
            .faces
            .iter()
            .filter(|face| face.p <= 0.0 && face.p + face.length >= 0.0);
        let middles = self.circles.iter().map(|circle| {
            let length = circle.center.length();
            circle.center * (1.0 / length)
        });
        feet.map(SeenFace::towards).chain(middles)
    }
}

impl World {
    /// The first thing a ray from `origin` along the unit vector `direction` meets. The surface it
    /// starts on, if it does, is not met.
    #[must_use]
    pub fn cast(&self, origin: Point, direction: Point) -> Option<Hit> {
        let circles = self.circles.iter().enumerate();
        let circles = circles.filter_map(|(index, circle)| {
            let (center, radius) = (circle.center - origin, circle.radius);
            let seen = SeenCircle {
                index,
                center,
                radius,
            };
            seen.hit(direction).filter(|hit| hit.distance_m > SELF_M)
        });
        nearest(
            self.cast_on_faces(origin, direction)
                .into_iter()
                .chain(circles),
        )
    }

    /// The first face a ray meets. Each lane keeps its own nearest face, by block, without a branch.
    fn cast_on_faces(&self, origin: Point, direction: Point) -> Option<Hit> {
        let (mut best, mut in_block) = ([f64::INFINITY; LANES], [0.0; LANES]);
        let mut number = 0.0;
        for block in &self.faces.blocks {
            for i in 0..LANES {
                let offset = Point::new(block.ax[i], block.ay[i]) - origin;
                let u = Point::new(block.ux[i], block.uy[i]);
                let (p, q) = (offset.dot(u), offset.cross(u));
                let cos = direction.cross(u);
                let along = q * direction.dot(u);
                let beyond = max(p * cos - along, along - (p + block.length[i]) * cos);
                let met = (q > SELF_M) & (cos > 0.0) & (beyond <= 0.0);
                let way = if met { q / cos } else { f64::INFINITY };
                in_block[i] = if way < best[i] { number } else { in_block[i] };
                best[i] = min(best[i], way);
            }
            number += 1.0;
        }
        let lane = (0..LANES).reduce(|a, b| if best[b] < best[a] { b } else { a })?;
        let index = in_block[lane] as usize * LANES + lane;
        let block = self.faces.blocks.get(index / LANES)?;
        let towards = Point::new(block.uy[lane], -block.ux[lane]);
        best[lane].is_finite().then(|| Hit {
            distance_m: best[lane],
            surface: Surface::Face(index),
            cos_incidence: direction.dot(towards),
            normal: -towards,
        })
    }
}

fn nearest(hits: impl Iterator<Item = Hit>) -> Option<Hit> {
    hits.reduce(|a, b| if b.distance_m < a.distance_m { b } else { a })
}
