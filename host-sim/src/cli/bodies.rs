//! `host-sim bodies`: measures robots whose sensors stand anywhere on their bodies.

use super::output::{bar, prepare};
use super::robot::ToldArgs;
use super::setup::parsed;
use super::{CliError, table};
use amp::config::Config;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use clap::{Args, ValueEnum};
use experiments::bodies::{BodyOutcome, BodyTrial, Control, Generator, measure, measure_control};
use files::error::BadInput;
use plots::{DotPanel, DotSection, dot_plot, save_picture};
use sim::pilot::MAX_MOVES;
use sim::robot::{AnyRobot, Origin, Ranges};
use sim::statistics::Mean;
use std::io::Write;
use std::path::PathBuf;

/// Flags of the `bodies` command.
#[derive(Debug, Clone, Args)]
pub struct BodiesArgs {
    /// Robots, with commas between: built-in names or .toml files (see docs/robots.md); "ring" is
    /// the Nomad's ring on its held turret, without points
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        default_value = "ring,nomad200,p3dx,p3dx-front,epuck2,thymio2"
    )]
    robots: Vec<String>,
    /// What the robots have: everything their own, or their layout and drive on the Nomad's body
    #[arg(long, value_name = "own|nomad", default_value = "nomad", value_parser = parsed::<Ranges>)]
    ranges: Ranges,
    #[command(flatten)]
    told: ToldArgs,
    /// What chooses the moves: the maps, or a rule without maps, which only avoids obstacles and
    /// has no guard
    #[arg(long, value_name = "NAME", default_value = "maps", value_enum)]
    method: Method,
    /// Generator of the worlds
    #[arg(long, value_name = "NAME", default_value = "random", value_enum)]
    generator: GeneratorChoice,
    /// Number of worlds
    #[arg(long, value_name = "WORLDS", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    worlds: u32,
    /// Seed of the first world: below 10 000 for tuning, from there on for reporting
    #[arg(long, value_name = "SEED", default_value_t = 10_000)]
    first: u64,
    /// Random moves before the behavior
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    explore: u16,
    /// Steps of each behavior
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
    /// Folder for the table as a picture
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// What chooses the moves, as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Method {
    /// The two maps
    Maps,
    /// A range shrinks by the cosine of the angle to the move: nothing is learned
    Cosine,
    /// Random moves: each range is linear in the move, by least squares
    LeastSquares,
    /// The same by least absolute deviations
    Robust,
    /// Random moves: the mean of the five most similar ones
    Nearest,
}

impl Method {
    const fn control(self) -> Option<Control> {
        match self {
            Self::Maps => None,
            Self::Cosine => Some(Control::Cosine),
            Self::LeastSquares => Some(Control::LeastSquares),
            Self::Robust => Some(Control::Robust),
            Self::Nearest => Some(Control::Nearest),
        }
    }
}

/// Generators as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum GeneratorChoice {
    /// Rooms with boxes
    Random,
    /// Worlds of twelve other kinds
    Random2,
}

/// The Nomad's ring on its held turret.
const RING: &str = "ring";

const HEADS: [&str; 10] = [
    "robot",
    "sensors",
    "limited by",
    "clean worlds, %",
    "contacts per km",
    "distance, m",
    "wall error, m",
    "nest found, %",
    "bearing error, degrees: median, worst",
    "stopped",
];

/// Measures and prints the table.
///
/// # Errors
/// An unknown robot or a bad file.
pub fn bodies(args: &BodiesArgs, out: &mut impl Write) -> Result<(), CliError> {
    let control = args.method.control();
    if control.is_some() && args.told.geometry() == Origin::Learned {
        return Err(BadInput::new(
            "--geometry learned: only with the maps, not with another --method",
        )
        .into());
    }
    let robots = robots(args)?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let conditions = [SonarModel::Ideal, SonarModel::Nomad];
    let guards = if control.is_some() {
        &[false][..]
    } else {
        &[false, true]
    };
    let per_row = u64::from(args.worlds) * if control.is_some() { 1 } else { 3 };
    let rows = (robots.len() * conditions.len() * guards.len()) as u64;
    let progress = bar(per_row * rows, "episodes");
    let mut rows = Vec::new();
    for (name, robots) in &robots {
        for sonar in conditions {
            for (&has_guard, robot) in guards.iter().zip(robots) {
                let (robot, trial) = (robot.as_ref(), trial(args, has_guard));
                let done = || progress.inc(1);
                let outcome = match control {
                    None => measure(robot, sonar, &trial, &done),
                    Some(control) => measure_control(robot, control, sonar, &trial, &done),
                };
                rows.push(BodyRow {
                    name,
                    sonar,
                    has_guard,
                    outcome,
                });
            }
        }
    }
    progress.finish_and_clear();
    let format = if args.markdown {
        table::markdown
    } else {
        table::plain
    };
    let cells: Vec<_> = rows.iter().map(BodyRow::cells).collect();
    out.write_all(format(&HEADS, &cells, &[3, 4, 5, 6, 7, 8, 9]).as_bytes())?;
    let about = about(args);
    writeln!(
        out,
        "\n{about}; {} random moves and {} steps of each behavior. [95 % interval]",
        args.explore, args.steps
    )?;
    if let Some(dir) = &args.out {
        let subtitle = format!("{about}; dot: mean, line: 95 % interval");
        let svg = dot_plot("Robots of all layouts", &subtitle, &sections(&rows));
        let [picture, _] = save_picture(dir, "bodies", &svg)?;
        writeln!(out, "Picture: {}", picture.display())?;
    }
    Ok(())
}

