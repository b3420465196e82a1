//! `host-sim run`: runs episodes in any worlds and prints their metrics.

use super::CliError;
use super::goal;
use super::neurons::NeuronArgs;
use super::output::{bar, pool, prepare};
pub use super::preset::Preset;
use super::remote::{MindArgs, MindChoice, Remote, needs_places};
use super::setup::SetupArgs;
use super::summary;
use amp::config::PlannerKind;
use arena::loaders::{WorldSource, parse_worlds};
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use clap::{Args, ValueEnum};
use files::error::BadInput;
use rayon::prelude::*;
use remote::link::Knowledge;
use remote::log;
use sim::behavior::TourBy;
use sim::episode::{self, Episode, EpisodeReport, Setup};
use sim::pilot::InspectableController;
use sim::robot::AnyRobot;
use sim::sim_controller::SimController;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Largest number of steps of an episode.
const MAX_STEPS: u32 = 10_000_000;

/// Worlds in progress at once: bounds memory, and keeps the lines in order.
const CHUNK: usize = 256;

/// Flags of the `run` command; all are optional.
#[derive(Debug, Clone, Args)]
pub struct RunArgs {
    /// World: a .toml or ROS .yaml FILE, a FOLDER of them, random:SEED, random:A..=B (rooms with
    /// boxes), random2:SEED, random2:A..=B (corridors, mazes and ten other kinds), barn:FILE#N,
    /// barn:FILE#A..=B (BARN benchmark), or a built-in name (see `host-sim worlds`); may be given
    /// several times
    #[arg(long = "world", value_name = "WORLD", default_value = "paper")]
    worlds: Vec<String>,
    #[command(flatten)]
    setup: SetupArgs,
    #[command(flatten)]
    neurons: NeuronArgs,
    /// Pursue the goal of this FILE instead of the behavior's own, by whose measure the robot is
    /// judged (see `host-sim goal`); with avoid, avoid-right, wall-left, wall-right, nest or follow
    #[arg(long, value_name = "FILE")]
    goal: Option<PathBuf>,
    /// Decisions toward the goal
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_STEPS)))]
    steps: u32,
    #[command(flatten)]
    pub(super) mind: MindArgs,
    /// Print one JSON object per world instead of a table
    #[arg(long)]
    json: bool,
    /// Write pictures and a page for each world into this folder
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Write the controller's final state into this file, for `host-sim link … upload` (one world,
    /// --mind host)
    #[arg(long, value_name = "FILE")]
    pub(super) save: Option<PathBuf>,
    /// Write all events and answers of the controller into a new FILE in the MCAP format (one world
    /// only), for `replay`, `log` and other tools
    #[arg(long, value_name = "FILE")]
    pub(super) log: Option<PathBuf>,
    /// Worker threads [default: one per core]; they do not affect the results
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl RunArgs {
    /// The setup of its episodes, without a recording.
    ///
    /// # Errors
    /// An unknown setting or an invalid value.
    pub(super) fn setup(&self) -> Result<Setup, BadInput> {
        let setup = self.setup.setup()?;
        Ok(Setup {
            steps: self.steps,
            goal: goal::of_file(self.goal.as_deref(), &setup.behavior)?,
            ..setup
        })
    }
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Switch {
    /// On.
    On,
    /// Off.
    Off,
}

/// What leads a robot on a tour, as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TourChoice {
    /// Its places, to where it has not been.
    Frontier,
    /// Nothing: it avoids obstacles.
    Avoid,
}

impl From<TourChoice> for TourBy {
    fn from(choice: TourChoice) -> Self {
        match choice {
            TourChoice::Frontier => Self::Frontier,
            TourChoice::Avoid => Self::Avoid,
        }
    }
}

/// Sonar models as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SonarChoice {
    /// Exact distances, measured at once
    Ideal,
    /// A Nomad 200's intact ring: lobes, mirror reflections, noise, whole inches
    Nomad,
    /// All kinds of disturbance
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
pub(super) enum TurretChoice {
    /// The ring keeps its bearing in the world
    Held,
    /// The ring turns with the heading
    Follow,
}

