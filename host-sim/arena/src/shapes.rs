//! Shapes of obstacles in a world.

use crate::geometry::Point;
use serde::{Deserialize, Serialize};

/// Smallest length of a segment, a box's side or a radius, m.
pub(crate) const MIN_SIZE_M: f64 = 1e-6;

/// Shape of an obstacle, for sound and robot. Meters and radians.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A thin wall: a chain of straight segments, solid from both sides.
    Wall {
        /// At least two points, no two neighbors equal.
        points: Vec<Point>,
    },
    /// A solid rectangle.
    Box {
        /// Its center.
        center: Point,
        /// Its full width and depth, both positive.
        size: Point,
        /// Its rotation, rad.
        angle: f64,
    },
    /// A solid disc: a post, a column.
    Circle {
        /// Its center.
        center: Point,
        /// Its radius, positive.
        radius: f64,
    },
    /// One straight segment of the outline of a solid, free on its left (occupancy maps). All
    /// segments of a world form closed outlines.
    Outline {
        /// Start of the segment.
        from: Point,
        /// End of the segment.
        to: Point,
    },
}

impl Shape {
    /// The wall of a room around the origin with these half sides, m.
    #[must_use]
    pub fn room(half: Point) -> Self {
        let corners = [
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
            (-1.0, -1.0),
        ];
        Self::Wall {
            points: corners
                .map(|(x, y)| Point::new(x * half.x, y * half.y))
                .to_vec(),
        }
    }

    /// The corners of a box, clockwise, so that its outside lies to the left of each side.
    #[must_use]
    pub fn box_corners(center: Point, size: Point, angle: f64) -> [Point; 4] {
        let along = Point::unit(angle);
        let half = size * 0.5;
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
            .map(|(x, y)| center + Point::new(x * half.x, y * half.y).turned(along))
    }

    /// Calls `visit` with the ends of every straight segment.
    pub fn for_each_segment(&self, mut visit: impl FnMut(Point, Point)) {
        match self {
            Self::Wall { points } => points.windows(2).for_each(|pair| visit(pair[0], pair[1])),
            Self::Box {
                center,
                size,
                angle,
            } => {
                let corners = Self::box_corners(*center, *size, *angle);
                for i in 0..4 {
                    visit(corners[i], corners[(i + 1) % 4]);
                }
            }
            Self::Circle { .. } => {}
            Self::Outline { from, to } => visit(*from, *to),
        }
    }

    /// Calls `visit` with every corner, edge and free end: they return an echo at any angle. A
    /// joint of two collinear segments is not a corner.
    pub(crate) fn for_each_corner(&self, mut visit: impl FnMut(Point)) {
        match self {
            Self::Wall { points } => wall_corners(points, visit),
            Self::Outline { from, .. } => visit(*from),
            _ => self.for_each_segment(|from, _| visit(from)),
        }
    }

    /// Whether `point` is inside this shape (never for a thin wall or an outline).
    #[must_use]
    pub fn contains(&self, point: Point) -> bool {
        match self {
            Self::Wall { .. } | Self::Outline { .. } => false,
            Self::Box {
                center,
                size,
                angle,
            } => {
                let p = (point - *center).turned_back(Point::unit(*angle));
                p.x.abs() <= size.x * 0.5 && p.y.abs() <= size.y * 0.5
            }
            Self::Circle { center, radius } => point.distance(*center) <= *radius,
        }
    }

    /// The defect of this shape, if any: sizes below [`MIN_SIZE_M`], coordinates that are not
    /// finite or exceed `limit_m`.
    pub(crate) fn defect(&self, limit_m: f64) -> Option<String> {
        let sized = |what: &str, value: f64| {
            let sound = (MIN_SIZE_M..=limit_m).contains(&value);
            (!sound)
                .then(|| format!("{what} must be positive and at most {limit_m} m, not {value}"))
        };
        match self {
            Self::Wall { points } => wall_defect(points, limit_m),
            Self::Box {
                center,
                size,
                angle,
            } => point_defect(*center, limit_m)
                .or_else(|| sized("a box's width", size.x))
                .or_else(|| sized("a box's depth", size.y))
                .or_else(|| (!angle.is_finite()).then(|| "a box's angle must be finite".into())),
            Self::Circle { center, radius } => {
                point_defect(*center, limit_m).or_else(|| sized("a circle's radius", *radius))
            }
            Self::Outline { from, to } => wall_defect(&[*from, *to], limit_m),
        }
    }
}

