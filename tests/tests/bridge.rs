//! A controller drives the simulated Nomad over the robot's own protocol; either side may fail.

use amp::config::Config;
use nomad200::NomadCommand;
use remote::link::NodeServer;
use remote::log::{AnswerRecord, EventKind, EventRecord, channel, read};
use serde_json::Value;
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};
use tests::board::EmulatedBoard;
use tests::chip::image;
use tests::nomad::{Proxy, ProxyMode, Running, ServedRobot, stands};
use tests::{Program, host_sim};

/// Longest braking time of a base: from 0.508 m/s at 0.762 m/s², wheels from 45 °/s at 30 °/s².
const BRAKING: Duration = Duration::from_millis(1_700);

fn bridge(program: &Program, robot: &str, flags: &str) -> Running {
    Running::start(program, &format!("bridge --nomad {robot} --json {flags}"))
}

fn figures(stdout: &str) -> Value {
    serde_json::from_str(stdout).unwrap_or_else(|error| panic!("{stdout}: {error}"))
}

/// Runs to the end without contact, by the robot's bumpers and by the world.
fn drives_clean(
    program: &Program,
    robot: &mut ServedRobot,
    at: &str,
    flags: &str,
    moves: [u64; 2],
) {
    let mut driver = bridge(program, at, flags);
    let (code, stdout, stderr) = driver.end(Duration::from_secs(1_800));
    assert_eq!(code, Some(0), "{stderr}");
    let figures = figures(&stdout);
    for (key, wanted) in [
        ("explore_moves", moves[0]),
        ("steps", moves[1]),
        ("contacts", 0),
        ("explore_contacts", 0),
    ] {
        assert_eq!(figures[key].as_u64(), Some(wanted), "{key}: {figures}");
    }
    assert!(
        figures["distance_m"].as_f64() > Some(0.05 * moves[1] as f64),
        "{figures}"
    );
    let until = Instant::now() + Duration::from_secs(5);
    let mut seen = robot.program.messages();
    // A serial port does not show a disconnection.
    while seen.is_empty() && at.starts_with("tcp") && Instant::now() < until {
        sleep(Duration::from_millis(10));
        seen = robot.program.messages();
    }
    for line in &seen {
        assert!(line.contains(" 0 contacts"), "{line}");
    }
}

#[test]
fn a_mind_in_this_process_drives_a_robot_at_a_socket() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_port(&program, "--speed 10");
    let at = format!("tcp:{}", robot.place);
    drives_clean(
        &program,
        &mut robot,
        &at,
        "--explore 40 --steps 100 --log drive.mcap",
        [40, 100],
    );
    // A replay makes the same decisions.
    let said = program.ok("replay drive.mcap");
    assert!(said.contains("every one identical"), "{said}");
    assert!(said.ends_with("complete\n"), "{said}");
    let said = program.ok("log drive.mcap");
    assert!(said.contains(&format!("Nomad at {at}")), "{said}");
}

#[test]
fn a_mind_in_this_process_drives_a_robot_at_a_serial_port() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_pty(&program, "--speed 10 --world room");
    let at = format!("serial:{}@38400", robot.place);
    drives_clean(
        &program,
        &mut robot,
        &at,
        "--explore 15 --steps 30",
        [15, 30],
    );
}

/// The whole chain: robot, its protocol, bridge, link, chip. At the robot's own speed: a faster
/// motion would expire before the chip's answer.
#[test]
fn the_firmware_in_an_emulated_chip_drives_a_robot() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_port(&program, "--speed 1");
    let at = format!("tcp:{}", robot.place);
    let firmware = image().display();
    let flags = format!("--explore 5 --steps 5 --mind qemu --firmware {firmware}");
    drives_clean(&program, &mut robot, &at, &flags, [5, 5]);
}

/// Takes minutes: run by `tests/extra bridge`.
#[test]
#[ignore = "takes minutes: tests/extra bridge"]
fn the_firmware_drives_a_thousand_steps() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_port(&program, "--speed 4");
    let at = format!("tcp:{}", robot.place);
    let firmware = image().display();
    let flags = format!("--explore 100 --steps 1000 --mind qemu --firmware {firmware}");
    drives_clean(&program, &mut robot, &at, &flags, [100, 1_000]);
}

/// Waits until the robot has moved for a while.
fn under_way(robot: &mut ServedRobot, driver: &mut Running) {
    sleep(Duration::from_secs(4));
    let (gone, said) = (robot.program.messages(), driver.messages());
    assert!(gone.is_empty() && said.is_empty(), "{gone:?} {said:?}");
}

/// Checked by a new client.
fn assert_stands(robot: &ServedRobot) {
    let mut host = robot.connect();
    let state = host.request(&NomadCommand::GetState).expect("an answer");
    assert!(stands(state), "{state:?}");
}

