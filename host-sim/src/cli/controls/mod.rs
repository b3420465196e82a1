//! `host-sim controls`: what is left of every behavior with something trivial in place of the
//! action map.

mod tables;

use super::output::{bar, prepare};
use super::run::{Preset, SonarChoice};
use super::{CliError, neurons};
use clap::{Args, ValueEnum};
use experiments::controls::{
    ControlMeasure, ControlRow, ControlTrial, Results, WorldSet, episodes_per_row, measure,
    measures, rows,
};
use files::error::BadInput;
use sim::episode::NEURON_COUNTS;
use sim::pilot::MAX_MOVES;
use std::io::Write;
use std::path::PathBuf;

/// Flags of the `controls` command.
#[derive(Debug, Clone, Args)]
pub struct ControlsArgs {
    /// Worlds per scene in rooms
    #[arg(long, value_name = "WORLDS", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    worlds: u32,
    /// Seeds per world in rooms
    #[arg(long, value_name = "SEEDS", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=999))]
    seeds: u32,
    /// Worlds of other kinds (corridors, mazes, halls …), one seed each; 0 = none
    #[arg(long, value_name = "WORLDS", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    others: u32,
    /// Number of the first world: below 10 000 for tuning, from there on for reporting
    #[arg(long, value_name = "NUMBER", default_value_t = 10_000)]
    first: u64,
    /// What changes from row to row: the predictor, or the size of the maps or the number of random
    /// moves for a choice of predictors
    #[arg(long, value_name = "WHAT", default_value = "predictors", value_enum)]
    by: Axis,
    /// Neurons of each map, and code vectors of what replaces it: 4, 9, 16, 25, 36, 49 or 64
    #[arg(long, value_name = "N", default_value_t = 16, conflicts_with = "by", value_parser = neurons::parsed)]
    neurons: u8,
    /// Random moves before each behavior
    #[arg(long, value_name = "MOVES", default_value_t = 100, conflicts_with = "by", value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    explore: u16,
    /// Preset of the controller's options: default or probe
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    preset: Preset,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Only predictors whose name contains this text, after the two maps
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object per measure and row instead of tables
    #[arg(long)]
    json: bool,
    /// Write a picture into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// What changes from row to row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Axis {
    /// What predicts the change of situation
    Predictors,
    /// Neurons of each map
    Neurons,
    /// Random moves
    Moves,
}

/// Numbers of random moves in the table by moves.
const MOVES: [u16; 7] = [1, 3, 10, 30, 100, 300, 1_000];

/// Predictors in the table by neurons: name, and whether they learn online.
const BY_NEURONS: [(&str, bool); 3] = [
    ("two maps", true),
    ("vector quantization", true),
    ("nothing learned, g", false),
];

/// Predictors in the table by moves.
const BY_MOVES: [(&str, bool); 6] = [
    ("two maps", true),
    ("two maps", false),
    ("nothing learned, g", false),
    ("least squares", false),
    ("turned least squares", false),
    ("32 nearest, turned", false),
];

/// One row of the tables.
#[derive(Clone)]
struct Case {
    row: ControlRow,
    neurons: u8,
    moves: u16,
    /// By set of worlds and measure.
    results: Vec<Vec<Results>>,
}

/// A set of worlds with its measures and conditions.
struct Part {
    set: WorldSet,
    measures: Vec<ControlMeasure>,
    trial: ControlTrial,
}

