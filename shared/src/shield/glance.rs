//! What surely does not shorten a motion, told without a root.
//!
//! While the robot moves each echo is asked about, and nearly all come from far off the way. The motion's length is taken
//! for somewhat more than it is: then what holds along the motion, times its length, holds for the shield's own direction,
//! which is rounded.

use super::{Arc, CERTAIN_MOST_MM, LONGEST_AXIS_Q28, Lobe, Shielding, braking_distance, magnitude};
use crate::config::Config;
use crate::units::{Displacement, Range};

/// Motions and reaches beyond these are not glanced at: products leave 32 bits.
const LONGEST_MM: i32 = 1 << 10;
const FARTHEST_MM: i32 = 1 << 17;

/// A way ahead at a glance.
pub(super) struct Glance {
    dx: i32,
    dy: i32,
    /// No less than the length of the motion.
    length_mm: i32,
    /// What lies this far beside the way is not met.
    reach_mm: i32,
    /// What lies this far along the way is not met.
    end_mm: i32,
    /// Nor is what lies farther than this from the robot.
    certain_mm: i32,
    least_range_mm: i32,
    /// No end of an arc is farther from its middle than this share of its range; less than 2¹⁶.
    spread_q14: i32,
}

impl Glance {
    /// `None` for a way that has to be looked at closely.
    #[inline(always)]
    pub(super) fn along<const SENSORS: usize>(
        config: &Config<SENSORS>,
        shielding: &Shielding,
        lobe: &Lobe,
        wanted: Displacement,
    ) -> Option<Self> {
        let (dx, dy) = (i32::from(wanted.dx_mm), i32::from(wanted.dy_mm));
        let length_mm = no_less_than_length(dx.wrapping_abs(), dy.wrapping_abs());
        // Two more for the roundings of the direction and along it.
        let reach_mm = i32::from(config.robot.body_radius_mm)
            .wrapping_add(i32::from(shielding.margin_mm))
            .wrapping_add(2);
        let least_range_mm = i32::from(shielding.least_range_mm);
        let limit = braking_distance(config).saturating_add(length_mm);
        let end_mm = limit.saturating_add(reach_mm);
        let may_glance = length_mm < LONGEST_MM
            && end_mm < FARTHEST_MM
            && lobe.half == shielding.half_lobe
            && shielding.approach_mm_s == 0;
        may_glance.then_some(Self {
            dx,
            dy,
            length_mm,
            reach_mm,
            end_mm,
            certain_mm: limit.wrapping_add(reach_mm.max(least_range_mm.wrapping_add(2))),
            least_range_mm,
            spread_q14: lobe.spread_q14 as i32,
        })
    }

    /// Whether an arc is surely not met.
    #[inline(always)]
    pub(super) fn passes(&self, face: Displacement, arc: &Arc) -> bool {
        // Nothing heard is farther than any range.
        let range = i32::from(!Range::nearness(arc.range));
        let (x, y) = (i32::from(face.dx_mm), i32::from(face.dy_mm));
        let slack = magnitude(x).wrapping_add(magnitude(y));
        range > self.certain_mm.wrapping_add(slack) || self.is_aside(x, y, range, arc)
    }

    /// Whether all of an arc lies behind, beside the way or beyond its end.
    #[inline(always)]
    fn is_aside(&self, face_x: i32, face_y: i32, range: i32, arc: &Arc) -> bool {
        if range <= self.least_range_mm || range > CERTAIN_MOST_MM as i32 {
            return false;
        }
        let (ax, ay) = (i32::from(arc.axis.x_q14), i32::from(arc.axis.y_q14));
        let out = |axis_q14: i32| range.wrapping_mul(axis_q14) >> 14;
        // The middle; roundings of less than 8 at the ends.
        let (x, y) = (face_x.wrapping_add(out(ax)), face_y.wrapping_add(out(ay)));
        let spread = (range.wrapping_mul(self.spread_q14) >> 14).wrapping_add(8);
        let times_length = |mm: i32| mm.wrapping_mul(self.length_mm);
        let along = x
            .wrapping_mul(self.dx)
            .wrapping_add(y.wrapping_mul(self.dy));
        let across = y
            .wrapping_mul(self.dx)
            .wrapping_sub(x.wrapping_mul(self.dy));
        let is_aside = along <= times_length(spread).wrapping_neg()
            || across.wrapping_abs() >= times_length(self.reach_mm.wrapping_add(spread))
            || along >= times_length(self.end_mm.wrapping_add(spread));
        is_aside && ax.wrapping_mul(ax).wrapping_add(ay.wrapping_mul(ay)) < LONGEST_AXIS_Q28
    }
}

/// A bound of the root of a² + b² within a twentieth and 2: a chord from no slope to one half, and one from there to one.
const fn no_less_than_length(a: i32, b: i32) -> i32 {
    let (long, short) = if a < b { (b, a) } else { (a, b) };
    let flat = long.wrapping_add(short >> 2);
    let steep = long.wrapping_mul(27).wrapping_add(short.wrapping_mul(19)) >> 5;
    let bound = if flat < steep { steep } else { flat };
    bound.wrapping_add(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_is_no_less_than_the_length_and_hardly_more() {
        for a in (0..=32_768).step_by(641) {
            for b in (0..=32_768).step_by(509) {
                let (length, bound) = (f64::from(a).hypot(f64::from(b)), no_less_than_length(a, b));
                assert!(length <= f64::from(bound) && f64::from(bound) <= length * 1.05 + 2.0);
            }
        }
    }
}
