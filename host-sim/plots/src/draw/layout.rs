//! Page layout of all pictures: title, legend column, tiles for map neurons, text helpers.

use super::color::{self, GRAY, INK, PALE};
use super::svg::{Anchor, Font, Svg, decimal, fill, stroke};

/// Width of a page, px.
pub const PAGE: f64 = 800.0;
/// Margin of a page, px.
pub const MARGIN: f64 = 20.0;
/// Top of the drawing, below the title, px.
pub const TOP: f64 = 76.0;
/// Width left of the legend column, px.
pub const PLOT: f64 = 570.0;
/// Distance between drawing and legend, px.
const GUTTER: f64 = 24.0;
/// Width of the symbols before legend labels, px.
const SYMBOL: f64 = 34.0;

/// Title and one line below it.
pub fn heading(svg: &mut Svg, title: &str, subtitle: &str) {
    svg.text(
        [MARGIN, 33.0],
        Font::new(19.0).bold(),
        &shortened(title, 78),
    );
    let subtitle = shortened(subtitle, 124);
    svg.text([MARGIN, 55.0], Font::new(12.5).color(GRAY), &subtitle);
}

/// A legend: symbols with their meaning, from top to bottom; the page grows with it.
#[derive(Debug)]
pub struct Legend {
    x: f64,
    y: f64,
    width: f64,
}

impl Legend {
    /// The legend right of a drawing that is `drawn` px wide.
    pub fn right_of(drawn: f64) -> Self {
        Self::new(
            MARGIN + drawn + GUTTER,
            TOP,
            PAGE - PLOT - 2.0 * MARGIN - GUTTER,
        )
    }

    /// A column of `width` px whose top left corner is (x, y).
    pub fn new(x: f64, y: f64, width: f64) -> Self {
        Self { x, y, width }
    }

    /// Top of the next entry, px from the top of the page.
    pub fn bottom(&self) -> f64 {
        self.y
    }

    /// Leaves `height` px empty.
    pub fn skip(&mut self, height: f64) {
        self.y += height;
    }

    /// A headline.
    pub fn headline(&mut self, svg: &mut Svg, text: &str) {
        svg.text([self.x, self.y + 12.0], Font::new(12.5).bold(), text);
        self.y += 22.0;
    }

    /// An entry: `draw` draws the symbol around the given center.
    pub fn entry(&mut self, svg: &mut Svg, meaning: &str, draw: impl FnOnce(&mut Svg, [f64; 2])) {
        draw(svg, [self.x + SYMBOL / 2.0 - 4.0, self.y + 9.0]);
        self.lines(svg, meaning, SYMBOL, 12.0, INK);
        self.y += 7.0;
    }

    /// A paragraph in small print.
    pub fn note(&mut self, svg: &mut Svg, text: &str) {
        self.lines(svg, text, 0.0, 11.5, GRAY);
        self.y += 7.0;
    }

    /// A color bar of [`color`] `ramp` with the values at its ends.
    pub fn ramp(&mut self, svg: &mut Svg, title: &str, ends: [&str; 2], ramp: fn(f64) -> String) {
        self.lines(svg, title, 0.0, 12.0, INK);
        const PARTS: usize = 32;
        let part = self.width / PARTS as f64;
        let top = self.y + 3.0;
        for i in 0..PARTS {
            let color = ramp(i as f64 / (PARTS - 1) as f64);
            // Each part overlaps the next, so that no gap is visible.
            let width = if i + 1 < PARTS { part + 1.0 } else { part };
            svg.rect([self.x + i as f64 * part, top, width, 12.0], &fill(&color));
        }
        svg.rect([self.x, top, self.width, 12.0], &stroke(PALE, 1.0));
        let font = Font::new(11.0).color(GRAY);
        svg.text([self.x, top + 26.0], font, ends[0]);
        svg.text(
            [self.x + self.width, top + 26.0],
            font.at(Anchor::End),
            ends[1],
        );
        self.y = top + 40.0;
        svg.grow(self.y + MARGIN);
    }

    /// Adds one line of small print; returns the start of its baseline.
    pub fn next_line(&mut self, svg: &mut Svg) -> [f64; 2] {
        self.y += 16.0;
        svg.grow(self.y + MARGIN);
        [self.x, self.y - 4.0]
    }

    /// The horizontal middle of the column and its width, px.
    pub fn column(&self) -> (f64, f64) {
        (self.x + self.width / 2.0, self.width)
    }

    fn lines(&mut self, svg: &mut Svg, text: &str, indent: f64, size: f64, color: &'static str) {
        let room = ((self.width - indent) / (size * 0.5)) as usize;
        for line in wrapped(text, room) {
            self.y += size * 1.3;
            svg.text(
                [self.x + indent, self.y - size * 0.25],
                Font::new(size).color(color),
                &line,
            );
        }
        svg.grow(self.y + MARGIN);
    }
}

/// Tiles of a map's neurons on the page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tiles {
    columns: usize,
    count: usize,
    side: f64,
    /// The map is a chain, drawn in several rows.
    folded: bool,
}

/// Widest tile, px.
const MAX_TILE: f64 = 150.0;
/// Number of columns of a folded chain.
const CHAIN_COLUMNS: usize = 6;

