//! An angle together with its unit vector.

use crate::world::Point;

/// An angle in the plane, rad, whose sine and cosine are worked out when asked for, once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Direction {
    angle: f64,
    unit: Option<Point>,
}

impl Direction {
    pub(super) fn new(angle: f64) -> Self {
        Self { angle, unit: None }
    }

    /// The angle, rad.
    pub(super) fn angle(&self) -> f64 {
        self.angle
    }

    /// The unit vector at that angle.
    pub(super) fn unit(&mut self) -> Point {
        *self.unit.get_or_insert_with(|| Point::unit(self.angle))
    }

    /// Becomes another angle, rad.
    pub(super) fn set(&mut self, angle: f64) {
        if angle.to_bits() != self.angle.to_bits() {
            *self = Self::new(angle);
        }
    }
}
