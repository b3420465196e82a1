//! `host-sim ablation`: the effect of each option, changed one at a time.

use super::output::bar;
use super::run::SonarChoice;
use super::{CliError, neurons, table};
use clap::Args;
use experiments::ablation::{
    AblationFigures, AblationTrial, Variant, VariantDriver, behavior_variants, measure, variants,
};
use experiments::behaviors;
use experiments::scenes::{BehaviorScene, scenes_named};
use files::error::BadInput;
use std::io::Write;

/// Flags of the `ablation` command.
#[derive(Debug, Clone, Args)]
pub struct AblationArgs {
    /// Random rooms per row
    #[arg(long, value_name = "ROOMS", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    rooms: u32,
    /// Seed of the first room
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    first: u64,
    /// Steps per room
    #[arg(long, value_name = "STEPS", default_value_t = 1_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    steps: u32,
    /// Seed of the first room's episode; each further room uses the next seed
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Sonar model
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Neurons of each map: 4, 9, 16, 25, 36, 49 or 64
    #[arg(long, value_name = "N", default_value_t = 16, conflicts_with = "behaviors", value_parser = neurons::parsed)]
    neurons: u8,
    /// Only rows whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Measure all behaviors instead, each in one scene without the shield; rooms = worlds, 5 seeds
    /// in each
    #[arg(long, conflicts_with_all = ["seed", "steps"])]
    behaviors: bool,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
}

const HEADS: [&str; 8] = [
    "option",
    "clean rooms %",
    "clean exploring %",
    "contacts/room",
    "distance m",
    "coverage m²",
    "goal held %",
    "shield stops",
];

/// Scenes in the table of behaviors.
const BEHAVIOR_SCENES: [(&str, &str); 7] = [
    ("avoid-right", "one obstacle"),
    ("wall-right", "plain room"),
    ("wall-right", "five boxes"),
    ("wall-right", "corridor"),
    ("nest", "4 m × 4 m"),
    ("nest", "six boxes"),
    ("follow", "five boxes"),
];

/// Seeds per world in that table.
const BEHAVIOR_SEEDS: u32 = 5;

/// Measures and prints the table.
///
/// # Errors
/// When no row matches `--only`, an episode fails, or the pipe is closed.
pub fn ablation(args: &AblationArgs, out: &mut impl Write) -> Result<(), CliError> {
    let chosen = chosen_variants(args)?;
    let progress = bar(chosen.len() as u64, "rows");
    let mut rows = Vec::new();
    for variant in &chosen {
        let row = if args.behaviors {
            behavior_row(variant, args)
        } else {
            avoidance_row(variant, args)
        };
        let failed = |failure| BadInput::new(format!("{}: {failure}", variant.name));
        rows.push(row.map_err(failed)?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let scenes = BEHAVIOR_SCENES.map(|(behavior, place)| format!("{behavior}, {place}"));
    let heads: Vec<_> = if args.behaviors {
        let scenes = scenes.iter().map(String::as_str);
        [HEADS[0]].into_iter().chain(scenes).collect()
    } else {
        HEADS.to_vec()
    };
    let right: Vec<_> = (1..heads.len()).collect();
    let text = if args.markdown {
        table::markdown
    } else {
        table::plain
    }(&heads, &rows, &right);
    Ok(out.write_all(text.as_bytes())?)
}

fn chosen_variants(args: &AblationArgs) -> Result<Vec<Variant>, BadInput> {
    let mut chosen = if args.behaviors {
        behavior_variants()?
    } else {
        variants()?
    };
    if let Some(text) = &args.only {
        chosen.retain(|variant| variant.name.contains(text.as_str()));
        if chosen.is_empty() {
            let why = format!("--only \"{text}\": no row has this in its name");
            return Err(BadInput::new(why));
        }
    }
    Ok(chosen)
}

fn avoidance_row(
    variant: &Variant,
    args: &AblationArgs,
) -> Result<Vec<String>, sim::error::EpisodeError> {
    let trial = AblationTrial {
        first: args.first,
        rooms: args.rooms,
        explore_moves: 100,
        steps: args.steps,
        seed: args.seed,
        sonar: args.sonar.into(),
        neurons: args.neurons,
    };
    let figures = measure(variant, &trial)?;
    Ok(row(&variant.name, &figures, f64::from(args.rooms)))
}

fn behavior_row(
    variant: &Variant,
    args: &AblationArgs,
) -> Result<Vec<String>, sim::error::EpisodeError> {
    let mut row = vec![variant.name.clone()];
    let VariantDriver::Mind(config, turret) = &variant.driver else {
        return Ok(row);
    };
    let trial = behaviors::BehaviorTrial {
        robot: None,
        first: args.first,
        worlds: args.rooms,
        seeds: BEHAVIOR_SEEDS,
        explore_moves: 100,
        preset: "",
        config: (**config).clone(),
        turret: *turret,
        sonar: args.sonar.into(),
    };
    let listed = |(behavior, place)| {
        let fits = |scene: &&&BehaviorScene| scene.behavior == behavior && scene.place == place;
        scenes_named(Some(behavior)).iter().find(fits).copied()
    };
    for scene in BEHAVIOR_SCENES.into_iter().filter_map(listed) {
        let outcome = behaviors::measure(scene, &trial, &|| ())?;
        row.push(format!("{:.3}", outcome.value.mean));
    }
    Ok(row)
}

fn row(name: &str, figures: &AblationFigures, rooms: f64) -> Vec<String> {
    vec![
        name.to_owned(),
        format!("{:.1}", 100.0 * f64::from(figures.clean) / rooms),
        format!("{:.1}", 100.0 * f64::from(figures.clean_exploring) / rooms),
        format!("{:.2}", figures.contacts),
        format!("{:.1}", figures.distance_m),
        format!("{:.2}", figures.coverage_m2),
        format!("{:.1}", 100.0 * figures.goal_share),
        format!("{:.1}", figures.shield_stops),
    ]
}
