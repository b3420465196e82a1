//! Bounding-box tree: limits a query to the items near a position.
//!
//! Items are sorted along a space-filling curve (Morton 1966) and divided into blocks of [`LANES`].
//! Each block has a bounding box, [`LANES`] boxes have one around them, and so on. A search skips
//! blocks that cannot change its result.

use crate::geometry::{Point, max, min};

/// Margin for rounding, m.
pub(crate) const SLACK_M: f64 = 1e-6;

/// Items per block, and boxes per row of the tree.
pub(crate) const LANES: usize = 8;

/// Boxes around [`LANES`] blocks or rows of boxes, one array per side, m. An unused box is
/// infinitely far away.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Boxes {
    low_x: [f64; LANES],
    low_y: [f64; LANES],
    high_x: [f64; LANES],
    high_y: [f64; LANES],
}

impl Boxes {
    const EMPTY: Self = Self {
        low_x: [f64::INFINITY; LANES],
        low_y: [f64::INFINITY; LANES],
        high_x: [f64::INFINITY; LANES],
        high_y: [f64::INFINITY; LANES],
    };

    /// Whether each box is within `reach` m of a position, plus [`SLACK_M`].
    #[inline]
    pub fn near(&self, place: Point, reach: f64) -> [bool; LANES] {
        let most = (reach + SLACK_M) * (reach + SLACK_M);
        self.distances_squared(place).map(|squared| squared <= most)
    }

    /// Squared distance of each box from a position, m².
    #[inline]
    fn distances_squared(&self, place: Point) -> [f64; LANES] {
        let mut squared = [0.0; LANES];
        for (i, squared) in squared.iter_mut().enumerate() {
            let dx = max(max(self.low_x[i] - place.x, place.x - self.high_x[i]), 0.0);
            let dy = max(max(self.low_y[i] - place.y, place.y - self.high_y[i]), 0.0);
            *squared = dx * dx + dy * dy;
        }
        squared
    }

    /// Whether a ray from `origin` along the unit vector `direction` hits each box within `reach`
    /// m, plus [`SLACK_M`].
    #[inline]
    pub fn met_by_ray(&self, origin: Point, direction: Point, reach: f64) -> [bool; LANES] {
        let mut met = [false; LANES];
        for (i, met) in met.iter_mut().enumerate() {
            let (middle, half) = self.middle_and_half(i);
            let offset = middle - origin;
            let along = offset.dot(direction);
            let across = direction.cross(offset);
            let (dx, dy) = (direction.x.abs(), direction.y.abs());
            let deep = half.x * dx + half.y * dy + SLACK_M;
            let wide = half.x * dy + half.y * dx + SLACK_M;
            *met = (across.abs() <= wide) & (along + deep >= 0.0) & (along - deep <= reach);
        }
        met
    }

    #[inline(always)]
    fn middle_and_half(&self, i: usize) -> (Point, Point) {
        let low = Point::new(self.low_x[i], self.low_y[i]);
        let high = Point::new(self.high_x[i], self.high_y[i]);
        ((low + high) * 0.5, (high - low) * 0.5)
    }

    fn set(&mut self, lane: usize, around: Bounds) {
        self.low_x[lane] = around.low.x;
        self.low_y[lane] = around.low.y;
        self.high_x[lane] = around.high.x;
        self.high_y[lane] = around.high.y;
    }
}

/// A bounding box, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    low: Point,
    high: Point,
}

