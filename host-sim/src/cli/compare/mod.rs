//! `host-sim compare`: the controller compared with other methods.

mod files;
mod picture;
mod tables;

use super::CliError;
use super::output::{bar, pool, prepare};
use super::robot::NamedRobotArgs;
use super::run::{SonarChoice, sources};
use ::files::error::BadInput;
use clap::{Args, ValueEnum};
use experiments::compare::search::{self, ConstantSearch};
use experiments::compare::{
    ComparedMethod, ComparisonPlan, ComparisonRow, Conditions, Constants, measure,
};
use std::io::Write;
use std::path::PathBuf;

/// Flags of the `compare` command.
#[derive(Debug, Clone, Args)]
pub struct CompareArgs {
    #[command(flatten)]
    robot: NamedRobotArgs,
    /// World: a file, a folder, random:SEED, random:A..=B, random2:SEED, random2:A..=B or a
    /// built-in name; may be given several times
    #[arg(long = "world", value_name = "WORLD", default_value = "random:1..=6")]
    worlds: Vec<String>,
    /// Methods, separated by commas: default, probe, touzet (the two maps), random, braitenberg,
    /// potential-field, vfh-plus, nearest-change, nearest-pair, cosine, least-squares, nearest-fit
    /// (something else in place of the action map), q-lazy, q-table, q-som, q-two-soms;
    /// or all
    #[arg(long, value_name = "NAMES", default_value = "all", value_parser = parse_methods)]
    methods: Methods,
    /// Seeds in each world
    #[arg(long, value_name = "SEEDS", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    seeds: u32,
    /// The first of these seeds
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Measure without the shield, with it, or both one after the other; another robot has a guard
    /// instead
    #[arg(long, value_name = "ON|OFF|BOTH", default_value = "both", value_enum)]
    shield: Shields,
    /// Measured decisions of each episode, after learning
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// Learning moves of the methods that learn by reward, ascending
    #[arg(long, value_name = "MOVES", value_delimiter = ',', default_value = "100,200,1000,5000,20000", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    moves: Vec<u32>,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Write compare.csv, compare.md and pictures into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the time each method takes per decision, on standard error
    #[arg(long)]
    time: bool,
    /// Search the constants of one method instead, with the first number in --moves, in --seeds
    /// rooms from random:20001 on
    #[arg(long, value_name = "METHOD", conflicts_with_all = ["worlds", "methods", "seed", "out", "time"], value_parser = parse_method)]
    tune: Option<ComparedMethod>,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Methods as named on the command line.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Methods(Vec<ComparedMethod>);

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Shields {
    /// With the shield
    On,
    /// Without the shield
    Off,
    /// Without, then with it
    Both,
}

impl Shields {
    fn each(self) -> &'static [bool] {
        match self {
            Self::On => &[true],
            Self::Off => &[false],
            Self::Both => &[false, true],
        }
    }
}

fn parse_method(text: &str) -> Result<ComparedMethod, BadInput> {
    text.parse()
}

/// Parses a list of methods; the result is in the order of the tables, without duplicates.
fn parse_methods(text: &str) -> Result<Methods, BadInput> {
    if text == "all" {
        return Ok(Methods(ComparedMethod::ALL.to_vec()));
    }
    let named: Result<Vec<ComparedMethod>, _> = text.split(',').map(str::parse).collect();
    let named = named?;
    let listed = ComparedMethod::ALL.into_iter();
    Ok(Methods(
        listed.filter(|method| named.contains(method)).collect(),
    ))
}

