//! Avoidance with rings of 8, 16 and 24 transducers, in half of the rooms.

use super::any_ring::{AnyRing, Count, SensorModel};
use super::measure::{ProgressListener, Size};
use super::{PaperReading, STEPS};
use amp::config::Config;
use amp::goal::Goal;
use amp::robot::{RobotSpec, evenly_spaced};
use arena::sonar::SonarConfig;
use arena::world::World;
use rayon::prelude::*;
use sim::episode::Seeds;

/// Counts for rings of 8, 16 and 24 transducers.
pub(super) fn measure(
    size: Size,
    reading: &PaperReading,
    progress: &impl ProgressListener,
) -> Vec<(usize, Vec<Count>)> {
    progress.begin("rings", 3);
    let one = |counts: Vec<Count>, sensors| {
        progress.done();
        (sensors, counts)
    };
    vec![
        one(ring::<8>(size, reading), 8),
        one(ring::<16>(size, reading), 16),
        one(ring::<24>(size, reading), 24),
    ]
}

/// Avoidance in half of the rooms by a Nomad with another ring. The cones leave no gap: ±200°
/// divided by the number of sensors.
fn ring<const SENSORS: usize>(size: Size, reading: &PaperReading) -> Vec<Count> {
    let nomad = RobotSpec::nomad200();
    let robot = RobotSpec {
        directions: evenly_spaced::<SENSORS>(),
        symmetric: true,
        face_radius_mm: nomad.face_radius_mm,
        body_radius_mm: nomad.body_radius_mm,
        step_mm: nomad.step_mm,
        speed_mm_s: nomad.speed_mm_s,
        braking_mm_s2: nomad.braking_mm_s2,
        ring_period_ms: nomad.ring_period_ms,
        steer_ms: nomad.steer_ms,
        half_cone: nomad.half_cone,
    };
    let config: Config<SENSORS> = reading.config.for_robot(robot);
    let sensor_model = SensorModel {
        half_angle_rad: 200.0_f64.to_radians() / SENSORS as f64,
        reach_m: SonarConfig::ideal().max_range_m,
    };
    (0..u64::from(size.rooms.div_ceil(2)))
        .into_par_iter()
        .map(|room| {
            let world = World::random(room.wrapping_add(1));
            let mut robot = AnyRing::new(config.clone(), &world, reading.turret, sensor_model);
            let seed = size.seed.wrapping_add(room);
            robot.explore_and_learn(Seeds::of(seed).exploration, |_| {});
            robot.seek(Goal::avoiding(&config), STEPS)
        })
        .collect()
}
