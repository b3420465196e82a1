//! The interface of everything that the view can show: a simulated robot, a real one, a log.

use super::Snapshot;
use super::command::{CommandOutcome, PageCommand};
use serde::Serialize;
use std::time::Duration;

/// What a source can do; the page hides the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Capabilities {
    /// Explore, learn, seek, stop, resume, and set goals.
    pub drive: bool,
    /// Set the speed, pause, take single steps.
    pub pace: bool,
    /// Move obstacles and the robot.
    pub carry: bool,
    /// Restart with another seed, world or preset.
    pub reset: bool,
    /// Switch shield, online learning and sonars.
    pub configure: bool,
    /// Save configuration and knowledge.
    pub save: bool,
    /// Load configuration and knowledge.
    pub load: bool,
    /// Record demonstrations and find their goals.
    pub show: bool,
    /// Jump to any decision, in a log.
    pub jump: bool,
    /// A memory of places leads it to goals: home, and any position.
    pub places: bool,
    /// The source has neither pose nor ranges.
    pub unplaced: bool,
}

/// Why a command was refused, as a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CommandRefused(pub String);

impl<T: std::fmt::Display> From<T> for CommandRefused {
    fn from(why: T) -> Self {
        Self(why.to_string())
    }
}

/// Outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepOutcome {
    /// Nothing happens before the next command.
    Idle,
    /// The step took some time.
    Took {
        /// Duration in the source's own time, seconds.
        took_s: f64,
        /// A decision was taken or an activity has ended, which ends a single step.
        whole: bool,
    },
}

/// Something to show. It has neither clock nor viewers.
pub trait ViewSource: Send {
    /// What it can do.
    fn abilities(&self) -> Capabilities;

    /// Takes its smallest step.
    fn step(&mut self) -> StepOutcome;

    /// Executes a command, other than those of control lock and clock.
    ///
    /// # Errors
    /// Why it was refused; nothing has changed then.
    fn execute(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused>;

    /// The current snapshot.
    fn snapshot(&mut self) -> Snapshot;

    /// Reports that no page has steered for `silence`: a real robot stops.
    fn steering_lost(&mut self, _silence: Duration) {}

    /// Shuts down: stops the robot and closes the log.
    ///
    /// # Errors
    /// What failed, in a sentence.
    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }
}
