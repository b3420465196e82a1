//! `host-sim errands`: sends a robot from place to place, again and again, while its world changes.

use super::output::{bar, pool, prepare};
use super::robot::NamedRobotArgs;
use super::run::{Preset, SonarChoice, Switch, sources};
use super::setup::configured;
use super::{CliError, table};
use clap::Args;
use experiments::errands::{ErrandTrial, PeriodSummary, WorldErrands, measure, summarize};
use files::error::BadInput;
use plots::draw::layout::counted;
use plots::{CurveKey, Curves, save_picture};
use sim::episode::Period;
use sim::pilot::MAX_MOVES;
use sim::statistics::Mean;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Flags of the `errands` command.
#[derive(Debug, Clone, Args)]
pub struct ErrandsArgs {
    /// Worlds, as for `run`; may be given several times
    #[arg(long = "world", value_name = "WORLD", default_value = "random2:1..=12")]
    worlds: Vec<String>,
    #[command(flatten)]
    robot: NamedRobotArgs,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Let the guard keep the robot from everything it has seen
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    shield: Switch,
    /// Random places in each world, which the robot visits in turn, and then home
    #[arg(long, value_name = "PLACES", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=100))]
    places: u32,
    /// How often it visits all of them
    #[arg(long, value_name = "ROUNDS", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    rounds: u32,
    /// Instead of so many rounds: as many as it can in so many hours
    #[arg(long, value_name = "HOURS", conflicts_with = "rounds", value_parser = clap::value_parser!(u32).range(1..=1_000))]
    hours: Option<u32>,
    /// After so many rounds, or hours, an obstacle stands where it makes the ways longest, and
    /// after as many it is gone
    #[arg(long, value_name = "PERIODS", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    change_every: Option<u32>,
    /// Decisions of one drive, at most
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// Random moves before the first drive
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    explore: u16,
    /// Seed of all randomness: the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object per drive instead of the table
    #[arg(long)]
    json: bool,
    /// Write a picture of the figures by period into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

const HEADS: [&str; 9] = [
    "drives",
    "obstructed",
    "there, %",
    "elsewhere, %",
    "way / shortest",
    "way, m",
    "touched",
    "error, m",
    "places known",
];

/// Measures and prints the table.
///
/// # Errors
/// An unknown robot or world, or an output that cannot be written.
pub fn errands(args: &ErrandsArgs, out: &mut impl Write) -> Result<(), CliError> {
    let trial = trial(args)?;
    let sources = sources(&args.worlds)?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let progress = bar(sources.len() as u64, "worlds");
    let done = || progress.inc(1);
    let worlds = pool(args.threads)?.install(|| measure(&trial, &sources, &done))?;
    progress.finish_and_clear();
    let periods = summarize(&trial, &worlds);
    if args.json {
        print_drives(&worlds, out)?;
    } else {
        print_table(args.markdown, &trial, &periods, out)?;
        writeln!(out, "\n{}.", about(&trial, worlds.len()))?;
        for world in &worlds {
            if let Some(why) = &world.stopped {
                writeln!(out, "world {}: {why}", world.world)?;
            }
        }
    }
    if let Some(dir) = &args.out {
        let picture = picture(dir, &trial, worlds.len(), &periods)?;
        if !args.json {
            writeln!(out, "Picture: {}", picture.display())?;
        }
    }
    Ok(())
}

fn trial(args: &ErrandsArgs) -> Result<ErrandTrial, BadInput> {
    Ok(ErrandTrial {
        seed: args.seed,
        places: args.places,
        period: args.hours.map_or(Period::Round, |_| Period::Hour),
        periods: args.hours.unwrap_or(args.rounds),
        change_every: args.change_every,
        explore_moves: args.explore,
        steps: args.steps,
        robot: args.robot.behind_points(args.shield == Switch::On)?,
        sonar: args.sonar.into(),
        config: configured(Preset::Default, &[], args.shield, Switch::On)?,
    })
}

fn print_drives(worlds: &[WorldErrands], out: &mut impl Write) -> Result<(), CliError> {
    for drive in worlds.iter().flat_map(WorldErrands::drives) {
        serde_json::to_writer(&mut *out, &drive).map_err(std::io::Error::from)?;
        writeln!(out)?;
    }
    Ok(())
}

fn print_table(
    is_markdown: bool,
    trial: &ErrandTrial,
    periods: &[PeriodSummary],
    out: &mut impl Write,
) -> Result<(), CliError> {
    let format = if is_markdown {
        table::markdown
    } else {
        table::plain
    };
    let heads: Vec<_> = [name(trial.period)].into_iter().chain(HEADS).collect();
    let rows: Vec<_> = (1..).zip(periods).map(row).collect();
    let right: Vec<_> = (0..heads.len()).collect();
    Ok(out.write_all(format(&heads, &rows, &right).as_bytes())?)
}

const fn name(period: Period) -> &'static str {
    match period {
        Period::Round => "round",
        Period::Hour => "hour",
    }
}

fn row((number, period): (u32, &PeriodSummary)) -> Vec<String> {
    vec![
        number.to_string(),
        period.errands.to_string(),
        period.obstructed.to_string(),
        format!("{:.1}", period.there.percent()),
        format!("{:.1}", period.elsewhere.percent()),
        format!("{:.2}", period.way),
        format!("{:.1}", period.distance_m),
        period.touched.to_string(),
        format!("{:.2}", period.error_m),
        format!("{:.0}", period.known),
    ]
}

/// What the table was measured in.
fn about(trial: &ErrandTrial, worlds: usize) -> String {
    let robot = &trial.robot.model().name;
    let obstacle = match trial.change_every {
        None => String::new(),
        Some(every) => format!(
            "; an obstacle comes and goes after {}",
            counted(every as usize, name(trial.period))
        ),
    };
    let worlds = counted(worlds, "world");
    format!(
        "{worlds}, {} places and home, robot {robot}{obstacle} [95 % interval]",
        trial.places
    )
}

fn picture(
    dir: &Path,
    trial: &ErrandTrial,
    worlds: usize,
    periods: &[PeriodSummary],
) -> Result<PathBuf, BadInput> {
    let along = name(trial.period);
    let last = periods.len().saturating_sub(1);
    let key = CurveKey {
        subtitle: about(trial, worlds),
        along: along.to_owned(),
        ticks: vec![(0, "1".to_owned()), (last, periods.len().to_string())],
        names: Vec::new(),
    };
    let panel = |title: &str, measure: &str, most: f64, value: fn(&PeriodSummary) -> Mean| Curves {
        title: title.to_owned(),
        measure: measure.to_owned(),
        within: [0.0, most],
        lines: vec![periods.iter().map(value).collect()],
    };
    let panels = [
        panel("Drives that ended there", "%", 100.0, |p| p.there.percent()),
        panel("Way", "of the shortest", f64::INFINITY, |p| p.way),
        panel("Places known", "places", f64::INFINITY, |p| p.known),
    ];
    let svg = plots::curves("Errands", &key, &panels);
    let [picture, _] = save_picture(dir, "errands", &svg)?;
    Ok(picture)
}
