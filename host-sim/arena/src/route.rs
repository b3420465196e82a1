//! The shortest path of a disc through a known world: the reference for a drive.

use crate::world::{Point, World};
use files::error::BadInput;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Side of a cell of the search grid, m.
const CELL_M: f64 = 0.05;
/// Margin of the search grid around all shapes, m.
const RIM_M: f64 = 1.0;
/// Largest number of cells.
const MAX_CELLS: usize = 4_000_000;
/// Cost of a step to a direct and to a diagonal neighbor.
const COSTS: [u32; 2] = [1_000, 1_414];

/// The path of a disc of `radius` m from `start` to `goal`; `None` if there is none.
///
/// A* over the free cells of 5 cm with eight neighbors, then shortened to the shortest chain of
/// free straight lines between its cells. The result may pass an obstacle on the wrong side where
/// both sides differ by a few centimeters.
///
/// # Errors
/// When the world is too large for the search.
pub fn route(
    world: &World,
    start: Point,
    goal: Point,
    radius: f64,
) -> Result<Option<Vec<Point>>, BadInput> {
    let Some(grid) = SearchGrid::around(world, start, goal) else {
        return Err(BadInput::new(format!(
            "world {}: more than {MAX_CELLS} cells to search for a path",
            world.name()
        )));
    };
    let free: Vec<bool> = (0..grid.cells())
        .map(|cell| world.clearance(grid.place(cell)) >= radius)
        .collect();
    let Some(cells) = search(&grid, &free, grid.cell(start), grid.cell(goal)) else {
        return Ok(None);
    };
    let inner = cells.into_iter().map(|cell| grid.place(cell));
    let path: Vec<_> = [start].into_iter().chain(inner).chain([goal]).collect();
    Ok(Some(shorten(world, &path, radius)))
}

/// Length of a path, m.
#[must_use]
pub fn length(path: &[Point]) -> f64 {
    path.windows(2).map(|ends| ends[0].distance(ends[1])).sum()
}

struct SearchGrid {
    low: Point,
    columns: usize,
    rows: usize,
}

impl SearchGrid {
    fn around(world: &World, start: Point, goal: Point) -> Option<Self> {
        let (low, high) = world.bounds();
        let least = |a: f64, b: f64, c: f64| a.min(b).min(c) - RIM_M;
        let low = Point::new(least(low.x, start.x, goal.x), least(low.y, start.y, goal.y));
        let most = |a: f64, b: f64, c: f64| a.max(b).max(c) + RIM_M;
        let high = Point::new(most(high.x, start.x, goal.x), most(high.y, start.y, goal.y));
        let count = |length: f64| libm::ceil(length / CELL_M) as usize;
        let (columns, rows) = (count(high.x - low.x), count(high.y - low.y));
        (columns.checked_mul(rows)? <= MAX_CELLS).then_some(Self { low, columns, rows })
    }

    fn cells(&self) -> usize {
        self.columns * self.rows
    }

    fn place(&self, cell: usize) -> Point {
        let middle = |index: usize| (index as f64 + 0.5) * CELL_M;
        self.low + Point::new(middle(cell % self.columns), middle(cell / self.columns))
    }

    fn cell(&self, place: Point) -> usize {
        let away = place - self.low;
        let index = |length: f64, count: usize| ((length / CELL_M) as usize).min(count - 1);
        index(away.y, self.rows) * self.columns + index(away.x, self.columns)
    }

    /// The neighbors of a cell, each with the cost of the step.
    fn around_cell(&self, cell: usize) -> impl Iterator<Item = (usize, u32)> {
        let (column, row) = (
            (cell % self.columns) as isize,
            (cell / self.columns) as isize,
        );
        let (columns, rows) = (self.columns as isize, self.rows as isize);
        let steps = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        steps.filter_map(move |(dx, dy): (isize, isize)| {
            let (x, y) = (column + dx, row + dy);
            let inside = (dx, dy) != (0, 0) && (0..columns).contains(&x) && (0..rows).contains(&y);
            let cost = COSTS[usize::from(dx != 0 && dy != 0)];
            inside.then_some(((y * columns + x) as usize, cost))
        })
    }

