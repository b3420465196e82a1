//! Furnished rooms: what stands on the floor are thin legs, and cabinets at the walls.

use super::Floor;
use super::site::{Site, any_angle, any_sign, random_site};
use crate::geometry::Point;
use crate::noise::Noise;
use crate::shapes::Shape;

/// 2 to 4 tables with up to four chairs each, 2 to 5 single chairs, 1 to 3 cabinets.
pub(super) fn furniture(noise: &mut Noise) -> Floor {
    let mut site = random_site(noise, (3.8, 5.2), 0.9);
    for _ in 0..1 + noise.index(3) {
        cabinet(noise, &mut site);
    }
    for _ in 0..2 + noise.index(3) {
        table(noise, &mut site);
    }
    for _ in 0..2 + noise.index(4) {
        if let Some(center) = site.place(noise, 0.32) {
            let turn = Point::unit(any_angle(noise));
            site.add(chair(center, turn));
        }
    }
    site.floor()
}

/// A box of 0.8 … 1.6 m × 0.35 … 0.6 m with its back at the upper or lower wall.
fn cabinet(noise: &mut Noise, site: &mut Site) {
    let size = Point::new(noise.uniform_in(0.8, 1.6), noise.uniform_in(0.35, 0.6));
    let half = site.half();
    let x = noise.uniform_in(size.x / 2.0 - half.x, half.x - size.x / 2.0);
    let center = Point::new(x, (half.y - size.y / 2.0) * any_sign(noise));
    if site.take(center, size.length() / 2.0) {
        site.add([Shape::Box {
            center,
            size,
            angle: 0.0,
        }]);
    }
}

/// Four legs of 1 … 1.8 m × 0.7 … 0.9 m, and chairs on both long sides.
fn table(noise: &mut Noise, site: &mut Site) {
    let half = Point::new(noise.uniform_in(0.5, 0.9), noise.uniform_in(0.35, 0.45));
    let leg = noise.uniform_in(0.02, 0.035);
    // A chair's middle from the table's edge: pushed under it, or drawn back.
    let chairs: Vec<_> = (0..noise.index(5))
        .map(|number| {
            let x = if number < 2 { -0.5 } else { 0.5 } * half.x;
            let y = half.y + noise.uniform_in(0.05, 0.4);
            Point::new(x, if number % 2 == 0 { y } else { -y })
        })
        .collect();
    let reach = chairs.iter().map(|chair| chair.length() + 0.32);
    let radius = reach.fold(half.length() + leg, f64::max);
    let Some(center) = site.place(noise, radius) else {
        return;
    };
    let turn = Point::unit(any_angle(noise));
    site.add(legs(center, turn, half, leg));
    for at in chairs {
        let askew = Point::unit(noise.uniform_in(-0.3, 0.3));
        site.add(chair(center + at.turned(turn), turn.turned(askew)));
    }
}

/// The legs of a chair of 0.4 m × 0.4 m.
fn chair(center: Point, turn: Point) -> [Shape; 4] {
    legs(center, turn, Point::new(0.2, 0.2), 0.015)
}

/// Four round legs at the corners of a rectangle.
fn legs(center: Point, turn: Point, half: Point, radius: f64) -> [Shape; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Shape::Circle {
        center: center + Point::new(x * half.x, y * half.y).turned(turn),
        radius,
    })
}
