//! The simulated Nomad 200 with programs for the real robot: answers, masks, timeouts,
//! reconnection.

use arena::sonar::FIRING_ORDER;
use nomad200::nserver::ServerMessage;
use nomad200::{
    ANSWER_TIMEOUT, AxisMode, Host, Kind, NomadCommand, Packet, ReadingGroup, RobotError,
    StateMask, WITH_SONAR,
};
use remote::link::Tcp;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::thread::sleep;
use std::time::{Duration, Instant};
use tests::host_sim;
use tests::nomad::{ServedRobot, stands};

fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

fn ask(host: &mut Host, command: &NomadCommand) -> nomad200::NomadReadings {
    let state = host.request(command);
    state
        .unwrap_or_else(|error| panic!("{command:?}: {error}"))
        .clone()
}

/// Startup of a program: masks, sensors, timeout, speeds; and its requests.
fn session(host: &mut Host) {
    let order = FIRING_ORDER.map(|sensor| sensor as u8);
    let start = ask(host, &NomadCommand::Communicate(StateMask::ALL)).pose;
    for command in [
        NomadCommand::ConfigureTimeout(5),
        NomadCommand::ConfigureSonar { rate: 15, order },
        NomadCommand::ConfigureInfrared { history: 2, order },
        NomadCommand::ConfigureCompass(1),
        NomadCommand::Accelerations([300; 3]),
        NomadCommand::Speeds([200, 450, 450]),
        NomadCommand::Talk(b"hello".to_vec()),
        NomadCommand::DefinePosition([100, 200]),
        NomadCommand::GetState,
    ] {
        ask(host, &command);
    }
    for group in ReadingGroup::ALL {
        ask(host, &NomadCommand::Get(group));
    }
    assert_eq!(host.state().pose, [100, 200, start[2], start[3]]);
    assert_eq!(host.state().acceleration, [300; 3]);
    // A relative move, with the library's wait.
    let moving = ask(host, &NomadCommand::Relative([100, 0, 0]));
    assert_eq!(moving.motors, 1);
    let wait = NomadCommand::WaitForStop {
        axes: [true; 3],
        timeout_s: 20,
    };
    let there = host
        .request_within(&wait, Duration::from_secs(21))
        .expect("it stops")
        .clone();
    assert!(stands(&there));
    let [x, y, steering, _] = there.pose.map(f64::from);
    let (sin, cos) = (steering / 1_800.0 * std::f64::consts::PI).sin_cos();
    assert!((x - 100.0 - 100.0 * cos).abs() <= 1.0 && (y - 200.0 - 100.0 * sin).abs() <= 1.0);
    assert!(there.sonar.iter().any(|&inches| inches < 255));
}

#[test]
fn a_program_finds_its_robot_at_a_socket() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--speed 20");
    let mut host = robot.connect();
    assert_eq!(*host.mask(), StateMask::ALL);
    session(&mut host);
    // Space for at least a meter ahead of its front at the start.
    drop(host);
    let robot = ServedRobot::at_a_port(&program, "--sonar ideal --speed 20");
    let mut host = robot.connect();
    sleep(ms(40));
    assert!(ask(&mut host, &NomadCommand::GetState).sonar[0] >= 40);
}

#[test]
fn a_program_finds_its_robot_at_a_serial_port_of_any_speed() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_pty(&program, "--speed 20");
    for baud in [4_800, 38_400] {
        session(&mut robot.open(baud));
    }
}

#[test]
fn masks_hold_until_the_next_one_and_for_the_next_program() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "");
    let mut host = robot.connect();
    let few = StateMask {
        sonar: 0x8003,
        bumper: true,
        pose: [true, true, false, false],
        attached: WITH_SONAR,
        ..StateMask::NONE
    };
    for mask in [few, StateMask::NONE, StateMask::ALL, few] {
        ask(&mut host, &NomadCommand::Communicate(mask));
        ask(&mut host, &NomadCommand::GetState);
        ask(&mut host, &NomadCommand::Stop);
    }
    drop(host);
    assert_eq!(*robot.connect().mask(), few);
}

