//! `host-sim barn`: drives the worlds of the BARN benchmark and prints its table.

mod tables;

use super::CliError;
use super::output::{bar, prepare};
use super::run::{Preset, SonarChoice, Switch};
use arena::loaders::barn::{range, sources};
use arena::route;
use arena::world::{Point, World};
use clap::Args;
use experiments::barn::{self, BarnMethod, Run, RunConditions, SeekerTuning, shortest};
use files::error::BadInput;
use files::table::{Records, Table};
use files::{MAX_INPUT_BYTES, read_text};
use rayon::prelude::*;
use sim::pilot::MAX_MOVES;
use sim::settings;
use std::collections::BTreeMap;
use std::io::Write;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Column of `--lengths` with the reference lengths.
const LENGTH: &str = "reference_path_length_m";

/// Drives the worlds of the BARN benchmark and prints success and score
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  host-sim barn --file worlds/BARN --worlds 0..=299
      the published worlds, world_0.world to world_299.world in a folder
  host-sim barn --file cells.csv --methods maps,vfh-plus --shield off --out out/barn
      worlds from a table of filled cells (header world,ix,iy); the methods alone; a picture")]
pub struct BarnArgs {
    /// Worlds: a folder of world_N.world files, one such file, or a table of filled cells with the
    /// header world,ix,iy
    #[arg(long, value_name = "FILE|FOLDER")]
    file: PathBuf,
    /// Worlds to drive, N or A..=B; missing ones are skipped [default: all]
    #[arg(long, value_name = "RANGE", value_parser = range)]
    worlds: Option<RangeInclusive<u32>>,
    /// Methods to drive by [default: all]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_enum)]
    methods: Vec<BarnMethod>,
    /// Table with the columns world and reference_path_length_m: path lengths for the score
    /// [default: computed]
    #[arg(long, value_name = "FILE")]
    lengths: Option<PathBuf>,
    /// Seed of the first world; each further world uses the next seed
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Random moves from which the maps learn, in a random room
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    explore: u16,
    /// Let the sonars limit the motion of all methods
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    shield: Switch,
    /// Distance that the shield keeps between body and echoes, m
    #[arg(long, value_name = "M", default_value = "0.09", value_parser = margin)]
    margin: f64,
    /// Clearance around the ring in the maps' goal, m
    #[arg(long, value_name = "M", default_value_t = SeekerTuning::default().clearance_m, value_parser = clearance)]
    clearance: f64,
    /// Weight of progress toward the goal for the maps, in units of a squared deviation of 1
    #[arg(long, value_name = "WEIGHT", default_value_t = SeekerTuning::default().pull, value_parser = pull)]
    pull: f64,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Change one option of the controller (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object per world and method instead of the table
    #[arg(long)]
    json: bool,
    /// Write a picture of the first worlds with the driven paths into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

fn between(text: &str, least: f64, most: f64) -> Result<f64, BadInput> {
    let number = text
        .parse()
        .ok()
        .filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| BadInput::new(format!("it must lie between {least} and {most}")))
}

fn margin(text: &str) -> Result<f64, BadInput> {
    between(text, 0.0, 1.0)
}

fn clearance(text: &str) -> Result<f64, BadInput> {
    between(text, 0.0, 6.0)
}

fn pull(text: &str) -> Result<f64, BadInput> {
    between(text, 0.0, 0.99)
}

/// A world, its shortest path and the runs of the methods.
struct WorldRuns {
    world: World,
    number: u32,
    /// The shortest path of the body.
    shortest_path: Option<Vec<Point>>,
    /// A path for the body plus the shield's margin exists.
    with_margin: bool,
    /// Path length for the score, m.
    length_m: f64,
    runs: Vec<Run>,
}

/// Drives the worlds and prints the table.
///
/// # Errors
/// Worlds that cannot be loaded, a flag that does not apply, a folder that cannot be written, a
/// closed pipe.
pub fn barn(args: &BarnArgs, out: &mut impl Write) -> Result<(), CliError> {
    let rules = rules(args)?;
    let methods = if args.methods.is_empty() {
        BarnMethod::ALL.to_vec()
    } else {
        args.methods.clone()
    };
    let lengths = args.lengths.as_deref().map(lengths).transpose()?;
    let sources = sources(&args.file, args.worlds.as_ref())?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let progress = bar(sources.len() as u64, "worlds");
    let run_world = |source: &_| {
        let result = drive(args, &rules, &methods, lengths.as_ref(), source);
        progress.inc(1);
        result
    };
    let results: Vec<_> = sources
        .par_iter()
        .map(run_world)
        .collect::<Result<_, _>>()?;
    progress.finish_and_clear();
    if args.json {
        for line in results
            .iter()
            .flat_map(|result| tables::objects(result, &methods))
        {
            writeln!(out, "{line}")?;
        }
    } else {
        tables::print(args, &results, &methods, out)?;
    }
    match &args.out {
        Some(dir) => tables::picture(dir, &results, &methods, args.json, out),
        None => Ok(()),
    }
}

fn rules(args: &BarnArgs) -> Result<RunConditions, BadInput> {
    let mut config = Preset::Default.config();
    settings::apply(&mut config, &args.sets)?;
    if let Some(shield) = &mut config.shield {
        shield.margin_mm = libm::rint(args.margin * 1e3) as u16;
    }
    if args.shield == Switch::Off {
        config.shield = None;
    }
    Ok(RunConditions {
        config,
        sonar: args.sonar.into(),
        explore_moves: args.explore,
        seed: args.seed,
        tuning: SeekerTuning {
            clearance_m: args.clearance,
            pull: args.pull,
        },
    })
}

fn drive(
    args: &BarnArgs,
    rules: &RunConditions,
    methods: &[BarnMethod],
    lengths: Option<&BTreeMap<u32, f64>>,
    source: &arena::loaders::barn::BarnSource,
) -> Result<WorldRuns, BadInput> {
    let world = source.load()?;
    let number = source.number;
    let shortest_path = shortest(&world, 0.0)?;
    let length_m = match lengths {
        Some(lengths) => lengths.get(&number).copied().ok_or_else(|| {
            BadInput::new(format!("--lengths: there is no length for world {number}"))
        })?,
        // In a world without a path every run fails: the length does not matter.
        None => shortest_path.as_deref().map_or(1.0, route::length),
    };
    let run = |method: &BarnMethod| barn::run(&world, *method, rules, u64::from(number));
    Ok(WorldRuns {
        number,
        with_margin: shortest(&world, args.margin)?.is_some(),
        runs: methods.iter().map(run).collect::<Result<_, _>>()?,
        shortest_path,
        length_m,
        world,
    })
}

/// Reads path lengths by world.
fn lengths(path: &Path) -> Result<BTreeMap<u32, f64>, BadInput> {
    let source = path.display().to_string();
    let text = read_text(path, MAX_INPUT_BYTES)?;
    let records = Records::parse(&source, &text, None)?;
    let column = |name: &str| {
        let place = records.heading.iter().position(|head| *head == name);
        place.ok_or_else(|| BadInput::line(&source, 1, format!("there is no column {name}")))
    };
    let (world, length) = (column("world")?, column(LENGTH)?);
    let mut found = BTreeMap::new();
    for (line, row) in &records.rows {
        let field = |column: usize| row.get(column).copied().unwrap_or_default();
        let bad = |column, what: &str| {
            Table::cell(
                &source,
                *line,
                column,
                format!("\"{}\" {what}", field(column)),
            )
        };
        let number = field(world)
            .parse()
            .map_err(|_| bad(world, "is not the number of a world"))?;
        let meters = field(length)
            .parse()
            .ok()
            .filter(|m: &f64| m.is_finite() && *m > 0.0);
        found.insert(
            number,
            meters.ok_or_else(|| bad(length, "is not a length"))?,
        );
    }
    Ok(found)
}
