//! Solid discs: posts and columns.

use super::tree::Bounds;
use crate::geometry::Point;
use crate::shapes::Shape;

/// Number of the first circle, above those of all faces.
pub(crate) const FIRST_CIRCLE: f64 = 1e9;

/// A solid disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Circle {
    pub center: Point,
    pub radius: f64,
    /// Its index in the world's list plus [`FIRST_CIRCLE`].
    pub number: f64,
}

impl Circle {
    /// The circle with this index in the world's list.
    pub fn new(center: Point, radius: f64, index: usize) -> Self {
        Self {
            center,
            radius,
            number: FIRST_CIRCLE + index as f64,
        }
    }

    /// Distance of a point inside or outside from its boundary, m.
    pub fn distance(&self, place: Point) -> f64 {
        (place.distance(self.center) - self.radius).abs()
    }

    /// Its bounding box.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.center, self.radius)
    }
}

/// The circles of `shapes`, numbered in their order.
pub(crate) fn list_circles(shapes: &[Shape]) -> Vec<Circle> {
    let mut circles = Vec::new();
    for shape in shapes {
        if let Shape::Circle { center, radius } = *shape {
            circles.push(Circle::new(center, radius, circles.len()));
        }
    }
    circles
}
