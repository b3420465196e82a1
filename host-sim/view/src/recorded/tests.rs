use super::*;
use crate::command::Reset;
use arena::sonar::SonarModel;
use arena::world::World;
use remote::link::Knowledge;
use remote::log::fixture::{changed, file, logged, setup};
use sim::episode;
use sim::pilot::LocalController;

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
