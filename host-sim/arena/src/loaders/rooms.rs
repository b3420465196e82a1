//! Random worlds for the scenes of the behaviors. A robot that keeps its distance can cross all of
//! them.

use crate::noise::Noise;
use crate::world::{Point, Pose, Shape, World};

/// Gap between obstacles that the robot can pass, m.
const PASSAGE_M: f64 = 1.8;

/// A closed chain of walls through these points.
fn walls(points: &[(f64, f64)]) -> Shape {
    let first = points.first().copied();
    let all = points.iter().copied().chain(first);
    Shape::Wall {
        points: all.map(|(x, y)| Point::new(x, y)).collect(),
    }
}

fn rectangle(half: Point) -> Shape {
    walls(&[
        (-half.x, -half.y),
        (half.x, -half.y),
        (half.x, half.y),
        (-half.x, half.y),
    ])
}

/// The world, or a bare room where a start lies inside something (which the generators avoid).
fn world(name: &str, seed: u64, start: Point, shapes: Vec<Shape>) -> World {
    World::new(format!("{name}:{seed}"), Pose::new(start, 0.0), shapes)
        .unwrap_or_else(|_| World::random(seed))
}

/// An empty room with sides of 4 … 8 m.
#[must_use]
pub fn plain(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let half = Point::new(noise.uniform_in(2.0, 4.0), noise.uniform_in(2.0, 4.0));
    world("plain", seed, Point::default(), vec![rectangle(half)])
}

/// 8 m × 8 m with five boxes of 0.5 … 1.2 m: half of them turned and free, half against the walls,
/// 1.8 m apart.
#[must_use]
pub fn boxes(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let mut shapes = vec![rectangle(Point::new(4.0, 4.0))];
    let mut placed: Vec<(Point, f64)> = Vec::new();
    for _ in 0..2_000 {
        let size = Point::new(noise.uniform_in(0.5, 1.2), noise.uniform_in(0.5, 1.2));
        let (center, angle) = box_place(&mut noise, size);
        let radius = size.length() / 2.0;
        let apart =
            |(other, reach): &(Point, f64)| other.distance(center) >= reach + radius + PASSAGE_M;
        if placed.len() < 5 && center.length() >= radius + 1.0 && placed.iter().all(apart) {
            placed.push((center, radius));
            shapes.push(Shape::Box {
                center,
                size,
                angle,
            });
        }
    }
    world("boxes", seed, Point::default(), shapes)
}

/// Center and angle of a box: at a wall, or in the middle and turned.
fn box_place(noise: &mut Noise, size: Point) -> (Point, f64) {
    let (side, along) = (noise.index(8), noise.uniform_in(-2.2, 2.2));
    let (dx, dy) = (4.0 - size.x / 2.0, 4.0 - size.y / 2.0);
    match side {
        0 => (Point::new(dx, along), 0.0),
        1 => (Point::new(-dx, along), 0.0),
        2 => (Point::new(along, dy), 0.0),
        3 => (Point::new(along, -dy), 0.0),
        _ => {
            let middle = Point::new(noise.uniform_in(-1.4, 1.4), along * 1.4 / 2.2);
            (middle, noise.uniform_in(0.0, 1.57))
        }
    }
}

/// A corridor 1.8 … 2.4 m wide with two corners.
#[must_use]
pub fn corridor(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let half = noise.uniform_in(0.9, 1.2);
    let mut leg = || noise.uniform_in(3.0, 5.0);
    let (first, second, third) = (leg(), leg(), leg());
    let side = if noise.chance(0.5) { 1.0 } else { -1.0 };
    let corner = [
        (-2.0, -half),
        (first + half, -half),
        (first + half, second - half),
        (first + third, second - half),
        (first + third, second + half),
        (first - half, second + half),
        (first - half, half),
        (-2.0, half),
    ];
    let outline = walls(&corner.map(|(x, y)| (x, y * side)));
    world("corridor", seed, Point::default(), vec![outline])
}

/// An empty room of 4 m × 4 m; the start anywhere at least 0.6 m from the walls.
#[must_use]
pub fn small(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let mut place = || noise.uniform_in(-1.4, 1.4);
    let start = Point::new(place(), place());
    world("small", seed, start, vec![rectangle(Point::new(2.0, 2.0))])
}

/// 8 m × 8 m with six boxes of 0.3 … 1 m anywhere; the start anywhere at least 0.5 m from
/// everything.
#[must_use]
pub fn six_boxes(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let mut shapes = vec![rectangle(Point::new(4.0, 4.0))];
    for _ in 0..6 {
        let half = Point::new(noise.uniform_in(0.15, 0.5), noise.uniform_in(0.15, 0.5));
        let center = Point::new(
            noise.uniform_in(half.x - 4.0, 4.0 - half.x),
            noise.uniform_in(half.y - 4.0, 4.0 - half.y),
        );
        shapes.push(Shape::Box {
            center,
            size: half * 2.0,
            angle: 0.0,
        });
    }
    // Draws starts until one is free.
    loop {
        let start = Point::new(noise.uniform_in(-3.4, 3.4), noise.uniform_in(-3.4, 3.4));
        let pose = Pose::new(start, 0.0);
        if let Ok(world) = World::new(format!("six-boxes:{seed}"), pose, shapes.clone())
            && world.clearance(start) >= 0.5
        {
            return world;
        }
    }
}

