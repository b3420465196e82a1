//! Faulty transducers are detected within a run, and intact ones stay enabled.

use amp::config::Config;
use amp::faults::{SensorFault, SensorVerdict};
use arena::robot::TurretMode;
use arena::sonar::{SonarModel, TransducerFault};
use arena::world::World;
use sim::behavior::Behavior;
use sim::episode::{Setup, run_with};
use sim::pilot::LocalController;
use tests::{host_sim, words};

/// Verdicts of a controller with fault detection in a random room, and the number of moves with
/// contact.
fn verdicts(room: u64, sonar: SonarModel, faults: &[&str]) -> (Vec<SensorVerdict>, u32) {
    let faults = faults
        .iter()
        .map(|text| text.parse::<TransducerFault>().expect(text));
    let config = Config::recommended();
    let setup = Setup {
        config: config.clone(),
        preset: "default".to_owned(),
        behavior: Behavior::Avoid,
        explore_moves: 100,
        steps: 100,
        seed: room,
        sonar,
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: faults.collect(),
        goal: None,
        second_robot: false,
        record: false,
    };
    let mut mind = LocalController::new(config);
    let run = run_with(&World::random(room), &setup, &mut mind, |_, _, _| {});
    let report = run.expect("an episode").report;
    (
        mind.verdicts().to_vec(),
        report.explore_contacts + report.contacts,
    )
}

#[test]
fn a_dead_transducer_is_masked_and_the_robot_touches_nothing() {
    for (room, sensor) in [(1_001, 0), (1_002, 6), (1_003, 13)] {
        let dead = format!("dead:{sensor}");
        let (verdicts, contacts) = verdicts(room, SonarModel::Nomad, &[&dead]);
        let first = verdicts.first().expect("a verdict");
        assert_eq!(
            (usize::from(first.sensor), first.fault),
            (sensor, Some(SensorFault::Unheard))
        );
        assert!(
            verdicts
                .iter()
                .all(|verdict| usize::from(verdict.sensor) == sensor)
        );
        assert_eq!(contacts, 0, "room {room}");
    }
}

#[test]
fn one_that_always_says_the_same_is_stuck() {
    let (verdicts, _) = verdicts(1_004, SonarModel::Nomad, &["stuck:5:2"]);
    let stuck = SensorVerdict {
        sensor: 5,
        fault: Some(SensorFault::Stuck),
    };
    assert_eq!(verdicts, [stuck]);
}

#[test]
fn a_ring_in_order_is_believed_in_every_room() {
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        for room in 1_001..1_011 {
            assert_eq!(
                verdicts(room, sonar, &[]),
                (Vec::new(), 0),
                "room {room}, {sonar:?}"
            );
        }
    }
}

/// Without a fault, a run with detection (the default) equals one without, byte for byte.
#[test]
fn who_finds_nothing_changes_nothing() {
    let program = host_sim!();
    let run = "run --world random:1005 --sonar nomad --steps 60 --json";
    let watched = format!("{run} --set fault-detection=off");
    assert_eq!(program.ok(run), program.ok(&watched));
}

#[test]
fn faults_that_are_none_are_refused_by_name() {
    let program = host_sim!();
    for (flags, part) in [
        ("run --fault daed:3", "did you mean \"dead\""),
        ("run --fault dead:16", "0 to 15"),
        ("run --fault stuck:3", "stuck:3"),
        ("run --fault swapped:3:3", "swapped:3:3"),
        ("faults --kind deaf", "deaf"),
    ] {
        let refused = program.run(&words(flags));
        assert_eq!(refused.code, Some(2), "{flags}");
        let said = refused.stderr;
        assert!(said.contains(part), "{flags}: {said}");
        assert!(refused.stdout.is_empty(), "{flags}");
    }
}

/// The documentation's table comes from this command; here for two rooms.
#[test]
fn the_campaign_prints_its_table() {
    let program = host_sim!();
    let table = program.ok("faults --rooms 2 --kind dead --steps 20 --markdown");
    let row = table.lines().nth(2).expect("a row");
    assert!(row.starts_with("| dead | 32 |"), "{table}");
    assert!(table.contains("2 random rooms from 1001 on"), "{table}");
}
