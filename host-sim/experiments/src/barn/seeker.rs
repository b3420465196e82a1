//! The mind's maps on the way to a place: the bearing of the place as one more component of the situation.
//!
//! The maps know 16 sonars. In free space nothing they perceive says where a distant place is; a component more does: the
//! place's bearing. How it changes need not be learned: a step towards the place brings the robot nearer by the whole step, one
//! aside by nothing, so a direction is worth the cosine of its angle to the bearing. That is what the look-ahead does with
//! the direction of travel already (`Goal::going_q16`): the crate's own planner is asked with the bearing in the course's
//! place. The maps stay those of 16 components, learned as always, and the chip's program stays as it is.

use amp::config::Config;
use amp::fixed::Mask;
use amp::goal::Goal;
use amp::planner::Planner;
use amp::units::{Displacement, Range};
use arena::world::Point;
use sim::error::EpisodeError;
use sim::pilot::{InspectableController as _, LocalController, SimState};
use sim::ring_pilot::{Perception, Policy, Steerable};

/// What is wanted on the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// Nothing is to be nearer than this, m from the ring.
    pub clearance_m: f64,
    /// What a step towards the place weighs against deviation, in units of a squared deviation of 1.
    pub pull: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            // Found in 50 fields grown like the benchmark's, none of them its own.
            clearance_m: 0.45,
            pull: 0.0025,
        }
    }
}

/// Maps learned elsewhere that are told where to go.
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
    /// With what a mind has learned; it starts along `course`, rad from the ring's x axis.
    ///
    /// # Errors
    /// When the mind cannot tell what it knows.
    pub fn new(
        mut mind: LocalController,
        tuning: Tuning,
        course: f64,
    ) -> Result<Self, EpisodeError> {
        let config = mind.config().clone();
        let clearance = Range::from_mm((tuning.clearance_m * 1e3) as u16);
        let goal = Goal {
            going_q16: (tuning.pull * 65_536.0) as u16,
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
        let way = Point::new(f64::from(action.dx_mm), f64::from(action.dy_mm)) * 1e-3;
        if way.length() > 0.0 {
            self.course = way.turned(heading).angle();
        }
        way
    }
}

impl Steerable for Seeker {
    fn steer(&mut self, target: Option<f64>) {
        self.target = target;
    }
}
