//! The panels of an avoidance sequence: per decision three bar charts with a bar per transducer.

use core::f64::consts::{FRAC_PI_2, PI};

use crate::draw::color::{BLUE, GRAY, PALE, VALUE, VERMILLION};
use crate::draw::layout::axis_end;
use crate::draw::rosette::nearest;
use crate::draw::svg::{Anchor, Font, Svg, fill};

/// Content of one panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Headline.
    pub title: String,
    /// Present situation, values in [0, 1].
    pub situation: Vec<f64>,
    /// Measured change since the previous decision.
    pub measured: Vec<f64>,
    /// Change wanted at the previous decision; the reason in words if there is none.
    pub wanted: Result<Vec<f64>, &'static str>,
}

/// Height of one panel, px.
pub const HEIGHT: f64 = 250.0;
/// Distance of panels, px.
pub const PITCH: f64 = 183.0;
/// Space for the axes left of the first panel, px.
pub const AXES: f64 = 52.0;
/// Width of the charts of one panel, px.
const WIDTH: f64 = 172.0;

/// The three charts of a panel: top (px below the panel's) and height.
const SITUATION: [f64; 2] = [24.0, 44.0];
const MEASURED: [f64; 2] = [82.0, 58.0];
const WANTED: [f64; 2] = [154.0, 58.0];

/// Limits of the axes of all panels: situations, measured and wanted changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ends {
    /// Value at the top of the situations.
    pub situation: f64,
    /// Largest measured difference up and down.
    pub measured: f64,
    /// Largest wanted difference up and down.
    pub wanted: f64,
}

impl Ends {
    /// Round values that include all values of the panels.
    pub fn holding(panels: &[Panel]) -> Self {
        let wanted = panels.iter().filter_map(|panel| panel.wanted.as_ref().ok());
        Self {
            situation: axis_end(panels.iter().flat_map(|panel| &panel.situation)),
            measured: axis_end(panels.iter().flat_map(|panel| &panel.measured)),
            wanted: axis_end(wanted.flatten()),
        }
    }
}

/// Draws the charts of one panel with its top left corner at `corner`.
pub fn draw(svg: &mut Svg, corner: [f64; 2], panel: &Panel, ends: Ends, bearings: &[f64]) {
    let [x, y] = corner;
    svg.text([x, y + 14.0], Font::new(12.0).bold(), &panel.title);
    let full = ends.wanted;
    situation(
        svg,
        area(corner, SITUATION),
        &panel.situation,
        ends.situation,
    );
    changes(svg, area(corner, MEASURED), &panel.measured, ends.measured);
    match &panel.wanted {
        Ok(wanted) => changes(svg, area(corner, WANTED), wanted, full),
        Err(reason) => {
            changes(svg, area(corner, WANTED), &[], full);
            let font = Font::new(11.0).color(GRAY).at(Anchor::Middle);
            let middle = [x + WIDTH / 2.0, y + WANTED[0] + WANTED[1] / 2.0 - 8.0];
            svg.text(middle, font, reason);
        }
    }
    let below = [x, y + WANTED[0] + WANTED[1]];
    transducers(svg, below, panel.situation.len(), bearings);
}

/// Draws the numbers and names of the axes left of a panel at `corner`.
pub fn axes(svg: &mut Svg, corner: [f64; 2], ends: Ends) {
    let unit = [(0.0, ends.situation.to_string()), (1.0, "0".into())];
    numbers(svg, area(corner, SITUATION), &unit, "situation");
    let both = |full: f64| {
        [
            (0.0, format!("+{full}")),
            (0.5, "0".into()),
            (1.0, format!("−{full}")),
        ]
    };
    numbers(
        svg,
        area(corner, MEASURED),
        &both(ends.measured),
        "measured",
    );
    numbers(svg, area(corner, WANTED), &both(ends.wanted), "wanted");
}

fn area([x, y]: [f64; 2], [top, height]: [f64; 2]) -> [f64; 4] {
    [x, y + top, WIDTH, height]
}

