//! The grid of neurons: a rectangle with four direct neighbors each, or a chain with two.

use crate::fixed::Mask;

/// Border of the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Edges {
    /// Neurons at the border have fewer neighbors.
    #[default]
    Open,
    /// Opposite borders are connected (a torus): every neuron has four neighbors.
    Wrapped,
}

/// A rectangular grid. Neuron `k` is in column `k % columns`, row `k / columns`.
///
/// A chain is a grid of one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "(u16, u16, Edges)", into = "(u16, u16, Edges)")
)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Grid {
    /// Columns minus 1. A grid of one neuron is then all zeros, so a static map of it is in `.bss`
    /// and takes no flash.
    more_columns: u16,
    /// Rows minus 1.
    more_rows: u16,
    edges: Edges,
}

/// The grid of [`NEIGHBORS_4X4`].
const GRID_4X4: Grid = Grid::rectangle(4, 4);

/// Direct neighbors of each neuron as bits. The table saves 60 instructions per update on a
/// Cortex-M4.
static NEIGHBORS_4X4: [u16; 16] = {
    let mut masks = [0; 16];
    let mut k = 0;
    while k < 16 {
        let here = 1_u16 << k;
        let left = if k % 4 == 0 { 0 } else { here >> 1 };
        let right = if k % 4 == 3 { 0 } else { here << 1 };
        masks[k] = left | right | here >> 4 | here << 4;
        k += 1;
    }
    masks
};

impl From<(u16, u16, Edges)> for Grid {
    fn from((columns, rows, edges): (u16, u16, Edges)) -> Self {
        Self::rectangle(columns, rows).with_edges(edges)
    }
}

impl From<Grid> for (u16, u16, Edges) {
    fn from(grid: Grid) -> Self {
        let length = |more: u16| more.saturating_add(1);
        (
            length(grid.more_columns),
            length(grid.more_rows),
            grid.edges,
        )
    }
}

impl Grid {
    /// A grid of `columns` × `rows` neurons, at least 1 × 1.
    #[must_use]
    pub const fn rectangle(columns: u16, rows: u16) -> Self {
        Self {
            more_columns: columns.saturating_sub(1),
            more_rows: rows.saturating_sub(1),
            edges: Edges::Open,
        }
    }

    /// A chain of `neurons` with two neighbors each.
    #[must_use]
    pub const fn chain(neurons: u16) -> Self {
        Self::rectangle(neurons, 1)
    }

    /// The same grid with other edges.
    #[must_use]
    pub const fn with_edges(self, edges: Edges) -> Self {
        Self { edges, ..self }
    }

    /// Number of columns.
    #[must_use]
    pub const fn columns(self) -> usize {
        self.more_columns as usize + 1
    }

    /// Number of rows.
    #[must_use]
    pub const fn rows(self) -> usize {
        self.more_rows as usize + 1
    }

