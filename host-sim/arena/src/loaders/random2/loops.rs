//! Corridors that lead around blocks.

use core::f64::consts::{PI, TAU};

use super::Floor;
use super::site::{any_angle, closed_wall, solid};
use crate::geometry::Point;
use crate::noise::Noise;
use crate::shapes::Shape;

/// Loops around rectangular blocks or around a polygon.
pub(super) fn loops(noise: &mut Noise) -> Floor {
    if noise.chance(0.5) {
        ring(noise)
    } else {
        blocks(noise)
    }
}

/// A ring 1.25 … 1.8 m wide around a regular polygon of 4 to 8 sides.
fn ring(noise: &mut Noise) -> Floor {
    let sides = 4 + noise.index(5);
    let inner = noise.uniform_in(1.6, 3.5);
    let width = noise.uniform_in(1.25, 1.8);
    let turn = any_angle(noise);
    // Distance of the sides from the middle.
    let polygon = |apothem: f64| {
        let radius = apothem / libm::cos(PI / sides as f64);
        let corner = |number| TAU * (f64::from(number) + 0.5) / sides as f64 + turn;
        (0..sides as u32).map(move |number| Point::unit(corner(number)) * radius)
    };
    let block: Vec<_> = polygon(inner).collect();
    let mut shapes = vec![closed_wall(polygon(inner + width).collect())];
    shapes.extend(solid(&block));
    Floor {
        shapes,
        start: Point::unit(turn) * (inner + width / 2.0),
    }
}

/// One to three blocks in a row of 2 … 4 m (one alone: 3.8 … 6 m), with corridors of 0.95 … 1.6 m
/// around and between them. The robot starts in the first, which is at least 1.25 m wide.
fn blocks(noise: &mut Noise) -> Floor {
    let count = 1 + noise.index(3);
    let (least, most) = if count == 1 { (3.8, 6.0) } else { (2.0, 4.0) };
    let mut corridor = || noise.uniform_in(0.95, 1.6);
    let (below, above) = (corridor(), corridor());
    let deep = noise.uniform_in(2.0, 4.5);
    let first = noise.uniform_in(1.25, 1.8);
    let mut x = first;
    let mut shapes = Vec::new();
    for _ in 0..count {
        let long = noise.uniform_in(least, most);
        shapes.push(Shape::Box {
            center: Point::new(x + long / 2.0, below + deep / 2.0),
            size: Point::new(long, deep),
            angle: 0.0,
        });
        x += long + noise.uniform_in(0.95, 1.6);
    }
    let high = below + deep + above;
    let corners = [(0.0, 0.0), (x, 0.0), (x, high), (0.0, high)];
    let corners = corners.map(|(x, y)| Point::new(x, y));
    shapes.insert(0, closed_wall(corners.to_vec()));
    Floor {
        shapes,
        start: Point::new(first / 2.0, high / 2.0),
    }
}
