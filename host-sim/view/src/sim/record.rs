//! Records what the robot does, as a demonstration of a goal.

use super::Simulator;
use crate::goal::ActiveGoal;
use crate::source::CommandRefused;
use amp::controller::Decision;
use amp::fixed::Mask;
use amp::units::Displacement;
use arena::world::Point;
use sim::demonstration::{Demonstration, DemonstrationRecorder, goal_of_demonstrations};
use sim::episode::{Moved, bearing};

/// Most steps of a recording: learning from them takes seconds.
const MAX_STEPS: usize = 300;

/// The recording of a demonstration.
#[derive(Debug, Default)]
pub(super) struct Recorder {
    /// Decisions with a goal are recorded.
    is_on: bool,
    steps: DemonstrationRecorder,
    /// Way since the last decision, m in the world's frame.
    way: Point,
    /// Bearing of the ring at that decision, rad; `None` before the first.
    ring_heading: Option<f64>,
}

impl Recorder {
    /// The base has moved.
    pub(super) fn moved(&mut self, moved: &Moved) {
        self.way = self.way + (moved.to - moved.from);
    }

    /// The robot has decided, with its ring at this bearing; of its transducers these are known.
    pub(super) fn decided(&mut self, decision: &Decision<16>, ring_heading: f64, known: Mask) {
        let way = std::mem::take(&mut self.way);
        let before = self.ring_heading.replace(ring_heading);
        let before = before.unwrap_or(ring_heading);
        let way = way.turned_back(Point::unit(before));
        let millimeters = |meters: f64| libm::rint(meters * 1e3) as i32;
        let moved = Displacement::saturating(millimeters(way.x), millimeters(way.y));
        let is_shown = self.is_on && decision.plan.is_some();
        let perceived = is_shown.then_some((decision.situation, known));
        let turned = bearing(ring_heading - before);
        self.steps.decided(moved, turned, perceived);
        if self.steps.shown().len() >= MAX_STEPS {
            self.end();
        }
    }

    /// The robot was carried: the step under way shows nothing.
    pub(super) fn carried(&mut self) {
        self.steps.abandon();
        self.way = Point::default();
    }

    fn end(&mut self) {
        self.is_on = false;
        self.steps.abandon();
    }

    /// Whether it records, and the number of steps.
    pub(super) fn state(&self) -> Option<(bool, usize)> {
        let count = self.steps.shown().len();
        (self.is_on || count > 0).then_some((self.is_on, count))
    }
}

impl Simulator {
    /// Starts a new recording, or ends it.
    pub(super) fn record(&mut self, on: bool) -> Result<(), CommandRefused> {
        if self.start.setup.robot.is_some() {
            return Err("a goal is learned from the ring of nomad200".into());
        }
        if on {
            self.recorder = Recorder {
                is_on: true,
                ..Recorder::default()
            };
        } else {
            self.recorder.end();
        }
        Ok(())
    }

    /// Pursues the goal of the recording.
    pub(super) fn use_recorded(&mut self) -> Result<(), CommandRefused> {
        self.recorder.end();
        let shown = self.recorder.steps.shown();
        let known = self.controller.pilot().cached_state()?;
        let demonstration = Demonstration {
            shown,
            actions: known.actions(),
            step_mm: self.config.robot.step_mm,
        };
        let goal = goal_of_demonstrations(&[demonstration], |_, _| {});
        let goal = goal?;
        let name = format!("shown in {} steps", shown.len());
        self.choose(ActiveGoal::shown(goal, name))
    }
}
