//! Worlds that are the same when they are turned.

use super::{Point, Shape, World};
use std::f64::consts::TAU;

/// What is no farther apart is the same place, m.
const SAME_M: f64 = 0.01;
/// The greatest order that is looked for.
const MAX_ORDER: u32 = 12;

/// A segment, or a circle, whose ends are the same; in meters, around the middle of all.
#[derive(Clone, Copy)]
struct Piece {
    ends: [Point; 2],
    radius: f64,
}

impl Piece {
    fn turned(&self, turn: Point) -> Self {
        Self {
            ends: self.ends.map(|end| end.turned(turn)),
            ..*self
        }
    }

    /// Distance from the middle of all: no turn changes it.
    fn distance(&self) -> f64 {
        let [from, to] = self.ends;
        ((from + to) * 0.5).length()
    }

    fn is_same(&self, other: &Self) -> bool {
        let are_near = |one: Point, to: Point| one.distance(to) < SAME_M;
        let [[a, b], [c, d]] = [self.ends, other.ends];
        let ends = are_near(a, c) && are_near(b, d) || are_near(a, d) && are_near(b, c);
        ends && (self.radius - other.radius).abs() < SAME_M
    }
}

impl World {
    /// The order of rotational symmetry of its surfaces as they are drawn, 1 to 12: turned by a
    /// full turn divided by that, the world is the same, to within 1 cm. A robot that does not know
    /// which way it faces cannot tell there where it is.
    #[must_use]
    pub fn symmetry_order(&self) -> u32 {
        let mut pieces = self.pieces();
        pieces.sort_by(|one, other| one.distance().total_cmp(&other.distance()));
        // Those at this distance from the middle.
        let at = |distance: f64| {
            let first = pieces.partition_point(|piece| piece.distance() < distance - SAME_M);
            let rest = pieces.iter().skip(first);
            rest.take_while(move |piece| piece.distance() <= distance + SAME_M)
        };
        let is_order = |order: &u32| {
            let turn = Point::unit(TAU / f64::from(*order));
            pieces.iter().all(|piece| {
                let turned = piece.turned(turn);
                at(piece.distance()).any(|other| turned.is_same(other))
            })
        };
        (2..=MAX_ORDER).rev().find(is_order).unwrap_or(1)
    }

    /// All surfaces, around the middle of their ends: a turn that changes nothing leaves it there.
    fn pieces(&self) -> Vec<Piece> {
        let segments = self.segments().map(|(from, to)| ([from, to], 0.0));
        let circles = self.shapes().iter().filter_map(|shape| match shape {
            Shape::Circle { center, radius } => Some(([*center; 2], *radius)),
            _ => None,
        });
        let all: Vec<_> = segments.chain(circles).collect();
        let ends = || all.iter().flat_map(|(ends, _)| ends);
        let sum = ends().fold(Point::default(), |sum, end| sum + *end);
        let middle = sum * (1.0 / ends().count().max(1) as f64);
        let around = |(ends, radius): &([Point; 2], f64)| Piece {
            ends: ends.map(|end| end - middle),
            radius: *radius,
        };
        all.iter().map(around).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Pose;

    /// A ring of walls with so many corners, with what else stands there.
    fn ring(corners: u32, others: &[Shape]) -> World {
        let corner = |index| Point::unit(0.3 + TAU * f64::from(index) / f64::from(corners)) * 3.0;
        let wall = Shape::Wall {
            points: (0..=corners).map(corner).collect(),
        };
        let shapes = std::iter::once(wall).chain(others.iter().cloned());
        World::new("ring", Pose::default(), shapes.collect()).unwrap()
    }

    fn post(x: f64, y: f64) -> Shape {
        Shape::Circle {
            center: Point::new(x, y),
            radius: 0.1,
        }
    }

    #[test]
    fn regular_rings_are_of_the_order_of_their_corners() {
        for corners in 3..=12 {
            assert_eq!(ring(corners, &[]).symmetry_order(), corners);
        }
        assert_eq!(ring(6, &[post(1.0, 1.0)]).symmetry_order(), 1);
        let two = [post(1.0, 1.0), post(-1.0, -1.0)];
        assert_eq!(ring(6, &two).symmetry_order(), 2);
        let [near, far] = [post(1.0, 1.0), post(-1.0, -1.02)];
        assert_eq!(ring(6, &[near, far]).symmetry_order(), 1);
    }

    #[test]
    fn a_grid_of_posts_is_of_order_four() {
        let at = |index: u32| f64::from(index) - 99.5;
        let posts = (0..200_u32).flat_map(|x| (0..200).map(move |y| post(at(x), at(y))));
        let world = World::new("grid", Pose::default(), posts.collect()).unwrap();
        assert_eq!(world.symmetry_order(), 4);
    }

    /// Halls, and corridors in rings of five, six and eight corners.
    #[test]
    fn one_world_in_seven_of_other_kinds_is_symmetric() {
        let orders = (10_000..10_096).map(|seed| (seed, World::random2(seed).symmetry_order()));
        let symmetric: Vec<_> = orders.filter(|(_, order)| *order > 1).collect();
        let wanted = [
            (10_010, 2),
            (10_017, 8),
            (10_022, 2),
            (10_029, 6),
            (10_034, 2),
            (10_041, 5),
            (10_046, 2),
            (10_058, 2),
            (10_065, 6),
            (10_070, 2),
            (10_077, 8),
            (10_082, 2),
            (10_094, 2),
        ];
        assert_eq!(symmetric, wanted);
        assert!((10_000..10_096).all(|seed| World::random(seed).symmetry_order() == 1));
    }
}
