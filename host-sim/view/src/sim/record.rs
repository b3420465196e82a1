//! Records what the robot does, as a demonstration of a goal.

use super::Simulator;
use crate::goal::ActiveGoal;
use crate::source::CommandRefused;
use amp::controller::Decision;
use amp::fixed::Mask;
use amp::units::Displacement;
use arena::world::Point;
use sim::demonstration::{Demonstration, ShownStep, goal_of_demonstrations};
use sim::episode::Moved;

/// Most steps of a recording: learning from them takes seconds.
const MAX_STEPS: usize = 300;

/// The recording of a demonstration.
#[derive(Debug, Default)]
pub(super) struct Recorder {
    /// Decisions with a goal are recorded.
    is_on: bool,
    shown: Vec<ShownStep>,
    /// The step whose motion is under way.
    open: Option<ShownStep>,
    /// Way since the last decision, m in the ring's frame.
    way: Point,
    course: Displacement,
}

impl Recorder {
    /// The base has moved.
    pub(super) fn moved(&mut self, moved: &Moved, ring_heading: f64) {
        let way = (moved.to - moved.from).turned_back(Point::unit(ring_heading));
        self.way = self.way + way;
    }

    /// The robot has decided; of its transducers these are known.
    pub(super) fn decided(&mut self, decision: &Decision<16>, known: Mask) {
        let way = std::mem::take(&mut self.way);
        let millimeters = |meters: f64| libm::rint(meters * 1e3) as i32;
        let moved = Displacement::saturating(millimeters(way.x), millimeters(way.y));
        if let Some(step) = self.open.take() {
            self.shown.push(ShownStep { moved, ..step });
        }
        if moved != Displacement::ZERO {
            self.course = moved;
        }
        let is_room = self.shown.len() < MAX_STEPS;
        self.is_on &= is_room;
        if self.is_on && decision.plan.is_some() {
            self.open = Some(ShownStep {
                situation: decision.situation,
                known,
                course: self.course,
                moved: Displacement::ZERO,
            });
        }
    }

    /// The robot was carried: the step under way shows nothing.
    pub(super) fn carried(&mut self) {
        (self.open, self.way) = (None, Point::default());
    }

    /// Whether it records, and the number of steps.
    pub(super) fn state(&self) -> Option<(bool, usize)> {
        (self.is_on || !self.shown.is_empty()).then_some((self.is_on, self.shown.len()))
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
            self.recorder.is_on = false;
            self.recorder.open = None;
        }
        Ok(())
    }

    /// Pursues the goal of the recording.
    pub(super) fn use_recorded(&mut self) -> Result<(), CommandRefused> {
        self.recorder.is_on = false;
        let shown = &self.recorder.shown;
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