impl Tiles {
    /// Tiles for `count` neurons on `grid` (columns, rows), none narrower than `smallest` px.
    ///
    /// A chain (a grid with one row or one column) longer than 6 is folded into rows.
    pub fn new(grid: [usize; 2], count: usize, smallest: f64) -> Self {
        let folded = grid[0].min(grid[1]) <= 1 && count > CHAIN_COLUMNS;
        let columns = if folded {
            CHAIN_COLUMNS
        } else {
            grid[0].clamp(1, count.max(1))
        };
        let rows = count.div_ceil(columns).max(1);
        // A tall grid must not make an endless page.
        let side = (PLOT / columns as f64).min(960.0 / rows as f64);
        let side = side.min(MAX_TILE).max(smallest);
        Self {
            columns,
            count,
            side,
            folded,
        }
    }

    /// Side of a tile, px.
    pub fn side(&self) -> f64 {
        self.side
    }

    /// Width of all tiles together, px.
    pub fn width(&self) -> f64 {
        self.side * self.columns as f64
    }

    /// Height of all tiles together, px.
    pub fn height(&self) -> f64 {
        self.side * self.count.div_ceil(self.columns) as f64
    }

    /// Width of a page with these tiles and a legend column, px.
    pub fn page_width(&self) -> f64 {
        PAGE.max(PAGE - PLOT + self.width())
    }

    /// Explains which tiles are neighbors.
    pub fn neighbors(&self) -> &'static str {
        if self.folded {
            "The map is a chain, folded like lines of text: N1 and N2 are neighbors, and so on."
        } else {
            "Tiles that share a side are neighbors in the map."
        }
    }

    /// The tile of neuron `index` (from 0): `[left, top, width, height]`.
    pub fn tile(&self, index: usize) -> [f64; 4] {
        let (column, row) = (index % self.columns, index / self.columns);
        let left = MARGIN + column as f64 * self.side;
        [left, TOP + row as f64 * self.side, self.side, self.side]
    }
}

/// `text` cut to at most `limit` characters, with an ellipsis where something is missing.
pub fn shortened(text: &str, limit: usize) -> String {
    if text.chars().count() <= limit {
        return text.into();
    }
    let mut short: String = text.chars().take(limit.saturating_sub(1)).collect();
    short.push('…');
    short
}

/// `text` broken between words into lines of at most `limit` characters; longer words are
/// shortened.
///
/// A no-break space does not end a word.
pub fn wrapped(text: &str, limit: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let word = shortened(word, limit.max(2));
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= limit => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

/// `count` and a noun, in the plural where it belongs: "1 move", "3 moves".
pub fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// The values scaled to [0, 1] between the smallest and the largest finite one, and both; 0 when
/// all are equal.
pub fn normalized(values: &[f64]) -> (Vec<f64>, [f64; 2]) {
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    if low > high {
        return (vec![0.0; values.len()], [0.0, 0.0]);
    }
    let span = high - low;
    let place = |&v: &f64| {
        if span > 0.0 && v.is_finite() {
            (v - low) / span
        } else {
            0.0
        }
    };
    (values.iter().map(place).collect(), [low, high])
}

/// The end of an axis from zero: the smallest round value up to 1 that holds all magnitudes.
pub fn axis_end<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let finite = values.filter(|value| value.is_finite());
    let largest = finite.fold(0.0, |largest: f64, value| largest.max(value.abs()));
    [0.1, 0.25, 0.5]
        .into_iter()
        .find(|&end| largest <= end && largest > 0.0)
        .unwrap_or(1.0)
}

/// The background color bar of a map, with its meaning.
pub fn u_matrix_legend(legend: &mut Legend, svg: &mut Svg, [low, high]: [f64; 2]) {
    let (low, high) = (decimal(low, 2), decimal(high, 2));
    legend.ramp(
        svg,
        "Background: mean distance to neighbors",
        [&low, &high],
        color::tint,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_stay_apart_and_on_the_page() {
        for (grid, count) in [
            ([4, 4], 16),
            ([1, 32], 32),
            ([32, 1], 32),
            ([6, 5], 30),
            ([1, 1], 1),
        ] {
            let tiles = Tiles::new(grid, count, 80.0);
            for i in 0..count {
                let [x, y, w, h] = tiles.tile(i);
                assert!(x >= MARGIN && x + w <= MARGIN + tiles.width() + 1e-9);
                assert!(y + h <= TOP + tiles.height() + 1e-9);
                for j in 0..i {
                    let [x2, y2, ..] = tiles.tile(j);
                    assert!((x - x2).abs() >= w - 1e-9 || (y - y2).abs() >= h - 1e-9);
                }
            }
            assert!(tiles.width() <= PLOT, "{grid:?}");
        }
        assert!(Tiles::new([30, 2], 60, 56.0).page_width() > PAGE);
    }

    #[test]
    fn words_are_wrapped_and_shortened() {
        assert_eq!(wrapped("one two three", 8), ["one two", "three"]);
        assert_eq!(wrapped("extraordinary", 6), ["extra…"]);
        assert_eq!(shortened("abc", 3), "abc");
        assert_eq!(counted(1, "move"), "1 move");
    }

    #[test]
    fn an_axis_holds_every_value() {
        for (value, end) in [
            (0.0, 1.0),
            (0.07, 0.1),
            (-0.2, 0.25),
            (0.5, 0.5),
            (0.51, 1.0),
        ] {
            assert_eq!(axis_end([value, f64::NAN].iter()), end);
        }
    }

    #[test]
    fn normalized_values_span_zero_to_one() {
        assert_eq!(normalized(&[2.0, 4.0, 3.0]).0, [0.0, 1.0, 0.5]);
        assert_eq!(normalized(&[2.0, 2.0]).0, [0.0, 0.0]);
        assert_eq!(normalized(&[f64::NAN]), (vec![0.0], [0.0, 0.0]));
    }
}