/// At the robot's own speed: after a kill of the bridge the base stops by its own timeout.
#[test]
fn without_its_bridge_the_base_stops_by_itself() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_port(&program, "--world room");
    let at = format!("tcp:{}", robot.place);
    let mut driver = bridge(&program, &at, "--explore 100");
    under_way(&mut robot, &mut driver);
    driver.kill();
    let killed = Instant::now();
    // A request before the timeout of one second would reset it.
    sleep(Duration::from_secs(1) + BRAKING);
    let mut host = robot.connect();
    let state = host
        .request(&NomadCommand::GetState)
        .expect("an answer")
        .clone();
    assert!(stands(&state), "{:?} after {:?}", state, killed.elapsed());
    assert_eq!(state.bumpers, 0);
}

#[test]
fn an_interrupted_bridge_tells_the_base_to_stand() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_port(&program, "--world room");
    let at = format!("tcp:{}", robot.place);
    let mut driver = bridge(&program, &at, "--explore 100");
    under_way(&mut robot, &mut driver);
    driver.interrupt();
    let (code, stdout, stderr) = driver.end(Duration::from_secs(3));
    assert_eq!(code, Some(2));
    assert_eq!(stderr, "host-sim: interrupted; the base was stopped\n");
    assert!(figures(&stdout)["distance_m"].as_f64() > Some(0.0));
    sleep(BRAKING);
    assert_stands(&robot);
}

#[test]
fn without_its_robot_the_bridge_ends_and_so_does_the_mind() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_port(&program, "--world room");
    let at = format!("tcp:{}", robot.place);
    let mut driver = bridge(&program, &at, "--explore 100");
    under_way(&mut robot, &mut driver);
    robot.program.kill();
    let killed = Instant::now();
    let (code, _, stderr) = driver.end(Duration::from_secs(5));
    assert_eq!(code, Some(2));
    assert!(killed.elapsed() < Duration::from_secs(4));
    assert!(
        stderr.starts_with(&format!("host-sim: {at}: the line to the robot broke")),
        "{stderr}"
    );
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}

/// The connection stays open without data: three requests with a timeout of one second each.
#[test]
fn a_robot_that_falls_silent_ends_the_bridge_and_stops_by_itself() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_port(&program, "--world room");
    let line = Proxy::to(&robot.place);
    let at = format!("tcp:{}", line.place);
    let mut driver = bridge(&program, &at, "--explore 100");
    under_way(&mut robot, &mut driver);
    line.switch(ProxyMode::Mute);
    let (code, stdout, stderr) = driver.end(Duration::from_secs(7));
    assert_eq!(code, Some(2));
    assert!(
        stderr.starts_with(&format!(
            "host-sim: {at}: the robot has not answered within 1 s"
        )),
        "{stderr}"
    );
    assert!(figures(&stdout)["distance_m"].as_f64() > Some(0.0));
    assert_stands(&robot);
}

/// Time from the last odometry report to the controller's last message, by its clock, ms; the
/// distance in that report, m.
fn last_way(log: &Path) -> (u32, f64) {
    let log = read(log).expect("a log");
    let (mut moved_ms, mut said_ms, mut way_m) = (0, 0, 0.0);
    for message in log.messages() {
        match message.topic.as_str() {
            channel::EVENT => {
                let record: EventRecord = message.content().expect("an event");
                if let EventKind::Odometry { moved_mm, .. } = record.event
                    && moved_mm != [0; 2]
                {
                    moved_ms = record.at_ms;
                    let [x, y] = moved_mm.map(f64::from);
                    way_m += x.hypot(y) / 1e3;
                }
            }
            channel::PLAN => {
                let answer: AnswerRecord = message.content().expect("an answer");
                said_ms = answer.at_ms;
            }
            _ => {}
        }
    }
    (said_ms - moved_ms, way_m)
}

/// The motor runs against blocked wheels. A motion must end after twice its distance over its speed
/// plus half a second: at full speed 1.5 s at most.
#[test]
fn blocked_wheels_stop_the_robot() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--world room --blocked-after 0.2");
    let at = format!("tcp:{}", robot.place);
    let began = Instant::now();
    let mut driver = bridge(&program, &at, "--explore 100 --log blocked.mcap");
    // Two moves take less than 10 s. The timeout of a silent ring, a hundred rings, would be 64 s.
    let (code, stdout, stderr) = driver.end(Duration::from_secs(30));
    assert_eq!(code, Some(2), "{stdout}");
    assert_eq!(
        stderr,
        "host-sim: the robot stopped: its motion did not end in time: the wheels may be blocked\n"
    );
    assert!(began.elapsed() < Duration::from_secs(30));
    // Summed up in steps of a tenth of an inch along x and y.
    let rolled_m = figures(&stdout)["distance_m"].as_f64();
    assert!(rolled_m > Some(0.19) && rolled_m < Some(0.3), "{stdout}");
    let (ms, way_m) = last_way(&program.folder().join("blocked.mcap"));
    assert!(ms < 1_600 && way_m > 0.19, "{ms} ms {way_m} m");
    // A replay makes the same decisions.
    let said = program.ok("replay blocked.mcap");
    assert!(said.contains("every one identical"), "{said}");
    sleep(BRAKING);
    assert_stands(&robot);
}

