//! Logs: what an episode's mind was told and what it answered, as an MCAP file that other tools open.
//!
//! | channel | schema | what |
//! |---|---|---|
//! | `/setup` | `amp.Setup` | at each start: the mind's configuration and the episode's conditions |
//! | `/event` | `amp.Event` | everything the mind was told, with its time |
//! | `/plan` | `amp.Plan` | everything it answered: decisions with their intermediate values, motions |
//! | `/sonar` | `foxglove.LaserScan` | the ring at each decision, in the frame `ring` |
//! | `/pose` | `foxglove.PoseInFrame` | where the robot really is, in the frame `world` |
//! | `/tf` | `foxglove.FrameTransform` | the same, from `world` to `ring` |
//! | `/scene` | `foxglove.SceneUpdate` | surfaces, body, a second robot, contacts |
//!
//! All messages are JSON; times count from the beginning of the log. The mind is a function of its configuration and
//! the events: `/setup` and `/event` are enough to run it again, and `/plan` says what must come of it
//! ([`replay()`]). A log of somebody who steers has a `/setup` for each new start; other choices and knowledge from a file are
//! events like all others. Fixed-point values are written as the decimal numbers they are, so nothing is lost on the way.
//!
//! A file is a series of chunks of about [`CHUNK_BYTES`], each written at once: a log that was cut off is whole up to its last
//! chunk. [`read`] checks the whole file first and refuses one that is damaged.

mod check;
mod fields;
mod logged;
mod read;
mod record;
mod replay;
mod retell;
mod run;
mod scene;
mod shared;
mod summary;
mod tap;
mod write;

pub use check::{Damage, Defect};
pub use logged::LoggedMind;
pub use read::{Ending, LogFile, Message, Reading, read};
pub use record::{
    Answer, DecisionRecord, EchoRecord, EventRecord, FORMAT, Happening, MotionRecord, PlanRecord,
    Setup,
};
pub use replay::{Replayed, replay};
pub use retell::Replayer;
pub use run::run;
pub use scene::{SceneChange, pose_of, scene_changes};
pub use shared::SharedLog;
pub use summary::Summary;
pub use tap::{Tap, Watcher};
pub use write::{CHUNK_BYTES, Log, LogOutput};

#[cfg(any(test, feature = "fixture"))]
pub mod fixture;
#[cfg(test)]
mod tests;

/// Names of the channels.
pub mod channel {
    /// The episode's conditions.
    pub const SETUP: &str = "/setup";
    /// What the mind is told.
    pub const EVENT: &str = "/event";
    /// What it answers.
    pub const PLAN: &str = "/plan";
    /// The ring.
    pub const SONAR: &str = "/sonar";
    /// Where the robot is.
    pub const POSE: &str = "/pose";
    /// The same as a transformation.
    pub const TRANSFORM: &str = "/tf";
    /// What stands around.
    pub const SCENE: &str = "/scene";
}
