//! Cone queries, and the surroundings of a position prepared for them.
//!
//! A face at distance `q` along its normal starts at `p` along it, from the foot of the
//! perpendicular. An edge of the cone intersects its line at `q·tan` of the edge's angle to the
//! normal. Between both edges, the point nearest to the foot is the nearest. No other surface can
//! hide the nearest point of all.

use crate::geometry::{Point, clamp, max, min};
use crate::surfaces::{Circle, FaceBlock, LANES, Surfaces};

/// A squared distance above all results, m².
const NOTHING: f32 = 1e18;

/// Margins for the rounding of f32, in m and as a share of the reach.
const SLACK_M: f64 = 1e-3;
const ROUNDING: f64 = 1e-5;

/// A tangent beyond any face: the edge of a cone is parallel to the face or points away from it.
const BEYOND: f32 = 1e9;

/// Faces relative to the middle of a view, m. `n`, the normal towards the face, is `u` turned
/// right.
#[derive(Debug, Clone)]
struct ViewBlock {
    ux: [f32; LANES],
    uy: [f32; LANES],
    /// Start of the face, along `u`.
    p: [f32; LANES],
    /// Distance of its line, along `n`; negative when seen from behind.
    q: [f32; LANES],
    length: [f32; LANES],
    /// Squared distance from the middle to the nearest of these faces, m².
    nearest_squared: f64,
}

impl ViewBlock {
    const EMPTY: Self = Self {
        ux: [1.0; LANES],
        uy: [0.0; LANES],
        p: [0.0; LANES],
        q: [-BEYOND; LANES],
        length: [0.0; LANES],
        nearest_squared: f64::INFINITY,
    };
}

/// The faces and circles that cones around one position may contain.
///
/// It is built once per position, in f64. A query runs once per cone, in f32 relative to the
/// position, with an error of at most 1 µm + 1 ppm.
#[derive(Debug)]
pub struct ConeView {
    offset_m: f64,
    reach_m: f64,
    /// From near to far.
    blocks: Vec<ViewBlock>,
    /// Relative to the middle: x, y, radius, m.
    circles: Vec<(f64, f64, f64)>,
}

/// Sine and cosine of a cone's half angle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ConeShape {
    pub(crate) sin: f64,
    pub(crate) cos: f64,
}

impl ConeShape {
    /// A cone of ±`half_angle` rad, which must lie in (0, π/2).
    #[must_use]
    pub fn new(half_angle: f64) -> Self {
        let (sin, cos) = libm::sincos(half_angle);
        Self { sin, cos }
    }
}

impl ConeView {
    /// Collects the surfaces around `middle`, for cones with tips `offset_m` from it and a reach of
    /// `reach_m`.
    pub(super) fn new(
        surfaces: &Surfaces,
        posts: &[Circle],
        middle: Point,
        offset_m: f64,
        reach_m: f64,
    ) -> Self {
        let reach = reach_m + offset_m;
        let mut faces = FacesAround {
            middle,
            offset_m,
            reach,
            blocks: Vec::new(),
            kept: 0,
        };
        surfaces.faces_near(middle, reach, |block| faces.keep(block));
        let mut circles = Vec::new();
        let mut keep = |circle: &Circle| {
            let offset = circle.center - middle;
            if offset.length() - circle.radius <= reach {
                circles.push((offset.x, offset.y, circle.radius));
            }
        };
        surfaces.circles_near(middle, reach, &mut keep);
        posts.iter().for_each(keep);
        let mut blocks = faces.blocks;
        blocks.sort_unstable_by(|a, b| a.nearest_squared.total_cmp(&b.nearest_squared));
        Self {
            offset_m,
            reach_m,
            blocks,
            circles,
        }
    }

    /// Distance from the tip of a cone around the unit vector `axis`, offset along it, to the
    /// nearest surface inside the cone, m; at least 1e9 if there is none.
    #[must_use]
    pub fn nearest_in_cone(&self, axis: Point, cone: ConeShape) -> f64 {
        let faces = self.nearest_face(axis, cone).sqrt();
        self.circles.iter().fold(faces, |nearest, &(x, y, radius)| {
            let center = Point::new(x, y) - axis * self.offset_m;
            min(nearest, circle_in_cone(center, radius, axis, cone))
        })
    }

    /// Squared distance of the nearest face, m².
    fn nearest_face(&self, axis: Point, cone: ConeShape) -> f64 {
        let tip = Tip {
            axis: [axis.x as f32, axis.y as f32],
            offset: self.offset_m as f32,
            cone: [cone.sin as f32, cone.cos as f32],
        };
        // A tip is nearer to a face than the middle by at most this.
        let nearer = self.offset_m + SLACK_M + ROUNDING * self.reach_m;
        let mut best = [NOTHING; LANES];
        for block in &self.blocks {
            if is_found(&best, block.nearest_squared.sqrt() - nearer) {
                break;
            }
            tip.meet(block, &mut best);
        }
        f64::from(best.into_iter().fold(NOTHING, min32))
    }
}

