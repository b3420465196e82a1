//! Draws the values of a decision as a table below its flow.

use crate::paper::decision::DecisionFigure;

use plots::draw::color::{BLUE, GRAY, PALE, VERMILLION};
use plots::draw::layout::{Legend, PAGE};
use plots::draw::svg::{Anchor, Font, Svg, decimal, fill};

/// Height of the rows and width of the columns, px.
const ROW: f64 = 18.0;
const COLUMN: f64 = 43.0;
/// Space for the letters, px.
const LETTERS: f64 = 66.0;

/// Draws a row per letter, a column per transducer.
pub fn table(svg: &mut Svg, [x, y]: [f64; 2], shown: &DecisionFigure) {
    let font = Font::new(11.0).color(GRAY).at(Anchor::End);
    svg.text([x, y], Font::new(11.0).color(GRAY), "transducer");
    let right = |i: usize| x + LETTERS + COLUMN * (i as f64 + 1.0) - 4.0;
    for i in 0..shown.present.len() {
        svg.text([right(i), y], font, &i.to_string());
    }
    svg.rect(
        [
            x,
            y + 6.0,
            LETTERS + COLUMN * shown.present.len() as f64,
            1.0,
        ],
        &fill(PALE),
    );
    let rows = [
        ("D", &shown.present),
        ("E ≤", &shown.goal),
        ("F", &shown.aim),
        ("G", &shown.wanted),
    ];
    for (row, (letter, values)) in rows.into_iter().enumerate() {
        let line = y + ROW * (row as f64 + 1.0) + 5.0;
        svg.text([x, line], Font::new(12.0).bold(), letter);
        for (i, &value) in values.iter().enumerate() {
            let font = Font::new(11.5).at(Anchor::End);
            let font = match value {
                v if v > 0.005 && letter == "G" => font.color(VERMILLION),
                v if v < -0.005 => font.color(BLUE),
                v if v.abs() <= 0.005 => font.color(GRAY),
                _ => font,
            };
            svg.text([right(i), line], font, &decimal(value, 2));
        }
    }
    let mut legend = Legend::new(x, y + 4.0 * ROW + 14.0, PAGE - 2.0 * x);
    legend.note(svg, &words(shown));
}

fn words(shown: &DecisionFigure) -> String {
    let [x, y] = shown.action_m.map(|m| decimal(100.0 * m, 1));
    let left_out = if shown.unmet_only {
        " G leaves out the transducers that already meet the goal."
    } else {
        ""
    };
    format!(
        "Transducer 0 looks ahead, 4 to the left.{left_out} The action: {x}\u{a0}cm ahead, {y}\u{a0}cm to the left (frame of the ring)."
    )
}
