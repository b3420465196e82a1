//! Robots whose sensors stand anywhere on their bodies.

use amp::config::Config;
use arena::robot::TurretMode;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Setup, run};
use sim::robot::{AnyRobot, Ranges};

/// Rooms that were not used for tuning.
const FIRST: u64 = 10_000;
const ROOMS: u64 = 8;

fn robot(name: &str, has_guard: bool) -> AnyRobot {
    let model = RobotModel::builtin(name).expect("a built-in robot");
    AnyRobot::new(model, Ranges::Nomad, has_guard).expect("at most 16 sensors")
}

/// Contacts and distance, m, of 300 steps in each room.
fn drive(robot: &AnyRobot, sonar: SonarModel) -> (u32, f64) {
    let reports = (FIRST..FIRST + ROOMS).into_par_iter().map(|seed| {
        let setup = Setup {
            config: Config::recommended(),
            preset: "default".to_owned(),
            behavior: Behavior::Avoid,
            explore_moves: 100,
            steps: 300,
            seed,
            sonar,
            turret: TurretMode::Held,
            robot: Some(robot.clone()),
            set_down: None,
            faults: Vec::new(),
            record: false,
        };
        let world = World::random(seed);
        let episode = run(&world, &setup, |_, _, _| {}).expect("it drives to the end");
        (episode.report.contacts, episode.report.distance_m)
    });
    reports.reduce(|| (0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
}

#[test]
fn sensors_anywhere_on_the_body_are_enough_to_touch_nothing() {
    for name in ["p3dx", "epuck2", "thymio2"] {
        let (contacts, distance_m) = drive(&robot(name, false), SonarModel::Ideal);
        assert_eq!(contacts, 0, "{name}");
        assert!(distance_m > 500.0, "{name}: {distance_m} m");
    }
}

#[test]
fn with_noise_and_a_guard_they_touch_nothing_either() {
    for name in ["p3dx", "thymio2"] {
        let (contacts, distance_m) = drive(&robot(name, true), SonarModel::Nomad);
        assert_eq!(contacts, 0, "{name}");
        assert!(distance_m > 400.0, "{name}: {distance_m} m");
    }
}

/// The control: who is told the wrong places of its sensors runs into things.
#[test]
fn scrambled_wires_run_into_things() {
    let (contacts, _) = drive(&robot("p3dx", false).scrambled(1), SonarModel::Ideal);
    assert!(contacts > 20, "{contacts} contacts");
}
