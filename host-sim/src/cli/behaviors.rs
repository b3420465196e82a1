//! `host-sim behaviors`: results of each behavior, without and with the shield.

use super::output::{bar, prepare};
use super::robot::RobotArgs;
use super::run::{Preset, SonarChoice};
use super::{CliError, summary, table};
use clap::Args;
use experiments::behaviors::{BehaviorTrial, SceneOutcome, first, measure};
use experiments::scenes::{BehaviorScene, scenes_named};
use files::error::BadInput;
use plots::ShownBehavior;
use sim::behavior::Behavior;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Flags of the `behaviors` command.
#[derive(Debug, Clone, Args)]
pub struct BehaviorsArgs {
    /// Measure every scene, in this many worlds [default: a short list, 3 worlds; with --seeds 10]
    #[arg(long, value_name = "WORLDS", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    worlds: Option<u32>,
    /// Measure every scene, with this many seeds per world [default: a short list, 4 seeds; with
    /// --worlds 30]
    #[arg(long, value_name = "SEEDS", value_parser = clap::value_parser!(u32).range(1..=999))]
    seeds: Option<u32>,
    /// Number of the first world; each has its own rooms and seeds
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    first: u64,
    /// Preset of the controller's options
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    preset: Preset,
    /// Change one option (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    #[command(flatten)]
    robot: RobotArgs,
    /// Only behaviors whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
    /// Write a picture of all behaviors, and pictures and a page for each, into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// The short list: worlds and seeds.
const SHORT: (u32, u32) = (3, 4);
/// Random moves before each behavior.
const EXPLORE_MOVES: u16 = 100;
/// The whole table.
const WHOLE: (u32, u32) = (10, 30);

const LIST_HEADS: [&str; 6] = [
    "behavior",
    "what it does",
    "measured",
    "required",
    "maps alone",
    "with shield",
];

const TABLE_HEADS: [&str; 8] = [
    "behavior",
    "where",
    "measure",
    "required",
    "maps alone",
    "contact steps %",
    "with shield",
    "contact steps %",
];

/// Measures and prints the list, or the whole table if its size is given.
///
/// # Errors
/// When no behavior matches `--only`, an episode fails, or something cannot be written.
pub fn behaviors(args: &BehaviorsArgs, out: &mut impl Write) -> Result<(), CliError> {
    let short = args.worlds.is_none() && args.seeds.is_none();
    let mut scenes = chosen(args.only.as_deref())?;
    if short {
        scenes.dedup_by_key(|scene| scene.behavior);
    }
    let (bare, shielded) = trials(args, if short { SHORT } else { WHOLE })?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let each = u64::from(bare.worlds) * u64::from(bare.seeds);
    let progress = bar(2 * each * scenes.len() as u64, "episodes");
    let mut rows = Vec::new();
    for scene in &scenes {
        let measured = |trial: &BehaviorTrial| {
            let outcome = measure(scene, trial, &|| progress.inc(1));
            outcome.map_err(|failure| BadInput::new(format!("{}: {failure}", scene.title())))
        };
        let row = if short { list_row } else { table_row };
        rows.push(row(scene, &measured(&bare)?, &measured(&shielded)?));
    }
    progress.finish_and_clear();
    let (heads, right): (&[&str], &[usize]) = if short {
        (&LIST_HEADS, &[4, 5])
    } else {
        (&TABLE_HEADS, &[4, 5, 6, 7])
    };
    let text = if args.markdown {
        table::markdown
    } else {
        table::plain
    }(heads, &rows, right);
    out.write_all(text.as_bytes())?;
    print_notes(&bare, short, out)?;
    match &args.out {
        Some(dir) => pictures(&scenes, &shielded, dir, out),
        None if short => Ok(writeln!(out, "Pictures: host-sim behaviors --out DIR")?),
        None => Ok(()),
    }
}

/// The size of the measurement, and how to repeat a short one as a whole.
fn print_notes(trial: &BehaviorTrial, short: bool, out: &mut impl Write) -> Result<(), CliError> {
    let (worlds, seeds) = (trial.worlds, trial.seeds);
    writeln!(
        out,
        "\nMean [95 % interval] of {worlds} worlds × {seeds} seeds, each with its own 100 random moves."
    )?;
    if short {
        let (worlds, seeds) = WHOLE;
        writeln!(
            out,
            "Every scene, with more episodes: host-sim behaviors --worlds {worlds} --seeds {seeds}"
        )?;
    }
    Ok(())
}

fn chosen(only: Option<&str>) -> Result<Vec<&'static BehaviorScene>, BadInput> {
    let scenes = scenes_named(only);
    match (scenes.is_empty(), only) {
        (true, Some(text)) => Err(BadInput::new(format!(
            "--only \"{text}\": no behavior has this in its name"
        ))),
        _ => Ok(scenes),
    }
}

