//! Writes all figures of the paper into a folder, with a page that explains them and lists the
//! claims.

use std::path::{Path, PathBuf};

use crate::paper::claims::Claim;
use crate::paper::measure::Measured;

use super::paper_page::paper_html;
use super::{chains, flow, situation_values};
use files::error::BadInput;
use files::save;
use plots::page::Figure;
use plots::{path, save_picture, sequence};

/// Writes every figure as SVG and PNG, and `index.html` with the claims, into the existing folder
/// `dir`.
///
/// A file appears under its name only when it is complete. Returns the files in the order of
/// writing, `index.html` last.
///
/// # Errors
/// The first file that cannot be written; earlier files stay.
pub fn write(
    dir: &Path,
    measured: &Measured,
    claims: &[Claim],
    next: &[&str],
) -> Result<Vec<PathBuf>, BadInput> {
    let mut written = Vec::new();
    let mut figures = Vec::new();
    for (name, title, caption, svg) in pictures(measured) {
        written.extend(save_picture(dir, name, &svg)?);
        figures.push(Figure {
            file: format!("{name}.svg"),
            title: title.into(),
            caption: caption.iter().map(|&paragraph| paragraph.into()).collect(),
        });
    }
    let html = paper_html(TITLE, &about(measured), claims, &figures, next);
    written.push(save(dir, "index.html", html.as_bytes())?);
    Ok(written)
}

const TITLE: &str = "The paper, claim by claim";

fn about(measured: &Measured) -> Vec<String> {
    let size = measured.size;
    vec![
        "C. Touzet, “Modeling and Simulation of Elementary Robot Behaviors using Associative Memories”, International Journal \
         of Advanced Robotic Systems 3(2), 2006, 165–170: its figures redrawn, and every testable \
     sentence of its sections 2, 3 and 5 measured. All by the maps alone, without the shield."
            .to_owned(),
        "Three readings of what the paper leaves open: touzet is the most literal one; probe the best found that keeps the \
         paper's four steps; default looks one step ahead instead of probing. A claim about the method holds when all \
     tested readings meet its rule, and partly when some do."
            .to_owned(),
        format!(
            "Seed {}; {} random rooms, {} worlds × {} seeds per behavior, {} repetitions, {} chains and miniature robots. The same \
             numbers give the same page, byte by byte.",
            size.seed, size.rooms, size.worlds, size.seeds, size.times, size.draws
        ),
    ]
}

type PaperFigure = (&'static str, &'static str, &'static [&'static str], String);

/// Name, title, caption and document of each figure.
fn pictures(measured: &Measured) -> Vec<PaperFigure> {
    let mut pictures = Vec::new();
    let drawn = measured.chains.each_ref().map(|chains| chains.first());
    if let [Some(uniform), Some(clusters), _] = drawn {
        let picture = chains(
            "A chain of 32 neurons over points in space",
            [uniform, clusters],
        );
        pictures.push((
            "figure-1",
            "Fig. 1: a chain of 32 neurons",
            FIGURE_1,
            picture,
        ));
    }
    if let Some(miniature) = measured.miniatures.first() {
        let picture = situation_values("Sixteen situations of a miniature robot", miniature);
        pictures.push((
            "figure-2",
            "Fig. 2: sixteen situations of a miniature robot",
            FIGURE_2,
            picture,
        ));
    }
    let [probe, touzet] = &measured.decisions;
    pictures.push((
        "figure-3",
        "Fig. 3: one decision with its values",
        FIGURE_3,
        flow(probe),
    ));
    let literal = "Fig. 3 in the most literal reading";
    pictures.push(("figure-3-literal", literal, FIGURE_3_LITERAL, flow(touzet)));
    let [probe, touzet] = &measured.episodes;
    pictures.push((
        "figure-4",
        "Fig. 4: a sequence of situations",
        FIGURE_4,
        sequence(probe),
    ));
    pictures.push((
        "figure-5",
        "Fig. 5: obstacle avoidance",
        FIGURE_5,
        path(probe),
    ));
    let literal = "Fig. 5 in the most literal reading";
    pictures.push(("figure-5-literal", literal, FIGURE_5_LITERAL, path(touzet)));
    pictures
}

const FIGURE_1: &[&str] = &[
    "The chain winds through the points so that each neuron represents about as many of them: (a) \
     points anywhere, (b) points in two clusters. A neuron between the clusters represents nothing; \
     the chain crosses there.",
];
const FIGURE_2: &[&str] = &[
    "What a robot of 55 mm with the eight bearings of a Khepera has learned from 100 random moves in a small box. The robot has \
     no turret: its ring turns with it. Look for neighbors that are alike.",
];
const FIGURE_3: &[&str] = &[
    "From the samples (A) come the learning bases of the two maps (B, C). For the decision: (1) the neuron of the goal E, (2) \
     that of the present situation D, (3) a neighbor nearer to the goal, F; (4) the difference G = F − D probes the second map, \
     which answers with the action.",
    "All values are from a real decision by preset probe, in the first episode from the given seed \
     on with a decision toward a neighbor with an obstacle on the left. Such decisions are rare in this preset (see § 2.5).",
];
const FIGURE_3_LITERAL: &[&str] = &[
    "The same by preset touzet: nothing nearer than 1 m is the goal, G is F − D in every component, and the action is a turn and \
     a step.",
];
const FIGURE_4: &[&str] = &[
    "Successive situations, their differences S(t) − S(t−1), and the robot's positions beside the obstacle in the box. Preset \
     probe; the part with the clearest avoidance is shown.",
];
const FIGURE_5: &[&str] = &[
    "An arena after the paper's figure, which has no scale. The robot explores with 100 random moves and then avoids for 300 \
     decisions by preset probe, without the shield.",
];
const FIGURE_5_LITERAL: &[&str] = &[
    "The same by the most literal reading of the paper, preset touzet. In most random rooms it has contacts \
     (see § 3).",
];
