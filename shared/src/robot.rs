//! What the controller knows of a robot's body: where its transducers look, its size and its speed.
//!
//! The paper's miniature robot with eight proximity sensors, a robot with 24 sonars and the Nomad
//! 200 differ in this data only.

use crate::units::{Bearing, Direction};
use serde::{Deserialize, Serialize};

mod nomad200;

/// A ring of `SENSORS` transducers on a round body (at most 32).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RobotSpec<const SENSORS: usize> {
    /// Directions the transducers look, from the robot's center in the ring's frame.
    #[serde(with = "crate::arrays")]
    pub directions: [Direction; SENSORS],
    /// The transducers are evenly spaced, transducer `i` at `i`/`SENSORS` of a turn, so the ring
    /// turned by a place is the same ring.
    pub symmetric: bool,
    /// Distance of the transducers' faces from the center, millimeters.
    pub face_radius_mm: u16,
    /// Radius of the disc that must not touch anything, millimeters.
    pub body_radius_mm: u16,
    /// Longest single displacement, millimeters.
    pub step_mm: u16,
    /// Highest speed, millimeters per second.
    pub speed_mm_s: u16,
    /// Deceleration when stopping, millimeters per second squared.
    pub braking_mm_s2: u16,
    /// Time the ring takes to hear every transducer once, milliseconds.
    pub ring_period_ms: u16,
    /// Longest time the base turns its wheels before it rolls, milliseconds; 0 for a base that
    /// rolls any way at once.
    pub steer_ms: u16,
    /// Half the opening of the cone in which a transducer hears what is nearest; of a ring read off
    /// points, half a point's cone more.
    pub half_cone: Bearing,
}

impl<const SENSORS: usize> RobotSpec<SENSORS> {
    /// Whether motions and rings have deadlines: otherwise blocked wheels or a silent transducer
    /// would stay undetected.
    #[cfg(feature = "store")]
    pub(crate) const fn is_supervisable(&self) -> bool {
        // The ranges of the parameters with these names.
        matches!(self.ring_period_ms, 1..=10_000)
            && self.steer_ms <= 10_000
            && self.speed_mm_s >= 10
            && self.braking_mm_s2 > 0
    }
}

impl RobotSpec<8> {
    /// The paper's miniature robot (Fig. 2): a body of 55 mm with six sensors in front and two
    /// behind; no symmetry.
    #[must_use]
    pub fn miniature() -> Self {
        // Bearings of the Khepera's sensors, left to right and then the two behind, in degrees
        // times 10.
        let decidegrees = [900, 450, 100, -100, -450, -900, -1_700, 1_700_i32];
        Self {
            directions: decidegrees
                .map(|d| Bearing::from_turns((d * 65_536 / 3_600) as u16).direction()),
            symmetric: false,
            face_radius_mm: 27,
            body_radius_mm: 28,
            step_mm: 20,
            speed_mm_s: 100,
            braking_mm_s2: 1_000,
            ring_period_ms: 40,
            steer_ms: 1_000,
            // Unknown: that of the Nomad's sonars.
            half_cone: Bearing::from_turns(2_276),
        }
    }
}

/// Directions of a ring of evenly spaced transducers.
#[must_use]
pub fn evenly_spaced<const SENSORS: usize>() -> [Direction; SENSORS] {
    core::array::from_fn(|index| Bearing::of_place(index, SENSORS).direction())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_constant_ring_is_the_computed_one() {
        assert_eq!(RobotSpec::nomad200().directions, evenly_spaced::<16>());
    }

    #[test]
    fn the_miniature_robot_looks_where_its_sensors_are() {
        let degrees = [90.0, 45.0, 10.0, -10.0, -45.0, -90.0, -170.0, 170.0_f64];
        let robot = RobotSpec::miniature();
        for (found, degrees) in robot.directions.into_iter().zip(degrees) {
            let exact = [
                libm::cos(degrees.to_radians()),
                libm::sin(degrees.to_radians()),
            ];
            for (q14, exact) in [found.x_q14, found.y_q14].into_iter().zip(exact) {
                let error = f64::from(q14) / 16_384.0 - exact;
                assert!(error.abs() < 0.0015, "{degrees}: {error}");
            }
        }
    }

    /// Khepera: four sensors to each side of the middle, the last two behind.
    #[test]
    fn the_miniature_robot_looks_ahead_and_behind() {
        use crate::config::Config;
        let robot = RobotSpec::miniature();
        let sides = robot.directions.map(|direction| direction.y_q14.signum());
        assert_eq!(sides, [1, 1, 1, -1, -1, -1, -1, 1]);
        let ahead = robot.directions.map(|direction| direction.x_q14 > 1_000);
        assert_eq!(ahead, [false, true, true, true, true, false, false, false]);
        let config = Config::touzet().for_robot(robot.clone());
        assert_eq!(
            (&config.robot, config.planning),
            (&robot, Config::touzet().planning)
        );
        assert!(config.enabled.covers(8));
    }
}
