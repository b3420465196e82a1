//! What one lobe can meet.
//!
//! A [`LobeView`] holds the faces, circles and corners that one lobe can meet, so that a fan of rays pays only for those.
//! Rays meet them in two ways: all rays at once ([`LobeView::meet`]), or as few as tell the nearest answer
//! ([`LobeView::nearest_answer`]).

use wide::f64x4;

use super::World;
use super::answer::{Fan, Search, Things};
use super::faces::{FaceBlock, Faces, LANES};
use super::geometry::Point;
use super::rays::{Rays, SeenCircle, SeenFace};
use super::surroundings::Surroundings;
use super::view::{ConeShape, circle_in_cone};

/// How much farther than an answer things are still looked at, m: far above any rounding.
const SLACK_M: f64 = 1e-3;

/// How much nearer than a corner a ray may end and still be said to reach it, m.
const CORNER_SLACK_M: f64 = 1e-6;

/// A lobe: where it begins and where it points.
#[derive(Debug, Clone, Copy, Default)]
struct Lobe {
    tip: Point,
    axis: Point,
    cone: ConeShape,
    reach: f64,
}

/// What one lobe can meet. Reusable: building it again seldom allocates.
#[derive(Debug, Clone, Default)]
pub struct LobeView {
    around: Surroundings,
    lobe: Lobe,
    /// Faces that may lie in the lobe.
    candidates: Faces,
    /// From near to far.
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
        let lobe = Lobe {
            tip: middle + axis * offset_m,
            axis,
            cone,
            reach: reach_m,
        };
        self.lobe = lobe;
        let sector = self.around.sector(lobe.tip, axis, cone);
        self.candidates.clear();
        for (block, outline) in self.around.faces.blocks.iter().zip(&self.around.outlines) {
            for lane in lanes(sector.faces(outline)) {
                self.candidates.push(block.face(lane));
            }
        }
        self.faces.clear();
        for (index, block) in self.candidates.blocks.iter().enumerate() {
            let used = LANES.min(self.candidates.count() - LANES * index);
            keep_faces(&mut self.faces, block, used, &lobe);
        }
        self.faces
            .sort_unstable_by(|a, b| a.near.total_cmp(&b.near));
        self.circles.clear();
        for circle in self.around.circles.iter().chain(&world.posts) {
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
    }

    /// Collects the corners in the lobe that are from `least` to `most` m from its tip, hidden or not: where they are,
    /// relative to the tip, and how far.
    pub fn corners(&mut self, least: f64, most: f64) -> &mut [(Point, f64)] {
        let Lobe {
            tip,
            axis,
            cone,
            reach,
        } = self.lobe;
        let sector = self.around.sector(tip, axis, cone);
        let blocks = self.around.corners.chunks(LANES);
        self.corners.clear();
        for (block, corners) in self.around.corner_blocks.iter().zip(blocks) {
            for lane in lanes(sector.points(block, most)) {
                let Some(corner) = corners.get(lane).map(|corner| *corner - tip) else {
                    continue;
                };
                let (along, across) = (axis.dot(corner), axis.cross(corner).abs());
                let range = corner.length();
                let inside = across * cone.cos <= along * cone.sin && range <= reach;
                if inside && range >= least && range <= most {
                    self.corners.push((corner, range));
                }
            }
        }
        &mut self.corners
    }

    /// How far the nearest corner is that is from `least` to `most` m from the tip and that nothing hides, m.
    pub fn nearest_corner(&mut self, least: f64, most: f64) -> Option<f64> {
        let axis = self.lobe.axis;
        let corners = self.corners(least, most);
        corners.sort_unstable_by(|a, b| a.1.total_cmp(&b.1));
        let things = Things {
            faces: &self.faces,
            circles: &self.circles,
        };
        let shown = self.corners.iter().find(|&&(corner, range)| {
            let towards = if range > 0.0 {
                corner * (1.0 / range)
            } else {
                axis
            };
            !things.hide(towards, range - CORNER_SLACK_M, f64::NEG_INFINITY)
        });
        shown.map(|(_, range)| *range)
    }

    /// Length, m, of the shortest of the rays of a [narrow](Fan::is_narrow) fan along the lobe's axis, as wide as the
    /// lobe, and of `others` in the lobe, that meets a circle, or a face with a cosine of at least `least_cos`, before
    /// anything else; infinite if none does. `least_facing` is the least cosine between the axis and a normal that any
    /// ray of the lobe meets so.
    #[must_use]
    pub fn nearest_answer(
        &self,
        fan: &Fan,
        others: &[Point],
        least_cos: f64,
        least_facing: f64,
    ) -> f64 {
        let search = Search {
            things: Things {
                faces: &self.faces,
                circles: &self.circles,
            },
            fan,
            axis: self.lobe.axis,
            others,
            least_cos,
            least_facing,
            best: f64::INFINITY,
        };
        search.run()
    }

    /// Lets the rays, which must not leave the lobe, meet what lies in it up to `far` m from its tip, and perhaps more.
    pub fn meet(&self, rays: &mut Rays, far: f64) {
        let most = (far + SLACK_M) * (far + SLACK_M);
        for face in self.faces.iter().filter(|face| face.near <= most) {
            rays.meet_face(face);
        }
        for circle in self.circles.iter().filter(|circle| circle.near <= most) {
            rays.meet_circle(circle);
        }
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

/// Appends those of the first `used` faces of a block of which any part lies in the lobe.
#[inline]
fn keep_faces(faces: &mut Vec<SeenFace>, block: &FaceBlock, used: usize, lobe: &Lobe) {
    let [ax, ay, tip_x, tip_y] =
        [lobe.axis.x, lobe.axis.y, lobe.tip.x, lobe.tip.y].map(f64x4::splat);
    let (sin, cos) = (f64x4::splat(lobe.cone.sin), f64x4::splat(lobe.cone.cos));
    let (zero, infinity) = (f64x4::ZERO, f64x4::splat(f64::INFINITY));
    let slack = f64x4::splat(SLACK_M);
    for half in 0..used.div_ceil(4) {
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
            faces.push(SeenFace {
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

/// The places of the ones in a mask, from the lowest.
fn lanes(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = (mask != 0).then(|| mask.trailing_zeros() as usize);
        mask &= mask.wrapping_sub(1);
        lane
    })
}
