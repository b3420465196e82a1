//! Limits of the motors, and modes of the turret.

use core::f64::consts::PI;
use core::str::FromStr;

use crate::nomad::COLLISION_RADIUS_M;
use files::error::BadInput;

/// Distances and angles below this count as zero (m, rad): the Nomad cannot measure them.
pub(super) const NEGLIGIBLE: f64 = 1e-9;

/// Size of the body, limits of the motors, and slip of the wheels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaseLimits {
    /// Radius of the disc that collides, m.
    pub radius_m: f64,
    /// Greatest speed, m/s: 20 in/s, the limit in the Nomad's own software.
    pub speed_m_s: f64,
    /// Acceleration and deceleration, m/s²: 30 in/s².
    pub acceleration_m_s2: f64,
    /// Greatest rate of steering and turret, rad/s: 45 °/s.
    pub turn_rate_rad_s: f64,
    /// Acceleration of steering and turret, rad/s²: 30 °/s².
    pub turn_acceleration_rad_s2: f64,
    /// Slip of the wheels, which the odometry does not measure: standard deviation of distance (as
    /// a share) and direction (rad) of a timed motion. Drawn once per command.
    pub slip: f64,
}

impl Default for BaseLimits {
    fn default() -> Self {
        Self {
            radius_m: COLLISION_RADIUS_M,
            speed_m_s: 0.508,
            acceleration_m_s2: 0.762,
            turn_rate_rad_s: PI / 4.0,
            turn_acceleration_rad_s2: PI / 6.0,
            slip: 0.02,
        }
    }
}

/// Motion of the turret while the base steers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TurretMode {
    /// It keeps its bearing in the world.
    #[default]
    Held,
    /// It turns with the wheels, which then always roll forward.
    Follow,
}

impl TurretMode {
    /// Name of the mode.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Held => "held",
            Self::Follow => "follow",
        }
    }
}

impl FromStr for TurretMode {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "held" => Ok(Self::Held),
            "follow" => Ok(Self::Follow),
            _ => Err(BadInput::unknown("turret mode", text, &["held", "follow"])),
        }
    }
}
