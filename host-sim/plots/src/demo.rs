//! Writes all pictures of one episode into a folder, with a page that explains them.

use files::error::BadInput;
use files::{save, unwritable};
use sim::recording::Recording;
use std::fs;
use std::path::{Path, PathBuf};

use super::page::{Figure, index_html};
use super::situation_map::MapMarks;
use super::{action_map, path, save_picture, sequence, situation_map};

/// Writes every picture of an episode as SVG and PNG, and `index.html` with them, into `dir`
/// (created if missing).
///
/// `summary` has (label, value) rows for the page, `next` has commands to try next. A file appears
/// under its name only when it is complete. Returns the files in the order of writing, `index.html`
/// last.
///
/// # Errors
/// The first file that cannot be written; earlier files stay.
pub fn write(
    dir: &Path,
    recording: &Recording,
    summary: &[(String, String)],
    next: &[&str],
) -> Result<Vec<PathBuf>, BadInput> {
    fs::create_dir_all(dir).map_err(|error| unwritable(dir, &error))?;
    let mut written = Vec::new();
    let mut figures = Vec::new();
    for (name, title, caption, svg) in pictures(recording) {
        written.extend(save_picture(dir, name, &svg)?);
        let caption = caption.iter().map(|&paragraph| paragraph.into()).collect();
        figures.push(Figure {
            file: format!("{name}.svg"),
            title: title.into(),
            caption,
        });
    }
    let title = format!(
        "Behavior “{}” in the world “{}”",
        recording.behavior,
        recording.world.name()
    );
    written.push(save(
        dir,
        "index.html",
        index_html(&title, summary, &figures, next).as_bytes(),
    )?);
    Ok(written)
}

type DemoPicture = (&'static str, &'static str, &'static [&'static str], String);

/// Name, title, caption and document of each picture, in the recommended order.
pub fn pictures(recording: &Recording) -> [DemoPicture; 4] {
    let plan = recording
        .seeking
        .iter()
        .rev()
        .find_map(|step| step.plan.as_ref());
    let marks = plan.map(MapMarks::from).unwrap_or_default();
    let ring = &recording.bearings_rad;
    [
        ("path", "The path through the world", PATH, path(recording)),
        (
            "situation-map",
            "What the robot has learned to recognize",
            SITUATION_MAP,
            situation_map(&recording.situation_map, ring, marks),
        ),
        (
            "action-map",
            "What the robot has learned to bring about",
            ACTION_MAP,
            action_map(&recording.change_map, &recording.actions_m, ring),
        ),
        (
            "sequence",
            "How the two maps decide",
            SEQUENCE,
            sequence(recording),
        ),
    ]
}

const PATH: &[&str] = &[
    "The world from above. The robot first makes random moves (purple), its only experience before \
     it gets a goal. Then it seeks the goal, a situation it should perceive, from S to F; the color \
     of the path shows the time.",
    "The robot has no rule for obstacles or turns: see where the path bends away from a wall before \
     the body could touch it.",
];
const SITUATION_MAP: &[&str] = &[
    "Each tile is one neuron of the situation map and represents a situation: the longer a bar, the \
     nearer the obstacle in that direction. The front of the ring points up, its left to the left.",
    "Neighboring neurons represent similar situations; a dark background marks a neuron that differs \
     from its neighbors. The goal is one of these neurons, and a path from tile to tile toward it is \
     a plan.",
];
const ACTION_MAP: &[&str] = &[
    "Each tile is one neuron of the action map: a change of situation and the displacement that \
     brings it. Bars outward: an obstacle comes nearer; bars inward: it moves away; the arrow is the displacement.",
    "Where learning went well, bars point outward on the arrow's side and inward behind it.",
];
const SEQUENCE: &[&str] = &[
    "A few decisions in a row. Looking one step ahead, the robot predicts the effect of each \
     direction with the action map, and takes the one whose predicted situation is nearest to the \
     goal. (In the presets with the paper's four steps it selects a neighbor of its present neuron \
     that is nearer to the goal, and the action map gives the displacement for the difference.)",
    "Compare the wanted change with the change measured after the move: they agree in direction \
     where the maps know the situation well.",
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::recording;

    #[test]
    fn everything_is_written_and_the_page_refers_to_it() {
        let dir = tempfile::tempdir().unwrap();
        let inner = dir.path().join("a/b");
        let files = write(
            &inner,
            &recording(),
            &[("seed".into(), "7".into())],
            &["cargo run"],
        )
        .unwrap();
        assert_eq!(files.len(), 9);
        assert!(
            files
                .iter()
                .all(|file| fs::metadata(file).unwrap().len() > 500)
        );
        assert_eq!(fs::read_dir(&inner).unwrap().count(), files.len());
        let page = fs::read_to_string(files.last().unwrap()).unwrap();
        for file in files
            .iter()
            .filter(|file| file.extension().unwrap() == "svg")
        {
            let name = file.file_name().unwrap().to_str().unwrap();
            assert!(page.contains(&format!("<img src=\"{name}\"")));
        }
    }

    #[test]
    fn the_file_that_cannot_be_written_is_named() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir(dir.path().join("path.svg")).unwrap();
        let error = write(dir.path(), &recording(), &[], &[]).unwrap_err();
        assert!(error.to_string().contains("path.svg"), "{error}");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "no leftovers");
    }
}
