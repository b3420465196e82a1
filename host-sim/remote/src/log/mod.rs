//! Logs of a controller's inputs and answers as MCAP files, which other tools can open.
//!
//! All messages are JSON; [`channel`] lists their schemas. The controller is a function of its
//! configuration and events, so a log can be [replayed](replay()). A file consists of chunks of
//! about [`CHUNK_BYTES`]; a log that was cut off is complete up to its last chunk.

mod check;
mod fields;
mod logged_controller;
mod logged_pilot;
mod read;
mod record;
mod replay;
mod replayer;
mod run;
mod scene;
mod setup_record;
mod shared;
mod shown;
mod summary;
mod write;

pub use check::{LogDamage, LogDefect};
pub use logged_controller::LoggedController;
pub use logged_pilot::{LoggedPilot, WorldLogger};
pub use read::{Ending, LogFile, LogMessage, Messages, read};
pub use record::{
    AnswerRecord, DecisionRecord, EchoRecord, EventKind, EventRecord, MotionRecord, PlanRecord,
};
pub use replay::{ReplayResult, replay};
pub use replayer::Replayer;
pub use run::run;
pub use scene::{SceneChange, pose_of, scene_changes};
pub use setup_record::{FORMAT, RobotRecord, SetupRecord};
pub use shared::SharedLog;
pub use shown::LoggedDemonstration;
pub use summary::Summary;
pub use write::{CHUNK_BYTES, LogOutput, LogWriter};

#[cfg(any(test, feature = "fixture"))]
pub mod fixture;
#[cfg(test)]
mod tests;

/// Names of the channels.
pub mod channel {
    /// Schema `amp.Setup`, at each start: the controller's configuration and the conditions.
    pub const SETUP: &str = "/setup";
    /// Schema `amp.Event`: every input of the controller, with its time.
    pub const EVENT: &str = "/event";
    /// Schema `amp.Plan`: every answer, with the intermediate values of decisions.
    pub const PLAN: &str = "/plan";
    /// Schema `foxglove.LaserScan`: the ring at each decision, in the frame `ring`.
    pub const SONAR: &str = "/sonar";
    /// Schema `foxglove.PoseInFrame`: the true pose of the robot, in the frame `world`.
    pub const POSE: &str = "/pose";
    /// Schema `foxglove.FrameTransform`: the same pose, from `world` to `ring`.
    pub const TRANSFORM: &str = "/tf";
    /// Schema `foxglove.SceneUpdate`: surfaces, body, second robot and contacts.
    pub const SCENE: &str = "/scene";
}
