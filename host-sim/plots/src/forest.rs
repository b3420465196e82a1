//! Measures by the values of something: a row for each value, a column for each measure.

use sim::statistics::Mean;

use crate::draw::color::{BLUE, GRAY, INK, PALE, SKY};
use crate::draw::layout::{MARGIN, PAGE, TOP, heading, shortened, wrapped};
use crate::draw::svg::{Anchor, Font, Svg, decimal, fill, filled, stroke};

/// Width of the rows' labels, px.
const LABELS: f64 = 148.0;
/// Height of a row, px.
const ROW: f64 = 24.0;
/// Gap between columns, px.
const GAP: f64 = 26.0;
/// Height above a section's rows: its title and the columns' names, px.
const ABOVE: f64 = 50.0;
/// Height below them: the axes' numbers, px.
const BELOW: f64 = 34.0;
/// Up to so many values are drawn as dots of their own.
const MAX_DOTS: usize = 60;

/// What is drawn of one measure in one row.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A value with its interval.
    Interval(Mean),
    /// A distribution: its quantiles 5, 25, 50, 75 and 95 %, and its values.
    Spread([f64; 5], Vec<f64>),
    /// Nothing is known.
    Nothing,
}

impl Mark {
    fn reach(&self) -> [f64; 2] {
        match self {
            Self::Interval(mean) => mean.interval,
            Self::Spread([low, .., high], values) => match (values.first(), values.last()) {
                (Some(first), Some(last)) if values.len() <= MAX_DOTS => [*first, *last],
                _ => [*low, *high],
            },
            Self::Nothing => [f64::INFINITY, f64::NEG_INFINITY],
        }
    }
}

/// One measure.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestColumn {
    /// Its name, with the unit.
    pub name: String,
    /// It cannot lie outside.
    pub within: [f64; 2],
    /// A mark for each row.
    pub marks: Vec<Mark>,
}

/// Rows under a common title, with axes of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestSection {
    /// Its title.
    pub title: String,
    /// The rows' labels, and what stands small behind them.
    pub labels: Vec<(String, String)>,
    /// The measures.
    pub columns: Vec<ForestColumn>,
}

/// Draws sections one below the other; the columns stand side by side.
///
/// Returns an SVG document.
#[must_use]
pub fn forest(title: &str, subtitle: &str, sections: &[ForestSection]) -> String {
    let height = |section: &ForestSection| ABOVE + section.labels.len() as f64 * ROW + BELOW;
    let below = TOP + sections.iter().map(height).sum::<f64>();
    let notes = wrapped(NOTE, 118);
    let mut svg = Svg::new(PAGE, below + 10.0 + 16.0 * notes.len() as f64);
    heading(&mut svg, title, subtitle);
    let mut top = TOP;
    for part in sections {
        section(&mut svg, top, part);
        top += height(part);
    }
    for (line, text) in notes.iter().enumerate() {
        let y = below + 8.0 + 16.0 * line as f64;
        svg.text([MARGIN, y], Font::new(11.5).color(GRAY), text);
    }
    svg.finish(title, subtitle)
}

const NOTE: &str = "Dot and line: value and 95 % interval. Box: the middle half of the episodes, with the median; line: all \
                    but the lowest and highest 5 %; small dots: single episodes.";

fn section(svg: &mut Svg, top: f64, section: &ForestSection) {
    svg.text(
        [MARGIN, top + 14.0],
        Font::new(13.0).bold(),
        &shortened(&section.title, 112),
    );
    let rows = section.labels.len();
    for (row, (label, small)) in section.labels.iter().enumerate() {
        let y = top + ABOVE + (row as f64 + 0.5) * ROW;
        let right = MARGIN + LABELS - 8.0;
        svg.text([MARGIN, y + 4.0], Font::new(12.0), &shortened(label, 17));
        svg.text(
            [right, y + 4.0],
            Font::new(11.0).color(GRAY).at(Anchor::End),
            small,
        );
    }
    let count = section.columns.len().max(1) as f64;
    let width = (PAGE - 2.0 * MARGIN - LABELS - GAP * (count - 1.0)) / count;
    for (index, column) in section.columns.iter().enumerate() {
        let left = MARGIN + LABELS + index as f64 * (width + GAP);
        svg.text(
            [left, top + 38.0],
            Font::new(12.0).color(GRAY),
            &shortened(&column.name, 30),
        );
        let axis = Axis::holding(column, left, width);
        axis.draw(svg, top + ABOVE, rows as f64 * ROW);
        for (row, mark) in column.marks.iter().enumerate() {
            axis.mark(svg, top + ABOVE + (row as f64 + 0.5) * ROW, mark);
        }
    }
}

/// Where values lie on the page.
struct Axis {
    left: f64,
    width: f64,
    low: f64,
    high: f64,
}

