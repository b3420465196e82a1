use super::*;
use crate::behavior::{Behavior, Tour};
use crate::episode::{Body, EpisodeReport, Setup, run, run_with};
use crate::robot::{AnyRobot, Ranges};
use crate::turret_pilot::TurretController;
use amp::config::Config;
use arena::robot::TurretMode;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::sources::{Scent, Sources};
use arena::world::{Point, World};

fn behavior(name: &str, tour: u32) -> Behavior {
    match name.parse().expect("a behavior") {
        Behavior::Sense { goal, .. } => Behavior::Sense {
            goal,
            tour: Tour::of(tour),
        },
        other => other,
    }
}

fn p3dx() -> AnyRobot {
    let model = RobotModel::builtin("p3dx").expect("built in");
    AnyRobot::new(model, Ranges::Nomad, false).expect("it fits")
}

fn setup(behavior: Behavior, sonar: SonarModel) -> Setup {
    let robot = p3dx();
    Setup {
        config: robot.config(Config::recommended()),
        preset: "default".to_owned(),
        behavior,
        explore_moves: 100,
        steps: 800,
        seed: 1,
        sonar,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        turret: TurretMode::Held,
        robot: Some(robot),
        set_down: None,
        record: false,
    }
}

/// What a P3-DX reports that drives around and then seeks.
fn sought(world: &World, name: &str, tour: u32, sonar: SonarModel) -> EpisodeReport {
    let setup = setup(behavior(name, tour), sonar);
    run(world, &setup, |_, _, _| {}).expect("it drives").report
}

#[test]
fn goals_have_names() {
    for name in [
        "scent:strongest",
        "light:strongest",
        "floor:red",
        "floor:black",
        "light:before",
    ] {
        let goal: SenseGoal = name.parse().expect(name);
        assert_eq!(goal.name(), name);
        assert_eq!(name.parse::<Behavior>().expect(name).name(), name);
    }
    let why = |name: &str| name.parse::<Behavior>().expect_err(name).to_string();
    assert!(
        why("floor:rde").contains("did you mean \"red\""),
        "{}",
        why("floor:rde")
    );
    assert!(why("floor:strongest").contains("strongest"));
    assert!(why("scent").contains("strongest"), "{}", why("scent"));
    assert!(
        why("light:red").contains("known: strongest, before"),
        "{}",
        why("light:red")
    );
    assert!(why("sent:strongest").contains("behavior \"sent:strongest\""));
}

#[test]
fn readings_are_shares_of_254_and_stay_in_range() {
    let sensed = Sensed {
        scent: 0.5,
        light: 1.0,
        floor: [0.0, 0.1, 0.9],
    };
    let exact = Readings::of(&sensed, || 1.0);
    assert_eq!(
        (exact.scent, exact.light, exact.floor),
        ([127], [254], [0, 25, 229])
    );
    let loud = Readings::of(&sensed, || 1.2);
    assert_eq!((loud.scent, loud.light), ([152], [254]));
}

#[test]
fn sensors_are_as_exact_as_the_sonars() {
    let scent = Scent {
        position: Point::default(),
        reach_m: 2.0,
    };
    let world = World::builtin("office")
        .expect("built in")
        .with_sources(Sources {
            scents: vec![scent],
            ..Sources::default()
        });
    let world = world.expect("a source");
    let spread = |sonar| {
        let mut body = Body::of_robot(&world, &p3dx(), sonar, 1).sensing(2);
        let exact = 254.0 * body.sensed().scent;
        let readings = (0..1_000).map(|_| f64::from(body.read().scent[0]) / exact - 1.0);
        let squares = readings.map(|off| off * off).sum::<f64>();
        (squares / 1_000.0).sqrt()
    };
    assert!(spread(SonarModel::Ideal) < 0.01);
    let noisy = spread(SonarModel::Nomad);
    assert!((0.045..0.055).contains(&noisy), "{noisy}");
}

