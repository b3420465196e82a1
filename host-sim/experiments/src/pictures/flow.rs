//! Draws one decision from the samples to the action, with its values (Fig. 3 of the paper).

use core::f64::consts::{FRAC_PI_2, PI};

use crate::paper::decision::DecisionFigure;

use super::flow_values as values;
use plots::draw::color::{BLUE, GRAY, INK, ORANGE, PALE, VERMILLION};
use plots::draw::layout::{Legend, MARGIN, PAGE, TOP, axis_end, heading};
use plots::draw::rosette::{Rosette, arrow};
use plots::draw::svg::{Anchor, Font, Svg, filled, stroke};

/// Left edges of the three columns, px: samples, first map, second map.
const COLUMNS: [f64; 3] = [MARGIN, 296.0, 550.0];
/// Side of a map's tile, px.
const TILE: f64 = 57.0;
/// Top of the maps, px.
const MAPS: f64 = TOP + 116.0;
/// Top of the row of situations, px.
const STEPS: f64 = MAPS + 4.0 * TILE + 40.0;
/// Distance of the situations in that row, px.
const PITCH: f64 = 152.0;

/// The bearings of the ring of 16.
fn ring() -> Vec<f64> {
    (0..16).map(|i| f64::from(i) * PI / 8.0).collect()
}

/// Draws the flow of the paper's Fig. 3 for one decision.
///
/// (A) samples, (B) and (C) what the two maps learn, the maps with the neurons involved, (D)
/// present situation, (E) goal, (F) subgoal, (G) wanted change, the action, and all values as
/// numbers.
///
/// Returns an SVG document.
#[must_use]
pub fn flow(shown: &DecisionFigure) -> String {
    let mut svg = Svg::new(PAGE, STEPS + 290.0);
    let title = format!("One decision with its values: preset “{}”", shown.preset);
    let subtitle = format!(
        "world “paper” · seed {} · decision {} · letters as in the paper's Fig. 3",
        shown.seed, shown.number
    );
    heading(&mut svg, &title, &subtitle);
    let ring = ring();
    samples(&mut svg, shown, &ring);
    bases(&mut svg, shown, &ring);
    maps(&mut svg, shown, &ring);
    steps(&mut svg, shown, &ring);
    values::table(&mut svg, [MARGIN, STEPS + 170.0], shown);
    svg.finish(&title, &subtitle)
}

fn rosette(center: [f64; 2], radius: f64, bearings: &[f64]) -> Rosette<'_> {
    Rosette {
        center,
        radius,
        bearings,
    }
}

fn title(svg: &mut Svg, at: [f64; 2], letter: &str, text: &str) {
    svg.text(at, Font::new(13.0).bold(), letter);
    svg.text([at[0] + 15.0, at[1]], Font::new(12.0), text);
}

/// The longest displacement shown, m.
fn longest<'a>(moves: impl Iterator<Item = &'a [f64; 2]>) -> f64 {
    moves.map(|[x, y]| libm::hypot(*x, *y)).fold(0.0, f64::max)
}

/// A: the lazy memory.
fn samples(svg: &mut Svg, shown: &DecisionFigure, ring: &[f64]) {
    let [x, ..] = COLUMNS;
    let memory = format!("lazy memory: {} samples", shown.memory);
    title(svg, [x, TOP + 4.0], "A", &memory);
    let font = Font::new(11.0).color(GRAY).at(Anchor::Middle);
    for (name, at) in [("S before", 34.0), ("action", 112.0), ("S after", 190.0)] {
        svg.text([x + at, TOP + 22.0], font, name);
    }
    let full = longest(shown.samples.iter().map(|sample| &sample.moved_m));
    for (row, sample) in shown.samples.iter().enumerate() {
        let y = TOP + 58.0 + 64.0 * row as f64;
        rosette([x + 34.0, y], 27.0, ring).values(svg, &sample.before, 1.0);
        rosette([x + 190.0, y], 27.0, ring).values(svg, &sample.after, 1.0);
        rosette([x + 112.0, y], 27.0, &[]).arrow(svg, sample.moved_m, full);
    }
    let below = TOP + 58.0 + 64.0 * shown.samples.len() as f64 - 18.0;
    let more = shown.memory.saturating_sub(shown.samples.len());
    svg.text(
        [x + 112.0, below],
        font,
        &format!("… and {more} more random moves"),
    );
    let mut legend = Legend::new(x, below + 10.0, 238.0);
    legend.note(
        svg,
        "Bars outward: nearness of obstacles around the ring, its front up. Red and blue: obstacles \
     that come nearer and move away. Arrows: displacements.",
    );
}

