//! The controller's maps on the way to a goal position, whose bearing extends the situation.
//!
//! A step's effect on the bearing is the cosine of its angle to it, so nothing has to be learned.
//! The crate's planner computes it if the bearing replaces the heading (`Goal::progress_q16`).

use amp::config::Config;
use amp::fixed::Mask;
use amp::goal::Goal;
use amp::planner::Planner;
use amp::units::{Displacement, Range};
use arena::world::Point;
use sim::error::EpisodeError;
use sim::pilot::{InspectableController as _, LocalController, SimState};
use sim::ring_pilot::{Perception, Policy, Steerable};

/// Weights of the goal on the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeekerTuning {
    /// Least distance to obstacles, m from the ring.
    pub clearance_m: f64,
    /// Weight of progress toward the goal, in units of a squared deviation of 1.
    pub pull: f64,
}

impl Default for SeekerTuning {
    fn default() -> Self {
        Self {
            // Tuned in 50 fields generated like those of the benchmark, none of them part of it.
            clearance_m: 0.45,
            pull: 0.0025,
        }
    }
}

/// Learned maps that are steered toward a position.
#[derive(Debug, Clone)]
pub struct Seeker {
    config: Config<16>,
    state: Box<SimState>,
    goal: Goal<16>,
    target: Option<f64>,
    /// Direction of the last step, rad in the frame of the pose.
    course: f64,
}

impl Seeker {
    /// Takes what a controller has learned; the robot starts along `course`, rad from the ring's x
    /// axis.
    ///
    /// # Errors
    /// When the controller cannot return its state.
    pub fn new(
        mut mind: LocalController,
        tuning: SeekerTuning,
        course: f64,
    ) -> Result<Self, EpisodeError> {
        let config = mind.config().clone();
        let clearance = Range::from_mm((tuning.clearance_m * 1e3) as u16);
        let goal = Goal {
            progress_q16: (tuning.pull * 65_536.0) as u16,
            ..Goal::nothing_within(clearance, config.encoding)
        };
        Ok(Self {
            state: Box::new(mind.knowledge()?.clone()),
            config,
            goal,
            target: None,
            course,
        })
    }
}

impl Policy for Seeker {
    fn decide(&mut self, perceived: &Perception) -> Point {
        let encoding = self.config.encoding;
        let situation = perceived.ranges.map(|range| encoding.value(range));
        let heading = Point::unit(perceived.pose.heading);
        let bearing = Point::unit(self.target.unwrap_or(self.course)).turned_back(heading);
        let step = f64::from(self.config.robot.step_mm);
        let millimeters = |part: f64| libm::rint(part * step) as i32;
        let planner = Planner {
            config: &self.config,
            situations: self.state.situations(),
            actions: self.state.actions(),
            enabled: Mask::ALL,
            allowed: Mask::ALL,
            current: None,
            course: Displacement::saturating(millimeters(bearing.x), millimeters(bearing.y)),
            cut: false,
        };
        let action = planner.plan(&situation, &self.goal).action;
        let step = Point::new(f64::from(action.dx_mm), f64::from(action.dy_mm)) * 1e-3;
        if step.length() > 0.0 {
            self.course = step.turned(heading).angle();
        }
        step
    }
}

impl Steerable for Seeker {
    fn steer(&mut self, target: Option<f64>) {
        self.target = target;
    }
}
