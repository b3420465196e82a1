//! Robots that a memory of places leads.

use super::*;
use crate::snapshot::{PartMessage, Rounded};
use arena::robot_model::RobotModel;
use serde_json::Value;
use sim::robot::{AnyRobot, Ranges};

pub(super) fn start(sonar: SonarModel, behavior: Behavior) -> SimulatorStart {
    let model = RobotModel::builtin("p3dx").unwrap();
    let robot = AnyRobot::new(model, Ranges::Nomad, false).unwrap();
    let plain = super::start(sonar);
    let config = robot.config(plain.whole);
    SimulatorStart {
        world: World::builtin("office").unwrap(),
        named: "office".to_owned(),
        setup: Setup {
            config: config.clone(),
            behavior,
            explore_moves: 100,
            steps: 300,
            robot: Some(robot),
            ..plain.setup
        },
        whole: config,
        presets: Vec::new(),
    }
}

fn simulator(sonar: SonarModel, tour: u32) -> Simulator {
    let start = start(
        sonar,
        Behavior::Home {
            tour: Tour::of(tour),
        },
    );
    Simulator::new(start, ControllerPlace::Host, None).unwrap()
}

/// Whether it still seeks, within a time that is long enough for all of these.
pub(super) fn seeks(simulator: &Simulator) -> bool {
    simulator.activity == SimulatorActivity::Seek && simulator.seeking.steps < 1_000
}

/// A part of a snapshot.
pub(super) fn part(simulator: &mut Simulator, name: &str) -> Arc<dyn PartMessage> {
    let parts = simulator.snapshot().into_parts();
    let mut found = parts.into_iter().filter(|part| part.key().0 == name);
    found.next().unwrap()
}

pub(super) fn places(simulator: &mut Simulator) -> Value {
    let text = part(simulator, "places").text();
    serde_json::from_str::<Value>(&text).unwrap()["value"].take()
}

fn count(places: &Value, what: &str) -> usize {
    places[what].as_array().unwrap().len()
}

/// The mind as it is saved.
pub(super) fn saved(simulator: &mut Simulator) -> String {
    match simulator.execute(&PageCommand::SaveMind).unwrap() {
        CommandOutcome::File(file) => file.hex.unwrap(),
        _ => panic!("no file"),
    }
}

/// Another robot reads its mind, and finds out where it is.
#[test]
fn places_are_saved_with_the_mind_and_lead_another_robot_home() {
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        let mut first = simulator(sonar, 300);
        educate(&mut first);
        first.execute(&PageCommand::Seek).unwrap();
        decide(&mut first, 301);
        let known = count(&places(&mut first), "places");
        let hex = saved(&mut first);
        let mut second = simulator(sonar, 0);
        let load = PageCommand::LoadMind { hex };
        second.execute(&load).unwrap();
        assert_eq!(saved(&mut second).len(), saved(&mut first).len());
        second.execute(&PageCommand::Seek).unwrap();
        decide(&mut second, 1);
        assert!(count(&places(&mut second), "places") >= known);
        while seeks(&second) {
            decide(&mut second, 1);
        }
        assert_eq!(
            second.snapshot().now.note.as_deref(),
            Some("home is reached")
        );
        let off_m = error_m(&mut second);
        assert!(off_m < 0.3, "{off_m} m");
    }
}

/// Stopped before it hears anything, it is drawn where it was all the same.
#[test]
fn a_recording_draws_loaded_places_as_the_page_did() {
    let mut first = simulator(SonarModel::Ideal, 200);
    educate(&mut first);
    first.execute(&PageCommand::Seek).unwrap();
    decide(&mut first, 201);
    let hex = saved(&mut first);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("loaded.mcap");
    let start = start(SonarModel::Ideal, Behavior::Home { tour: Tour::of(0) });
    let mut second = Simulator::new(start, ControllerPlace::Host, Some(&path)).unwrap();
    second.execute(&PageCommand::LoadMind { hex }).unwrap();
    second.execute(&PageCommand::Stop).unwrap();
    second.execute(&PageCommand::Seek).unwrap();
    decide(&mut second, 12);
    let drawn = places(&mut second);
    drop(second);
    let log = remote::log::read(&path).unwrap();
    let mut recorded = crate::WatchedLog::new(&log).unwrap();
    while recorded.step() != StepOutcome::Idle {}
    let parts = recorded.snapshot().into_parts();
    let part = parts.iter().find(|part| part.key().0 == "places").unwrap();
    let replayed: Value = serde_json::from_str(&part.text()).unwrap();
    let first_of = |value: &Value| value["places"][0].clone();
    assert!(count(&drawn, "places") > 40);
    assert_eq!(first_of(&replayed["value"]), first_of(&drawn));
}