/// B and C: what the two maps learn.
fn bases(svg: &mut Svg, shown: &DecisionFigure, ring: &[f64]) {
    let [_, first, second] = COLUMNS;
    title(
        svg,
        [first, TOP + 4.0],
        "B",
        "learning base of the 1st map: S",
    );
    title(
        svg,
        [second, TOP + 4.0],
        "C",
        "of the 2nd map: change, action",
    );
    let changes: Vec<Vec<f64>> = shown
        .samples
        .iter()
        .map(|sample| {
            let pairs = sample.after.iter().zip(&sample.before);
            pairs.map(|(after, before)| after - before).collect()
        })
        .collect();
    let full = axis_end(changes.iter().flatten());
    let longest = longest(shown.samples.iter().map(|sample| &sample.moved_m));
    for (i, (sample, change)) in shown.samples.iter().zip(&changes).enumerate() {
        let (along, y) = (36.0 + 78.0 * i as f64, TOP + 46.0);
        rosette([first + along, y], 29.0, ring).values(svg, &sample.after, 1.0);
        let both = rosette([second + along, y], 29.0, ring);
        both.changes(svg, change, full);
        both.arrow(svg, sample.moved_m, longest);
    }
    base_arrows(svg);
}

/// Arrows from the samples to both learning bases, and on to the maps.
fn base_arrows(svg: &mut Svg) {
    let [from, first, second] = COLUMNS;
    arrow(svg, [from + 234.0, TOP + 46.0], -FRAC_PI_2, 32.0, 2.0);
    let style = stroke(INK, 2.0);
    let (above, edge) = (TOP - 12.0, second + 220.0);
    let line = [
        [from + 246.0, TOP + 46.0],
        [from + 246.0, above],
        [edge, above],
    ];
    svg.polyline(&line, &style);
    arrow(svg, [edge, above - 1.0], PI, 26.0, 2.0);
    for x in [first, second] {
        arrow(svg, [x + 2.0 * TILE, TOP + 77.0], PI, 18.0, 2.0);
    }
}

/// Both maps with the neurons of the decision.
fn maps(svg: &mut Svg, shown: &DecisionFigure, ring: &[f64]) {
    let [_, first, second] = COLUMNS;
    let [goal, present, aim, answer] = shown.neurons;
    let full = axis_end(shown.situations.iter().flatten());
    let most = axis_end(shown.changes.iter().flatten());
    let longest = longest(shown.actions_m.iter());
    let font = Font::new(11.5).color(GRAY);
    svg.text([first, MAPS - 7.0], font, "1st map: situations");
    svg.text([second, MAPS - 7.0], font, "2nd map: changes and actions");
    for (i, code) in shown.situations.iter().enumerate() {
        let [x, y] = tile(svg, first, i);
        let rosette = rosette([x, y], 23.0, ring);
        rosette.values(svg, code, full);
        if i == present {
            rosette.fill_hub(svg, BLUE);
        }
    }
    for (i, (code, action)) in shown.changes.iter().zip(&shown.actions_m).enumerate() {
        let [x, y] = tile(svg, second, i);
        let rosette = rosette([x, y], 23.0, ring);
        rosette.changes(svg, code, most);
        rosette.arrow(svg, *action, longest);
    }
    for (left, neuron, color, inset) in [
        (first, goal, ORANGE, 2.0),
        (first, present, BLUE, 5.0),
        (first, aim, VERMILLION, 2.0),
        (second, answer, INK, 2.0),
    ] {
        let [x, y] = center(left, neuron);
        let side = TILE - 2.0 * inset;
        let half = side / 2.0;
        svg.rect([x - half, y - half, side, side], &stroke(color, 3.0));
    }
}

