//! Long halls: with pillars, and with barriers.

use super::Floor;
use super::site::{any_angle, any_sign, wall};
use crate::geometry::Point;
use crate::noise::Noise;
use crate::shapes::Shape;

/// A hall 4.8 … 7 m wide with two rows of 4 to 8 round or square pillars, 0.2 … 0.5 m thick, with
/// centers 1.6 … 2.2 m apart. The robot starts between the rows.
pub(super) fn hall(noise: &mut Noise) -> Floor {
    let count = 4 + noise.index(5);
    let spacing = noise.uniform_in(1.6, 2.2);
    let margin = noise.uniform_in(1.2, 2.0);
    let long = (count - 1) as f64 * spacing / 2.0 + margin;
    let wide = noise.uniform_in(2.4, 3.5);
    let radius = noise.uniform_in(0.1, 0.25);
    let square = noise.chance(0.5).then(|| any_angle(noise));
    let mut shapes = vec![Shape::room(Point::new(long, wide))];
    for number in 0..count {
        let x = number as f64 * spacing + margin - long;
        for y in [-wide / 2.0, wide / 2.0] {
            shapes.push(pillar(Point::new(x, y), radius, square));
        }
    }
    Floor {
        shapes,
        start: Point::new(0.9 - long, 0.0),
    }
}

/// A square pillar at an angle, or a round one.
fn pillar(center: Point, radius: f64, square: Option<f64>) -> Shape {
    match square {
        None => Shape::Circle { center, radius },
        // As wide as the round one along its diagonal.
        Some(angle) => Shape::Box {
            center,
            size: Point::new(radius, radius) * core::f64::consts::SQRT_2,
            angle,
        },
    }
}

/// A hall 2.5 … 4 m wide with 3 to 7 barriers from both sides in turn, 1.6 … 2.2 m apart. Each
/// leaves 0.95 … 1.4 m free, and its tip is up to 0.25 m off the perpendicular.
pub(super) fn slalom(noise: &mut Noise) -> Floor {
    let count = 3 + noise.index(5);
    let spacing = noise.uniform_in(1.6, 2.2);
    let long = (count + 1) as f64 * spacing / 2.0;
    let wide = noise.uniform_in(1.25, 2.0);
    let mut side = any_sign(noise);
    let mut shapes = vec![Shape::room(Point::new(long, wide))];
    for number in 1..=count {
        let x = number as f64 * spacing - long;
        let foot = Point::new(x, wide * side);
        let gap = noise.uniform_in(0.95, 1.4);
        let tip = Point::new(x + noise.uniform_in(-0.25, 0.25), (gap - wide) * side);
        shapes.push(wall([foot, tip]));
        side = -side;
    }
    Floor {
        shapes,
        start: Point::new(0.65 - long, 0.0),
    }
}