/// Places stand 10 m aside of the others until it knows where it was set down.
#[test]
fn a_robot_that_does_not_know_where_it_is_records_nothing() {
    let world = World::random2(1);
    let scent = Scent {
        position: world.start().position,
        reach_m: 10.0,
    };
    let world = world.with_sources(Sources {
        scents: vec![scent],
        ..Sources::default()
    });
    let world = world.expect("a source");
    let setup = setup(
        Behavior::Nest {
            tour: Tour::of(300),
            is_turned: false,
        },
        SonarModel::Ideal,
    );
    let mut controller = TurretController::new(setup.config.clone(), &p3dx());
    let episode = run_with(&world, &setup, &mut controller, |_, _, _| {}).expect("it drives");
    assert_eq!(episode.report.success, 1.0);
    let records = controller.senses().remembered(SenseGoal::Scent);
    assert!(records.len() > 50, "{}", records.len());
    let start = world.start().position;
    for (position, strength) in records {
        let [x, y] = [position.dx_mm, position.dy_mm].map(|mm| f64::from(mm) / 1e3);
        let there = start + Point::new(x, y);
        let is = world.sensed(there, 0.0).scent;
        assert!(
            (is - strength).abs() < 0.1,
            "{position:?}: {strength}, {is}"
        );
    }
}

/// On a tour of as many steps for home it leaves half of the places out.
#[test]
fn a_robot_that_seeks_something_looks_everywhere_on_its_tour() {
    let world = World::builtin("room").expect("built in");
    let tour = 800;
    let places = |behavior| {
        let setup = setup(behavior, SonarModel::Ideal);
        let mut controller = TurretController::new(setup.config.clone(), &p3dx());
        let setup = Setup {
            steps: 1,
            record: true,
            ..setup
        };
        let episode = run_with(&world, &setup, &mut controller, |_, _, _| {}).expect("it drives");
        assert!(episode.recording.expect("recorded").has_toured);
        let turret = controller.led_turret().expect("places");
        turret.places().positions().len()
    };
    let everywhere = places(behavior("floor:red", tour));
    let home = places(Behavior::Home {
        tour: Tour::of(tour),
    });
    assert!(everywhere > home + 20, "{everywhere} {home}");
}

#[test]
fn all_modalities_are_forgotten() {
    let mut senses = Senses::default();
    let sensed = Sensed {
        scent: 0.5,
        light: 0.5,
        floor: [0.5; 3],
    };
    let readings = Readings::of(&sensed, || 1.0);
    senses.perceive(&readings, Displacement::ZERO, Millis::from_ms(1));
    let goals = [SenseGoal::Scent, SenseGoal::Light, SenseGoal::Floor("red")];
    let counts = |senses: &Senses| goals.map(|goal| senses.remembered(goal).len());
    assert_eq!(counts(&senses), [1; 3]);
    senses.forget();
    assert_eq!(counts(&senses), [0; 3]);
}

/// A clock that begins anew, and one that has run for long.
#[test]
fn what_is_restored_is_as_old_as_it_was() {
    let readings = |light: f64| {
        let sensed = Sensed {
            scent: 0.5,
            light,
            floor: [0.1, 0.5, 0.9],
        };
        Readings::of(&sensed, || 1.0)
    };
    let at = |dx_mm| Displacement { dx_mm, dy_mm: 0 };
    let second = |s: u32| Millis::from_ms(1_000 * s);
    let mut senses = Senses::default();
    for (light, x_mm, when) in [(0.9, 0, 100), (0.8, 1_000, 160), (0.0, 2_000, 190)] {
        senses.perceive(&readings(light), at(x_mm), second(when));
    }
    let saved = senses.saved();
    for now in [second(0), second(5_000), Millis::from_ms(u32::MAX - 9)] {
        let mut restored = Senses::default();
        restored.perceive(&readings(0.4), at(9_000), second(1));
        restored.restore(&saved, now);
        assert_eq!(restored.saved(), saved);
        for goal in [SenseGoal::Scent, SenseGoal::Light, SenseGoal::Floor("red")] {
            assert_eq!(restored.remembered(goal), senses.remembered(goal));
        }
        let last = |senses: &Senses, now: Millis| {
            let records = senses.light.records().iter();
            let ages = records.map(|record| [now.after(record.first), now.after(record.last)]);
            Vec::from_iter(ages)
        };
        assert_eq!(last(&restored, now), [[90_000; 2], [30_000; 2], [0; 2]]);
        // Before it got dark it was at the second one.
        restored.perceive(&readings(0.0), at(2_000), now);
        restored.seek(Some(SenseGoal::Before(Sense::Light)));
        assert_eq!(restored.before, Some(at(1_000)));
    }
}