#[test]
fn a_mind_of_another_robot_is_refused() {
    let mut with_points = simulator(SonarModel::Ideal, 0);
    educate(&mut with_points);
    let mut ring =
        Simulator::new(super::start(SonarModel::Ideal), ControllerPlace::Host, None).unwrap();
    educate(&mut ring);
    let mut guarded = start(SonarModel::Ideal, Behavior::Avoid);
    let robot = guarded.setup.robot.take().unwrap();
    guarded.setup.robot = Some(robot.with_guard(true));
    let refused = |loads: &mut Simulator, hex: String| {
        let load = PageCommand::LoadMind { hex };
        loads.execute(&load).map(|_| ()).unwrap_err().0
    };
    let hex = saved(&mut ring);
    let why = refused(&mut with_points, hex);
    assert_eq!(why, "it is of the Nomad's own ring");
    let hex = saved(&mut with_points);
    let why = refused(&mut ring, hex.clone());
    assert_eq!(why, "it is of a robot behind points (--robot, --places)");
    let mut guarded = Simulator::new(guarded, ControllerPlace::Host, None).unwrap();
    let why = refused(&mut guarded, hex);
    assert_eq!(
        why,
        "it is of another robot, or its guard (--shield) was another one"
    );
    assert!(guarded.execute(&PageCommand::Explore).is_ok(), "it goes on");
}

/// How far from where it is the robot thinks that it is, m.
fn error_m(simulator: &mut Simulator) -> f64 {
    let now = simulator.snapshot().now;
    let [x, y, _] = now.thinks.unwrap().map(|value| value.0);
    Point::new(x, y).distance(Point::new(now.pose[0].0, now.pose[1].0))
}

/// A robot that the page drives goes exactly as in an episode: a tour, and a way somewhere.
pub(super) fn assert_driven_as_in_an_episode(sonar: SonarModel, behavior: &Behavior) {
    let setup = Setup {
        record: true,
        ..start(sonar, behavior.clone()).setup
    };
    let run = episode::run(&World::builtin("office").unwrap(), &setup, |_, _, _| {}).unwrap();
    assert_eq!(run.report.goal_steps, 1, "it ends");
    let recorded = run.recording.unwrap().seeking;
    let start = start(sonar, behavior.clone());
    let mut simulator = Simulator::new(start, ControllerPlace::Host, None).unwrap();
    educate(&mut simulator);
    simulator.execute(&PageCommand::Seek).unwrap();
    let mut driven = Vec::new();
    while seeks(&simulator) {
        driven.extend(decide(&mut simulator, 1));
        let _ = simulator.snapshot().into_parts();
    }
    let wanted: Vec<_> = recorded.iter().map(|step| step.pose.position).collect();
    // After the tour, and the decision with which it ends. One more tells that it is there.
    let tour = behavior.tour().unwrap().steps as usize;
    let name = behavior.name();
    assert_eq!(driven.len(), tour + 2 + wanted.len(), "{name}");
    assert_eq!(driven[tour + 1..][..wanted.len()], wanted, "{name}");
    let now = simulator.snapshot().now;
    assert_eq!(now.note, Some(format!("{name} is reached")));
}

#[test]
fn home_on_the_page_is_home_in_an_episode() {
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        assert_driven_as_in_an_episode(
            sonar,
            &Behavior::Home {
                tour: Tour::of(150),
            },
        );
    }
}

#[test]
fn places_are_sent_where_the_robot_was_and_once() {
    let mut simulator = simulator(SonarModel::Ideal, 40);
    assert_eq!(count(&places(&mut simulator), "places"), 0);
    assert_eq!(simulator.snapshot().now.thinks, None);
    educate(&mut simulator);
    simulator.execute(&PageCommand::Seek).unwrap();
    let driven = decide(&mut simulator, 40);
    let known = places(&mut simulator);
    assert!(count(&known, "places") > 10, "{known}");
    assert!(count(&known, "links") > 10 && count(&known, "frontiers") > 3);
    let to_point = |place: &Value| {
        let [x, y] = [0, 1].map(|axis| place[axis].as_f64().unwrap());
        Point::new(x, y)
    };
    // The last one was found on the tour.
    let last = to_point(known["places"].as_array().unwrap().last().unwrap());
    let nearest = driven.iter().map(|place| place.distance(last));
    assert!(nearest.fold(f64::INFINITY, f64::min) < 0.05, "{last:?}");
    assert!(error_m(&mut simulator) < 0.05);
    let heading = |pose: [Rounded; 3]| pose[2].0;
    let now = simulator.snapshot().now;
    let off = libm::sin(heading(now.thinks.unwrap()) - heading(now.pose));
    assert!(off.abs() < 0.01, "{off}");
    // Another snapshot of the same places is not sent again.
    let parts = [0, 1].map(|_| part(&mut simulator, "places").revision());
    assert_eq!(parts[0], parts[1]);
    decide(&mut simulator, 10);
    assert!(part(&mut simulator, "places").revision() > parts[1]);
}

