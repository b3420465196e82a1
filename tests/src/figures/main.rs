//! Writes `docs/FIGURES.md`: runs the commands of `tests/figures.toml` and extracts each figure.
//!
//! `cargo run -p tests --bin figures` measures everything (hours); arguments select commands and
//! groups that contain one of these words: `figures -- chip "cargo bench"`. Other rows keep their
//! value. The page is replaced after each command.

mod list;
mod measure;
mod page;

use list::{FigureList, FigureRow};
use measure::MeasurementSite;
use page::{MeasuredFigure, Page};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match write(&root(), &words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("figures: {why}");
            ExitCode::from(2)
        }
    }
}

/// The workspace's folder.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Measures what `words` select (everything without words) and replaces the page.
fn write(root: &Path, words: &[String]) -> Result<(), String> {
    let list = FigureList::read(&root.join("tests/figures.toml"))?;
    let page = root.join("docs/FIGURES.md");
    let old = std::fs::read_to_string(&page).unwrap_or_default();
    let mut measured = Page::parse(&old).measured;
    let chosen: Vec<_> = list.commands.iter().filter(|c| c.is_meant(words)).collect();
    if chosen.is_empty() {
        return Err(format!(
            "no command of tests/figures.toml contains {}",
            words.join(" or ")
        ));
    }
    let place = MeasurementSite::here(root)?;
    for (index, command) in chosen.iter().enumerate() {
        eprintln!("[{}/{}] {}", index + 1, chosen.len(), command.run);
        let output = measure::output(root, &command.run)?;
        for row in &command.row {
            let value = row.value(&output)?;
            eprintln!("        {}: {value}", row.what);
            measured.insert(row.what.clone(), place.measured(value, &command.run));
        }
        replace(
            &page,
            &Page {
                measured: still_listed(&list, &measured),
            }
            .text(&list),
        )?;
    }
    Ok(())
}

/// The measured figures whose row and command are still in the list.
fn still_listed(
    list: &FigureList,
    measured: &BTreeMap<String, MeasuredFigure>,
) -> BTreeMap<String, MeasuredFigure> {
    let asked = |(what, found): &(&String, &MeasuredFigure)| {
        let of = |row: &FigureRow, run: &str| row.what == **what && run == found.command;
        let commands = &list.commands;
        commands
            .iter()
            .any(|c| c.row.iter().any(|row| of(row, &c.run)))
    };
    let rows = measured.iter().filter(asked);
    rows.map(|(what, found)| (what.clone(), found.clone()))
        .collect()
}

/// Replaces the page atomically, by a temporary file.
fn replace(page: &Path, text: &str) -> Result<(), String> {
    let beside = page.with_extension("md.new");
    let failed = |error| format!("{}: {error}", page.display());
    std::fs::write(&beside, text).map_err(failed)?;
    std::fs::rename(&beside, page).map_err(failed)
}
