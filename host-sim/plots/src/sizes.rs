//! Draws a measure over the size of a map, with levels that do not depend on it.

use crate::draw::color::{self, GRAY, INK, PALE};
use crate::draw::layout::{Legend, MARGIN, PAGE, PLOT, TOP, heading};
use crate::draw::svg::{Anchor, Font, Svg, fill, stroke};

/// Height of the axes, px.
const HEIGHT: f64 = 340.0;

/// Draws lines over map sizes, and level lines; `lines` have a name and one value per size.
///
/// Returns an SVG document.
#[must_use]
pub fn sizes(
    title: &str,
    measure: &str,
    sizes: &[String],
    lines: &[(String, Vec<f64>)],
    levels: &[(String, f64)],
) -> String {
    let area = [MARGIN + 42.0, TOP + 8.0, PLOT - 62.0, HEIGHT];
    let mut svg = Svg::new(PAGE, TOP + HEIGHT + 56.0);
    heading(&mut svg, title, measure);
    let values = lines
        .iter()
        .flat_map(|(_, values)| values)
        .chain(levels.iter().map(|(_, value)| value));
    let most = values
        .copied()
        .filter(|value| value.is_finite())
        .fold(0.0, f64::max);
    // Rounded to tenths, at least 1: shares and ratios are compared with 1.
    let top = libm::ceil(most.max(1.0) * 10.0 - 1e-9) / 10.0;
    let axes = SizeAxes {
        area,
        top,
        last: sizes.len().saturating_sub(1).max(1),
    };
    axes.draw(&mut svg, sizes);
    let mut legend = Legend::right_of(PLOT);
    draw_lines(&mut svg, &mut legend, &axes, lines);
    legend.skip(6.0);
    draw_levels(&mut svg, &mut legend, &axes, levels);
    svg.finish(title, measure)
}

fn draw_lines(svg: &mut Svg, legend: &mut Legend, axes: &SizeAxes, lines: &[(String, Vec<f64>)]) {
    legend.headline(svg, "Maps");
    for (index, (name, values)) in lines.iter().enumerate() {
        let color = color::class(index);
        let points: Vec<_> = values
            .iter()
            .enumerate()
            .map(|(i, &value)| axes.at(i, value))
            .collect();
        svg.polyline(&points, &stroke(color, 2.2));
        for point in points {
            svg.circle(point, 3.2, &fill(color));
        }
        legend.entry(svg, name, |svg, [x, y]| {
            svg.line([x - 11.0, y], [x + 11.0, y], &stroke(color, 2.6))
        });
    }
}

fn draw_levels(svg: &mut Svg, legend: &mut Legend, axes: &SizeAxes, levels: &[(String, f64)]) {
    legend.headline(svg, "Without a map");
    for (index, (name, value)) in levels.iter().enumerate() {
        let dashes = ["6 4", "2 3", "10 3 2 3"][index % 3];
        let style = format!(r#"{} stroke-dasharray="{dashes}""#, stroke(INK, 1.6));
        svg.line(axes.at(0, *value), axes.at(axes.last, *value), &style);
        legend.entry(svg, name, |svg, [x, y]| {
            svg.line([x - 11.0, y], [x + 11.0, y], &style)
        });
    }
}

/// Maps values to page coordinates.
struct SizeAxes {
    area: [f64; 4],
    top: f64,
    last: usize,
}

impl SizeAxes {
    fn at(&self, size: usize, value: f64) -> [f64; 2] {
        let [left, top, width, height] = self.area;
        let share = (value / self.top).clamp(0.0, 1.0);
        [
            left + width * size as f64 / self.last as f64,
            top + height * (1.0 - share),
        ]
    }

    fn draw(&self, svg: &mut Svg, sizes: &[String]) {
        let font = Font::new(11.0).color(GRAY);
        for fifth in 0..=5 {
            let value = self.top * f64::from(fifth) / 5.0;
            let [from, to] = [self.at(0, value), self.at(self.last, value)];
            svg.line(from, to, &stroke(PALE, 1.0));
            svg.text(
                [from[0] - 6.0, from[1] + 4.0],
                font.at(Anchor::End),
                &format!("{value:.2}"),
            );
        }
        let every = sizes.len().div_ceil(9).max(1);
        for (index, size) in sizes
            .iter()
            .enumerate()
            .filter(|(index, _)| index % every == 0)
        {
            let [x, y] = self.at(index, 0.0);
            svg.text([x, y + 18.0], font.at(Anchor::Middle), size);
        }
        let [left, top, width, height] = self.area;
        svg.text(
            [left + width / 2.0, top + height + 38.0],
            font.at(Anchor::Middle),
            "neurons of each map",
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::assert_well_formed;

    #[test]
    fn curves_and_levels_are_named() {
        let names: Vec<String> = (4..=20).map(|side| format!("{side}x{side}")).collect();
        let lines = [("by <change>".to_owned(), vec![0.5; 17])];
        let picture = sizes("t", "m", &names, &lines, &[("mean".to_owned(), 1.3)]);
        assert_well_formed(&picture);
        assert!(picture.contains("by &lt;change&gt;") && picture.contains(">mean</text>"));
        assert_well_formed(&sizes("t", "m", &[], &[], &[]));
    }
}
