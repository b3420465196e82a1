//! The goal of a controller on a chip, by its name or its file.

use amp::config::Config;
use amp::goal::{Goal, Name, SaveGoalError};
use amp::wire::message::GoalSpec;
use files::error::BadInput;
use sim::behavior::Behavior;
use sim::goal_file::GoalFile;
use std::path::Path;

/// Parses a goal.
pub(super) fn spec(text: &str) -> Result<GoalSpec<16>, BadInput> {
    Ok(match text {
        "avoid" => GoalSpec::Avoid,
        "perceived" => GoalSpec::Perceived,
        text => match saved_goal(text) {
            Some(saved) => GoalSpec::Saved(name(saved)?),
            None => GoalSpec::Components(goal_by_name(text)?),
        },
    })
}

/// The name behind `saved:`, or behind its former spelling.
fn saved_goal(text: &str) -> Option<&str> {
    text.strip_prefix("saved:")
        .or_else(|| text.strip_prefix("kept:"))
}

/// Parses the name of a saved goal.
pub(super) fn name(text: &str) -> Result<Name, BadInput> {
    let name = Name::new(text);
    name.ok_or_else(|| BadInput::new(format!("\"{text}\": {}", SaveGoalError::Name)))
}

/// The goal of a behavior with the ranges of the preset `default`, or the goal of a file.
fn goal_by_name(name: &str) -> Result<Goal<16>, BadInput> {
    let is_file = name.contains(['.', '/']) || Path::new(name).exists();
    if is_file {
        return Ok(GoalFile::load(name.as_ref())?.goal);
    }
    let goal = name.parse::<Behavior>()?.fixed_goal(&Config::recommended());
    goal.ok_or_else(|| {
        BadInput::new(format!(
            "goal {name}: a controller on a chip takes one goal at a time; at the nest, `goal perceived` captures it"
        ))
    })
}
