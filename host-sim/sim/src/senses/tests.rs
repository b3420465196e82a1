use super::*;
use crate::behavior::Behavior;
use crate::episode::{EpisodeReport, Setup, run};
use crate::robot::{AnyRobot, Ranges};
use amp::config::Config;
use arena::robot::TurretMode;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::World;

fn behavior(name: &str, tour: u32) -> Behavior {
    match name.parse().expect("a behavior") {
        Behavior::Sense { goal, .. } => Behavior::Sense { goal, tour },
        other => other,
    }
}

/// What a P3-DX reports that drives around and then seeks.
fn sought(world: &World, name: &str, tour: u32, sonar: SonarModel) -> EpisodeReport {
    let model = RobotModel::builtin("p3dx").expect("built in");
    let robot = AnyRobot::new(model, Ranges::Nomad, false).expect("it fits");
    let setup = Setup {
        config: robot.config(Config::recommended()),
        preset: "default".to_owned(),
        behavior: behavior(name, tour),
        explore_moves: 100,
        steps: 800,
        seed: 1,
        sonar,
        faults: Vec::new(),
        second_robot: false,
        turret: TurretMode::Held,
        robot: Some(robot),
        set_down: None,
        record: false,
    };
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

/// By the end of the tour alone the robot is at none of these sources.
#[test]
fn a_robot_goes_to_what_it_has_come_upon() {
    for (name, sonar) in [
        ("scent:strongest", SonarModel::Ideal),
        ("scent:strongest", SonarModel::Nomad),
        ("light:strongest", SonarModel::Nomad),
        ("floor:red", SonarModel::Ideal),
    ] {
        for seed in [13, 22] {
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
