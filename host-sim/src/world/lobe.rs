//! What one lobe can meet, and the rays of a fan within it.
//!
//! A [`LobeView`] holds the faces, circles and corners that one lobe can meet, so that a fan of rays pays only for those.
//! Rays come in blocks of [`LANES`], and a thing is held against a whole block at a time. Things are taken from near to
//! far, and once the fan has got an answer, what lies beyond it is left alone.

use super::World;
use super::faces::{FaceBlock, LANES, clamp, max, min};
use super::geometry::Point;
use super::surroundings::Surroundings;
use super::view::{ConeShape, circle_in_cone};

/// How much farther than an answer things are still looked at, m: far above any rounding.
const SLACK_M: f64 = 1e-3;

/// Things up to this many times as far as the nearest one, squared, are looked at in one go.
const STRIDE: f64 = 1.44;

/// [`LANES`] rays from one tip and what each met first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayBlock {
    /// Unit vectors; nothing is met by a ray of length 0.
    x: [f64; LANES],
    y: [f64; LANES],
    /// Length of each ray, m; infinite while it has met nothing.
    pub way: [f64; LANES],
    /// Cosine of the angle between each ray and the normal of the face it met; 1 for a circle.
    pub cos_incidence: [f64; LANES],
    /// Number of the thing met: a face's or, higher than those, a circle's place in the world's list; −∞ for none.
    pub number: [f64; LANES],
}

impl RayBlock {
    /// Rays in a block.
    pub const LANES: usize = LANES;

    const EMPTY: Self = Self {
        x: [0.0; LANES],
        y: [0.0; LANES],
        way: [f64::INFINITY; LANES],
        cos_incidence: [0.0; LANES],
        number: [f64::NEG_INFINITY; LANES],
    };

    /// Direction of a ray.
    #[must_use]
    pub fn direction(&self, lane: usize) -> Point {
        Point::new(self.x[lane], self.y[lane])
    }

    #[inline]
    fn meet_face(&mut self, u: Point, p: f64, q: f64, length: f64, number: f64) {
        for i in 0..LANES {
            let cos = self.x[i] * u.y - self.y[i] * u.x;
            // Where the ray meets the face's line, times the cosine.
            let along = q * (self.x[i] * u.x + self.y[i] * u.y);
            let (from, to) = (p * cos, (p + length) * cos);
            let met = (cos > 0.0) & (along >= from) & (along <= to);
            let way = if met { q / cos } else { f64::INFINITY };
            self.take(i, way, cos, number);
        }
    }

    #[inline]
    fn meet_circle(&mut self, center: Point, radius: f64, number: f64) {
        for i in 0..LANES {
            let across = self.x[i] * center.y - self.y[i] * center.x;
            let depth = radius * radius - across * across;
            let way = self.x[i] * center.x + self.y[i] * center.y - max(depth, 0.0).sqrt();
            let met = (depth >= 0.0) & (way > 0.0);
            self.take(i, if met { way } else { f64::INFINITY }, 1.0, number);
        }
    }

    /// Of two things met at the same distance, the one first in the world's list counts.
    #[inline(always)]
    fn take(&mut self, i: usize, way: f64, cos_incidence: f64, number: f64) {
        let first = (way < self.way[i]) | ((way == self.way[i]) & (number < self.number[i]));
        self.cos_incidence[i] = if first {
            cos_incidence
        } else {
            self.cos_incidence[i]
        };
        self.number[i] = if first { number } else { self.number[i] };
        self.way[i] = if first { way } else { self.way[i] };
    }
}

/// Rays from one tip. Reusable.
#[derive(Debug, Clone, Default)]
pub struct Rays {
    blocks: Vec<RayBlock>,
    count: usize,
}

impl Rays {
    /// Forgets all rays.
    pub fn clear(&mut self) {
        self.blocks.clear();
        self.count = 0;
    }

    /// Adds a ray along a unit vector.
    pub fn push(&mut self, direction: Point) {
        let lane = self.count % LANES;
        if lane == 0 {
            self.blocks.push(RayBlock::EMPTY);
        }
        if let Some(block) = self.blocks.last_mut() {
            (block.x[lane], block.y[lane]) = (direction.x, direction.y);
        }
        self.count += 1;
    }

    /// These rays turned left by the angle whose unit vector is `direction`, none of which has met anything.
    pub fn turned_into(&self, direction: Point, out: &mut Self) {
        out.blocks.clear();
        out.count = self.count;
        out.blocks.extend(self.blocks.iter().map(|block| {
            let mut turned = RayBlock::EMPTY;
            for i in 0..LANES {
                turned.x[i] = block.x[i] * direction.x - block.y[i] * direction.y;
                turned.y[i] = block.x[i] * direction.y + block.y[i] * direction.x;
            }
            turned
        }));
    }

