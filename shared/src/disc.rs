//! A disc that moves straight ahead among points: the robot's body and the margin around it.

use crate::fixed::isqrt_u32;
use crate::units::{Direction, Displacement, div_round};

/// The direction of a displacement of this length, millimeters.
pub(crate) fn direction_of(way: Displacement, length_mm: i32) -> Direction {
    let unit = |mm: i16| div_round(i32::from(mm) << 14, length_mm.max(1)) as i16;
    Direction {
        x_q14: unit(way.dx_mm),
        y_q14: unit(way.dy_mm),
    }
}

/// Distance until the disc touches a point, millimeters; `limit` where it does not before that. The
/// point lies `along` the way and `aside` of it. A point ahead of the center that the disc touches
/// already gives 0.
pub(crate) fn until_contact((along, aside): (i32, i32), radius_mm: i32, limit: i32) -> i32 {
    let beyond = along.wrapping_sub(limit);
    if along <= 0 || magnitude(aside) >= radius_mm || beyond >= radius_mm {
        return limit;
    }
    let squared = radius_mm
        .wrapping_mul(radius_mm)
        .wrapping_sub(aside.wrapping_mul(aside))
        .max(0);
    // A quick test without a root: most points lie beyond the limit.
    if beyond >= 0 && beyond.wrapping_mul(beyond) >= squared {
        return limit;
    }
    let half_chord = isqrt_u32(squared.unsigned_abs());
    along.wrapping_sub(half_chord as i32).max(0).min(limit)
}

/// The amount of a number, one less for those below 0: a single instruction on the chip.
pub(crate) const fn magnitude(value: i32) -> i32 {
    value ^ (value >> 31)
}
