//! The commands of the page and the replies.

use serde::{Deserialize, Serialize};

/// A command with its number, `{"id": 7, "do": "explore"}`. The reply is `{"reply": 7}`, with
/// `"error": "why not"` if it was refused, or with `"file": {"name", "text"}` (or `"hex"`).
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct NumberedCommand {
    /// Returned in the reply.
    pub id: u64,
    /// The command.
    #[serde(flatten)]
    pub command: PageCommand,
}

/// A command. Lengths in meters, in the world's frame.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub enum PageCommand {
    /// Acquire the control lock.
    Steer {
        /// The run's token.
        token: String,
        /// Also from another viewer.
        #[serde(default)]
        over: bool,
    },
    /// Release the control lock.
    Leave,
    /// Stop.
    Stop,
    /// Make random moves.
    Explore,
    /// Learn the maps.
    Learn,
    /// Pursue the chosen goal.
    Seek,
    /// Resume what a stop interrupted.
    Resume,
    /// Take one decision, then pause.
    Step,
    /// Pause or resume time.
    Pause {
        /// Paused.
        paused: bool,
    },
    /// Set the speed of time.
    Speed {
        /// Simulated seconds per second; `None` = maximum.
        factor: Option<f64>,
    },
    /// Jump within a recording.
    Jump {
        /// Number of decisions before the new position.
        to: usize,
    },
    /// Restart; omitted values stay.
    Reset(Reset),
    /// Set a behavior as the goal; a seeking robot pursues it at once.
    Behavior {
        /// Its name.
        name: String,
        /// Steps of driving around before the way home.
        #[serde(default)]
        tour: Option<u32>,
    },
    /// Set a neuron's situation as the goal.
    GoalNeuron {
        /// Index of the neuron.
        neuron: usize,
    },
    /// Set the current situation as the goal.
    GoalHere,
    /// Set a position as the goal, for a robot with a memory of places.
    GoalPosition {
        /// Its x.
        x: f64,
        /// Its y.
        y: f64,
    },
    /// Set the goal of a file's text.
    GoalFile {
        /// The text.
        text: String,
    },
    /// Record what the robot does from now on, as a demonstration, or end that.
    Record {
        /// Record.
        on: bool,
    },
    /// Set the goal that the recorded demonstration pursued.
    GoalShown,
    /// Save the goal as a file.
    SaveGoal,
    /// Save configuration and knowledge as a file.
    SaveMind,
    /// Load configuration and knowledge.
    LoadMind {
        /// The file's bytes, in hexadecimal.
        hex: String,
    },
    /// Switch the shield.
    Shield {
        /// On.
        on: bool,
    },
    /// Switch online learning.
    Online {
        /// On.
        on: bool,
    },
    /// Switch a sonar.
    Sonar {
        /// Its number.
        number: usize,
        /// On.
        on: bool,
    },
    /// Move a box or post.
    MoveShape {
        /// Index among the scene's shapes.
        shape: usize,
        /// New x of its center.
        x: f64,
        /// New y of its center.
        y: f64,
    },
    /// Move a lamp, a source of a scent or colored floor.
    MoveSource {
        /// Index among the scene's sources.
        source: usize,
        /// New x of its center.
        x: f64,
        /// New y of its center.
        y: f64,
    },
    /// Move the robot.
    MoveRobot {
        /// New x of its center.
        x: f64,
        /// New y of its center.
        y: f64,
    },
}

/// Values of a restart.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Reset {
    /// Seed of all randomness.
    pub seed: Option<u64>,
    /// A world of the menu or `random:SEED`.
    pub world: Option<String>,
    /// A preset of the menu.
    pub preset: Option<String>,
}

/// Outcome of a command.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum CommandOutcome {
    /// Done.
    #[default]
    Done,
    /// Done, with a file.
    File(PageFile),
}

/// A file for the viewer to save.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PageFile {
    /// Its name.
    pub name: &'static str,
    /// Its text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Its bytes, in hexadecimal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hex: Option<String>,
}

/// A reply as JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reply {
    reply: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<PageFile>,
}

impl Reply {
    /// The reply to command `id`.
    #[must_use]
    pub fn to(id: u64, outcome: Result<CommandOutcome, String>) -> Self {
        let (error, file) = match outcome {
            Ok(CommandOutcome::Done) => (None, None),
            Ok(CommandOutcome::File(file)) => (None, Some(file)),
            Err(why) => (Some(why), None),
        };
        Self {
            reply: id,
            error,
            file,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_are_read_and_strange_ones_refused() {
        let read = |text: &str| serde_json::from_str::<NumberedCommand>(text).map(|n| n.command);
        assert_eq!(
            read(r#"{"id":1,"do":"explore"}"#).unwrap(),
            PageCommand::Explore
        );
        assert_eq!(
            read(r#"{"id":1,"do":"move_shape","shape":3,"x":1.5,"y":-2}"#).unwrap(),
            PageCommand::MoveShape {
                shape: 3,
                x: 1.5,
                y: -2.0
            }
        );
        assert_eq!(
            read(r#"{"id":1,"do":"speed","factor":null}"#).unwrap(),
            PageCommand::Speed { factor: None }
        );
        for strange in [
            "",
            "{}",
            r#"{"id":1,"do":"explode"}"#,
            r#"{"do":"stop"}"#,
            r#"{"id":1,"do":"goal_neuron","neuron":-1}"#,
        ] {
            assert!(read(strange).is_err(), "{strange}");
        }
    }
}