/// What the table was measured in.
fn about(args: &BodiesArgs) -> String {
    format!(
        "{} worlds of {} from {} on, {}",
        args.worlds,
        trial(args, false).generator.name(),
        args.first,
        match args.ranges {
            Ranges::Own => "bodies and ranges are the robots' own",
            Ranges::Nomad => "layouts and drives on the Nomad's body",
        }
    )
}

/// Each robot by name, without and with a guard; `None` for the ring on its turret.
type NamedRobots = Vec<(String, [Option<AnyRobot>; 2])>;

fn robots(args: &BodiesArgs) -> Result<NamedRobots, BadInput> {
    let robot = |name: &String| {
        if name == RING {
            return Ok((name.clone(), [None, None]));
        }
        let model = RobotModel::find(name)?;
        let built = |has_guard| {
            let robot = AnyRobot::new(model.clone(), args.ranges, has_guard)?;
            args.told.apply(robot, args.explore).map(Some)
        };
        Ok((name.clone(), [built(false)?, built(true)?]))
    };
    args.robots.iter().map(robot).collect()
}

fn trial(args: &BodiesArgs, has_guard: bool) -> BodyTrial {
    let mut config = Config::recommended();
    if !has_guard {
        config.shield = None;
    }
    BodyTrial {
        generator: match args.generator {
            GeneratorChoice::Random => Generator::Random,
            GeneratorChoice::Random2 => Generator::Random2,
        },
        first: args.first,
        worlds: args.worlds,
        explore_moves: args.explore,
        steps: args.steps,
        config,
    }
}

/// A row of the table.
struct BodyRow<'a> {
    name: &'a str,
    sonar: SonarModel,
    has_guard: bool,
    outcome: BodyOutcome,
}

impl BodyRow<'_> {
    fn limited_by(&self) -> &'static str {
        match (self.has_guard, self.name) {
            (false, _) => "nothing",
            (true, RING) => "shield",
            (true, _) => "guard",
        }
    }

    fn cells(&self) -> Vec<String> {
        let outcome = &self.outcome;
        let drove = outcome.worlds - outcome.stopped;
        let none = || "–".to_owned();
        let driven = |text: String| if drove > 0 { text } else { none() };
        let shown = |mean: Option<Mean>, digits: usize| {
            mean.map_or_else(none, |mean| format!("{mean:.digits$}"))
        };
        let errors_deg = outcome.bearing_errors_deg;
        vec![
            self.name.to_owned(),
            sensors(self.sonar).to_owned(),
            self.limited_by().to_owned(),
            format!("{:.1}", outcome.clean.percent()),
            driven(format!("{:.2}", outcome.contacts_per_km())),
            driven(format!("{:.0}", outcome.distance_m / drove as f64)),
            shown(outcome.wall_error_m, 2),
            shown(outcome.nest.map(Mean::percent), 1),
            errors_deg.map_or_else(none, |[median, worst]| format!("{median:.1}, {worst:.1}")),
            outcome.stopped.to_string(),
        ]
    }
}

const fn sensors(sonar: SonarModel) -> &'static str {
    match sonar {
        SonarModel::Ideal => "exact",
        SonarModel::Nomad | SonarModel::Harsh => "noisy",
    }
}

/// The rows as a picture: exact sensors above, noisy ones below.
fn sections(rows: &[BodyRow<'_>]) -> Vec<DotSection> {
    let section = |sonar: SonarModel| {
        let rows: Vec<_> = rows.iter().filter(|row| row.sonar == sonar).collect();
        let panel = |name: &str, most: f64, value: fn(&BodyOutcome) -> Option<Mean>| DotPanel {
            name: name.to_owned(),
            within: [0.0, most],
            means: rows.iter().map(|row| value(&row.outcome)).collect(),
        };
        let label = |row: &&BodyRow<'_>| {
            let limited = match row.limited_by() {
                "nothing" => row.name.to_owned(),
                by => format!("{}, {by}", row.name),
            };
            (limited, row.outcome.worlds)
        };
        let mut panels = vec![
            panel("clean worlds, %", 100.0, |o| Some(o.clean.percent())),
            panel("wall error, m", f64::INFINITY, |o| o.wall_error_m),
            panel("nest found, %", 100.0, |o| o.nest.map(Mean::percent)),
        ];
        panels.retain(|panel| panel.means.iter().any(Option::is_some));
        DotSection {
            title: format!("{} sensors", sensors(sonar)),
            labels: rows.iter().map(label).collect(),
            panels,
        }
    };
    [SonarModel::Ideal, SonarModel::Nomad].map(section).into()
}
