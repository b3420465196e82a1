//! Draws the U-matrix and the hit map of any map.

use sim::recording::MapRecord;

use crate::draw::color::{self, INK};
use crate::draw::layout::{Legend, TOP, Tiles, heading, normalized};
use crate::draw::svg::{Anchor, Font, Svg, decimal, filled};

/// Draws the U-matrix (cell color = mean distance of a neuron to its neighbors, units of the data)
/// and the hit map (circle area = number of samples that the neuron won) over the grid of a map.
///
/// Works for any grid and any data. Returns an SVG document.
#[must_use]
pub fn u_matrix(map: &MapRecord, title: &str) -> String {
    let tiles = Tiles::new(map.grid, map.code.len(), 22.0);
    let mut svg = Svg::new(tiles.page_width(), TOP + tiles.height() + 20.0);
    let total: usize = map.hits.iter().sum();
    let dimensions = map.code.first().map_or(0, Vec::len);
    let subtitle = format!(
        "{} × {} neurons · {dimensions} dimensions · {total} hits",
        map.grid[0], map.grid[1]
    );
    heading(&mut svg, title, &subtitle);
    let (places, [low, high]) = normalized(&map.u_matrix);
    let most = map.hits.iter().copied().max().unwrap_or(0);
    for i in 0..map.code.len() {
        let place = places.get(i).copied().unwrap_or(0.0);
        let hits = map.hits.get(i).copied().unwrap_or(0);
        cell(&mut svg, tiles.tile(i), i, place, [hits, most]);
        if let Some(&distance) = map.u_matrix.get(i) {
            foot(&mut svg, tiles.tile(i), place, distance);
        }
    }
    legend(&mut svg, &tiles, [low, high], most);
    svg.finish(title, &subtitle)
}

fn legend(svg: &mut Svg, tiles: &Tiles, [low, high]: [f64; 2], most: usize) {
    let mut legend = Legend::right_of(tiles.width());
    let ends = [decimal(low, 3), decimal(high, 3)];
    legend.ramp(
        svg,
        "Mean distance to neighbors",
        [&ends[0], &ends[1]],
        color::value,
    );
    legend.note(
        svg,
        "Dark: the neuron is like its neighbors. Bright: a border between regions.",
    );
    legend.skip(6.0);
    let area = if tiles.side() > 60.0 {
        "area and number"
    } else {
        "area"
    };
    let meaning = format!("circle {area}: hits, {most} at most");
    legend.entry(svg, &meaning, |svg, at| {
        svg.circle(at, 9.0, &filled("#ffffff", INK, 1.2))
    });
    legend.note(svg, tiles.neighbors());
}

fn cell(svg: &mut Svg, area: [f64; 4], index: usize, place: f64, [hits, most]: [usize; 2]) {
    let [x, y, side, _] = area;
    svg.rect(area, &filled(&color::value(place), "#ffffff", 1.5));
    let center = [x + side / 2.0, y + side / 2.0];
    let radius = (hits as f64 / most.max(1) as f64).sqrt()
        * (side / 2.0 - if side > 60.0 { 18.0 } else { 3.0 });
    if hits > 0 {
        svg.circle(center, radius.max(1.0), &filled("#ffffff", INK, 1.0));
    }
    if side > 60.0 {
        let color = color::text_on_value(place);
        svg.text(
            [x + 6.0, y + 14.0],
            Font::new(11.5).color(color),
            &format!("N{}", index + 1),
        );
        let inside = radius > 10.0;
        let font = Font::new(11.5)
            .at(Anchor::Middle)
            .color(if inside { INK } else { color });
        let below = if inside { 4.0 } else { radius + 12.0 };
        svg.text([center[0], center[1] + below], font, &hits.to_string());
    }
}

/// The distance as a number in the bottom right corner, if there is room.
fn foot(svg: &mut Svg, [x, y, side, _]: [f64; 4], place: f64, distance: f64) {
    if side > 60.0 && distance.is_finite() {
        let font = Font::new(11.0)
            .color(color::text_on_value(place))
            .at(Anchor::End);
        svg.text(
            [x + side - 6.0, y + side - 6.0],
            font,
            &decimal(distance, 2),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, map};

    #[test]
    fn every_neuron_is_drawn_once_on_any_grid() {
        for grid in [[4, 4], [1, 32], [1, 1], [6, 5]] {
            let picture = u_matrix(&map(grid, 3, 0.0), "a & b");
            assert_well_formed(&picture);
            for i in 1..=grid[0] * grid[1] {
                assert_eq!(
                    picture.matches(&format!(">N{i}</text>")).count(),
                    1,
                    "N{i} of {grid:?}"
                );
            }
        }
        assert_well_formed(&u_matrix(&map([30, 20], 3, 0.0), "large"));
    }

    #[test]
    fn maps_without_hits_or_distances_are_drawn() {
        let mut map = map([2, 2], 3, 0.0);
        map.hits = vec![0; 4];
        map.u_matrix.clear();
        assert_well_formed(&u_matrix(&map, ""));
    }
}
