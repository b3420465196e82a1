//! Lengths of the ways from all places to the nearest source (Dijkstra 1959).

use super::NOWHERE;

/// What is not reached.
const FAR: u16 = u16::MAX;
/// No open way.
const NO_WAY: u8 = u8::MAX;

/// Cost and next step of a place. Six bytes: a robot has hundreds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cell {
    cost_mm: u16,
    /// [`NOWHERE`] where the way ends.
    next: u16,
    /// The open way that a way ends with; [`NO_WAY`] for the goal.
    way: u8,
    is_settled: bool,
}

impl Cell {
    const NEW: Self = Self {
        cost_mm: FAR,
        next: NOWHERE,
        way: NO_WAY,
        is_settled: false,
    };
    /// All zeros: static memory that begins otherwise takes flash.
    const ZERO: Self = Self {
        cost_mm: 0,
        next: 0,
        way: 0,
        is_settled: false,
    };
}

/// A wave that spreads over the places.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Wavefront<const RECORDS: usize> {
    cells: [Cell; RECORDS],
}

impl<const RECORDS: usize> Wavefront<RECORDS> {
    /// A wave that has not [begun](Self::begin).
    pub(super) const NEW: Self = Self {
        cells: [Cell::ZERO; RECORDS],
    };

    /// Forgets the last wave.
    pub(super) fn begin(&mut self) {
        self.cells.fill(Cell::NEW);
    }

    /// From this place it is so far to the goal, or to the end of an open way.
    pub(super) fn source(&mut self, index: u16, cost_mm: u16, way: Option<u8>) {
        if let Some(cell) = self.cells.get_mut(usize::from(index))
            && cost_mm < cell.cost_mm
        {
            *cell = Cell {
                cost_mm,
                way: way.unwrap_or(NO_WAY),
                ..Cell::NEW
            };
        }
    }

    /// The nearest place that the wave has not passed, and its cost: it is passed now.
    pub(super) fn nearest(&mut self) -> Option<(u16, u16)> {
        let ahead = (0_u16..).zip(&mut self.cells);
        let ahead = ahead.filter(|(_, cell)| !cell.is_settled && cell.cost_mm < FAR);
        let (index, cell) = ahead.min_by_key(|(_, cell)| cell.cost_mm)?;
        cell.is_settled = true;
        Some((index, cell.cost_mm))
    }

    /// Whether this would be a shorter way.
    pub(super) fn improves(&self, index: u16, cost_mm: u16) -> bool {
        let cell = self.cells.get(usize::from(index));
        cell.is_some_and(|cell| cost_mm < cell.cost_mm)
    }

    /// From this place the way goes by the next one.
    pub(super) fn reach(&mut self, index: u16, cost_mm: u16, next: u16) {
        if let Some(cell) = self.cells.get_mut(usize::from(index)) {
            (cell.cost_mm, cell.next, cell.way) = (cost_mm, next, NO_WAY);
        }
    }

    /// Length of the way; `None` where there is none.
    pub(super) fn cost_mm(&self, index: u16) -> Option<u16> {
        let cost_mm = self.cells.get(usize::from(index))?.cost_mm;
        (cost_mm < FAR).then_some(cost_mm)
    }

    /// The place after this one.
    pub(super) fn next(&self, index: u16) -> Option<u16> {
        let next = self.cells.get(usize::from(index))?.next;
        (next != NOWHERE).then_some(next)
    }

    /// The open way that a source was.
    pub(super) fn way_of(&self, index: u16) -> Option<u8> {
        let way = self.cells.get(usize::from(index))?.way;
        (way != NO_WAY).then_some(way)
    }

    /// Whether the way ends at this place, and not with an open way.
    pub(super) fn is_end(&self, index: u16) -> bool {
        self.next(index).is_none() && self.way_of(index).is_none()
    }

    /// The last place of the way from here, and the open way that it ends with.
    pub(super) fn end_of_way(&self, index: u16) -> (u16, Option<u8>) {
        let mut last = index;
        // No way is longer than all places.
        for _ in 0..RECORDS {
            match self.next(last) {
                Some(next) => last = next,
                None => break,
            }
        }
        (last, self.way_of(last))
    }
}
