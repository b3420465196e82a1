//! Draws the situation map: the code vector of each neuron (Fig. 2 of the paper).

use sim::recording::{MapRecord, PlanTrace};

use crate::draw::color::{self, BLUE, ORANGE};
use crate::draw::layout::{Legend, TOP, Tiles, axis_end, heading, normalized, u_matrix_legend};
use crate::draw::rosette::{Rosette, corner, tile};
use crate::draw::svg::{Svg, fill, stroke};

/// Marked neurons of a map, by index from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MapMarks {
    /// The goal neuron.
    pub goal: Option<usize>,
    /// The neuron of the present situation.
    pub current: Option<usize>,
}

impl From<&PlanTrace> for MapMarks {
    fn from(plan: &PlanTrace) -> Self {
        Self {
            goal: Some(plan.goal_neuron),
            current: Some(plan.current_neuron),
        }
    }
}

/// Draws a situation map with a rosette per neuron over the U-matrix.
///
/// One bar per transducer at its bearing (rad, front up the page), bar length = value; with labels
/// N1, N2, …, hits and marks.
///
/// Works for any grid and any number of transducers. Returns an SVG document.
#[must_use]
pub fn situation_map(map: &MapRecord, bearings_rad: &[f64], marks: MapMarks) -> String {
    let tiles = Tiles::new(map.grid, map.code.len(), 76.0);
    let mut svg = Svg::new(tiles.page_width(), TOP + tiles.height() + 20.0);
    let title = "Situation map: what each neuron has learned to recognize";
    let subtitle = format!(
        "{} × {} neurons · {} transducers · the front of the ring is up",
        map.grid[0],
        map.grid[1],
        bearings_rad.len()
    );
    heading(&mut svg, title, &subtitle);
    let full = axis_end(map.code.iter().flatten());
    let (shades, ends) = normalized(&map.u_matrix);
    for (i, code) in map.code.iter().enumerate() {
        let shade = color::tint(shades.get(i).copied().unwrap_or(0.0));
        let rosette = tile(&mut svg, tiles.tile(i), i, &shade, bearings_rad);
        rosette.values(&mut svg, code, full);
        if marks.current == Some(i) {
            rosette.fill_hub(&mut svg, BLUE);
        }
        if marks.goal == Some(i) {
            goal_frame(&mut svg, tiles.tile(i));
        }
        corner(&mut svg, tiles.tile(i), &hits(map, i, tiles.side()));
    }
    let mut legend = Legend::right_of(tiles.width());
    ring_legend(&mut legend, &mut svg, bearings_rad, full);
    u_matrix_legend(&mut legend, &mut svg, ends);
    marks_legend(&mut legend, &mut svg, marks);
    legend.note(&mut svg, tiles.neighbors());
    svg.finish(title, &subtitle)
}

fn hits(map: &MapRecord, index: usize, side: f64) -> String {
    let hits = map.hits.get(index).copied().unwrap_or(0);
    match (hits, side > 90.0) {
        (1, true) => "1 hit".into(),
        (_, true) => format!("{hits} hits"),
        (_, false) => format!("{hits}"),
    }
}

fn goal_frame(svg: &mut Svg, [x, y, w, h]: [f64; 4]) {
    svg.rect([x + 2.0, y + 2.0, w - 4.0, h - 4.0], &stroke(ORANGE, 3.5));
}

fn ring_legend(legend: &mut Legend, svg: &mut Svg, bearings: &[f64], full: f64) {
    legend.headline(svg, "One tile = one neuron");
    let (x, _) = legend.column();
    let rosette = Rosette {
        center: [x, legend.bottom() + 64.0],
        radius: 40.0,
        bearings,
    };
    // An example with one long bar in front fading to both sides.
    let example: Vec<f64> = bearings
        .iter()
        .map(|&b| (1.6 * libm::cos(b) - 0.6).max(0.0))
        .collect();
    rosette.values(svg, &example, 1.0);
    rosette.annotate(svg);
    legend.skip(136.0);
    let scale = format!(
        "Bar length: value of the transducer, 0 at the inner circle (nothing near), {full} at the outer one; \
         1 is the near limit."
    );
    legend.note(svg, &scale);
    legend.note(svg, "Hits: how often the neuron won.");
    legend.skip(4.0);
}

fn marks_legend(legend: &mut Legend, svg: &mut Svg, marks: MapMarks) {
    if marks.goal.is_some() {
        legend.entry(svg, "goal neuron", |svg, [x, y]| {
            goal_frame(svg, [x - 12.0, y - 11.0, 24.0, 22.0]);
        });
    }
    if marks.current.is_some() {
        legend.entry(svg, "neuron of the last situation", |svg, at| {
            svg.circle(at, 8.0, &fill(BLUE))
        });
    }
    if marks != MapMarks::default() {
        legend.skip(4.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{assert_well_formed, map, ring};

    #[test]
    fn every_neuron_of_any_grid_is_drawn_once() {
        for (grid, sensors) in [
            ([4, 4], 16),
            ([1, 32], 8),
            ([32, 1], 8),
            ([6, 5], 24),
            ([1, 1], 16),
        ] {
            let picture = situation_map(
                &map(grid, sensors, 0.0),
                &ring(sensors),
                MapMarks::default(),
            );
            assert_well_formed(&picture);
            for i in 1..=grid[0] * grid[1] {
                assert_eq!(
                    picture.matches(&format!(">N{i}</text>")).count(),
                    1,
                    "N{i} of {grid:?}"
                );
            }
        }
    }

    #[test]
    fn marks_outside_the_map_are_left_out() {
        let marks = MapMarks {
            goal: Some(99),
            current: Some(16),
        };
        assert_well_formed(&situation_map(&map([4, 4], 16, 0.0), &ring(16), marks));
    }

    #[test]
    fn an_incomplete_map_does_not_stop_the_picture() {
        let mut map = map([4, 4], 16, 0.0);
        map.hits.clear();
        map.u_matrix = vec![f64::NAN; 3];
        map.code[2] = vec![f64::NAN; 5];
        let picture = situation_map(&map, &[], MapMarks::default());
        assert_well_formed(&picture);
        map.code.clear();
        assert_well_formed(&situation_map(&map, &ring(16), MapMarks::default()));
    }
}
