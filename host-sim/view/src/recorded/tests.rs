use super::*;
use crate::command::Reset;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::World;
use remote::link::Knowledge;
use remote::log::fixture::{changed, file, logged, setup};
use sim::behavior::{Behavior, Tour};
use sim::episode;
use sim::pilot::LocalController;
use sim::robot::{AnyRobot, Ranges};
use sim::sim_controller::SimController;

fn recorded(sonar: SonarModel) -> WatchedLog {
    WatchedLog::new(&file(logged(sonar))).unwrap()
}

fn to_the_end(recorded: &mut WatchedLog) {
    while recorded.step() != StepOutcome::Idle {}
}

fn known(recorded: &WatchedLog) -> Vec<u8> {
    let controller = recorded.playback.replayer.controller();
    let knowledge = Knowledge::of(controller.config(), controller.state());
    knowledge.to_bytes()
}

#[test]
fn at_its_end_the_mind_knows_what_it_knew_in_the_episode() {
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        let setup = setup(sonar);
        let mut controller = LocalController::new(setup.config.clone());
        episode::run_with(&World::random(3), &setup, &mut controller, |_, _, _| {}).unwrap();
        let knowledge = Knowledge::of(controller.config(), controller.state());
        let mut recorded = recorded(sonar);
        to_the_end(&mut recorded);
        assert_eq!(recorded.playback.difference, None);
        assert_eq!(recorded.playback.decided, recorded.timeline.decisions);
        assert_eq!(known(&recorded), knowledge.to_bytes(), "{sonar:?}");
        let now = recorded.snapshot().now;
        assert_eq!(now.note.as_deref(), Some("The recording ends here"));
        assert_eq!(now.goal.name, "avoid");
        assert_eq!(now.mode, "seek");
    }
}

#[test]
fn any_moment_is_the_same_from_either_side() {
    let mut forward = recorded(SonarModel::Nomad);
    while forward.playback.decided < 50 {
        forward.step();
    }
    let mut back = recorded(SonarModel::Nomad);
    to_the_end(&mut back);
    let last = known(&back);
    back.execute(&PageCommand::Jump { to: 50 }).unwrap();
    assert_eq!(known(&back), known(&forward));
    let texts = |recorded: &mut WatchedLog| -> Vec<_> {
        let mut now = recorded.snapshot().now;
        // Chunk numbers differ between playbacks.
        now.echo_trail = [0; 2];
        vec![serde_json::to_string(&now).unwrap()]
    };
    assert_eq!(texts(&mut back), texts(&mut forward));
    assert_ne!(known(&back), last);
    back.execute(&PageCommand::Jump { to: 9_999 }).unwrap();
    assert_eq!(back.playback.decided, back.timeline.decisions);
    back.execute(&PageCommand::Jump { to: 0 }).unwrap();
    assert_eq!(
        (back.playback.decided, back.snapshot().now.mode),
        (0, "idle")
    );
    to_the_end(&mut back);
    assert_eq!(known(&back), last);
}

