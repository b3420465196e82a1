//! The area a robot's body has swept, in cells of 0.25 m, or smaller ones for a small body.

use std::ops::RangeInclusive;

use arena::robot::COLLISION_RADIUS_M;
use arena::world::Point;

/// Greatest side of a cell, for a body of the Nomad's radius, meters.
pub const CELL_M: f64 = 0.25;

/// Cells along one side. A world larger than 2 km is covered in its first 2 km only.
const MAX_CELLS: usize = 8_192;

/// Search range for uncovered cells beyond the body, m.
const LOOK_AHEAD_M: f64 = 0.12;

/// Covers rounding errors and is far below anything visible, m.
const SLACK_M: f64 = 1e-6;

/// Cells whose center the body has passed over.
#[derive(Debug, Clone)]
pub struct Coverage {
    origin: Point,
    columns: usize,
    rows: usize,
    /// Side of a cell, m: no larger than the body, or its centers would be missed.
    cell_m: f64,
    words: Vec<u64>,
    radius_m: f64,
    /// Center and radius, m, of a disc in which the body reaches no uncovered cell. A negative
    /// radius means that nothing is known.
    clear: (Point, f64),
}

impl Coverage {
    /// Nothing is covered yet. `bounds` are the least and the greatest corner.
    #[must_use]
    pub fn new(bounds: (Point, Point), radius_m: f64) -> Self {
        let cell_m = (CELL_M * (radius_m / COLLISION_RADIUS_M)).min(CELL_M);
        let cells = |least: f64, greatest: f64| {
            (((greatest - least) / cell_m) as usize)
                .saturating_add(1)
                .min(MAX_CELLS)
        };
        let columns = cells(bounds.0.x, bounds.1.x);
        let rows = cells(bounds.0.y, bounds.1.y);
        Self {
            origin: bounds.0,
            columns,
            rows,
            cell_m,
            words: vec![0; (columns * rows).div_ceil(64)],
            radius_m,
            clear: (bounds.0, f64::NEG_INFINITY),
        }
    }

    /// Covers the cells along a straight path.
    #[inline]
    pub fn sweep(&mut self, from: Point, to: Point) {
        if !(self.is_surely_covered(from) && self.is_surely_covered(to)) {
            self.cover(from, to);
            self.clear = (to, self.distance_to_uncovered(to));
        }
    }

    #[inline]
    fn is_surely_covered(&self, place: Point) -> bool {
        let (center, room) = self.clear;
        let apart = place - center;
        room >= 0.0 && apart.dot(apart) <= room * room
    }

    fn cover(&mut self, from: Point, to: Point) {
        let (columns, rows) = self.around(from, to, self.radius_m);
        let way = to - from;
        let squared = way.dot(way);
        let scale = if squared > 0.0 { 1.0 / squared } else { 0.0 };
        for row in rows {
            for column in self.uncovered(row, &columns) {
                let offset = self.center(column, row) - from;
                let along = (offset.dot(way) * scale).clamp(0.0, 1.0);
                let gap = offset - way * along;
                if gap.dot(gap) <= self.radius_m * self.radius_m {
                    self.mark(row * self.columns + column);
                }
            }
        }
    }

    /// Lower bound of the distance from `place` to where the body reaches an uncovered cell, m.
    fn distance_to_uncovered(&self, place: Point) -> f64 {
        let far = self.radius_m + LOOK_AHEAD_M;
        let (columns, rows) = self.around(place, place, far);
        let mut nearest = far * far;
        for row in rows {
            for column in self.uncovered(row, &columns) {
                let offset = self.center(column, row) - place;
                nearest = nearest.min(offset.dot(offset));
            }
        }
        nearest.sqrt() - self.radius_m - SLACK_M
    }

    /// Columns and rows of the cells within `reach` m of a path.
    fn around(
        &self,
        from: Point,
        to: Point,
        reach: f64,
    ) -> (RangeInclusive<usize>, RangeInclusive<usize>) {
        let cell = |value: f64, most: usize| {
            ((value / self.cell_m).max(0.0) as usize).min(most.saturating_sub(1))
        };
        let (low, high) = (
            Point::new(from.x.min(to.x), from.y.min(to.y)) - self.origin,
            Point::new(from.x.max(to.x), from.y.max(to.y)) - self.origin,
        );
        (
            cell(low.x - reach, self.columns)..=cell(high.x + reach, self.columns),
            cell(low.y - reach, self.rows)..=cell(high.y + reach, self.rows),
        )
    }

    fn center(&self, column: usize, row: usize) -> Point {
        Point::new(
            self.origin.x + (column as f64 + 0.5) * self.cell_m,
            self.origin.y + (row as f64 + 0.5) * self.cell_m,
        )
    }

    /// Columns of a row whose cells are not covered. Beyond 64 columns it also returns covered
    /// ones.
    fn uncovered(
        &self,
        row: usize,
        columns: &RangeInclusive<usize>,
    ) -> impl Iterator<Item = usize> + use<> {
        let begin = *columns.start();
        let first = row * self.columns + begin;
        let count = columns.end() - begin + 1;
        let word = |index: usize| self.words.get(index).copied().unwrap_or(0);
        let (index, shift) = (first / 64, first % 64);
        // Two shifts, because a shift by 64 bits is not allowed.
        let covered = word(index) >> shift | word(index + 1) << 1 << (63 - shift);
        let most = count.min(64);
        let mut left = !covered & (u64::MAX >> (64 - most));
        let near = std::iter::from_fn(move || {
            let lane = (left != 0).then(|| left.trailing_zeros() as usize);
            left &= left.wrapping_sub(1);
            lane
        });
        near.chain(most..count).map(move |lane| begin + lane)
    }

    fn mark(&mut self, index: usize) {
        if let Some(word) = self.words.get_mut(index / 64) {
            *word |= 1 << (index % 64);
        }
    }

    /// Area of the covered cells, square meters.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        let cells: u32 = self.words.iter().map(|word| word.count_ones()).sum();
        f64::from(cells) * self.cell_m * self.cell_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arena::noise::Noise;

    /// 8 m long and 0.06 m wide.
    #[test]
    fn a_small_body_covers_its_strip_as_well() {
        let mut coverage = Coverage::new((Point::new(0.0, 0.0), Point::new(10.0, 10.0)), 0.03);
        coverage.sweep(Point::new(1.0, 5.0), Point::new(9.0, 5.0));
        let area_m2 = coverage.area_m2();
        assert!((0.4..0.56).contains(&area_m2), "{area_m2}");
    }

    #[test]
    fn a_straight_run_covers_its_strip() {
        let mut coverage = Coverage::new((Point::new(0.0, 0.0), Point::new(10.0, 10.0)), 0.269);
        coverage.sweep(Point::new(1.0, 5.0), Point::new(9.0, 5.0));
        // Two rows of cell centers lie within 0.269 m of y = 5. The strip is 8 m long, and its
        // round ends add one center at each end.
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

    /// Moves at random in bounds that are soon covered, and a little beyond them.
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
            known +=
                u32::from(coverage.is_surely_covered(place) && coverage.is_surely_covered(next));
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
