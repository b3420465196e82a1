//! The two maps from a logged run of a real robot: `host-sim learn`.
//!
//! A log is a table with a row for each moment: what a ring of range finders heard, and what the
//! robot did then (the name of an action, or velocities). The way of the data: [`log`] (a text
//! file) → [`task`] (situations in [0, 1], changes of situation, actions; a part of the run held
//! out, contiguous in time) → [`memory`] (maps trained by the robot's own kernels, and what they
//! are compared with) → [`score`] (how well the held-out actions are recalled) → [`mod@study`].
//!
//! The paper's action map learns (change of situation, action) and is probed with the change alone.
//! Where an action was chosen *because of* the situation, as the class of a wall follower was, the
//! change it brings says little about it: the same memory probed with the situation is reported
//! beside it.

pub mod args;
pub mod log;
pub mod memory;
pub mod score;
pub mod study;
pub mod task;

pub use args::LearnArgs;
pub use log::{Actions, Columns, Log};
pub use score::Score;
pub use study::{Map, Method, Recalled, Study, study};
pub use task::{Options, Task};

#[cfg(test)]
mod tests;
