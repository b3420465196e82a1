//! A tree of boxes over the things of a world, so that a question about one place costs the same in a room and in a town.
//!
//! Things are put in the order of a curve that fills the plane (Morton 1966), so that neighbors in the list are neighbors
//! in the plane, and cut into blocks of [`LANES`]. Each block has a box around it, [`LANES`] boxes have one around them, and
//! so on up to a single row of boxes: a hierarchy of bounding boxes without pointers. All it says is which blocks cannot
//! matter; what does is then worked out as without it, so no answer depends on it.

use super::faces::{LANES, max, min};
use super::geometry::Point;

/// Boxes around [`LANES`] things or rows of boxes, one array per side, m. A place without a thing lies infinitely far off.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Boxes {
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

    /// Squared distance of each box from a place, m².
    #[inline]
    pub fn distances_squared(&self, place: Point) -> [f64; LANES] {
        let mut squared = [0.0; LANES];
        for (i, squared) in squared.iter_mut().enumerate() {
            let dx = max(max(self.low_x[i] - place.x, place.x - self.high_x[i]), 0.0);
            let dy = max(max(self.low_y[i] - place.y, place.y - self.high_y[i]), 0.0);
            *squared = dx * dx + dy * dy;
        }
        squared
    }

    /// Whether a ray from `origin` along the unit vector `direction` comes to each box within `reach` m, give or take
    /// [`SLACK_M`].
    #[inline]
    pub fn met_by_ray(&self, origin: Point, direction: Point, reach: f64) -> [bool; LANES] {
        let mut met = [false; LANES];
        for (i, met) in met.iter_mut().enumerate() {
            let (x, y) = (
                (self.low_x[i] + self.high_x[i]) * 0.5 - origin.x,
                (self.low_y[i] + self.high_y[i]) * 0.5 - origin.y,
            );
            let (half_x, half_y) = (
                (self.high_x[i] - self.low_x[i]) * 0.5,
                (self.high_y[i] - self.low_y[i]) * 0.5,
            );
            let (dx, dy) = (direction.x.abs(), direction.y.abs());
            let (along, across) = (
                x * direction.x + y * direction.y,
                x * direction.y - y * direction.x,
            );
            let (deep, wide) = (
                half_x * dx + half_y * dy + SLACK_M,
                half_x * dy + half_y * dx + SLACK_M,
            );
            *met = (across.abs() <= wide) & (along + deep >= 0.0) & (along - deep <= reach);
        }
        met
    }

    fn set(&mut self, lane: usize, around: Bounds) {
        self.low_x[lane] = around.low.x;
        self.low_y[lane] = around.low.y;
        self.high_x[lane] = around.high.x;
        self.high_y[lane] = around.high.y;
    }
}

/// Far above any rounding, far below anything that matters, m.
pub(super) const SLACK_M: f64 = 1e-6;

/// The box around something, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub low: Point,
    pub high: Point,
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
    pub fn all(parts: impl Iterator<Item = Self>) -> Self {
        parts.fold(Self::NOTHING, |all, part| Self {
            low: Point::new(min(all.low.x, part.low.x), min(all.low.y, part.low.y)),
            high: Point::new(max(all.high.x, part.high.x), max(all.high.y, part.high.y)),
        })
    }

    /// Its width and its height, m; negative around nothing.
    pub fn size(&self) -> Point {
        self.high - self.low
    }

    fn middle(&self) -> Point {
        (self.low + self.high) * 0.5
    }
}

/// Brings things into the order in which neighbors stand together. Things with the same key keep theirs.
pub(super) fn sort<T>(things: &mut [T], bounds: impl Fn(&T) -> Bounds) {
    let all = Bounds::all(things.iter().map(&bounds));
    let size = all.size();
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

/// What is asked of a tree.
pub(super) trait Search {
    /// Which of these boxes may hold something that matters.
    fn wants(&self, boxes: &Boxes) -> [bool; LANES];

    /// Looks at a block of things.
    fn look(&mut self, block: usize);
}

/// The boxes, from those around blocks to those around everything.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Tree {
    /// Box j of row i of a level lies around row `LANES * i + j` of the level before it; of the first, around that block.
    levels: Vec<Vec<Boxes>>,
}

impl Tree {
    /// A tree over blocks with these boxes.
    pub fn of(blocks: &[Bounds]) -> Self {
        let mut levels = Vec::new();
        let mut below = blocks.to_vec();
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

    /// Shows a search every block it may want, in the order of the list.
    pub fn search(&self, search: &mut impl Search) {
        if let Some(top) = self.levels.len().checked_sub(1) {
            self.descend(top, 0, search);
        }
    }

    fn descend(&self, level: usize, row: usize, search: &mut impl Search) {
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

    /// A block near a place, by always taking the nearest box: a good first guess, no more.
    pub fn guess(&self, place: Point) -> Option<usize> {
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
pub(super) struct Near<F> {
    pub place: Point,
    pub reach: f64,
    pub look: F,
}

impl<F: FnMut(usize)> Search for Near<F> {
    fn wants(&self, boxes: &Boxes) -> [bool; LANES] {
        let most = (self.reach + SLACK_M) * (self.reach + SLACK_M);
        boxes
            .distances_squared(self.place)
            .map(|squared| squared <= most)
    }

    fn look(&mut self, block: usize) {
        (self.look)(block);
    }
}

/// Finds the least distance of the things from `place`.
pub(super) struct Nearest<F> {
    pub place: Point,
    /// The least distance so far, m.
    pub best: f64,
    /// Least distance of a block's things, m.
    pub measure: F,
}

impl<F: Fn(usize) -> f64> Nearest<F> {
    /// The least distance, m: `best` in an empty tree.
    pub fn search(mut self, tree: &Tree) -> f64 {
        if let Some(guess) = tree.guess(self.place) {
            self.look(guess);
            tree.search(&mut self);
        }
        self.best
    }
}

impl<F: Fn(usize) -> f64> Search for Nearest<F> {
    fn wants(&self, boxes: &Boxes) -> [bool; LANES] {
        let reach = self.best + SLACK_M;
        boxes
            .distances_squared(self.place)
            .map(|squared| squared <= reach * reach)
    }

    fn look(&mut self, block: usize) {
        self.best = min(self.best, (self.measure)(block));
    }
}
