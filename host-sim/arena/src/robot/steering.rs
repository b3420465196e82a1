//! The angle between the wheels and their target bearing, for a servo.

use core::f64::consts::{FRAC_PI_2, PI};

use super::limits::TurretMode;
use super::servo::RemainingDistance;
use crate::geometry::wrap_angle;

/// Motion of the wheels to a bearing, mirrored if necessary so that their angle increases.
#[derive(Debug, Clone, Copy)]
pub(super) struct SteeringPath {
    pub(super) bearing: f64,
    /// Half turns between the bearing and the final angle of the wheels, rad.
    pub(super) half_turns: f64,
    pub(super) wheels: f64,
}

impl RemainingDistance for SteeringPath {
    /// As [`angle_to_turn`]; subtracting the half turns is exact. Their number never increases, so
    /// if it is the same at both ends of a stride, it is the same in between.
    fn remaining(&self) -> f64 {
        self.bearing - self.wheels - self.half_turns
    }

    fn advance(&mut self, angle: f64) {
        self.wheels += angle;
    }
}

/// Whether an angle is in [−π, π).
pub(super) fn is_wrapped(angle: f64) -> bool {
    wrap_angle(angle) == angle
}

/// Angle by which the wheels turn to point along a bearing, rad. With a held turret they may also
/// point in the opposite direction if that turn is shorter.
pub(super) fn angle_to_turn(turret: TurretMode, bearing: f64, wheels: f64) -> f64 {
    let left = wrap_angle(bearing - wheels);
    if turret == TurretMode::Held && left.abs() > FRAC_PI_2 {
        left - if left > 0.0 { PI } else { -PI }
    } else {
        left
    }
}
