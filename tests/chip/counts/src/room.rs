//! A square room of 4 m × 4 m with a robot whose ring keeps its bearing, in integer arithmetic.

use amp::config::Config;
use amp::robot::RobotSpec;
use amp::units::Displacement;

const HALF_ROOM_MM: i32 = 2_000;

/// The robot's position in the room.
pub struct SquareRoom {
    robot: RobotSpec<16>,
    /// From the center, millimeters.
    x: i32,
    y: i32,
}

impl SquareRoom {
    /// A robot near a wall, so that there is something to learn.
    pub fn new() -> Self {
        Self {
            robot: Config::recommended().robot,
            x: 1_300,
            y: 0,
        }
    }

    /// Distance from a transducer's face to the wall along its axis.
    pub fn range_mm(&self, sensor: usize) -> u16 {
        let axis = self.robot.directions[sensor];
        let to_wall = |place: i32, part: i16| match i32::from(part) {
            0 => i32::MAX,
            part => ((HALF_ROOM_MM * part.signum() - place) << 14) / part,
        };
        let from_middle = to_wall(self.x, axis.x_q14).min(to_wall(self.y, axis.y_q14));
        (from_middle - i32::from(self.robot.face_radius_mm)).max(0) as u16
    }

    /// Moves the robot, unless it would touch a wall. Returns the displacement.
    pub fn drive(&mut self, wanted: Displacement) -> Displacement {
        let limit = HALF_ROOM_MM - i32::from(self.robot.body_radius_mm);
        let (x, y) = (
            self.x + i32::from(wanted.dx_mm),
            self.y + i32::from(wanted.dy_mm),
        );
        if x.abs() > limit || y.abs() > limit {
            return Displacement::ZERO;
        }
        (self.x, self.y) = (x, y);
        wanted
    }
}