/// Collects the faces that cones around one position may contain.
struct FacesAround {
    middle: Point,
    offset_m: f64,
    reach: f64,
    blocks: Vec<ViewBlock>,
    kept: usize,
}

impl FacesAround {
    /// Appends the faces of a block that are within reach and have their front to a tip.
    #[inline]
    fn keep(&mut self, block: &FaceBlock) {
        let (middle, front) = (self.middle, -self.offset_m);
        let reach_squared = self.reach * self.reach;
        let (mut p, mut q, mut squared) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let (dx, dy) = (block.ax[i] - middle.x, block.ay[i] - middle.y);
            p[i] = dx * block.ux[i] + dy * block.uy[i];
            q[i] = dx * block.uy[i] - dy * block.ux[i];
            let nearest = clamp(0.0, p[i], p[i] + block.length[i]);
            squared[i] = nearest * nearest + q[i] * q[i];
        }
        for i in 0..LANES {
            if q[i] > front && squared[i] <= reach_squared {
                self.push(block, i, [p[i], q[i], squared[i]]);
            }
        }
    }

    fn push(&mut self, block: &FaceBlock, i: usize, [p, q, squared]: [f64; 3]) {
        let lane = self.kept % LANES;
        if lane == 0 {
            self.blocks.push(ViewBlock::EMPTY);
        }
        self.kept += 1;
        let Some(seen) = self.blocks.last_mut() else {
            return;
        };
        seen.ux[lane] = block.ux[i] as f32;
        seen.uy[lane] = block.uy[i] as f32;
        seen.p[lane] = p as f32;
        seen.q[lane] = q as f32;
        seen.length[lane] = block.length[i] as f32;
        seen.nearest_squared = min(seen.nearest_squared, squared);
    }
}

/// The tip of a cone.
struct Tip {
    axis: [f32; 2],
    /// Its distance from the middle of the view, m.
    offset: f32,
    /// Sine and cosine of half its angle.
    cone: [f32; 2],
}

impl Tip {
    /// Lowers each of the best squared distances to that of the block's face in the same lane, m².
    #[inline]
    fn meet(&self, block: &ViewBlock, best: &mut [f32; LANES]) {
        let ([cx, cy], offset, [sin, cos]) = (self.axis, self.offset, self.cone);
        for (i, best) in best.iter_mut().enumerate() {
            let (ux, uy) = (block.ux[i], block.uy[i]);
            let axis_u = cx * ux + cy * uy;
            let axis_n = cx * uy - cy * ux;
            let q = block.q[i] - offset * axis_n;
            let p = block.p[i] - offset * axis_u;
            let (left_n, left_u) = (axis_n * cos - axis_u * sin, axis_u * cos + axis_n * sin);
            let (right_n, right_u) = (axis_n * cos + axis_u * sin, axis_u * cos - axis_n * sin);
            let left = q * left_u / left_n;
            let right = q * right_u / right_n;
            let left = if left_n > 0.0 { left } else { BEYOND };
            let right = if right_n > 0.0 { right } else { -BEYOND };
            let from = max32(p, right);
            let to = min32(p + block.length[i], left);
            let nearest = max32(from, min32(to, 0.0));
            let squared = nearest * nearest + q * q;
            let seen = (q > 0.0) & (from <= to) & (max32(left_n, right_n) > 0.0);
            *best = min32(*best, if seen { squared } else { NOTHING });
        }
    }
}

/// Whether one of the squared distances lies below that of `least` m.
#[inline]
fn is_found(squared: &[f32; LANES], least: f64) -> bool {
    if least <= 0.0 {
        return false;
    }
    let most = (least * least) as f32;
    squared
        .iter()
        .fold(false, |found, &squared| found | (squared < most))
}

#[inline(always)]
fn min32(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn max32(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Distance from the tip of a cone to the nearest point of a circle inside it, m. The nearest
/// direction is the one to the circle's middle, or the edge of the cone next to it.
pub(crate) fn circle_in_cone(center: Point, radius: f64, axis: Point, cone: ConeShape) -> f64 {
    let (along, across) = (axis.dot(center), axis.cross(center).abs());
    // Angle from the axis within the half angle, by the sine of the difference.
    if across * cone.cos <= along * cone.sin {
        return max((along * along + across * across).sqrt() - radius, 0.0);
    }
    let edge_along = along * cone.cos + across * cone.sin;
    let edge_across = across * cone.cos - along * cone.sin;
    let depth = radius * radius - edge_across * edge_across;
    if depth < 0.0 || edge_along <= 0.0 {
        return f64::from(NOTHING).sqrt();
    }
    max(edge_along - depth.sqrt(), 0.0)
}