#[test]
fn a_program_that_falls_silent_leaves_a_robot_that_stops() {
    let program = host_sim!();
    // At this speed, the robot's timeout of one second is 50 ms.
    let robot = ServedRobot::at_a_port(&program, "--speed 20 --world room");
    let mut host = robot.connect();
    ask(&mut host, &NomadCommand::ConfigureTimeout(1));
    ask(&mut host, &NomadCommand::Velocity([20, 0, 100]));
    // Requests for its state keep it moving.
    let until = Instant::now() + ms(250);
    let mut state = ask(&mut host, &NomadCommand::GetState);
    while Instant::now() < until {
        state = ask(&mut host, &NomadCommand::GetState);
        sleep(ms(5));
    }
    assert_eq!(
        (state.velocity[0], state.velocity[2]),
        (20, 100),
        "{state:?}"
    );
    sleep(ms(250));
    let state = ask(&mut host, &NomadCommand::GetState);
    assert!(stands(&state), "{state:?}");
    let pose = state.pose;
    sleep(ms(50));
    assert_eq!(ask(&mut host, &NomadCommand::GetState).pose, pose);
}

/// At the robot's own speed: from 10 in/s it rolls 10 in until its timeout of one second and 1.7 in
/// while it brakes.
#[test]
fn a_program_that_is_killed_leaves_a_base_that_stops_when_its_time_is_out() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--sonar ideal");
    let mut host = robot.connect();
    ask(&mut host, &NomadCommand::ConfigureTimeout(1));
    ask(&mut host, &NomadCommand::Velocity([100, 0, 0]));
    sleep(ms(500));
    let rolling = ask(&mut host, &NomadCommand::GetState);
    assert_eq!(rolling.velocity[0], 100);
    drop(host);
    // A request would reset the timeout.
    sleep(ms(1_500));
    let state = ask(&mut robot.connect(), &NomadCommand::GetState);
    assert!(stands(&state), "{state:?}");
    let way = state.pose[0] - rolling.pose[0];
    assert!((115..=119).contains(&way), "{way}");
}

#[test]
fn another_order_is_fired_at_once() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--speed 20");
    let mut host = robot.connect();
    let mut order = [255; 16];
    order[..3].copy_from_slice(&[0, 1, 15]);
    ask(&mut host, &NomadCommand::ConfigureSonar { rate: 10, order });
    let mask = StateMask {
        attached: WITH_SONAR,
        ..StateMask::ALL
    };
    let before = ask(&mut host, &NomadCommand::Communicate(mask));
    sleep(ms(50));
    let after = ask(&mut host, &NomadCommand::GetState);
    let fired: Vec<_> = (0..16)
        .filter(|&i| after.sonar_at[i].sensed_ms != before.sonar_at[i].sensed_ms)
        .collect();
    assert_eq!(fired, [0, 1, 15]);
    assert!(after.time_ms.wrapping_sub(before.time_ms) >= 900);
    let newest = fired
        .iter()
        .map(|&i| after.sonar_at[i].sensed_ms)
        .max()
        .unwrap_or(0);
    assert!(after.time_ms - newest <= 40);
}

#[test]
fn who_is_gone_makes_room_for_the_next_one() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "");
    // In the middle of a packet.
    let mut first = TcpStream::connect(&robot.place).expect("a robot");
    first.write_all(&[1, 8, 0, 5, 100]).expect("half a packet");
    // The second one gets its greeting when the first one is gone.
    let mut second = TcpStream::connect(&robot.place).expect("a queue");
    second.set_read_timeout(Some(ms(150))).expect("a time-out");
    let mut greeting = [0; 11];
    assert!(second.read_exact(&mut greeting).is_err());
    drop(first);
    second
        .set_read_timeout(Some(ANSWER_TIMEOUT))
        .expect("a time-out");
    second.read_exact(&mut greeting).expect("a greeting");
    second
        .write_all(&[1, 2, 0, 7, 0x0a, 0x5c])
        .expect("a question");
    let mut head = [0; 4];
    second.read_exact(&mut head).expect("an answer");
    assert_eq!((head[0], head[3]), (1, Kind::Gs as u8));
    drop(second);
    ask(&mut robot.connect(), &NomadCommand::GetState);
}

#[test]
fn a_robot_answers_again_within_a_second_after_any_garbage() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "");
    let garbage: [&[u8]; 4] = [
        &[0xff; 3_000],
        &[1, 200, 0, 5, 1, 2, 3],
        &[1; 700],
        b"GET / HTTP/1.1\r\nHost: robot\r\n\r\n",
    ];
    for garbage in garbage {
        let mut host = robot.connect();
        host.line().send(garbage).expect("a line");
        // With the command directly behind, and again.
        ask(&mut host, &NomadCommand::GetState);
        ask(&mut host, &NomadCommand::Stop);
        drop(host);
        ask(&mut robot.connect(), &NomadCommand::GetState);
    }
    // A packet with a wrong check byte gets no answer; an unknown one is refused.
    let mut host = robot.connect();
    host.line().send(&[1, 2, 0, 9, 0x0d, 0x5c]).expect("a line");
    let torque = NomadCommand::Move([(AxisMode::Torque, 5); 3]);
    assert_eq!(host.request(&torque), Err(RobotError::Refused(Kind::Mv)));
    let unknown = Packet {
        kind: 77,
        payload: Vec::new(),
    };
    host.line().send(&unknown.to_bytes()).expect("a line");
    let answer = host.next(Instant::now() + ANSWER_TIMEOUT).expect("a line");
    assert_eq!(answer.map(|packet| packet.kind), Some(Kind::Nak as u8));
}

