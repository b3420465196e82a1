//! The situation that a robot at rest perceives at a given pose.

use super::Seeds;
use crate::robot::AnyRobot;
use amp::scan::{Encoding, Situation};
use amp::units::Range;
use arena::noise::Noise;
use arena::sonar::{FIRING_ORDER, FIRING_SLOT_S, Ring, SonarModel};
use arena::world::{Pose, World};

/// The situation of a whole ring at rest in `pose`: the Nomad's, or the ring of sectors that a
/// robot's controller sees, complete and exact up to the sensors' noise. `seed` seeds the noise.
#[must_use]
pub fn perceive(
    world: &World,
    pose: Pose,
    robot: Option<&AnyRobot>,
    sonar: SonarModel,
    seed: u64,
    encoding: Encoding,
) -> Situation<16> {
    let mut noise = Noise::new(Seeds::of(seed).noise);
    let mut ring = match robot {
        None => Ring::new(sonar, &mut noise),
        Some(robot) => {
            let (mounts, sensing) = (robot.ring_of_sectors(), robot.sensing(sonar));
            Ring::with_mounts(sonar, &mounts, sensing, &mut noise)
        }
    };
    let mut ranges = [None; 16];
    for (slot, &sensor) in FIRING_ORDER.iter().enumerate() {
        let time_s = slot as f64 * FIRING_SLOT_S;
        if let Some(range) = ranges.get_mut(sensor) {
            *range = ring.ping(world, &pose, sensor, time_s, &mut noise);
        }
    }
    // A range beyond 65 m cannot come from a sonar; the cast saturates.
    let millimeters = |m: f64| Range::from_mm((m * 1e3) as u16);
    ranges.map(|range: Option<f64>| encoding.value(range.map(millimeters)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::behavior::Behavior;
    use crate::episode::{Setup, run};
    use amp::config::Config;
    use arena::robot::TurretMode;

    #[test]
    fn a_robot_at_its_start_perceives_what_is_captured_there() {
        let config = Config::recommended();
        for seed in 0..5 {
            let world = World::random(seed);
            let captured = perceive(
                &world,
                world.start(),
                None,
                SonarModel::Ideal,
                seed,
                config.encoding,
            );
            let setup = Setup {
                config: config.clone(),
                preset: String::new(),
                behavior: Behavior::Avoid,
                explore_moves: 1,
                steps: 1,
                seed,
                sonar: SonarModel::Ideal,
                turret: TurretMode::Held,
                robot: None,
                set_down: None,
                faults: Vec::new(),
                record: true,
            };
            let episode = run(&world, &setup, |_, _, _| {}).expect("an episode");
            let recording = episode.recording.expect("its steps");
            let perceived = &recording.exploration[0].situation;
            for (value, perceived) in captured.iter().zip(perceived) {
                assert!((value.to_num::<f64>() - perceived).abs() < 1e-9, "{seed}");
            }
        }
    }
}
