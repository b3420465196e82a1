//! The situation that a robot at rest perceives at a given pose, and what is known of it.

use super::Seeds;
use crate::pilot::SimState;
use crate::robot::AnyRobot;
use amp::fixed::Mask;
use amp::memory;
use amp::scan::{Encoding, Situation};
use amp::units::Range;
use arena::noise::Noise;
use arena::sonar::{FIRING_ORDER, FIRING_SLOT_S, Ring, SonarModel};
use arena::world::{Pose, World};

/// The situation of a whole ring at rest in `pose`, and the transducers of which something is
/// known: of another robot than the Nomad, the ring of sectors that its controller reads off what
/// its sensors hear there. `seed` seeds the noise.
#[must_use]
pub fn perceive(
    world: &World,
    pose: Pose,
    robot: Option<&AnyRobot>,
    sonar: SonarModel,
    seed: u64,
    encoding: Encoding,
) -> (Situation<16>, Mask) {
    let mut noise = Noise::new(Seeds::of(seed).noise);
    let (mut ring, count) = match robot {
        None => (Ring::new(sonar, &mut noise), 16),
        Some(robot) => {
            let mounts = robot.mounts();
            let sensing = robot.sensing(sonar);
            let ring = Ring::with_mounts(sonar, &mounts, sensing, &mut noise);
            (ring, mounts.len())
        }
    };
    let mut ranges = [None; 16];
    for (slot, &sensor) in FIRING_ORDER.iter().enumerate() {
        let time_s = slot as f64 * FIRING_SLOT_S;
        if let Some(range) = ranges.get_mut(sensor).filter(|_| sensor < count) {
            *range = ring.ping(world, &pose, sensor, time_s, &mut noise);
        }
    }
    // A range beyond 65 m cannot come from a sonar; the cast saturates.
    let millimeters = |m: f64| Range::from_mm((m * 1e3) as u16);
    let (ranges, known) = match robot {
        None => (
            ranges.map(|range: Option<f64>| range.map(millimeters)),
            Mask::ALL,
        ),
        Some(robot) => robot.ring_of(ranges.get(..count).unwrap_or(&ranges)),
    };
    (ranges.map(|range| encoding.value(range)), known)
}

/// What was known in the situation before the first move. A body's sensors do not see all at once,
/// and a range that jumped during the first move (`Learning::largest_change_mm`) belonged to an
/// edge or was noise: a place is not recognized by it.
#[must_use]
pub fn nest_known(knowledge: &SimState) -> Mask {
    let first = knowledge.memory().samples().first();
    first.map_or(Mask::ALL, |sample| memory::from_bytes(&sample.before).1)
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
            let (captured, _) = perceive(
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
