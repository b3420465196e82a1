//! Conversions between the Nomad's units and meters, radians and seconds.

use arena::sonar::M_PER_INCH;
use core::f64::consts::PI;

/// 0.1 in, the unit of lengths, speeds and accelerations of translation.
pub const M_PER_TENTH_INCH: f64 = M_PER_INCH / 10.0;

/// 0.1°, the unit of steering and turret.
pub const RAD_PER_TENTH_DEGREE: f64 = PI / 1_800.0;

/// Units per turn.
pub const TENTH_DEGREES_PER_TURN: i32 = 3_600;

/// Size of a unit of each axis: translation, steering, turret.
pub const PER_UNIT: [f64; 3] = [M_PER_TENTH_INCH, RAD_PER_TENTH_DEGREE, RAD_PER_TENTH_DEGREE];

/// Rounds to whole units; saturates.
#[must_use]
pub fn whole(quantity: f64, unit: f64) -> i32 {
    libm::rint(quantity / unit) as i32
}

/// An angle in the robot's units: 0 … 3599.
#[must_use]
pub fn whole_angle(rad: f64) -> i32 {
    whole(rad, RAD_PER_TENTH_DEGREE).rem_euclid(TENTH_DEGREES_PER_TURN)
}
