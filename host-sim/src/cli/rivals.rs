//! `host-sim rivals`: other models and other quantizers, from the same random moves.

use super::output::{bar, pool, prepare};
use super::run::SonarChoice;
use super::{CliError, table};
use arena::sonar::SonarModel;
use clap::{Args, ValueEnum};
use experiments::bodies::Generator;
use experiments::rivals::{Rival, RivalOutcome, RivalRow, RivalTrial, measure};
use files::error::BadInput;
use plots::{CurveKey, Curves, curves, save_picture};
use serde_json::json;
use sim::pilot::MAX_MOVES;
use sim::statistics::Mean;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Flags of the `rivals` command.
#[derive(Debug, Clone, Args)]
pub struct RivalsArgs {
    /// Rivals, separated by commas: default, default-frozen (the two maps, learning on or not), gp,
    /// forest, linear-mpc (models instead of maps and planner), gng, gwr, plsom (instead of the
    /// action map); or all
    #[arg(long, value_name = "NAMES", default_value = "all", value_parser = parse_rivals)]
    rivals: Rivals,
    /// Learn each move turned by all 16 ring steps, as it was, or both one after the other
    #[arg(long, value_name = "ON|OFF|BOTH", default_value = "both", value_enum)]
    symmetry: Symmetries,
    /// Numbers of random moves, ascending
    #[arg(long, value_name = "MOVES", value_delimiter = ',', default_value = "10,30,100,300,1000", value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    moves: Vec<u16>,
    /// Generator of the worlds: random (rooms with boxes) or random2 (twelve other kinds)
    #[arg(long, value_name = "NAME", default_value = "random")]
    generator: Generator,
    /// Number of worlds; each is driven with its own seed
    #[arg(long, value_name = "WORLDS", default_value_t = 48, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    worlds: u32,
    /// Seed of the first world: below 10 000 for tuning, from there on for reporting
    #[arg(long, value_name = "SEED", default_value_t = 10_000)]
    first: u64,
    /// Steps of each behavior
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Measure with the shield
    #[arg(long)]
    shield: bool,
    /// Print the times of learning and of a decision, on standard error
    #[arg(long)]
    time: bool,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object per row
    #[arg(long)]
    json: bool,
    /// Write the learning curves as pictures into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

/// Rivals as named on the command line.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Rivals(Vec<Rival>);

/// With the ring's symmetry, without it, or both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Symmetries {
    /// With it
    On,
    /// Without it
    Off,
    /// With it, then without
    Both,
}

impl Symmetries {
    const fn each(self) -> &'static [bool] {
        match self {
            Self::On => &[true],
            Self::Off => &[false],
            Self::Both => &[true, false],
        }
    }
}

/// Parses a list of rivals; the result is in the order of the tables, without duplicates.
fn parse_rivals(text: &str) -> Result<Rivals, BadInput> {
    if text == "all" {
        return Ok(Rivals(Rival::ALL.to_vec()));
    }
    let named: Result<Vec<Rival>, _> = text.split(',').map(str::parse).collect();
    let named = named?;
    let listed = Rival::ALL.into_iter();
    Ok(Rivals(
        listed.filter(|rival| named.contains(rival)).collect(),
    ))
}

const HEADS: [&str; 9] = [
    "rival",
    "symmetry",
    "random moves",
    "clean worlds, %",
    "contacts per 100 m",
    "area, m²",
    "wall error, m",
    "nest found, %",
    "KiB",
];

/// A row and its figures.
type Measured = (RivalRow, RivalOutcome);

/// Measures and prints the table.
///
/// # Errors
/// Numbers of moves that do not ascend, an episode that fails, a folder that cannot be written.
pub fn rivals(args: &RivalsArgs, out: &mut impl Write) -> Result<(), CliError> {
    if !args.moves.is_sorted_by(|a, b| a < b) {
        return Err(
            BadInput::new("--moves: each number must be greater than the one before").into(),
        );
    }
    let pool = pool(args.threads)?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let trial = trial(args);
    let rows = rows(args);
    let progress = bar(u64::from(args.worlds) * rows.len() as u64, "worlds");
    let mut measured = Vec::new();
    for row in rows {
        let outcome = pool.install(|| measure(&row, &trial, &|| progress.inc(1)));
        let outcome = outcome.map_err(|failure| BadInput::new(failure.to_string()))?;
        measured.push((row, outcome));
    }
    progress.finish_and_clear();
    print(args, &measured, out)?;
    if args.time {
        eprint!("{}", times(&measured));
    }
    let Some(dir) = &args.out else { return Ok(()) };
    pictures(dir, args, &measured, out)
}

fn rows(args: &RivalsArgs) -> Vec<RivalRow> {
    let mut rows = Vec::new();
    for symmetric in args.symmetry.each() {
        for rival in &args.rivals.0 {
            rows.extend(args.moves.iter().map(|moves| RivalRow {
                rival: *rival,
                symmetric: *symmetric,
                moves: *moves,
            }));
        }
    }
    rows
}

fn trial(args: &RivalsArgs) -> RivalTrial {
    RivalTrial {
        generator: args.generator,
        first: args.first,
        worlds: args.worlds,
        steps: args.steps,
        sonar: args.sonar.into(),
        shield: args.shield,
        timed: args.time,
    }
}

fn print(args: &RivalsArgs, measured: &[Measured], out: &mut impl Write) -> Result<(), CliError> {
    if args.json {
        for row in measured {
            writeln!(out, "{}", object(row))?;
        }
        return Ok(());
    }
    let format = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    let cells: Vec<_> = measured.iter().map(cells).collect();
    let right = [2, 3, 4, 5, 6, 7, 8];
    out.write_all(format(&HEADS, &cells, &right).as_bytes())?;
    Ok(writeln!(out, "\n{}. [95 % interval]", about(args))?)
}

