//! Occupancy grid: outlines of the occupied cells, and a start position.

/// State of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OccupancyCell {
    Free,
    Occupied,
    Unknown,
}

/// A map of square cells. Cell (0, 0) is at the lower left; cells outside the map are unknown.
#[derive(Debug, Clone)]
pub(crate) struct Occupancy {
    pub width: usize,
    pub height: usize,
    /// Row by row from below.
    pub cells: Vec<OccupancyCell>,
}

/// A grid point: columns from the left, rows from below.
pub(crate) type GridPoint = (usize, usize);

impl Occupancy {
    fn cell(&self, column: usize, row: usize) -> OccupancyCell {
        if column < self.width && row < self.height {
            self.cells[row * self.width + column]
        } else {
            OccupancyCell::Unknown
        }
    }

    /// Whether the cell to the lower left of a grid point is occupied.
    fn occupied_before(&self, column: usize, row: usize) -> bool {
        let (Some(column), Some(row)) = (column.checked_sub(1), row.checked_sub(1)) else {
            return false;
        };
        self.cell(column, row) == OccupancyCell::Occupied
    }

    /// Outlines of the occupied cells as maximal straight segments, each with the free side on its
    /// left. Unknown cells count as free.
    pub fn outlines(&self) -> Vec<(GridPoint, GridPoint)> {
        let mut pieces = Vec::new();
        for row in 0..=self.height {
            let sides = |i: usize| {
                (
                    self.occupied_before(i + 1, row),
                    self.occupied_before(i + 1, row + 1),
                )
            };
            runs(self.width, sides, |from, to, solid_below| {
                let (from, to) = ((from, row), (to, row));
                pieces.push(if solid_below { (from, to) } else { (to, from) });
            });
        }
        for column in 0..=self.width {
            let sides = |i: usize| {
                (
                    self.occupied_before(column, i + 1),
                    self.occupied_before(column + 1, i + 1),
                )
            };
            runs(self.height, sides, |from, to, solid_left| {
                let (from, to) = ((column, from), (column, to));
                pieces.push(if solid_left { (to, from) } else { (from, to) });
            });
        }
        pieces
    }

    /// The start: the free cell nearest to the middle of the free area with at least `clearance`
    /// cells to every occupied cell. Without such a cell, the one with the largest clearance.
    /// `None` if no cell is free.
    pub fn start(&self, clearance: u8) -> Option<GridPoint> {
        let middle = self.middle_of_free()?;
        let clearance = usize::from(clearance);
        let reach = clearance + 1;
        let columns = self.column_distances(reach);
        let mut best: Option<(GridPoint, usize, usize)> = None;
        for row in 0..self.height {
            for column in (0..self.width).filter(|&c| self.cell(c, row) == OccupancyCell::Free) {
                let room = self.squared_room(&columns, column, row, reach);
                let room = room.min(clearance * clearance);
                let away =
                    (2 * column).abs_diff(middle.0).pow(2) + (2 * row).abs_diff(middle.1).pow(2);
                let better = |&(_, best_room, best_away): &(GridPoint, usize, usize)| {
                    room > best_room || (room == best_room && away < best_away)
                };
                if best.as_ref().is_none_or(better) {
                    best = Some(((column, row), room, away));
                }
            }
        }
        best.map(|(cell, _, _)| cell)
    }

    /// Twice the middle of the smallest rectangle around all free cells.
    fn middle_of_free(&self) -> Option<GridPoint> {
        let mut bounds: Option<(usize, usize, usize, usize)> = None;
        for (index, _) in self
            .cells
            .iter()
            .enumerate()
            .filter(|&(_, &cell)| cell == OccupancyCell::Free)
        {
            let (column, row) = (index % self.width, index / self.width);
            let (left, right, low, high) = bounds.unwrap_or((column, column, row, row));
            bounds = Some((
                left.min(column),
                right.max(column),
                low.min(row),
                high.max(row),
            ));
        }
        bounds.map(|(left, right, low, high)| (left + right, low + high))
    }

    /// By cell: distance in rows to the nearest occupied cell of its column, at most `reach`.
    fn column_distances(&self, reach: usize) -> Vec<u16> {
        let reach = u16::try_from(reach).unwrap_or(u16::MAX);
        let mut distances = vec![reach; self.cells.len()];
        for column in 0..self.width {
            let rows = (0..self.height).chain((0..self.height).rev());
            let mut distance = reach;
            for row in rows {
                let index = row * self.width + column;
                distance = match self.cells[index] {
                    OccupancyCell::Occupied => 0,
                    _ => (distance + 1).min(reach),
                };
                distances[index] = distances[index].min(distance);
            }
        }
        distances
    }

    /// Squared distance in cells to the nearest occupied cell, at most `reach²`.
    fn squared_room(&self, columns: &[u16], column: usize, row: usize, reach: usize) -> usize {
        let near = column.saturating_sub(reach)..(column + reach + 1).min(self.width);
        near.map(|c| c.abs_diff(column).pow(2) + usize::from(columns[row * self.width + c]).pow(2))
            .fold(reach * reach, usize::min)
    }
}

/// Calls `emit(from, to, solid_first)` for every maximal run of positions with exactly one solid
/// side.
fn runs(
    count: usize,
    sides: impl Fn(usize) -> (bool, bool),
    mut emit: impl FnMut(usize, usize, bool),
) {
    let mut open: Option<(usize, bool)> = None;
    for i in 0..=count {
        let boundary = if i < count { Some(sides(i)) } else { None };
        let solid_first = boundary.and_then(|(first, second)| (first != second).then_some(first));
        if open.map(|(_, solid)| solid) == solid_first {
            continue;
        }
        if let Some((from, solid)) = open {
            emit(from, i, solid);
        }
        open = solid_first.map(|solid| (i, solid));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(rows: &[&str]) -> Occupancy {
        let cells = rows.iter().rev().flat_map(|row| {
            row.chars().map(|c| match c {
                '#' => OccupancyCell::Occupied,
                '.' => OccupancyCell::Free,
                _ => OccupancyCell::Unknown,
            })
        });
        Occupancy {
            width: rows[0].len(),
            height: rows.len(),
            cells: cells.collect(),
        }
    }

    #[test]
    fn outlines_are_maximal_segments_with_the_free_side_on_the_left() {
        let mut pieces = map(&["....", ".##.", "...."]).outlines();
        pieces.sort_unstable();
        let expected = [
            ((1, 1), (1, 2)),
            ((1, 2), (3, 2)),
            ((3, 1), (1, 1)),
            ((3, 2), (3, 1)),
        ];
        assert_eq!(pieces, expected);
    }

    #[test]
    fn cells_that_touch_at_a_corner_keep_their_own_outlines() {
        let pieces = map(&["#.", ".#"]).outlines();
        assert_eq!(pieces.len(), 8);
        assert!(map(&["?."]).outlines().is_empty());
    }

    #[test]
    fn the_start_is_free_and_near_the_middle() {
        let room = map(&[
            "#########",
            "#.......#",
            "#.......#",
            "#..#....#",
            "#.......#",
            "#.......#",
            "#########",
        ]);
        // The middle is the cell right of the block; a clearance of two cells moves the start away.
        assert_eq!(room.start(1), Some((4, 3)));
        let (column, row) = room.start(2).unwrap();
        assert!(room.cell(column, row) == OccupancyCell::Free && column >= 5);
        // No cell has this clearance: the start is the cell with the largest one.
        assert!(room.start(50).is_some());
        assert_eq!(map(&["##", "?#"]).start(1), None);
    }
}
