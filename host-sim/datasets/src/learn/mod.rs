//! The two maps from a logged run of a real robot: `host-sim learn`.
//!
//! A log is a table with one row per moment: the ranges of a ring of range finders and the robot's
//! action (a name, or velocities). Data flow:
//!
//! * [`log`] parses the text file;
//! * [`dataset`] computes situations in [0, 1], their changes and the actions, and splits the run
//!   at one moment into a training part and a held-out part;
//! * [`associative_memory`] trains the maps with the robot's kernels and builds the baselines;
//! * [`score`] measures how well the held-out actions are recalled;
//! * [`evaluation`] does this for every map size and method.
//!
//! The paper's action map learns (change of situation, action) pairs and is probed with the change
//! alone. If a rule chose the action *because of* the situation, as in a wall follower, the change
//! has little information about the action. The results therefore include the same memory probed
//! with the situation.

pub mod args;
pub mod associative_memory;
pub mod dataset;
pub mod evaluation;
pub mod log;
pub mod score;

pub use args::LearnArgs;
pub use dataset::{Dataset, DatasetOptions};
pub use evaluation::{Evaluation, MapResult, MethodScore, RecallMethod, evaluate};
pub use log::{Actions, Log, LogColumns};
pub use score::Score;

#[cfg(test)]
mod tests;
