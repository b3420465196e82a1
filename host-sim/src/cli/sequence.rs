//! `host-sim sequence`: recalls sequences of patterns by a pair of associative memories, and by
//! simpler methods.

use super::output::{bar, pool, prepare};
use super::{CliError, table};
use clap::Args;
use experiments::sequence::{
    BITS, ELEMENTS, Elements, FLIPPED, Measure, Method, Row, SEQUENCES, SHORT, SIZES,
    SequenceTrial, measure, picture,
};
use files::error::BadInput;
use plots::save_picture;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Flags of the `sequence` command.
#[derive(Debug, Clone, Args)]
pub struct SequenceArgs {
    /// Draws of elements: random bits, and drives in worlds of many kinds
    #[arg(long, value_name = "SEEDS", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    seeds: u32,
    /// Damaged cues for each draw and share of noise
    #[arg(long, value_name = "CUES", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    cues: u32,
    /// The longest sequence is measured for corrected weights up to so many bits; they take long
    #[arg(long, value_name = "BITS", default_value_t = 128, value_parser = clap::value_parser!(u16).range(0..=512))]
    corrected_bits: u16,
    /// Seed of all randomness: the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object per figure instead of the tables
    #[arg(long)]
    json: bool,
    /// Write pictures into this folder: the longest sequences, recall under noise, and a sequence
    /// as rows of bits
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Measures and prints the tables.
///
/// # Errors
/// An output that cannot be written.
pub fn sequence(args: &SequenceArgs, out: &mut impl Write) -> Result<(), CliError> {
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let trial = SequenceTrial {
        seed: args.seed,
        seeds: args.seeds,
        cues: args.cues,
        corrected_bits: args.corrected_bits.into(),
    };
    let progress = bar(args.seeds.into(), "seeds");
    let done = || progress.inc(1);
    let rows = pool(args.threads)?.install(|| measure(&trial, &done))?;
    progress.finish_and_clear();
    if args.json {
        for row in &rows {
            serde_json::to_writer(&mut *out, row).map_err(std::io::Error::from)?;
            writeln!(out)?;
        }
    } else {
        print_tables(args.markdown, &rows, out)?;
        writeln!(out, "{} [95 % interval].", about(&trial))?;
    }
    if let Some(dir) = &args.out {
        for file in pictures(dir, &trial, &rows)? {
            if !args.json {
                writeln!(out, "Picture: {}", file.display())?;
            }
        }
    }
    Ok(())
}

fn about(trial: &SequenceTrial) -> String {
    format!(
        "{} draws, {} cues for each share of noise; mean over the draws",
        trial.seeds, trial.cues
    )
}

/// The tables: title, measure, conditions, and how a condition is headed.
fn print_tables(is_markdown: bool, rows: &[Row], out: &mut impl Write) -> Result<(), CliError> {
    let sizes: Vec<u32> = SIZES.iter().map(|bits| *bits as u32).collect();
    let noise = format!("a sequence of {ELEMENTS} elements of {BITS} bits");
    let several = format!("sequences of {SHORT} elements of {BITS} bits");
    for (title, measure, at, unit) in [
        (
            "Longest sequence recalled without an error, elements".to_owned(),
            Measure::Longest,
            &sizes[..],
            " bits",
        ),
        (
            format!("Recalled wholly from a damaged cue, %: {noise}"),
            Measure::Cue,
            &FLIPPED[..],
            " % flipped",
        ),
        (
            format!("Recalled wholly with noise in every step, %: {noise}"),
            Measure::Steps,
            &FLIPPED[..],
            " % flipped",
        ),
        (
            format!("Recalled wholly of several in one memory, %: {several}"),
            Measure::Sequences,
            &SEQUENCES[..],
            " sequences",
        ),
        (
            format!("Recalled wholly of two, without and with an element in common, %: {several}"),
            Measure::Shared,
            &[0, 1][..],
            " in common",
        ),
    ] {
        let heads: Vec<String> = at.iter().map(|at| format!("{at}{unit}")).collect();
        let heads = ["elements", "method"]
            .into_iter()
            .chain(heads.iter().map(String::as_str));
        let heads: Vec<_> = heads.collect();
        let cells = cells(rows, measure, at);
        let right: Vec<_> = (2..heads.len()).collect();
        let format = if is_markdown {
            table::markdown
        } else {
            table::plain
        };
        writeln!(out, "{title}\n\n{}", format(&heads, &cells, &right))?;
    }
    Ok(())
}

/// A row for each kind of elements and method that was measured.
fn cells(rows: &[Row], measure: Measure, at: &[u32]) -> Vec<Vec<String>> {
    let mut all = Vec::new();
    for elements in Elements::ALL {
        for method in Method::ALL {
            let figure = |at: &u32| {
                let key = (elements, measure, method, *at);
                let mut rows = rows.iter();
                let row = rows.find(|r| (r.elements, r.measure, r.method, r.at) == key)?;
                Some(match measure {
                    Measure::Longest => format!("{:.1}", row.figure()),
                    _ => format!("{:.0}", row.figure().percent()),
                })
            };
            let figures: Vec<_> = at.iter().map(figure).collect();
            if figures.iter().any(Option::is_some) {
                let names = [elements.name(), method.name()].map(str::to_owned);
                let figures = figures.into_iter().map(Option::unwrap_or_default);
                all.push(names.into_iter().chain(figures).collect());
            }
        }
    }
    all
}

fn pictures(dir: &Path, trial: &SequenceTrial, rows: &[Row]) -> Result<Vec<PathBuf>, BadInput> {
    let about = format!("{}; bands: 95 % intervals", about(trial));
    let mut files = Vec::new();
    for (name, svg) in [
        ("longest", picture::longest(rows, &about)),
        (
            "noise-random",
            picture::noise(rows, Elements::Random, &about),
        ),
        (
            "noise-situations",
            picture::noise(rows, Elements::Situations, &about),
        ),
        ("recalled", picture::recalled(trial.seed)?),
    ] {
        let [file, _] = save_picture(dir, name, &svg)?;
        files.push(file);
    }
    Ok(files)
}