fn center(left: f64, neuron: usize) -> [f64; 2] {
    let (column, row) = (neuron % 4, neuron / 4);
    [
        left + (column as f64 + 0.5) * TILE,
        MAPS + (row as f64 + 0.5) * TILE,
    ]
}

/// An empty tile; returns its center.
fn tile(svg: &mut Svg, left: f64, neuron: usize) -> [f64; 2] {
    let [x, y] = center(left, neuron);
    let half = TILE / 2.0;
    svg.rect(
        [x - half, y - half, TILE, TILE],
        &filled("#f3f5f7", "#ffffff", 2.0),
    );
    [x, y]
}

/// The row of situations: E, D, F, G and the action.
fn steps(svg: &mut Svg, shown: &DecisionFigure, ring: &[f64]) {
    svg.rect(
        [MARGIN, STEPS - 22.0, PAGE - 2.0 * MARGIN, 1.0],
        &filled(PALE, PALE, 0.0),
    );
    for (i, step) in step_cells(shown).iter().enumerate() {
        let x = MARGIN + PITCH * (i as f64 + 0.5);
        let center = [x, STEPS + 68.0];
        title(svg, [x - 62.0, STEPS], step.letter, step.name);
        let rosette = rosette(center, 46.0, ring);
        step_values(svg, shown, &rosette, i);
        if i < 3 {
            rosette.fill_hub(svg, step.color);
        }
        svg.text(
            [x, STEPS + 140.0],
            Font::new(11.5).at(Anchor::Middle),
            &step.note,
        );
        if (1..4).contains(&i) {
            arrow(svg, [x + 58.0, center[1]], -FRAC_PI_2, 30.0, 2.0);
        }
    }
}

/// Texts and color of one step.
struct StepCell {
    letter: &'static str,
    name: &'static str,
    note: String,
    color: &'static str,
}

fn step_cells(shown: &DecisionFigure) -> [StepCell; 5] {
    let [goal, present, aim, answer] = shown.neurons.map(|neuron| format!("N{}", neuron + 1));
    let cell = |letter, name, note, color| StepCell {
        letter,
        name,
        note,
        color,
    };
    let goal = format!("(1) stands for it: {goal}");
    let present = format!("(2) stands for it: {present}");
    let neighbor = format!("(3) neighbor: {aim}");
    let probe = "(4) probes the 2nd map".to_owned();
    [
        cell("E", "goal: at most", goal, ORANGE),
        cell("D", "present", present, BLUE),
        cell("F", "intermediate", neighbor, VERMILLION),
        cell("G", "F − D: wanted", probe, GRAY),
        cell("", "action", format!("answer: {answer}"), INK),
    ]
}

/// The values of a step as a rosette; those of the action as an arrow.
fn step_values(svg: &mut Svg, shown: &DecisionFigure, rosette: &Rosette<'_>, step: usize) {
    let full = axis_end(shown.present.iter().chain(&shown.aim));
    match step {
        0 => rosette.values(svg, &shown.goal, 1.0),
        1 => rosette.values(svg, &shown.present, full),
        2 => rosette.values(svg, &shown.aim, full),
        3 => rosette.changes(svg, &shown.wanted, axis_end(shown.wanted.iter())),
        _ => Rosette {
            radius: 90.0,
            ..*rosette
        }
        .arrow(svg, shown.action_m, longest([shown.action_m].iter())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::{decision::decision, readings};
    use crate::pictures::assert_well_formed;
    use arena::world::World;

    #[test]
    fn every_letter_of_the_figure_is_there() {
        let world = World::paper().expect("the arena");
        let shown = decision(&readings()[2], &world, 1).expect("a decision");
        let picture = flow(&shown);
        assert_well_formed(&picture);
        for letter in ["A", "B", "C", "D", "E", "F", "G"] {
            assert!(picture.contains(&format!(">{letter}</text>")), "{letter}");
        }
    }
}
