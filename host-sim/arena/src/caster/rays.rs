//! Rays of sound from one place, and what each meets first, four at a time.

use wide::f64x4;

use crate::geometry::Point;
use crate::surfaces::LANES;

/// A face as seen from the tip of a lobe.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenFace {
    pub u: Point,
    pub p: f64,
    pub q: f64,
    pub length: f64,
    pub number: f64,
    /// Squared distance of the nearest point within the lobe, m².
    pub near: f64,
}

impl SeenFace {
    /// Whether the foot of the perpendicular from the tip lies on it.
    pub fn has_foot(&self) -> bool {
        self.p <= 0.0 && self.p + self.length >= 0.0
    }
}

/// A circle as seen from the tip of a lobe.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenCircle {
    pub center: Point,
    pub radius: f64,
    pub number: f64,
    pub near: f64,
}

/// Rays from one tip and what each met first, one list per quantity. Reusable.
///
/// The lists are filled up to whole blocks of eight with rays of length 0, which meet nothing.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rays {
    x: Vec<f64>,
    y: Vec<f64>,
    way: Vec<f64>,
    cos_incidence: Vec<f64>,
    number: Vec<f64>,
    count: usize,
}

impl Rays {
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

    /// These rays turned left by the angle whose unit vector is `direction`, none of which has met
    /// anything.
    pub fn turned_into(&self, direction: Point, out: &mut Self) {
        let rays = || self.x.iter().zip(&self.y);
        out.x.clear();
        out.y.clear();
        out.x
            .extend(rays().map(|(x, y)| x * direction.x - y * direction.y));
        out.y
            .extend(rays().map(|(x, y)| x * direction.y + y * direction.x));
        out.begin(self.count);
    }

    /// Resets what the rays have met; `count` of the places are rays.
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

    /// Length of each ray, m: infinite while it has met nothing, and for padding.
    #[must_use]
    pub fn ways(&self) -> &[f64] {
        &self.way
    }

    /// Cosine of the angle between each ray and the normal of the face it met; 1 for a circle, 0
    /// for nothing.
    #[must_use]
    pub fn cos_incidences(&self) -> &[f64] {
        &self.cos_incidence
    }

    /// Number of the surface each ray met: a face's or, higher than those, a circle's place in the
    /// world's list; −∞ for nothing.
    #[must_use]
    pub fn numbers(&self) -> &[f64] {
        &self.number
    }

    /// Direction of a ray; nowhere beyond the last.
    #[must_use]
    pub fn direction(&self, ray: usize) -> Point {
        let at = |list: &[f64]| list.get(ray).copied().unwrap_or_default();
        Point::new(at(&self.x), at(&self.y))
    }

    /// Intersects every ray with a face.
    pub(super) fn meet_face(&mut self, face: &SeenFace) {
        let [ux, uy, p, q] = [face.u.x, face.u.y, face.p, face.q].map(f64x4::splat);
        let end = f64x4::splat(face.p + face.length);
        self.meet(face.number, |x, y| {
            let cos = x * uy - y * ux;
            // Where the ray meets the face's line, times the cosine.
            let along = q * (x * ux + y * uy);
            let met = cos.simd_gt(f64x4::ZERO) & along.simd_ge(p * cos) & along.simd_le(end * cos);
            // Most rays miss, without a division.
            met.any().then(|| (met, q / cos, cos))
        });
    }

    /// Intersects every ray with a circle.
    pub(super) fn meet_circle(&mut self, circle: &SeenCircle) {
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

    /// Intersects every ray with surface `number`, four at a time: `met` computes which of them
    /// meet it, how far, and the cosine. Of two surfaces met at the same distance, the first in the
    /// world's list counts.
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
