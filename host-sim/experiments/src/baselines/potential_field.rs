//! The artificial potential field: the target attracts, what is near repels, the robot follows the sum.
//!
//! O. Khatib, *Real-time obstacle avoidance for manipulators and mobile robots*, International Journal of Robotics
//! Research 5(1), 1986, 90–98: an obstacle at distance ρ below ρ₀ repels with η (1/ρ − 1/ρ₀) / ρ². Each echo counts as one
//! obstacle on its transducer's axis, as in the virtual force field (J. Borenstein, Y. Koren, *Real-time obstacle
//! avoidance for fast mobile robots*, IEEE Transactions on Systems, Man, and Cybernetics 19(5), 1989, 1179–1187), but by the
//! latest ring alone, without a certainty grid. Our reading: only a bearing is known of the target, so it attracts with
//! the constant force 1; without a target the course does.
//!
//! Where the forces balance the robot trembles on the spot, as the method is known to: there is no cure for local minima here.

use arena::robot::COLLISION_RADIUS_M;
use arena::sonar::FACE_RADIUS_M;
use arena::world::Point;
use sim::ring_pilot::{Perception, Policy, STEP_M, Steerable, axis};

/// From a transducer's face to the rim of the body that must not touch, m.
const RIM_M: f64 = COLLISION_RADIUS_M - FACE_RADIUS_M;
/// No distance counts as shorter than this, m: forces stay finite.
const LEAST_M: f64 = 0.01;
/// A sum of forces weaker than this has no direction.
const BALANCE: f64 = 1e-6;

/// The field's constants; the default values were searched for in rooms that nothing is compared in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// ρ₀: obstacles farther than this do not repel, m from the rim of the body.
    pub reach_m: f64,
    /// η, m³ (the attraction is 1).
    pub strength: f64,
}

impl Default for Tuning {
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
    tuning: Tuning,
    /// Bearing to go along, rad in the frame of the pose.
    target: Option<f64>,
    /// Direction of the last step, rad in the frame of the pose.
    course: f64,
}

impl PotentialField {
    /// A robot that starts along `course` (rad from the ring's x axis) and goes wherever the way is free.
    #[must_use]
    pub fn new(tuning: Tuning, course: f64) -> Self {
        Self {
            tuning,
            target: None,
            course,
        }
    }

    /// What repels, in the ring's frame.
    fn repulsion(&self, perceived: &Perception) -> Point {
        let mut sum = Point::default();
        for sensor in 0..16 {
            let distance = (perceived.range_m(sensor) - RIM_M).max(LEAST_M);
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

    const TUNING: Tuning = Tuning {
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
        // Half a meter from the rim: 0.25 · (2 − 1) / 0.25 = 1, just the attraction.
        let left = hearing(4, 538, 0.0);
        let mut field = PotentialField::new(TUNING, 0.0);
        let step = field.decide(&left);
        assert!((step.angle() + FRAC_PI_4).abs() < 5e-3, "{step:?}");
        assert!((step.length() - STEP_M).abs() < 1e-12);
        // A meter away nothing repels any more: without a target the course goes on.
        let far = field.decide(&hearing(4, 1_039, 0.0));
        assert!(far.distance(step) < 1e-12);
    }

    #[test]
    fn a_target_is_gone_to_whatever_the_course_and_the_ring() {
        let mut field = PotentialField::new(TUNING, 0.0);
        field.steer(Some(FRAC_PI_2));
        // The ring looks backwards: a target to the left of the start is to its right.
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
