use super::{TurretController, TurretPolicy};
use crate::behavior::{Behavior, Tour, TourBy};
use crate::episode::{Episode, Setup, run, run_with};
use crate::goal_file::GoalFile;
use crate::pilot::Pilot as _;
use crate::ring_pilot::{Perception, Policy};
use crate::robot::{AnyRobot, Miswiring, Origin, Ranges};
use amp::config::Config;
use amp::controller::Event;
use amp::fixed::Mask;
use amp::units::{Millis, Range};
use arena::loaders::rooms;
use arena::robot::TurretMode;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::{Point, World};

fn scrambled(name: &str) -> AnyRobot {
    let model = RobotModel::builtin(name).expect("built in");
    let robot = AnyRobot::new(model, Ranges::Nomad, false).expect("it fits");
    let robot = robot.scrambled(1).with_geometry(Origin::Learned);
    robot.expect("it turns")
}

fn drive(robot: AnyRobot, sonar: SonarModel, steps: u32, seed: u64) -> Episode {
    let setup = setup(robot, sonar, steps, seed);
    run(&World::random(seed), &setup, |_, _, _| {}).expect("it drives")
}

fn setup(robot: AnyRobot, sonar: SonarModel, steps: u32, seed: u64) -> Setup {
    Setup {
        config: robot.config(Config::recommended()),
        preset: "default".to_owned(),
        behavior: Behavior::Avoid,
        explore_moves: 100,
        steps,
        seed,
        sonar,
        turret: TurretMode::Held,
        robot: Some(robot),
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    }
}

/// It looks for what is as near as can be ahead, and hears its shortest range, stray echoes and
/// posts between two beams.
#[test]
fn a_guard_keeps_a_robot_off_whatever_it_seeks() {
    let mut situation = [f64::NAN; 16];
    situation[0] = 1.0;
    let text = format!("situation = {situation:?}").replace("NaN", "nan");
    let file = GoalFile::read(&text, "near.toml").expect("a goal");
    for (seed, sonar) in [
        (202, SonarModel::Ideal),
        (203, SonarModel::Nomad),
        (206, SonarModel::Nomad),
        (215, SonarModel::Nomad),
    ] {
        for name in ["nomad200", "p3dx"] {
            let model = RobotModel::builtin(name).expect("built in");
            let robot = AnyRobot::new(model, Ranges::Own, true).expect("it fits");
            let setup = Setup {
                behavior: Behavior::Seek(Box::new(file.clone())),
                ..setup(robot, sonar, 1_000, 1)
            };
            let episode = run(&World::random2(seed), &setup, |_, _, _| {}).expect("it drives");
            assert_eq!(episode.report.contacts, 0, "{name} {seed}");
        }
    }
}

/// The first 20 random moves alone leave 5.6° of error on average, all 100 leave 3.4°.
#[test]
fn all_random_moves_teach_where_the_sensors_look() {
    let errors = (300..312).map(|seed| {
        let episode = drive(scrambled("thymio2"), SonarModel::Nomad, 1, seed);
        episode.bearing_errors_deg.expect("learned")[0]
    });
    let mean = errors.sum::<f64>() / 12.0;
    assert!(mean < 4.7, "{mean}");
}

/// A sensor is turned aside, or fails, while the robot drives: it notices, drives on without it
/// and finds where it looks now.
#[test]
fn a_sensor_that_is_moved_while_driving_is_found_again() {
    let worst_deg = |seed, fault: &str| {
        let robot = scrambled("epuck2");
        let setup = Setup {
            faults: vec![fault.parse().expect("a fault")],
            ..setup(robot, SonarModel::Ideal, 700, seed)
        };
        let episode = run(&World::random(seed), &setup, |_, _, _| {}).expect("it drives");
        episode.bearing_errors_deg.expect("learned")[1]
    };
    let found = (300..308).filter(|seed| {
        (80.0..100.0).contains(&worst_deg(*seed, "turned:0:90@500"))
            && worst_deg(*seed, "dead:0@500") < 15.0
    });
    let found = found.count();
    assert!(found >= 7, "{found} of 8");
}

