//! Outlines along a line: a corridor of one width, and a hall that narrows and widens.

use super::Floor;
use super::site::{any_sign, closed_wall};
use crate::geometry::Point;
use crate::noise::Noise;

/// Steepest direction of a corridor against x, rad: it never meets itself.
const STEEPEST: f64 = 1.4;

/// A lobby of 2 … 3 m and a corridor 0.95 … 1.4 m wide with 4 to 6 legs of 2 … 3 m and bends of
/// 30 … 100°.
pub(super) fn corridor(noise: &mut Noise) -> Floor {
    let half = noise.uniform_in(0.475, 0.7);
    let lobby = Point::new(noise.uniform_in(2.0, 3.0), noise.uniform_in(1.0, 1.5));
    let line = bent_line(noise);
    let right = side(&line, -half);
    let left = side(&line, half);
    let mut corners = vec![Point::new(-lobby.x, -lobby.y), Point::new(0.0, -lobby.y)];
    corners.extend(right);
    corners.extend(left.into_iter().rev());
    corners.extend([Point::new(0.0, lobby.y), Point::new(-lobby.x, lobby.y)]);
    Floor {
        shapes: vec![closed_wall(corners)],
        start: Point::new(-lobby.x / 2.0, 0.0),
    }
}

/// A line from the origin along x that bends.
fn bent_line(noise: &mut Noise) -> Vec<Point> {
    let mut line = vec![Point::default()];
    let (mut at, mut angle) = (Point::default(), 0.0);
    for _ in 0..4 + noise.index(3) {
        at = at + Point::unit(angle) * noise.uniform_in(2.0, 3.0);
        line.push(at);
        angle = loop {
            let next = angle + any_sign(noise) * noise.uniform_in(0.52, 1.75);
            if (-STEEPEST..=STEEPEST).contains(&next) {
                break next;
            }
        };
    }
    line
}

/// The parallel of a line at this distance to its left.
fn side(line: &[Point], distance: f64) -> Vec<Point> {
    let normals: Vec<_> = line.windows(2).map(|leg| normal(leg[0], leg[1])).collect();
    let point = |(number, &at): (usize, &Point)| {
        let before = normals[number.saturating_sub(1)];
        let after = normals[number.min(normals.len() - 1)];
        // Both legs' parallels meet here.
        at + (before + after) * (distance / (1.0 + before.dot(after)))
    };
    line.iter().enumerate().map(point).collect()
}

/// The unit vector to the left of a leg.
fn normal(from: Point, to: Point) -> Point {
    let along = to - from;
    Point::new(-along.y, along.x) * (1.0 / along.length())
}

/// A hall of diagonal walls, narrowed 3 to 5 times from 2.4 … 4 m to 1 … 1.4 m within 1.2 … 2.4 m.
/// Half of them end in a wedge.
pub(super) fn wedges(noise: &mut Noise) -> Floor {
    let (mut lower, mut upper) = (Vec::new(), Vec::new());
    let mut middle = 0.0;
    let mut station = |x: f64, middle: f64, half: f64| {
        lower.push(Point::new(x, middle - half));
        upper.push(Point::new(x, middle + half));
    };
    let mut wide = noise.uniform_in(1.2, 2.0);
    station(-1.6, middle, wide);
    let mut x = 0.0;
    for _ in 0..3 + noise.index(3) {
        station(x, middle, wide);
        middle += noise.uniform_in(-0.4, 0.4);
        x += noise.uniform_in(1.2, 2.4);
        station(x, middle, noise.uniform_in(0.5, 0.7));
        middle += noise.uniform_in(-0.4, 0.4);
        x += noise.uniform_in(1.2, 2.4);
        wide = noise.uniform_in(1.2, 2.0);
    }
    station(x, middle, wide);
    let end = if noise.chance(0.5) { 0.1 } else { wide };
    station(x + noise.uniform_in(1.2, 2.4), middle, end);
    lower.extend(upper.into_iter().rev());
    Floor {
        shapes: vec![closed_wall(lower)],
        start: Point::new(-0.8, 0.0),
    }
}