/// 8 m × 8 m with one box or post of 0.3 … 1 m about 2 m from the start.
#[must_use]
pub fn one_obstacle(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let center = Point::new(noise.uniform_in(1.6, 2.0), noise.uniform_in(-1.0, 1.0));
    let size = noise.uniform_in(0.3, 1.0);
    let obstacle = if noise.chance(0.5) {
        Shape::Circle {
            center,
            radius: size / 2.0,
        }
    } else {
        Shape::Box {
            center,
            size: Point::new(size, noise.uniform_in(0.3, 1.0)),
            angle: noise.uniform_in(0.0, 1.57),
        }
    };
    let room = rectangle(Point::new(4.0, 4.0));
    world("one-obstacle", seed, Point::default(), vec![room, obstacle])
}

/// A hall of 8 m × 6 m with a room in one corner, whose exit is 1.5 … 1.9 m wide; the start in the
/// hall.
#[must_use]
pub fn with_exit(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let corner = Point::new(noise.uniform_in(-0.8, 0.2), noise.uniform_in(0.4, 1.0));
    let width = noise.uniform_in(1.5, 1.9);
    let from = noise.uniform_in(-2.4, corner.y - 0.6 - width);
    let wall = |a: Point, b: Point| Shape::Wall { points: vec![a, b] };
    let shapes = vec![
        rectangle(Point::new(4.0, 3.0)),
        wall(Point::new(-4.0, corner.y), corner),
        wall(corner, Point::new(corner.x, from + width)),
        wall(Point::new(corner.x, from), Point::new(corner.x, -3.0)),
    ];
    let start = Point::new(
        noise.uniform_in(corner.x + 1.0, 3.2),
        noise.uniform_in(-2.2, 2.2),
    );
    world("with-exit", seed, start, shapes)
}

/// A place inside the room of any world [`with_exit`].
#[must_use]
pub fn inside(seed: u64) -> Point {
    let mut noise = Noise::new(seed);
    Point::new(noise.uniform_in(-3.0, -1.8), noise.uniform_in(-1.9, -0.7))
}

/// A corridor 1.8 … 2.4 m wide around a block.
#[must_use]
pub fn around_a_block(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let width = noise.uniform_in(1.8, 2.4);
    let half = Point::new(noise.uniform_in(1.0, 2.5), noise.uniform_in(1.0, 2.5));
    let outer = half + Point::new(width, width);
    let start = Point::new(0.0, half.y + width / 2.0);
    let block = Shape::Box {
        center: Point::default(),
        size: half * 2.0,
        angle: 0.0,
    };
    let wall = rectangle(outer);
    world("around-a-block", seed, start, vec![wall, block])
}

/// A room of 9 m × 9 m with a turned block of 1.2 … 2 m in its middle.
#[must_use]
pub fn one_block(seed: u64) -> World {
    let mut noise = Noise::new(seed);
    let mut side = || noise.uniform_in(1.2, 2.0);
    let size = Point::new(side(), side());
    let block = Shape::Box {
        center: Point::default(),
        size,
        angle: noise.uniform_in(0.0, 1.57),
    };
    let start = Point::new(-3.0, noise.uniform_in(-1.0, 1.0));
    let wall = rectangle(Point::new(4.5, 4.5));
    world("one-block", seed, start, vec![wall, block])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_room_comes_from_its_seed_and_has_room_for_the_robot() {
        type Make = fn(u64) -> World;
        let makers: [Make; 9] = [
            plain,
            boxes,
            corridor,
            small,
            six_boxes,
            one_obstacle,
            with_exit,
            around_a_block,
            one_block,
        ];
        for make in makers {
            for seed in 0..50 {
                let world = make(seed);
                assert_eq!(world, make(seed));
                assert!(!world.name().starts_with("random"), "{}", world.name());
                assert!(
                    world.clearance(world.start().position) > 0.45,
                    "{}",
                    world.name()
                );
            }
        }
    }
    #[test]
    fn the_room_with_an_exit_can_be_left() {
        for seed in 0..50 {
            let world = with_exit(seed);
            let inside = inside(seed);
            assert!(world.clearance(inside) > 0.8, "{seed}");
            // There is a free path between the room and the hall.
            let free = (-30..10).any(|y| {
                let y = f64::from(y) / 10.0;
                let [from, to] = [-1.6, 1.0].map(|x| Point::new(x, y));
                !world.sweep(from, to, 0.4).touched()
            });
            assert!(free, "{seed}");
        }
    }
}
