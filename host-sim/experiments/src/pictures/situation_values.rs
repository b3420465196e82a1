//! Draws the situations of a map with their values as numbers, for rings of few sensors (Fig. 2).

use crate::paper::miniature::Miniature;
use arena::world::Point;

use plots::draw::color::{self, GRAY, PURPLE};
use plots::draw::layout::{Legend, TOP, Tiles, heading, normalized, u_matrix_legend};
use plots::draw::rosette::Rosette;
use plots::draw::rosette::{corner, tile};
use plots::draw::scene::{self, SceneView};
use plots::draw::svg::{Anchor, Font, Svg, decimal, filled, stroke};

/// Numbers of two sensors with similar bearings are moved apart to this angle from the axis, rad.
const APART: f64 = 0.3;

/// Draws the 16 situations of the miniature robot's map, each value as a bar and a number, and the
/// path of its random moves.
///
/// Returns an SVG document.
#[must_use]
pub fn situation_values(title: &str, shown: &Miniature) -> String {
    let map = &shown.map;
    let tiles = Tiles::new(map.grid, map.code.len(), 100.0);
    let mut svg = Svg::new(tiles.page_width(), TOP + tiles.height() + 20.0);
    let subtitle = format!(
        "{} × {} neurons after {} random moves · {} sensors · the front of the robot is up",
        map.grid[0],
        map.grid[1],
        shown.exploration.steps,
        shown.bearings_rad.len()
    );
    heading(&mut svg, title, &subtitle);
    let (shades, ends) = normalized(&map.u_matrix);
    for (i, code) in map.code.iter().enumerate() {
        let shade = color::tint(shades.get(i).copied().unwrap_or(0.0));
        let whole = tile(&mut svg, tiles.tile(i), i, &shade, &shown.bearings_rad);
        let rosette = Rosette {
            radius: 0.62 * whole.radius,
            ..whole
        };
        rosette.values(&mut svg, code, 1.0);
        figures(&mut svg, &rosette, code);
        let hits = map.hits.get(i).copied().unwrap_or(0);
        let plural = if hits == 1 { "" } else { "s" };
        corner(&mut svg, tiles.tile(i), &format!("{hits} hit{plural}"));
    }
    let mut legend = Legend::right_of(tiles.width());
    explain_tiles(&mut svg, &mut legend, &tiles, ends);
    legend.skip(8.0);
    walk(&mut svg, &mut legend, shown);
    svg.finish(title, &subtitle)
}

fn explain_tiles(svg: &mut Svg, legend: &mut Legend, tiles: &Tiles, ends: [f64; 2]) {
    legend.headline(svg, "One tile = one neuron");
    legend.note(
        svg,
        "Bars and figures: the value of each sensor, 1 = an obstacle at 2\u{a0}cm or nearer, 0 = none within 5\u{a0}cm.",
    );
    legend.note(svg, "Hits: how many of the 100 situations it stands for.");
    u_matrix_legend(legend, svg, ends);
    legend.note(svg, tiles.neighbors());
}

/// The values around a rosette.
fn figures(svg: &mut Svg, rosette: &Rosette<'_>, values: &[f64]) {
    let radius = rosette.radius + 13.0;
    for (&bearing, &value) in rosette.bearings.iter().zip(values) {
        let (sin, cos) = libm::sincos(apart(bearing));
        let [x, y] = rosette.center;
        let at = [x - radius * sin, y - radius * cos + 4.0];
        let font = Font::new(11.0).at(Anchor::Middle);
        let font = if value < 0.05 {
            font.color(GRAY)
        } else {
            font.bold()
        };
        svg.text(at, font, &decimal(value, 1));
    }
}

/// The bearing of a number: farther from the axis where two sensors are close to each other.
fn apart(bearing: f64) -> f64 {
    use core::f64::consts::PI;
    if bearing.abs() < APART {
        libm::copysign(APART, bearing)
    } else if PI - bearing.abs() < APART {
        libm::copysign(PI - APART, bearing)
    } else {
        bearing
    }
}

/// The box with the path of the random moves.
fn walk(svg: &mut Svg, legend: &mut Legend, shown: &Miniature) {
    legend.headline(svg, "The random walk");
    let (middle, width) = legend.column();
    let corner = [middle - width / 2.0, legend.bottom() + 2.0];
    let view = SceneView::new(scene::extent(&shown.world), corner, [width, 200.0]);
    scene::obstacles(svg, &view, &shown.world);
    let places: Vec<_> = shown
        .walk
        .iter()
        .map(|pose| view.at(pose.position))
        .collect();
    svg.polyline(&places, &stroke(PURPLE, 1.4));
    if let Some(last) = shown.walk.last() {
        let at = view.at(last.position);
        let radius = shown.radius_m * view.scale;
        svg.circle(
            at,
            radius,
            &format!(r#"{} fill-opacity="0.7""#, filled("#ffffff", PURPLE, 1.6)),
        );
        let ahead = last.position + Point::unit(last.heading) * shown.radius_m;
        svg.line(at, view.at(ahead), &stroke(PURPLE, 1.6));
    }
    legend.skip(view.size[1] + 10.0);
    legend.note(
        svg,
        "The box is 30\u{a0}cm × 20\u{a0}cm; the circle: the robot's body at the end.",
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::miniature::walk;
    use crate::pictures::assert_well_formed;

    #[test]
    fn every_value_is_written() {
        let shown = walk(1).expect("the box");
        let picture = situation_values("Fig. 2", &shown);
        assert_well_formed(&picture);
        let figures = picture.matches("</text>").count();
        assert!(figures > 16 * 8 + 16, "{figures}");
    }

    #[test]
    fn figures_of_close_sensors_are_apart() {
        assert_eq!([0.17, -0.17, 1.0].map(apart), [0.3, -0.3, 1.0]);
        assert!((apart(-2.97) + 2.8416).abs() < 1e-3);
    }
}
