//! Draws the action map: which action brings which change of situation.

use sim::recording::MapRecord;

use crate::draw::color::{self, BLUE, VERMILLION};
use crate::draw::layout::{Legend, TOP, Tiles, heading, normalized, u_matrix_legend};
use crate::draw::rosette::{Rosette, arrow, corner, tile};
use crate::draw::svg::{Svg, decimal, fill};

/// Draws an action map with one tile per neuron, over the U-matrix.
///
/// Bars show the change of situation from a zero circle (outward = increase) at the transducers'
/// bearings (rad, front up the page). An arrow shows the action (`actions_m`: meters in the ring
/// frame, x to the front, y to the left). Both are relative to the largest on the map.
///
/// Works for any grid and any number of transducers. Returns an SVG document.
#[must_use]
pub fn action_map(changes: &MapRecord, actions_m: &[[f64; 2]], bearings_rad: &[f64]) -> String {
    let tiles = Tiles::new(changes.grid, changes.code.len(), 76.0);
    let mut svg = Svg::new(tiles.page_width(), TOP + tiles.height() + 20.0);
    let title = "Action map: which displacement brings which change of situation";
    let subtitle = format!(
        "{} × {} neurons · {} transducers · the front of the ring is up",
        changes.grid[0],
        changes.grid[1],
        bearings_rad.len()
    );
    heading(&mut svg, title, &subtitle);
    let change = largest(changes.code.iter().flatten().map(|value| value.abs()));
    let reach = largest(actions_m.iter().map(length));
    let (shades, ends) = normalized(&changes.u_matrix);
    for (i, code) in changes.code.iter().enumerate() {
        let shade = color::tint(shades.get(i).copied().unwrap_or(0.0));
        let rosette = tile(&mut svg, tiles.tile(i), i, &shade, bearings_rad);
        rosette.changes(&mut svg, code, change);
        if let Some(action) = actions_m.get(i) {
            rosette.arrow(&mut svg, *action, reach);
            corner(
                &mut svg,
                tiles.tile(i),
                &format!("{} cm", decimal(100.0 * length(action), 1)),
            );
        }
    }
    legend(&mut svg, &tiles, bearings_rad, [change, reach], ends);
    svg.finish(title, &subtitle)
}

fn legend(
    svg: &mut Svg,
    tiles: &Tiles,
    bearings: &[f64],
    [change, reach]: [f64; 2],
    ends: [f64; 2],
) {
    let mut legend = Legend::right_of(tiles.width());
    legend.headline(svg, "One tile = one neuron");
    let (x, _) = legend.column();
    let rosette = Rosette {
        center: [x, legend.bottom() + 64.0],
        radius: 40.0,
        bearings,
    };
    // An example: forward, nearer to what is in front, away from what is behind.
    let example: Vec<f64> = bearings.iter().map(|&b| libm::cos(b)).collect();
    rosette.changes(svg, &example, 1.0);
    rosette.arrow(svg, [1.0, 0.0], 1.0);
    rosette.annotate(svg);
    legend.skip(136.0);
    let outward = format!("increase: an obstacle comes nearer; the outer circle is +{change:.2}");
    legend.entry(svg, &outward, |svg, at| bar(svg, at, -7.0, VERMILLION));
    let inward = format!("decrease: it moves away; −{change:.2} is as long inward");
    legend.entry(svg, &inward, |svg, at| bar(svg, at, 7.0, BLUE));
    let action = format!(
        "the displacement of the neuron; the longest arrow is {:.1}\u{a0}cm",
        100.0 * reach
    );
    legend.entry(svg, &action, |svg, [x, y]| {
        arrow(svg, [x, y + 10.0], 0.0, 20.0, 2.2);
    });
    legend.skip(6.0);
    u_matrix_legend(&mut legend, svg, ends);
    legend.note(svg, tiles.neighbors());
}

/// A bar from a zero line, `height` px downward.
fn bar(svg: &mut Svg, [x, y]: [f64; 2], height: f64, color: &str) {
    svg.rect(
        [x - 4.0, y + height.min(0.0), 8.0, height.abs()],
        &fill(color),
    );
    svg.rect([x - 9.0, y - 0.5, 18.0, 1.0], &fill(color::GRAY));
}

fn length(action: &[f64; 2]) -> f64 {
    libm::hypot(action[0], action[1])
}

/// The largest finite value, 0 if there is none.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.filter(|value| value.is_finite()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, map, recording, ring};

    #[test]
    fn every_neuron_is_drawn_once_with_its_length() {
        let recording = recording();
        let picture = action_map(
            &recording.change_map,
            &recording.actions_m,
            &recording.bearings_rad,
        );
        assert_well_formed(&picture);
        for i in 1..=16 {
            assert_eq!(picture.matches(&format!(">N{i}</text>")).count(), 1, "N{i}");
        }
        assert_eq!(picture.matches(" cm</text>").count(), 16);
    }

    #[test]
    fn actions_without_length_or_number_do_not_stop_the_picture() {
        let changes = map([2, 2], 8, -0.5);
        for action in [[0.0, 0.0], [f64::NAN, 1.0]] {
            let picture = action_map(&changes, &[action; 4], &ring(8));
            assert_well_formed(&picture);
            assert!(picture.contains(">0.0 cm</text>"));
        }
        assert_well_formed(&action_map(&changes, &[], &ring(8)));
        assert_well_formed(&action_map(&map([1, 1], 8, 0.0), &[[0.1, 0.0]], &ring(8)));
    }
}
