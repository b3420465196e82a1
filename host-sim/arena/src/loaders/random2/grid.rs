//! Cells on a grid with openings between them: rooms with doors, and mazes.

use super::Floor;
use super::site::{closed_wall, wall};
use crate::geometry::Point;
use crate::noise::Noise;
use crate::shapes::Shape;

/// 2 or 3 by 2 or 3 rooms of 3 … 4.5 m with doors of 0.9 … 1.2 m; a box stands in two rooms of
/// five.
pub(super) fn rooms(noise: &mut Noise) -> Floor {
    let [columns, rows] = [(); 2].map(|()| 2 + noise.index(2));
    let mut lines = |count: usize| lines(count, || noise.uniform_in(3.0, 4.5));
    let (xs, ys) = (lines(columns), lines(rows));
    let grid = Grid::carve(noise, [columns, rows], 0.3);
    let home = [noise.index(columns), noise.index(rows)];
    let mut door = |from: f64, to: f64| {
        let wide = noise.uniform_in(0.9, 1.2);
        let low = noise.uniform_in(from + 0.4, to - 0.4 - wide);
        (low, low + wide)
    };
    let mut shapes = grid.shapes(&xs, &ys, &mut door);
    for [column, row] in cells([columns, rows]) {
        if [column, row] != home && noise.chance(0.4) {
            shapes.push(Shape::Box {
                center: middle(&xs, &ys, [column, row]),
                size: Point::new(noise.uniform_in(0.4, 0.8), noise.uniform_in(0.4, 0.8)),
                angle: noise.uniform_in(0.0, core::f64::consts::FRAC_PI_2),
            });
        }
    }
    Floor {
        shapes,
        start: middle(&xs, &ys, home),
    }
}

/// 6 to 8 by 5 to 7 squares of 1.25 … 1.6 m; one side in ten of those left is open too, so that
/// there are ways around.
pub(super) fn maze(noise: &mut Noise) -> Floor {
    let size = [6 + noise.index(3), 5 + noise.index(3)];
    let side = noise.uniform_in(1.25, 1.6);
    let [xs, ys] = size.map(|count| lines(count, || side));
    let grid = Grid::carve(noise, size, 0.1);
    let shapes = grid.shapes(&xs, &ys, &mut |from, to| (from, to));
    let home = size.map(|count| noise.index(count));
    Floor {
        shapes,
        start: middle(&xs, &ys, home),
    }
}

/// The lines that bound `count` cells, from 0.
fn lines(count: usize, mut width: impl FnMut() -> f64) -> Vec<f64> {
    let mut lines = vec![0.0];
    let mut at = 0.0;
    for _ in 0..count {
        at += width();
        lines.push(at);
    }
    lines
}

fn cells([columns, rows]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]))
}

fn middle(xs: &[f64], ys: &[f64], [column, row]: [usize; 2]) -> Point {
    let between = |lines: &[f64], at: usize| (lines[at] + lines[at + 1]) / 2.0;
    Point::new(between(xs, column), between(ys, row))
}

/// Which sides of the cells are open.
struct Grid {
    size: [usize; 2],
    /// Per cell, row by row: its right and its upper side.
    open: Vec<[bool; 2]>,
}

impl Grid {
    /// Connects all cells by a random walk that turns back from dead ends, and opens a share of the
    /// other sides.
    fn carve(noise: &mut Noise, size: [usize; 2], extra: f64) -> Self {
        let mut grid = Self {
            size,
            open: vec![[false; 2]; size[0] * size[1]],
        };
        let first = size.map(|count| noise.index(count));
        let mut visited = vec![false; grid.open.len()];
        visited[grid.index(first)] = true;
        let mut path = vec![first];
        while let Some(&here) = path.last() {
            let neighbors = grid.neighbors(here).into_iter().flatten();
            let new: Vec<_> = neighbors.filter(|&n| !visited[grid.index(n)]).collect();
            if new.is_empty() {
                path.pop();
                continue;
            }
            let next = new[noise.index(new.len())];
            visited[grid.index(next)] = true;
            grid.connect(here, next);
            path.push(next);
        }
        for side in grid.open.iter_mut().flatten() {
            *side |= noise.chance(extra);
        }
        grid
    }

    fn index(&self, [column, row]: [usize; 2]) -> usize {
        row * self.size[0] + column
    }

    fn neighbors(&self, [column, row]: [usize; 2]) -> [Option<[usize; 2]>; 4] {
        let [columns, rows] = self.size;
        [
            (column + 1 < columns).then(|| [column + 1, row]),
            (row + 1 < rows).then(|| [column, row + 1]),
            (column > 0).then(|| [column - 1, row]),
            (row > 0).then(|| [column, row - 1]),
        ]
    }

    /// Opens the side between two neighbors.
    fn connect(&mut self, a: [usize; 2], b: [usize; 2]) {
        let lower = self.index([a[0].min(b[0]), a[1].min(b[1])]);
        self.open[lower][usize::from(a[0] == b[0])] = true;
    }

    /// The outer wall and the inner ones; `opening` gives the free part of an open side.
    fn shapes(
        &self,
        xs: &[f64],
        ys: &[f64],
        opening: &mut impl FnMut(f64, f64) -> (f64, f64),
    ) -> Vec<Shape> {
        let [columns, rows] = self.size;
        let (right, top) = (xs[columns], ys[rows]);
        let corners = [(0.0, 0.0), (right, 0.0), (right, top), (0.0, top)];
        let mut shapes = vec![closed_wall(corners.map(|(x, y)| Point::new(x, y)).to_vec())];
        for column in 0..columns - 1 {
            let is_open = |row| self.open[self.index([column, row])][0];
            let at = |y| Point::new(xs[column + 1], y);
            shapes.extend(pieces(ys, is_open, opening).map(|(from, to)| wall([from, to].map(at))));
        }
        for row in 0..rows - 1 {
            let is_open = |column| self.open[self.index([column, row])][1];
            let at = |x| Point::new(x, ys[row + 1]);
            shapes.extend(pieces(xs, is_open, opening).map(|(from, to)| wall([from, to].map(at))));
        }
        shapes
    }
}

/// The closed pieces of a line across the cells; sides next to each other form one piece.
fn pieces(
    lines: &[f64],
    is_open: impl Fn(usize) -> bool,
    opening: &mut impl FnMut(f64, f64) -> (f64, f64),
) -> impl Iterator<Item = (f64, f64)> {
    let mut pieces = Vec::new();
    let mut from = lines[0];
    for (number, side) in lines.windows(2).enumerate() {
        if is_open(number) {
            let (low, high) = opening(side[0], side[1]);
            pieces.push((from, low));
            from = high;
        }
    }
    pieces.push((from, lines[lines.len() - 1]));
    pieces.into_iter().filter(|(from, to)| to > from)
}
