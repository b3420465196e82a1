//! `host-sim ablation`: the worth of each open choice.

use super::output::bar;
use super::run::SonarChoice;
use super::{Failure, table};
use crate::error::BadInput;
use crate::experiments::ablation::{Figures, Trial, measure, variants};
use clap::Args;
use std::io::Write;

/// The `ablation` command's flags.
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
    /// Seed of the first room's episode; each further room has the next one
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// What the sonars return
    #[arg(long, value_name = "MODEL", default_value = "ideal", value_enum)]
    sonar: SonarChoice,
    /// Only rows whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Print Markdown
    #[arg(long)]
    markdown: bool,
}

const HEADS: [&str; 8] = [
    "choice",
    "clean rooms %",
    "clean exploring %",
    "contacts/room",
    "distance m",
    "coverage m²",
    "goal held %",
    "shield stops",
];

/// Measures and prints the table.
///
/// # Errors
/// When no row has the asked name, an episode fails, or the pipe is closed.
pub fn ablation(args: &AblationArgs, out: &mut impl Write) -> Result<(), Failure> {
    let trial = Trial {
        first: args.first,
        rooms: args.rooms,
        explore_moves: 100,
        steps: args.steps,
        seed: args.seed,
        sonar: args.sonar.into(),
    };
    let mut chosen = variants()?;
    if let Some(text) = &args.only {
        chosen.retain(|variant| variant.name.contains(text.as_str()));
        if chosen.is_empty() {
            return Err(
                BadInput::new(format!("--only \"{text}\": no row has that in its name")).into(),
            );
        }
    }
    let progress = bar(chosen.len() as u64, "rows");
    let mut rows = Vec::new();
    for variant in &chosen {
        let figures = measure(variant, &trial)
            .map_err(|failure| BadInput::new(format!("{}: {failure}", variant.name)))?;
        rows.push(row(&variant.name, &figures, f64::from(args.rooms)));
        progress.inc(1);
    }
    progress.finish_and_clear();
    let right: Vec<_> = (1..HEADS.len()).collect();
    let text = if args.markdown {
        table::markdown
    } else {
        table::plain
    }(&HEADS, &rows, &right);
    Ok(out.write_all(text.as_bytes())?)
}

fn row(name: &str, figures: &Figures, rooms: f64) -> Vec<String> {
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