/// The same with a remote controller, which has its own clock.
#[test]
fn blocked_wheels_stop_the_robot_of_a_mind_elsewhere() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--world room --blocked-after 0.2");
    let at = format!("tcp:{}", robot.place);
    let mind = NodeServer::start(Config::recommended()).expect("a mind");
    let to_mind = format!("tcp:{}", mind.host());
    let mut driver = bridge(&program, &at, &format!("--mind {to_mind} --explore 100"));
    let (code, stdout, stderr) = driver.end(Duration::from_secs(30));
    assert_eq!(code, Some(2), "{stdout}");
    assert_eq!(
        stderr,
        format!(
            "host-sim: {to_mind}: the controller stopped: its motion did not end in time: the wheels may be blocked; the robot was stopped\n"
        )
    );
    sleep(BRAKING);
    assert_stands(&robot);
}

/// A controller behind a socket that is closed, or that stays open without data.
#[test]
fn without_its_mind_the_base_is_told_to_stand() {
    let program = host_sim!();
    for (lost, why) in [
        (ProxyMode::Off, "the link broke"),
        (ProxyMode::Mute, "no answer within 2 s"),
    ] {
        let mut robot = ServedRobot::at_a_port(&program, "--world room");
        let at = format!("tcp:{}", robot.place);
        let mind = NodeServer::start(Config::recommended()).expect("a mind");
        let line = Proxy::to(&mind.host());
        let to_mind = format!("tcp:{}", line.place);
        let mut driver = bridge(&program, &at, &format!("--mind {to_mind}"));
        under_way(&mut robot, &mut driver);
        line.switch(lost);
        let (code, stdout, stderr) = driver.end(Duration::from_secs(6));
        assert_eq!(code, Some(2), "{stdout}");
        assert!(
            stderr.starts_with(&format!("host-sim: {to_mind}: {why}"))
                && stderr.ends_with("; the robot was stopped\n"),
            "{stderr}"
        );
        assert!(figures(&stdout)["distance_m"].as_f64() > Some(0.0));
        sleep(BRAKING);
        assert_stands(&robot);
    }
}

/// The firmware panics while the robot moves: the chip resets, and the bridge detects it by the
/// next hello.
#[test]
fn without_its_chip_the_base_is_told_to_stand() {
    let program = host_sim!();
    let mut robot = ServedRobot::at_a_port(&program, "--world room");
    let at = format!("tcp:{}", robot.place);
    let board = EmulatedBoard::start();
    let line = Proxy::to(board.host());
    let to_mind = format!("tcp:{}", line.place);
    let mut driver = bridge(&program, &at, &format!("--mind {to_mind} --explore 100"));
    under_way(&mut robot, &mut driver);
    line.say(b"\0!panic\0");
    let reset = Instant::now();
    let (code, stdout, stderr) = driver.end(Duration::from_secs(6));
    assert_eq!(code, Some(2), "{stdout}");
    assert_eq!(
        stderr,
        format!(
            "host-sim: {to_mind}: the controller has restarted (its program panicked); the robot was stopped\n"
        )
    );
    assert!(
        reset.elapsed() < Duration::from_secs(2),
        "{:?}",
        reset.elapsed()
    );
    assert!(figures(&stdout)["distance_m"].as_f64() > Some(0.0));
    sleep(BRAKING);
    assert_stands(&robot);
}

#[test]
fn what_is_not_there_is_named() {
    let program = host_sim!();
    let refused = |flags: &str| {
        let output = program.run(&tests::words(&format!("bridge {flags}")));
        assert_eq!(
            (output.code, output.stdout.as_str()),
            (Some(2), ""),
            "{flags}"
        );
        assert!(!output.stderr.contains("panicked"));
        output.stderr
    };
    // Port 1 has no server.
    assert!(refused("--nomad tcp:127.0.0.1:1").contains("tcp:127.0.0.1:1"));
    assert!(refused("--nomad serial:/dev/ttyNowhere7").contains("/dev/ttyNowhere7"));
    assert!(refused("--nomad qemu").contains("no address of a robot"));
    let robot = ServedRobot::at_a_port(&program, "");
    let at = format!("tcp:{}", robot.place);
    let lost = refused(&format!("--nomad {at} --mind tcp:127.0.0.1:1"));
    assert!(lost.contains("tcp:127.0.0.1:1 cannot be reached"), "{lost}");
    assert!(refused(&format!("--nomad {at} --preset touzet")).contains("turret"));
}