/// The sensors of a P3-DX read from three quarters to five quarters of what they should.
fn unequal(robot: AnyRobot, sonar: SonarModel, steps: u32, seed: u64) -> Setup {
    let factors = [
        0.826, 0.906, 0.994, 0.988, 0.868, 1.122, 1.111, 1.246, 0.853, 1.151, 0.836, 1.251, 0.843,
        0.744, 0.846, 1.023,
    ];
    let faults = factors.into_iter().enumerate().map(|(sensor, factor)| {
        let fault = format!("scaled:{sensor}:{factor}");
        fault.parse().expect("a fault")
    });
    Setup {
        faults: faults.collect(),
        ..setup(robot, sonar, steps, seed)
    }
}

/// Believed, they let the robot touch something more than three hundred times in these rooms.
#[test]
fn unequal_sensors_are_corrected_while_the_robot_drives() {
    let contacts = (572..575).map(|seed| {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Nomad, false).expect("it fits");
        let setup = unequal(robot, SonarModel::Ideal, 400, seed);
        let episode = run(&World::random(seed), &setup, |_, _, _| {}).expect("it drives");
        episode.report.contacts
    });
    assert_eq!(contacts.sum::<u32>(), 0);
}

/// Compared as they read they leave 1.6° of error on average.
#[test]
fn unequal_sensors_are_told_apart_while_the_robot_learns_where_they_look() {
    let errors = (300..308).map(|seed| {
        let setup = unequal(scrambled("p3dx"), SonarModel::Nomad, 1, seed);
        let episode = run(&World::random(seed), &setup, |_, _, _| {}).expect("it drives");
        episode.bearing_errors_deg.expect("learned")[0]
    });
    let mean = errors.sum::<f64>() / 8.0;
    assert!(mean < 1.4, "{mean}");
}

/// Told that it is less than half as large as it is, with a guard that believes it. Without
/// learning there are forty contacts.
#[test]
fn a_body_learns_from_contacts_how_large_it_is() {
    let contacts = (300..303).map(|seed| {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Nomad, true).expect("it fits");
        let setup = Setup {
            explore_moves: 400,
            ..setup(robot.with_told_radius(0.4), SonarModel::Nomad, 1, seed)
        };
        let episode = run(&World::random2(seed), &setup, |_, _, _| {}).expect("it drives");
        episode.report.explore_contacts
    });
    let contacts = contacts.sum::<u32>();
    assert!((3..20).contains(&contacts), "{contacts}");
}

#[test]
fn a_robot_led_by_its_places_comes_home() {
    for (seed, tour) in [(3, 200), (4, 200)] {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Nomad, false).expect("it fits");
        let setup = Setup {
            behavior: Behavior::Home {
                tour: Tour::of(tour),
            },
            ..setup(robot, SonarModel::Ideal, 200, seed)
        };
        let world = World::random2(seed);
        let report = run(&world, &setup, |_, _, _| {}).expect("it drives").report;
        assert_eq!((report.success, report.contacts), (1.0, 0), "{seed}");
        // It stops there.
        assert!(report.steps < 200 && report.goal_steps == 1, "{report:?}");
    }
}

/// Without the tour it finds none of these nests.
#[test]
fn a_robot_that_knows_the_world_finds_out_where_it_was_set_down() {
    for seed in [1, 8, 13] {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Nomad, false).expect("it fits");
        let setup = Setup {
            behavior: Behavior::Nest {
                tour: Tour::of(300),
                is_turned: false,
            },
            ..setup(robot, SonarModel::Ideal, 400, seed)
        };
        let world = World::random2(seed);
        let report = run(&world, &setup, |_, _, _| {}).expect("it drives").report;
        assert_eq!((report.success, report.contacts), (1.0, 0), "{seed}");
        assert!(report.distance_m < 12.0, "{seed}: {} m", report.distance_m);
    }
}

/// If it takes its heading to be the one of before it drives for more than 30 m.
#[test]
fn a_robot_that_was_turned_as_well_finds_out_which_way_it_faces() {
    for (seed, sonar) in [
        (200, SonarModel::Ideal),
        (203, SonarModel::Ideal),
        (207, SonarModel::Nomad),
    ] {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Own, false).expect("it fits");
        let setup = Setup {
            behavior: Behavior::Nest {
                tour: Tour::of(300),
                is_turned: true,
            },
            ..setup(robot, sonar, 600, seed)
        };
        let episode = run(&World::random(seed), &setup, |_, _, _| {}).expect("it drives");
        let report = episode.report;
        assert_eq!((report.success, report.contacts), (1.0, 0), "{seed}");
        assert!(report.distance_m < 25.0, "{seed}: {} m", report.distance_m);
    }
}