/// Its wheels slip: what it remembers lies where it thinks that it was.
#[test]
fn a_robot_is_shown_where_it_thinks_that_it_is() {
    let mut simulator = simulator(SonarModel::Nomad, 1_000);
    educate(&mut simulator);
    simulator.execute(&PageCommand::Seek).unwrap();
    let off = (0..100).map(|_| {
        decide(&mut simulator, 1);
        error_m(&mut simulator)
    });
    let most = off.fold(0.0, f64::max);
    assert!((0.03..0.5).contains(&most), "{most} m");
}

/// It drives around, and then its places lead it back over sub-goals.
#[test]
fn the_way_home_leads_over_sub_goals_to_the_start() {
    let mut simulator = simulator(SonarModel::Ideal, 150);
    educate(&mut simulator);
    assert_eq!(simulator.snapshot().now.goal.tour, Some([0, 150]));
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 20);
    let now = simulator.snapshot().now;
    assert!(now.way.is_some());
    assert!(now.goal.tour < Some([30, 150]), "{:?}", now.goal.tour);
    let mut longest = 0;
    while seeks(&simulator) {
        decide(&mut simulator, 1);
        let now = simulator.snapshot().now;
        if now.goal.tour == Some([150, 150])
            && let Some(way) = now.way
        {
            longest = longest.max(way.len());
            let home = now.goal.place.unwrap();
            let end = way.last().unwrap();
            let off = (0..2).map(|axis| (home[axis].0 - end[axis].0).abs());
            assert!(off.fold(0.0, f64::max) < 0.01, "{home:?} {end:?}");
        }
    }
    assert!(longest > 2, "{longest}");
    // It stands: nothing leads it.
    assert_eq!(simulator.snapshot().now.way, None);
}

#[test]
fn a_robot_goes_to_a_position_and_stops_there() {
    let mut simulator = simulator(SonarModel::Ideal, 0);
    educate(&mut simulator);
    let to = simulator.body.pose().position;
    // Somewhere else it is told to come here.
    simulator.execute(&PageCommand::Seek).unwrap();
    while seeks(&simulator) {
        decide(&mut simulator, 1);
    }
    let far = simulator.body.pose().position.distance(to);
    assert!(far > 0.5, "{far}");
    let wall = PageCommand::GoalPosition { x: 99.0, y: 0.0 };
    assert!(simulator.execute(&wall).is_err());
    let there = PageCommand::GoalPosition { x: to.x, y: to.y };
    simulator.execute(&there).unwrap();
    assert!(simulator.execute(&PageCommand::SaveGoal).is_err());
    simulator.execute(&PageCommand::Seek).unwrap();
    while seeks(&simulator) {
        decide(&mut simulator, 1);
    }
    let off = simulator.body.pose().position.distance(to);
    assert!(off < 0.1, "{off} m away");
    let now = simulator.snapshot().now;
    assert_eq!(now.note.as_deref(), Some("a place is reached"));
}

