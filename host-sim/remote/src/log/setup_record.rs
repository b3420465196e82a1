//! The JSON record of the channel `/setup`.

use amp::config::Config;
use arena::sonar::SonarModel;
use serde::{Deserialize, Serialize};
use sim::robot::{AnyRobot, ToldRobot};

/// Conditions of a start without knowledge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SetupRecord {
    /// Version of the format: [`FORMAT`].
    pub format: u32,
    /// Version of the program.
    pub program: String,
    /// Name of the world.
    pub world: String,
    /// Behavior of the episode.
    pub behavior: String,
    /// Name of the configuration's preset.
    pub preset: String,
    /// Seed of all randomness.
    pub seed: u64,
    /// Sonar model.
    pub sonar: String,
    /// What the ring does while the base steers.
    pub turret: String,
    /// Number of random moves.
    pub explore_moves: u16,
    /// The robot, if it is not the Nomad with its own ring.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<Box<RobotRecord>>,
    /// The controller's configuration.
    pub config: Config<16>,
}

/// A robot whose sensors stand anywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotRecord {
    /// Its name.
    pub name: String,
    /// Radius of its body, meters.
    pub radius_m: f64,
    /// Radius of the circle that its controller takes the sensors to stand on, meters.
    pub face_radius_m: f64,
    /// Half the opening of a sensor's cone, radians.
    pub half_cone_rad: f64,
    /// Where its sensors stand and look, in the order of the controller's inputs: x ahead and y to
    /// the left, meters; bearing from the front, radians.
    pub sensors: Vec<[f64; 3]>,
    /// Whether the base takes left for right.
    pub is_mirrored: bool,
    /// What the controller is told of it.
    pub told: ToldRobot,
}

impl RobotRecord {
    /// A robot with this model of its sensors.
    #[must_use]
    pub fn of(robot: &AnyRobot, sonar: SonarModel) -> Self {
        let told = robot.told();
        let sensors = robot.mounts().into_iter();
        Self {
            name: robot.model().name.clone(),
            radius_m: robot.model().radius_m,
            face_radius_m: f64::from(told.body.points.face_radius_mm) / 1e3,
            half_cone_rad: robot.sensing(sonar).half_angle_rad,
            sensors: sensors
                .map(|mount| [mount.position.x, mount.position.y, mount.bearing_rad])
                .collect(),
            is_mirrored: robot.miswiring().is_some_and(|wrong| wrong.side() < 0.0),
            told,
        }
    }
}

impl SetupRecord {
    /// The conditions of an episode in a world of this name.
    #[must_use]
    pub fn of(world: &str, setup: &sim::episode::Setup) -> Self {
        Self {
            format: FORMAT,
            program: env!("CARGO_PKG_VERSION").to_owned(),
            world: world.to_owned(),
            behavior: setup.behavior.name(),
            preset: setup.preset.clone(),
            seed: setup.seed,
            sonar: setup.sonar.name().to_owned(),
            turret: setup.turret.name().to_owned(),
            explore_moves: setup.explore_moves,
            robot: setup
                .robot
                .as_ref()
                .map(|robot| Box::new(RobotRecord::of(robot, setup.sonar))),
            config: setup.config.clone(),
        }
    }
}

/// Version of the records.
pub const FORMAT: u32 = 5;

/// The oldest version that can be read; 3 differs in names, which are read as aliases, and before 5
/// the robot is always the Nomad with its own ring.
pub(super) const OLDEST_FORMAT: u32 = 3;
