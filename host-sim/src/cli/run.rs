//! `host-sim run`: episodes in any worlds.

use super::output::{bar, prepare};
use super::{Failure, table};
use crate::episode::{self, Report, Setup};
use crate::error::BadInput;
use crate::pilot::MOST_MOVES;
use crate::plot;
use crate::robot::TurretMode;
use crate::scenes::Behavior;
use crate::settings;
use crate::sonar::SonarModel;
use crate::world::{WorldSource, parse_worlds};
use amp::config::Config;
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Most steps of one episode.
const MOST_STEPS: u32 = 10_000_000;

/// Worlds in the air at once: bounds memory, and keeps the lines coming in order.
const CHUNK: usize = 256;

/// The `run` command's flags; every one may be left out.
#[derive(Debug, Clone, Args)]
pub struct RunArgs {
    /// World: a .toml or ROS .yaml FILE, a FOLDER of them, random:SEED, random:A..=B, or a built-in
    /// name (see `host-sim worlds`); may be given several times
    #[arg(long = "world", value_name = "WORLD", default_value = "paper")]
    worlds: Vec<String>,
    /// What to do after exploring: avoid, avoid-right, wall-left, wall-right, nest, follow, seek:FILE (a
    /// captured situation), or several of them one after the other: a,b,c (see `host-sim behaviors`)
    #[arg(long, value_name = "NAME", default_value = "avoid", value_parser = parse::<Behavior>)]
    behavior: Behavior,
    /// Random moves before it
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_MOVES)))]
    explore: u16,
    /// Decisions towards the goal
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_STEPS)))]
    steps: u32,
    /// Seed of all randomness: the same seed gives the same bytes
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Let the sonars limit motion: what the robot does (on) or what the maps alone do (off)
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    shield: Switch,
    /// Let both maps go on learning from every move
    #[arg(long, value_name = "ON|OFF", default_value = "on", value_enum)]
    online: Switch,
    /// What the sonars return
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Whether the ring keeps its bearing in the world or turns with the heading
    /// [default: held; follow for the preset touzet]
    #[arg(long, value_name = "MODE", value_enum)]
    turret: Option<TurretChoice>,
    /// The open choices of the method: the best found, or the most literal reading of the paper
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    preset: Preset,
    /// Change one open choice, e.g. --set far=1.2 (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Where the mind runs
    #[arg(long, value_name = "WHERE", default_value = "host", value_enum)]
    mind: MindChoice,
    /// Print one JSON object per world instead of a table
    #[arg(long)]
    json: bool,
    /// Write pictures and a page for each world into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Worker threads [default: one per core]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

fn parse<T: std::str::FromStr<Err = BadInput>>(text: &str) -> Result<T, BadInput> {
    text.parse()
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// On.
    On,
    /// Off.
    Off,
}

/// Sonar models as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SonarChoice {
    /// Exact distances, all at once
    Ideal,
    /// A Nomad 200's ring in good order: lobes, mirrors, noise, whole inches
    Nomad,
    /// Everything that can go wrong does
    Harsh,
}

impl From<SonarChoice> for SonarModel {
    fn from(choice: SonarChoice) -> Self {
        match choice {
            SonarChoice::Ideal => Self::Ideal,
            SonarChoice::Nomad => Self::Nomad,
            SonarChoice::Harsh => Self::Harsh,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TurretChoice {
    /// The ring keeps its bearing in the world
    Held,
    /// The ring turns with the heading
    Follow,
}

/// Presets as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Preset {
    /// The best found
    Default,
    /// The best that keeps the paper's four steps
    Probe,
    /// The most literal reading of the paper
    Touzet,
}

impl Preset {
    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Probe => "probe",
            Self::Touzet => "touzet",
        }
    }

    /// Its open choices.
    #[must_use]
    pub fn config(self) -> Config<16> {
        match self {
            Self::Default => Config::recommended(),
            Self::Probe => Config::probing(),
            Self::Touzet => Config::touzet(),
        }
    }

