//! The angle between the wheels and the bearing to which they turn, as a way for a servo.

use core::f64::consts::{FRAC_PI_2, PI};

use super::limits::TurretMode;
use super::servo::TravelLeft;
use crate::geometry::wrap_angle;

/// The wheels on their way to a bearing, mirrored if need be so that their angle grows.
#[derive(Debug, Clone, Copy)]
pub(super) struct SteeringWay {
    pub(super) bearing: f64,
    /// The half turns that the bearing is farther away than the end.
    pub(super) halves: f64,
    pub(super) wheels: f64,
}

impl TravelLeft for SteeringWay {
    /// As [`angle_to_turn`] with as many half turns off: to take them off is exact, one by one or
    /// at once. Their number never grows, so if it is the same at both ends of a stride it is in
    /// between.
    fn left(&self) -> f64 {
        self.bearing - self.wheels - self.halves
    }

    fn go(&mut self, way: f64) {
        self.wheels += way;
    }
}

/// Whether an angle is in [−π, π).
pub(super) fn is_wrapped(angle: f64) -> bool {
    wrap_angle(angle) == angle
}

/// The angle to turn the wheels by, so that they point along a bearing, rad: straight towards it,
/// or straight away from it where that is the shorter turn and the turret does not follow.
pub(super) fn angle_to_turn(turret: TurretMode, bearing: f64, wheels: f64) -> f64 {
    let left = wrap_angle(bearing - wheels);
    if turret == TurretMode::Held && left.abs() > FRAC_PI_2 {
        left - if left > 0.0 { PI } else { -PI }
    } else {
        left
    }
}