/// The defect of a coordinate pair, if any.
pub(crate) fn point_defect(point: Point, limit_m: f64) -> Option<String> {
    let bad = [point.x, point.y]
        .into_iter()
        .find(|c| c.is_nan() || c.abs() > limit_m)?;
    Some(format!(
        "a coordinate must lie within ±{limit_m} m, not be {bad}"
    ))
}

fn wall_defect(points: &[Point], limit_m: f64) -> Option<String> {
    if points.len() < 2 {
        return Some(format!(
            "a wall needs at least 2 points, not {}",
            points.len()
        ));
    }
    if let Some(defect) = points.iter().find_map(|&p| point_defect(p, limit_m)) {
        return Some(defect);
    }
    let still = points
        .windows(2)
        .position(|pair| pair[0].distance(pair[1]) < MIN_SIZE_M)?;
    Some(format!(
        "points {} and {} of a wall are the same",
        still + 1,
        still + 2
    ))
}

/// The free ends and the bends of a chain; a bend is at least 1°.
fn wall_corners(points: &[Point], mut visit: impl FnMut(Point)) {
    const SIN_ONE_DEGREE: f64 = 0.017_452_406;
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else {
        return;
    };
    let bends = |before: Point, at: Point, after: Point| {
        let (incoming, outgoing) = (at - before, after - at);
        let turn = incoming.cross(outgoing).abs();
        turn > SIN_ONE_DEGREE * incoming.length() * outgoing.length()
            || incoming.dot(outgoing) < 0.0
    };
    for triple in points.windows(3) {
        if bends(triple[0], triple[1], triple[2]) {
            visit(triple[1]);
        }
    }
    if first != last {
        visit(first);
        visit(last);
    } else if bends(points[points.len() - 2], first, points[1]) {
        visit(first);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(shape: &Shape) -> Vec<Point> {
        let mut found = Vec::new();
        shape.for_each_corner(|corner| found.push(corner));
        found
    }

    #[test]
    fn a_straight_joint_is_no_corner_and_a_closed_chain_has_no_ends() {
        let p = Point::new;
        let straight = Shape::Wall {
            points: vec![p(0.0, 0.0), p(1.0, 0.0), p(2.0, 0.0)],
        };
        assert_eq!(corners(&straight), [p(0.0, 0.0), p(2.0, 0.0)]);
        let back = Shape::Wall {
            points: vec![p(0.0, 0.0), p(1.0, 0.0), p(0.5, 0.0)],
        };
        assert_eq!(corners(&back).len(), 3);
        let closed = |start: Point| Shape::Wall {
            points: vec![
                start,
                p(1.0, 0.0),
                p(1.0, 1.0),
                p(0.0, 1.0),
                p(0.0, 0.0),
                start,
            ],
        };
        // The chain starts in the middle of a side, so the joint at the start is straight.
        assert_eq!(corners(&closed(p(0.5, 0.0))).len(), 4);
    }

    #[test]
    fn the_outside_of_a_box_lies_left_of_its_sides() {
        let shape = Shape::Box {
            center: Point::new(1.0, 2.0),
            size: Point::new(0.4, 0.8),
            angle: 0.3,
        };
        let mut sides = 0;
        shape.for_each_segment(|from, to| {
            assert!((to - from).cross(Point::new(1.0, 2.0) - from) < 0.0);
            sides += 1;
        });
        assert_eq!(sides, 4);
        let inside = Point::new(0.19, 0.39).turned(Point::unit(0.3));
        assert!(shape.contains(Point::new(1.0, 2.0) + inside));
        assert!(!shape.contains(Point::new(1.0, 2.0) + inside * 1.1));
    }

    #[test]
    fn shapes_without_extent_are_defects() {
        let p = Point::new;
        let wall = |points: &[Point]| Shape::Wall {
            points: points.to_vec(),
        };
        let circle = |radius| Shape::Circle {
            center: p(0.0, 0.0),
            radius,
        };
        for (shape, words) in [
            (wall(&[p(0.0, 0.0)]), "at least 2 points"),
            (
                wall(&[p(0.0, 0.0), p(1.0, 0.0), p(1.0, 0.0)]),
                "points 2 and 3",
            ),
            (wall(&[p(0.0, 0.0), p(f64::NAN, 0.0)]), "within"),
            (wall(&[p(0.0, 0.0), p(0.0, -1e6)]), "within"),
            (circle(0.0), "radius"),
            (circle(f64::NAN), "radius"),
            (circle(f64::INFINITY), "radius"),
        ] {
            let defect = shape.defect(1e5).unwrap_or_default();
            assert!(defect.contains(words), "{defect:?}");
        }
        assert_eq!(circle(0.1).defect(1e5), None);
    }
}
