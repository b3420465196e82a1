//! `host-sim graph`: whether the neuron aimed at is reached, and the nest found, by preset.

use super::output::{bar, pool};
use super::run::Preset;
use super::{CliError, table};
use arena::loaders::WorldKind;
use clap::Args;
use experiments::bodies::Generator;
use experiments::traversed::{Aims, Drives, measure};
use files::error::BadInput;
use sim::statistics::bootstrap;
use std::io::Write;

/// Flags of the `graph` command; all are optional.
#[derive(Debug, Clone, Args)]
pub struct GraphArgs {
    /// Number of worlds; in each there is one drive, with the world's seed
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    worlds: u32,
    /// Generator of the worlds: random (rooms with boxes) or random2 (twelve other kinds)
    #[arg(long, value_name = "NAME", default_value = "random2")]
    generator: Generator,
    /// Seed of the first world: below 10 000 for tuning, from there on for reporting
    #[arg(long, value_name = "SEED", default_value_t = 10_000)]
    first: u64,
    /// Decisions of obstacle avoidance before the robot is set down elsewhere
    #[arg(long, value_name = "STEPS", default_value_t = 300, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    tour: u32,
    /// A row for each kind of world as well (random2)
    #[arg(long)]
    kinds: bool,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

const PRESETS: [Preset; 4] = [
    Preset::Default,
    Preset::Probe,
    Preset::Touzet,
    Preset::Graph,
];

const HEADS: [&str; 11] = [
    "preset",
    "worlds",
    "at the nest, %",
    "minus default, points",
    "worlds touched",
    "aims",
    "reached, %",
    "most frequent, %",
    "random, %",
    "after one move, %",
    "decisions with an aim, %",
];

/// Measures the presets and prints a table.
///
/// # Errors
/// Kinds of rooms with boxes, an episode that fails, a closed pipe.
pub fn graph(args: &GraphArgs, out: &mut impl Write) -> Result<(), CliError> {
    if args.kinds && args.generator == Generator::Random {
        return Err(
            BadInput::new("--kinds: only the worlds of --generator random2 have kinds").into(),
        );
    }
    let drives = Drives {
        generator: args.generator,
        first: args.first,
        worlds: args.worlds,
        tour: args.tour,
    };
    let pool = pool(args.threads)?;
    let progress = bar(PRESETS.len() as u64 * u64::from(args.worlds), "worlds");
    let mut measured = Vec::new();
    for preset in PRESETS {
        let done = || progress.inc(1);
        let aims = pool.install(|| measure(&preset.config(), preset.turret(), &drives, &done));
        let failed = |failure| BadInput::new(format!("preset {}: {failure}", preset.name()));
        measured.push((preset, aims.map_err(failed)?));
    }
    progress.finish_and_clear();
    let rows = rows(args, &drives.seeds(), &measured);
    let format = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    let right: Vec<_> = (2..HEADS.len()).collect();
    out.write_all(format(&HEADS, &rows, &right).as_bytes())?;
    Ok(writeln!(
        out,
        "\nNest in {} worlds of {} from {} on, after a tour of {} decisions; exact sonars, with the shield. \
         [95 % interval, paired by world]",
        args.worlds,
        args.generator.name(),
        args.first,
        args.tour,
    )?)
}

/// All worlds, then each kind, by preset.
fn rows(args: &GraphArgs, seeds: &[u64], measured: &[(Preset, Vec<Aims>)]) -> Vec<Vec<String>> {
    let kinds = WorldKind::ALL.into_iter().filter(|_| args.kinds);
    let mut rows = Vec::new();
    for kind in std::iter::once(None).chain(kinds.map(Some)) {
        let meant = |aims: &[Aims]| -> Vec<Aims> {
            let pairs = seeds.iter().zip(aims);
            let meant = pairs
                .filter(|(seed, _)| kind.is_none_or(|kind| WorldKind::of_seed(**seed) == kind));
            meant.map(|(_, aims)| *aims).collect()
        };
        let Some((_, default)) = measured.first() else {
            return rows;
        };
        let default = meant(default);
        let name = kind.map_or("all", WorldKind::name);
        rows.extend(
            measured
                .iter()
                .map(|(preset, aims)| row(*preset, name, &meant(aims), &default)),
        );
    }
    rows
}

fn row(preset: Preset, worlds: &str, drives: &[Aims], default: &[Aims]) -> Vec<String> {
    let sum = drives.iter().copied().fold(Aims::default(), Aims::plus);
    let share = |part: f64, whole: u32| match whole {
        0 => String::new(),
        _ => format!("{:.1}", 100.0 * part / f64::from(whole)),
    };
    let more = drives
        .iter()
        .zip(default)
        .map(|(own, default)| vec![f64::from(own.at_nest) - f64::from(default.at_nest)]);
    let more = bootstrap(&more.collect::<Vec<_>>()).percent();
    vec![
        preset.name().to_owned(),
        worlds.to_owned(),
        share(sum.at_nest.into(), sum.drives),
        if preset == Preset::Default {
            String::new()
        } else {
            format!("{more:.1}")
        },
        sum.touched.to_string(),
        sum.legs.to_string(),
        share(sum.reached.into(), sum.legs),
        share(sum.most_frequent.into(), sum.legs),
        share(sum.random, sum.legs),
        share(sum.after_one.into(), sum.moves),
        share(sum.moves.into(), sum.decisions),
    ]
}
