//! Logs of short episodes, for the tests of this crate and of others.

use super::{AnswerRecord, LogFile, LogWriter, channel, run};
use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use sim::behavior::Behavior;
use sim::episode::Setup;
use sim::pilot::LocalController;
use std::io::Cursor;
use std::path::Path;

/// Thirty random moves and sixty decisions to avoid obstacles.
pub fn setup(sonar: SonarModel) -> Setup {
    Setup {
        config: Config::recommended(),
        preset: "default".into(),
        behavior: Behavior::Avoid,
        explore_moves: 30,
        steps: 60,
        seed: 5,
        sonar,
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    }
}

/// The log of an episode.
pub fn logged(sonar: SonarModel) -> Vec<u8> {
    let world = World::random(3);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    run(
        &world,
        &setup(sonar),
        LocalController::new(Config::recommended()),
        &path,
    )
    .unwrap();
    std::fs::read(path).unwrap()
}

/// Parses the bytes of a log.
pub fn file(bytes: Vec<u8>) -> LogFile {
    LogFile::of(Path::new("a.mcap"), bytes).unwrap()
}

/// A log whose answer 40 differs from the controller's.
pub fn changed() -> LogFile {
    let original = file(logged(SonarModel::Ideal));
    let mut log = LogWriter::begin(Cursor::new(Vec::new()), "b.mcap").unwrap();
    log.setup(original.setup(), Some(&World::random(3)));
    let mut answers = 0;
    for message in original.messages() {
        match message.topic.as_str() {
            channel::EVENT => log.event(&message.content().unwrap()),
            channel::PLAN => {
                let mut answer: AnswerRecord = message.content().unwrap();
                answers += 1;
                if let (40, Some(motion)) = (answers, &mut answer.motion) {
                    motion.displacement_mm[0] += 1;
                }
                log.answer(&answer);
            }
            _ => {}
        }
    }
    log.finish().unwrap();
    file(log.into_inner().into_inner())
}
