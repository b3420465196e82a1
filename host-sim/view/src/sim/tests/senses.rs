//! What can be perceived beside ranges.

use super::places::{assert_driven_as_in_an_episode, part, places, saved, seeks, start};
use super::*;
use serde_json::Value;

fn simulator(sonar: SonarModel, name: &str, steps: u32) -> Simulator {
    let mut simulator = Simulator::new(
        start(sonar, behavior(name, steps)),
        ControllerPlace::Host,
        None,
    )
    .unwrap();
    educate(&mut simulator);
    simulator
}

fn behavior(name: &str, steps: u32) -> Behavior {
    match name.parse().unwrap() {
        Behavior::Sense { goal, .. } => Behavior::Sense {
            goal,
            tour: Tour::of(steps),
        },
        other => other,
    }
}

#[test]
fn what_is_sought_on_the_page_is_found_as_in_an_episode() {
    for (sonar, name, tour) in [
        (SonarModel::Ideal, "scent:strongest", 100),
        (SonarModel::Nomad, "light:strongest", 100),
        // Long enough that nothing is left where it has not been.
        (SonarModel::Ideal, "floor:red", 800),
    ] {
        assert_driven_as_in_an_episode(sonar, &behavior(name, tour));
    }
}

#[test]
fn a_source_is_shown_moved_and_remembered() {
    let mut simulator = simulator(SonarModel::Ideal, "scent:strongest", 300);
    let source = |simulator: &mut Simulator| {
        let text = part(simulator, "scene").text();
        let scene = serde_json::from_str::<Value>(&text).unwrap()["value"].take();
        scene["sources"].clone()
    };
    let first = source(&mut simulator);
    assert_eq!(
        (first.as_array().unwrap().len(), &first[0]["kind"]),
        (1, &"scent".into())
    );
    let here = simulator.body.pose().position;
    let to_here = PageCommand::MoveSource {
        source: 0,
        x: here.x + 0.1,
        y: here.y,
    };
    simulator.execute(&to_here).unwrap();
    assert_ne!(source(&mut simulator)[0]["at"], first[0]["at"]);
    let sensed = simulator.snapshot().now.sensed.unwrap();
    assert!(
        (sensed.scent.0 - libm::exp(-0.05)).abs() < 0.01,
        "{sensed:?}"
    );
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 60);
    let remembered = places(&mut simulator)["sensed"].take();
    assert!(remembered.as_array().unwrap().len() > 10, "{remembered}");
    let second = PageCommand::MoveSource {
        source: 1,
        x: 0.0,
        y: 0.0,
    };
    let CommandRefused(why) = simulator.execute(&second).unwrap_err();
    assert_eq!(why, "there is no source 1");
    // Another goal has other memories, and its own source.
    let red = PageCommand::Behavior {
        name: "floor:red".to_owned(),
        tour: Some(0),
    };
    simulator.execute(&red).unwrap();
    let kinds = source(&mut simulator);
    assert_eq!([&kinds[0]["kind"], &kinds[1]["kind"]], ["floor", "scent"]);
}

fn remembered(simulator: &mut Simulator) -> Vec<Value> {
    let sensed = places(simulator)["sensed"].take();
    sensed.as_array().unwrap().clone()
}

/// Another robot reads what it perceived, and goes there as soon as it knows where it is.
#[test]
fn what_was_perceived_is_saved_and_leads_another_robot() {
    let mut first = simulator(SonarModel::Nomad, "scent:strongest", 300);
    first.execute(&PageCommand::Seek).unwrap();
    decide(&mut first, 301);
    let known = remembered(&mut first);
    assert!(known.len() > 50, "{}", known.len());
    let hex = saved(&mut first);
    let source = first.body.world().sources().scents[0].position;

    let mut second = simulator(SonarModel::Nomad, "scent:strongest", 0);
    second.execute(&PageCommand::LoadMind { hex }).unwrap();
    assert_eq!(saved(&mut second).len(), saved(&mut first).len());
    second.execute(&PageCommand::Seek).unwrap();
    while seeks(&second) {
        decide(&mut second, 1);
    }
    assert!(remembered(&mut second).len() >= known.len());
    let place = second.body.pose().position;
    assert!(place.distance(source) < 0.6, "{place:?} {source:?}");
}

/// Where it has too few places to find out where it is, nothing says where it perceived what.
#[test]
fn a_robot_that_begins_anew_forgets_what_it_perceived() {
    let mut simulator = simulator(SonarModel::Ideal, "scent:strongest", 0);
    simulator.execute(&PageCommand::Seek).unwrap();
    decide(&mut simulator, 10);
    let known = remembered(&mut simulator).len();
    assert!(known > 3, "{known}");
    let Point { x, y } = simulator.body.pose().position;
    let aside = PageCommand::MoveRobot { x: x + 0.3, y };
    simulator.execute(&aside).unwrap();
    decide(&mut simulator, 1);
    let left = remembered(&mut simulator).len();
    assert!(left <= 2, "{left} of {known}");
}