    /// Number of neurons.
    #[must_use]
    #[expect(
        clippy::len_without_is_empty,
        reason = "a grid has at least one neuron"
    )]
    pub const fn len(self) -> usize {
        self.columns() * self.rows()
    }

    /// Column and row of neuron `k`.
    #[must_use]
    pub const fn position(self, k: usize) -> (usize, usize) {
        (k % self.columns(), k / self.columns())
    }

    /// Distance of two neurons along the columns and along the rows, in grid steps.
    #[inline]
    #[must_use]
    pub fn offsets(self, a: usize, b: usize) -> (usize, usize) {
        let ((ax, ay), (bx, by)) = (self.position(a), self.position(b));
        (self.column_distance(ax, bx), self.row_distance(ay, by))
    }

    /// Grid steps between two columns.
    #[inline]
    #[must_use]
    pub fn column_distance(self, a: usize, b: usize) -> usize {
        self.axis_distance(a.abs_diff(b), self.columns())
    }

    /// Grid steps between two rows.
    #[inline]
    #[must_use]
    pub fn row_distance(self, a: usize, b: usize) -> usize {
        self.axis_distance(a.abs_diff(b), self.rows())
    }

    #[inline]
    fn axis_distance(self, direct: usize, length: usize) -> usize {
        match self.edges {
            Edges::Open => direct,
            Edges::Wrapped => direct.min(length.saturating_sub(direct)),
        }
    }

    /// Length of the shortest path between two neurons over direct neighbors.
    #[must_use]
    pub fn hops(self, a: usize, b: usize) -> usize {
        let (dx, dy) = self.offsets(a, b);
        dx.saturating_add(dy)
    }

    /// The direct neighbors of neuron `k` in the order left, right, above, below; at most four.
    #[inline]
    pub fn neighbors(self, k: usize) -> impl Iterator<Item = usize> {
        let (x, y) = self.position(k);
        let (columns, rows) = (self.columns(), self.rows());
        let in_row = move |x: usize| y * columns + x;
        let in_column = move |y: usize| y * columns + x;
        let neighbors = if k < self.len() {
            [
                self.before(x, columns).map(in_row),
                self.after(x, columns).map(in_row),
                self.before(y, rows).map(in_column),
                self.after(y, rows).map(in_column),
            ]
        } else {
            [None; 4]
        };
        neighbors.into_iter().flatten()
    }

    /// The position before `position` along an axis.
    const fn before(self, position: usize, length: usize) -> Option<usize> {
        match (position.checked_sub(1), self.edges) {
            // On a wrapped axis of two both neighbors are the same neuron: `after` returns it.
            (_, Edges::Wrapped) if length <= 2 => None,
            (None, Edges::Wrapped) => Some(length - 1),
            (before, _) => before,
        }
    }

    /// The position after `position` along an axis.
    const fn after(self, position: usize, length: usize) -> Option<usize> {
        match self.edges {
            _ if position + 1 < length => Some(position + 1),
            Edges::Wrapped if length > 1 => Some(0),
            _ => None,
        }
    }

    /// The direct neighbors of neuron `k` below 32.
    #[inline]
    pub(crate) fn neighbor_mask(self, k: usize) -> Mask {
        match NEIGHBORS_4X4.get(k) {
            Some(bits) if self == GRID_4X4 => Mask::from_bits(u32::from(*bits)),
            _ => self.any_neighbor_mask(k),
        }
    }

    #[inline(never)]
    fn any_neighbor_mask(self, k: usize) -> Mask {
        self.neighbors(k).fold(Mask::NONE, Mask::with)
    }

    /// Whether two neurons are direct neighbors.
    #[must_use]
    pub fn are_neighbors(self, a: usize, b: usize) -> bool {
        self.hops(a, b) == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn neighbors_of_a_rectangle_and_a_chain() {
        let list = |grid: Grid, k| grid.neighbors(k).collect::<Vec<_>>();
        let square = Grid::rectangle(4, 4);
        assert_eq!(list(square, 0), [1, 4]);
        assert_eq!(list(square, 5), [4, 6, 1, 9]);
        assert_eq!(list(Grid::chain(32), 31), [30]);
        assert_eq!(list(square.with_edges(Edges::Wrapped), 0), [3, 1, 12, 4]);
        assert_eq!(
            list(Grid::rectangle(2, 1).with_edges(Edges::Wrapped), 0),
            [1]
        );
        assert_eq!(list(square, 16), Vec::<usize>::new());
    }

    #[test]
    fn neighbors_are_one_hop_away_and_mutual() {
        for edges in [Edges::Open, Edges::Wrapped] {
            for (columns, rows) in [(4, 4), (32, 1), (5, 3), (2, 2), (1, 1)] {
                let grid = Grid::rectangle(columns, rows).with_edges(edges);
                for a in 0..grid.len() {
                    let direct: Vec<_> = grid.neighbors(a).collect();
                    for b in 0..grid.len() {
                        assert_eq!(
                            direct.contains(&b),
                            grid.are_neighbors(a, b),
                            "{grid:?} {a} {b}"
                        );
                        assert_eq!(grid.hops(a, b), grid.hops(b, a));
                    }
                }
            }
        }
    }

    #[test]
    fn the_neighbor_mask_equals_the_neighbors() {
        for edges in [Edges::Open, Edges::Wrapped] {
            for (columns, rows) in [(4, 4), (16, 1), (32, 1), (1, 32), (5, 3), (2, 2), (1, 1)] {
                let grid = Grid::rectangle(columns, rows).with_edges(edges);
                for k in 0..34 {
                    let neighbors = grid.neighbors(k).collect::<Vec<_>>();
                    let mask = grid.neighbor_mask(k).to_bits();
                    let bits = (0..32).filter(|k| mask & (1 << k) != 0);
                    let mut neighbors = neighbors.clone();
                    neighbors.sort_unstable();
                    assert_eq!(bits.collect::<Vec<_>>(), neighbors, "{grid:?} {k}");
                }
            }
        }
    }

    #[test]
    fn hops_count_grid_steps() {
        let square = Grid::rectangle(4, 4);
        assert_eq!(square.hops(0, 15), 6);
        assert_eq!(square.with_edges(Edges::Wrapped).hops(0, 15), 2);
    }
}