/// A P3-DX that seeks a scent, and one that drives around, is carried and finds home.
fn with_places(behavior: &str) -> WatchedLog {
    let p3dx = RobotModel::builtin("p3dx").unwrap();
    let robot = AnyRobot::new(p3dx, Ranges::Nomad, true).unwrap();
    let ring = setup(SonarModel::Ideal);
    let tour = Tour::of(150);
    let behavior = match behavior.parse().unwrap() {
        Behavior::Sense { goal, .. } => Behavior::Sense { goal, tour },
        _ => Behavior::Nest {
            tour,
            is_turned: false,
        },
    };
    let setup = episode::Setup {
        config: robot.config(ring.config.clone()),
        robot: Some(robot),
        behavior,
        // It looks around for a while until it knows.
        steps: 400,
        ..ring
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let controller = SimController::new(&setup.config, setup.robot.as_ref());
    remote::log::run(&World::random(3), &setup, controller, &path).unwrap();
    let log = file(std::fs::read(path).unwrap());
    WatchedLog::new(&log).unwrap()
}

fn part(recorded: &mut WatchedLog, name: &str) -> serde_json::Value {
    let parts = recorded.snapshot().into_parts();
    let part = parts.iter().find(|part| part.key().0 == name).unwrap();
    let message: serde_json::Value = serde_json::from_str(&part.text()).unwrap();
    message["value"].clone()
}

/// Distance between where the robot is and where it thinks it is, m.
fn error_m(now: &serde_json::Value) -> f64 {
    let at = |name: &str, axis: usize| now[name][axis].as_f64().unwrap();
    let along = |axis| at("pose", axis) - at("thinks", axis);
    along(0).hypot(along(1))
}

#[test]
fn the_places_of_a_recorded_robot_are_where_it_was() {
    for behavior in ["scent:strongest", "nest"] {
        let mut recorded = with_places(behavior);
        let scene = part(&mut recorded, "scene");
        assert_eq!(scene["robot"], "p3dx");
        assert_eq!(scene["sensors"].as_array().unwrap().len(), 16);
        let sources = scene["sources"].as_array().unwrap().len();
        assert_eq!(sources, usize::from(behavior != "nest"));
        let (mut led, mut far) = (0, 0);
        while recorded.step() != StepOutcome::Idle {
            let now = part(&mut recorded, "now");
            far += u32::from(now["thinks"].is_array() && error_m(&now) > 0.05);
            led += u32::from(now["way"].is_array());
        }
        assert_eq!(recorded.playback.difference, None);
        // It is shown where it was carried to before it hears that it was.
        assert!(
            led > 20 && far <= 3 * u32::from(behavior == "nest"),
            "{led} {far}"
        );
        let (now, places) = (part(&mut recorded, "now"), part(&mut recorded, "places"));
        // In the end it knows again where it is.
        assert!(error_m(&now) < 0.1, "{now}");
        assert_eq!(now["goal"]["name"], behavior);
        let count = |name: &str| places[name].as_array().unwrap().len();
        assert!(count("places") > 20 && count("links") > 20);
        assert_eq!(count("sensed") > 10, behavior != "nest");
    }
}

#[test]
fn the_time_line_has_every_decision_with_its_place() {
    let setup = episode::Setup {
        record: true,
        ..setup(SonarModel::Ideal)
    };
    let run = episode::run(&World::random(3), &setup, |_, _, _| {}).unwrap();
    let steps = run.recording.unwrap().seeking;
    let recorded = recorded(SonarModel::Ideal);
    let texts = recorded.timeline.trail.parts();
    let marks: Vec<Vec<f64>> = texts
        .flat_map(|part| {
            let text: serde_json::Value = serde_json::from_str(&part.text()).unwrap();
            serde_json::from_value::<Vec<Vec<f64>>>(text["value"].clone()).unwrap()
        })
        .collect();
    assert_eq!(marks.len(), recorded.timeline.decisions);
    // A step ends where the next one is decided.
    let seeking = marks.iter().filter(|mark| mark[3] > 0.0);
    for (mark, next) in seeking.zip(&steps[1..]) {
        let place = next.pose.position;
        assert!((mark[1] - place.x).abs() < 1e-4 && (mark[2] - place.y).abs() < 1e-4);
    }
}

#[test]
fn a_mind_that_decides_otherwise_is_noticed_and_the_rest_not_shown() {
    let mut recorded = WatchedLog::new(&changed()).unwrap();
    to_the_end(&mut recorded);
    let now = recorded.snapshot().now;
    assert!(now.why.unwrap().contains("does not do what the log says"));
    assert!(recorded.playback.decided < recorded.timeline.decisions);
    recorded.execute(&PageCommand::Jump { to: 5 }).unwrap();
    assert_eq!(recorded.playback.difference, None);
}

#[test]
fn a_log_that_is_cut_off_plays_up_to_its_end() {
    let mut bytes = logged(SonarModel::Nomad);
    bytes.truncate(bytes.len() * 3 / 4);
    let mut recorded = WatchedLog::new(&file(bytes)).unwrap();
    to_the_end(&mut recorded);
    let now = recorded.snapshot().now;
    let note = now.note.unwrap();
    assert!(note.contains("cut off"), "{note}");
    assert_eq!(now.why, None);
}

#[test]
fn a_recording_cannot_be_steered() {
    let mut recorded = recorded(SonarModel::Ideal);
    for command in [
        PageCommand::Explore,
        PageCommand::Seek,
        PageCommand::GoalNeuron { neuron: 3 },
        PageCommand::Shield { on: false },
        PageCommand::Reset(Reset::default()),
    ] {
        assert!(recorded.execute(&command).is_err(), "{command:?}");
    }
    assert!(!recorded.abilities().drive);
}
