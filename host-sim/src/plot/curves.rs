//! Curves with their 95 % bands: a measure over repetitions, with learning and with frozen maps.

use crate::experiments::statistics::Mean;

use super::color::{BLUE, GREY, ORANGE, PALE};
use super::layout::{MARGIN, PAGE, TOP, heading, shortened};
use super::svg::{Anchor, Font, Svg, fill, num, stroke};

/// Panels in a row.
const COLUMNS: usize = 3;
/// A panel's height with its captions, and that of its axes, px.
const HEIGHT: f64 = 214.0;
const AXES: f64 = 138.0;

/// One panel: the same measure twice.
#[derive(Debug, Clone)]
pub struct Curves {
    /// What is repeated.
    pub title: String,
    /// The measure.
    pub measure: String,
    /// By repetition, while the maps learn.
    pub learning: Vec<Mean>,
    /// By repetition, with frozen maps.
    pub frozen: Vec<Mean>,
}

/// Draws a panel for each behaviour: orange while the maps go on learning, blue with frozen maps.
///
/// Returns an SVG document.
#[must_use]
pub fn curves(title: &str, panels: &[Curves]) -> String {
    let rows = panels.len().div_ceil(COLUMNS).max(1);
    let mut svg = Svg::new(PAGE, TOP + rows as f64 * HEIGHT);
    let subtitle = "Mean and 95 % interval by repetition · orange: the maps go on learning · blue: frozen maps";
    heading(&mut svg, title, subtitle);
    let side = (PAGE - 2.0 * MARGIN) / COLUMNS as f64;
    for (index, curves) in panels.iter().enumerate() {
        let left = MARGIN + (index % COLUMNS) as f64 * side;
        let top = TOP + (index / COLUMNS) as f64 * HEIGHT;
        panel(&mut svg, [left, top], side, curves);
    }
    svg.finish(title, subtitle)
}

fn panel(svg: &mut Svg, [left, top]: [f64; 2], side: f64, curves: &Curves) {
    let name = shortened(&curves.title, (side / 7.0) as usize);
    svg.text([left, top + 14.0], Font::new(12.5).bold(), &name);
    svg.text(
        [left, top + 29.0],
        Font::new(11.0).color(GREY),
        &curves.measure,
    );
    let area = [left + 42.0, top + 38.0, side - 62.0, AXES];
    let axes = Axes::holding(area, curves);
    axes.draw(svg, curves.learning.len());
    for (means, color) in [(&curves.frozen, BLUE), (&curves.learning, ORANGE)] {
        let place = |end: usize| {
            move |(i, mean): (usize, &Mean)| (i, mean.interval.get(end).copied().unwrap_or(0.0))
        };
        let upper = means.iter().enumerate().map(place(1));
        let lower = means.iter().enumerate().rev().map(place(0));
        let band: Vec<_> = upper.chain(lower).map(|(i, v)| axes.at(i, v)).collect();
        svg.polygon(&band, &format!(r#"{} fill-opacity="0.22""#, fill(color)));
        let middle = means.iter().enumerate();
        let line: Vec<_> = middle.map(|(i, mean)| axes.at(i, mean.mean)).collect();
        svg.polyline(&line, &stroke(color, 2.0));
    }
}

/// Where values lie on the page.
struct Axes {
    area: [f64; 4],
    low: f64,
    high: f64,
    last: usize,
}

impl Axes {
    fn holding(area: [f64; 4], curves: &Curves) -> Self {
        let both = curves.learning.iter().chain(&curves.frozen);
        let ends: Vec<f64> = both.flat_map(|mean| mean.interval).collect();
        let low = ends.iter().copied().fold(f64::INFINITY, f64::min);
        let high = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        // A curve that never moves lies in the middle.
        let rim = ((high - low) * 0.06).max(0.01);
        Self {
            area,
            low: low - rim,
            high: high + rim,
            last: curves.learning.len().saturating_sub(1).max(1),
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

    fn draw(&self, svg: &mut Svg, repetitions: usize) {
        let [left, top, width, height] = self.area;
        svg.rect([left, top, width, height], &stroke(PALE, 1.0));
        let font = Font::new(11.0).color(GREY);
        for (value, y) in [(self.high, top + 10.0), (self.low, top + height)] {
            let digits = if self.high - self.low > 2.0 { 1 } else { 3 };
            let text = format!("{value:.digits$}");
            svg.text([left - 5.0, y], font.at(Anchor::End), &text);
        }
        let below = top + height + 16.0;
        svg.text([left, below], font.at(Anchor::Middle), "1");
        let last = num(repetitions as f64);
        svg.text([left + width, below], font.at(Anchor::Middle), &last);
        svg.text(
            [left + width / 2.0, below],
            font.at(Anchor::Middle),
            "repetition",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::fixture::assert_well_formed;

    #[test]
    fn curves_are_drawn_even_where_nothing_changes() {
        let mean = |mean: f64| Mean {
            mean,
            interval: [mean - 0.1, mean + 0.1],
        };
        let of = |values: &[f64]| Curves {
            title: "nest, six boxes".into(),
            measure: "reached".into(),
            learning: values.iter().copied().map(mean).collect(),
            frozen: values.iter().rev().copied().map(mean).collect(),
        };
        let picture = curves(
            "Repetition",
            &[of(&[1.0, 2.0, 4.0]), of(&[1.0; 3]), of(&[])],
        );
        assert_well_formed(&picture);
        assert!(picture.contains("nest, six boxes"));
    }
}
