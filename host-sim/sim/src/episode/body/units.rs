//! Conversions between the simulator's meters, radians and seconds and the controller's integers.

use amp::units::{Bearing, Displacement, Millis};
use std::f64::consts::TAU;

/// Simulated time on the controller's clock.
pub fn milliseconds(time_s: f64) -> Millis {
    // A signed conversion is a single instruction; no time is below 0.
    Millis::from_ms((time_s * 1e3 + 0.5) as i64 as u32)
}

pub(super) fn meters(displacement: Displacement) -> [f64; 2] {
    [
        f64::from(displacement.dx_mm) / 1e3,
        f64::from(displacement.dy_mm) / 1e3,
    ]
}

/// Rounds to the nearest millimeter, halves to even, and saturates.
pub(super) fn millimeters(m: f64) -> i16 {
    // The sum lies between 2⁵² and 2⁵³, so its lowest bits are those of a rounded integer.
    const ROUNDS: f64 = (3_u64 << 51) as f64;
    let most = f64::from(i16::MAX);
    ((m * 1e3).clamp(-most - 1.0, most) + ROUNDS).to_bits() as i16
}

/// The nearest bearing to an angle, rad.
#[must_use]
pub fn bearing(angle_rad: f64) -> Bearing {
    let turns = libm::rint(angle_rad / TAU * 65_536.0);
    Bearing::from_turns(turns as i64 as u16)
}

pub(super) fn angle(bearing: Bearing) -> f64 {
    f64::from(bearing.as_turns()) / 65_536.0 * TAU
}
