//! `host-sim plot`: what a sweep found.

mod pictures;

use super::output::prepare;
use super::{Failure, table};
use clap::Args;
use experiments::sweep::{Found, Key, Table, keys};
use files::error::BadInput;
use files::save;
use plots::{index_html, png};
use rayon::prelude::*;
use sim::statistics::Mean;
use std::io::Write;
use std::path::PathBuf;

/// Behaviors that are drawn.
const MAX_BEHAVIORS: usize = 8;

/// The `plot` command's flags.
#[derive(Debug, Clone, Args)]
pub struct PlotArgs {
    /// Results of `sweep` or `merge`, complete or not (.csv; .parquet needs a program built with --features parquet)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Folder for the pictures and their page
    #[arg(long, value_name = "DIR", default_value = "out/plot")]
    out: PathBuf,
}

/// Prints the table, and writes the pictures.
///
/// # Errors
/// A file that cannot be read or holds no episode, a folder that cannot be written.
pub fn plot(args: &PlotArgs, out: &mut impl Write) -> Result<(), Failure> {
    let results = Table::load(&args.file)?;
    if results.rows() == 0 {
        return Err(BadInput::file(&args.file, "holds no episode").into());
    }
    prepare(&args.out)?;
    let sweep = Sweep::of(&results);
    out.write_all(sweep.table().as_bytes())?;
    for name in &sweep.left_out {
        writeln!(out, "{name}: too many values to be told apart")?;
    }
    let mut figures = Vec::new();
    for (figure, svg) in pictures::pictures(&sweep) {
        save(&args.out, &figure.file, svg.as_bytes())?;
        let bitmap = figure.file.replace(".svg", ".png");
        let png =
            png::render(&svg, 2.0).map_err(|error| BadInput::new(format!("{bitmap}: {error}")))?;
        save(&args.out, &bitmap, &png)?;
        figures.push(figure);
    }
    let page = index_html(&sweep.title, &sweep.summary, &figures, &[]);
    let page = save(&args.out, "index.html", page.as_bytes())?;
    Ok(writeln!(out, "\nPictures: {}", page.display())?)
}

/// The episodes by behavior and by what varies.
struct Sweep<'t> {
    results: &'t Table,
    title: String,
    summary: Vec<(String, String)>,
    keys: Vec<Key>,
    left_out: Vec<String>,
    /// Name and unit of its measure, as they come in the results.
    behaviors: Vec<(String, String)>,
    /// By key, behavior and value.
    found: Vec<Vec<Vec<Option<Found>>>>,
}

impl<'t> Sweep<'t> {
    fn of(results: &'t Table) -> Self {
        let (mut keys, left_out) = keys(results);
        if keys.is_empty() {
            let (name, values) = ("all".to_owned(), vec!["all episodes".to_owned()]);
            keys.push(Key {
                name,
                values,
                of_row: vec![0; results.rows()],
            });
        }
        let (names, of_row) = results.texts("behavior");
        let (units, unit_of_row) = results.texts("success_unit");
        let unit = |behavior: usize| {
            let row = of_row.iter().position(|&of| of as usize == behavior)?;
            units.get(*unit_of_row.get(row)? as usize).cloned()
        };
        let behaviors = names.iter().enumerate();
        let behaviors =
            behaviors.map(|(place, name)| (name.clone(), unit(place).unwrap_or_default()));
        let behaviors: Vec<_> = behaviors.take(MAX_BEHAVIORS).collect();
        let of_value = |key: &Key, behavior: usize, value: usize| {
            let has = |row: usize| {
                key.of_row.get(row) == Some(&value)
                    && of_row.get(row).is_some_and(|&of| of as usize == behavior)
            };
            Found::of(results, has)
        };
        let of_key = |key: &Key| {
            let of_behavior = |behavior: usize| {
                let values = (0..key.values.len()).into_par_iter();
                values.map(|value| of_value(key, behavior, value)).collect()
            };
            (0..behaviors.len()).map(of_behavior).collect()
        };
        let found = keys.iter().map(of_key).collect();
        let header = results.header();
        let title = header.identity().trim_start_matches("host-sim ");
        let title = title.split(',').next().unwrap_or(title).to_owned();
        let summary = vec![
            ("results".to_owned(), header.identity().to_owned()),
            (
                "drawn".to_owned(),
                format!("{} of {} episodes", results.rows(), header.episodes()),
            ),
        ];
        Self {
            results,
            title,
            summary,
            keys,
            left_out,
            behaviors,
            found,
        }
    }

    fn table(&self) -> String {
        let heads = [
            "choice",
            "value",
            "behavior",
            "episodes",
            "without contact %",
            "success",
            "distance m",
        ];
        let mut rows = Vec::new();
        for (key, found) in self.keys.iter().zip(&self.found) {
            for (value, name) in key.values.iter().enumerate() {
                for ((behavior, _), found) in self.behaviors.iter().zip(found) {
                    if let Some(Some(found)) = found.get(value) {
                        let names = [&key.name, name, behavior].map(String::clone);
                        rows.push(names.into_iter().chain(figures(found)).collect());
                    }
                }
            }
        }
        table::plain(&heads, &rows, &[3, 4, 5, 6])
    }
}

/// As they stand in the table.
fn figures(found: &Found) -> [String; 4] {
    let with = |mean: Mean, factor: f64, digits: usize| {
        let [value, low, high] =
            [mean.mean, mean.interval[0], mean.interval[1]].map(|value| value * factor);
        format!("{value:.digits$} [{low:.digits$}, {high:.digits$}]")
    };
    let [_, low, middle, high, _] = found.distance_m;
    [
        found.episodes.to_string(),
        with(found.clean, 100.0, 1),
        with(found.success, 1.0, 4),
        format!("{middle:.1} ({low:.1}–{high:.1})"),
    ]
}
