//! Robots whose sensors stand anywhere on their bodies.

use amp::config::Config;
use arena::robot::TurretMode;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Setup, run};
use sim::robot::{AnyRobot, Origin, Ranges};

/// Rooms that were not used for tuning.
const FIRST: u64 = 10_000;
const ROOMS: u64 = 24;

fn robot(name: &str, has_guard: bool) -> AnyRobot {
    let model = RobotModel::builtin(name).expect("a built-in robot");
    AnyRobot::new(model, Ranges::Nomad, has_guard).expect("at most 16 sensors")
}

/// What 300 steps in each room come to, added up.
#[derive(Debug, Default)]
struct Driven {
    explore_contacts: u32,
    contacts: u32,
    distance_m: f64,
    /// Median error of the sensors' bearings in each room where they were learned.
    bearing_errors_deg: Vec<f64>,
}

fn drive(robot: &AnyRobot, sonar: SonarModel) -> Driven {
    let reports = (FIRST..FIRST + ROOMS).into_par_iter().map(|seed| {
        let setup = Setup {
            config: robot.config(Config::recommended()),
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
            goal: None,
            second_robot: false,
            record: false,
        };
        let world = World::random(seed);
        let episode = run(&world, &setup, |_, _, _| {}).expect("it drives to the end");
        Driven {
            explore_contacts: episode.report.explore_contacts,
            contacts: episode.report.contacts,
            distance_m: episode.report.distance_m,
            bearing_errors_deg: episode
                .bearing_errors_deg
                .map(|[median, _]| median)
                .into_iter()
                .collect(),
        }
    });
    reports.reduce(Driven::default, |sum, one| Driven {
        explore_contacts: sum.explore_contacts + one.explore_contacts,
        contacts: sum.contacts + one.contacts,
        distance_m: sum.distance_m + one.distance_m,
        bearing_errors_deg: [sum.bearing_errors_deg, one.bearing_errors_deg].concat(),
    })
}

#[test]
fn sensors_anywhere_on_the_body_are_enough_to_touch_nothing() {
    for name in ["p3dx", "epuck2", "thymio2"] {
        let driven = drive(&robot(name, false), SonarModel::Ideal);
        assert_eq!(driven.contacts, 0, "{name}");
        assert!(driven.distance_m > 1_500.0, "{name}: {driven:?}");
    }
}

/// The ring behind points keeps its bearing, whatever the turret does.
#[test]
fn the_nomad_drives_with_a_turret_that_follows_as_with_one_that_is_held() {
    for turret in [TurretMode::Held, TurretMode::Follow] {
        let nomad = robot("nomad200", false).with_turret(turret);
        let driven = drive(&nomad.expect("it has a turret"), SonarModel::Ideal);
        assert_eq!(driven.contacts, 0, "{turret:?}");
        assert!(driven.distance_m > 1_700.0, "{turret:?}: {driven:?}");
    }
}

#[test]
fn with_noise_and_a_guard_they_touch_nothing_either() {
    for name in ["p3dx", "thymio2"] {
        let driven = drive(&robot(name, true), SonarModel::Nomad);
        assert_eq!(driven.contacts, 0, "{name}");
        assert!(driven.distance_m > 1_200.0, "{name}: {driven:?}");
    }
}

/// Nobody tells it the order of its wires, or where its sensors look.
#[test]
fn a_robot_that_learned_where_its_sensors_look_touches_nothing() {
    let robot = robot("p3dx", false).scrambled(1);
    let robot = robot.with_geometry(Origin::Learned).expect("it turns");
    let driven = drive(&robot, SonarModel::Ideal);
    assert_eq!(driven.contacts, 0, "{driven:?}");
    assert!(driven.distance_m > 1_500.0, "{driven:?}");
    let errors_deg = &driven.bearing_errors_deg;
    let small = errors_deg.iter().filter(|error| **error <= 5.0).count();
    assert!(small >= 20, "{errors_deg:?}");
}

/// Random moves know nothing of goals: only the guard ends them in time.
#[test]
fn the_guard_keeps_random_moves_from_touching() {
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        let [alone, guarded] =
            [false, true].map(|has_guard| drive(&robot("p3dx", has_guard), sonar).explore_contacts);
        assert!(alone > 5, "{sonar:?}: {alone}");
        assert_eq!(guarded, 0, "{sonar:?}");
    }
}

/// The control: who is told the wrong places of its sensors runs into things.
#[test]
fn scrambled_wires_run_into_things() {
    let driven = drive(&robot("p3dx", false).scrambled(1), SonarModel::Ideal);
    assert!(driven.contacts > 60, "{driven:?}");
}