    /// What its ring does while the base steers.
    #[must_use]
    pub fn turret(self) -> TurretMode {
        match self {
            Self::Default | Self::Probe => TurretMode::Held,
            Self::Touzet => TurretMode::Follow,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MindChoice {
    /// In this process
    Host,
}

/// Runs the episodes and prints their lines in the worlds' order.
///
/// # Errors
/// Bad input before anything is run; a world that cannot be loaded when its turn comes; a closed pipe.
pub fn run(args: &RunArgs, out: &mut impl Write) -> Result<(), Failure> {
    let setup = setup(args)?;
    let sources = sources(&args.worlds)?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(args.threads.map_or(0, usize::from))
        .build();
    let pool = pool.map_err(|error| BadInput::new(format!("--threads: {error}")))?;
    let began = std::time::Instant::now();
    let progress = bar(sources.len() as u64, "worlds");
    let mut reports = Vec::new();
    for (number, chunk) in sources.chunks(CHUNK).enumerate() {
        let one = |(index, source): (usize, &WorldSource)| {
            let folder = args
                .out
                .as_deref()
                .map(|dir| folder(dir, number * CHUNK + index, source, sources.len()));
            let report = episode(source, &setup, folder.as_deref());
            progress.inc(1);
            report
        };
        let lines: Vec<_> = pool.install(|| chunk.par_iter().enumerate().map(one).collect());
        for line in lines {
            let report = line?;
            if args.json {
                write_json(out, &report)?;
            } else {
                reports.push(report);
            }
        }
    }
    progress.finish_and_clear();
    if !args.json {
        out.write_all(summary(&reports).as_bytes())?;
    }
    eprintln!(
        "{} episodes in {:.2} s",
        sources.len(),
        began.elapsed().as_secs_f64()
    );
    Ok(())
}

fn setup(args: &RunArgs) -> Result<Setup, BadInput> {
    let mut config = args.preset.config();
    settings::apply(&mut config, &args.sets)?;
    if args.shield == Switch::Off {
        config.shield = None;
    }
    if args.online == Switch::Off {
        config.online = None;
    }
    let MindChoice::Host = args.mind;
    Ok(Setup {
        config,
        preset: args.preset.name().to_owned(),
        behavior: args.behavior.clone(),
        explore_moves: args.explore,
        steps: args.steps,
        seed: args.seed,
        sonar: args.sonar.into(),
        turret: match args.turret {
            None => args.preset.turret(),
            Some(TurretChoice::Held) => TurretMode::Held,
            Some(TurretChoice::Follow) => TurretMode::Follow,
        },
        record: args.out.is_some(),
    })
}

pub(super) fn sources(names: &[String]) -> Result<Vec<WorldSource>, BadInput> {
    let mut sources = Vec::new();
    for name in names {
        sources.extend(parse_worlds(name)?);
    }
    Ok(sources)
}

/// The folder of one world's pictures: the given one, or one inside it where there are several worlds.
fn folder(dir: &Path, index: usize, source: &WorldSource, count: usize) -> PathBuf {
    if count == 1 {
        return dir.to_owned();
    }
    let name = source.to_string();
    let name = Path::new(&name)
        .file_stem()
        .and_then(|stem| stem.to_str())
        .unwrap_or("world");
    let tame = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    dir.join(format!(
        "{:04}-{}",
        index + 1,
        name.chars().map(tame).collect::<String>()
    ))
}

fn episode(source: &WorldSource, setup: &Setup, folder: Option<&Path>) -> Result<Report, BadInput> {
    let world = source.load()?;
    let episode = episode::run(&world, setup, |_, _, _| {})
        .map_err(|failure| BadInput::new(format!("world {}: {failure}", world.name())))?;
    if let (Some(folder), Some(recording)) = (folder, &episode.recording) {
        plot::demo::write(folder, recording, &summary_rows(&episode.report), &[])?;
    }
    Ok(episode.report)
}

fn write_json(out: &mut impl Write, report: &Report) -> Result<(), Failure> {
    serde_json::to_writer(&mut *out, report).map_err(std::io::Error::from)?;
    Ok(out.write_all(b"\n")?)
}

/// One episode as (label, value) rows.
pub(super) fn summary_rows(report: &Report) -> Vec<(String, String)> {
    let share = f64::from(report.goal_steps) / f64::from(report.steps.max(1)) * 100.0;
    let rows = [
        ("world", report.world.clone()),
        ("behavior", report.behavior.clone()),
        (
            "random moves",
            format!(
                "{} ({} touched something)",
                report.explore_moves, report.explore_contacts
            ),
        ),
        ("steps", report.steps.to_string()),
        ("steps with contact", report.contacts.to_string()),
        ("distance", format!("{:.1} m", report.distance_m)),
        (
            "least clearance",
            format!("{:.3} m", report.min_clearance_m),
        ),
        ("area swept", format!("{:.1} m²", report.coverage_m2)),
        ("goal held", format!("{share:.1} % of the steps")),
        (
            "shortened by the shield",
            format!("{} steps", report.shield_stops),
        ),
        ("simulated time", format!("{:.0} s", report.time_s)),
        (
            "success",
            format!("{:.4} ({})", report.success, report.success_unit),
        ),
    ];
    rows.map(|(label, value)| (label.to_owned(), value)).into()
}

/// The table over all worlds, with their means where there are several.
fn summary(reports: &[Report]) -> String {
    let heads = [
        "world",
        "explore contacts",
        "contacts",
        "distance m",
        "clearance m",
        "coverage m²",
        "goal %",
        "shield stops",
        "time s",
        "success",
    ];
    let mut rows: Vec<_> = reports
        .iter()
        .map(|report| cells(&report.world, &figures(report)))
        .collect();
    let count = reports.len() as f64;
    let mut tail = String::new();
    if reports.len() > 1 {
        let mut means = [0.0; 9];
        for report in reports {
            for (mean, figure) in means.iter_mut().zip(figures(report)) {
                *mean += figure / count;
            }
        }
        rows.push(cells("mean", &means));
        let clean = reports.iter().filter(|report| report.contacts == 0).count();
        let untouched = reports
            .iter()
            .filter(|report| report.explore_contacts == 0)
            .count();
        tail = format!(
            "\n{clean} of {} worlds without contact while seeking ({:.1} %), {untouched} without contact while exploring\n",
            reports.len(),
            100.0 * clean as f64 / count
        );
    }
    let right: Vec<_> = (1..heads.len()).collect();
    table::plain(&heads, &rows, &right) + &tail
}

fn figures(report: &Report) -> [f64; 9] {
    [
        f64::from(report.explore_contacts),
        f64::from(report.contacts),
        report.distance_m,
        report.min_clearance_m,
        report.coverage_m2,
        f64::from(report.goal_steps) / f64::from(report.steps.max(1)) * 100.0,
        f64::from(report.shield_stops),
        report.time_s,
        report.success,
    ]
}

fn cells(name: &str, figures: &[f64; 9]) -> Vec<String> {
    let digits = [2, 2, 1, 3, 1, 1, 1, 0, 4];
    let short = |value: f64, digits: usize| {
        let text = format!("{value:.digits$}");
        // A whole count needs no decimals; a mean of counts does.
        if value.fract() == 0.0 && digits == 2 {
            format!("{value:.0}")
        } else {
            text
        }
    };
    let mut row = vec![name.to_owned()];
    row.extend(
        figures
            .iter()
            .zip(digits)
            .map(|(&value, digits)| short(value, digits)),
    );
    row
}