/// Measures and prints the tables.
///
/// # Errors
/// When no predictor matches `--only`, an episode fails, or something cannot be written.
pub fn controls(args: &ControlsArgs, out: &mut impl Write) -> Result<(), CliError> {
    if args.preset == Preset::Touzet {
        let why = "--preset touzet: its ring turns, so no linear prediction fits; default or probe";
        return Err(BadInput::new(why).into());
    }
    let parts = parts(args);
    let mut cases = cases(args)?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let each: u64 = parts
        .iter()
        .map(|part| episodes_per_row(&part.measures, &part.trial))
        .sum();
    let progress = bar(each * cases.len() as u64, "episodes");
    for case in &mut cases {
        for part in &parts {
            let trial = ControlTrial {
                neurons: case.neurons,
                explore_moves: case.moves,
                ..part.trial.clone()
            };
            let results = measure(&case.row, &part.measures, &trial, &|| progress.inc(1));
            let failed = |failure| BadInput::new(format!("{}: {failure}", case.row.title()));
            case.results.push(results.map_err(failed)?);
        }
    }
    progress.finish_and_clear();
    let report = tables::ControlTables {
        axis: args.by,
        parts: &parts,
        cases: &cases,
    };
    if args.json {
        report.write_json(out)?;
    } else {
        out.write_all(report.text(args.markdown).as_bytes())?;
        writeln!(out, "{}", about(args))?;
    }
    match &args.out {
        Some(dir) => report.picture(dir, &about(args), args.json, out),
        None => Ok(()),
    }
}

fn parts(args: &ControlsArgs) -> Vec<Part> {
    let part = |set, worlds, seeds| Part {
        set,
        measures: measures(set),
        trial: ControlTrial {
            first: args.first,
            worlds,
            seeds,
            explore_moves: args.explore,
            preset: args.preset.name(),
            config: args.preset.config(),
            sonar: args.sonar.into(),
            neurons: args.neurons,
        },
    };
    let mut parts = vec![part(WorldSet::Rooms, args.worlds, args.seeds)];
    if args.others > 0 {
        parts.push(part(WorldSet::OtherKinds, args.others, 1));
    }
    parts
}

fn cases(args: &ControlsArgs) -> Result<Vec<Case>, BadInput> {
    let case = |row: &ControlRow, neurons, moves| Case {
        row: *row,
        neurons,
        moves,
        results: Vec::new(),
    };
    let named = |names: &[(&str, bool)]| {
        let row = |&(name, online): &(&str, bool)| {
            let fits = |row: &ControlRow| row.name == name && row.online == online;
            rows().into_iter().find(fits)
        };
        names.iter().filter_map(row).collect::<Vec<_>>()
    };
    let chosen = match args.by {
        Axis::Predictors => rows(),
        Axis::Neurons => named(&BY_NEURONS),
        Axis::Moves => named(&BY_MOVES),
    };
    let text = args.only.as_deref().unwrap_or_default();
    let fits = |(index, row): &(usize, &ControlRow)| *index == 0 || row.name.contains(text);
    let chosen: Vec<_> = chosen.iter().enumerate().filter(fits).collect();
    if !chosen.iter().any(|(_, row)| row.name.contains(text)) {
        let why = format!("--only \"{text}\": no predictor has this in its name");
        return Err(BadInput::new(why));
    }
    let rows = chosen.into_iter().map(|(_, row)| row);
    let cases = rows.flat_map(|row| match args.by {
        Axis::Predictors => vec![case(row, args.neurons, args.explore)],
        Axis::Neurons => NEURON_COUNTS.map(|n| case(row, n, args.explore)).to_vec(),
        Axis::Moves => MOVES.map(|moves| case(row, args.neurons, moves)).to_vec(),
    });
    Ok(cases.collect())
}

/// The size of the measurement and the meaning of the marks.
fn about(args: &ControlsArgs) -> String {
    let what = match args.by {
        Axis::Predictors => format!("{} random moves, {} neurons", args.explore, args.neurons),
        Axis::Neurons => format!("{} random moves", args.explore),
        Axis::Moves => format!("{} neurons", args.neurons),
    };
    format!(
        "Preset {}, {what}, sonars {}, no shield. Mean [95 % interval] of {} worlds × {} seeds in rooms, {} worlds of other kinds, all from \
         number {} on. + / − = better / worse than the first row, paired (95 % interval).",
        args.preset.name(),
        arena::sonar::SonarModel::from(args.sonar).name(),
        args.worlds,
        args.seeds,
        args.others,
        args.first
    )
}
