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
    known: Known,
}

/// A rectangle: ways within it sweep covered cells only.
#[derive(Debug, Clone, Copy)]
struct Known {
    least: Point,
    greatest: Point,
}

impl Known {
    const NOTHING: Self = Self {
        least: Point::new(f64::INFINITY, f64::INFINITY),
        greatest: Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    fn contains(&self, place: Point) -> bool {
        (self.least.x <= place.x && place.x <= self.greatest.x)
            && (self.least.y <= place.y && place.y <= self.greatest.y)
    }
}

/// Columns and rows of cells, first and last.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cells {
    columns: (usize, usize),
    rows: (usize, usize),
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
            known: Known::NOTHING,
        }
    }

    /// The body has moved straight from `from` to `to`.
    #[inline]
    pub fn sweep(&mut self, from: Point, to: Point) {
        let is_known = self.known.contains(from) && self.known.contains(to);
        let stands = from == to && self.last == Some(to);
        if !is_known && !stands {
            self.last = Some(to);
            self.cover(from, to);
        }
    }

    fn cover(&mut self, from: Point, to: Point) {
        let cells = self.around(from, to);
        let Cells { columns, rows } = cells;
        let mut is_covered = true;
        for row in rows.0..=rows.1 {
            let start = row * self.columns;
            if !self.is_marked(start + columns.0..=start + columns.1) {
                is_covered = false;
                self.cover_row(row, columns, from, to);
            }
        }
        if is_covered {
            self.known = self.within(cells);
        }
    }

    /// The cells that the body may touch on a way.
    fn around(&self, from: Point, to: Point) -> Cells {
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
        Cells {
            columns: (cell(low_x, self.columns), cell(high_x, self.columns)),
            rows: (cell(low_y, self.rows), cell(high_y, self.rows)),
        }
    }

    /// The places from which the body touches none but these cells; nothing where that is not sure.
    fn within(&self, cells: Cells) -> Known {
        // More than the roundings of coordinates.
        const INSET_M: f64 = 1e-6;
        let inset = self.radius_m + INSET_M;
        let side = |index: usize, origin: f64| origin + index as f64 * CELL_M;
        let ((left, right), (low, high)) = (cells.columns, cells.rows);
        let known = Known {
            least: Point::new(
                side(left, self.origin.x) + inset,
                side(low, self.origin.y) + inset,
            ),
            greatest: Point::new(
                side(right + 1, self.origin.x) - inset,
                side(high + 1, self.origin.y) - inset,
            ),
        };
        // What holds at the corners holds between them: no step of the reckoning ever falls where a coordinate rises.
        let is_sure = self.around(known.least, known.greatest) == cells;
        if is_sure { known } else { Known::NOTHING }
    }

    fn cover_row(&mut self, row: usize, columns: (usize, usize), from: Point, to: Point) {
        let start = row * self.columns;
        let reach = self.radius_m;
        let way = to - from;
        let squared = way.dot(way);
        let scale = if squared > 0.0 { 1.0 / squared } else { 0.0 };
        for column in columns.0..=columns.1 {
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
    use crate::noise::Noise;

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

    /// To and fro in bounds that are soon covered, and beyond them.
    #[test]
    fn where_all_is_covered_nothing_is_missed() {
        let bounds = (Point::new(-0.9, 3.3), Point::new(0.9, 4.9));
        let mut coverage = Coverage::new(bounds, 0.269);
        let mut plain = coverage.clone();
        let mut noise = Noise::new(7);
        let (mut place, mut known) = (Point::new(0.0, 4.0), 0);
        for _ in 0..20_000 {
            let mut step = || noise.uniform_in(-0.05, 0.05);
            let x = (place.x + step()).clamp(-1.0, 1.0);
            let next = Point::new(x, (place.y + step()).clamp(3.2, 5.0));
            known += u32::from(coverage.known.contains(place) && coverage.known.contains(next));
            coverage.sweep(place, next);
            plain.cover(place, next);
            assert_eq!(coverage.words, plain.words, "{place:?} {next:?}");
            place = next;
        }
        assert!(known > 5_000 && coverage.area_m2() > 2.0, "{known}");
    }

    #[test]
    fn outside_the_bounds_nothing_breaks() {
        let mut coverage = Coverage::new((Point::new(0.0, 0.0), Point::new(1.0, 1.0)), 0.269);
        coverage.sweep(Point::new(-5.0, -5.0), Point::new(-4.0, 50.0));
        assert_eq!(coverage.area_m2(), 0.0);
    }
}
