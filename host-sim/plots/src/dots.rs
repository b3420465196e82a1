//! Draws dot plots: means with 95 % intervals, a row per value, a panel per measure.

use sim::statistics::Mean;

use crate::draw::color::{BLUE, GRAY, PALE};
use crate::draw::layout::{MARGIN, PAGE, TOP, heading, shortened};
use crate::draw::svg::{Anchor, Font, Svg, decimal, fill, stroke};

/// Width of the rows' labels, px.
const LABELS: f64 = 180.0;
/// Height of a row, px.
const ROW: f64 = 24.0;
/// Gap between panels, px.
const GAP: f64 = 30.0;
/// Height above a section's rows, for its title and the panels' names, px.
const ABOVE: f64 = 50.0;
/// Height below the rows, for the numbers of the axes, px.
const BELOW: f64 = 34.0;

/// One measure.
#[derive(Debug, Clone, PartialEq)]
pub struct DotPanel {
    /// Its name, with the unit.
    pub name: String,
    /// Limits of the measure.
    pub within: [f64; 2],
    /// One mean per row; `None` without a value.
    pub means: Vec<Option<Mean>>,
}

/// Rows under a common title, with axes of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct DotSection {
    /// Its title.
    pub title: String,
    /// Labels of the rows, and the number of cases of each.
    pub labels: Vec<(String, usize)>,
    /// The measures.
    pub panels: Vec<DotPanel>,
}

/// Draws sections one below the other; the panels of a section are side by side.
///
/// Returns an SVG document.
#[must_use]
pub fn dot_plot(title: &str, subtitle: &str, sections: &[DotSection]) -> String {
    let height = |section: &DotSection| ABOVE + section.labels.len() as f64 * ROW + BELOW;
    let mut svg = Svg::new(PAGE, TOP + sections.iter().map(height).sum::<f64>());
    heading(&mut svg, title, subtitle);
    let mut top = TOP;
    for part in sections {
        section(&mut svg, top, part);
        top += height(part);
    }
    svg.finish(title, subtitle)
}

fn section(svg: &mut Svg, top: f64, section: &DotSection) {
    let bold = Font::new(13.0).bold();
    svg.text([MARGIN, top + 14.0], bold, &shortened(&section.title, 100));
    let small = Font::new(11.0).color(GRAY).at(Anchor::End);
    let middle = |row: usize| top + ABOVE + (row as f64 + 0.5) * ROW;
    for (row, (label, cases)) in section.labels.iter().enumerate() {
        let y = middle(row) + 4.0;
        svg.text([MARGIN, y], Font::new(12.0), &shortened(label, 20));
        let right = MARGIN + LABELS - 8.0;
        svg.text([right, y], small, &format!("n={cases}"));
    }
    let count = section.panels.len().max(1) as f64;
    let width = (PAGE - 2.0 * MARGIN - LABELS - GAP * (count - 1.0)) / count;
    for (index, panel) in section.panels.iter().enumerate() {
        let left = MARGIN + LABELS + index as f64 * (width + GAP);
        let name = shortened(&panel.name, (width / 6.2) as usize);
        svg.text([left, top + 38.0], Font::new(12.0).color(GRAY), &name);
        let axis = DotAxis::holding(panel, left, width);
        axis.draw(svg, top + ABOVE, section.labels.len() as f64 * ROW);
        for (row, mean) in panel.means.iter().enumerate() {
            let Some(Mean { mean, interval }) = mean else {
                continue;
            };
            let [low, high] = interval.map(|end| axis.at(end));
            let y = middle(row);
            svg.line([low, y], [high, y], &stroke(BLUE, 2.0));
            svg.circle([axis.at(*mean), y], 4.2, &fill(BLUE));
        }
    }
}

/// Maps values to page coordinates.
struct DotAxis {
    left: f64,
    width: f64,
    low: f64,
    high: f64,
}

impl DotAxis {
    /// An axis with room for all intervals of a panel.
    fn holding(panel: &DotPanel, left: f64, width: f64) -> Self {
        let ends = panel.means.iter().flatten().flat_map(|mean| mean.interval);
        let low = ends.clone().fold(f64::INFINITY, f64::min);
        let high = ends.fold(f64::NEG_INFINITY, f64::max);
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let [least, most] = panel.within;
        // Without any spread the values lie in the middle, or at a limit of the measure.
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
        let font = Font::new(11.0).color(GRAY).at(Anchor::Middle);
        let (ticks, decimals) = ticks(self.low, self.high);
        for tick in ticks {
            let x = self.at(tick);
            svg.line([x, top], [x, top + height], &stroke(PALE, 1.0));
            svg.text([x, top + height + 14.0], font, &decimal(tick, decimals));
        }
    }
}

/// Round numbers between two values, at most six, and the number of their decimals.
fn ticks(low: f64, high: f64) -> (Vec<f64>, usize) {
    let span = (high - low).max(1e-9);
    let unit = libm::pow(10.0, libm::floor(libm::log10(span / 4.0)));
    let steps = [1.0, 2.0, 5.0].map(|factor| factor * unit);
    let step = steps.into_iter().find(|step| span / step <= 4.5);
    let step = step.unwrap_or(10.0 * unit);
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
            let within = low - 1e-9..=high + 1e-9;
            assert!(found.iter().all(|tick| within.contains(tick)), "{found:?}");
        }
    }

    #[test]
    fn every_row_has_its_label_and_every_mean_its_dot() {
        let mean = Mean {
            mean: 0.5,
            interval: [0.4, 0.7],
        };
        let panel = |name: &str, means: Vec<Option<Mean>>| DotPanel {
            name: name.to_owned(),
            within: [0.0, f64::INFINITY],
            means,
        };
        let section = DotSection {
            title: "avoid <all>".to_owned(),
            labels: vec![("far 1".to_owned(), 12), ("none".to_owned(), 0)],
            panels: vec![
                panel("share", vec![Some(mean), None]),
                panel("way", vec![Some(mean), None]),
            ],
        };
        let picture = dot_plot("far", "by <value>", &[section.clone(), section]);
        assert_well_formed(&picture);
        for text in ["avoid &lt;all&gt;", ">far 1</text>", ">share</text>"] {
            assert_eq!(picture.matches(text).count(), 2, "{text}");
        }
        assert_eq!(picture.matches("<circle").count(), 4);
        assert_well_formed(&dot_plot("none", "", &[]));
    }
}
