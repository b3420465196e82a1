//! What a robot perceives at a given place, and what of it the place can be recognized by.

use super::Seeds;
use crate::robot::AnyRobot;
use amp::config::Config;
use amp::fixed::Mask;
use amp::scan::Situation;
use amp::units::Range;
use arena::noise::Noise;
use arena::sonar::{FIRING_ORDER, FIRING_SLOT_S, Ring, SonarModel};
use arena::world::{Point, Pose, World};
use std::f64::consts::TAU;

/// Headings in which a body that turns listens to a place.
const HEADINGS: u8 = 12;

/// The situation in `pose`, and the transducers by which the place can be recognized: those whose
/// range changes by at most [`largest_change_mm`](amp::config::Learning::largest_change_mm) half a
/// step away to four sides. What changes more belongs to an edge, and says something else when the
/// robot returns a little aside.
///
/// `None` is the Nomad. Of another robot it is the ring of sectors that its controller reads off
/// what the sensors hear while the body, if it turns to where it goes, turns once around. `seed`
/// seeds the noise; `config` is the robot's.
#[must_use]
pub fn perceive(
    world: &World,
    pose: Pose,
    robot: Option<&AnyRobot>,
    sonar: SonarModel,
    seed: u64,
    config: &Config<16>,
) -> (Situation<16>, Mask) {
    let mut listener = Listener::new(world, robot, sonar, seed);
    let mut situation_at = |pose| {
        let (ranges, known) = listener.listen(pose);
        (ranges.map(|range| config.encoding.value(range)), known)
    };
    let (situation, known) = situation_at(pose);
    let aside_m = f64::from(config.robot.step_mm) * 1e-3 / 2.0;
    let aside = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)].map(|(x, y)| Pose {
        position: pose.position + Point::new(x, y) * aside_m,
        ..pose
    });
    let largest_mm = config.learning.largest_change_mm;
    let recognized = aside.into_iter().fold(known, |recognized, pose| {
        let (nearby, _) = situation_at(pose);
        let steady = config
            .encoding
            .changed_within(&situation, &nearby, largest_mm);
        recognized.and(steady)
    });
    (situation, recognized)
}

/// A robot that listens wherever it is put.
struct Listener<'a> {
    world: &'a World,
    robot: Option<&'a AnyRobot>,
    ring: Ring,
    transducers: usize,
    noise: Noise,
}

impl<'a> Listener<'a> {
    fn new(world: &'a World, robot: Option<&'a AnyRobot>, sonar: SonarModel, seed: u64) -> Self {
        let mut noise = Noise::new(Seeds::of(seed).noise);
        let (ring, transducers) = match robot {
            None => (Ring::new(sonar, &mut noise), 16),
            Some(robot) => {
                let mounts = robot.mounts();
                let sensing = robot.sensing(sonar);
                let ring = Ring::with_mounts(sonar, &mounts, sensing, &mut noise);
                (ring, mounts.len())
            }
        };
        Self {
            world,
            robot,
            ring,
            transducers,
            noise,
        }
    }

    /// The ring of its controller, and what is known of it.
    fn listen(&mut self, pose: Pose) -> ([Option<Range>; 16], Mask) {
        let Some(robot) = self.robot else {
            return (self.ranges(pose), Mask::ALL);
        };
        let headings = if robot.turns() { HEADINGS } else { 1 };
        robot.ring_of((0..headings).map(|heading| {
            let turned_rad = f64::from(heading) / f64::from(headings) * TAU;
            let heading = pose.heading + turned_rad;
            (turned_rad, self.ranges(Pose { heading, ..pose }))
        }))
    }

    /// What each transducer tells.
    fn ranges(&mut self, pose: Pose) -> [Option<Range>; 16] {
        let mut ranges = [None; 16];
        for (slot, &sensor) in FIRING_ORDER.iter().enumerate() {
            let time_s = slot as f64 * FIRING_SLOT_S;
            if let Some(range) = ranges.get_mut(sensor).filter(|_| sensor < self.transducers) {
                let noise = &mut self.noise;
                let range_m = self.ring.ping(self.world, &pose, sensor, time_s, noise);
                // A range beyond 65 m cannot come from a sensor; the cast saturates.
                *range = range_m.map(|m| Range::from_mm((m * 1e3) as u16));
            }
        }
        ranges
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::behavior::Behavior;
    use crate::episode::{Setup, run};
    use crate::robot::Ranges;
    use amp::config::Config;
    use arena::robot::TurretMode;
    use arena::robot_model::RobotModel;
    use arena::world::Shape;

    /// The middle of a wide room, with a thin post at this bearing, 2 m away.
    fn room_with_post(bearing_deg: f64) -> World {
        let (sine, cosine) = libm::sincos(bearing_deg.to_radians());
        let walls = Shape::room(Point::new(9.0, 9.0));
        let room = World::new("room", Pose::default(), vec![walls]).expect("a sound world");
        room.with_post(Point::new(cosine, sine) * 2.0, 0.03)
    }

    /// 15° is just outside the cone of sensor 0 and inside that of sensor 1; half a step aside it
    /// is inside both.
    #[test]
    fn a_place_is_not_recognized_by_what_jumps_a_little_aside() {
        let world = room_with_post(15.0);
        for (config, is_masked) in [(Config::recommended(), true), (Config::touzet(), false)] {
            let (_, recognized) =
                perceive(&world, world.start(), None, SonarModel::Ideal, 0, &config);
            assert_eq!(recognized.contains(0), !is_masked);
            assert!(
                (1..16).all(|sensor| recognized.contains(sensor)),
                "{recognized:?}"
            );
        }
    }

    /// A Thymio has no sensors at its sides.
    #[test]
    fn a_body_perceives_a_place_while_it_turns_once_around() {
        let model = RobotModel::find("thymio2").expect("a built-in robot");
        let robot = AnyRobot::new(model, Ranges::Nomad, false).expect("few enough sensors");
        let config = robot.config(Config::recommended());
        let world = room_with_post(90.0);
        let (situation, recognized) = perceive(
            &world,
            world.start(),
            Some(&robot),
            SonarModel::Ideal,
            0,
            &config,
        );
        assert!(recognized.contains(4), "{recognized:?}");
        assert!(situation[4] > situation[0] && situation[4] > situation[8]);
    }

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
                &config,
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
                goal: None,
                second_robot: false,
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
