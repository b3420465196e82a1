//! All pictures of one episode in a folder, with a page that shows and explains them.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::files;
use crate::recording::Recording;

use super::page::{Figure, index_html};
use super::situation_map::MapMarks;
use super::{action_map, path, png, sequence, situation_map};

/// Pixels per page unit of the bitmaps.
pub(super) const PNG_SCALE: f32 = 2.0;

/// A file that could not be written, and why.
#[derive(Debug)]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    /// What went wrong.
    pub reason: io::Error,
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot write {}: {}", self.path.display(), self.reason)
    }
}

impl std::error::Error for WriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.reason)
    }
}

/// Writes every picture of an episode as SVG and PNG, and `index.html` with them, into `dir` (made if missing).
///
/// `summary` are (label, value) rows for the page, `next` commands to try next. Each file appears under its name only
/// when it is complete. Returns the files in the order they were written, `index.html` last.
///
/// # Errors
///
/// The first file that could not be written; those before it stay.
pub fn write(
    dir: &Path,
    recording: &Recording,
    summary: &[(String, String)],
    next: &[&str],
) -> Result<Vec<PathBuf>, WriteError> {
    fs::create_dir_all(dir).map_err(|reason| WriteError {
        path: dir.into(),
        reason,
    })?;
    let mut written = Vec::new();
    let mut figures = Vec::new();
    for (name, title, caption, svg) in pictures(recording) {
        let file = format!("{name}.svg");
        written.push(save(dir, &file, svg.as_bytes())?);
        let bitmap = format!("{name}.png");
        let png = png::render(&svg, PNG_SCALE).map_err(|error| WriteError {
            path: dir.join(&bitmap),
            reason: io::Error::other(error),
        })?;
        written.push(save(dir, &bitmap, &png)?);
        let caption = caption.iter().map(|&paragraph| paragraph.into()).collect();
        figures.push(Figure {
            file,
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

/// Writes one file into `dir` so that it is there completely or not at all; returns its path.
///
/// # Errors
///
/// When the file or its temporary neighbor cannot be written; an older file of that name stays as it was.
pub fn save(dir: &Path, name: &str, content: &[u8]) -> Result<PathBuf, WriteError> {
    let path = dir.join(name);
    match files::write(&path, content) {
        Ok(()) => Ok(path),
        Err(reason) => Err(WriteError { path, reason }),
    }
}

type Picture = (&'static str, &'static str, &'static [&'static str], String);

/// Name, title, caption and document of each picture, in the order a student should see them.
fn pictures(recording: &Recording) -> [Picture; 4] {
    let plan = recording
        .seeking
        .iter()
        .rev()
        .find_map(|step| step.plan.as_ref());
    let marks = plan.map(MapMarks::from).unwrap_or_default();
    let ring = &recording.bearings_rad;
    [
        ("path", "The way through the world", PATH, path(recording)),
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
    "The world from above. The robot first makes random moves (purple): that is all it ever learns from before it is \
     given a goal. Then it seeks the goal, a situation it should perceive, from S to F; the color of the path tells \
     the time.",
    "Nobody told the robot what an obstacle is or how to turn: look for places where the path bends away from a wall \
     before the body could touch it.",
];
const SITUATION_MAP: &[&str] = &[
    "Each tile is one neuron of the situation map and stands for a situation: the longer a bar, the nearer the \
     obstacle in that direction. The front of the ring points up, its left to the left.",
    "Neighboring neurons stand for similar situations; a dark background marks a neuron that differs from its \
     neighbors. The goal is one of these neurons, and a way from tile to tile towards it is a plan.",
];
const ACTION_MAP: &[&str] = &[
    "Each tile is one neuron of the action map: a change of situation and the displacement that brings it. Bars \
     outwards: something comes nearer there; bars inwards: it goes away; the arrow is the displacement.",
    "Where learning went well, bars point outwards on the arrow's side and inwards behind it.",
];
const SEQUENCE: &[&str] = &[
    "A few decisions in a row. Looking one step ahead, the robot asks the action map what each direction would change, \
     and takes the one whose situation to come is nearest to the goal. (In the presets that keep the paper's four steps it \
     picks a neighbor of its present neuron that is nearer to the goal and asks which displacement brings the difference.)",
    "Compare the change that was wanted with the change that was measured after the move: they agree in direction \
     where the maps know the situation well.",
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::fixture::recording;

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
