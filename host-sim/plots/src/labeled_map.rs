//! Draws a situation map whose neurons are labeled with the actions in their situations.

use core::f64::consts::TAU;

use sim::recording::MapRecord;

use crate::draw::color::{self, INK, PALE};
use crate::draw::layout::{Legend, MARGIN, PAGE, PLOT, TOP, heading, shortened};
use crate::draw::rosette::Rosette;
use crate::draw::svg::{Anchor, Font, Svg, decimal, fill, filled};

/// Smallest tile that holds a rosette, px.
const ROSETTE: f64 = 76.0;
/// Smallest tile that holds a number, px.
const NUMBER: f64 = 20.0;

/// A map and its labels.
#[derive(Debug, Clone, Copy)]
pub struct LabeledMap<'a> {
    /// The map, values from 0 (nothing near) to 1.
    pub map: &'a MapRecord,
    /// By neuron: shares of the classes, or mean velocities; `None` where nothing was won.
    pub labels: &'a [Option<Vec<f64>>],
    /// Names of the classes or of the velocities.
    pub components: &'a [String],
    /// By neuron: shares of the classes, or mean velocities; `None` for a neuron that won no
    /// sample.
    pub named: bool,
}

/// Draws a tile per neuron, colored by its most frequent action; a larger share gives a stronger
/// color.
///
/// Larger tiles hold the code vector as a rosette, the first component up and the others
/// counter-clockwise at equal steps. Velocities are numbers in the tiles.
///
/// Returns an SVG document.
#[must_use]
pub fn labeled_map(shown: &LabeledMap<'_>, title: &str) -> String {
    let [columns, rows] = shown.map.grid;
    let side = (PLOT / columns.max(1) as f64).min(150.0);
    let mut svg = Svg::new(PAGE, TOP + side * rows as f64 + MARGIN);
    let dims = shown.map.code.first().map_or(0, Vec::len);
    let order = if side >= ROSETTE {
        " · the first range is up, the others follow counter-clockwise"
    } else {
        ""
    };
    let subtitle = format!("{columns} × {rows} neurons · {dims} ranges{order}");
    heading(&mut svg, title, &subtitle);
    let bearings: Vec<f64> = (0..dims).map(|i| TAU * i as f64 / dims as f64).collect();
    for (index, code) in shown.map.code.iter().enumerate() {
        let (column, row) = (index % columns.max(1), index / columns.max(1));
        let corner = [MARGIN + column as f64 * side, TOP + row as f64 * side];
        let label = shown.labels.get(index).and_then(Option::as_ref);
        tile(&mut svg, corner, side, shown, label);
        if side >= ROSETTE {
            let [x, y] = corner;
            let rosette = Rosette {
                center: [x + side / 2.0, y + side / 2.0 + 9.0],
                radius: (side - 34.0) / 2.0,
                bearings: &bearings,
            };
            rosette.values(&mut svg, code, 1.0);
        }
    }
    legend(&mut svg, shown, side);
    svg.finish(title, &subtitle)
}

/// The most frequent class and its share.
fn prevailing(label: &[f64]) -> Option<(usize, f64)> {
    let of = label.iter().copied().enumerate();
    of.reduce(|best, other| if other.1 > best.1 { other } else { best })
}

fn tile(
    svg: &mut Svg,
    [x, y]: [f64; 2],
    side: f64,
    shown: &LabeledMap<'_>,
    label: Option<&Vec<f64>>,
) {
    svg.rect([x, y, side, side], &filled("#ffffff", PALE, 1.0));
    let Some(label) = label else { return };
    if shown.named {
        class_tile(svg, [x, y], side, shown, label);
        return;
    }
    let font = Font::new(11.0).color(INK);
    let rows = label.iter().enumerate().take((side / 13.0) as usize);
    for (row, value) in rows.filter(|_| side >= 2.0 * NUMBER) {
        svg.text(
            [x + 4.0, y + 13.0 + 12.0 * row as f64],
            font,
            &decimal(*value, 2),
        );
    }
}

/// Colors a tile by its most frequent class and names the class.
fn class_tile(svg: &mut Svg, [x, y]: [f64; 2], side: f64, shown: &LabeledMap<'_>, label: &[f64]) {
    let font = Font::new(11.0).color(INK);
    let Some((class, share)) = prevailing(label) else {
        return;
    };
    let strength = (0.25 + 0.6 * share).clamp(0.0, 0.85);
    let style = format!(
        r#"{} fill-opacity="{strength:.2}""#,
        fill(color::class(class))
    );
    svg.rect([x + 0.5, y + 0.5, side - 1.0, side - 1.0], &style);
    let name = shown.components.get(class).map_or("", String::as_str);
    if side >= ROSETTE {
        let text = format!(
            "{} {:.0}\u{a0}%",
            shortened(name, ((side - 40.0) / 6.0) as usize),
            100.0 * share
        );
        svg.text([x + 5.0, y + 14.0], font.halo(), &text);
    } else if side >= NUMBER {
        let middle = [x + side / 2.0, y + side / 2.0 + 4.0];
        svg.text(
            middle,
            font.at(Anchor::Middle).halo(),
            &(class + 1).to_string(),
        );
    }
}

fn legend(svg: &mut Svg, shown: &LabeledMap<'_>, side: f64) {
    let columns = shown.map.grid[0].max(1);
    let mut legend = Legend::right_of(side * columns as f64);
    legend.headline(svg, "One tile = one neuron");
    if side >= ROSETTE {
        legend.note(svg, "Bars: how near something is around the ring; the outer circle is 1, at the near limit.");
    }
    if shown.named {
        legend.note(svg, "Color: what was done most often in the learned situations the neuron won; the paler, the less it prevailed.");
        for (class, name) in shown.components.iter().enumerate().take(16) {
            let name = if side < ROSETTE {
                format!("{}  {name}", class + 1)
            } else {
                name.clone()
            };
            legend.entry(svg, &name, |svg, [x, y]| {
                svg.rect(
                    [x - 9.0, y - 6.0, 18.0, 12.0],
                    &filled(color::class(class), PALE, 1.0),
                );
            });
        }
    } else {
        let names = shown.components.join(", ");
        legend.note(
            svg,
            &format!("Numbers: mean {names} in the learned situations the neuron won."),
        );
    }
    legend.entry(svg, "won nothing", |svg, [x, y]| {
        svg.rect(
            [x - 9.0, y - 6.0, 18.0, 12.0],
            &filled("#ffffff", PALE, 1.0),
        );
    });
    legend.note(svg, "Tiles that share a side are neighbors in the map.");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, map};

    #[test]
    fn small_and_large_maps_of_classes_and_velocities_are_drawn() {
        let names = ["turn-left", "ahead"].map(str::to_owned);
        for (grid, named) in [
            ([4, 4], true),
            ([20, 20], true),
            ([4, 4], false),
            ([12, 5], false),
        ] {
            let map = map(grid, 24, 0.0);
            let mut labels = vec![Some(vec![0.25, 0.75]); map.code.len()];
            labels[3] = None;
            let shown = LabeledMap {
                map: &map,
                labels: &labels,
                components: &names,
                named,
            };
            let picture = labeled_map(&shown, "a map");
            assert_well_formed(&picture);
            assert!(picture.contains("ahead"));
        }
    }
}
