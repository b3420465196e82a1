//! Things placed apart from each other in a room: posts, polygons, traps, clutter.

use core::f64::consts::{PI, TAU};

use super::Floor;
use super::site::{Site, any_angle, random_site, solid, wall};
use crate::geometry::Point;
use crate::noise::Noise;
use crate::shapes::Shape;

/// 8 to 20 posts with radii of 0.04 … 0.9 m, small ones more often, 0.9 … 1.2 m apart.
pub(super) fn posts(noise: &mut Noise) -> Floor {
    let gap = noise.uniform_in(0.9, 1.2);
    let mut site = random_site(noise, (4.2, 6.0), gap);
    for _ in 0..8 + noise.index(13) {
        let share = noise.uniform();
        let radius = 0.04 + 0.86 * share * share;
        if let Some(center) = site.place(noise, radius) {
            site.add([Shape::Circle { center, radius }]);
        }
    }
    site.floor()
}

/// 6 to 12 polygons with radii of 0.35 … 1.1 m, 0.9 … 1.2 m apart, half of them concave.
pub(super) fn polygons(noise: &mut Noise) -> Floor {
    let gap = noise.uniform_in(0.9, 1.2);
    let mut site = random_site(noise, (4.5, 6.5), gap);
    for _ in 0..6 + noise.index(7) {
        let radius = noise.uniform_in(0.35, 1.1);
        let Some(center) = site.place(noise, radius) else {
            continue;
        };
        let corners = match noise.index(4) {
            0 => star(noise, radius),
            1 => hook(noise, radius),
            _ => convex(noise, radius),
        };
        let turn = Point::unit(any_angle(noise));
        site.add(solid(&moved(&corners, center, turn)));
    }
    site.floor()
}

/// Up to 9 thin walls in the shape of a U, 1.1 … 1.9 m wide and 0.9 … 1.9 m deep, 0.9 m apart. The
/// first one stands 1.8 … 2.6 m before the start and opens toward it.
pub(super) fn traps(noise: &mut Noise) -> Floor {
    let half = Point::new(noise.uniform_in(5.0, 6.5), noise.uniform_in(4.0, 5.5));
    let start = Point::new(1.2 - half.x, noise.uniform_in(-0.8, 0.8));
    let mut site = Site::new(half, start, 0.9);
    for number in 0..5 + noise.index(5) {
        let arms = Point::new(noise.uniform_in(0.9, 1.9), noise.uniform_in(1.1, 1.9)) * 0.5;
        let radius = arms.length();
        let (center, angle) = if number == 0 {
            let ahead = Point::new(noise.uniform_in(1.8, 2.6), noise.uniform_in(-0.2, 0.2));
            let center = start + ahead + Point::new(arms.x, 0.0);
            let is_free = site.take(center, radius);
            (is_free.then_some(center), noise.uniform_in(-0.2, 0.2) + PI)
        } else {
            (site.place(noise, radius), any_angle(noise))
        };
        if let Some(center) = center {
            let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
            let corners = corners.map(|(x, y)| Point::new(x * arms.x, y * arms.y));
            site.add([wall(moved(&corners, center, Point::unit(angle)))]);
        }
    }
    site.floor()
}

/// 30 to 50 posts, boxes, polygons and short walls of 0.06 … 0.3 m radius, 0.5 … 0.9 m apart.
pub(super) fn clutter(noise: &mut Noise) -> Floor {
    let gap = noise.uniform_in(0.5, 0.9);
    let mut site = random_site(noise, (3.2, 4.5), gap);
    for _ in 0..30 + noise.index(21) {
        let radius = noise.uniform_in(0.06, 0.3);
        let Some(center) = site.place(noise, radius) else {
            continue;
        };
        let turn = Point::unit(any_angle(noise));
        let (from, to) = (center - turn * radius, center + turn * radius);
        match noise.index(4) {
            0 => site.add([Shape::Circle { center, radius }]),
            1 => site.add([wall([from, to])]),
            2 => site.add(solid(&moved(&rectangle(noise, radius), center, turn))),
            _ => site.add(solid(&moved(&convex(noise, radius), center, turn))),
        }
    }
    site.floor()
}

/// Corners around the origin, turned and moved to a place.
fn moved(corners: &[Point], center: Point, turn: Point) -> Vec<Point> {
    let corner = |corner: &Point| center + corner.turned(turn);
    corners.iter().map(corner).collect()
}

/// 3 to 7 corners on an ellipse.
fn convex(noise: &mut Noise, radius: f64) -> Vec<Point> {
    let count = 3 + noise.index(5);
    let flat = noise.uniform_in(0.4, 1.0);
    let corner = |number: usize| {
        let share = (number as f64 + noise.uniform_in(0.0, 0.6)) / count as f64;
        let at = Point::unit(TAU * share) * radius;
        Point::new(at.x, at.y * flat)
    };
    (0..count).map(corner).collect()
}

/// 3 to 5 points with notches between them.
fn star(noise: &mut Noise, radius: f64) -> Vec<Point> {
    let points = 3 + noise.index(3);
    let notch = noise.uniform_in(0.3, 0.5);
    let corner = |number: usize| {
        let length = if number.is_multiple_of(2) { 1.0 } else { notch };
        Point::unit(PI * number as f64 / points as f64) * (radius * length)
    };
    (0..2 * points).map(corner).collect()
}

/// An L with arms of 0.25 … 0.5 of its length.
fn hook(noise: &mut Noise, radius: f64) -> Vec<Point> {
    let thick = noise.uniform_in(0.5, 1.0);
    let corners = [
        (-1.0, -1.0),
        (1.0, -1.0),
        (1.0, thick - 1.0),
        (thick - 1.0, thick - 1.0),
        (thick - 1.0, 1.0),
        (-1.0, 1.0),
    ];
    let half = radius * core::f64::consts::FRAC_1_SQRT_2;
    let corners = corners.map(|(x, y)| Point::new(x * half, y * half));
    corners.to_vec()
}

/// A rectangle with its corners on a circle.
fn rectangle(noise: &mut Noise, radius: f64) -> Vec<Point> {
    let Point { x, y } = Point::unit(noise.uniform_in(0.3, 1.2)) * radius;
    [(-x, -y), (x, -y), (x, y), (-x, y)]
        .map(|(x, y)| Point::new(x, y))
        .to_vec()
}
