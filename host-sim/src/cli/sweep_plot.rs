//! `host-sim plot`: draws the results of a sweep, one picture per option.

use super::output::prepare;
use super::{CliError, table};
use clap::Args;
use experiments::sweep::{ResultsTable, SweepOutcome, SweptChoice, Texts, swept_choices};
use files::error::BadInput;
use files::save;
use plots::{DotPanel, DotSection, Figure, dot_plot, index_html, save_picture};
use rayon::prelude::*;
use sim::statistics::Mean;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Largest number of behaviors in a picture.
const MAX_BEHAVIORS: usize = 8;

/// Flags of the `plot` command.
#[derive(Debug, Clone, Args)]
pub struct PlotArgs {
    /// Results of `sweep` or `merge`, complete or not
    #[arg(value_name = "RESULTS.csv")]
    file: PathBuf,
    /// Folder for the pictures and their page
    #[arg(long, value_name = "DIR", default_value = "out/plot")]
    out: PathBuf,
}

/// Prints the table, and writes the pictures.
///
/// # Errors
/// A file that cannot be read or holds no episode, a folder that cannot be written.
pub fn plot(args: &PlotArgs, out: &mut impl Write) -> Result<(), CliError> {
    let results = ResultsTable::load(&args.file)?;
    if results.rows() == 0 {
        return Err(BadInput::file(&args.file, "holds no episode").into());
    }
    prepare(&args.out)?;
    let (mut choices, left_out) = swept_choices(&results);
    if choices.is_empty() {
        choices.push(SweptChoice {
            key: "all".to_owned(),
            values: vec!["all episodes".to_owned()],
            of_row: vec![0; results.rows()],
        });
    }
    let drawn: Vec<_> = choices
        .iter()
        .map(|choice| (choice, by_behavior(&results, choice)))
        .collect();
    out.write_all(text(&drawn).as_bytes())?;
    for key in &left_out {
        writeln!(out, "{key}: too many values to distinguish")?;
    }
    let identity = results.header().identity();
    let title = identity.trim_start_matches("host-sim ");
    let title = title.split(',').next().unwrap_or(title);
    let count = format!(
        "{} of {} episodes",
        results.rows(),
        results.header().episodes()
    );
    let summary = [("results", identity), ("drawn", count.as_str())];
    let summary = summary.map(|(label, value)| (label.to_owned(), value.to_owned()));
    let figures = draw(&args.out, title, &drawn)?;
    let page = index_html(title, &summary, &figures, &[]);
    let page = save(&args.out, "index.html", page.as_bytes())?;
    Ok(writeln!(out, "\nPictures: {}", page.display())?)
}

/// Writes a picture for each option, as SVG and as PNG.
fn draw(folder: &Path, title: &str, drawn: &[DrawnChoice<'_>]) -> Result<Vec<Figure>, BadInput> {
    let subtitle = format!("{title}: all other options together; dot: mean, line: 95 % interval");
    let mut figures = Vec::new();
    for (choice, found) in drawn {
        let figure = figure(&choice.key);
        let svg = dot_plot(&figure.title, &subtitle, &sections(choice, found));
        save_picture(folder, figure.file.trim_end_matches(".svg"), &svg)?;
        figures.push(figure);
    }
    Ok(figures)
}

/// An option, and the outcomes by its values.
type DrawnChoice<'c> = (&'c SweptChoice, Vec<BehaviorOutcomes>);

/// A behavior, and its outcomes by the values of an option.
struct BehaviorOutcomes {
    name: String,
    /// Unit of the behavior's own measure.
    unit: String,
    of_value: Vec<Option<SweepOutcome>>,
}

fn by_behavior(results: &ResultsTable, choice: &SweptChoice) -> Vec<BehaviorOutcomes> {
    let (Some(names), Some(units)) = (results.texts("behavior"), results.texts("success_unit"))
    else {
        return Vec::new();
    };
    let behaviors = names.distinct.iter().enumerate().take(MAX_BEHAVIORS);
    let outcomes = |(behavior, name): (usize, &String)| {
        let of_value = |value: usize| {
            let has = |row: usize| {
                choice.of_row.get(row) == Some(&value) && names.of_row.get(row) == Some(&behavior)
            };
            SweepOutcome::of(results, has)
        };
        BehaviorOutcomes {
            name: name.clone(),
            unit: unit(names, units, behavior).unwrap_or_default(),
            of_value: (0..choice.values.len())
                .into_par_iter()
                .map(of_value)
                .collect(),
        }
    };
    behaviors.map(outcomes).collect()
}

/// The unit in the first row of a behavior.
fn unit(names: &Texts, units: &Texts, behavior: usize) -> Option<String> {
    let row = names.of_row.iter().position(|&of| of == behavior)?;
    units.distinct.get(*units.of_row.get(row)?).cloned()
}

fn text(drawn: &[DrawnChoice<'_>]) -> String {
    let heads = [
        "option",
        "value",
        "behavior",
        "episodes",
        "without contact %",
        "success",
        "distance m",
    ];
    let mut rows = Vec::new();
    for (choice, found) in drawn {
        for (place, value) in choice.values.iter().enumerate() {
            for behavior in found {
                if let Some(Some(outcome)) = behavior.of_value.get(place) {
                    let names = [&choice.key, value, &behavior.name].map(String::clone);
                    rows.push(names.into_iter().chain(figures_of(outcome)).collect());
                }
            }
        }
    }
    table::plain(&heads, &rows, &[3, 4, 5, 6])
}

/// The figures in the form of the table.
fn figures_of(outcome: &SweepOutcome) -> [String; 4] {
    [
        outcome.episodes.to_string(),
        format!("{:.1}", outcome.clean.percent()),
        format!("{:.4}", outcome.success),
        format!("{:.1}", outcome.distance_m),
    ]
}

const CAPTION: &str = "Each value's episodes, all other options together: the share without contact (interval by Wilson's score, \
                       episodes taken as independent) and the behavior's own measure (interval by the bootstrap over worlds \
                       and seeds).";

fn figure(key: &str) -> Figure {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '.' {
            c
        } else {
            '-'
        }
    };
    Figure {
        file: format!("{}.svg", key.chars().map(plain).collect::<String>()),
        title: format!("Outcome by {key}"),
        caption: vec![CAPTION.to_owned()],
    }
}

fn sections(choice: &SweptChoice, found: &[BehaviorOutcomes]) -> Vec<DotSection> {
    let section = |behavior: &BehaviorOutcomes| {
        let outcomes = &behavior.of_value;
        let panel = |name: &str, within: [f64; 2], mean: fn(&SweepOutcome) -> Mean| DotPanel {
            name: name.to_owned(),
            within,
            means: outcomes
                .iter()
                .map(|found| found.as_ref().map(mean))
                .collect(),
        };
        let episodes = outcomes
            .iter()
            .map(|found| found.map_or(0, |found| found.episodes));
        DotSection {
            title: format!("{} (success: {})", behavior.name, behavior.unit),
            labels: choice.values.iter().cloned().zip(episodes).collect(),
            panels: vec![
                panel("episodes without contact, %", [0.0, 100.0], |found| {
                    found.clean.percent()
                }),
                panel("success", [0.0, f64::INFINITY], |found| found.success),
            ],
        }
    };
    found.iter().map(section).collect()
}
