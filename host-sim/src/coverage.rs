//! The area a robot's body has swept, in cells of 0.25 m.

use crate::world::Point;

/// Side of a cell, metres.
pub const CELL_M: f64 = 0.25;

/// Most cells along one side: a world larger than 2 km is covered with its first 2 km only.
const MOST_CELLS: usize = 8_192;

/// Cells whose middle the body has passed over.
#[derive(Debug, Clone)]
pub struct Coverage {
    origin: Point,
    columns: usize,
    rows: usize,
    words: Vec<u64>,
    radius_m: f64,
    /// Where the last way ended.
    last: Option<Point>,
}

impl Coverage {
    /// Nothing covered yet, for a body of `radius_m` within `bounds` (least and greatest corner).
    #[must_use]
    pub fn new(bounds: (Point, Point), radius_m: f64) -> Self {
        let cells = |least: f64, greatest: f64| {
            (((greatest - least) / CELL_M) as usize)
                .saturating_add(1)
                .min(MOST_CELLS)
        };
        let columns = cells(bounds.0.x, bounds.1.x);
        let rows = cells(bounds.0.y, bounds.1.y);
        Self {
            origin: bounds.0,
            columns,
            rows,
            words: vec![0; (columns * rows).div_ceil(64)],
            radius_m,
            last: None,
        }
    }

    /// The body has moved straight from `from` to `to`.
    pub fn sweep(&mut self, from: Point, to: Point) {
        if from == to && self.last == Some(to) {
            // It stands where it stood.
            return;
        }
        self.last = Some(to);
        let cell = |value: f64, most: usize| {
            ((value / CELL_M).max(0.0) as usize).min(most.saturating_sub(1))
        };
        let reach = self.radius_m;
        let (low_x, high_x) = (
            from.x.min(to.x) - reach - self.origin.x,
            from.x.max(to.x) + reach - self.origin.x,
        );
        let (low_y, high_y) = (
            from.y.min(to.y) - reach - self.origin.y,
            from.y.max(to.y) + reach - self.origin.y,
        );
        let way = to - from;
        let squared = way.dot(way);
        let scale = if squared > 0.0 { 1.0 / squared } else { 0.0 };
        let columns = cell(low_x, self.columns)..=cell(high_x, self.columns);
        for row in cell(low_y, self.rows)..=cell(high_y, self.rows) {
            let start = row * self.columns;
            if self.is_marked(start + columns.start()..=start + columns.end()) {
                continue;
            }
            for column in columns.clone() {
                let middle = Point::new(
                    self.origin.x + (column as f64 + 0.5) * CELL_M,
                    self.origin.y + (row as f64 + 0.5) * CELL_M,
                );
                let offset = middle - from;
                let along = (offset.dot(way) * scale).clamp(0.0, 1.0);
                let gap = offset - way * along;
                if gap.dot(gap) <= reach * reach {
                    self.mark(start + column);
                }
            }
        }
    }

    /// Whether all these cells are covered already; runs beyond two words count as not.
    fn is_marked(&self, cells: std::ops::RangeInclusive<usize>) -> bool {
        let (first, last) = (*cells.start(), *cells.end());
        let word = |index: usize| u128::from(self.words.get(index).copied().unwrap_or(0));
        let pair = word(first / 64) | word(first / 64 + 1) << 64;
        let count = last - first + 1;
        count < 64 && {
            let run = (1_u128 << count) - 1;
            pair >> (first % 64) & run == run
        }
    }

    fn mark(&mut self, index: usize) {
        if let Some(word) = self.words.get_mut(index / 64) {
            *word |= 1 << (index % 64);
        }
    }

    /// Area of the covered cells, square metres.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        let cells: u32 = self.words.iter().map(|word| word.count_ones()).sum();
        f64::from(cells) * CELL_M * CELL_M
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_run_covers_its_strip() {
        let mut coverage = Coverage::new((Point::new(0.0, 0.0), Point::new(10.0, 10.0)), 0.269);
        coverage.sweep(Point::new(1.0, 5.0), Point::new(9.0, 5.0));
        // Two rows of cell middles lie within 0.269 m of y = 5; the strip is 8 m long, and its round
        // ends add a middle at each end.
        assert_eq!(coverage.area_m2(), 2.0 * (32.0 + 2.0) * 0.0625);
        let once = coverage.area_m2();
        coverage.sweep(Point::new(9.0, 5.0), Point::new(1.0, 5.0));
        assert_eq!(coverage.area_m2(), once);
    }

    #[test]
    fn where_it_stands_is_covered_once_it_gets_there() {
        let mut coverage = Coverage::new((Point::new(0.0, 0.0), Point::new(10.0, 10.0)), 0.269);
        let mut stand = |x: f64| {
            let place = Point::new(x, 5.0);
            coverage.sweep(place, place);
            coverage.area_m2()
        };
        let once = stand(1.0);
        assert!(once > 0.0 && stand(1.0) == once && stand(3.0) == 2.0 * once);
    }

    #[test]
    fn outside_the_bounds_nothing_breaks() {
        let mut coverage = Coverage::new((Point::new(0.0, 0.0), Point::new(1.0, 1.0)), 0.269);
        coverage.sweep(Point::new(-5.0, -5.0), Point::new(-4.0, 50.0));
        assert_eq!(coverage.area_m2(), 0.0);
    }
}
