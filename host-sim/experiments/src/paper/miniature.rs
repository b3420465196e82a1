//! Fig. 2: the situation map of a miniature robot with eight sensors after 100 random moves.
//!
//! The robot is [`RobotSpec::miniature`]: a body of 55 mm with the Khepera's eight bearings, which
//! turn with it. Value 1 = 2 cm, 0 = 5 cm, as in the figure. Our choice: sensors see ±20°; a box of
//! 30 cm × 20 cm with two blocks and a post.

use super::any_ring::{AnyRing, Count, SensorModel};
use super::topology::{MapTopology, topology_of};
use amp::config::Config;
use amp::goal::Goal;
use amp::memory::from_bytes;
use amp::robot::RobotSpec;
use amp::scan::Encoding;
use arena::robot::TurretMode;
use arena::world::{Point, Pose, Shape, World};
use files::error::BadInput;
use sim::episode::Seeds;
use sim::recording::MapRecord;
use std::f64::consts::PI;

/// Decisions toward the goal.
const STEPS: u32 = 300;

/// All values of Fig. 2.
#[derive(Debug, Clone, PartialEq)]
pub struct Miniature {
    /// Bearings of the eight sensors, rad counter-clockwise from the front.
    pub bearings_rad: Vec<f64>,
    /// The situation map: 16 neurons of 8 values.
    pub map: MapRecord,
    /// The box in which it moves.
    pub world: World,
    /// Pose before each random move, and at the end.
    pub walk: Vec<Pose>,
    /// Radius of its body, m.
    pub radius_m: f64,
    /// Topology of the map.
    pub topology: MapTopology,
    /// Counts of the random moves.
    pub exploration: Count,
    /// Counts of the avoidance that follows, with frozen maps.
    pub seeking: Count,
}

/// Makes the random moves of the figure, drawn by `seed`.
///
/// # Errors
/// None in practice: the box is part of the program and tested.
pub fn walk(seed: u64) -> Result<Miniature, BadInput> {
    let config = config();
    let radius_m = f64::from(config.robot.body_radius_mm) / 1e3;
    let world = arena(radius_m)?;
    let sensor_model = SensorModel {
        half_angle_rad: PI / 9.0,
        reach_m: 0.1,
    };
    let mut robot = AnyRing::new(config.clone(), &world, TurretMode::Follow, sensor_model);
    let mut walk = Vec::new();
    let exploration = robot.explore_and_learn(Seeds::of(seed).exploration, |pose| walk.push(pose));
    let situations = robot.state().situations();
    let perceived: Vec<_> = robot
        .state()
        .memory()
        .samples()
        .iter()
        .map(|sample| from_bytes(&sample.after).0)
        .collect();
    let topology = topology_of(situations, &perceived, seed);
    let map = MapRecord::new(situations, &perceived);
    let seeking = robot.seek(Goal::avoiding(&config), STEPS);
    let directions = &config.robot.directions;
    Ok(Miniature {
        bearings_rad: directions
            .iter()
            .map(|d| libm::atan2(f64::from(d.y_q14), f64::from(d.x_q14)))
            .collect(),
        map,
        walk,
        radius_m,
        topology,
        exploration,
        seeking,
        world,
    })
}

/// A configuration with the paper's four steps at the scale of the miniature robot.
fn config() -> Config<8> {
    Config {
        encoding: Encoding {
            near_mm: 20,
            far_mm: 50,
        },
        clearance_mm: 50,
        shield: None,
        ..Config::probing().for_robot(RobotSpec::miniature())
    }
}

fn arena(radius_m: f64) -> Result<World, BadInput> {
    let block = |x: f64, y: f64, angle: f64| Shape::Box {
        center: Point::new(x, y),
        size: Point::new(0.03, 0.03),
        angle,
    };
    let shapes = vec![
        Shape::room(Point::new(0.15, 0.1)),
        block(-0.07, 0.05, 0.4),
        block(0.08, -0.05, 0.0),
        Shape::Circle {
            center: Point::new(0.06, 0.06),
            radius: 0.008,
        },
    ];
    World::for_body("miniature", Pose::default(), shapes, radius_m)
}
