//! Draws curves with 95 % bands: measures over repetitions or moves, several lines per panel.

use sim::statistics::Mean;

use crate::draw::color::{BLUE, GRAY, GREEN, INK, ORANGE, PALE, PURPLE, VERMILLION};
use crate::draw::layout::{MARGIN, PAGE, TOP, heading, shortened};
use crate::draw::svg::{Anchor, Font, Svg, fill, stroke};

/// Panels in a row.
const COLUMNS: usize = 3;
/// Height of a panel with its captions, and of its axes, px.
const HEIGHT: f64 = 214.0;
const AXES: f64 = 138.0;

/// Height of the names below the panels, and of each further row of them, px.
const NAMES: f64 = 30.0;
const NAMES_ROW: f64 = 20.0;

/// Names in a row, at most: more would run into each other.
const NAMES_IN_ROW: usize = 4;

/// Colors of the lines, in order.
const COLORS: [&str; 6] = [BLUE, ORANGE, GREEN, PURPLE, VERMILLION, INK];

/// What all panels share.
#[derive(Debug, Clone)]
pub struct CurveKey {
    /// One line about the page.
    pub subtitle: String,
    /// Name of the horizontal axis.
    pub along: String,
    /// Labeled positions on the horizontal axis (counted from 0), with their labels.
    pub ticks: Vec<(usize, String)>,
    /// Names of the lines, and whether they are dashed; empty if the subtitle names them.
    pub names: Vec<(String, bool)>,
}

/// One panel: a measure by line; the first line is drawn first.
#[derive(Debug, Clone)]
pub struct Curves {
    /// Title of the panel.
    pub title: String,
    /// Name of the measure.
    pub measure: String,
    /// Limits of the measure; the axis does not exceed them.
    pub within: [f64; 2],
    /// The lines, all of equal length.
    pub lines: Vec<Vec<Mean>>,
}

/// Draws a panel per measure, with lines in blue, orange, green, purple, vermillion, black.
///
/// Returns an SVG document.
#[must_use]
pub fn curves(title: &str, key: &CurveKey, panels: &[Curves]) -> String {
    let rows = panels.len().div_ceil(COLUMNS).max(1);
    let below = TOP + rows as f64 * HEIGHT;
    let names = match key.names.len().div_ceil(NAMES_IN_ROW) {
        0 => 0.0,
        rows => NAMES + (rows - 1) as f64 * NAMES_ROW,
    };
    let mut svg = Svg::new(PAGE, below + names);
    heading(&mut svg, title, &key.subtitle);
    let side = (PAGE - 2.0 * MARGIN) / COLUMNS as f64;
    for (index, curves) in panels.iter().enumerate() {
        let left = MARGIN + (index % COLUMNS) as f64 * side;
        let top = TOP + (index / COLUMNS) as f64 * HEIGHT;
        panel(&mut svg, [left, top], side, key, curves);
    }
    let width = (PAGE - 2.0 * MARGIN) / key.names.len().clamp(1, NAMES_IN_ROW) as f64;
    for (index, (name, _)) in key.names.iter().enumerate() {
        let left = MARGIN + (index % NAMES_IN_ROW) as f64 * width;
        let y = below + 8.0 + (index / NAMES_IN_ROW) as f64 * NAMES_ROW;
        svg.polyline(&[[left, y], [left + 24.0, y]], &drawn(key, index));
        svg.text([left + 30.0, y + 4.0], Font::new(12.0), name);
    }
    svg.finish(title, &key.subtitle)
}

fn color(line: usize) -> &'static str {
    COLORS.get(line % COLORS.len()).copied().unwrap_or(INK)
}