impl Axis {
    fn holding(column: &ForestColumn, left: f64, width: f64) -> Self {
        let reaches = column.marks.iter().map(Mark::reach);
        let (low, high) = reaches.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), reach| {
            (low.min(reach[0]), high.max(reach[1]))
        });
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let [least, most] = column.within;
        // What never moves lies in the middle, or at the end it cannot pass.
        let rim = ((high - low) * 0.06).max(high.abs() * 0.002).max(1e-3);
        let (low, high) = ((low - rim).max(least), (high + rim).min(most));
        Self {
            left,
            width,
            low,
            high: high.max(low + rim),
        }
    }

    fn at(&self, value: f64) -> f64 {
        self.left + self.width * ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0)
    }

    fn draw(&self, svg: &mut Svg, top: f64, height: f64) {
        svg.rect([self.left, top, self.width, height], &stroke(PALE, 1.0));
        let (ticks, decimals) = ticks(self.low, self.high);
        for tick in ticks {
            let x = self.at(tick);
            svg.line([x, top], [x, top + height], &stroke(PALE, 1.0));
            let text = decimal(tick, decimals);
            // Inside the axis' width: the next axis is near.
            let half = text.chars().count() as f64 * 3.1;
            let x = x.max(self.left + half).min(self.left + self.width - half);
            let font = Font::new(11.0).color(GRAY).at(Anchor::Middle);
            svg.text([x, top + height + 14.0], font, &text);
        }
    }

    fn mark(&self, svg: &mut Svg, y: f64, mark: &Mark) {
        match mark {
            Mark::Nothing => {}
            Mark::Interval(mean) => {
                let [low, high] = mean.interval.map(|end| self.at(end));
                svg.line([low, y], [high, y], &stroke(BLUE, 2.0));
                svg.circle([self.at(mean.mean), y], 4.2, &fill(BLUE));
            }
            Mark::Spread(quantiles, values) => {
                let [least, low, middle, high, most] = quantiles.map(|value| self.at(value));
                svg.line([least, y], [most, y], &stroke(BLUE, 1.4));
                let half = ROW * 0.3;
                svg.rect(
                    [low, y - half, high - low, 2.0 * half],
                    &filled(SKY, BLUE, 1.4),
                );
                svg.line([middle, y - half], [middle, y + half], &stroke(INK, 2.2));
                if values.len() <= MAX_DOTS {
                    self.dots(svg, y, values);
                }
            }
        }
    }

    fn dots(&self, svg: &mut Svg, y: f64, values: &[f64]) {
        let style = format!(r#"{} fill-opacity="0.55""#, fill(INK));
        for (index, value) in values.iter().enumerate() {
            // Spread over the row's height, evenly and always the same.
            let aside = ((index * 5) % 7) as f64 / 6.0 - 0.5;
            svg.circle([self.at(*value), y + aside * ROW * 0.5], 1.6, &style);
        }
    }
}

/// Round numbers between two values, two to six of them, and the decimals they need.
fn ticks(low: f64, high: f64) -> (Vec<f64>, usize) {
    let span = (high - low).max(1e-9);
    let power = libm::floor(libm::log10(span / 4.0));
    let unit = libm::pow(10.0, power);
    let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * unit);
    let step = step
        .into_iter()
        .find(|step| span / step <= 4.5)
        .unwrap_or(10.0 * unit);
    let decimals = (-libm::floor(libm::log10(step) + 1e-9)).max(0.0) as usize;
    let first = libm::ceil(low / step - 1e-9);
    let count = libm::floor(high / step + 1e-9) - first;
    let ticks = (0..=count.max(0.0) as usize).map(|index| (first + index as f64) * step);
    (ticks.collect(), decimals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::assert_well_formed;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(0.0, 1.0), (vec![0.0, 0.5, 1.0], 1));
        let (found, decimals) = ticks(96.2, 100.0);
        assert_eq!((found, decimals), (vec![97.0, 98.0, 99.0, 100.0], 0));
        assert_eq!(ticks(230.0, 252.0).0, [230.0, 235.0, 240.0, 245.0, 250.0]);
        for (low, high) in [(0.0, 1e-3), (-3.0, 8.0), (5.0, 5.001), (1e4, 9e4)] {
            let (found, _) = ticks(low, high);
            assert!((1..=6).contains(&found.len()), "{found:?}");
            assert!(
                found
                    .iter()
                    .all(|tick| (low - 1e-9..=high + 1e-9).contains(tick)),
                "{found:?}"
            );
        }
    }

    #[test]
    fn every_row_has_its_label_and_marks() {
        let mean = Mean {
            mean: 0.5,
            interval: [0.4, 0.7],
        };
        let spread = Mark::Spread([1.0, 2.0, 3.0, 4.0, 5.0], vec![1.0, 3.0, 5.0]);
        let column = |name: &str, marks: Vec<Mark>| ForestColumn {
            name: name.to_owned(),
            within: [0.0, f64::INFINITY],
            marks,
        };
        let section = ForestSection {
            title: "avoid <all>".to_owned(),
            labels: vec![
                ("far 1".to_owned(), "12".to_owned()),
                ("none".to_owned(), "0".to_owned()),
            ],
            columns: vec![
                column("share", vec![Mark::Interval(mean), Mark::Nothing]),
                column("way", vec![spread, Mark::Nothing]),
            ],
        };
        let picture = forest("far", "by <value>", &[section.clone(), section]);
        assert_well_formed(&picture);
        for text in ["avoid &lt;all&gt;", ">far 1</text>", ">share</text>"] {
            assert_eq!(picture.matches(text).count(), 2, "{text}");
        }
        assert_well_formed(&forest("none", "", &[]));
    }
}