/// A robot of this model drives around for 500 steps, and home.
fn home(name: &str, ranges: Ranges, has_guard: bool, sonar: SonarModel, world: &World) -> Episode {
    let model = RobotModel::builtin(name).expect("built in");
    let robot = AnyRobot::new(model, ranges, has_guard).expect("it fits");
    let setup = Setup {
        behavior: Behavior::Home {
            tour: Tour::of(500),
        },
        ..setup(robot, sonar, 1_000, 1)
    };
    let episode = run(world, &setup, |_, _, _| {}).expect("it drives");
    assert_eq!(episode.report.success, 1.0, "{}", world.name());
    episode
}

#[test]
fn a_robot_that_only_avoids_obstacles_on_its_tour_finds_fewer_places() {
    let found = [TourBy::Frontier, TourBy::Avoid].map(|by| {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Nomad, false).expect("it fits");
        let tour = Tour { steps: 200, by };
        let setup = Setup {
            behavior: Behavior::Home { tour },
            ..setup(robot.clone(), SonarModel::Ideal, 1, 3)
        };
        let mut controller = TurretController::new(setup.config.clone(), &robot);
        run_with(&World::random2(3), &setup, &mut controller, |_, _, _| {}).expect("it drives");
        controller.turret().places().positions().len()
    });
    assert!(found[0] > found[1] + 20, "{found:?}");
}

/// Its places are as far from everything as its guard wants it to be.
#[test]
fn a_robot_with_a_guard_is_led_where_the_guard_lets_it_go() {
    let rooms = [227, 229].into_iter();
    let steps = rooms.map(|room| {
        let episode = home(
            "p3dx",
            Ranges::Nomad,
            true,
            SonarModel::Ideal,
            &World::random(room),
        );
        episode.report.steps
    });
    let steps = steps.sum::<u32>();
    assert!(steps < 100, "{steps}");
}

/// By odometry alone it comes home in none of these rooms.
#[test]
fn a_robot_whose_wheels_slip_perceives_where_it_is() {
    for room in [208, 211, 234, 240] {
        home(
            "nomad200",
            Ranges::Own,
            true,
            SonarModel::Nomad,
            &World::random(room),
        );
    }
}

/// By the odometry's heading it comes home in none of these worlds.
#[test]
fn a_robot_whose_heading_drifts_perceives_which_way_it_faces() {
    for seed in [201, 206, 245] {
        home(
            "p3dx",
            Ranges::Own,
            false,
            SonarModel::Nomad,
            &World::random2(seed),
        );
    }
}

/// By the goal alone it finds none of these four.
#[test]
fn a_robot_with_noisy_sonars_finds_its_nest_and_stays_there() {
    for seed in [303, 304, 306, 310] {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Nomad, true).expect("it fits");
        let setup = Setup {
            behavior: Behavior::NEST,
            seed: 1,
            ..setup(robot, SonarModel::Nomad, 1_000, seed)
        };
        let episode = run(&World::random(seed), &setup, |_, _, _| {}).expect("it drives");
        let report = episode.report;
        assert_eq!((report.success, report.contacts), (1.0, 0), "{seed}");
        assert!(report.goal_steps > 100, "{seed}: {}", report.goal_steps);
    }
}

#[test]
fn a_second_robot_drives_around_in_the_room() {
    let places = |second_robot| {
        let robot = scrambled("p3dx");
        let setup = Setup {
            second_robot,
            record: true,
            ..setup(robot, SonarModel::Ideal, 40, 300)
        };
        let episode = run(&World::random(300), &setup, |_, _, _| {}).expect("it drives");
        let steps = episode.recording.expect("recorded").seeking;
        let mut places: Vec<_> = steps.iter().filter_map(|step| step.leader).collect();
        places.dedup();
        places.len()
    };
    assert_eq!(places(false), 0);
    assert!(places(true) > 20);
}

