//! The conditions of an episode.

use crate::behavior::Behavior;
use crate::goal_file::GoalFile;
use crate::robot::AnyRobot;
use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::{SonarModel, TransducerFault};
use arena::world::Point;

/// The conditions of an episode, without its world.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The controller's configuration.
    pub config: Config<16>,
    /// Name of the preset it came from.
    pub preset: String,
    /// Behavior after exploring.
    pub behavior: Behavior,
    /// Its goal is pursued instead of the behavior's own; the behavior says how it is measured.
    pub goal: Option<Box<GoalFile>>,
    /// Random moves, 1 … [`MAX_MOVES`](crate::pilot::MAX_MOVES).
    pub explore_moves: u16,
    /// Decisions towards the goal, at least 1.
    pub steps: u32,
    /// Seed of all randomness.
    pub seed: u64,
    /// What the sonars return.
    pub sonar: SonarModel,
    /// Faulty transducers.
    pub faults: Vec<TransducerFault>,
    /// A second robot drives around in the world, whatever the behavior is.
    pub second_robot: bool,
    /// What the ring does while the base steers.
    pub turret: TurretMode,
    /// The robot, if it is not the Nomad; it then has its own sensors and no turret.
    pub robot: Option<AnyRobot>,
    /// Where the robot is placed after exploring; `None` = the default of its behavior.
    pub set_down: Option<Point>,
    /// Record every step, for pictures.
    pub record: bool,
}

impl Setup {
    /// Random moves that teach where the sensors look; the others teach the maps.
    #[must_use]
    pub fn calibration_moves(&self) -> u16 {
        let robot = self.robot.as_ref();
        robot.map_or(0, |robot| robot.calibration_moves(self.explore_moves))
    }

    /// The name of the behavior, and of the file with its goal.
    #[must_use]
    pub fn task(&self) -> String {
        let behavior = self.behavior.name();
        match &self.goal {
            Some(file) => format!("{behavior} by {}", file.path),
            None => behavior,
        }
    }

    /// The same with another behavior.
    #[must_use]
    pub fn pursuing(self, behavior: Behavior) -> Self {
        Self { behavior, ..self }
    }
}
