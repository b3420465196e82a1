//! Random free places where a robot may be placed after exploring.

use arena::noise::Noise;
use arena::world::{Point, World};

/// Least distance of the place from the nest, m.
const ELSEWHERE_M: f64 = 1.0;
/// Gap between body and surfaces at the place and on the path to it, of the body's radius.
const GAP: f64 = 0.15 / 0.269;
/// Grid of the path search, m.
const CELL_M: f64 = 0.1;
/// Limit of the search, which bounds time and memory in huge worlds.
const MAX_CELLS: usize = 250_000;

/// A random free place at least 1 m from `nest` that a disc of this radius can reach from it, all
/// in meters. Returns the nest if there is none.
#[must_use]
pub fn elsewhere(world: &World, radius_m: f64, nest: Point, noise: &mut Noise) -> Point {
    let reached = reachable(world, radius_m, nest);
    let far: Vec<_> = reached
        .into_iter()
        .filter(|place| place.distance(nest) >= ELSEWHERE_M)
        .collect();
    far.get(noise.index(far.len())).copied().unwrap_or(nest)
}

/// Cells of a grid that the disc can reach from `nest`, in a fixed order.
fn reachable(world: &World, radius_m: f64, nest: Point) -> Vec<Point> {
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
                && world.clearance(to) >= radius_m * (1.0 + GAP)
                && !world.sweep(place(cell), to, radius_m).touched()
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
    use arena::world::{Pose, Shape};

    #[test]
    fn places_are_free_far_and_repeatable() {
        for seed in 0..30 {
            let world = World::random(seed);
            let nest = world.start().position;
            for radius_m in [0.035, 0.269] {
                let place = || elsewhere(&world, radius_m, nest, &mut Noise::new(seed));
                assert!(place().distance(nest) >= ELSEWHERE_M, "{seed}");
                assert!(world.clearance(place()) >= radius_m && !world.is_inside(place()));
                assert_eq!(place(), place());
            }
        }
    }

    /// Two rooms joined by a way of 0.4 m: the Khepera goes on to the other one.
    #[test]
    fn a_narrow_way_is_open_to_a_small_body_only() {
        let wall = |points: &[(f64, f64)]| Shape::Wall {
            points: points.iter().map(|(x, y)| Point::new(*x, *y)).collect(),
        };
        let hall = [
            (-1.0, -2.0),
            (7.0, -2.0),
            (7.0, 2.0),
            (-1.0, 2.0),
            (-1.0, -2.0),
        ];
        let shapes = vec![
            wall(&hall),
            wall(&[(3.0, -2.0), (3.0, -0.2)]),
            wall(&[(3.0, 0.2), (3.0, 2.0)]),
        ];
        let world = World::new("slit", Pose::default(), shapes).unwrap();
        let reaches_far = |radius_m| {
            let nest = world.start().position;
            let mut places =
                (0..40).map(|seed| elsewhere(&world, radius_m, nest, &mut Noise::new(seed)));
            places.any(|place| place.x > 3.0)
        };
        assert!(reaches_far(0.03));
        assert!(!reaches_far(0.269));
    }
}
