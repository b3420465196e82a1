//! The pose that the robot reports: wheel odometry from an origin that a host may set.

use super::units::{M_PER_TENTH_INCH, whole, whole_angle};
use arena::world::Point;

/// Origins of the reported pose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct DeadReckoning {
    position: Point,
    /// Reported angle minus the axis's own.
    steering: f64,
    turret: f64,
}

impl DeadReckoning {
    /// Adds a displacement in the frame of the steering axis.
    pub(super) fn roll(&mut self, displacement: Point) {
        self.position = self.position + displacement.turned(Point::unit(self.steering));
    }

    /// x, y, steering and turret for these angles of the axes.
    pub(super) fn reported(&self, steering: f64, turret: f64) -> [i32; 4] {
        [
            whole(self.position.x, M_PER_TENTH_INCH),
            whole(self.position.y, M_PER_TENTH_INCH),
            whole_angle(steering + self.steering),
            whole_angle(turret + self.turret),
        ]
    }

    /// `dp`: sets the position, m.
    pub(super) fn define_position(&mut self, position: Point) {
        self.position = position;
    }

    /// `da`: sets the reported angles for the current angles of the axes.
    pub(super) fn define_angles(&mut self, axes: [f64; 2], reported: [f64; 2]) {
        self.steering = reported[0] - axes[0];
        self.turret = reported[1] - axes[1];
    }

    /// Difference between a reported angle and the current one, for steering (0) or turret (1).
    pub(super) fn off(&self, angle: usize, at: f64, reported: f64) -> f64 {
        let origin = if angle == 0 {
            self.steering
        } else {
            self.turret
        };
        arena::world::wrap_angle(reported - at - origin)
    }
}