/// By the end of the tour alone the robot is at none of these sources.
#[test]
fn a_robot_goes_to_what_it_has_come_upon() {
    for (name, sonar) in [
        ("scent:strongest", SonarModel::Ideal),
        ("scent:strongest", SonarModel::Nomad),
        ("light:strongest", SonarModel::Nomad),
        ("floor:red", SonarModel::Ideal),
    ] {
        for seed in [13, 23] {
            let world = World::random2(seed);
            let report = sought(&world, name, 400, sonar);
            assert_eq!(report.success, 1.0, "{name} {seed}");
            assert!(report.goal_steps == 1 && report.steps < 200, "{report:?}");
            let shortest_m = report.shortest_m.expect("a way");
            assert!(report.distance_m > shortest_m - 0.7, "{report:?}");
        }
    }
}

/// Nothing has been perceived before: it looks for it.
#[test]
fn a_robot_without_a_tour_looks_for_a_color() {
    for seed in [8, 13] {
        let report = sought(&World::random2(seed), "floor:blue", 0, SonarModel::Ideal);
        assert_eq!(report.success, 1.0, "{seed}");
        assert!(report.steps > 10, "{seed}");
    }
}

/// A lamp that goes out on the tour: time leads to a position.
#[test]
fn a_robot_goes_back_to_where_it_was_before_it_got_dark() {
    let text = |until_s: u32| {
        format!(
            "[[wall]]\npoints_m = [[-4, -3], [4, -3], [4, 3], [-4, 3], [-4, -3]]\n\
             [[box]]\ncenter_m = [1.5, 1.5]\nsize_m = [1, 1]\n\
             [[light]]\nposition_m = [-1, -1]\nuntil_s = {until_s}\n"
        )
    };
    let mut places = Vec::new();
    for until_s in [200, 250, 300] {
        let world = World::from_toml(&text(until_s), "dark").expect("a world");
        let report = sought(&world, "light:before", 150, SonarModel::Ideal);
        assert_eq!(report.success, 1.0, "{until_s}");
        places.push(report.shortest_m);
    }
    // It went dark at other places.
    assert!(
        places[0] != places[1] && places[1] != places[2],
        "{places:?}"
    );
}

/// Each part of a chain is measured by its own place.
#[test]
fn in_a_chain_the_nest_stays_where_it_was() {
    let world = World::random2(13);
    for name in ["floor:red,home", "scent:strongest,nest"] {
        let report = sought(&world, name, 0, SonarModel::Ideal);
        assert_eq!(report.success, 1.0, "{name}: {report:?}");
        assert_eq!(report.shortest_m, None);
    }
}

#[test]
fn a_world_gets_only_what_it_lacks() {
    let office = World::builtin("office").expect("built in");
    let lacking = |world: &World, name: &str| {
        let noise = arena::noise::Noise::new(1);
        let behavior = name.parse().expect("a behavior");
        crate::episode::with_missing_sources(world, &behavior, 0.269, noise).expect("a world")
    };
    assert_eq!(lacking(&office, "avoid,home"), None);
    let more = lacking(&office, "scent:strongest,floor:red,scent:before").expect("more");
    let sources = more.sources();
    assert_eq!(
        (
            sources.scents.len(),
            sources.floor.len(),
            sources.lights.len()
        ),
        (1, 1, 0)
    );
    assert_eq!(lacking(&more, "floor:red,scent:strongest"), None);
    assert!(lacking(&more, "floor:green").is_some());
    // The robot can be there.
    let place = sources.scents[0].position;
    assert!(office.clearance(place) > 0.269 && place.distance(office.start().position) >= 1.0);
}
