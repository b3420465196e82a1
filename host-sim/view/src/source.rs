//! What can be watched: a simulated robot, a real one, a recording.

use super::Snapshot;
use super::order::{Done, Order};
use serde::Serialize;
use std::time::Duration;

/// What can be asked of a source; the page leaves out the rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Abilities {
    /// Explore, learn, seek, stop, resume, and goals.
    pub drive: bool,
    /// Speed, pause, single steps.
    pub pace: bool,
    /// Obstacles and the robot can be moved.
    pub carry: bool,
    /// A new start with another seed, world or preset.
    pub reset: bool,
    /// Shield, learning while behaving, sonars.
    pub configure: bool,
    /// Knowledge as a file can be saved.
    pub save: bool,
    /// Knowledge can be replaced by that of a file.
    pub load: bool,
    /// Any decision can be gone to: a recording.
    pub jump: bool,
    /// Neither where the robot is nor what each sonar has heard is known.
    pub unplaced: bool,
}

/// Why an order was not carried out, in a sentence for the person who gave it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refused(pub String);

impl<T: std::fmt::Display> From<T> for Refused {
    fn from(why: T) -> Self {
        Self(why.to_string())
    }
}

/// What a step was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stepped {
    /// Nothing goes on: the robot stands and waits for an order.
    Standing,
    /// It took so long in the source's own time, seconds.
    Took {
        /// Seconds.
        took_s: f64,
        /// A decision was taken, or what went on has ended: a single step ends here.
        whole: bool,
    },
}

/// What can be watched. Knows neither clock nor viewers.
pub trait Source: Send {
    /// What can be asked of it.
    fn abilities(&self) -> Abilities;

    /// Goes on by its smallest step.
    fn step(&mut self) -> Stepped;

    /// Carries out an order other than those of seat and pace.
    ///
    /// # Errors
    /// Why it was not done; nothing has changed then.
    fn carry_out(&mut self, order: &Order) -> Result<Done, Refused>;

    /// What there is to see.
    fn snapshot(&mut self) -> Snapshot;

    /// No page has steered for `silence`: a real robot stops.
    fn steering_lost(&mut self, _silence: Duration) {}

    /// The program is about to end: a robot is told to stand, a log is closed.
    ///
    /// # Errors
    /// What could not be done, in a sentence.
    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }
}
