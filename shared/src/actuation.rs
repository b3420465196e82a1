//! What a base makes of its commands, and what its odometry means, as far as either differs from
//! what it says: a frame turned on the body, wheels of another size, another axle.

use crate::units::{Bearing, Displacement};
use serde::{Deserialize, Serialize};

/// 1 in the units of [`Actuation::length_q12`] and [`Actuation::turn_q12`].
pub const ONE_Q12: u16 = 1 << 12;

/// A base whose commands and odometry share their errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Actuation {
    /// Where the base goes when it goes ahead, in the frame of its commands and its odometry.
    pub front: Bearing,
    /// True length of what the base takes for a length of 4 096; not 0.
    pub length_q12: u16,
    /// True turn of what the base takes for a turn of 4 096; not 0.
    pub turn_q12: u16,
}

impl Actuation {
    /// A base that does and tells what it says.
    pub const EXACT: Self = Self {
        front: Bearing::ZERO,
        length_q12: ONE_Q12,
        turn_q12: ONE_Q12,
    };

    /// What a base is to be told so that it moves by `wanted`, x ahead, after turning towards it.
    #[must_use]
    pub fn command(&self, wanted: Displacement) -> Displacement {
        if *self == Self::EXACT {
            return wanted;
        }
        let scaled = |value: i32, scale_q12: u16| {
            crate::units::div_round(value.wrapping_mul(ONE_Q12.into()), scale_q12.into())
        };
        let turns = scaled(wanted.bearing().as_signed_turns().into(), self.turn_q12);
        let bearing = self.front.plus(Bearing::from_turns(turns as u16));
        Displacement::along(bearing, scaled(wanted.length_mm().into(), self.length_q12))
    }
}

/// Odometry as it is, from what a base of some [`Actuation`] tells. What rounding leaves over goes
/// into the next report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Odometer {
    /// Left over of x, y and the turn, in 1/4 096 of their units.
    rest_q12: [i32; 3],
}

impl Odometer {
    /// Nothing left over.
    pub const NEW: Self = Self { rest_q12: [0; 3] };

    /// The true displacement, x ahead, and the true turn.
    pub fn correct(
        &mut self,
        actuation: &Actuation,
        moved: Displacement,
        turned: Bearing,
    ) -> (Displacement, Bearing) {
        if *actuation == Actuation::EXACT {
            return (moved, turned);
        }
        let along_front = moved.rotated(actuation.front.direction().mirrored());
        let length = i32::from(actuation.length_q12);
        let [x, y, turns] = [
            i32::from(along_front.dx_mm).wrapping_mul(length),
            i32::from(along_front.dy_mm).wrapping_mul(length),
            i32::from(turned.as_signed_turns()).wrapping_mul(actuation.turn_q12.into()),
        ];
        let [rest_x, rest_y, rest_turns] = &mut self.rest_q12;
        let moved = Displacement::saturating(whole(x, rest_x), whole(y, rest_y));
        (moved, Bearing::from_turns(whole(turns, rest_turns) as u16))
    }
}

/// The whole units of a value in 1/4 096 and the rest, which is replaced.
fn whole(value_q12: i32, rest_q12: &mut i32) -> i32 {
    let sum = value_q12.saturating_add(*rest_q12);
    let whole = sum.wrapping_add(1 << 11) >> 12;
    *rest_q12 = sum.wrapping_sub(whole << 12);
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees(angle: i32) -> Bearing {
        Bearing::from_turns((angle * 65_536 / 360) as u16)
    }

    const WRONG: Actuation = Actuation {
        front: Bearing::from_turns(0x4000),
        length_q12: 6_144,
        turn_q12: 3_072,
    };

    #[test]
    fn an_exact_base_is_told_and_tells_what_is() {
        let moved = Displacement::saturating(-7, 12);
        let mut odometer = Odometer::NEW;
        let seen = odometer.correct(&Actuation::EXACT, moved, degrees(-5));
        assert_eq!(seen, (moved, degrees(-5)));
        assert_eq!(Actuation::EXACT.command(moved), moved);
    }

    /// Its front is at 90°, it goes 1.5 times as far and turns 0.75 times as far as it thinks.
    #[test]
    fn a_wrong_base_is_told_what_makes_it_do_right() {
        let told = WRONG.command(Displacement::along(degrees(-60), 300));
        assert!((199..=200).contains(&told.length_mm()), "{told:?}");
        let off = told.bearing().minus(degrees(90 - 80)).as_signed_turns();
        assert!(off.abs() < 200, "{told:?}");
    }

    #[test]
    fn reports_of_a_millimeter_add_up() {
        let mut odometer = Odometer::NEW;
        let (mut x, mut y, mut turns) = (0, 0, 0);
        for _ in 0..1_000 {
            let step = Displacement::saturating(0, 1);
            let (moved, turned) = odometer.correct(&WRONG, step, Bearing::from_turns(1));
            x += i32::from(moved.dx_mm);
            y += i32::from(moved.dy_mm);
            turns += i32::from(turned.as_signed_turns());
        }
        assert_eq!((x, y, turns), (1_500, 0, 750));
    }
}