/// Its places of before stay where they are, those that it finds are drawn where it is.
#[test]
fn a_robot_that_knows_enough_finds_out_where_it_was_set_down() {
    let mut simulator = simulator(SonarModel::Ideal, 150);
    educate(&mut simulator);
    simulator.execute(&PageCommand::Seek).unwrap();
    while simulator.snapshot().now.goal.tour != Some([150, 150]) {
        decide(&mut simulator, 1);
    }
    let (home, known) = (simulator.home(), places(&mut simulator));
    let found = count(&known, "places");
    assert!(found >= 32, "{found}");
    assert_eq!(count(&known, "guesses"), 0);
    let on_floor =
        |place: &Value| Point::new(place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
    let all = Vec::from_iter(known["places"].as_array().unwrap().iter().map(on_floor));
    let start = simulator.body.pose().position;
    let farthest =
        |one: &&Point, other: &&Point| start.distance(**one).total_cmp(&start.distance(**other));
    let Point { x, y } = *all.iter().max_by(farthest).unwrap();
    assert!(start.distance(Point::new(x, y)) > 1.0);
    simulator.execute(&PageCommand::MoveRobot { x, y }).unwrap();
    decide(&mut simulator, 2);
    assert!(error_m(&mut simulator) < 0.05);
    let now = places(&mut simulator);
    assert_eq!(
        now["places"].as_array().unwrap()[..found],
        known["places"].as_array().unwrap()[..found]
    );
    assert!(count(&now, "places") > found);
    let newest = on_floor(&now["places"][found]);
    assert!(newest.distance(Point::new(x, y)) < 0.3, "{newest:?}");
    let (mut strongest, mut guesses) = (0.0, 0);
    while seeks(&simulator) {
        let here = decide(&mut simulator, 1)[0];
        let now = places(&mut simulator);
        guesses = guesses.max(count(&now, "guesses"));
        for guess in now["guesses"].as_array().unwrap() {
            let strength = guess[1].as_f64().unwrap();
            strongest = f64::max(strongest, strength);
            // It is at a place that it knew; what is nearly believed is where it is.
            let guessed = on_floor(&guess[0]);
            let off = |place: &Point| place.distance(guessed);
            assert!(all.iter().any(|place| off(place) < 1.0), "{guess}");
            assert!(strength < 0.9 || off(&here) < 0.3, "{guess} {here:?}");
        }
    }
    assert!(guesses > 1 && strongest > 0.9, "{guesses} {strongest}");
    let place = simulator.body.pose().position;
    assert!(place.distance(home) < 0.3, "{place:?} {home:?}");
}

/// Without a compass it finds out its heading; what it finds meanwhile is drawn where it is.
#[test]
fn what_a_robot_that_was_turned_finds_is_drawn_around_it() {
    let tour = Tour::of(150);
    let mut start = start(SonarModel::Ideal, Behavior::Home { tour });
    let model = RobotModel::builtin("p3dx").unwrap();
    start.setup.robot = Some(AnyRobot::new(model, Ranges::Own, false).unwrap());
    let mut simulator = Simulator::new(start, ControllerPlace::Host, None).unwrap();
    educate(&mut simulator);
    simulator.execute(&PageCommand::Seek).unwrap();
    while simulator.snapshot().now.goal.tour != Some([150, 150]) {
        decide(&mut simulator, 1);
    }
    let known = count(&places(&mut simulator), "places");
    let Point { x, y } = simulator.start.world.start().position;
    simulator.execute(&PageCommand::MoveRobot { x, y }).unwrap();
    simulator.body.turn_anywhere();
    let mut drawn = 0;
    while seeks(&simulator) && drawn < 20 {
        let here = decide(&mut simulator, 1)[0];
        let now = places(&mut simulator);
        let turret = simulator.controller.inner().led_turret().unwrap();
        if turret.places().aside().is_none() || count(&now, "places") == known {
            continue;
        }
        let newest = &now["places"][count(&now, "places") - 1];
        let newest = Point::new(newest[0].as_f64().unwrap(), newest[1].as_f64().unwrap());
        assert!(newest.distance(here) < 1.0, "{newest:?} {here:?}");
        drawn += 1;
    }
    assert!(drawn > 5, "{drawn}");
}

#[test]
fn a_robot_that_was_carried_begins_anew_where_it_was_set_down() {
    let mut simulator = simulator(SonarModel::Ideal, 0);
    educate(&mut simulator);
    let here = simulator.body.pose().position;
    let home = simulator.frames;
    let (x, y) = (here.x + 0.2, here.y);
    simulator.execute(&PageCommand::MoveRobot { x, y }).unwrap();
    // What it remembers lies elsewhere than it thinks.
    assert_eq!(count(&places(&mut simulator), "places"), 0);
    assert_eq!(simulator.snapshot().now.thinks, None);
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 2);
    assert!(error_m(&mut simulator) < 0.05);
    assert!((1..4).contains(&count(&places(&mut simulator), "places")));
    // It does not take where it was set down for home: it looks for the situation.
    while seeks(&simulator) {
        decide(&mut simulator, 1);
    }
    let place = simulator.body.pose().position;
    assert!(place.distance(Point::new(x, y)) > 0.3, "{place:?} {home:?}");
}

#[test]
fn a_robot_without_places_is_not_sent_home() {
    let mut simulator = super::simulator(SonarModel::Ideal);
    assert!(!simulator.abilities().places);
    for command in [
        PageCommand::Behavior {
            name: "avoid,home".to_owned(),
            tour: None,
        },
        PageCommand::GoalPosition { x: 0.0, y: 0.0 },
    ] {
        let refused = simulator.execute(&command).unwrap_err();
        assert!(refused.0.contains("memory of places"), "{}", refused.0);
    }
    let parts = simulator.snapshot().into_parts();
    assert!(parts.iter().all(|part| part.key().0 != "places"));
    let mut scene = part(&mut simulator, "scene").text().to_string();
    assert!(!scene.contains("\"home\""), "{scene}");
    scene = part(&mut self::simulator(SonarModel::Ideal, 0), "scene")
        .text()
        .to_string();
    assert!(scene.contains("\"home\""), "{scene}");
}
