//! Random free places where a robot may be placed after exploring.

use arena::noise::Noise;
use arena::robot::COLLISION_RADIUS_M;
use arena::world::{Point, World};

/// Least distance of the place from the nest, m.
const ELSEWHERE_M: f64 = 1.0;
/// Gap between body and surfaces at the place and on the path to it, m.
const GAP_M: f64 = 0.15;
/// Grid of the path search, m.
const CELL_M: f64 = 0.1;
/// Limit of the search, which bounds time and memory in huge worlds.
const MAX_CELLS: usize = 250_000;

/// A random free place at least 1 m from `nest` that can be reached from it. Returns the nest if
/// there is none.
#[must_use]
pub fn elsewhere(world: &World, nest: Point, noise: &mut Noise) -> Point {
    let reached = reachable(world, nest);
    let far: Vec<_> = reached
        .into_iter()
        .filter(|place| place.distance(nest) >= ELSEWHERE_M)
        .collect();
    far.get(noise.index(far.len())).copied().unwrap_or(nest)
}

/// Cells of a grid that a disc of the robot's size can reach from `nest`, in a fixed order.
fn reachable(world: &World, nest: Point) -> Vec<Point> {
    use std::collections::{HashSet, VecDeque};
    let place =
        |(column, row): (i32, i32)| nest + Point::new(f64::from(column), f64::from(row)) * CELL_M;
    let mut seen = HashSet::from([(0, 0)]);
    let mut queue = VecDeque::from([(0, 0)]);
    let mut reached = Vec::new();
    let (low, high) = world.bounds();
    while let Some(cell) = queue.pop_front() {
        reached.push(place(cell));
        if seen.len() >= MAX_CELLS {
            continue;
        }
        for (dx, dy) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
            let next = (cell.0 + dx, cell.1 + dy);
            let to = place(next);
            let inside = to.x > low.x && to.x < high.x && to.y > low.y && to.y < high.y;
            if inside
                && world.clearance(to) >= COLLISION_RADIUS_M + GAP_M
                && !world.sweep(place(cell), to, COLLISION_RADIUS_M).touched()
                && seen.insert(next)
            {
                queue.push_back(next);
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_free_far_and_repeatable() {
        for seed in 0..30 {
            let world = World::random(seed);
            let nest = world.start().position;
            let place = elsewhere(&world, nest, &mut Noise::new(seed));
            assert!(place.distance(nest) >= ELSEWHERE_M, "{seed}");
            assert!(world.clearance(place) >= COLLISION_RADIUS_M && !world.is_inside(place));
            assert_eq!(place, elsewhere(&world, nest, &mut Noise::new(seed)));
        }
    }
}