fn situation(svg: &mut Svg, [x, y, width, height]: [f64; 4], values: &[f64], full: f64) {
    svg.rect([x, y, width, height], &fill("#f3f5f7"));
    for (i, &value) in values.iter().enumerate() {
        let tall = height * (value / full).clamp(0.0, 1.0);
        svg.rect(
            bar([x, y + height - tall, width, tall], i, values.len()),
            &fill(VALUE),
        );
    }
    svg.rect([x, y + height - 0.5, width, 1.0], &fill(GRAY));
}

fn changes(svg: &mut Svg, [x, y, width, height]: [f64; 4], values: &[f64], full: f64) {
    svg.rect([x, y, width, height], &fill("#f3f5f7"));
    let (zero, half) = (y + height / 2.0, height / 2.0);
    for (i, &value) in values.iter().enumerate() {
        let tall = half * (value / full).clamp(-1.0, 1.0);
        let color = if tall > 0.0 { VERMILLION } else { BLUE };
        svg.rect(
            bar(
                [x, zero - tall.max(0.0), width, tall.abs()],
                i,
                values.len(),
            ),
            &fill(color),
        );
    }
    svg.rect([x, zero - 0.5, width, 1.0], &fill(GRAY));
}

/// The bar of transducer `i` of `count` in a chart, with a small gap to its neighbors.
fn bar([x, y, width, height]: [f64; 4], i: usize, count: usize) -> [f64; 4] {
    let slot = width / count.max(1) as f64;
    [x + (i as f64 + 0.12) * slot, y, 0.76 * slot, height]
}

/// Numbers and named directions of the transducers below the charts.
fn transducers(svg: &mut Svg, [x, y]: [f64; 2], count: usize, bearings: &[f64]) {
    let slot = WIDTH / count.max(1) as f64;
    let font = Font::new(11.0).color(GRAY).at(Anchor::Middle);
    let named = [
        ("front", 0.0),
        ("left", FRAC_PI_2),
        ("back", PI),
        ("right", -FRAC_PI_2),
    ];
    let mut taken: Vec<usize> = Vec::new();
    for (name, bearing) in named {
        let Some(i) = nearest(bearings, bearing).filter(|i| *i < count && !taken.contains(i))
        else {
            continue;
        };
        taken.push(i);
        let middle = x + (i as f64 + 0.5) * slot;
        svg.rect([middle - 0.5, y, 1.0, 4.0], &fill(GRAY));
        svg.text([middle, y + 14.0], font, &i.to_string());
        svg.text([middle.max(x + 11.0), y + 26.0], font, name);
    }
    let last = count.saturating_sub(1);
    if count > 0 && !taken.contains(&last) {
        let middle = x + (last as f64 + 0.5) * slot;
        svg.rect([middle - 0.5, y, 1.0, 4.0], &fill(GRAY));
        svg.text([middle, y + 14.0], font, &last.to_string());
    }
}

/// Axis numbers (relative position from the top, text) and the name of the axis.
fn numbers(svg: &mut Svg, [x, y, _, height]: [f64; 4], marks: &[(f64, String)], name: &str) {
    let font = Font::new(11.0).color(GRAY).at(Anchor::End);
    for (place, text) in marks {
        let at = y + place * height;
        svg.rect([x - 4.0, at - 0.5, 4.0, 1.0], &fill(PALE));
        svg.text([x - 6.0, at + 4.0], font, text);
    }
    svg.text_upwards([x - 43.0, y + height / 2.0], Font::new(11.5), name);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_hold_every_bar() {
        let panel = |value: f64| Panel {
            title: String::new(),
            situation: vec![0.2],
            measured: vec![0.1, f64::NAN],
            wanted: Ok(vec![value]),
        };
        for (value, wanted) in [(0.05, 0.1), (0.2, 0.25), (-0.4, 0.5), (-1.0, 1.0)] {
            let ends = Ends::holding(&[panel(value)]);
            assert_eq!(
                ends,
                Ends {
                    situation: 0.25,
                    measured: 0.1,
                    wanted
                }
            );
        }
        let reason = Panel {
            wanted: Err("goal held"),
            ..panel(0.9)
        };
        assert_eq!(Ends::holding(&[reason]).measured, 0.1);
    }
}
