//! The result of one simulation step.

use amp::controller::{Decision, Outputs, StopReason};
use arena::world::{Point, Pose};

/// The result of one simulation step.
#[derive(Debug)]
pub struct StepResult {
    /// Pose of the robot at the beginning of the step.
    pub pose: Pose,
    /// Simulated time of that pose, seconds.
    pub time_s: f64,
    /// The decision that was taken.
    pub decision: Option<Decision<16>>,
    /// The pilot changed its mode.
    pub mode_changed: bool,
    /// Why the pilot stopped the robot, if it did.
    pub stopped: Option<StopReason>,
    /// The pilot shortened the motion under way.
    pub shortened: bool,
    /// Motion of the base, after the decision if there was one.
    pub moved: Option<Moved>,
    /// The other robot's motion ended at this one.
    pub collision: Option<Collision>,
}

/// Who closed the gap when the other robot touched this one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Collision {
    /// The robot rolled towards the other one.
    ByRobot,
    /// The robot stood, rolled past or rolled away.
    ByOther,
}

/// A straight piece of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// Its beginning.
    pub from: Point,
    /// Its end.
    pub to: Point,
    /// Its length, meters.
    pub traveled_m: f64,
    /// Smallest gap between body and surfaces, meters. It may be infinite above the
    /// [limit](super::Body::ignore_gaps_above).
    pub clearance_m: f64,
    /// The body touched something.
    pub touched: bool,
}

impl StepResult {
    /// A step in which nothing has happened yet.
    pub(super) fn new(pose: Pose, time_s: f64) -> Self {
        Self {
            pose,
            time_s,
            decision: None,
            mode_changed: false,
            stopped: None,
            shortened: false,
            moved: None,
            collision: None,
        }
    }

    /// Adds the outputs of one more event.
    pub(super) fn add(&mut self, outputs: &Outputs<16>) {
        if let (None, Some(decision)) = (&self.decision, &outputs.decision) {
            self.decision = Some(*decision);
        }
        self.mode_changed |= outputs.mode_changed;
        self.stopped = self.stopped.or(outputs.stopped);
        self.shortened |= shortens(outputs);
    }
}

/// Whether the outputs shorten the motion under way.
fn shortens(outputs: &Outputs<16>) -> bool {
    outputs.motion.is_some() && outputs.decision.is_none() && !outputs.mode_changed
}

/// Who closes the gap to a thing at `to_thing` while the robot moves by `way`.
pub(super) fn collision(to_thing: Point, way: Point) -> Collision {
    if way.dot(to_thing) > 0.0 {
        Collision::ByRobot
    } else {
        Collision::ByOther
    }
}