/// It happened once in 192 drives of the first four robots, rooms 300 to 323.
#[test]
fn a_sensor_in_order_is_hardly_ever_taken_for_a_moved_one() {
    let mut mistaken = Vec::new();
    let robots = ["p3dx", "p3at", "epuck2", "thymio2", "khepera", "turtlebot3"];
    for (name, ranges) in robots
        .into_iter()
        .flat_map(|name| [(name, Ranges::Own), (name, Ranges::Nomad)])
    {
        let model = RobotModel::builtin(name).expect("built in");
        let robot = AnyRobot::new(model, ranges, false).expect("it fits");
        for seed in 300..304 {
            let setup = setup(robot.clone(), SonarModel::Nomad, 500, seed);
            let mut controller = TurretController::new(setup.config.clone(), &robot);
            let world = World::random(seed);
            run_with(&world, &setup, &mut controller, |_, _, _| {}).expect("it drives");
            let unused = controller.known_body().enabled.complement();
            if unused.and(robot.body().enabled) != Mask::NONE {
                mistaken.push(format!("{} in room {seed}", robot.label()));
            }
        }
    }
    assert!(mistaken.len() <= 1, "of 48 drives: {mistaken:?}");
}

/// At its first decision a P3-DX has not seen four of sixteen sectors: the nest is what it saw.
#[test]
fn a_body_comes_back_to_its_nest_by_what_it_saw_there() {
    let reached = nests_found(Origin::Known);
    assert!(reached >= 6, "{reached} of 8");
}

/// It begins to learn maps elsewhere than where it began to look for its sensors.
#[test]
fn a_body_that_finds_its_sensors_comes_back_to_where_it_had_found_them() {
    let reached = nests_found(Origin::Learned);
    assert!(reached >= 6, "{reached} of 8");
}

fn nests_found(geometry: Origin) -> usize {
    let reached = (300..308).filter(|&seed| {
        let model = RobotModel::builtin("p3dx").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Nomad, true).expect("it fits");
        let robot = robot.with_geometry(geometry).expect("it turns");
        let setup = Setup {
            behavior: Behavior::NEST,
            ..setup(robot, SonarModel::Ideal, 300, seed)
        };
        let world = rooms::small(seed);
        let episode = run(&world, &setup, |_, _, _| {}).expect("it drives");
        episode.report.success > 0.0
    });
    reached.count()
}

/// The base is turned, mirrored and scaled. Who learns that drives cleanly, who believes it
/// does not.
#[test]
fn what_the_commands_do_is_learned_from_random_moves() {
    let contacts = |actuators| -> u32 {
        let reports = (300..304).map(|seed| {
            let robot = scrambled("epuck2").miswired(Miswiring {
                front_rad: 2.0,
                is_mirrored: true,
                length: 1.3,
                turn: 0.85,
            });
            let robot = robot.with_actuators(actuators).expect("a learned geometry");
            drive(robot, SonarModel::Ideal, 300, seed).report.contacts
        });
        reports.sum()
    };
    assert_eq!(contacts(Origin::Learned), 0);
    assert!(contacts(Origin::Known) > 10);
}

/// Stands, and may look for a position.
struct Stands(bool);

impl Policy for Stands {
    fn decide(&mut self, _: &Perception) -> Point {
        Point::default()
    }

    fn looks_for_position(&self) -> bool {
        self.0
    }
}

/// It stands where it heard what its first sonar now hears no more.
#[test]
fn silence_counts_for_a_rule_that_looks_for_a_position() {
    for looks in [false, true] {
        let model = RobotModel::builtin("nomad200").expect("built in");
        let robot = AnyRobot::new(model, Ranges::Own, true).expect("it fits");
        let config = robot.config(Config::recommended());
        let mut pilot = TurretPolicy::new(config, &robot, Stands(looks));
        let hear = |pilot: &mut TurretPolicy<Stands>, range: Option<u16>| {
            let (sensor, range) = (0, range.map(Range::from_mm));
            let _ = pilot.handle(Millis::from_ms(1), Event::Echo { sensor, range });
            pilot.turret.memory().len()
        };
        let heard = hear(&mut pilot, Some(2_000));
        assert_eq!(heard, 1);
        assert_eq!(hear(&mut pilot, None) < heard, looks);
    }
}
