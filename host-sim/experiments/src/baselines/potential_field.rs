//! Baseline: artificial potential field; the target attracts, obstacles repel.
//!
//! O. Khatib, International Journal of Robotics Research 5(1), 1986, 90–98: an obstacle at ρ < ρ₀
//! repels with η (1/ρ − 1/ρ₀) / ρ². Each echo of the latest ring is one obstacle on its axis. The
//! attraction is a constant force of 1 along bearing or heading.

use arena::robot::COLLISION_RADIUS_M;
use arena::sonar::FACE_RADIUS_M;
use arena::world::Point;
use sim::ring_pilot::{Perception, Policy, STEP_M, Steerable, axis};

/// From a transducer's face to the edge of the collision disc, m.
const RIM_M: f64 = COLLISION_RADIUS_M - FACE_RADIUS_M;
/// Lower limit of the distances, m: keeps the forces finite.
const MIN_DISTANCE_M: f64 = 0.01;
/// A sum of forces weaker than this has no direction.
const BALANCE: f64 = 1e-6;

/// The method's constants; the defaults were tuned in rooms that no comparison uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PotentialFieldTuning {
    /// ρ₀: obstacles beyond this distance do not repel, m from the edge of the body.
    pub reach_m: f64,
    /// η, m³ (the attraction is 1).
    pub strength: f64,
}

impl Default for PotentialFieldTuning {
    fn default() -> Self {
        Self {
            reach_m: 0.8,
            strength: 0.02,
        }
    }
}

/// A robot in a potential field.
#[derive(Debug, Clone)]
pub struct PotentialField {
    tuning: PotentialFieldTuning,
    /// Bearing of the target, rad in the frame of the pose.
    target: Option<f64>,
    /// Direction of the last step, rad in the frame of the pose.
    course: f64,
}

impl PotentialField {
    /// A robot that starts along `course` (rad from the ring's x axis) and has no target.
    #[must_use]
    pub fn new(tuning: PotentialFieldTuning, course: f64) -> Self {
        Self {
            tuning,
            target: None,
            course,
        }
    }

    /// The repelling force, in the ring's frame.
    fn repulsion(&self, perceived: &Perception) -> Point {
        let mut sum = Point::default();
        for sensor in 0..16 {
            let distance = (perceived.range_m(sensor) - RIM_M).max(MIN_DISTANCE_M);
            if distance < self.tuning.reach_m {
                let force = self.tuning.strength * (1.0 / distance - 1.0 / self.tuning.reach_m)
                    / (distance * distance);
                sum = sum - axis(sensor) * force;
            }
        }
        sum
    }
}

impl Policy for PotentialField {
    fn decide(&mut self, perceived: &Perception) -> Point {
        let heading = Point::unit(perceived.pose.heading);
        let attraction = Point::unit(self.target.unwrap_or(self.course));
        let force = self.repulsion(perceived).turned(heading) + attraction;
        let length = force.length();
        if length < BALANCE {
            return Point::default();
        }
        self.course = force.angle();
        force.turned_back(heading) * (STEP_M / length)
    }
}

impl Steerable for PotentialField {
    fn steer(&mut self, target: Option<f64>) {
        self.target = target;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::units::{Bearing, Range};
    use arena::world::Pose;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    const TUNING: PotentialFieldTuning = PotentialFieldTuning {
        reach_m: 1.0,
        strength: 0.25,
    };

    fn hearing(sensor: usize, range_mm: u16, heading: f64) -> Perception {
        let mut ranges = [None; 16];
        ranges[sensor] = Some(Range::from_mm(range_mm));
        Perception {
            ranges,
            pose: Pose::new(Point::default(), heading),
            turned: Bearing::ZERO,
            last: None,
        }
    }

    #[test]
    fn forces_add_up_as_by_hand() {
        // Half a meter from the edge: 0.25 · (2 − 1) / 0.25 = 1 balances the attraction.
        let left = hearing(4, 538, 0.0);
        let mut field = PotentialField::new(TUNING, 0.0);
        let step = field.decide(&left);
        assert!((step.angle() + FRAC_PI_4).abs() < 5e-3, "{step:?}");
        assert!((step.length() - STEP_M).abs() < 1e-12);
        // Nothing repels at 1 m: without a target the heading is kept.
        let far = field.decide(&hearing(4, 1_039, 0.0));
        assert!(far.distance(step) < 1e-12);
    }

    #[test]
    fn a_target_is_gone_to_whatever_the_course_and_the_ring() {
        let mut field = PotentialField::new(TUNING, 0.0);
        field.steer(Some(FRAC_PI_2));
        // The ring looks backward: a target to the left of the start is to its right.
        let step = field.decide(&hearing(0, 5_000, PI));
        assert!(step.distance(Point::new(0.0, -STEP_M)) < 1e-12);
        field.steer(None);
        let on = field.decide(&hearing(0, 5_000, 0.0));
        assert!(on.distance(Point::new(0.0, STEP_M)) < 1e-12);
    }

    #[test]
    fn a_wall_touched_ahead_sends_back() {
        let step = PotentialField::new(TUNING, 0.0).decide(&hearing(0, 38, 0.0));
        assert!(step.distance(Point::new(-STEP_M, 0.0)) < 1e-12);
    }
}
