//! `host-sim paper`: redraws the paper's figures and measures its claims one by one.

use super::output::{bar, prepare};
use super::{CliError, table};
use clap::Args;
use experiments::paper::claims::{Claim, ClaimVerdict, claims};
use experiments::paper::measure::{ProgressListener, Size, measure};
use files::error::BadInput;
use files::save;
use indicatif::ProgressBar;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Flags of the `paper` command.
#[derive(Debug, Clone, Args)]
pub struct PaperArgs {
    /// Folder for the page, the figures and the table
    #[arg(long, value_name = "DIR", default_value = "out/paper")]
    out: PathBuf,
    /// Seed of all randomness
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Random rooms for avoidance, for each of three presets
    #[arg(long, value_name = "ROOMS", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rooms: u32,
    /// Worlds for each of the other behaviors
    #[arg(long, value_name = "WORLDS", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    worlds: u32,
    /// Seeds per world
    #[arg(long, value_name = "SEEDS", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=999))]
    seeds: u32,
    /// Repetitions of each behavior
    #[arg(long, value_name = "TIMES", default_value_t = 6, value_parser = clap::value_parser!(u32).range(2..=1_000))]
    times: u32,
    /// Chains, miniature robots and episodes in the paper's arena
    #[arg(long, value_name = "DRAWS", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    draws: u32,
}

const HEADS: [&str; 6] = ["where", "claim", "holds if", "measured", "of", "verdict"];

const NEXT: [&str; 5] = [
    "cargo run --release -- paper --seed 2 --out out/paper-2",
    "cargo run --release -- paper --rooms 1000 --worlds 10 --out out/paper-long",
    "cargo run --release -- ablation --rooms 200",
    "cargo run --release -- behaviors --out out/behaviors",
    "cargo run --release -- repetition --worlds 10 --seeds 10",
];

/// A progress bar for each part of the measurement.
struct Bars(ProgressBar);

impl ProgressListener for Bars {
    fn begin(&self, part: &'static str, pieces: u64) {
        self.0.set_prefix(part);
        self.0.set_length(pieces);
        self.0.set_position(0);
    }

    fn done(&self) {
        self.0.inc(1);
    }
}

/// Measures everything, prints the table and writes page, figures and table.
///
/// # Errors
/// When the folder cannot be written, an episode fails, or standard output is closed.
pub fn paper(args: &PaperArgs, out: &mut impl Write) -> Result<(), CliError> {
    prepare(&args.out)?;
    let size = Size {
        rooms: args.rooms,
        worlds: args.worlds,
        seeds: args.seeds,
        draws: args.draws,
        times: args.times,
        seed: args.seed,
    };
    let bars = Bars(bar(1, ""));
    let measured = measure(size, &bars).map_err(|error| BadInput::new(error.to_string()))?;
    let claims = claims(&measured);
    bars.begin("draw", 1);
    let files = write(&args.out, &claims, |dir| {
        experiments::pictures::paper::write(dir, &measured, &claims, &NEXT)
    })?;
    bars.0.finish_and_clear();
    print(out, &claims)?;
    if let Some(page) = files.last() {
        writeln!(
            out,
            "\nPage: open {} in a browser ({} files beside it)",
            page.display(),
            files.len() - 1
        )?;
    }
    Ok(())
}

/// Writes the table as CSV and Markdown, then the files of `page`.
fn write(
    dir: &Path,
    claims: &[Claim],
    page: impl FnOnce(&Path) -> Result<Vec<PathBuf>, BadInput>,
) -> Result<Vec<PathBuf>, BadInput> {
    let rows: Vec<_> = claims.iter().map(row).collect();
    let markdown = table::markdown(&HEADS, &rows, &[]);
    let mut files = vec![
        save(dir, "claims.csv", &csv(&rows)?)?,
        save(dir, "claims.md", markdown.as_bytes())?,
    ];
    files.extend(page(dir)?);
    Ok(files)
}

fn row(claim: &Claim) -> Vec<String> {
    let words = claim.verdict.words();
    let place = claim.place();
    let cells = [
        &place,
        claim.words,
        &claim.rule,
        &claim.measured,
        &claim.sample,
        words,
    ];
    cells.map(str::to_owned).to_vec()
}

fn csv(rows: &[Vec<String>]) -> Result<Vec<u8>, BadInput> {
    let bad = |error: csv::Error| BadInput::new(format!("claims.csv: {error}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADS).map_err(bad)?;
    for row in rows {
        writer.write_record(row).map_err(bad)?;
    }
    writer
        .into_inner()
        .map_err(|error| BadInput::new(format!("claims.csv: {error}")))
}

/// Prints the claims one below the other: six columns are too wide for a terminal.
fn print(out: &mut impl Write, claims: &[Claim]) -> Result<(), CliError> {
    for claim in claims {
        writeln!(
            out,
            "{:<18} {:<9} \"{}\"",
            claim.verdict.words(),
            claim.place(),
            claim.words
        )?;
        if !claim.rule.is_empty() {
            writeln!(out, "    holds if {}", claim.rule)?;
        }
        let of = if claim.sample.is_empty() {
            String::new()
        } else {
            format!(" ({})", claim.sample)
        };
        writeln!(out, "    {}{of}", claim.measured)?;
    }
    let counts = ClaimVerdict::ALL.map(|verdict| {
        let count = claims
            .iter()
            .filter(|claim| claim.verdict == verdict)
            .count();
        vec![verdict.words().to_owned(), count.to_string()]
    });
    writeln!(out)?;
    Ok(out.write_all(table::plain(&["verdict", "claims"], &counts, &[1]).as_bytes())?)
}
