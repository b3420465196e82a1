//! What one lobe can meet, and the rays of a fan within it.
//!
//! A [`LobeView`] holds the faces, circles and corners that one lobe can meet, so that a fan of rays pays only for those.
//! A thing is held against all rays at once. Things are taken from near to
//! far, and once the fan has got an answer, what lies beyond it is left alone.

use wide::{CmpEq as _, CmpGe as _, CmpGt as _, CmpLe as _, CmpLt as _, f64x4};

use super::World;
use super::faces::{FaceBlock, LANES, min};
use super::geometry::Point;
use super::surfaces::PointBlock;
use super::surroundings::Surroundings;
use super::view::{ConeShape, circle_in_cone};

/// How much farther than an answer things are still looked at, m: far above any rounding.
const SLACK_M: f64 = 1e-3;

/// Things up to this many times as far as the nearest one, squared, are looked at in one go.
const STRIDE: f64 = 1.44;

/// Rays from one tip and what each met first, one list per quantity. Reusable.
///
/// The lists are filled up to whole blocks of [`LANES`] with rays of length 0, which meet nothing.
#[derive(Debug, Clone, Default)]
pub struct Rays {
    x: Vec<f64>,
    y: Vec<f64>,
    way: Vec<f64>,
    cos_incidence: Vec<f64>,
    number: Vec<f64>,
    count: usize,
}

impl Rays {
    /// Forgets all rays.
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.begin(0);
    }

    /// Adds a ray along a unit vector.
    pub fn push(&mut self, direction: Point) {
        if self.count.is_multiple_of(LANES) {
            let most = self.count + LANES;
            self.x.resize(most, 0.0);
            self.y.resize(most, 0.0);
            self.way.resize(most, f64::INFINITY);
            self.cos_incidence.resize(most, 0.0);
            self.number.resize(most, f64::NEG_INFINITY);
        }
        if let (Some(x), Some(y)) = (self.x.get_mut(self.count), self.y.get_mut(self.count)) {
            (*x, *y) = (direction.x, direction.y);
        }
        self.count += 1;
    }

    /// These rays turned left by the angle whose unit vector is `direction`, none of which has met anything.
    pub fn turned_into(&self, direction: Point, out: &mut Self) {
        let rays = || self.x.iter().zip(&self.y);
        out.x.clear();
        out.y.clear();
        out.x.extend(rays().map(|(x, y)| x * direction.x - y * direction.y));
        out.y.extend(rays().map(|(x, y)| x * direction.y + y * direction.x));
        out.begin(self.count);
    }

    /// So many rays, of as many places as there are, begin anew.
    fn begin(&mut self, count: usize) {
        let places = self.x.len();
        self.count = count;
        self.way.clear();
        self.way.resize(places, f64::INFINITY);
        self.cos_incidence.clear();
        self.cos_incidence.resize(places, 0.0);
        self.number.clear();
        self.number.resize(places, f64::NEG_INFINITY);
    }

    /// Length of each ray, m: infinite while it has met nothing, and where the list is only filled up.
    #[must_use]
    pub fn ways(&self) -> &[f64] {
        &self.way
    }

    /// Cosine of the angle between each ray and the normal of the face it met; 1 for a circle, 0 for nothing.
    #[must_use]
    pub fn cos_incidences(&self) -> &[f64] {
        &self.cos_incidence
    }

    /// Number of the thing each ray met: a face's or, higher than those, a circle's place in the world's list; −∞ for
    /// nothing.
    #[must_use]
    pub fn numbers(&self) -> &[f64] {
        &self.number
    }

    /// Length of the shortest ray that met something with at least `least_cos`, m; infinite if none did.
    #[must_use]
    pub fn nearest(&self, least_cos: f64) -> f64 {
        let least = f64x4::splat(least_cos);
        let [ways, cosines] = [&self.way, &self.cos_incidence].map(|list| list.as_chunks::<4>().0);
        let mut nearest = f64x4::splat(f64::INFINITY);
        for (ways, cosines) in ways.iter().zip(cosines) {
            let way = f64x4::new(*ways);
            let counts = f64x4::new(*cosines).simd_ge(least) & way.simd_lt(nearest);
            nearest = counts.select(way, nearest);
        }
        nearest.to_array().into_iter().fold(f64::INFINITY, min)
    }

    /// Direction of a ray; nowhere beyond the last.
    #[must_use]
    pub fn direction(&self, ray: usize) -> Point {
        let at = |list: &[f64]| list.get(ray).copied().unwrap_or_default();
        Point::new(at(&self.x), at(&self.y))
    }

    /// Holds a face against every ray.
    fn meet_face(&mut self, face: &SeenFace) {
        let [ux, uy, p, q] = [face.u.x, face.u.y, face.p, face.q].map(f64x4::splat);
        let end = f64x4::splat(face.p + face.length);
        self.meet(face.number, |x, y| {
            let cos = x * uy - y * ux;
            // Where the ray meets the face's line, times the cosine.
            let along = q * (x * ux + y * uy);
            let met = cos.simd_gt(f64x4::ZERO)
                & along.simd_ge(p * cos)
                & along.simd_le(end * cos);
            // Most rays miss, without a division.
            met.any().then(|| (met, q / cos, cos))
        });
    }

    /// Holds a circle against every ray.
    fn meet_circle(&mut self, circle: &SeenCircle) {
        let [cx, cy] = [circle.center.x, circle.center.y].map(f64x4::splat);
        let squared = f64x4::splat(circle.radius * circle.radius);
        self.meet(circle.number, |x, y| {
            let across = x * cy - y * cx;
            let depth = squared - across * across;
            let reached = depth.simd_ge(f64x4::ZERO);
            let way = x * cx + y * cy - reached.select(depth, f64x4::ZERO).sqrt();
            let met = reached & way.simd_gt(f64x4::ZERO);
            met.any().then_some((met, way, f64x4::ONE))
        });
    }

    /// Holds thing `number` against every ray, four at a time: `met` says which of them meet it, how far off, and how. Of
    /// two things met at the same distance, the one first in the world's list counts.
    #[inline(always)]
    fn meet(&mut self, number: f64, met: impl Fn(f64x4, f64x4) -> Option<(f64x4, f64x4, f64x4)>) {
        let number = f64x4::splat(number);
        let [x, y] = [&self.x, &self.y].map(|list| list.as_chunks::<4>().0);
        let ways = self.way.as_chunks_mut::<4>().0;
        let cosines = self.cos_incidence.as_chunks_mut::<4>().0;
        let numbers = self.number.as_chunks_mut::<4>().0;
        let known = ways.iter_mut().zip(cosines).zip(numbers);
        for ((x, y), ((way, cos), known)) in x.iter().zip(y).zip(known) {
            let Some((met, new, new_cos)) = met(f64x4::new(*x), f64x4::new(*y)) else {
                continue;
            };
            let (old, old_number) = (f64x4::new(*way), f64x4::new(*known));
            let earlier = new.simd_eq(old) & number.simd_lt(old_number);
            let first = met & (new.simd_lt(old) | earlier);
            *way = first.select(new, old).to_array();
            *cos = first.select(new_cos, f64x4::new(*cos)).to_array();
            *known = first.select(number, old_number).to_array();
        }
    }
}

