//! Where the robot has been: a look counts for a fault only in a cell that is new.

/// Cells of a quarter of a meter on a torus of 4 m.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct VisitedCells {
    visited: [u16; 16],
    pub(super) cell: (u8, u8),
    /// The robot has been in this cell before.
    pub(super) is_known: bool,
}

impl VisitedCells {
    const CELL_LOG2: u32 = 8;
    /// Half of the cells. Then all are forgotten: the same cell may also lie 4 m away.
    const MAX_VISITED: u32 = 128;

    pub(super) const NEW: Self = Self {
        visited: [0; 16],
        cell: (0, 0),
        is_known: false,
    };

    pub(super) fn enter(&mut self, x_mm: i16, y_mm: i16) {
        let index = |mm: i16| (mm >> Self::CELL_LOG2) as u8 & 15;
        let cell = (index(x_mm), index(y_mm));
        if cell == self.cell {
            return;
        }
        let row = |y: u8| usize::from(y & 15);
        if let Some(bits) = self.visited.get_mut(row(self.cell.1)) {
            *bits |= 1 << self.cell.0;
        }
        let count: u32 = self.visited.iter().map(|row| row.count_ones()).sum();
        if count > Self::MAX_VISITED {
            self.visited = [0; 16];
        }
        let bits = self.visited.get(row(cell.1)).copied().unwrap_or(0);
        (self.cell, self.is_known) = (cell, bits >> cell.0 & 1 != 0);
    }
}
