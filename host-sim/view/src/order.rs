//! What a viewer may ask for, and the answers.

use serde::{Deserialize, Serialize};

/// An order with its number.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Numbered {
    /// Comes back in the reply.
    pub id: u64,
    /// The order.
    #[serde(flatten)]
    pub order: Order,
}

/// Something to do. Lengths in meters, in the world's frame.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub enum Order {
    /// Take the seat.
    Steer {
        /// The run's token.
        token: String,
        /// From whoever has it, too.
        #[serde(default)]
        over: bool,
    },
    /// Give the seat up.
    Leave,
    /// Stand still.
    Stop,
    /// Make random moves.
    Explore,
    /// Make the maps.
    Learn,
    /// Pursue the chosen goal.
    Seek,
    /// Go on with what a stop interrupted.
    Resume,
    /// One decision, then time stands still.
    Step,
    /// Lets time stand still or go on.
    Pause {
        /// Stand still.
        paused: bool,
    },
    /// How fast time passes.
    Speed {
        /// Simulated seconds per second; none = as fast as it goes.
        factor: Option<f64>,
    },
    /// Go to a moment of a recording.
    Jump {
        /// How many of its decisions then lie behind.
        to: usize,
    },
    /// Start anew; what is not given stays.
    Reset(Reset),
    /// Choose a behavior as the goal; a robot that seeks pursues it at once.
    Behavior {
        /// Its name.
        name: String,
    },
    /// Make the situation of a neuron the goal.
    GoalNeuron {
        /// The neuron, from 0.
        neuron: usize,
    },
    /// Make what is perceived now the goal.
    GoalHere,
    /// Make a goal file's text the goal.
    GoalFile {
        /// The text.
        text: String,
    },
    /// The goal as a file.
    SaveGoal,
    /// What the mind was told and has learned, as a file.
    SaveMind,
    /// Replace what the mind was told and has learned.
    LoadMind {
        /// The file's bytes, in hexadecimal.
        hex: String,
    },
    /// Let the sonars limit motion.
    Shield {
        /// On.
        on: bool,
    },
    /// Let the maps go on learning while behaving.
    Online {
        /// On.
        on: bool,
    },
    /// Switch a sonar on or off.
    Sonar {
        /// Its number.
        number: usize,
        /// On.
        on: bool,
    },
    /// Move a box or post.
    MoveShape {
        /// Its place among the scene's shapes.
        shape: usize,
        /// Where its center is to be.
        x: f64,
        /// As above.
        y: f64,
    },
    /// Carry the robot.
    MoveRobot {
        /// Where its center is to be.
        x: f64,
        /// As above.
        y: f64,
    },
}

/// What a new start is to be made of.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
pub struct Reset {
    /// Seed of all randomness.
    pub seed: Option<u64>,
    /// A world of the menu, or `random:SEED`.
    pub world: Option<String>,
    /// A preset of the menu.
    pub preset: Option<String>,
}

/// What came of an order.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Done {
    /// It was done.
    #[default]
    Well,
    /// Here is a file.
    File(File),
}

/// A file for the viewer to keep.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct File {
    /// Its name.
    pub name: &'static str,
    /// Its text.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Its bytes, in hexadecimal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hex: Option<String>,
}

/// An answer as it goes out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reply {
    reply: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<File>,
}

impl Reply {
    /// The answer to order `id`.
    #[must_use]
    pub fn to(id: u64, outcome: Result<Done, String>) -> Self {
        let (error, file) = match outcome {
            Ok(Done::Well) => (None, None),
            Ok(Done::File(file)) => (None, Some(file)),
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
        let read = |text: &str| serde_json::from_str::<Numbered>(text).map(|n| n.order);
        assert_eq!(read(r#"{"id":1,"do":"explore"}"#).unwrap(), Order::Explore);
        assert_eq!(
            read(r#"{"id":1,"do":"move_shape","shape":3,"x":1.5,"y":-2}"#).unwrap(),
            Order::MoveShape {
                shape: 3,
                x: 1.5,
                y: -2.0
            }
        );
        assert_eq!(
            read(r#"{"id":1,"do":"speed","factor":null}"#).unwrap(),
            Order::Speed { factor: None }
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