/// Measures and prints the tables, or searches constants.
///
/// # Errors
/// A world that cannot be loaded, numbers of moves that do not ascend, an episode that fails, a
/// folder that cannot be written.
pub fn compare(args: &CompareArgs, out: &mut impl Write) -> Result<(), CliError> {
    if !args.moves.is_sorted_by(|a, b| a < b) {
        return Err(
            BadInput::new("--moves: each number must be greater than the one before").into(),
        );
    }
    let pool = pool(args.threads)?;
    if let Some(method) = args.tune {
        let text = pool.install(|| tune(method, args))?;
        return Ok(out.write_all(text.as_bytes())?);
    }
    let plan = plan(args)?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let began = std::time::Instant::now();
    let progress = bar(plan.len() as u64, "episodes");
    let rows = pool.install(|| measure(&plan, &|| progress.inc(1)));
    progress.finish_and_clear();
    let rows = rows.map_err(|failure| BadInput::new(failure.to_string()))?;
    let report = pool.install(|| tables::ComparisonTables::of(&rows));
    eprintln!(
        "{} episodes in {:.1} s",
        plan.len(),
        began.elapsed().as_secs_f64()
    );
    out.write_all(report.text().as_bytes())?;
    writeln!(out, "{}", about(&plan, args))?;
    if args.time {
        eprint!("{}", report.times());
    }
    args.out.as_ref().map_or(Ok(()), |dir| {
        files::write(dir, &report, &about(&plan, args), out)
    })
}

fn plan(args: &CompareArgs) -> Result<ComparisonPlan, BadInput> {
    let mut worlds = Vec::new();
    for source in sources(&args.worlds)? {
        worlds.push(source.load()?);
    }
    let shields = args.shield.each().iter();
    let conditions: Result<_, _> = shields.map(|shield| conditions(args, *shield)).collect();
    Ok(ComparisonPlan {
        worlds,
        first_seed: args.seed,
        seeds: args.seeds,
        methods: methods(args)?,
        moves: args.moves.clone(),
        conditions: conditions?,
    })
}

/// The methods; all that drive another robot, if it is one.
fn methods(args: &CompareArgs) -> Result<Vec<ComparedMethod>, BadInput> {
    let mut methods = args.methods.0.clone();
    if args.robot.find_on_nomad(false)?.is_some() {
        let are_all = methods.len() == ComparedMethod::ALL.len();
        let other = methods.iter().find(|method| method.slot().is_some());
        if let Some(method) = other.filter(|_| !are_all) {
            let name = method.name();
            return Err(BadInput::new(format!(
                "--methods {name}: only on the Nomad's own ring, without --robot"
            )));
        }
        methods.retain(|method| method.slot().is_none());
    }
    Ok(methods)
}

fn conditions(args: &CompareArgs, shield: bool) -> Result<Conditions, BadInput> {
    Ok(Conditions {
        robot: args.robot.find_on_nomad(shield)?,
        steps: args.steps,
        sonar: args.sonar.into(),
        shield,
        timed: args.time,
    })
}

/// Describes the figures in one or two sentences.
fn about(plan: &ComparisonPlan, args: &CompareArgs) -> String {
    let robot = plan.conditions.iter().find_map(|c| c.robot.as_ref());
    let robot = robot.map_or_else(String::new, |robot| format!("{}: ", robot.label()));
    format!(
        "Mean [95 % interval] of {robot}{} worlds ({}) × {} seeds, {} steps each, measured from the world's start after learning in the \
         same world; sonars: {}. Intervals by the bootstrap over worlds and seeds.",
        plan.worlds.len(),
        args.worlds.join(", "),
        plan.seeds,
        args.steps,
        arena::sonar::SonarModel::from(args.sonar).name(),
    )
}

fn tune(method: ComparedMethod, args: &CompareArgs) -> Result<String, BadInput> {
    let tuned_constants = search::tuned_constants(method);
    if tuned_constants.is_empty() {
        let name = method.name();
        return Err(BadInput::new(format!(
            "--tune {name}: it has no constants to search"
        )));
    }
    let search = ConstantSearch {
        method,
        moves: args.moves.first().copied().unwrap_or(1),
        rooms: args.seeds,
        conditions: conditions(args, args.shield == Shields::On)?,
    };
    let progress = bar((search::ROUNDS * tuned_constants.len()) as u64, "constants");
    let mut lines = Vec::new();
    let found = search.run(
        Constants::of(search.conditions.shield),
        |name, value, score| {
            lines.push((name.to_owned(), value, score));
            progress.inc(1);
        },
    );
    progress.finish_and_clear();
    found.map_err(|failure| BadInput::new(failure.to_string()))?;
    Ok(tables::search(&lines))
}

/// The rows by condition: without the shield, with it.
fn by_shield(rows: &[ComparisonRow]) -> impl Iterator<Item = &[ComparisonRow]> {
    rows.chunk_by(|a, b| a.shield == b.shield)
}
