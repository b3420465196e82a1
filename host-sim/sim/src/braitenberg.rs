//! A hand-written avoider after V. Braitenberg, *Vehicles*, MIT Press 1984. Each sonar pushes the
//! course away from its echo, the stronger the nearer; the speed is constant.
//!
//! It is the reference for distance and coverage: it learns nothing and is tuned by hand.

use crate::ring_pilot::{Perception, Policy, STEP_M, axis};
use arena::world::Point;
use std::f64::consts::PI;

/// Constants of the rule.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BraitenbergTuning {
    /// Step per decision, meters.
    pub step_m: f64,
    /// Farther echoes are ignored, meters.
    pub far_m: f64,
    /// Weight of the pushes against the course.
    pub push: f64,
}

impl Default for BraitenbergTuning {
    fn default() -> Self {
        Self {
            step_m: STEP_M,
            far_m: 0.9,
            push: 2.0,
        }
    }
}

/// A Braitenberg vehicle with a ring of 16 sonars.
#[derive(Debug, Clone)]
pub struct Braitenberg {
    tuning: BraitenbergTuning,
    /// Unit vector of the course in the ring's frame.
    course: Point,
}

impl Braitenberg {
    /// A vehicle that starts along the ring's x axis.
    #[must_use]
    pub fn new(tuning: BraitenbergTuning) -> Self {
        Self::towards(tuning, 0.0)
    }

    /// A vehicle that starts at `angle_rad` from the ring's x axis.
    #[must_use]
    pub fn towards(tuning: BraitenbergTuning, angle_rad: f64) -> Self {
        Self {
            tuning,
            course: Point::unit(angle_rad),
        }
    }

    /// Adds the pushes to the course. Only echoes within about a quarter turn of the course push,
    /// so a wall beside the robot does not turn it away.
    fn next_course(&self, perceived: &Perception) -> Point {
        let mut sum = self.course;
        for (sensor, range) in perceived.ranges.iter().enumerate() {
            let Some(range) = range else { continue };
            let nearness = 1.0 - f64::from(range.as_mm()) / (self.tuning.far_m * 1e3);
            let axis = axis(sensor);
            let ahead = axis.dot(self.course);
            if nearness > 0.0 && ahead > -0.1 {
                let push = self.tuning.push * nearness * nearness * (0.2 + ahead.max(0.0));
                sum = sum - axis * push;
            }
        }
        let length = sum.length();
        if length > 1e-6 {
            Point::new(sum.x / length, sum.y / length)
        } else {
            Point::new(-self.course.y, self.course.x)
        }
    }
}

impl Policy for Braitenberg {
    fn decide(&mut self, perceived: &Perception) -> Point {
        // The ring has turned; the course keeps its direction in the world.
        let turned = f64::from(perceived.turned.as_signed_turns()) * PI / 32_768.0;
        self.course = self.course.turned_back(Point::unit(turned));
        self.course = self.next_course(perceived);
        self.course * self.tuning.step_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::units::{Bearing, Range};
    use arena::world::Pose;

    #[test]
    fn the_push_of_a_wall_ahead_matches_a_hand_computed_value() {
        let mut ranges = [None; 16];
        ranges[2] = Some(Range::from_mm(450));
        let perceived = Perception {
            ranges,
            pose: Pose::default(),
            turned: Bearing::ZERO,
            last: None,
        };
        // Nearness 1/2 at 45° to the left: a push of 2 · 1/4 · (0.2 + cos 45°) away from it.
        let push = 0.5 * (0.2 + 0.5_f64.sqrt()) * 0.5_f64.sqrt();
        let expected = Point::new(1.0 - push, -push);
        let step = Braitenberg::new(BraitenbergTuning::default()).decide(&perceived);
        assert!(step.distance(expected * (STEP_M / expected.length())) < 1e-12);
    }
}