/// A face as seen from the tip of a lobe; see [`super::View`].
#[derive(Debug, Clone, Copy)]
struct SeenFace {
    u: Point,
    p: f64,
    q: f64,
    length: f64,
    number: f64,
    /// Squared distance of the nearest point within the lobe, m².
    near: f64,
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
        self.around.look(world, middle, offset_m, reach_m);
        let around = std::mem::take(&mut self.around);
        let lobe = Lobe {
            tip: middle + axis * offset_m,
            axis,
            cone,
            reach: reach_m,
        };
        self.faces.clear();
        for (block, circle) in around.faces.blocks.iter().zip(&around.around_faces) {
            if lobe.may_reach(*circle) {
                self.keep_faces(block, &lobe);
            }
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
                self.keep_corners(block, &lobe);
            }
        }
        self.around = around;
    }

    /// Appends the corners of a block that lie in the lobe.
    #[inline]
    fn keep_corners(&mut self, block: &PointBlock, lobe: &Lobe) {
        let [ax, ay, tip_x, tip_y] =
            [lobe.axis.x, lobe.axis.y, lobe.tip.x, lobe.tip.y].map(f64x4::splat);
        let (xs, ys) = (block.x.as_chunks::<4>().0, block.y.as_chunks::<4>().0);
        for (xs, ys) in xs.iter().zip(ys) {
            let (x, y) = (f64x4::new(*xs) - tip_x, f64x4::new(*ys) - tip_y);
            let (along, across) = (ax * x + ay * y, (ax * y - ay * x).abs());
            let inside = (across * lobe.cone.cos).simd_le(along * lobe.cone.sin);
            let (x, y) = (x.to_array(), y.to_array());
            for lane in lanes(inside.to_bitmask()) {
                let corner = Point::new(x[lane], y[lane]);
                let range = corner.length();
                if range <= lobe.reach {
                    self.corners.push((corner, range));
                }
            }
        }
    }

    /// Appends the faces of a block of which any part lies in the lobe.
    #[inline]
    fn keep_faces(&mut self, block: &FaceBlock, lobe: &Lobe) {
        let [ax, ay, tip_x, tip_y] =
            [lobe.axis.x, lobe.axis.y, lobe.tip.x, lobe.tip.y].map(f64x4::splat);
        let (sin, cos) = (f64x4::splat(lobe.cone.sin), f64x4::splat(lobe.cone.cos));
        let (zero, infinity) = (f64x4::ZERO, f64x4::splat(f64::INFINITY));
        let slack = f64x4::splat(SLACK_M);
        for half in 0..LANES / 4 {
            let four = |list: &[f64; LANES]| f64x4::new(list.as_chunks::<4>().0[half]);
            let (ux, uy, length) = (four(&block.ux), four(&block.uy), four(&block.length));
            let (dx, dy) = (four(&block.ax) - tip_x, four(&block.ay) - tip_y);
            let (p, q) = (dx * ux + dy * uy, dx * uy - dy * ux);
            let (axis_u, axis_n) = (ax * ux + ay * uy, ax * uy - ay * ux);
            let (left_n, left_u) = (axis_n * cos - axis_u * sin, axis_u * cos + axis_n * sin);
            let (right_n, right_u) = (axis_n * cos + axis_u * sin, axis_u * cos - axis_n * sin);
            let (met_left, met_right) = (left_n.simd_gt(zero), right_n.simd_gt(zero));
            let end = p + length;
            // Whether the face begins right of the left edge and ends left of the right one, give or take rounding: most
            // do not, without a division.
            let right_of = (p * left_n - q * left_u).simd_le(slack) | !met_left;
            let left_of = (q * right_u - end * right_n).simd_le(slack) | !met_right;
            let seen = q.simd_gt(zero) & (met_left | met_right) & right_of & left_of;
            if !seen.any() {
                continue;
            }
            // An edge of the cone that runs away from the face bounds nothing.
            let left = met_left.select(q * left_u / left_n, infinity);
            let right = met_right.select(q * right_u / right_n, -infinity);
            let from = p.simd_gt(right).select(p, right);
            let to = end.simd_lt(left).select(end, left);
            let nearest = to.simd_lt(zero).select(to, zero);
            let nearest = from.simd_gt(nearest).select(from, nearest);
            let near = nearest * nearest + q * q;
            let reached = near.simd_le(f64x4::splat(lobe.reach * lobe.reach));
            let kept = seen & from.simd_le(to) & reached;
            let (p, q, near) = (p.to_array(), q.to_array(), near.to_array());
            for lane in lanes(kept.to_bitmask()) {
                let face = block.face(4 * half + lane);
                self.faces.push(SeenFace {
                    u: face.u,
                    p: p[lane],
                    q: q[lane],
                    length: face.length,
                    number: face.number,
                    near: near[lane],
                });
            }
        }
    }

    /// Lets the rays meet what lies in the lobe, which they must not leave, from near to far; what lies farther, m, than
    /// `far` says of what was met so far is left alone.
    pub fn meet(&self, rays: &mut Rays, mut far: impl FnMut(&Rays) -> f64) {
        let mut done = -1.0;
        loop {
            let next = self.nearest_beyond(done);
            let far = far(rays) + SLACK_M;
            if next == f64::INFINITY || next > far * far {
                return;
            }
            let until = next * STRIDE;
            let due = |near: f64| near > done && near <= until;
            for face in self.faces.iter().filter(|face| due(face.near)) {
                rays.meet_face(face);
            }
            for circle in self.circles.iter().filter(|circle| due(circle.near)) {
                rays.meet_circle(circle);
            }
            done = until;
        }
    }

    /// Squared distance of the nearest thing beyond a squared distance, m²; infinite if there is none.
    fn nearest_beyond(&self, done: f64) -> f64 {
        let beyond =
            |nearest: f64, near: f64| if near > done { min(nearest, near) } else { nearest };
        let faces = self.faces.iter().map(|face| face.near).fold(f64::INFINITY, beyond);
        self.circles.iter().map(|circle| circle.near).fold(faces, beyond)
    }

    /// The corners in the lobe, relative to its tip, and how far they are, m, hidden or not.
    #[must_use]
    pub fn corners(&self) -> &[(Point, f64)] {
        &self.corners
    }

    /// Unit vectors from the tip towards the places most likely to answer: the foot of the perpendicular
    /// on each face that has one, and the middle of each circle. They may lie outside the lobe.
    pub fn promising(&self) -> impl Iterator<Item = Point> + '_ {
        let feet = self.faces.iter();
        let feet = feet.filter(|face| face.p <= 0.0 && face.p + face.length >= 0.0);
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

/// The places of the ones in a mask, from the lowest.
fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (mask != 0).then(|| mask.trailing_zeros() as usize);
        mask &= mask.wrapping_sub(1);
        lane
    })
}