impl Bounds {
    const NOTHING: Self = Self {
        low: Point::new(f64::INFINITY, f64::INFINITY),
        high: Point::new(f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The bounding box of two points.
    pub fn of(a: Point, b: Point) -> Self {
        Self {
            low: Point::new(min(a.x, b.x), min(a.y, b.y)),
            high: Point::new(max(a.x, b.x), max(a.y, b.y)),
        }
    }

    /// The bounding box of a circle.
    pub fn around(center: Point, radius: f64) -> Self {
        let half = Point::new(radius, radius);
        Self {
            low: center - half,
            high: center + half,
        }
    }

    /// The bounding box of several boxes.
    fn all(parts: impl Iterator<Item = Self>) -> Self {
        parts.fold(Self::NOTHING, |all, part| Self {
            low: Point::new(min(all.low.x, part.low.x), min(all.low.y, part.low.y)),
            high: Point::new(max(all.high.x, part.high.x), max(all.high.y, part.high.y)),
        })
    }

    fn middle(&self) -> Point {
        (self.low + self.high) * 0.5
    }
}

/// Sorts items along the Morton curve, so that neighbors are near each other. The sort is stable.
pub(super) fn sort<T>(things: &mut [T], bounds: impl Fn(&T) -> Bounds) {
    let all = Bounds::all(things.iter().map(&bounds));
    let size = all.high - all.low;
    let cell = |at: f64, low: f64, size: f64| {
        // From 0 to 65 535. The cast saturates, and gives 0 for a world without extent (NaN).
        u64::from(((at - low) / size * 65_535.0) as u16)
    };
    things.sort_by_cached_key(|thing| {
        let middle = bounds(thing).middle();
        let column = cell(middle.x, all.low.x, size.x);
        let row = cell(middle.y, all.low.y, size.y);
        (0..16).fold(0, |key, bit| {
            key | (column >> bit & 1) << (2 * bit) | (row >> bit & 1) << (2 * bit + 1)
        })
    });
}

/// A query that runs through a tree.
pub(crate) trait TreeSearch {
    /// Which of these boxes may change the result.
    fn wants(&self, boxes: &Boxes) -> [bool; LANES];

    /// Tests the items of a block.
    fn look(&mut self, block: usize);
}

/// The boxes by level, from those around blocks to the root.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Tree {
    /// Box j of row i of a level contains row `LANES * i + j` of the level below; on the lowest
    /// level, that block.
    levels: Vec<Vec<Boxes>>,
}

impl Tree {
    /// A tree over items in blocks of [`LANES`].
    pub fn over<T>(things: &[T], bounds: impl Fn(&T) -> Bounds) -> Self {
        let blocks = things.chunks(LANES);
        let mut below: Vec<_> = blocks
            .map(|block| Bounds::all(block.iter().map(&bounds)))
            .collect();
        let mut levels = Vec::new();
        while !below.is_empty() {
            let rows = below.chunks(LANES);
            let mut level = vec![Boxes::EMPTY; rows.len()];
            for (row, parts) in level.iter_mut().zip(rows.clone()) {
                for (lane, part) in parts.iter().enumerate() {
                    row.set(lane, *part);
                }
            }
            levels.push(level);
            if rows.len() == 1 {
                break;
            }
            below = rows
                .map(|parts| Bounds::all(parts.iter().copied()))
                .collect();
        }
        Self { levels }
    }

    /// Calls `look` for every block that the search wants, in the order of the list.
    pub fn search(&self, search: &mut impl TreeSearch) {
        if let Some(top) = self.levels.len().checked_sub(1) {
            self.descend(top, 0, search);
        }
    }

    fn descend(&self, level: usize, row: usize, search: &mut impl TreeSearch) {
        let Some(boxes) = self.levels.get(level).and_then(|level| level.get(row)) else {
            return;
        };
        let wanted = search.wants(boxes);
        for (lane, wanted) in wanted.into_iter().enumerate() {
            if wanted && level == 0 {
                search.look(LANES * row + lane);
            } else if wanted {
                self.descend(level - 1, LANES * row + lane, search);
            }
        }
    }

    /// A block near a position, by descending into the nearest box: a first guess, not always the
    /// nearest block.
    fn guess(&self, place: Point) -> Option<usize> {
        let mut row = 0;
        for level in self.levels.iter().rev() {
            let distances = level.get(row)?.distances_squared(place);
            let nearest =
                (0..LANES).reduce(|a, b| if distances[b] < distances[a] { b } else { a })?;
            row = LANES * row + nearest;
        }
        (!self.levels.is_empty()).then_some(row)
    }
}

/// Tests every block that may be within `reach` m of `place`.
pub(super) struct NearSearch<F> {
    pub place: Point,
    pub reach: f64,
    pub look: F,
}

impl<F: FnMut(usize)> TreeSearch for NearSearch<F> {
    fn wants(&self, boxes: &Boxes) -> [bool; LANES] {
        boxes.near(self.place, self.reach)
    }

    fn look(&mut self, block: usize) {
        (self.look)(block);
    }
}

/// Finds the smallest distance of the items from a query object within `extent_m` of `place`.
pub(super) struct NearestSearch<F> {
    pub place: Point,
    pub extent_m: f64,
    /// The smallest distance so far, m.
    pub best: f64,
    /// Smallest distance of a block's items, m. If all are farther from `place` than the second
    /// argument, any larger number.
    pub measure: F,
}

impl<F: Fn(usize, f64) -> f64> NearestSearch<F> {
    /// Largest distance from `place` at which an item can improve the result, m.
    fn reach(&self) -> f64 {
        self.best + self.extent_m + SLACK_M
    }

    /// The smallest distance, m; `best` for an empty tree.
    pub fn search(mut self, tree: &Tree) -> f64 {
        if let Some(guess) = tree.guess(self.place) {
            self.look(guess);
            tree.search(&mut self);
        }
        self.best
    }
}

impl<F: Fn(usize, f64) -> f64> TreeSearch for NearestSearch<F> {
    fn wants(&self, boxes: &Boxes) -> [bool; LANES] {
        boxes.near(self.place, self.reach())
    }

    fn look(&mut self, block: usize) {
        self.best = min(self.best, (self.measure)(block, self.reach()));
    }
}
