//! `host-sim goal`: prints the goal of a behavior as a file, or learns one from a demonstration.

mod learn;

use crate::cli::CliError;
use crate::cli::run::{Preset, Switch};
use crate::cli::setup::{configured, parsed};
use clap::{Args, Subcommand};
use files::error::BadInput;
use sim::behavior::Behavior;
use sim::goal_file::{self, GoalFile};
use std::io::Write;
use std::path::Path;

/// Flags of the `goal` command.
#[derive(Debug, Clone, Args)]
#[command(
    args_conflicts_with_subcommands = true,
    after_help = "\
Examples:
  host-sim goal wall-right > wall.toml
  host-sim run --world office --behavior wall-right --goal wall.toml
      the same as without the file, until you change it
  host-sim goal learn --from wall.mcap -o shown.toml
      the goal that a logged drive pursued"
)]
pub struct GoalArgs {
    #[command(subcommand)]
    command: Option<GoalCommand>,
    /// avoid, avoid-right, wall-left, wall-right, follow, or seek:FILE
    #[arg(value_name = "BEHAVIOR", value_parser = parsed::<Behavior>, required = true)]
    behavior: Option<Behavior>,
    /// Preset of the controller's options, which define the scale of the situation
    #[arg(long, value_name = "NAME", default_value = "default", value_enum)]
    preset: Preset,
    /// Change one option, e.g. --set clearance=0.4 (see `host-sim settings`); may be given several
    /// times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
}

#[derive(Debug, Clone, Subcommand)]
enum GoalCommand {
    /// Find the goal that a demonstration pursued
    Learn(learn::GoalLearnArgs),
}

/// The goal of a file that is pursued instead of the behavior's own.
///
/// # Errors
/// A behavior that has none of its own, or several; a bad file.
pub(in crate::cli) fn of_file(
    path: Option<&Path>,
    behavior: &Behavior,
) -> Result<Option<Box<GoalFile>>, BadInput> {
    let Some(path) = path else {
        return Ok(None);
    };
    if matches!(behavior, Behavior::Seek(_)) || behavior.parts().len() > 1 {
        let what = "--goal: the behaviors seek:FILE and a,b,c have goals of their own";
        return Err(BadInput::new(what));
    }
    if matches!(behavior, Behavior::Home { .. } | Behavior::Sense { .. }) {
        let what = format!("--goal: the behavior {} is led by places", behavior.name());
        return Err(BadInput::new(what));
    }
    Ok(Some(Box::new(GoalFile::load(path)?)))
}

/// Prints the goal of a behavior, or learns one.
///
/// # Errors
/// A behavior whose goal is that of a place, or has several; an unknown option; a bad
/// demonstration; a closed pipe.
pub fn goal(args: &GoalArgs, out: &mut impl Write) -> Result<(), CliError> {
    if let Some(GoalCommand::Learn(args)) = &args.command {
        return learn::learn(args, out);
    }
    let config = configured(args.preset, &args.sets, Switch::On, Switch::On)?;
    let name = args
        .behavior
        .as_ref()
        .map_or_else(String::new, Behavior::name);
    let goal = args
        .behavior
        .as_ref()
        .and_then(|behavior| behavior.fixed_goal(&config));
    let Some(goal) = goal else {
        return Err(BadInput::new(format!(
            "goal {name}: its goal is found where the robot is; `host-sim capture` writes that of a place"
        ))
        .into());
    };
    let text = goal_file::whole_text(&goal, &name, &goal_file::scale(config.encoding));
    Ok(out.write_all(text.as_bytes())?)
}
