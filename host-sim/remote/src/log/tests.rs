//! Logs in memory: complete, cut off, changed, and on a full disk.

use super::fixture::{changed, file, logged, setup};
use super::read::LogFile;
use super::*;
use amp::controller::{Event, Outputs};
use amp::units::Millis;
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::World;
use sim::behavior::{Behavior, Tour};
use sim::episode::{self, Setup};
use sim::pilot::{LocalController, Pilot};
use sim::robot::{AnyRobot, Origin, Ranges};
use sim::senses::SenseGoal;
use sim::sim_controller::SimController;
use std::io::{Cursor, Seek, SeekFrom, Write};
use std::path::Path;

#[test]
fn a_log_replays_bit_for_bit() {
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        let done = replay(&file(logged(sonar)), |_| {}).unwrap();
        assert_eq!(done.difference, None);
        assert_eq!(done.ending, Ending::Complete);
        // The last decision of each phase is not executed.
        assert!(done.decisions >= 90, "{done:?}");
    }
}

#[test]
fn a_log_does_not_change_the_episode_and_is_the_same_twice() {
    let world = World::random(3);
    let setup = setup(SonarModel::Nomad);
    let plain = episode::run(&world, &setup, |_, _, _| {}).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let controller = LocalController::new(setup.config.clone());
    let watched = run(&world, &setup, controller, &path).unwrap();
    assert_eq!(plain.report, watched.report);
    assert_eq!(std::fs::read(path).unwrap(), logged(SonarModel::Nomad));
}

/// It finds its sensors, learns, drives around by its places, is carried and turned, and comes back
/// by a scent.
#[test]
fn a_log_of_a_robot_with_places_replays_bit_for_bit() {
    let told = |robot: AnyRobot| robot.with_geometry(Origin::Learned).unwrap();
    let tour = Tour::of(60);
    let nest = Behavior::Nest {
        tour,
        is_turned: true,
    };
    let scent = Behavior::Sense {
        goal: SenseGoal::Scent,
        tour,
    };
    let p3dx = AnyRobot::new(RobotModel::builtin("p3dx").unwrap(), Ranges::Own, true).unwrap();
    for (sonar, robot, behavior) in [
        (SonarModel::Ideal, p3dx.clone(), scent.clone()),
        (SonarModel::Ideal, told(p3dx.clone()), nest.clone()),
        (SonarModel::Nomad, told(p3dx.clone()), scent),
        (SonarModel::Nomad, p3dx, nest),
    ] {
        let ring = setup(sonar);
        let setup = Setup {
            config: robot.config(ring.config.clone()),
            robot: Some(robot),
            behavior,
            ..ring
        };
        let world = World::random(3);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let controller = SimController::new(&setup.config, setup.robot.as_ref());
        let episode = run(&world, &setup, controller, &path).unwrap();
        let plain = episode::run(&world, &setup, |_, _, _| {}).unwrap();
        assert_eq!(plain.report, episode.report);
        assert_eq!(plain.bearing_errors_deg, episode.bearing_errors_deg);
        let log = file(std::fs::read(path).unwrap());
        let done = replay(&log, |_| {}).unwrap();
        assert_eq!(done.difference, None, "{sonar:?}");
        assert!(done.decisions >= 100, "{done:?}");
    }
}

#[test]
fn wherever_it_is_cut_off_the_whole_chunks_replay() {
    let whole = logged(SonarModel::Nomad);
    let mut seen = std::collections::BTreeSet::new();
    for part in 0..=32 {
        let mut bytes = whole.clone();
        bytes.truncate(whole.len() * part / 32);
        let Ok(log) = LogFile::of(Path::new("a.mcap"), bytes) else {
            assert!(part < 32, "the whole log is readable");
            continue;
        };
        let done = replay(&log, |_| {}).unwrap();
        assert_eq!(done.difference, None);
        let ending = if part == 32 {
            Ending::Complete
        } else {
            Ending::Interrupted
        };
        assert_eq!(done.ending, ending, "{part}");
        seen.insert(done.decisions);
    }
    assert!(seen.len() > 2, "several chunks: {seen:?}");
}

#[test]
fn a_changed_byte_is_noticed() {
    let mut bytes = logged(SonarModel::Ideal);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    let refused = LogFile::of(Path::new("a.mcap"), bytes).unwrap_err();
    let sentence = refused.to_string();
    assert!(
        sentence.contains("a.mcap: is damaged at byte "),
        "{sentence}"
    );
}

