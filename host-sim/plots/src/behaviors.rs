//! Draws the paths of several behaviors side by side.

use sim::recording::Recording;

use super::path::draw_path;
use crate::draw::color::GRAY;
use crate::draw::layout::{MARGIN, PAGE, TOP, heading, shortened, wrapped};
use crate::draw::scene::{self, SceneView};
use crate::draw::svg::{Font, Svg};

/// Panels in a row.
const COLUMNS: usize = 3;
/// Height of the captions of a row and the gap below them, px.
const CAPTIONS: f64 = 74.0;
/// Height limit of a panel, px.
const TALLEST: f64 = 250.0;

/// One behavior with its recording.
#[derive(Debug, Clone)]
pub struct ShownBehavior {
    /// Its name.
    pub name: String,
    /// One or two lines about it.
    pub about: String,
    /// The recorded episode.
    pub recording: Recording,
}

/// Draws the paths of behaviors as small multiples with their captions.
///
/// Returns an SVG document.
#[must_use]
pub fn behaviors(title: &str, shown: &[ShownBehavior]) -> String {
    let side = (PAGE - 2.0 * MARGIN) / COLUMNS as f64;
    let room = [side - 18.0, TALLEST];
    let view_at = |corner, shown: &ShownBehavior| {
        let corners = scene::extent(&shown.recording.world);
        SceneView::new(corners, corner, room)
    };
    let mut svg = Svg::new(PAGE, TOP);
    let subtitle = "S start · F end · N nest or sought place · L leader · purple: the random moves · color of the path: time";
    heading(&mut svg, title, subtitle);
    let mut top = TOP;
    for row in shown.chunks(COLUMNS) {
        let height = |shown: &ShownBehavior| view_at([0.0, 0.0], shown).size[1];
        let tallest = row.iter().map(height).fold(0.0, f64::max);
        svg.grow(top + tallest + CAPTIONS);
        for (column, shown) in row.iter().enumerate() {
            let left = MARGIN + column as f64 * side;
            let size = view_at([0.0, 0.0], shown).size;
            let corner = [left + (room[0] - size[0]) / 2.0, top + tallest - size[1]];
            draw_path(&mut svg, &view_at(corner, shown), &shown.recording);
            caption(&mut svg, [left, top + tallest], side, shown);
        }
        top += tallest + CAPTIONS;
    }
    svg.finish(title, subtitle)
}

fn caption(svg: &mut Svg, [x, y]: [f64; 2], side: f64, shown: &ShownBehavior) {
    let name = shortened(&shown.name, (side / 7.5) as usize);
    svg.text([x, y + 22.0], Font::new(13.0).bold(), &name);
    let lines = wrapped(&shown.about, (side / 6.2) as usize);
    for (number, line) in lines.iter().take(2).enumerate() {
        let at = [x, y + 38.0 + 15.0 * number as f64];
        svg.text(at, Font::new(11.5).color(GRAY), line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, recording};

    #[test]
    fn every_behavior_has_its_name_below() {
        let shown: Vec<_> = (0..4)
            .map(|i| ShownBehavior {
                name: format!("behavior-{i}"),
                about: "goes <here> & there".into(),
                recording: recording(),
            })
            .collect();
        let picture = behaviors("Behaviors", &shown);
        assert_well_formed(&picture);
        assert!((0..4).all(|i| picture.contains(&format!("behavior-{i}"))));
        assert_well_formed(&behaviors("none", &[]));
    }
}