fn drawn(key: &CurveKey, line: usize) -> String {
    let solid = stroke(color(line), 2.0);
    match key.names.get(line) {
        Some((_, true)) => format!(r#"{solid} stroke-dasharray="6 4""#),
        _ => solid,
    }
}

fn panel(svg: &mut Svg, [left, top]: [f64; 2], side: f64, key: &CurveKey, curves: &Curves) {
    let name = shortened(&curves.title, (side / 7.0) as usize);
    svg.text([left, top + 14.0], Font::new(12.5).bold(), &name);
    svg.text(
        [left, top + 29.0],
        Font::new(11.0).color(GRAY),
        &curves.measure,
    );
    let area = [left + 42.0, top + 38.0, side - 62.0, AXES];
    let axes = CurveAxes::holding(area, curves);
    axes.draw(svg, key);
    // Many bands over each other hide the lines.
    let opacity = if curves.lines.len() > 3 { 0.1 } else { 0.22 };
    for (line, means) in curves.lines.iter().enumerate() {
        let place = |end: usize| {
            move |(i, mean): (usize, &Mean)| (i, mean.interval.get(end).copied().unwrap_or(0.0))
        };
        let upper = means.iter().enumerate().map(place(1));
        let lower = means.iter().enumerate().rev().map(place(0));
        let band: Vec<_> = upper.chain(lower).map(|(i, v)| axes.at(i, v)).collect();
        let paint = fill(color(line));
        svg.polygon(&band, &format!(r#"{paint} fill-opacity="{opacity}""#));
    }
    for (line, means) in curves.lines.iter().enumerate() {
        let middle = means.iter().enumerate();
        let points: Vec<_> = middle.map(|(i, mean)| axes.at(i, mean.mean)).collect();
        svg.polyline(&points, &drawn(key, line));
    }
}

/// Maps values to page coordinates.
struct CurveAxes {
    area: [f64; 4],
    low: f64,
    high: f64,
    last: usize,
}

impl CurveAxes {
    fn holding(area: [f64; 4], curves: &Curves) -> Self {
        let all = curves.lines.iter().flatten();
        let ends: Vec<f64> = all.flat_map(|mean| mean.interval).collect();
        let low = ends.iter().copied().fold(f64::INFINITY, f64::min);
        let high = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        // A constant curve lies in the middle.
        let [least, most] = curves.within;
        let longest = curves.lines.iter().map(Vec::len).max().unwrap_or(0);
        let rim = if high > low {
            (high - low) * 0.06
        } else {
            0.01 * high.abs()
        };
        let rim = rim.max(0.01);
        Self {
            area,
            low: (low - rim).max(least),
            high: (high + rim).min(most).max(least + rim),
            last: longest.saturating_sub(1).max(1),
        }
    }

    fn at(&self, repetition: usize, value: f64) -> [f64; 2] {
        let [left, top, width, height] = self.area;
        let share = (value - self.low) / (self.high - self.low);
        [
            left + width * repetition as f64 / self.last as f64,
            top + height * (1.0 - share),
        ]
    }

    fn draw(&self, svg: &mut Svg, key: &CurveKey) {
        let [left, top, width, height] = self.area;
        svg.rect([left, top, width, height], &stroke(PALE, 1.0));
        let font = Font::new(11.0).color(GRAY);
        for (value, y) in [(self.high, top + 10.0), (self.low, top + height)] {
            let digits = if self.high - self.low > 2.0 { 1 } else { 3 };
            let text = format!("{value:.digits$}");
            svg.text([left - 5.0, y], font.at(Anchor::End), &text);
        }
        let below = top + height + 16.0;
        for (place, label) in &key.ticks {
            let [x, _] = self.at(*place, self.low);
            svg.text([x, below], font.at(Anchor::Middle), label);
        }
        // Between the labels of both ends, or below them if there are many.
        let along = if key.ticks.len() > 2 {
            below + 14.0
        } else {
            below
        };
        svg.text(
            [left + width / 2.0, along],
            font.at(Anchor::Middle),
            &key.along,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::assert_well_formed;

    #[test]
    fn curves_are_drawn_even_where_nothing_changes() {
        let mean = |mean: f64| Mean {
            mean,
            interval: [mean - 0.1, mean + 0.1],
        };
        let of = |values: &[f64]| Curves {
            title: "nest, six boxes".into(),
            measure: "reached".into(),
            within: [f64::NEG_INFINITY, f64::INFINITY],
            lines: vec![
                values.iter().rev().copied().map(mean).collect(),
                values.iter().copied().map(mean).collect(),
            ],
        };
        let key = CurveKey {
            subtitle: "Mean and 95 % interval".into(),
            along: "repetition".into(),
            ticks: vec![(0, "1".into()), (2, "3".into())],
            names: vec![("frozen".into(), true), ("learning".into(), false)],
        };
        let picture = curves(
            "Repetition",
            &key,
            &[of(&[1.0, 2.0, 4.0]), of(&[1.0; 3]), of(&[])],
        );
        assert_well_formed(&picture);
        assert!(picture.contains("nest, six boxes"));
    }

    /// The page grows by 20 px, so no name lies beside a fifth one.
    #[test]
    fn more_than_four_names_take_two_rows() {
        let of = |count: usize| {
            let name = |index: usize| (format!("turned least squares {index}"), false);
            let key = CurveKey {
                subtitle: String::new(),
                along: "moves".into(),
                ticks: Vec::new(),
                names: (0..count).map(name).collect(),
            };
            curves("Moves", &key, &[])
        };
        let [four, five] = [4, 5].map(of);
        let height = |svg: &str| -> Option<f64> {
            let (_, rest) = svg.split_once(" height=\"")?;
            rest.split_once('"')?.0.parse().ok()
        };
        assert_eq!(
            height(&five).map(|high| high - 20.0),
            height(&four),
            "{five}"
        );
        assert!(height(&four).is_some());
    }
}
