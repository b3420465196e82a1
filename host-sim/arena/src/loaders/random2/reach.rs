//! Flood fill: the area that a disc reaches from the start.

use crate::geometry::Point;
use crate::world::World;

/// Radius of the disc, m: the robot's and a margin.
const DISC_M: f64 = 0.35;
/// Side of a cell, m.
const CELL_M: f64 = 0.1;
/// The area that the disc has to reach, in cells: 8 m².
const ENOUGH_CELLS: usize = 800;

/// Whether a disc of 0.35 m radius covers at least 8 m² on all its ways from `start`, and none of
/// them leads out of the world.
pub(super) fn reaches(world: &World, start: Point) -> bool {
    reached_cells(world, start, DISC_M, ENOUGH_CELLS).is_some_and(|cells| cells >= ENOUGH_CELLS)
}

/// Number of cells that a disc of this radius (m) covers; the search stops at `enough`. `None` if
/// the disc leaves the world.
pub(super) fn reached_cells(
    world: &World,
    start: Point,
    disc: f64,
    enough: usize,
) -> Option<usize> {
    let mut flood = Flood::new(world, disc);
    let from = flood.cell(start)?;
    flood.visit(from);
    while let Some([column, row]) = flood.open.pop() {
        if flood.count >= enough {
            break;
        }
        for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let next = [column + dx, row + dy];
            if flood.is_free(world, next)? {
                flood.visit(next);
            }
        }
    }
    Some(flood.count)
}

/// The cells of a world's bounding box.
struct Flood {
    /// Radius of the disc, m.
    disc: f64,
    low: Point,
    columns: i32,
    rows: i32,
    /// Cells that the disc's center has reached.
    visited: Vec<bool>,
    /// Cells that the disc has covered.
    covered: Vec<bool>,
    /// Number of covered cells.
    count: usize,
    /// Visited cells whose neighbors are not checked yet.
    open: Vec<[i32; 2]>,
}

impl Flood {
    fn new(world: &World, disc: f64) -> Self {
        let (low, high) = world.bounds();
        let cells = |from: f64, to: f64| libm::ceil((to - from) / CELL_M) as i32;
        let (columns, rows) = (cells(low.x, high.x), cells(low.y, high.y));
        let all = (columns * rows) as usize;
        Self {
            disc,
            low,
            columns,
            rows,
            visited: vec![false; all],
            covered: vec![false; all],
            count: 0,
            open: Vec::new(),
        }
    }

    /// The cell at a point inside the bounds.
    fn cell(&self, at: Point) -> Option<[i32; 2]> {
        let along = |at: f64, low: f64| libm::floor((at - low) / CELL_M) as i32;
        let cell = [along(at.x, self.low.x), along(at.y, self.low.y)];
        self.index(cell).map(|_| cell)
    }

    fn index(&self, [column, row]: [i32; 2]) -> Option<usize> {
        let inside = (0..self.columns).contains(&column) && (0..self.rows).contains(&row);
        inside.then_some((row * self.columns + column) as usize)
    }

    /// Whether the disc fits at a cell not visited yet; `None` outside the bounds.
    fn is_free(&self, world: &World, cell: [i32; 2]) -> Option<bool> {
        let index = self.index(cell)?;
        let [x, y] = cell.map(|number| (f64::from(number) + 0.5) * CELL_M);
        let middle = self.low + Point::new(x, y);
        Some(!self.visited[index] && world.clearance(middle) >= self.disc)
    }

    fn visit(&mut self, [column, row]: [i32; 2]) {
        if let Some(index) = self.index([column, row]) {
            self.visited[index] = true;
        }
        self.open.push([column, row]);
        let reach = (self.disc / CELL_M) as i32;
        for (dx, dy) in (-reach..=reach).flat_map(|dx| (-reach..=reach).map(move |dy| (dx, dy))) {
            let apart = f64::from(dx * dx + dy * dy) * CELL_M * CELL_M;
            if apart <= self.disc * self.disc
                && let Some(index) = self.index([column + dx, row + dy])
                && !self.covered[index]
            {
                self.covered[index] = true;
                self.count += 1;
            }
        }
    }
}