#[test]
fn a_changed_answer_is_found_and_named() {
    let done = replay(&changed(), |_| {}).unwrap();
    assert_eq!(done.answers, 40);
    let difference = done.difference.unwrap();
    assert!(
        difference.contains("the log says {\"at_ms\":"),
        "{difference}"
    );
}

#[test]
fn the_summary_counts_what_happened() {
    let log = file(logged(SonarModel::Ideal));
    let summary = Summary::of(&log).unwrap();
    assert_eq!(summary.random_moves, 30);
    assert_eq!(summary.decisions, 61);
    let commands: Vec<_> = summary.commands.iter().map(|(_, what)| *what).collect();
    assert_eq!(commands, ["explore", "learn", "seek"]);
    assert!(summary.distance_m > 10.0);
    assert_eq!(log.setup().seed, 5);
}

/// A disk with a limited number of free bytes.
struct FullDisk {
    room: usize,
    at: u64,
}

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        if bytes.len() > self.room {
            return Err(std::io::Error::from(std::io::ErrorKind::StorageFull));
        }
        self.room -= bytes.len();
        self.at += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for FullDisk {
    fn seek(&mut self, _: SeekFrom) -> std::io::Result<u64> {
        Ok(self.at)
    }
}

#[test]
fn a_full_disk_ends_the_episode_in_words() {
    let world = World::random(3);
    let setup = setup(SonarModel::Nomad);
    let disk = FullDisk {
        room: 50_000,
        at: 0,
    };
    let log = SharedLog::new(LogWriter::begin(disk, "a.mcap").unwrap());
    let mut tap = LoggedPilot::new(
        LocalController::new(setup.config.clone()),
        Some(log.clone()),
    );
    let mut watcher = WorldLogger::new(log);
    let done = episode::run_observed(&world, &setup, &mut tap, Some(&mut watcher), |_, _, _| {});
    let failure = done.unwrap_err().to_string();
    assert!(
        failure.starts_with("a.mcap: cannot be written: "),
        "{failure}"
    );
}

#[test]
fn a_message_that_could_not_be_read_is_not_written() {
    let mut log = LogWriter::begin(Cursor::new(Vec::new()), "a.mcap").unwrap();
    let event = EventKind::Know("0".repeat(1_048_577));
    log.event(&EventRecord { at_ms: 0, event });
    let failure = log.failure().unwrap();
    assert!(
        failure.starts_with("a.mcap: cannot be written: a message of /event has 10485"),
        "{failure}"
    );
}

#[test]
fn ticks_that_change_nothing_are_not_counted_out() {
    let log = file(logged(SonarModel::Ideal));
    let mut controller = Replayer::new(log.setup());
    for done in [false, true] {
        let event = EventKind::Ticks {
            count: u32::MAX,
            done,
        };
        let mut ticks = 0;
        controller
            .apply(&EventRecord { at_ms: 0, event }, |_| ticks += 1)
            .unwrap();
        assert_eq!(ticks, 1);
    }
}

/// Does nothing.
struct Idle;

impl Pilot for Idle {
    fn handle(&mut self, _: Millis, _: Event<16>) -> Outputs<16> {
        Outputs::NONE
    }
}

#[test]
fn ticks_that_change_nothing_are_written_where_they_let_time_pass() {
    // A body may find its sensors in each tick.
    let p3dx = AnyRobot::new(RobotModel::builtin("p3dx").unwrap(), Ranges::Own, true).unwrap();
    assert_eq!(logged_times(None), [100, 120, 130, 140]);
    assert_eq!(
        logged_times(Some(p3dx)),
        [100, 100, 110, 120, 130, 130, 140]
    );
}

/// Times of the logged events of a robot whose controller does nothing.
fn logged_times(robot: Option<AnyRobot>) -> Vec<u32> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let log = SharedLog::new(LogWriter::create(&path).unwrap());
    let mut tap = LoggedPilot::new(Idle, Some(log.clone()));
    let setup = Setup {
        robot,
        ..setup(SonarModel::Ideal)
    };
    tap.begin(&SetupRecord::of("room", &setup), None);
    let mut tell = |at_ms, event| {
        let _ = tap.handle(Millis::from_ms(at_ms), event);
    };
    tell(100, Event::Touched);
    for at_ms in [100, 110, 120] {
        tell(at_ms, Event::Tick);
    }
    tell(130, Event::Touched);
    tell(130, Event::Tick);
    tell(140, Event::Touched);
    log.finish().unwrap();
    let log = LogFile::of(&path, std::fs::read(&path).unwrap()).unwrap();
    let events = log
        .messages()
        .filter(|message| message.topic == channel::EVENT);
    let times = events.map(|message| message.content::<EventRecord>().unwrap().at_ms);
    times.collect()
}
