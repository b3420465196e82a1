//! What lies around one place, prepared for cone queries, and the cone query itself.
//!
//! For a face seen from distance `q` along its normal, whose start lies `p` along it from the foot of
//! the perpendicular, the nearest point inside a cone is found without a branch: each edge of the cone
//! meets the face's line at `q·tan` of its angle to the normal; between the two meeting points and
//! between the face's ends, the point nearest to the foot is the nearest one. The line of sight to the
//! nearest point of *all* faces lies in the cone, so nothing can hide it.
//!
//! The view is built once per pose in f64, from the surroundings that hold for a whole neighborhood; it drops faces that
//! look away or lie too far. The query
//! runs once per transducer over what is left, in f32 relative to the robot: within 1 µm + 1 ppm. Both go from near to far,
//! and only as far as something could be nearer than what was found: in a crowd most of it is never looked at.

use super::World;
use super::faces::{FaceBlock, LANES, clamp, max, min};
use super::geometry::Point;
use super::neighborhoods::Neighborhoods;

/// A squared distance no query can reach, m².
const NOTHING: f32 = 1e18;

/// How much farther than an answer faces are still looked at, m and as a share of the reach: far above the rounding of f32.
const SLACK_M: f64 = 1e-3;
const ROUNDING: f64 = 1e-5;

/// A tangent past any face: where the edge of a cone runs parallel to a face or away from it.
const BEYOND: f32 = 1e9;

/// Faces as seen from the middle of a view, m. `n`, the normal towards the face, is `u` turned right.
#[derive(Debug, Clone)]
struct ViewBlock {
    ux: [f32; LANES],
    uy: [f32; LANES],
    /// Start of the face, along `u`.
    p: [f32; LANES],
    /// Distance of its line, along `n`; negative when seen from behind.
    q: [f32; LANES],
    length: [f32; LANES],
    /// Distance from the middle of the surroundings to the nearest of these and all later faces, m.
    from_m: f64,
}

impl ViewBlock {
    const EMPTY: Self = Self {
        ux: [1.0; LANES],
        uy: [0.0; LANES],
        p: [0.0; LANES],
        q: [-BEYOND; LANES],
        length: [0.0; LANES],
        from_m: 0.0,
    };
}

/// The faces and circles that may answer near one place. Reusable: building it again allocates nothing
/// once it has grown to the size of the world.
#[derive(Debug, Clone, Default)]
pub struct View {
    around: Neighborhoods,
    middle: Point,
    offset_m: f64,
    reach_m: f64,
    /// Faces from near to far.
    blocks: Vec<ViewBlock>,
    kept: usize,
    /// How many blocks of the surroundings have been looked at.
    taken: usize,
    /// Relative to the middle: x, y, radius, m.
    circles: Vec<(f64, f64, f64)>,
}

/// A cone as the query needs it: it opens by `half_angle` on either side of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ConeShape {
    pub(super) sin: f64,
    pub(super) cos: f64,
}

impl ConeShape {
    /// A cone of ±`half_angle` rad, which must lie in (0, π/2).
    #[must_use]
    pub fn new(half_angle: f64) -> Self {
        let (sin, cos) = libm::sincos(half_angle);
        Self { sin, cos }
    }
}

impl View {
    /// Looks at `world` from `middle`, for eyes at most `offset_m` from it that see what shows its front within `reach_m`
    /// and `offset_m` of it.
    pub fn build(&mut self, world: &World, middle: Point, offset_m: f64, reach_m: f64) {
        self.around.look(world, middle, offset_m, reach_m);
        (self.middle, self.offset_m, self.reach_m) = (middle, offset_m, reach_m);
        (self.kept, self.taken) = (0, 0);
        let reach = reach_m + offset_m;
        self.circles.clear();
        for circle in self.around.here.circles.iter().chain(&world.posts) {
            let offset = circle.center - middle;
            if offset.length() - circle.radius <= reach {
                self.circles.push((offset.x, offset.y, circle.radius));
            }
        }
    }

    /// How many blocks hold faces: full ones while there are more to come.
    fn ready(&self) -> usize {
        if self.taken < self.around.here.nearby.faces.blocks.len() {
            self.kept / LANES
        } else {
            self.kept.div_ceil(LANES)
        }
    }

    /// Looks at the next block of the surroundings.
    fn take(&mut self) {
        let around = std::mem::take(&mut self.around);
        if let (Some(block), Some(&from_m)) = (
            around.here.nearby.faces.blocks.get(self.taken),
            around.here.nearby.faces_m.get(self.taken),
        ) {
            self.keep_block(block, from_m);
        }
        self.taken += 1;
        if self.taken >= around.here.nearby.faces.blocks.len()
            && let Some(last) = self.blocks.get_mut(self.kept / LANES)
        {
            for lane in self.kept % LANES..LANES {
                last.q[lane] = -BEYOND;
                last.p[lane] = 0.0;
            }
        }
        self.around = around;
    }

