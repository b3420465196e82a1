//! Draws chains of neurons over points in space (Fig. 1 of the paper).

use crate::paper::chain::{Chain, Cloud, Point3};

use plots::draw::color::{GRAY, INK, ORANGE, PALE};
use plots::draw::layout::{MARGIN, PAGE, TOP, heading};
use plots::draw::svg::{Font, Svg, fill, filled, stroke};

/// Side of a panel, px.
const SIDE: f64 = 370.0;
/// Space for the caption below, px.
const CAPTION: f64 = 74.0;
/// Largest number of points drawn in a panel.
const POINTS: usize = 700;
/// Rotation about the vertical axis and elevation of the view, rad.
const TURN: f64 = 0.55;
const ABOVE: f64 = 0.35;

/// Draws chains side by side as the paper's Fig. 1: points, neurons as circles, lines between
/// neighbors in the chain, seen from slightly above.
///
/// Returns an SVG document.
#[must_use]
pub fn chains(title: &str, chains: [&Chain; 2]) -> String {
    let mut svg = Svg::new(PAGE, TOP + SIDE + CAPTION);
    let subtitle = "dots: points learned · circles: neurons · lines: neighbors in the chain · orange: a neuron outside the points";
    heading(&mut svg, title, subtitle);
    for (number, chain) in chains.into_iter().enumerate() {
        let left = MARGIN + number as f64 * (PAGE - 2.0 * MARGIN - SIDE);
        panel(&mut svg, [left, TOP], chain);
        caption(
            &mut svg,
            [left, TOP + SIDE + 22.0],
            ["(a)", "(b)"][number],
            chain,
        );
    }
    svg.finish(title, subtitle)
}

fn panel(svg: &mut Svg, corner: [f64; 2], chain: &Chain) {
    let at = |point: &Point3| place(corner, point);
    cube(svg, corner);
    for point in chain.points.iter().take(POINTS) {
        let style = format!(r#"{} fill-opacity="0.55""#, fill(GRAY));
        svg.circle(at(point), 1.1, &style);
    }
    let line: Vec<_> = chain.code.iter().map(at).collect();
    svg.polyline(&line, &stroke("#ffffff", 3.4));
    svg.polyline(&line, &stroke(INK, 1.6));
    for (place, point) in line.iter().zip(&chain.code) {
        let inside = chain.covers(point);
        let color = if inside { "#ffffff" } else { ORANGE };
        svg.circle(*place, 4.6, &filled(color, INK, 1.5));
    }
}

/// The edges of the unit cube.
fn cube(svg: &mut Svg, corner: [f64; 2]) {
    let bit = |number: usize, axis: usize| ((number >> axis) & 1) as f64;
    let vertex = |number: usize| [0, 1, 2].map(|axis| bit(number, axis));
    for from in 0..8 {
        for axis in 0..3 {
            let to = from | (1 << axis);
            if to != from {
                let ends = [vertex(from), vertex(to)].map(|end| place(corner, &end));
                svg.line(ends[0], ends[1], &stroke(PALE, 1.0));
            }
        }
    }
}

/// Position of a point of the unit cube on the page.
fn place([left, top]: [f64; 2], point: &Point3) -> [f64; 2] {
    let [x, y, z] = point.map(|value| value - 0.5);
    let (sin, cos) = libm::sincos(TURN);
    let (across, away) = (x * cos - y * sin, x * sin + y * cos);
    let (rise, fall) = (libm::cos(ABOVE), libm::sin(ABOVE));
    // The longest diagonal of the cube fills the panel.
    let scale = SIDE / 1.5;
    [
        left + SIDE / 2.0 + scale * across,
        top + SIDE / 2.0 - scale * (z * rise + away * fall),
    ]
}

fn caption(svg: &mut Svg, [x, y]: [f64; 2], letter: &str, chain: &Chain) {
    let hits = chain.relative_hits();
    let least = hits.iter().copied().fold(f64::INFINITY, f64::min);
    let most = hits.iter().copied().fold(0.0, f64::max);
    let what = match chain.cloud {
        Cloud::Uniform => "points anywhere in the cube",
        Cloud::Clusters => "points in two clusters",
        Cloud::Uneven => "points mostly in one half",
    };
    let neurons = chain.code.len();
    svg.text([x, y], Font::new(13.0).bold(), &format!("{letter} {what}"));
    let font = Font::new(11.5).color(GRAY);
    let share = format!(
        "each of {neurons} neurons wins {least:.2} to {most:.2} times 1/{neurons} of fresh points"
    );
    svg.text([x, y + 17.0], font, &share);
    let void = format!("{} of them outside the points", chain.in_the_void);
    svg.text([x, y + 33.0], font, &void);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pictures::assert_well_formed;

    #[test]
    fn all_neurons_are_drawn_and_the_cube_fits_its_panel() {
        let chain = Chain::trained(Cloud::Clusters, 1);
        let picture = chains("Fig. 1", [&chain, &chain]);
        assert_well_formed(&picture);
        assert_eq!(picture.matches(r#"r="4.6""#).count(), 2 * chain.code.len());
        assert_eq!(picture.matches(ORANGE).count(), 2 * chain.in_the_void);
        for number in 0..8 {
            let corner = [0, 1, 2].map(|axis| ((number >> axis) & 1) as f64);
            let [x, y] = place([0.0, 0.0], &corner);
            assert!(
                (0.0..=SIDE).contains(&x) && (0.0..=SIDE).contains(&y),
                "{x} {y}"
            );
        }
    }
}