impl From<TurretChoice> for TurretMode {
    fn from(choice: TurretChoice) -> Self {
        match choice {
            TurretChoice::Held => Self::Held,
            TurretChoice::Follow => Self::Follow,
        }
    }
}

/// Runs the episodes and prints their lines in the order of the worlds.
///
/// # Errors
/// Bad input before the first episode; a world that cannot be loaded; a closed pipe.
pub fn run(args: &RunArgs, out: &mut impl Write) -> Result<(), CliError> {
    let setup = Setup {
        record: args.out.is_some(),
        ..args.setup()?
    };
    let sources = sources(&args.worlds)?;
    check_outputs(args, sources.len())?;
    check_robot(&setup)?;
    args.neurons.check(args, &setup)?;
    check_planner(args, &setup)?;
    let mut remote = Remote::connect(&args.mind, setup.explore_moves, setup.robot.as_ref())?;
    if let Some(remote) = &mut remote {
        check_remote(args, &setup, remote)?;
    }
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let began = std::time::Instant::now();
    let mut reports = Vec::new();
    let mut print = |report: EpisodeReport| {
        if args.json {
            return write_json(out, &report);
        }
        reports.push(report);
        Ok(())
    };
    match remote {
        None => in_parallel(args, &setup, &sources, &mut print)?,
        Some(remote) => one_by_one(args, &setup, &sources, remote, &mut print)?,
    }
    if !args.json {
        out.write_all(summary::table(&reports).as_bytes())?;
    }
    let episodes = match sources.len() {
        1 => "1 episode".into(),
        count => format!("{count} episodes"),
    };
    eprintln!("{episodes} in {:.2} s", began.elapsed().as_secs_f64());
    Ok(())
}

/// Refuses a controller's file or a log for more than one world.
fn check_outputs(args: &RunArgs, worlds: usize) -> Result<(), BadInput> {
    if let Some(file) = &args.save
        && (worlds > 1 || args.mind.choice != MindChoice::Host)
    {
        return Err(BadInput::new(format!(
            "--save {}: only the controller in this process, of one world (a chip's: host-sim link … download)",
            file.display()
        )));
    }
    if let (Some(path), true) = (&args.log, worlds != 1) {
        let what = format!("a log holds one episode, not one of each of {worlds} worlds");
        return Err(BadInput::file(path, what));
    }
    Ok(())
}

/// Refuses what is sought in another modality without a memory of places.
fn check_robot(setup: &Setup) -> Result<(), BadInput> {
    let is_led = setup.robot.as_ref().is_none_or(AnyRobot::is_led);
    match setup.behavior.sense_goals().next() {
        Some(goal) if !is_led => Err(BadInput::new(format!(
            "--places off: the behavior {} needs a memory of places",
            goal.name()
        ))),
        _ => Ok(()),
    }
}

/// Refuses plans of several steps by a controller at the other end of a link: devices have no graph
/// of traversed situations.
fn check_planner(args: &RunArgs, setup: &Setup) -> Result<(), BadInput> {
    let is_here = args.mind.choice == MindChoice::Host;
    if is_here || setup.config.planning.planner != PlannerKind::Traversed {
        return Ok(());
    }
    Err(BadInput::new(
        "--preset graph, --set planner=traversed: only with --mind host; a device has no graph of \
         traversed situations",
    ))
}

/// Refuses what a controller at the other end of a link cannot do without a memory of places.
fn check_remote(args: &RunArgs, setup: &Setup, remote: &mut Remote) -> Result<(), BadInput> {
    if setup.robot.is_none() || remote.has_places()? {
        return Ok(());
    }
    let goal = setup.behavior.sense_goals().next();
    let goal = goal.map(|goal| format!("--behavior {}", goal.name()));
    let log = args
        .log
        .as_ref()
        .map(|path| format!("--log {}", path.display()));
    match goal.or(log) {
        Some(what) => Err(needs_places(&what, &remote.address().to_string())),
        None => Ok(()),
    }
}

