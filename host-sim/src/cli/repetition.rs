//! `host-sim repetition`: measures whether a behavior improves by repetition.

use super::output::{bar, prepare};
use super::run::{Preset, SonarChoice};
use super::{CliError, table};
use clap::Args;
use experiments::behaviors::BehaviorTrial;
use experiments::repetition::{Curve, measure};
use experiments::scenes::{BehaviorScene, scenes_named};
use files::error::BadInput;
use plots::{CurveKey, Curves};
use sim::pilot::MAX_MOVES;
use sim::statistics::Mean;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Flags of the `repetition` command.
#[derive(Debug, Clone, Args)]
pub struct RepetitionArgs {
    /// Worlds per scene
    #[arg(long, value_name = "WORLDS", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    worlds: u32,
    /// Seeds per world
    #[arg(long, value_name = "SEEDS", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=999))]
    seeds: u32,
    /// Repetitions
    #[arg(long, value_name = "TIMES", default_value_t = 8, value_parser = clap::value_parser!(u32).range(2..=1_000))]
    times: u32,
    /// Random moves before the first repetition: fewer leave more to learn
    #[arg(long, value_name = "MOVES", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_MOVES)))]
    explore: u16,
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
    /// Only behaviors whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
    /// Write a picture of the curves into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

const HEADS: [&str; 8] = [
    "behavior",
    "where",
    "measure",
    "first",
    "last, learning",
    "last, frozen",
    "learning minus frozen, last half",
    "differs",
];

/// Measures and prints the table, without the shield.
///
/// # Errors
/// When no behavior matches `--only`, an episode fails, or something cannot be written.
pub fn repetition(args: &RepetitionArgs, out: &mut impl Write) -> Result<(), CliError> {
    let trial = trial(args)?;
    let scenes = chosen(args.only.as_deref())?;
    if let Some(dir) = &args.out {
        prepare(dir)?;
    }
    let each = u64::from(args.worlds) * u64::from(args.seeds);
    let progress = bar(2 * each * scenes.len() as u64, "series");
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for scene in scenes {
        let curve = measure(scene, &trial, args.times, &|| progress.inc(1))
            .map_err(|failure| BadInput::new(format!("{}: {failure}", scene.title())))?;
        rows.push(row(scene, &curve));
        panels.push(Curves {
            title: scene.title(),
            measure: scene.measure.to_owned(),
            within: [f64::NEG_INFINITY, f64::INFINITY],
            lines: vec![curve.frozen, curve.learning],
        });
    }
    progress.finish_and_clear();
    let text = if args.markdown {
        table::markdown
    } else {
        table::plain
    }(&HEADS, &rows, &[3, 4, 5, 6]);
    out.write_all(text.as_bytes())?;
    writeln!(
        out,
        "\nMean [95 % interval] of {} worlds × {} seeds, {} repetitions after {} random moves, without the shield.",
        args.worlds, args.seeds, args.times, args.explore
    )?;
    args.out
        .as_ref()
        .map_or(Ok(()), |dir| picture(dir, args.times, &panels, out))
}

fn trial(args: &RepetitionArgs) -> Result<BehaviorTrial, BadInput> {
    let mut config = args.preset.config();
    sim::settings::apply(&mut config, &args.sets)?;
    config.shield = None;
    Ok(BehaviorTrial {
        robot: None,
        worlds: args.worlds,
        seeds: args.seeds,
        first: args.first,
        explore_moves: args.explore,
        preset: args.preset.name(),
        config,
        turret: args.preset.turret(),
        sonar: args.sonar.into(),
    })
}

/// The scenes for repetition. Skips chains, which already repeat their parts, and scenes with their
/// own sonars.
fn chosen(only: Option<&str>) -> Result<Vec<&'static BehaviorScene>, BadInput> {
    let mut scenes = scenes_named(only);
    scenes.retain(|scene| !scene.behavior.contains(',') && scene.sonar.is_none());
    match (scenes.is_empty(), only) {
        (true, Some(text)) => Err(BadInput::new(format!(
            "--only \"{text}\": no behavior that is repeated has this in its name"
        ))),
        _ => Ok(scenes),
    }
}

fn row(scene: &BehaviorScene, curve: &Curve) -> Vec<String> {
    let text = |mean: Option<&Mean>| mean.map(Mean::to_string).unwrap_or_default();
    let [low, high] = curve.difference.interval;
    let differs = if low > 0.0 || high < 0.0 { "yes" } else { "no" };
    vec![
        scene.behavior.to_owned(),
        scene.place.to_owned(),
        scene.measure.to_owned(),
        text(curve.learning.first()),
        text(curve.learning.last()),
        text(curve.frozen.last()),
        curve.difference.to_string(),
        differs.to_owned(),
    ]
}

fn picture(
    dir: &Path,
    times: u32,
    panels: &[Curves],
    out: &mut impl Write,
) -> Result<(), CliError> {
    let key = CurveKey {
        subtitle: "Mean and 95 % interval by repetition · orange: the maps keep learning · blue: frozen maps".to_owned(),
        along: "repetition".to_owned(),
        ticks: vec![(0, "1".to_owned()), (times as usize - 1, times.to_string())],
        names: Vec::new(),
    };
    let svg = plots::curves("Does repetition improve a behavior?", &key, panels);
    let [picture, _] = plots::save_picture(dir, "repetition", &svg)?;
    Ok(writeln!(out, "Picture: {}", picture.display())?)
}
