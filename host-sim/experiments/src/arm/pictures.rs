//! Pictures of arms.

use super::body::{ArmBody, Vector};
use super::reach::Trajectory;
use plots::draw::color::{BLUE, GRAY, INK, PALE, VERMILLION};
use plots::draw::layout::{MARGIN, PAGE, TOP, heading};
use plots::draw::svg::{Anchor, Font, Svg, fill, filled, stroke};

/// Reaches that are drawn.
const SHOWN: usize = 3;
/// Side of a view, px, and the height of its caption.
const SIDE: f64 = 244.0;
const CAPTION: f64 = 20.0;
/// Moves of a reach that shows something.
const MOVES: std::ops::RangeInclusive<usize> = 6..=16;
/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Draws the first reaches around a region, each from above and from the side.
///
/// Returns an SVG document.
#[must_use]
pub fn reaching(body: &ArmBody, all: &[Trajectory]) -> String {
    let is_shown = |way: &&Trajectory| {
        let last = way.postures.last();
        let hand_m = last.map_or([f64::NAN; 3], |angles| body.hand_m(angles));
        let error = super::body::distance(hand_m, way.target_m) / body.reach_m();
        error <= super::reach::TOLERANCE && MOVES.contains(&(way.postures.len() - 1))
    };
    let shown: Vec<_> = all.iter().filter(is_shown).take(SHOWN).collect();
    let mut svg = Svg::new(PAGE, TOP + 2.0 * (SIDE + CAPTION) + 48.0);
    let title = "An arm reaches for targets after 100 random moves";
    let subtitle = "Two maps of 16 neurons; the hand is to keep out of the gray region. Above: seen \
                    from above, below: from the side";
    heading(&mut svg, title, subtitle);
    for (column, way) in shown.iter().enumerate() {
        for (row, axes) in [[0, 1], [0, 2]].into_iter().enumerate() {
            let left = MARGIN + column as f64 * (SIDE + 14.0);
            let top = TOP + row as f64 * (SIDE + CAPTION);
            ArmView::new(body, axes, [left, top]).draw(&mut svg, body, way);
        }
    }
    legend(&mut svg, TOP + 2.0 * (SIDE + CAPTION) + 20.0);
    svg.finish(title, subtitle)
}

/// A view along one axis.
struct ArmView {
    axes: [usize; 2],
    corner: [f64; 2],
    /// Half the width, m.
    half_m: f64,
}

impl ArmView {
    fn new(body: &ArmBody, axes: [usize; 2], corner: [f64; 2]) -> Self {
        Self {
            axes,
            corner,
            half_m: 1.05 * body.reach_m(),
        }
    }

    fn at(&self, point_m: Vector) -> [f64; 2] {
        let [x, y] = self.axes.map(|axis| point_m[axis] / self.half_m);
        let [left, top] = self.corner;
        [left + SIDE / 2.0 * (1.0 + x), top + SIDE / 2.0 * (1.0 - y)]
    }

    fn draw(&self, svg: &mut Svg, body: &ArmBody, way: &Trajectory) {
        let [left, top] = self.corner;
        svg.rect([left, top, SIDE, SIDE], &stroke(PALE, 1.0));
        if let Some(region) = way.region {
            // From values to meters.
            let width_m = 2.0 * body.reach_m();
            let center_m = region.center.map(|part| (part - 0.5) * width_m);
            let radius = region.radius * width_m / self.half_m * SIDE / 2.0;
            svg.circle(self.at(center_m), radius, &filled("#dfe3e7", GRAY, 1.0));
        }
        let last = way.postures.len().saturating_sub(1);
        for (index, angles) in way.postures.iter().enumerate() {
            let chain: Vec<_> = body
                .chain_m(angles)
                .iter()
                .map(|end| self.at(*end))
                .collect();
            let style = match index {
                0 => stroke(GRAY, 3.0),
                _ if index == last => stroke(INK, 4.0),
                _ => stroke(PALE, 1.0),
            };
            svg.polyline(&chain, &style);
        }
        let hands = way
            .postures
            .iter()
            .map(|angles| self.at(body.hand_m(angles)));
        let hands: Vec<_> = hands.collect();
        svg.polyline(&hands, &stroke(BLUE, 2.0));
        for hand in &hands {
            svg.circle(*hand, 3.0, &fill(BLUE));
        }
        svg.circle(self.at([0.0; 3]), 4.5, &fill(INK));
        svg.circle(self.at(way.target_m), 7.0, &stroke(VERMILLION, 2.5));
        let [right, up] = self.axes.map(|axis| AXES[axis]);
        let font = Font::new(11.0).color(GRAY);
        let caption = format!(
            "{right} to the right, {up} up; {:.1} m wide",
            2.0 * self.half_m
        );
        svg.text([left + 2.0, top + SIDE + 13.0], font, &caption);
        let moves = format!("{last} moves");
        svg.text(
            [left + SIDE - 2.0, top + SIDE + 13.0],
            font.at(Anchor::End),
            &moves,
        );
    }
}

