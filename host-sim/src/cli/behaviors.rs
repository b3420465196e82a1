//! `host-sim behaviors`: what each behaviour reaches, by the maps alone and with the shield.

use super::output::{bar, prepare};
use super::run::{Preset, SonarChoice};
use super::{Failure, table};
use crate::episode::run;
use crate::error::BadInput;
use crate::experiments::behaviors::{Outcome, SCENES, Scene, Trial};
use crate::plot;
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The `behaviors` command's flags.
#[derive(Debug, Clone, Args)]
pub struct BehaviorsArgs {
    /// Worlds per scene
    #[arg(long, value_name = "WORLDS", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    worlds: u32,
    /// Seeds per world
    #[arg(long, value_name = "SEEDS", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=999))]
    seeds: u32,
    /// The open choices of the method
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    preset: Preset,
    /// Change one open choice (see `host-sim settings`); may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// What the sonars return
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Only scenes whose behaviour contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
    /// Write pictures of each scene's first episode into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

const HEADS: [&str; 8] = [
    "behaviour",
    "where",
    "measure",
    "asked",
    "maps alone",
    "contact steps %",
    "with shield",
    "contact steps %",
];

/// Measures and prints the table.
///
/// # Errors
/// When no scene has the asked name, an episode fails, or something cannot be written.
pub fn behaviors(args: &BehaviorsArgs, out: &mut impl Write) -> Result<(), Failure> {
    let mut config = args.preset.config();
    crate::settings::apply(&mut config, &args.sets)?;
    let shielded = Trial {
        worlds: args.worlds,
        seeds: args.seeds,
        config,
        turret: args.preset.turret(),
        sonar: args.sonar.into(),
    };
    let mut bare = shielded.clone();
    bare.config.shield = None;
    let chosen: Vec<_> = SCENES
        .iter()
        .filter(|scene| {
            let named = |text: &String| scene.behavior.contains(text.as_str());
            args.only.as_ref().is_none_or(named)
        })
        .collect();
    if chosen.is_empty() {
        let text = args.only.as_deref().unwrap_or_default();
        return Err(BadInput::new(format!(
            "--only \"{text}\": no behaviour has that in its name"
        ))
        .into());
    }
    let progress = bar(chosen.len() as u64, "scenes");
    let mut rows = Vec::new();
    for scene in chosen {
        let measured = |trial: &Trial| {
            let outcome = scene.measure(trial);
            outcome.map_err(|failure| BadInput::new(format!("{}: {failure}", scene.behavior)))
        };
        rows.push(row(scene, &measured(&bare)?, &measured(&shielded)?));
        if let Some(dir) = &args.out {
            picture(scene, &shielded, dir)?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    let right = [4, 5, 6, 7];
    let text = if args.markdown {
        table::markdown
    } else {
        table::plain
    }(&HEADS, &rows, &right);
    Ok(out.write_all(text.as_bytes())?)
}

fn row(scene: &Scene, bare: &Outcome, shielded: &Outcome) -> Vec<String> {
    let value = |outcome: &Outcome| {
        let [low, high] = outcome.value.interval;
        format!("{:.3} [{low:.3}, {high:.3}]", outcome.value.mean)
    };
    vec![
        scene.behavior.to_owned(),
        scene.place.to_owned(),
        scene.measure.to_owned(),
        scene.asked.to_owned(),
        value(bare),
        format!("{:.3}", bare.contacts_percent),
        value(shielded),
        format!("{:.3}", shielded.contacts_percent),
    ]
}

/// The pictures of the scene's first episode, in a folder of its name.
fn picture(scene: &Scene, trial: &Trial, dir: &Path) -> Result<(), BadInput> {
    let world = scene.world(1);
    let mut setup = scene.setup(trial, &world, 1_000);
    setup.record = true;
    let episode = run(&world, &setup, |_, _, _| {})
        .map_err(|failure| BadInput::new(format!("{}: {failure}", scene.behavior)))?;
    let tame = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let name: String = format!("{}-{}", scene.behavior, scene.place)
        .chars()
        .map(tame)
        .collect();
    let folder = dir.join(name);
    prepare(&folder)?;
    if let Some(recording) = &episode.recording {
        plot::demo::write(
            &folder,
            recording,
            &super::summary::rows(&episode.report),
            &[],
        )?;
    }
    Ok(())
}
