//! Draws the code vectors of any map as bars.

use sim::recording::MapRecord;

use crate::draw::color::{BLUE, GRAY, INK, VALUE, VERMILLION};
use crate::draw::layout::{Legend, TOP, Tiles, heading, normalized, shortened};
use crate::draw::rosette::{corner, tile};
use crate::draw::svg::{Font, Svg, decimal, fill};

/// Largest number of listed component names.
const NAMES: usize = 20;

/// Draws the code vectors of a map trained on any data: one bar per component and neuron, all on
/// one scale.
///
/// Bars start at zero if the values span it, else at the smallest value. `names` are the
/// components' names, in order (may be empty).
///
/// Returns an SVG document.
#[must_use]
pub fn code_vectors(map: &MapRecord, names: &[String], title: &str) -> String {
    let tiles = Tiles::new(map.grid, map.code.len(), 76.0);
    let dimensions = map.code.iter().map(Vec::len).max().unwrap_or(0);
    let mut svg = Svg::new(tiles.page_width(), TOP + tiles.height() + 20.0);
    let subtitle = format!(
        "{} × {} neurons · {dimensions} components",
        map.grid[0], map.grid[1]
    );
    heading(&mut svg, title, &subtitle);
    let all: Vec<f64> = map.code.iter().flatten().copied().collect();
    let (_, [low, high]) = normalized(&all);
    let base = if low <= 0.0 && high >= 0.0 { 0.0 } else { low };
    for (i, code) in map.code.iter().enumerate() {
        tile(&mut svg, tiles.tile(i), i, "#f3f5f7", &[]);
        let hits = map.hits.get(i).copied().unwrap_or(0);
        corner(&mut svg, tiles.tile(i), &hits.to_string());
        profile(&mut svg, tiles.tile(i), code, [low, base, high]);
    }
    legend(&mut svg, &tiles, [low, base, high], names, dimensions);
    svg.finish(title, &subtitle)
}

/// The bars of one neuron inside its tile.
fn profile(svg: &mut Svg, [x, y, side, _]: [f64; 4], code: &[f64], [low, base, high]: [f64; 3]) {
    let (left, top, width, height) = (x + 8.0, y + 24.0, side - 16.0, side - 32.0);
    let span = if high > low { high - low } else { 1.0 };
    let level = |value: f64| top + height * (high - value) / span;
    let slot = width / code.len().max(1) as f64;
    for (i, &value) in code.iter().enumerate() {
        let value = if value.is_finite() { value } else { base };
        let (from, to) = (level(value.max(base)), level(value.min(base)));
        let color = if value < base {
            BLUE
        } else {
            upwards(low, base)
        };
        let bar = [left + (i as f64 + 0.1) * slot, from, 0.8 * slot, to - from];
        svg.rect(bar, &fill(color));
    }
    svg.rect([left, level(base) - 0.5, width, 1.0], &fill(GRAY));
}

/// The color of bars above the base: neutral where there is nothing below it.
fn upwards(low: f64, base: f64) -> &'static str {
    if low < base { VERMILLION } else { VALUE }
}

fn legend(
    svg: &mut Svg,
    tiles: &Tiles,
    [low, base, high]: [f64; 3],
    names: &[String],
    dimensions: usize,
) {
    let mut legend = Legend::right_of(tiles.width());
    legend.headline(svg, "One tile = one neuron");
    legend.note(
        svg,
        "Bars: the components of its code vector, in order. Top right: how often the neuron won.",
    );
    let up = format!("from {} up to {}", decimal(base, 2), decimal(high, 2));
    legend.entry(svg, &up, |svg, [x, y]| {
        svg.rect([x - 5.0, y - 7.0, 10.0, 14.0], &fill(upwards(low, base)))
    });
    if low < base {
        let down = format!("from {} down to {}", decimal(base, 2), decimal(low, 2));
        legend.entry(svg, &down, |svg, [x, y]| {
            svg.rect([x - 5.0, y - 7.0, 10.0, 14.0], &fill(BLUE))
        });
    }
    legend.note(svg, tiles.neighbors());
    if !names.is_empty() {
        component_names(svg, &mut legend, names, dimensions);
    }
}

fn component_names(svg: &mut Svg, legend: &mut Legend, names: &[String], dimensions: usize) {
    legend.skip(4.0);
    legend.headline(svg, "Components");
    for (i, name) in names.iter().take(NAMES.min(dimensions)).enumerate() {
        let name = shortened(name, 24);
        let at = legend.next_line(svg);
        svg.text(
            at,
            Font::new(11.5).color(INK),
            &format!("{}  {name}", i + 1),
        );
    }
    let more = dimensions.saturating_sub(NAMES);
    if more > 0 {
        legend.note(svg, &format!("and {more} more"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, map};

    #[test]
    fn every_neuron_is_drawn_once_with_all_its_bars() {
        let map = map([6, 5], 7, -0.5);
        let names: Vec<String> = (0..7).map(|i| format!("<{i}>")).collect();
        let picture = code_vectors(&map, &names, "any data");
        assert_well_formed(&picture);
        assert!(picture.contains("&lt;6&gt;"));
        for i in 1..=30 {
            assert_eq!(picture.matches(&format!(">N{i}</text>")).count(), 1);
        }
    }

    #[test]
    fn constant_missing_and_infinite_values_are_drawn() {
        let mut map = map([2, 2], 3, 0.0);
        map.code = vec![vec![2.0; 3], vec![], vec![f64::INFINITY; 3], vec![2.0]];
        assert_well_formed(&code_vectors(&map, &[], "strange"));
        map.code.clear();
        assert_well_formed(&code_vectors(&map, &[], "nothing"));
    }
}