fn legend(svg: &mut Svg, y: f64) {
    let font = Font::new(12.0);
    let mut x = MARGIN;
    let mut entry = |svg: &mut Svg, text: &str, draw: &dyn Fn(&mut Svg, f64)| {
        draw(svg, x);
        svg.text([x + 30.0, y + 4.0], font, text);
        x += 44.0 + 6.6 * text.chars().count() as f64;
    };
    let line = |style: String| move |svg: &mut Svg, x: f64| svg.line([x, y], [x + 24.0, y], &style);
    entry(svg, "arm before", &line(stroke(GRAY, 3.0)));
    entry(svg, "arm at the end", &line(stroke(INK, 4.0)));
    entry(svg, "hand, a dot per move", &line(stroke(BLUE, 2.0)));
    entry(svg, "target", &|svg: &mut Svg, x: f64| {
        svg.circle([x + 12.0, y], 7.0, &stroke(VERMILLION, 2.5));
    });
    entry(svg, "region to be avoided", &|svg: &mut Svg, x: f64| {
        svg.circle([x + 12.0, y], 9.0, &filled("#dfe3e7", GRAY, 1.0));
    });
}

/// Ends of the axis of angle errors, as powers of ten of a degree.
const FROM_DECADE: f64 = -2.0;
const TO_DECADE: f64 = 2.0;
/// Height of a method and width of its name, px.
const LANE: f64 = 46.0;
const NAME: f64 = 270.0;

/// Draws the angle errors of each method on a logarithmic axis.
///
/// Returns an SVG document.
#[must_use]
pub fn pointing(methods: &[(&str, Vec<f64>)]) -> String {
    let height = TOP + LANE * methods.len() as f64 + 40.0;
    let mut svg = Svg::new(PAGE, height);
    let title = "Pointing at what the eye looks at, after 100 random moves";
    let subtitle = "Angle error, degrees, by method: median (dot), half of the targets (bar), 90 %                     of them (line)";
    heading(&mut svg, title, subtitle);
    let left = MARGIN + NAME;
    let width = PAGE - MARGIN - left - 20.0;
    let at = |error_deg: f64| {
        let decade = libm::log10(error_deg.max(1e-9)).clamp(FROM_DECADE, TO_DECADE);
        left + width * (decade - FROM_DECADE) / (TO_DECADE - FROM_DECADE)
    };
    let bottom = TOP + LANE * methods.len() as f64;
    let small = Font::new(11.0).color(GRAY).at(Anchor::Middle);
    for (error_deg, label) in [
        (0.01, "≤ 0.01°"),
        (0.1, "0.1°"),
        (1.0, "1°"),
        (10.0, "10°"),
        (100.0, "100°"),
    ] {
        svg.line(
            [at(error_deg), TOP],
            [at(error_deg), bottom],
            &stroke(PALE, 1.0),
        );
        svg.text([at(error_deg), bottom + 16.0], small, label);
    }
    for (lane, (name, errors_deg)) in methods.iter().enumerate() {
        let y = TOP + LANE * (lane as f64 + 0.5);
        svg.text([MARGIN, y + 4.0], Font::new(12.0), name);
        let mut sorted = errors_deg.clone();
        sorted.sort_by(f64::total_cmp);
        let quantile = |share: f64| {
            let index = (share * sorted.len().saturating_sub(1) as f64) as usize;
            at(sorted.get(index).copied().unwrap_or(0.0))
        };
        svg.line([quantile(0.05), y], [quantile(0.95), y], &stroke(BLUE, 1.5));
        let (low, high) = (quantile(0.25), quantile(0.75));
        svg.rect([low, y - 6.0, high - low, 12.0], &fill(BLUE));
        svg.circle([quantile(0.5), y], 5.0, &filled("#ffffff", INK, 1.5));
    }
    svg.finish(title, subtitle)
}