    /// Appends the faces of a block that may answer.
    #[inline]
    fn keep_block(&mut self, block: &FaceBlock, from_m: f64) {
        let (middle, front) = (self.middle, -self.offset_m);
        let reach = self.reach_m + self.offset_m;
        let reach_squared = reach * reach;
        let mut kept = self.kept;
        if self.blocks.len() < kept / LANES + 2 {
            self.blocks.resize(kept / LANES + 2, ViewBlock::EMPTY);
        }
        let (mut p, mut q, mut keep) = ([0.0; LANES], [0.0; LANES], [false; LANES]);
        for i in 0..LANES {
            let (dx, dy) = (block.ax[i] - middle.x, block.ay[i] - middle.y);
            p[i] = dx * block.ux[i] + dy * block.uy[i];
            q[i] = dx * block.uy[i] - dy * block.ux[i];
            let nearest = clamp(0.0, p[i], p[i] + block.length[i]);
            keep[i] = (q[i] > front) & (nearest * nearest + q[i] * q[i] <= reach_squared);
        }
        for i in 0..LANES {
            // Written in any case and counted if kept: no branch to mispredict.
            if let Some(seen) = self.blocks.get_mut(kept / LANES) {
                let lane = kept % LANES;
                if lane == 0 {
                    seen.from_m = from_m;
                }
                seen.ux[lane] = block.ux[i] as f32;
                seen.uy[lane] = block.uy[i] as f32;
                seen.p[lane] = p[i] as f32;
                seen.q[lane] = q[i] as f32;
                seen.length[lane] = block.length[i] as f32;
            }
            kept += usize::from(keep[i]);
        }
        self.kept = kept;
    }

    /// Distance from an eye, `offset_m` from the middle along the unit vector `axis`, to the nearest
    /// surface inside the cone around that axis, m; at least 1e9 if there is none.
    #[must_use]
    pub fn nearest_in_cone(&mut self, axis: Point, offset_m: f64, cone: ConeShape) -> f64 {
        let faces = self.nearest_face(axis, offset_m, cone).sqrt();
        self.circles.iter().fold(faces, |nearest, &(x, y, radius)| {
            let center = Point::new(x, y) - axis * offset_m;
            min(nearest, circle_in_cone(center, radius, axis, cone))
        })
    }

    /// Squared distance of the nearest face, m².
    fn nearest_face(&mut self, axis: Point, offset_m: f64, cone: ConeShape) -> f64 {
        let eye = Eye {
            axis: [axis.x as f32, axis.y as f32],
            offset: offset_m as f32,
            cone: [cone.sin as f32, cone.cos as f32],
        };
        // A face at some distance from the middle of the surroundings is nearer to the eye by no more than this.
        let eye_from = self.around.here.apart_m(self.middle + axis * offset_m);
        let apart = eye_from + SLACK_M + ROUNDING * self.reach_m;
        let mut best = [NOTHING; LANES];
        let mut index = 0;
        loop {
            while index >= self.ready() && self.taken < self.around.here.nearby.faces.blocks.len() {
                self.take();
            }
            let ready = index < self.ready();
            match self.blocks.get(index).filter(|_| ready) {
                Some(block) if !is_found(&best, block.from_m - apart) => {
                    eye.meet(block, &mut best);
                    index += 1;
                }
                None if !is_found(&best, self.around.here.known_m() - apart) => {
                    let more = self.around.here.known_m() + SLACK_M;
                    self.around.know_faces(more);
                    (self.kept, self.taken, index) = (0, 0, 0);
                }
                _ => return f64::from(best.into_iter().fold(NOTHING, min32)),
            }
        }
    }
}

/// An eye and its cone.
struct Eye {
    axis: [f32; 2],
    /// How far from the middle of its view it lies, m.
    offset: f32,
    /// Sine and cosine of half its angle.
    cone: [f32; 2],
}

impl Eye {
    /// Takes of each place the lesser: the best so far, or the squared distance of the face in the block, m².
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

/// Whether one of the squared distances is that of something nearer than `least` m, or there can be nothing beyond.
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

/// Distance from the tip of a cone to the nearest point of a circle inside it, m. The nearest direction
/// is the one to the circle's middle, or the edge of the cone next to it.
pub(super) fn circle_in_cone(center: Point, radius: f64, axis: Point, cone: ConeShape) -> f64 {
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