    /// Lower bound of the cost to `goal`: the cost without obstacles.
    fn left(&self, cell: usize, goal: usize) -> u32 {
        let across = (cell % self.columns).abs_diff(goal % self.columns);
        let up = (cell / self.columns).abs_diff(goal / self.columns);
        let (short, long) = (across.min(up) as u32, across.max(up) as u32);
        short * COSTS[1] + (long - short) * COSTS[0]
    }
}

fn search(grid: &SearchGrid, free: &[bool], start: usize, goal: usize) -> Option<Vec<usize>> {
    let mut costs = vec![u32::MAX; free.len()];
    let mut from = vec![usize::MAX; free.len()];
    let mut open = BinaryHeap::from([Reverse((grid.left(start, goal), 0, start))]);
    costs[start] = 0;
    while let Some(Reverse((_, cost, cell))) = open.pop() {
        if cell == goal {
            let back = |cell: &usize| Some(from[*cell]).filter(|from| *from != usize::MAX);
            let mut path: Vec<_> = std::iter::successors(Some(goal), back).collect();
            path.reverse();
            return Some(path);
        }
        if cost > costs[cell] {
            continue;
        }
        for (next, step) in grid.around_cell(cell).filter(|(next, _)| free[*next]) {
            let reached = cost + step;
            if reached < costs[next] {
                (costs[next], from[next]) = (reached, cell);
                open.push(Reverse((reached + grid.left(next, goal), reached, next)));
            }
        }
    }
    None
}

/// The shortest chain of free straight lines between points of a path, from first to last.
fn shorten(world: &World, path: &[Point], radius: f64) -> Vec<Point> {
    let mut best = vec![(0.0, 0); path.len()];
    for (to, place) in path.iter().enumerate().skip(1) {
        // The previous point is always visible: the search came from there.
        let mut found = (best[to - 1].0 + path[to - 1].distance(*place), to - 1);
        for from in (0..to - 1).rev() {
            let length = best[from].0 + path[from].distance(*place);
            if length <= found.0 && !world.sweep(path[from], *place, radius).touched() {
                found = (length, from);
            }
        }
        best[to] = found;
    }
    let back = |&at: &usize| (at > 0).then(|| best[at].1);
    let chain = std::iter::successors(Some(path.len() - 1), back);
    let mut corners: Vec<_> = chain.map(|at| path[at]).collect();
    corners.reverse();
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Pose, Shape};

    fn world(shapes: Vec<Shape>) -> World {
        World::new("test", Pose::default(), shapes).unwrap()
    }

    fn wall(points: &[(f64, f64)]) -> Shape {
        let points = points.iter().map(|&(x, y)| Point::new(x, y)).collect();
        Shape::Wall { points }
    }

    #[test]
    fn a_free_way_is_straight_and_one_around_a_wall_goes_by_its_end() {
        let far = Shape::Circle {
            center: Point::new(0.0, 9.0),
            radius: 0.1,
        };
        let goal = Point::new(4.0, 0.0);
        let path = route(&world(vec![far.clone()]), Point::default(), goal, 0.25)
            .unwrap()
            .unwrap();
        assert_eq!(path, [Point::default(), goal]);
        // Calculated by hand: two tangents to the circle of 0.25 m around the wall's end at (2, 1),
        // and the arc between them.
        let blocked = world(vec![far, wall(&[(2.0, -5.0), (2.0, 1.0)])]);
        let path = route(&blocked, Point::default(), goal, 0.25)
            .unwrap()
            .unwrap();
        let tangent: f64 = (5.0_f64 - 0.0625).sqrt();
        let turn = libm::atan2(1.0, 2.0) + libm::asin(0.25 / 5.0_f64.sqrt());
        let exact = 2.0 * tangent + 0.25 * 2.0 * turn;
        assert!(
            (exact - 0.01..exact + 0.08).contains(&length(&path)),
            "{} {exact}",
            length(&path)
        );
    }

    #[test]
    fn a_gap_is_passed_by_what_fits_only() {
        let walls = vec![
            wall(&[(1.0, -9.0), (1.0, -0.3)]),
            wall(&[
                (1.0, 0.3),
                (1.0, 9.0),
                (-9.0, 9.0),
                (-9.0, -9.0),
                (1.0, -9.0),
            ]),
        ];
        let world = world(walls);
        let path = |radius| route(&world, Point::default(), Point::new(3.0, 0.0), radius).unwrap();
        assert!((length(&path(0.25).unwrap()) - 3.0).abs() < 0.01);
        assert_eq!(path(0.35), None);
    }
}