    /// The block that holds a ray, and its place there.
    #[must_use]
    pub fn get(&self, ray: usize) -> Option<(&RayBlock, usize)> {
        let block = self.blocks.get(ray / LANES).filter(|_| ray < self.count)?;
        Some((block, ray % LANES))
    }

    /// The rays in blocks; what fills up the last one meets nothing.
    #[must_use]
    pub fn blocks(&self) -> &[RayBlock] {
        &self.blocks
    }
}

/// [`LANES`] faces as seen from the tip of a lobe; see [`super::View`].
#[derive(Debug, Clone, Copy)]
struct SeenBlock {
    ux: [f64; LANES],
    uy: [f64; LANES],
    p: [f64; LANES],
    q: [f64; LANES],
    length: [f64; LANES],
    number: [f64; LANES],
    /// Squared distance of the nearest point within the lobe, m²; infinite where there is no face.
    near: [f64; LANES],
}

impl SeenBlock {
    const EMPTY: Self = Self {
        ux: [1.0; LANES],
        uy: [0.0; LANES],
        p: [0.0; LANES],
        q: [0.0; LANES],
        length: [0.0; LANES],
        number: [f64::INFINITY; LANES],
        near: [f64::INFINITY; LANES],
    };
}

/// A circle as seen from the tip of a lobe.
#[derive(Debug, Clone, Copy)]
struct SeenCircle {
    center: Point,
    radius: f64,
    number: f64,
    near: f64,
}

/// A lobe: where it begins and where it points.
#[derive(Debug, Clone, Copy)]
struct Lobe {
    tip: Point,
    axis: Point,
    cone: ConeShape,
    reach: f64,
}

impl Lobe {
    /// Whether anything within a circle may lie in the lobe's cone.
    fn may_reach(&self, (middle, radius): (Point, f64)) -> bool {
        let (offset, radius) = (middle - self.tip, radius + SLACK_M);
        let (along, across) = (self.axis.dot(offset), self.axis.cross(offset));
        let depth = along * self.cone.sin + radius;
        across * self.cone.cos <= depth && -across * self.cone.cos <= depth && along >= -radius
    }
}

/// What one lobe can meet. Reusable: building it again seldom allocates.
#[derive(Debug, Clone, Default)]
pub struct LobeView {
    around: Surroundings,
    faces: Vec<SeenBlock>,
    count: usize,
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
        self.around.look(world, middle, offset_m, reach_m);
        let around = std::mem::take(&mut self.around);
        let lobe = Lobe {
            tip: middle + axis * offset_m,
            axis,
            cone,
            reach: reach_m,
        };
        self.count = 0;
        for (block, circle) in around.faces.blocks.iter().zip(&around.around_faces) {
            if lobe.may_reach(*circle) {
                self.keep_faces(block, &lobe);
            }
        }
        if let Some(last) = self.faces.get_mut(self.count / LANES) {
            last.near[self.count % LANES..].fill(f64::INFINITY);
        }
        self.circles.clear();
        for circle in around.circles.iter().chain(&world.posts) {
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
        self.corners.clear();
        for (block, circle) in around.corners.iter().zip(&around.around_corners) {
            if lobe.may_reach(*circle) {
                for i in 0..LANES {
                    let corner = Point::new(block.x[i], block.y[i]) - lobe.tip;
                    let (along, across) = (axis.dot(corner), axis.cross(corner).abs());
                    let range = corner.length();
                    if across * cone.cos <= along * cone.sin && range <= reach_m {
                        self.corners.push((corner, range));
                    }
                }
            }
        }
        self.around = around;
    }

