//! Robots as data: body, limits of the drive and mounting of the range sensors.
//!
//! A [`RobotModel`] is read from a TOML file, or is one of the robots that come with the program.
//! The format and the source of every number stand in `docs/robots.md`.
//!
//! Body frame: x points ahead, y to the left, in meters; angles count counter-clockwise from ahead.
//! The origin is the point about which the robot turns on the spot.

use core::str::FromStr;
use std::path::Path;

use crate::world::Point;
use files::error::{BadInput, suggestion};

mod file;

/// Maximum number of sensors.
pub const MAX_SENSORS: usize = 32;

/// Name and text of each built-in robot.
const ROBOTS: &[(&str, &str)] = &[
    ("nomad200", include_str!("../../robots/nomad200.toml")),
    ("p3dx", include_str!("../../robots/p3dx.toml")),
    ("p3dx-front", include_str!("../../robots/p3dx-front.toml")),
    ("p3at", include_str!("../../robots/p3at.toml")),
    ("epuck2", include_str!("../../robots/epuck2.toml")),
    ("thymio2", include_str!("../../robots/thymio2.toml")),
    ("khepera", include_str!("../../robots/khepera.toml")),
    ("crazyflie", include_str!("../../robots/crazyflie.toml")),
    ("turtlebot3", include_str!("../../robots/turtlebot3.toml")),
    ("lidar16", include_str!("../../robots/lidar16.toml")),
    ("one-beam", include_str!("../../robots/one-beam.toml")),
];

/// Kind of drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriveKind {
    /// All wheels roll and steer together; the body keeps its heading.
    Synchro,
    /// Two wheels, or two sides, at different speeds; the robot moves along its heading.
    Differential,
    /// The robot moves in any direction and turns independently.
    Holonomic,
}

impl DriveKind {
    /// The names, in the order of the variants.
    pub const NAMES: [&'static str; 3] = ["synchro", "differential", "holonomic"];

    /// Name of the drive.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Synchro => "synchro",
            Self::Differential => "differential",
            Self::Holonomic => "holonomic",
        }
    }
}

impl FromStr for DriveKind {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "synchro" => Ok(Self::Synchro),
            "differential" => Ok(Self::Differential),
            "holonomic" => Ok(Self::Holonomic),
            _ => Err(BadInput::unknown("drive", text, &Self::NAMES)),
        }
    }
}

/// Kind of range sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SensorKind {
    /// Ultrasonic transducer.
    #[default]
    Sonar,
    /// Infrared proximity sensor: the reflected light.
    Infrared,
    /// Time of flight or triangulation of a laser; for a scanner, one sector.
    Laser,
}

impl SensorKind {
    /// The names, in the order of the variants.
    pub const NAMES: [&'static str; 3] = ["sonar", "infrared", "laser"];

    /// Name of the kind.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sonar => "sonar",
            Self::Infrared => "infrared",
            Self::Laser => "laser",
        }
    }
}

impl FromStr for SensorKind {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "sonar" => Ok(Self::Sonar),
            "infrared" => Ok(Self::Infrared),
            "laser" => Ok(Self::Laser),
            _ => Err(BadInput::unknown("sensor kind", text, &Self::NAMES)),
        }
    }
}

/// Mounting of a range sensor on the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorMount {
    /// Direction of the axis, rad from ahead, positive to the left, in [−2π, 2π].
    pub bearing_rad: f64,
    /// Position of the face in the body frame, m: at most twice the radius from the center.
    pub position: Point,
    /// Kind of sensor.
    pub kind: SensorKind,
}

/// A robot: body, limits of the drive, range sensors.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotModel {
    /// Name, not empty.
    pub name: String,
    /// Kind of drive.
    pub drive: DriveKind,
    /// Radius of the collision disc around the center, m, in (0, 10].
    pub radius_m: f64,
    /// Greatest speed, m/s, in (0, 20].
    pub max_speed_m_s: f64,
    /// Greatest rate of turn, rad/s, in (0, 20π].
    pub max_turn_rad_s: f64,
    /// Shortest and longest measurable range, m from the face: 0 ≤ shortest < longest ≤ 1000.
    pub range_m: [f64; 2],
    /// Half the opening of a sensor, rad, in (0, π/2].
    pub half_cone_rad: f64,
    /// Time in which every sensor measures once, s, in (0, 10].
    pub period_s: f64,
    /// Slip of the wheels: standard deviation as a share of the distance, in [0, 1].
    pub wheel_slip: f64,
    /// Random walk of the heading that the odometry does not measure: standard deviation after 1 m,
    /// rad/√m, in [0, π/2].
    pub heading_drift: f64,
    /// Order in which the sensors measure, in equal slots of the period: a permutation of their
    /// numbers. `None`: all at the same time.
    pub firing_order: Option<Vec<usize>>,
    /// The sensors: 1 to [`MAX_SENSORS`].
    pub sensors: Vec<SensorMount>,
}

impl RobotModel {
    /// Reads a robot file.
    ///
    /// # Errors
    /// When the file is missing or unreadable, or describes an impossible robot; the sentence names
    /// file, line and key.
    pub fn load(path: &Path) -> Result<Self, BadInput> {
        file::load(path)
    }

    /// Reads the text of a robot file; `source` names it in errors.
    ///
    /// # Errors
    /// Like [`RobotModel::load`].
    pub fn from_toml(text: &str, source: &str) -> Result<Self, BadInput> {
        file::parse(text, source)
    }

    /// The names of the built-in robots; the first is the paper's robot.
    #[must_use]
    pub fn builtin_names() -> Vec<&'static str> {
        ROBOTS.iter().map(|(name, _)| *name).collect()
    }

    /// The built-in robot called `name`.
    ///
    /// # Errors
    /// When there is none of that name; the sentence suggests the nearest one.
    pub fn builtin(name: &str) -> Result<Self, BadInput> {
        match ROBOTS.iter().find(|(known, _)| *known == name) {
            Some((known, text)) => file::parse(text, known),
            None => Err(BadInput::unknown("robot", name, &Self::builtin_names())),
        }
    }

    /// The robot `text` names: a built-in robot, or a robot file. A file called like a built-in
    /// robot is reached as `./NAME`.
    ///
    /// # Errors
    /// When `text` names nothing known; otherwise like [`RobotModel::load`].
    pub fn find(text: &str) -> Result<Self, BadInput> {
        let names = Self::builtin_names();
        if names.contains(&text) {
            return Self::builtin(text);
        }
        let path = Path::new(text);
        if path.exists() {
            return Self::load(path);
        }
        if text.contains(['/', '\\']) || path.extension().is_some() {
            return Err(BadInput::file(path, "there is no such robot file"));
        }
        let hint = suggestion(text, &names);
        Err(BadInput::new(format!(
            "unknown robot \"{text}\"{hint} (a file, or one of: {})",
            names.join(", ")
        )))
    }
}

#[cfg(test)]
mod tests;
