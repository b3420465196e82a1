//! `host-sim repetition`: does a behaviour improve by being repeated?

use super::output::bar;
use super::run::SonarChoice;
use super::{Failure, table};
use crate::error::BadInput;
use crate::experiments::behaviors::{Mean, SCENES, Trial};
use crate::experiments::repetition::{Curve, measure};
use amp::config::Config;
use clap::Args;
use std::io::Write;

/// The `repetition` command's flags.
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
    /// What the sonars return
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Change one open choice (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Only scenes whose behaviour contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
}

const HEADS: [&str; 8] = [
    "behaviour",
    "where",
    "measure",
    "maps",
    "first",
    "middle",
    "last",
    "learning less frozen, last half",
];

/// Measures and prints the table, without the shield.
///
/// # Errors
/// When no scene has the asked name, an episode fails, or the pipe is closed.
pub fn repetition(args: &RepetitionArgs, out: &mut impl Write) -> Result<(), Failure> {
    let mut config = Config::recommended();
    crate::settings::apply(&mut config, &args.sets)?;
    config.shield = None;
    let trial = Trial {
        worlds: args.worlds,
        seeds: args.seeds,
        config,
        turret: crate::robot::TurretMode::Held,
        sonar: args.sonar.into(),
    };
    let named = |name: &str| {
        args.only
            .as_ref()
            .is_none_or(|text| name.contains(text.as_str()))
    };
    // A chain repeats its parts already.
    let chosen: Vec<_> = SCENES
        .iter()
        .filter(|scene| named(scene.behavior) && !scene.behavior.contains(','))
        .collect();
    if chosen.is_empty() {
        let text = args.only.as_deref().unwrap_or_default();
        let why = format!("--only \"{text}\": no behaviour has that in its name");
        return Err(BadInput::new(why).into());
    }
    let progress = bar(chosen.len() as u64, "scenes");
    let mut rows = Vec::new();
    for scene in chosen {
        let curve = measure(scene, &trial, args.times)
            .map_err(|failure| BadInput::new(format!("{}: {failure}", scene.behavior)))?;
        let names = [scene.behavior, scene.place, scene.measure];
        rows.extend(curve_rows(names, &curve));
        progress.inc(1);
    }
    progress.finish_and_clear();
    let text = if args.markdown {
        table::markdown
    } else {
        table::plain
    }(&HEADS, &rows, &[4, 5, 6, 7]);
    Ok(out.write_all(text.as_bytes())?)
}

fn curve_rows(names: [&str; 3], curve: &Curve) -> [Vec<String>; 2] {
    let interval = |mean: &Mean| {
        let [low, high] = mean.interval;
        format!("{:.3} [{low:.3}, {high:.3}]", mean.mean)
    };
    let row = |maps: &str, means: &[Mean], last: String| {
        let at = |index: usize| means.get(index).map_or_else(String::new, interval);
        let mut row: Vec<_> = names.map(str::to_owned).into();
        row.extend([
            maps.to_owned(),
            at(0),
            at(means.len() / 2),
            at(means.len().saturating_sub(1)),
            last,
        ]);
        row
    };
    [
        row("learning", &curve.learning, interval(&curve.difference)),
        row("frozen", &curve.frozen, String::new()),
    ]
}
