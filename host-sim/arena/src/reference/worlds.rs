//! Random test worlds of all kinds, for comparisons with the reference model.

use crate::geometry::{Point, Pose};
use crate::loaders::occupancy::{Occupancy, OccupancyCell};
use crate::noise::Noise;
use crate::shapes::Shape;
use crate::world::World;

/// As [`test_world`]; every fifth world has a movable post at its first position.
pub(crate) fn test_world_with_post(seed: u64) -> (World, Vec<Point>) {
    let (world, positions) = test_world(seed);
    let world = if seed.is_multiple_of(5) {
        world.with_post(positions[0], 0.269)
    } else {
        world
    };
    (world, positions)
}

/// A world, and positions in and near it, some of them on lines and corners.
///
/// By seed: maps of cells (many collinear segments, many shared ends), a cluttered room, a row of
/// rooms, a field of posts, or many small boxes.
pub(crate) fn test_world(seed: u64) -> (World, Vec<Point>) {
    let mut noise = Noise::new(seed);
    let mut shapes = Vec::new();
    let side = match seed % 6 {
        0 => cells(&mut noise, &mut shapes),
        1 => rooms(&mut noise, &mut shapes, 1),
        2 => rooms(&mut noise, &mut shapes, 6),
        3 => posts(&mut noise, &mut shapes),
        4 => small_boxes(&mut noise, &mut shapes, 0.0),
        _ => small_boxes(&mut noise, &mut shapes, 0.5),
    };
    let world = World::unchecked("test".into(), Pose::default(), shapes);
    let random_position =
        |noise: &mut Noise| Point::new(noise.uniform_in(-4.5, side), noise.uniform_in(-4.5, 4.5));
    let positions = (0..12).map(|i| {
        let Point { x, y } = random_position(&mut noise);
        match i % 3 {
            0 => Point::new(libm::rint(x * 4.0) / 4.0, y),
            1 => Point::new(libm::rint(x * 4.0) / 4.0, libm::rint(y * 4.0) / 4.0),
            _ => Point::new(x, y),
        }
    });
    let positions = positions.collect();
    (world, positions)
}

fn cells(noise: &mut Noise, shapes: &mut Vec<Shape>) -> f64 {
    let cells = (0..32 * 32).map(|_| {
        if noise.chance(0.12) {
            OccupancyCell::Occupied
        } else {
            OccupancyCell::Free
        }
    });
    let map = Occupancy {
        width: 32,
        height: 32,
        cells: cells.collect(),
    };
    let at =
        |(column, row): (usize, usize)| Point::new(column as f64 - 16.0, row as f64 - 16.0) * 0.25;
    shapes.extend(map.outlines().into_iter().map(|(from, to)| Shape::Outline {
        from: at(from),
        to: at(to),
    }));
    4.0
}

fn rooms(noise: &mut Noise, shapes: &mut Vec<Shape>, count: u64) -> f64 {
    for room in 0..count {
        let offset = Point::new(8.0 * room as f64, 0.0);
        for shape in World::random(noise.next_u64() % 1_000).shapes() {
            shapes.push(match shape {
                Shape::Box { center, size, .. } => Shape::Box {
                    center: *center + offset,
                    size: *size,
                    angle: if noise.chance(0.3) {
                        noise.uniform()
                    } else {
                        0.0
                    },
                },
                Shape::Wall { points } => Shape::Wall {
                    points: points.iter().map(|&point| point + offset).collect(),
                },
                other => other.clone(),
            });
        }
        shapes.push(Shape::Circle {
            center: offset + Point::new(noise.uniform_in(-3.0, 3.0), noise.uniform_in(-3.0, 3.0)),
            radius: noise.uniform_in(0.01, 1.0),
        });
    }
    8.0 * count as f64 - 4.0
}

fn posts(noise: &mut Noise, shapes: &mut Vec<Shape>) -> f64 {
    for _ in 0..150 {
        let (x, y) = (noise.uniform_in(-5.0, 15.0), noise.uniform_in(-5.0, 5.0));
        shapes.push(Shape::Circle {
            center: Point::new(libm::rint(x / 0.15) * 0.15, libm::rint(y / 0.15) * 0.15),
            radius: 0.075,
        });
    }
    15.0
}

/// A room with many small boxes, which may overlap. A share of them is rotated; a tenth of that
/// share has a circle next to it.
fn small_boxes(noise: &mut Noise, shapes: &mut Vec<Shape>, share: f64) -> f64 {
    shapes.extend(World::random(1).shapes().iter().take(1).cloned());
    for _ in 0..400 {
        let mut coordinate = || noise.uniform_in(-4.0, 4.0);
        let center = Point::new(coordinate(), coordinate());
        let mut size = || noise.uniform_in(0.02, 0.15);
        let size = Point::new(size(), size());
        let angle = if noise.chance(share) {
            noise.uniform()
        } else {
            0.0
        };
        shapes.push(Shape::Box {
            center,
            size,
            angle,
        });
        if noise.chance(share / 10.0) {
            shapes.push(Shape::Circle {
                center: center + size,
                radius: 0.05,
            });
        }
    }
    4.0
}
