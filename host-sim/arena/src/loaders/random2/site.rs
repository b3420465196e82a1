//! A closed room in which things are placed apart from each other, and parts of all kinds.

use core::f64::consts::TAU;

use super::Floor;
use crate::geometry::Point;
use crate::noise::Noise;
use crate::shapes::Shape;

/// Draws per thing before it is left out.
const MAX_DRAWS: usize = 60;
/// Free radius around the start, m.
const START_FREE_M: f64 = 0.75;

/// A room around the origin with the things placed so far.
pub(super) struct Site {
    half: Point,
    start: Point,
    /// Gap between things, and between things and the wall, m.
    gap: f64,
    shapes: Vec<Shape>,
    /// Circles around the things placed.
    taken: Vec<(Point, f64)>,
}

impl Site {
    pub(super) fn new(half: Point, start: Point, gap: f64) -> Self {
        Self {
            half,
            start,
            gap,
            shapes: vec![Shape::room(half)],
            taken: Vec::new(),
        }
    }

    pub(super) fn half(&self) -> Point {
        self.half
    }

    /// A free place for a thing of this radius, which is then taken; `None` if no draw was free.
    pub(super) fn place(&mut self, noise: &mut Noise, radius: f64) -> Option<Point> {
        let [x, y] = [self.half.x, self.half.y].map(|half| (half - radius - self.gap).max(0.0));
        for _ in 0..MAX_DRAWS {
            let center = Point::new(noise.uniform_in(-x, x), noise.uniform_in(-y, y));
            if self.take(center, radius) {
                return Some(center);
            }
        }
        None
    }

    /// Takes a circle if it is free.
    pub(super) fn take(&mut self, center: Point, radius: f64) -> bool {
        let apart =
            |(other, reach): &(Point, f64)| other.distance(center) >= reach + radius + self.gap;
        let is_free =
            self.start.distance(center) >= radius + START_FREE_M && self.taken.iter().all(apart);
        if is_free {
            self.taken.push((center, radius));
        }
        is_free
    }

    pub(super) fn add(&mut self, shapes: impl IntoIterator<Item = Shape>) {
        self.shapes.extend(shapes);
    }

    pub(super) fn floor(self) -> Floor {
        Floor {
            shapes: self.shapes,
            start: self.start,
        }
    }
}

/// A room of random size whose start is at least 1 m from the wall.
pub(super) fn random_site(noise: &mut Noise, half: (f64, f64), gap: f64) -> Site {
    let mut side = || noise.uniform_in(half.0, half.1);
    let half = Point::new(side(), side());
    let mut along = |half: f64| noise.uniform_in(1.0 - half, half - 1.0);
    let start = Point::new(along(half.x), along(half.y));
    Site::new(half, start, gap)
}

/// An angle of a full turn, rad.
pub(super) fn any_angle(noise: &mut Noise) -> f64 {
    noise.uniform_in(0.0, TAU)
}

/// −1 or 1.
pub(super) fn any_sign(noise: &mut Noise) -> f64 {
    if noise.chance(0.5) { 1.0 } else { -1.0 }
}

pub(super) fn wall(points: impl IntoIterator<Item = Point>) -> Shape {
    Shape::Wall {
        points: points.into_iter().collect(),
    }
}

/// A wall that ends where it begins.
pub(super) fn closed_wall(mut points: Vec<Point>) -> Shape {
    points.extend(points.first().copied());
    Shape::Wall { points }
}

/// The outline of a solid whose corners run counter-clockwise.
pub(super) fn solid(corners: &[Point]) -> impl Iterator<Item = Shape> + '_ {
    let next = corners.iter().cycle().skip(1);
    // The free side is on the left.
    let sides = corners.iter().zip(next);
    sides.map(|(&to, &from)| Shape::Outline { from, to })
}
