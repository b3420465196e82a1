//! A tree of boxes over the things of a world: a query about one place looks at what is near only.
//!
//! Things stand in the order of a curve that fills the plane (Morton 1966) and are cut into blocks
//! of [`LANES`]. Each block has a box around it, [`LANES`] boxes have one around them, and so on. A
//! search skips blocks that cannot matter; no answer depends on the tree.

use crate::geometry::{Point, max, min};

/// Far above any rounding, far below anything that matters, m.
pub(crate) const SLACK_M: f64 = 1e-6;

/// Things per block, and boxes per row of the tree.
pub(crate) const LANES: usize = 8;

/// Boxes around [`LANES`] things or rows of boxes, one array per side, m. An unused place lies
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

    /// Whether each box comes within `reach` m of a place, or nearly.
    #[inline]
    pub fn near(&self, place: Point, reach: f64) -> [bool; LANES] {
        let most = (reach + SLACK_M) * (reach + SLACK_M);
        self.distances_squared(place).map(|squared| squared <= most)
    }

    /// Squared distance of each box from a place, m².
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

    /// Whether a ray from `origin` along the unit vector `direction` meets each box within `reach`
    /// m, or nearly.
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

/// The box around something, m.
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

    /// The box around two points.
    pub fn of(a: Point, b: Point) -> Self {
        Self {
            low: Point::new(min(a.x, b.x), min(a.y, b.y)),
            high: Point::new(max(a.x, b.x), max(a.y, b.y)),
        }
    }

    /// The box around a circle.
    pub fn around(center: Point, radius: f64) -> Self {
        let half = Point::new(radius, radius);
        Self {
            low: center - half,
            high: center + half,
        }
    }

    /// The box around many.
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

/// Sorts things so that neighbors stand together. Things with the same key keep their order.
pub(super) fn sort<T>(things: &mut [T], bounds: impl Fn(&T) -> Bounds) {
    let all = Bounds::all(things.iter().map(&bounds));
    let size = all.high - all.low;
    let cell = |at: f64, low: f64, size: f64| {
        // From 0 to 65 535; the cast saturates, and makes 0 of a world without extent.
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
    /// Which of these boxes may hold something that matters.
    fn wants(&self, boxes: &Boxes) -> [bool; LANES];

    /// Looks at a block of things.
    fn look(&mut self, block: usize);
}

/// The boxes, from those around blocks to those around everything.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Tree {
    /// Box j of row i of a level lies around row `LANES * i + j` of the level below; of the lowest
    /// level, around that block.
    levels: Vec<Vec<Boxes>>,
}

impl Tree {
    /// A tree over things in blocks of [`LANES`].
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

    /// A block near a place, found by always taking the nearest box: a good first guess, no more.
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

/// Looks at every block that may come within `reach` m of `place`.
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

/// Finds the least distance of the things from something that lies within `extent_m` of `place`.
pub(super) struct NearestSearch<F> {
    pub place: Point,
    pub extent_m: f64,
    /// The least distance so far, m.
    pub best: f64,
    /// Least distance of a block's things, m; any greater number if they are all farther than the
    /// second argument from `place`.
    pub measure: F,
}

impl<F: Fn(usize, f64) -> f64> NearestSearch<F> {
    /// How far from `place` something better can lie, m.
    fn reach(&self) -> f64 {
        self.best + self.extent_m + SLACK_M
    }

    /// The least distance, m: `best` in an empty tree.
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
