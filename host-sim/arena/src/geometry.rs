//! Points and poses in the plane: meters, radians, counter-clockwise positive.

use core::f64::consts::{PI, TAU};
use core::ops::{Add, Mul, Neg, Sub};
use serde::{Deserialize, Serialize};

/// A position or a displacement, in meters.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Point {
    /// Meters along the world's x axis.
    pub x: f64,
    /// Meters along the world's y axis.
    pub y: f64,
}

impl Point {
    /// The point (`x`, `y`), meters.
    #[must_use]
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// The unit vector at `angle` rad from the x axis.
    #[must_use]
    pub fn unit(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        Self::new(cos, sin)
    }

    /// Scalar product.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// The z component of the vector product: positive if `other` is to the left of `self`.
    #[must_use]
    pub fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Length, m.
    #[must_use]
    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Distance to `other`, m.
    #[must_use]
    pub fn distance(self, other: Self) -> f64 {
        (other - self).length()
    }

    /// Angle from the x axis, rad in [−π, π].
    #[must_use]
    pub fn angle(self) -> f64 {
        libm::atan2(self.y, self.x)
    }

    /// Turned left by the angle whose unit vector is `direction` (a product of complex numbers).
    #[must_use]
    pub fn turned(self, direction: Self) -> Self {
        Self::new(
            self.x * direction.x - self.y * direction.y,
            self.x * direction.y + self.y * direction.x,
        )
    }

    /// Turned right by the angle whose unit vector is `direction`: undoes [`Point::turned`].
    #[must_use]
    pub fn turned_back(self, direction: Self) -> Self {
        Self::new(self.dot(direction), direction.cross(self))
    }
}

impl Add for Point {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl Sub for Point {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

impl Mul<f64> for Point {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor)
    }
}

impl Neg for Point {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y)
    }
}

/// Position of the robot and direction of its turret.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pose {
    /// Center of the robot, m.
    pub position: Point,
    /// Bearing of the turret (sonar 0) in the world, rad, counter-clockwise from the x axis.
    pub heading: f64,
}

impl Pose {
    /// A robot at `position` whose turret points along `heading` (rad).
    #[must_use]
    pub const fn new(position: Point, heading: f64) -> Self {
        Self { position, heading }
    }
}

/// `angle` (rad) wrapped to [−π, π).
#[must_use]
pub fn wrap_angle(angle: f64) -> f64 {
    if (0.0..TAU).contains(&(angle + PI)) {
        // The common case; the formula below gives the same result.
        return angle;
    }
    let turned = angle - TAU * libm::floor((angle + PI) / TAU);
    // Rounding can give π itself, which is outside the interval.
    if turned >= PI { turned - TAU } else { turned }
}

/// The smaller of two numbers that are not NaN: one instruction, unlike `f64::min`.
#[inline(always)]
pub(crate) fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers that are not NaN.
#[inline(always)]
pub(crate) fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `x` clamped to [`low`, `high`], for `low <= high`.
#[inline(always)]
pub(crate) fn clamp(x: f64, low: f64, high: f64) -> f64 {
    max(low, min(x, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turning_left_and_back_is_the_identity() {
        let (p, direction) = (Point::new(1.25, -0.5), Point::unit(0.7));
        assert!(p.turned(direction).turned_back(direction).distance(p) < 1e-15);
        let up = Point::new(1.0, 0.0).turned(Point::new(0.0, 1.0));
        assert_eq!(up, Point::new(0.0, 1.0));
        assert!(Point::new(1.0, 0.0).cross(up) > 0.0);
    }

    #[test]
    fn angles_wrap_into_one_turn() {
        for (angle, expected) in [(0.0, 0.0), (PI, -PI), (-PI, -PI), (3.0 * PI, -PI)] {
            assert!((wrap_angle(angle) - expected).abs() < 1e-12, "{angle}");
        }
        assert!((wrap_angle(7.0) - (7.0 - TAU)).abs() < 1e-12);
        assert!((wrap_angle(-4.0) - (TAU - 4.0)).abs() < 1e-12);
    }
}
