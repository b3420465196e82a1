//! A disc that moves straight ahead among points: the robot's body and the margin around it.

use crate::fixed::isqrt_u32;
use crate::units::{Direction, Displacement, div_round};

/// A disc beside a point comes nearer by as much, millimeters: rounding must not hold it.
const NEARER_MM: i32 = 4;

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

/// As [`until_contact`], for a disc that may touch the point already: it may go beside it, where it
/// comes no nearer than [`NEARER_MM`].
pub(crate) fn until_contact_beside(place: (i32, i32), radius_mm: i32, limit: i32) -> i32 {
    let (along, aside) = place;
    let is_near = magnitude(along) < radius_mm && magnitude(aside) < radius_mm;
    let radius_mm = if is_near {
        let square = |mm: i32| mm.unsigned_abs().saturating_pow(2);
        let distance = isqrt_u32(square(along).saturating_add(square(aside)));
        radius_mm.min(distance as i32 - NEARER_MM)
    } else {
        radius_mm
    };
    until_contact(place, radius_mm, limit)
}

/// The amount of a number, one less for those below 0: a single instruction on the chip.
pub(crate) const fn magnitude(value: i32) -> i32 {
    value ^ (value >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_goes_beside_what_it_touches_and_comes_no_nearer() {
        let until = |along, aside| until_contact_beside((along, aside), 319, 250);
        // Outside, as any disc.
        assert_eq!(until(400, 0), 81);
        assert_eq!(until(0, 290), 250);
        // 4 mm nearer to a thing at 290 mm, no more.
        assert_eq!(until(46, 286), 250);
        assert_eq!(until(60, 283), 27);
        assert_eq!(until(290, 0), 4);
        assert_eq!(until(-60, 283), 250, "behind");
    }

    #[test]
    fn extreme_places_do_no_harm() {
        for (along, aside) in [(65_534, 65_534), (46_341, -46_341), (1, 0), (0, 0)] {
            let until = until_contact_beside((along, aside), i32::from(u16::MAX), 250);
            assert!((0..=250).contains(&until));
        }
    }
}