#[test]
fn a_packet_may_come_byte_by_byte() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "");
    let mut line = Tcp::open(&robot.place).expect("a robot");
    use remote::link::Transport as _;
    let mut host = Host::with_greeting(Tcp::open(&robot.place).expect("a queue"));
    assert!(host.is_err(), "one at a time");
    let mut buffer = [0; 64];
    assert_eq!(
        line.receive(&mut buffer, ANSWER_TIMEOUT)
            .expect("a greeting"),
        11
    );
    for byte in NomadCommand::Velocity([0, 50, 0]).to_packet().to_bytes() {
        line.send(&[byte]).expect("a line");
        sleep(ms(20));
    }
    let count = line
        .receive(&mut buffer, ANSWER_TIMEOUT)
        .expect("an answer");
    assert_eq!(buffer[..count].get(3), Some(&(Kind::Vm as u8)));
    drop(line);
    host = Host::with_greeting(Tcp::open(&robot.place).expect("a robot"));
    let mut host = host.expect("a greeting");
    assert!(ask(&mut host, &NomadCommand::Get(ReadingGroup::Velocity)).velocity[1] > 0);
}

/// At twenty times real time its clock runs twenty times as fast.
#[test]
fn its_time_runs_as_fast_as_it_is_told() {
    let program = host_sim!();
    for speed in [1_u32, 20] {
        let robot = ServedRobot::at_a_port(&program, &format!("--speed {speed}"));
        let mut host = robot.connect();
        let asked = Instant::now();
        let before = ask(&mut host, &NomadCommand::GetState).time_ms;
        let answered = Instant::now();
        sleep(ms(400));
        let least = answered.elapsed().as_millis() as u32 * speed;
        let passed = ask(&mut host, &NomadCommand::GetState).time_ms - before;
        let most = asked.elapsed().as_millis() as u32 * speed;
        // The robot reads the clock at intervals.
        let slack = 60 * speed;
        assert!(
            (least - slack..=most + slack).contains(&passed),
            "{passed}: {least} to {most}"
        );
    }
}

/// A program linked with the other library, byte by byte.
#[test]
fn a_program_of_the_simulators_server_finds_the_same_robot() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--protocol nserver --speed 20");
    let mut line = TcpStream::connect(&robot.place).expect("a server");
    line.set_read_timeout(Some(ANSWER_TIMEOUT))
        .expect("a time-out");
    let mut ask = |kind: u16, numbers: &[i32]| {
        let numbers = numbers.to_vec();
        let request = ServerMessage { kind, numbers };
        line.write_all(&request.to_bytes()).expect("a line");
        let (mut bytes, mut buffer) = (Vec::new(), [0; 4_096]);
        loop {
            if let Some(answer) = ServerMessage::take_from(&mut bytes) {
                return (answer.kind, answer.numbers);
            }
            let count = line.read(&mut buffer).expect("an answer in time");
            assert!(count > 0, "{request:?}");
            bytes.extend(&buffer[..count]);
        }
    };
    let port = robot
        .place
        .rsplit(':')
        .next()
        .and_then(|port| port.parse().ok());
    let connected = ask(102, &[1, 4_711]);
    assert_eq!(connected, (82, port.into_iter().collect::<Vec<i32>>()));
    ask(16, &[255, 255, 255, 255, 255, 0b1110, 0]);
    ask(26, &[5]);
    let (kind, state) = ask(13, &[100, 0, 0]);
    assert_eq!((kind, state[0], state[41], state.len()), (80, 200, 1, 49));
    let (_, state) = ask(39, &[1, 1, 1, 20]);
    assert!((state[34] - 100).abs() <= 1 && state[41] == 0, "{state:?}");
    let (kind, sonars) = ask(28, &[]);
    assert_eq!((kind, sonars.len()), (84, 17));
}
