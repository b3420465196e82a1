//! Writes the files of `compare --out`.

use super::picture::picture;
use super::tables::{ComparisonTables, MethodLine};
use crate::cli::CliError;
use ::files::error::BadInput;
use ::files::save;
use plots::save_picture;
use sim::statistics::Mean;
use std::io::Write;
use std::path::Path;

/// Writes all files and prints their names.
///
/// # Errors
/// When a file cannot be written or the pipe is closed.
pub fn write(
    dir: &Path,
    report: &ComparisonTables,
    about: &str,
    out: &mut impl Write,
) -> Result<(), CliError> {
    let csv = csv(report).map_err(|error| BadInput::new(format!("compare.csv: {error}")))?;
    save(dir, "compare.csv", &csv)?;
    let markdown = format!("{}{about}\n", report.markdown());
    save(dir, "compare.md", markdown.as_bytes())?;
    writeln!(
        out,
        "Tables: {0}/compare.csv, {0}/compare.md",
        dir.display()
    )?;
    picture(report).map_or(Ok(()), |svg| draw(dir, &svg, out))
}

fn draw(dir: &Path, svg: &str, out: &mut impl Write) -> Result<(), CliError> {
    let [picture, _] = save_picture(dir, "compare", svg)?;
    Ok(writeln!(out, "Picture: {}", picture.display())?)
}

/// Columns that are means with an interval.
const MEANS: [&str; 11] = [
    "contacts_while_learning",
    "contacts_per_100_m",
    "clean_percent",
    "distance_m",
    "coverage_m2",
    "least_clearance_m",
    "to_goal_s",
    "less_default_contacts_per_100_m",
    "less_default_clean_percent",
    "less_default_distance_m",
    "less_default_coverage_m2",
];

fn csv(report: &ComparisonTables) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let heads = ["method", "learning_moves", "shield"].map(str::to_owned);
    let means = MEANS
        .iter()
        .flat_map(|name| ["", "_low", "_high"].map(|end| format!("{name}{end}")));
    let bytes = ["bytes".to_owned()];
    writer.write_record(heads.into_iter().chain(means).chain(bytes))?;
    for line in &report.lines {
        writer.write_record(record(line))?;
    }
    writer
        .into_inner()
        .map_err(|error| error.into_error().into())
}

fn record(line: &MethodLine) -> Vec<String> {
    let shield = if line.shield { "on" } else { "off" };
    let mut cells = vec![
        line.method.name().to_owned(),
        line.moves.to_string(),
        shield.to_owned(),
    ];
    for mean in means(line) {
        let texts = mean.map_or([const { String::new() }; 3], |mean| {
            let [low, high] = mean.interval;
            [mean.mean, low, high].map(|value| format!("{value:.4}"))
        });
        cells.extend(texts);
    }
    cells.push(format!("{:.0}", line.figures.bytes));
    cells
}

fn means(line: &MethodLine) -> [Option<Mean>; 11] {
    let figures = &line.figures;
    let less = line.differences.as_ref();
    [
        Some(figures.learning_contacts),
        Some(figures.contacts_per_100_m),
        Some(figures.clean_percent),
        Some(figures.distance_m),
        Some(figures.coverage_m2),
        Some(figures.clearance_m),
        figures.to_goal_s,
        less.map(|less| less.contacts_per_100_m),
        less.map(|less| less.clean_percent),
        less.map(|less| less.distance_m),
        less.map(|less| less.coverage_m2),
    ]
}
