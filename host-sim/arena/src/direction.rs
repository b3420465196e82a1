//! An angle and its unit vector.

use crate::geometry::Point;

/// An angle in the plane, rad. Its unit vector is computed on first use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CachedDirection {
    angle: f64,
    unit: Option<Point>,
}

impl CachedDirection {
    pub(crate) fn new(angle: f64) -> Self {
        Self { angle, unit: None }
    }

    /// The angle, rad.
    pub(crate) fn angle(&self) -> f64 {
        self.angle
    }

    /// The unit vector at that angle.
    pub(crate) fn unit(&mut self) -> Point {
        *self.unit.get_or_insert_with(|| Point::unit(self.angle))
    }

    /// Changes the angle, rad.
    pub(crate) fn set(&mut self, angle: f64) {
        if angle.to_bits() != self.angle.to_bits() {
            *self = Self::new(angle);
        }
    }
}
