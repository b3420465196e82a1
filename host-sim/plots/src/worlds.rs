//! Draws small pictures of worlds side by side.

use core::f64::consts::FRAC_PI_2;

use arena::world::World;

use crate::draw::color::{GRAY, VERMILLION};
use crate::draw::layout::{MARGIN, PAGE, TOP, counted, heading, shortened};
use crate::draw::rosette::arrow;
use crate::draw::scene::{self, SceneView};
use crate::draw::svg::{Anchor, Font, Svg, decimal, filled};

/// Radius of the drawn robot, m.
const ROBOT_RADIUS_M: f64 = 0.23;
/// Height of the captions of a row and the gap below them, px.
const CAPTIONS: f64 = 62.0;

/// Draws worlds as small multiples, with name and size in meters below, the start pose as an arrow,
/// and a scale bar.
///
/// Returns an SVG document.
#[must_use]
pub fn worlds(title: &str, worlds: &[&World]) -> String {
    let columns = worlds.len().clamp(1, 4);
    let side = ((PAGE - 2.0 * MARGIN) / columns as f64).min(300.0);
    let drawing = side - 14.0;
    let heights: Vec<f64> = worlds
        .chunks(columns)
        .map(|row| tallest(row, drawing))
        .collect();
    let bottom: f64 = heights.iter().map(|height| height + CAPTIONS).sum();
    let mut svg = Svg::new(PAGE, TOP + bottom.max(30.0));
    let subtitle = format!(
        "{} · arrow: where the robot starts and the bearing of its ring",
        counted(worlds.len(), "world")
    );
    heading(&mut svg, title, &subtitle);
    let mut top = TOP;
    for (row, &height) in worlds.chunks(columns).zip(&heights) {
        for (i, &world) in row.iter().enumerate() {
            small(
                &mut svg,
                [MARGIN + i as f64 * side, top],
                [drawing, height],
                world,
            );
        }
        top += height + CAPTIONS;
    }
    svg.finish(title, &subtitle)
}

/// Height of the tallest drawing of a row if each is at most `side` px wide and high.
fn tallest(row: &[&World], side: f64) -> f64 {
    let height =
        |world: &&World| SceneView::new(scene::extent(world), [0.0, 0.0], [side, side]).size[1];
    row.iter().map(height).fold(0.0, f64::max)
}

/// One world centered in `room` px below `corner`, aligned with its captions.
fn small(svg: &mut Svg, [x, y]: [f64; 2], [side, height]: [f64; 2], world: &World) {
    let corners = scene::extent(world);
    let [wide, tall] = SceneView::new(corners, [x, y], [side, side]).size;
    let corner = [x + (side - wide) / 2.0, y + height - tall];
    let view = SceneView::new(corners, corner, [side, side]);
    scene::obstacles(svg, &view, world);
    let start = world.start();
    let at = view.at(start.position);
    let radius = (ROBOT_RADIUS_M * view.scale).max(3.5);
    svg.circle(at, radius, &filled("#ffffff", VERMILLION, 1.8));
    // Bearings on the page start at straight up, headings at the x axis.
    arrow(
        svg,
        at,
        start.heading - FRAC_PI_2,
        (2.4 * radius).max(16.0),
        2.0,
    );
    let middle = x + side / 2.0;
    let name = shortened(world.name(), (side / 7.0) as usize);
    svg.text(
        [middle, y + height + 19.0],
        Font::new(13.0).bold().at(Anchor::Middle),
        &name,
    );
    let size = corners[1] - corners[0];
    let meters = format!("{} m × {} m", decimal(size.x, 1), decimal(size.y, 1));
    svg.text([x, y + height + 37.0], Font::new(11.0).color(GRAY), &meters);
    scene::scale_bar(
        svg,
        [x + side * 0.58, y + height + 33.0],
        view.scale,
        side * 0.42 - 36.0,
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, recording};

    #[test]
    fn every_world_is_named() {
        let world = recording().world;
        let picture = worlds("Worlds & <more>", &[&world, &world]);
        assert_well_formed(&picture);
        assert_eq!(
            picture
                .matches(&format!(">{}</text>", world.name()))
                .count(),
            2
        );
        assert_well_formed(&worlds("none", &[]));
    }
}