    /// Appends the faces of a block of which any part lies in the lobe.
    #[inline]
    fn keep_faces(&mut self, block: &FaceBlock, lobe: &Lobe) {
        let (axis, cone) = (lobe.axis, lobe.cone);
        let (mut p, mut q, mut near) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut keep = [false; LANES];
        for i in 0..LANES {
            let (ux, uy) = (block.ux[i], block.uy[i]);
            let (dx, dy) = (block.ax[i] - lobe.tip.x, block.ay[i] - lobe.tip.y);
            p[i] = dx * ux + dy * uy;
            q[i] = dx * uy - dy * ux;
            let (axis_u, axis_n) = (axis.x * ux + axis.y * uy, axis.x * uy - axis.y * ux);
            let (left_n, left_u) = (
                axis_n * cone.cos - axis_u * cone.sin,
                axis_u * cone.cos + axis_n * cone.sin,
            );
            let (right_n, right_u) = (
                axis_n * cone.cos + axis_u * cone.sin,
                axis_u * cone.cos - axis_n * cone.sin,
            );
            let (left, right) = (q[i] * left_u / left_n, q[i] * right_u / right_n);
            let left = if left_n > 0.0 { left } else { f64::INFINITY };
            let right = if right_n > 0.0 { right } else { -f64::INFINITY };
            let (from, to) = (max(p[i], right), min(p[i] + block.length[i], left));
            let nearest = clamp(0.0, from, to);
            near[i] = nearest * nearest + q[i] * q[i];
            keep[i] = (q[i] > 0.0)
                & (max(left_n, right_n) > 0.0)
                & (from <= to)
                & (near[i] <= lobe.reach * lobe.reach);
        }
        let most = (self.count + LANES).div_ceil(LANES);
        if self.faces.len() < most {
            self.faces.resize(most, SeenBlock::EMPTY);
        }
        for i in 0..LANES {
            // Written in any case and counted if kept: no branch to mispredict.
            if let Some(seen) = self.faces.get_mut(self.count / LANES) {
                let lane = self.count % LANES;
                seen.ux[lane] = block.ux[i];
                seen.uy[lane] = block.uy[i];
                seen.p[lane] = p[i];
                seen.q[lane] = q[i];
                seen.length[lane] = block.length[i];
                seen.number[lane] = block.number[i];
                seen.near[lane] = near[i];
            }
            self.count += usize::from(keep[i]);
        }
    }

    /// Lets the rays meet what lies in the lobe, which they must not leave, from near to far; what lies farther, m, than
    /// `far` says of what was met so far is left alone.
    pub fn meet(&self, rays: &mut Rays, far: impl Fn(&Rays) -> f64) {
        let mut done = -1.0;
        loop {
            let next = self.nearest_beyond(done);
            let far = far(rays) + SLACK_M;
            if next == f64::INFINITY || next > far * far {
                return;
            }
            let until = next * STRIDE;
            let due = |near: f64| near > done && near <= until;
            for block in self.seen() {
                for i in (0..LANES).filter(|&i| due(block.near[i])) {
                    let (u, length) = (Point::new(block.ux[i], block.uy[i]), block.length[i]);
                    for rays in &mut rays.blocks {
                        rays.meet_face(u, block.p[i], block.q[i], length, block.number[i]);
                    }
                }
            }
            for circle in self.circles.iter().filter(|circle| due(circle.near)) {
                for rays in &mut rays.blocks {
                    rays.meet_circle(circle.center, circle.radius, circle.number);
                }
            }
            done = until;
        }
    }

    /// The blocks that hold faces.
    fn seen(&self) -> &[SeenBlock] {
        self.faces.get(..self.count.div_ceil(LANES)).unwrap_or(&[])
    }

    /// Squared distance of the nearest thing beyond a squared distance, m²; infinite if there is none.
    fn nearest_beyond(&self, done: f64) -> f64 {
        let mut nearest = [f64::INFINITY; LANES];
        for block in self.seen() {
            for (nearest, &near) in nearest.iter_mut().zip(&block.near) {
                let near = if near > done { near } else { f64::INFINITY };
                *nearest = min(*nearest, near);
            }
        }
        let circles = self
            .circles
            .iter()
            .map(|circle| circle.near)
            .filter(|&near| near > done);
        circles.chain(nearest).fold(f64::INFINITY, min)
    }

    /// The corners in the lobe, relative to its tip, and how far they are, m, hidden or not.
    #[must_use]
    pub fn corners(&self) -> &[(Point, f64)] {
        &self.corners
    }

    /// Unit vectors from the tip towards the places most likely to answer: the foot of the perpendicular
    /// on each face that has one, and the middle of each circle. They may lie outside the lobe.
    pub fn promising(&self) -> impl Iterator<Item = Point> + '_ {
        let feet = self.seen().iter().flat_map(|block| {
            let feet = (0..LANES).filter(|&i| {
                block.near[i] < f64::INFINITY
                    && block.p[i] <= 0.0
                    && block.p[i] + block.length[i] >= 0.0
            });
            feet.map(|i| Point::new(block.uy[i], -block.ux[i]))
        });
        let middles = self.circles.iter().map(|circle| {
            let length = circle.center.length();
            circle.center * (1.0 / length)
        });
        feet.chain(middles)
    }

    /// Unit vector from a face of the lobe, by its number, at right angles to it; `None` for what is no such face.
    #[must_use]
    pub fn normal(&self, number: f64) -> Option<Point> {
        let lanes = self
            .seen()
            .iter()
            .flat_map(|block| (0..LANES).map(move |i| (block, i)));
        let mut lanes = lanes.take(self.count);
        let face = lanes.find(|(block, i)| block.number[*i] == number);
        face.map(|(block, i)| Point::new(-block.uy[i], block.ux[i]))
    }
}
