//! `host-sim patrol`: shows a robot a round of stations and measures whether it goes on by itself.

use super::output::{bar, pool};
use super::robot::NamedRobotArgs;
use super::run::{Preset, SonarChoice, Switch, sources};
use super::setup::configured;
use super::{CliError, table};
use arena::world::{MAX_COORDINATE_M, Point};
use clap::Args;
use experiments::patrol::{MISSING, NamerSummary, PatrolTrial, Patrols, measure, summarize};
use files::error::BadInput;
use plots::draw::layout::counted;
use sim::pilot::MAX_MOVES;
use std::io::Write;

/// Flags of the `patrol` command.
#[derive(Debug, Clone, Args)]
pub struct PatrolArgs {
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
    /// Random stations in each world
    #[arg(long, value_name = "STATIONS", default_value_t = 4, value_parser = clap::value_parser!(u32).range(2..=20))]
    stations: u32,
    /// A station, meters, instead of random ones; give it once for each, in their order
    #[arg(long = "station", value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    given: Vec<Point>,
    /// Seeds of each world
    #[arg(long, value_name = "SEEDS", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1_000))]
    seeds: u32,
    /// Decisions of one drive, at most
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// Random moves before the first drive
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    explore: u16,
    /// First seed of all randomness: the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Print Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Print one JSON object per round instead of the table
    #[arg(long)]
    json: bool,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

fn point(text: &str) -> Result<Point, String> {
    let number = |text: &str| {
        let number = text.trim().parse().ok();
        number.filter(|number: &f64| number.abs() <= MAX_COORDINATE_M)
    };
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    match numbers.as_deref() {
        Some([x, y]) => Ok(Point::new(*x, *y)),
        _ => Err("not X,Y in meters".to_owned()),
    }
}

/// Measures and prints the table.
///
/// # Errors
/// An unknown robot or world, a station where the robot does not fit, or an output that cannot be
/// written.
pub fn patrol(args: &PatrolArgs, out: &mut impl Write) -> Result<(), CliError> {
    let trial = trial(args)?;
    let sources = sources(&args.worlds)?;
    check(&trial, &sources)?;
    let progress = bar(sources.len() as u64 * u64::from(args.seeds), "rounds");
    let done = || progress.inc(1);
    let patrols = pool(args.threads)?.install(|| measure(&trial, &sources, &done))?;
    progress.finish_and_clear();
    if args.json {
        for round in patrols.iter().flat_map(|one| &one.rounds) {
            serde_json::to_writer(&mut *out, round).map_err(std::io::Error::from)?;
            writeln!(out)?;
        }
        return Ok(());
    }
    print_table(args, &patrols, out)?;
    let stations = match trial.given.len() {
        0 => trial.stations as usize,
        given => given,
    };
    Ok(writeln!(
        out,
        "\n{} × {}, {stations} stations, robot {} [95 % interval over the worlds]; {} ended early.",
        counted(sources.len(), "world"),
        counted(args.seeds as usize, "seed"),
        trial.robot.model().name,
        patrols.iter().filter(|one| one.stopped.is_some()).count()
    )?)
}

fn trial(args: &PatrolArgs) -> Result<PatrolTrial, BadInput> {
    if args.given.len() == 1 {
        return Err(BadInput::new(
            "--station: a round has two stations at least",
        ));
    }
    Ok(PatrolTrial {
        seed: args.seed,
        seeds: args.seeds,
        stations: args.stations,
        given: args.given.clone(),
        explore_moves: args.explore,
        steps: args.steps,
        robot: args.robot.behind_points(args.shield == Switch::On)?,
        sonar: args.sonar.into(),
        config: configured(Preset::Default, &[], args.shield, Switch::On)?,
    })
}

/// The robot fits at the given stations in all worlds.
fn check(trial: &PatrolTrial, sources: &[arena::loaders::WorldSource]) -> Result<(), BadInput> {
    for source in sources.iter().filter(|_| !trial.given.is_empty()) {
        let world = source.load()?;
        let radius_m = trial.robot.model().radius_m;
        let has_room =
            |place: &&Point| !world.is_inside(**place) && world.clearance(**place) >= radius_m;
        if let Some(Point { x, y }) = trial.given.iter().find(|place| !has_room(place)) {
            let name = world.name();
            let why =
                format!("--station {x},{y}: there is no room for the robot in the world {name}");
            return Err(BadInput::new(why));
        }
    }
    Ok(())
}

fn print_table(args: &PatrolArgs, all: &[Patrols], out: &mut impl Write) -> Result<(), CliError> {
    let right = MISSING.map(|missing| match missing {
        0 => "next named right, %".to_owned(),
        _ => format!("{missing} values missing"),
    });
    let fixed = [
        "next station by",
        "rounds",
        "completed, %",
        "stations reached, %",
        "error, m",
        "contacts",
    ];
    let heads: Vec<_> = fixed
        .into_iter()
        .chain(right.iter().map(String::as_str))
        .collect();
    let rows: Vec<_> = summarize(all, args.seeds).iter().map(row).collect();
    let columns: Vec<_> = (1..heads.len()).collect();
    let format = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    Ok(out.write_all(format(&heads, &rows, &columns).as_bytes())?)
}

fn row(namer: &NamerSummary) -> Vec<String> {
    let led = |text: String| {
        if namer.rounds > 0 {
            text
        } else {
            String::new()
        }
    };
    let mut row = vec![
        namer.namer.name().to_owned(),
        led(namer.rounds.to_string()),
        led(format!("{:.1}", namer.completed.percent())),
        led(format!("{:.1}", namer.reached.percent())),
        led(format!("{:.2}", namer.error_m)),
        led(namer.contacts.to_string()),
    ];
    let shares = namer
        .right
        .map(|right| right.map(|share| format!("{:.1}", share.percent())));
    row.extend(shares.map(Option::unwrap_or_default));
    row
}