/// Without the shield, and with it.
fn trials(
    args: &BehaviorsArgs,
    (worlds, seeds): (u32, u32),
) -> Result<(BehaviorTrial, BehaviorTrial), BadInput> {
    let mut config = args.preset.config();
    sim::settings::apply(&mut config, &args.sets)?;
    let robot = args.robot.find(true, EXPLORE_MOVES, None)?;
    if let Some(robot) = &robot {
        config = robot.config(config);
    }
    let shielded = BehaviorTrial {
        worlds: args.worlds.unwrap_or(worlds),
        seeds: args.seeds.unwrap_or(seeds),
        first: args.first,
        explore_moves: EXPLORE_MOVES,
        preset: args.preset.name(),
        config,
        turret: args.preset.turret(),
        robot,
        sonar: args.sonar.into(),
    };
    let mut bare = shielded.clone();
    bare.config.shield = None;
    bare.robot = args.robot.find(false, EXPLORE_MOVES, None)?;
    Ok((bare, shielded))
}

fn list_row(scene: &BehaviorScene, bare: &SceneOutcome, shielded: &SceneOutcome) -> Vec<String> {
    vec![
        scene.behavior.to_owned(),
        Behavior::about(scene.behavior).to_owned(),
        format!("{}, {}", scene.measure, scene.place),
        scene.required.to_owned(),
        format!("{:.3}", bare.value.mean),
        format!("{:.3}", shielded.value.mean),
    ]
}

fn table_row(scene: &BehaviorScene, bare: &SceneOutcome, shielded: &SceneOutcome) -> Vec<String> {
    vec![
        scene.behavior.to_owned(),
        scene.place.to_owned(),
        scene.measure.to_owned(),
        scene.required.to_owned(),
        bare.value.to_string(),
        format!("{:.3}", bare.contacts_percent),
        shielded.value.to_string(),
        format!("{:.3}", shielded.contacts_percent),
    ]
}

/// Writes the pictures of each scene's first episode into a folder of its name, and one of all
/// behaviors.
fn pictures(
    scenes: &[&BehaviorScene],
    trial: &BehaviorTrial,
    dir: &Path,
    out: &mut impl Write,
) -> Result<(), CliError> {
    let mut scenes = scenes.to_vec();
    scenes.dedup_by_key(|scene| (scene.behavior, scene.place));
    let progress = bar(scenes.len() as u64, "pictures");
    let mut shown = Vec::new();
    for scene in scenes {
        let episode = first(scene, trial)
            .map_err(|failure| BadInput::new(format!("{}: {failure}", scene.title())))?;
        let Some(recording) = episode.recording else {
            continue;
        };
        let folder = dir.join(safe_name(&scene.title()));
        let rows = summary::rows(&episode.report);
        plots::demo::write(&folder, &recording, &rows, &[])?;
        shown.push(ShownBehavior {
            name: scene.behavior.to_owned(),
            about: format!("{}: {}", Behavior::about(scene.behavior), scene.place),
            recording,
        });
        progress.inc(1);
    }
    progress.finish_and_clear();
    let title = "Behaviors, each from 100 random moves";
    let svg = plots::behaviors(title, &shown);
    let [picture, _] = plots::save_picture(dir, "behaviors", &svg)?;
    let dir = dir.display();
    Ok(writeln!(
        out,
        "Pictures: {}, and a page for each behavior in {dir}/*/index.html",
        picture.display()
    )?)
}

/// A valid name of a folder.
fn safe_name(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric());
    let words: Vec<_> = words.filter(|word| !word.is_empty()).collect();
    words.join("-")
}