const fn on_off(symmetric: bool) -> &'static str {
    if symmetric { "yes" } else { "no" }
}

fn cells((row, outcome): &Measured) -> Vec<String> {
    vec![
        row.rival.name().to_owned(),
        on_off(row.symmetric).to_owned(),
        row.moves.to_string(),
        format!("{:.0}", outcome.clean.percent()),
        format!("{:.2}", outcome.contacts_per_100_m),
        format!("{:.1}", outcome.coverage_m2),
        format!("{:.3}", outcome.wall_error_m),
        format!("{:.0}", outcome.nest.percent()),
        format!("{:.1}", outcome.bytes / 1_024.0),
    ]
}

/// Everything but the times, which depend on the machine.
fn object((row, outcome): &Measured) -> serde_json::Value {
    let mean = |mean: Mean| json!({ "mean": mean.mean, "interval": mean.interval });
    json!({
        "rival": row.rival.name(),
        "symmetry": row.symmetric,
        "random_moves": row.moves,
        "clean_share": mean(outcome.clean),
        "contacts_per_100_m": mean(outcome.contacts_per_100_m),
        "coverage_m2": mean(outcome.coverage_m2),
        "wall_error_m": mean(outcome.wall_error_m),
        "nest_share": mean(outcome.nest),
        "bytes": outcome.bytes,
    })
}

/// Wall times of this machine, as a table.
fn times(measured: &[Measured]) -> String {
    let cells = |(row, outcome): &Measured| {
        vec![
            row.rival.name().to_owned(),
            on_off(row.symmetric).to_owned(),
            row.moves.to_string(),
            format!("{:.2}", outcome.learning_us / 1e3),
            format!("{:.1}", outcome.decision_us),
        ]
    };
    let rows: Vec<_> = measured.iter().map(cells).collect();
    let heads = [
        "rival",
        "symmetry",
        "random moves",
        "ms to learn",
        "µs per decision",
    ];
    table::plain(&heads, &rows, &[2, 3, 4])
}

/// What the table was measured in.
fn about(args: &RivalsArgs) -> String {
    format!(
        "{}, {} steps of each behavior",
        conditions(args),
        args.steps
    )
}

fn conditions(args: &RivalsArgs) -> String {
    format!(
        "{} worlds of {} from {} on, {} sonars, {} shield",
        args.worlds,
        args.generator.name(),
        args.first,
        match SonarModel::from(args.sonar) {
            SonarModel::Ideal => "exact",
            SonarModel::Nomad => "noisy",
            SonarModel::Harsh => "harsh",
        },
        if args.shield { "with the" } else { "without" },
    )
}

/// A picture: its name, its title, and which rivals are drawn beside the maps.
type Picture = (&'static str, &'static str, fn(Rival) -> bool);

const PICTURES: [Picture; 2] = [
    (
        "models",
        "Other models beside the two maps",
        Rival::is_model,
    ),
    (
        "quantizers",
        "Other quantizers in the action map's slot",
        Rival::is_quantizer,
    ),
];

/// Draws models and quantizers apart, each beside the maps.
fn pictures(
    dir: &Path,
    args: &RivalsArgs,
    measured: &[Measured],
    out: &mut impl Write,
) -> Result<(), CliError> {
    for (name, title, belongs) in PICTURES {
        let drawn = args.rivals.0.iter().copied();
        let drawn: Vec<_> = drawn
            .filter(|rival| belongs(*rival) || !(rival.is_model() || rival.is_quantizer()))
            .collect();
        if !drawn.iter().any(|rival| belongs(*rival)) {
            continue;
        }
        let svg = picture(title, args, measured, &drawn);
        let [picture, _] = save_picture(dir, &format!("rivals-{name}"), &svg)?;
        writeln!(out, "Picture: {}", picture.display())?;
    }
    Ok(())
}

/// A measure in the picture: its name, its largest value, and its accessor.
type Drawn = (&'static str, f64, fn(&RivalOutcome) -> Mean);

const DRAWN: [Drawn; 3] = [
    ("area, m²", f64::INFINITY, |outcome| outcome.coverage_m2),
    ("wall error, m", f64::INFINITY, |outcome| {
        outcome.wall_error_m
    }),
    ("nest found, %", 100.0, |outcome| outcome.nest.percent()),
];

fn picture(title: &str, args: &RivalsArgs, measured: &[Measured], drawn: &[Rival]) -> String {
    let name = |rival: &Rival| {
        let dashed = !(rival.is_model() || rival.is_quantizer());
        (rival.name().to_owned(), dashed)
    };
    let key = CurveKey {
        subtitle: format!("{}; line: mean, band: 95 % interval", conditions(args)),
        along: "random moves".to_owned(),
        ticks: args.moves.iter().map(u16::to_string).enumerate().collect(),
        names: drawn.iter().map(name).collect(),
    };
    let panel = |symmetric: bool, (measure, most, value): Drawn| {
        let of_rival = |rival: &Rival| {
            let own = measured.iter();
            let own = own.filter(|(row, _)| row.rival == *rival && row.symmetric == symmetric);
            own.map(|(_, outcome)| value(outcome)).collect()
        };
        Curves {
            title: if symmetric {
                "each move in 16 turns".to_owned()
            } else {
                "each move as it was".to_owned()
            },
            measure: measure.to_owned(),
            within: [0.0, most],
            lines: drawn.iter().map(of_rival).collect(),
        }
    };
    let symmetries = args.symmetry.each().iter();
    let panels: Vec<_> = symmetries
        .flat_map(|symmetric| DRAWN.map(|measure| panel(*symmetric, measure)))
        .collect();
    curves(title, &key, &panels)
}
