//! `host-sim link` with a running chip: download and upload of its state, goals, power cycles.

use amp::controller::{Command, Decision, Event, handle};
use amp::goal::Goal;
use amp::units::{Millis, Range};
use amp::wire::message::{Clock, DeviceMessage, HostMessage, Report, RobotCommand, TimedEcho};
use remote::link::Knowledge;
use sim::goal_file::GoalFile;
use std::io::{BufRead as _, BufReader};
use std::process::Stdio;
use std::sync::mpsc::{Receiver, channel};
use std::thread::{sleep, spawn};
use std::time::Duration;
use tests::board::EmulatedBoard;
use tests::chip::{EmulatedChip, SESSION, TIMEOUT};
use tests::{Program, host_sim};

/// State of a robot with the preset `touzet` after thirty moves: neither its configuration nor its
/// maps are the defaults of the chip.
const EPISODE: &str = "run --preset touzet --world random:4 --explore 30 --steps 5 --json --mind";

const GOAL: &str = "[[sonar]]\nnumbers = [4]\nat_least = 0.6\nat_most = 0.8\n";

fn link(program: &Program, board: &EmulatedBoard, verb: &str) -> String {
    program.ok(&format!("link --to tcp:{} {verb}", board.host()))
}

#[test]
fn what_one_chip_has_learned_another_one_knows() {
    let program = host_sim!();
    let taught = EmulatedBoard::start();
    let _ = program.ok(&format!("{EPISODE} tcp:{}", taught.host()));
    link(&program, &taught, "pull first.mind");
    drop(taught);
    let fresh = EmulatedBoard::start();
    link(&program, &fresh, "pull fresh.mind");
    link(&program, &fresh, "push first.mind");
    link(&program, &fresh, "pull second.mind");
    let read = |name: &str| std::fs::read(program.folder().join(name)).expect("a file");
    assert_eq!(read("first.mind"), read("second.mind"));
    assert_ne!(read("first.mind"), read("fresh.mind"));
    let knowledge = Knowledge::load(&program.folder().join("second.mind")).expect("a mind");
    assert_eq!(knowledge.samples(), 30);
    a_goal_file_is_what_the_chip_pursues(&program, &fresh, &knowledge);
}

/// Part of the test above, because it needs a trained chip.
fn a_goal_file_is_what_the_chip_pursues(
    program: &Program,
    board: &EmulatedBoard,
    mind: &Knowledge,
) {
    program.put("wall.toml", GOAL);
    assert_eq!(link(program, board, "goal wall.toml"), "done\n");
    let mut chip = EmulatedChip::at(board.host());
    chip.open(SESSION, Clock::Host);
    chip.command(RobotCommand::Seek);
    let theirs = decision(&chip.ask(&HostMessage::Scan {
        at_ms: chip.at_ms(),
        echoes: (0..16).map(heard).collect(),
    }));
    let file = GoalFile::load(&program.folder().join("wall.toml")).expect("a goal");
    let goal = file.goal;
    assert_eq!(theirs, Some(decided_here(mind, goal)));
    let other = Goal::avoiding(mind.config());
    assert_ne!(theirs, Some(decided_here(mind, other)));
}

/// A ring with nearer echoes on the left.
fn heard(sensor: u8) -> TimedEcho {
    TimedEcho {
        sensor,
        range_mm: Some(if sensor == 4 { 400 } else { 900 }),
        age_ms: 0,
    }
}

fn decision(said: &[Report<16>]) -> Option<Decision<16>> {
    said.iter().find_map(|report| match report.message {
        DeviceMessage::Decision(decision) => Some(decision),
        _ => None,
    })
}

/// The decision of the same controller on this machine.
fn decided_here(mind: &Knowledge, goal: Goal<16>) -> Decision<16> {
    let mut state = mind.state().clone();
    let now = Millis::from_ms(0);
    let _ = handle(
        mind.config(),
        &mut state,
        now,
        Event::Command(Command::Seek(goal)),
    );
    let decisions = (0..16).map(heard).filter_map(|heard| {
        let (sensor, range) = (heard.sensor, heard.range_mm.map(Range::from_mm));
        handle(
            mind.config(),
            &mut state,
            now,
            Event::Echo { sensor, range },
        )
        .decision
    });
    decisions.last().expect("a decision")
}

#[test]
fn monitor_finds_a_chip_again_that_was_switched_off() {
    let program = host_sim!();
    let mut board = EmulatedBoard::start();
    let address = format!("tcp:{}", board.host());
    let mut monitor = program.command(&["link", "--to", &address, "monitor"]);
    let mut monitor = monitor
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("host-sim starts");
    let said = lines(monitor.stderr.take().expect("its messages"));
    let accepted = |board: &EmulatedBoard| {
        let mut chip = EmulatedChip::at(board.host());
        chip.open(SESSION, Clock::Device);
        chip.counters().accepted
    };
    // Long enough to connect and to occupy the chip's only line.
    sleep(Duration::from_secs(1));
    board.switch_off();
    let lost = said.recv_timeout(TIMEOUT).expect("a message");
    assert!(
        lost.contains(&address) && lost.contains("the link broke") && lost.contains("trying again"),
        "{lost}"
    );
    board.switch_on();
    let found = said.recv_timeout(TIMEOUT).expect("another message");
    assert_eq!(found, format!("{address}: reconnected"));
    // It continues: the chip receives its heartbeats.
    sleep(Duration::from_secs(1));
    assert_eq!(monitor.try_wait().expect("its state"), None);
    monitor.kill().expect("it still runs");
    let _ = monitor.wait();
    assert!(accepted(&board) > 5);
    assert_eq!(said.try_iter().next(), None);
}

/// The lines of a stream as they arrive.
fn lines(stream: impl std::io::Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            let _ = sender.send(line);
        }
    });
    receiver
}
