//! Measures by two things at once.

use crate::draw::color::{self, GRAY, INK, PALE};
use crate::draw::layout::{MARGIN, PAGE, TOP, heading, normalized, shortened};
use crate::draw::svg::{Anchor, Font, Svg, decimal, filled};

/// Panels in a row.
const COLUMNS: usize = 3;
/// Width of the rows' labels, px.
const LABELS: f64 = 96.0;
/// Gap between panels, px.
const GAP: f64 = 14.0;
/// Height of a cell, px.
const CELL: f64 = 30.0;
/// Height of a section's title and its panels', px.
const TITLES: f64 = 44.0;
/// Longest label of a column, in characters.
const MAX_LETTERS: usize = 14;

/// One measure.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    /// Its name, with the unit.
    pub name: String,
    /// Decimals of the numbers in the cells.
    pub decimals: usize,
    /// Values by row and column; `None` where there are none.
    pub cells: Vec<Vec<Option<f64>>>,
}

/// What the rows or the columns of all panels stand for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeatAxis {
    /// What varies.
    pub name: String,
    /// Its values.
    pub labels: Vec<String>,
}

/// Draws sections of up to three heat maps each, on the same axes; bright is much, each panel with a scale of its own.
///
/// Returns an SVG document.
#[must_use]
pub fn heat_maps(
    title: &str,
    [down, along]: [&HeatAxis; 2],
    sections: &[(String, Vec<HeatMap>)],
) -> String {
    let subtitle = format!(
        "Rows: {} · columns: {} · dark is little, bright is much, within each panel",
        down.name, along.name
    );
    let width = (PAGE - 2.0 * MARGIN - LABELS - GAP * (COLUMNS - 1) as f64) / COLUMNS as f64;
    let width = width / along.labels.len().max(1) as f64;
    let letters = along
        .labels
        .iter()
        .map(|label| label.chars().count())
        .max()
        .unwrap_or(0);
    let upright = letters as f64 * 6.3 + 4.0 > width;
    let above = if upright {
        letters.min(MAX_LETTERS) as f64 * 6.2 + 10.0
    } else {
        18.0
    };
    let height = TITLES + above + down.labels.len() as f64 * CELL + 16.0;
    let mut svg = Svg::new(PAGE, TOP + height * sections.len() as f64 + 4.0);
    heading(&mut svg, title, &subtitle);
    for (index, (name, maps)) in sections.iter().enumerate() {
        let top = TOP + height * index as f64;
        svg.text(
            [MARGIN, top + 14.0],
            Font::new(13.0).bold(),
            &shortened(name, 112),
        );
        let cells = top + TITLES + above;
        for (row, label) in down.labels.iter().enumerate() {
            let at = [
                MARGIN + LABELS - 8.0,
                cells + (row as f64 + 0.5) * CELL + 4.0,
            ];
            let font = Font::new(11.5).color(INK).at(Anchor::End);
            svg.text(at, font, &shortened(label, MAX_LETTERS));
        }
        for (place, map) in maps.iter().take(COLUMNS).enumerate() {
            let panel = width * along.labels.len() as f64 + GAP;
            let left = MARGIN + LABELS + place as f64 * panel;
            svg.text(
                [left, top + 36.0],
                Font::new(12.0).color(GRAY),
                &shortened(&map.name, 32),
            );
            labels(&mut svg, [left, cells], width, upright, &along.labels);
            draw(&mut svg, [left, cells], width, map);
        }
    }
    svg.finish(title, &subtitle)
}

fn labels(svg: &mut Svg, [left, top]: [f64; 2], width: f64, upright: bool, labels: &[String]) {
    let font = Font::new(11.0).color(INK);
    for (column, label) in labels.iter().enumerate() {
        let middle = left + (column as f64 + 0.5) * width;
        let label = shortened(label, MAX_LETTERS);
        if upright {
            let length = label.chars().count() as f64 * 6.2;
            svg.text_upwards([middle + 4.0, top - 6.0 - length / 2.0], font, &label);
        } else {
            svg.text([middle, top - 6.0], font.at(Anchor::Middle), &label);
        }
    }
}

fn draw(svg: &mut Svg, [left, top]: [f64; 2], width: f64, map: &HeatMap) {
    let all: Vec<f64> = map
        .cells
        .iter()
        .flatten()
        .map(|cell| cell.unwrap_or(f64::NAN))
        .collect();
    let (mut places, [low, high]) = normalized(&all);
    if low == high {
        // All the same is neither little nor much.
        places.fill(0.5);
    }
    let mut places = places.into_iter();
    for (row, cells) in map.cells.iter().enumerate() {
        for (column, value) in cells.iter().enumerate() {
            let place = places.next().unwrap_or(0.0);
            let at = [left + column as f64 * width, top + row as f64 * CELL];
            match value {
                Some(value) => {
                    let text = decimal(*value, map.decimals);
                    let fits = text.chars().count() as f64 * 6.4 + 2.0 <= width;
                    cell(svg, at, [width, CELL], place, if fits { &text } else { "" });
                }
                None => svg.rect([at[0], at[1], width, CELL], &filled("#ffffff", PALE, 1.0)),
            }
        }
    }
}

/// A cell colored by its `place` in 0 … 1, with a text in its middle.
pub(super) fn cell(
    svg: &mut Svg,
    [x, y]: [f64; 2],
    [width, height]: [f64; 2],
    place: f64,
    text: &str,
) {
    svg.rect(
        [x, y, width, height],
        &filled(&color::value(place), "#ffffff", 1.5),
    );
    if !text.is_empty() {
        let font = Font::new(11.5)
            .color(color::text_on_value(place))
            .at(Anchor::Middle);
        svg.text([x + width / 2.0, y + height / 2.0 + 4.0], font, text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::assert_well_formed;

    fn axis(name: &str, labels: &[&str]) -> HeatAxis {
        let labels = labels.iter().map(|label| (*label).to_owned()).collect();
        HeatAxis {
            name: name.to_owned(),
            labels,
        }
    }

    #[test]
    fn every_value_stands_in_its_cell() {
        let map = HeatMap {
            name: "share <%>".to_owned(),
            decimals: 1,
            cells: vec![vec![Some(1.0), None], vec![Some(3.0), Some(2.0)]],
        };
        let axes = [
            &axis("far", &["1", "2"]),
            &axis("recall", &["direction", "a long projection"]),
        ];
        let sections = [("avoid".to_owned(), vec![map.clone(), map])];
        let picture = heat_maps("far and recall", axes, &sections);
        assert_well_formed(&picture);
        for (text, count) in [
            (">1.0<", 2),
            (">3.0<", 2),
            (">2.0<", 2),
            ("share &lt;%&gt;", 2),
        ] {
            assert_eq!(picture.matches(text).count(), count, "{text}");
        }
        assert!(picture.contains("a long projec…") && picture.contains("rotate(-90)"));
        assert_well_formed(&heat_maps("none", [&axis("a", &[]), &axis("b", &[])], &[]));
    }
}