/// Receives the metrics of each world, in order.
type Print<'p> = &'p mut dyn FnMut(EpisodeReport) -> Result<(), CliError>;

fn in_parallel(
    args: &RunArgs,
    setup: &Setup,
    sources: &[WorldSource],
    print: Print<'_>,
) -> Result<(), CliError> {
    let pool = pool(args.threads)?;
    let progress = bar(sources.len() as u64, "worlds");
    for (number, chunk) in sources.chunks(CHUNK).enumerate() {
        let one = |(index, source): (usize, &WorldSource)| {
            let folder = folder(args, number * CHUNK + index, source, sources.len());
            let mut mind = SimController::new(&setup.config, setup.robot.as_ref());
            let report = episode(source, folder.as_deref(), |world| {
                match args.neurons.other() {
                    Some(neurons) => episode::run_sized(neurons, world, setup, |_, _, _| {}),
                    None => drive(world, setup, &mut mind, args.log.as_deref()),
                }
            })?;
            if let Some(file) = &args.save {
                Knowledge::of_controller(&mind).save(file)?;
            }
            progress.inc(1);
            Ok::<_, BadInput>(report)
        };
        let lines: Vec<_> = pool.install(|| chunk.par_iter().enumerate().map(one).collect());
        for line in lines {
            print(line?)?;
        }
    }
    progress.finish_and_clear();
    Ok(())
}

/// Runs the episodes in sequence: there is only one chip.
fn one_by_one(
    args: &RunArgs,
    setup: &Setup,
    sources: &[WorldSource],
    mut remote: Remote,
    print: Print<'_>,
) -> Result<(), CliError> {
    let progress = bar(sources.len() as u64, "worlds");
    for (index, source) in sources.iter().enumerate() {
        let folder = folder(args, index, source, sources.len());
        print(episode(source, folder.as_deref(), |world| {
            remote.episode(world, setup, args.log.as_deref())
        })?)?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(())
}

pub(super) fn sources(names: &[String]) -> Result<Vec<WorldSource>, BadInput> {
    let mut sources = Vec::new();
    for name in names {
        sources.extend(parse_worlds(name)?);
    }
    Ok(sources)
}

/// The folder of one world's pictures: the given one, or one inside it if there are several worlds.
fn folder(args: &RunArgs, index: usize, source: &WorldSource, count: usize) -> Option<PathBuf> {
    let dir = args.out.as_deref()?;
    if count == 1 {
        return Some(dir.to_owned());
    }
    let name = source.to_string();
    let name = Path::new(&name)
        .file_stem()
        .and_then(|stem| stem.to_str())
        .unwrap_or("world");
    let tame = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    Some(dir.join(format!(
        "{:04}-{}",
        index + 1,
        name.chars().map(tame).collect::<String>()
    )))
}

fn episode(
    source: &WorldSource,
    folder: Option<&Path>,
    run: impl FnOnce(&World) -> Result<Episode, sim::error::EpisodeError>,
) -> Result<EpisodeReport, BadInput> {
    let world = source.load()?;
    let episode = run(&world)
        .map_err(|failure| BadInput::new(format!("world {}: {failure}", world.name())))?;
    if let (Some(folder), Some(recording)) = (folder, &episode.recording) {
        plots::demo::write(folder, recording, &summary::rows(&episode.report), &[])?;
    }
    Ok(episode.report)
}

/// Runs an episode, with a log if one is requested.
pub(super) fn drive(
    world: &World,
    setup: &Setup,
    mind: &mut impl InspectableController,
    log: Option<&Path>,
) -> Result<Episode, sim::error::EpisodeError> {
    match log {
        Some(path) => log::run(world, setup, mind, path),
        None => episode::run_with(world, setup, mind, |_, _, _| {}),
    }
}

fn write_json(out: &mut impl Write, report: &EpisodeReport) -> Result<(), CliError> {
    serde_json::to_writer(&mut *out, report).map_err(std::io::Error::from)?;
    Ok(out.write_all(b"\n")?)
}
