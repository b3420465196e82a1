use super::*;
use crate::mask::WITH_SONAR;
use crate::{AxisMode, NomadCommand, ReadingGroup};
use arena::sonar::FIRING_ORDER;
use arena::world::{Point, Shape};

fn robot_in(world: World) -> SimulatedNomad {
    SimulatedNomad::new(world, SonarModel::Ideal, 1)
}

/// A wall `x` m ahead and one 3 m away on each side.
fn hall(x: f64) -> World {
    let corners = [(x, -3.0), (x, 3.0), (-9.0, 3.0), (-9.0, -3.0), (x, -3.0)];
    let points = corners.map(|(x, y)| Point::new(x, y)).to_vec();
    World::new("hall", Pose::default(), vec![Shape::Wall { points }]).unwrap()
}

fn robot() -> SimulatedNomad {
    robot_in(hall(9.0))
}

/// Executes a command and decodes its answer as a host does.
fn send(robot: &mut SimulatedNomad, command: &NomadCommand) -> NomadReadings {
    let packet = robot.execute(command).expect("an answer at once");
    assert_eq!(packet.kind, command.kind() as u8);
    let mut state = NomadReadings::default();
    state.take_payload(robot.mask(), &packet.payload).unwrap();
    state
}

fn state(robot: &mut SimulatedNomad) -> NomadReadings {
    send(robot, &NomadCommand::GetState)
}

#[test]
fn it_begins_at_zero_with_a_meter_to_go() {
    let mut robot = robot_in(World::paper().unwrap());
    robot.advance(640);
    let state = state(&mut robot);
    assert_eq!(
        (state.pose, state.velocity, state.motors),
        ([0; 4], [0; 3], 0)
    );
    assert_eq!((state.time_ms, state.bumpers), (640, 0));
    // At least 1 m ahead of the front.
    assert!(state.sonar[0] >= 40, "{:?}", state.sonar);
    assert_eq!(state.infrared, [15; 16]);
}

/// 200 = 20 in/s: reached in 20/30 s, held, and braked in 20/30 s after `st`.
#[test]
fn velocities_ramp_and_stop() {
    let mut robot = robot();
    send(&mut robot, &NomadCommand::Velocity([200, 0, 0]));
    robot.advance(500);
    assert_eq!(state(&mut robot).velocity, [150, 0, 0]);
    robot.advance(1_500);
    let rolling = state(&mut robot);
    assert_eq!((rolling.velocity, rolling.motors), ([200, 0, 0], 1));
    // 20/30 s at half the speed, then 4/3 s at full speed: 33.3 in.
    assert_eq!(rolling.pose, [333, 0, 0, 0]);
    send(&mut robot, &NomadCommand::Stop);
    robot.advance(680);
    let rest = state(&mut robot);
    assert_eq!((rest.velocity, rest.motors, rest.pose[0]), ([0; 3], 0, 400));
    // Velocities saturate; 450 = 45°/s.
    send(&mut robot, &NomadCommand::Velocity([0, -9_999, 9_999]));
    robot.advance(2_000);
    assert_eq!(state(&mut robot).velocity, [0, -450, 450]);
}

#[test]
fn moves_end_where_they_were_sent_at_the_speed_that_was_set() {
    let mut robot = robot();
    send(&mut robot, &NomadCommand::Speeds([100, 200, 450]));
    send(&mut robot, &NomadCommand::Accelerations([300, 300, 300]));
    // First the wheels turn across.
    send(&mut robot, &NomadCommand::Relative([0, 900, 0]));
    robot.advance(3_000);
    assert_eq!(state(&mut robot).velocity, [0, 200, 0]);
    robot.advance(4_000);
    send(&mut robot, &NomadCommand::Relative([200, 0, -900]));
    robot.advance(1_000);
    assert_eq!(state(&mut robot).velocity[0], 100);
    robot.advance(4_000);
    let there = state(&mut robot);
    assert_eq!((there.pose, there.motors), ([0, 200, 900, 2_700], 0));
    // Absolute angles are reached by the smaller turn.
    send(&mut robot, &NomadCommand::Absolute([200, 0, 3_500]));
    robot.advance(1_000);
    let turning = state(&mut robot);
    assert!(turning.velocity[1] < 0 && turning.velocity[2] > 0);
    robot.advance(9_000);
    assert_eq!(state(&mut robot).pose, [0, 200, 0, 3_500]);
}

#[test]
fn each_axis_moves_in_its_own_way() {
    let mut robot = robot();
    let axes = [
        (AxisMode::Velocity, 50),
        (AxisMode::Relative, 100),
        (AxisMode::Ignore, 7),
    ];
    send(&mut robot, &NomadCommand::Move(axes));
    robot.advance(3_000);
    let state = state(&mut robot);
    assert_eq!((state.velocity, state.motors), ([50, 0, 0], 1));
    assert_eq!(state.pose[2..], [100, 0]);
    let torque = NomadCommand::Move([(AxisMode::Torque, 1); 3]);
    assert_eq!(
        robot.execute(&torque).map(|packet| packet.kind),
        Some(Kind::Nak as u8)
    );
}

#[test]
fn a_silent_host_ends_the_motion() {
    let mut robot = robot();
    send(&mut robot, &NomadCommand::ConfigureTimeout(2));
    send(&mut robot, &NomadCommand::Velocity([100, 0, 0]));
    robot.advance(1_900);
    // Any command restarts the time-out.
    assert_eq!(state(&mut robot).velocity[0], 100);
    robot.advance(1_999);
    assert_eq!(robot.state().velocity[0], 100);
    // Braking from 10 in/s takes a third of a second.
    robot.advance(340);
    assert_eq!((robot.state().velocity[0], robot.state().motors), (0, 0));
    // 0 = never.
    send(&mut robot, &NomadCommand::ConfigureTimeout(0));
    send(&mut robot, &NomadCommand::Velocity([0, 0, 100]));
    robot.advance(60_000);
    assert_eq!(robot.state().velocity[2], 100);
}

#[test]
fn a_sonar_changes_when_it_fires_and_not_before() {
    let mut robot = robot_in(hall(3.0));
    robot.advance(640);
    send(&mut robot, &NomadCommand::Speeds([200, 450, 450]));
    send(&mut robot, &NomadCommand::Relative([400, 0, 0]));
    let mut last = robot.state().clone();
    let mut fired = Vec::new();
    for _ in 0..1_280 {
        robot.advance(1);
        let now = robot.state();
        for sensor in 0..16 {
            let changed = now.sonar_at[sensor].sensed_ms != last.sonar_at[sensor].sensed_ms;
            assert!(changed || now.sonar[sensor] == last.sonar[sensor]);
            if changed {
                fired.push(sensor);
            }
        }
        last = now.clone();
    }
    assert_eq!(fired, [FIRING_ORDER, FIRING_ORDER].concat());
    // The attached pose is that of the reading.
    let front = last.sonar_at[0];
    let face = 3.0 - 0.2305 - f64::from(front.pose[0]) * 0.00254;
    assert_eq!(i32::from(last.sonar[0]), (face / 0.0254).round() as i32);
    assert!(front.velocity[0] > 0 && front.pose[0] < last.pose[0]);
}

#[test]
fn another_order_fires_others_and_none_leaves_them_as_they_were() {
    let mut robot = robot_in(hall(3.0));
    let mut order = [255; 16];
    order[..3].copy_from_slice(&[0, 1, 15]);
    send(&mut robot, &NomadCommand::ConfigureSonar { rate: 5, order });
    robot.advance(700);
    let sensed = |robot: &SimulatedNomad| -> Vec<_> {
        let at = robot.state().sonar_at;
        (0..16).filter(|&sensor| at[sensor].sensed_ms > 0).collect()
    };
    assert_eq!(sensed(&robot), [0, 1, 15]);
    // 20 ms are enough for 3.4 m, 4 ms are not for 2.8 m.
    assert_eq!(robot.state().sonar[0], 109);
    send(&mut robot, &NomadCommand::ConfigureSonar { rate: 1, order });
    robot.advance(100);
    assert_eq!(robot.state().sonar[0], 255);
    let order = [255; 16];
    send(&mut robot, &NomadCommand::ConfigureSonar { rate: 0, order });
    let before = robot.state().sonar_at;
    robot.advance(1_000);
    assert_eq!(robot.state().sonar_at, before);
}

#[test]
fn masks_make_packets_shorter_and_groups_ignore_them() {
    let mut robot = robot();
    robot.advance(700);
    let mask = StateMask {
        sonar: 1,
        attached: WITH_SONAR,
        ..StateMask::NONE
    };
    let command = NomadCommand::Communicate(mask);
    let packet = robot.execute(&command).unwrap();
    assert_eq!(packet.payload.len(), 1 + 36 + 7);
    let all = robot
        .execute(&NomadCommand::Get(ReadingGroup::Sonar))
        .unwrap();
    assert_eq!(all.payload.len(), 16 + 16 * 36 + 4);
    let pose = robot
        .execute(&NomadCommand::Get(ReadingGroup::Pose))
        .unwrap();
    assert_eq!(pose.payload, [0; 8]);
}

#[test]
fn a_wall_is_detected_by_bumper_sonar_and_infrared() {
    let mut robot = robot_in(hall(1.0));
    send(&mut robot, &NomadCommand::Relative([900, 0, 0]));
    robot.advance(5_000);
    let state = state(&mut robot);
    assert_eq!((state.bumpers, state.motors), (1, 0));
    // 38.5 mm between face and wall: the disc is wider by that.
    assert_eq!(
        (state.sonar[0], state.infrared[0], state.infrared[8]),
        (2, 2, 15)
    );
    assert_eq!(robot.ground_truth().contacts, 1);
    assert!((robot.ground_truth().traveled_m - (1.0 - 0.269)).abs() < 1e-6);
}

#[test]
fn positions_and_angles_are_what_the_host_says_they_are() {
    let mut robot = robot();
    send(&mut robot, &NomadCommand::DefinePosition([1_000, -500]));
    let state = send(&mut robot, &NomadCommand::DefineAngles([900, 1_800]));
    assert_eq!(state.pose, [1_000, -500, 900, 1_800]);
    send(&mut robot, &NomadCommand::Relative([100, 0, 0]));
    robot.advance(3_000);
    let pose = send(&mut robot, &NomadCommand::GetState).pose;
    assert_eq!(pose, [1_000, -400, 900, 1_800]);
    // Zero is the base's front, whatever the angles were.
    send(&mut robot, &NomadCommand::Relative([0, 450, -450]));
    robot.advance(5_000);
    assert_eq!(robot.execute(&NomadCommand::Zero), None);
    let mut waited_ms = 0;
    let packet = loop {
        robot.advance(1);
        waited_ms += 1;
        if let Some(packet) = robot.answer() {
            break packet;
        }
    };
    // 45° at 30°/s²: 2·√(45/30) s.
    assert!((2_440..2_460).contains(&waited_ms), "{waited_ms}");
    assert_eq!(packet.kind, Kind::Zr as u8);
    assert_eq!(send(&mut robot, &NomadCommand::GetState).pose, [0; 4]);
    assert_eq!(robot.pose().heading, 0.0);
}

#[test]
fn waiting_ends_with_the_motion_or_with_patience() {
    let wait = |axes, timeout_s| NomadCommand::WaitForStop { axes, timeout_s };
    let mut robot = robot();
    // Nothing to wait for.
    assert!(robot.execute(&wait([true; 3], 20)).is_some());
    send(&mut robot, &NomadCommand::Velocity([50, 0, 0]));
    assert!(robot.execute(&wait([false, true, true], 20)).is_some());
    assert_eq!(robot.execute(&wait([true, false, false], 2)), None);
    robot.advance(1_999);
    assert_eq!(robot.answer(), None);
    robot.advance(1);
    assert!(robot.answer().is_some() && robot.answer().is_none());
    assert_eq!(robot.state().motors, 1);
}

/// The same commands at the same times give the same bytes.
#[test]
fn the_seed_is_all_there_is_to_chance() {
    let drive = |seed: u64| {
        let mut robot = SimulatedNomad::new(World::paper().unwrap(), SonarModel::Harsh, seed);
        robot.execute(&NomadCommand::Velocity([100, 100, 0]));
        robot.advance(3_000);
        robot.execute(&NomadCommand::GetState)
    };
    assert_eq!(drive(3), drive(3));
    assert_ne!(drive(3), drive(4));
}

#[test]
fn blocked_wheels_leave_the_robot_where_it_is_while_its_motor_runs() {
    let mut robot = robot().with_wheels_blocked_after(0.5);
    send(&mut robot, &NomadCommand::Velocity([100, 0, 0]));
    robot.advance(4_000);
    let blocked = state(&mut robot);
    assert_eq!((blocked.motors, blocked.velocity), (1, [0; 3]));
    // 0.5 m are 196.9 tenths of an inch.
    assert!((197..=198).contains(&blocked.pose[0]), "{:?}", blocked.pose);
    send(&mut robot, &NomadCommand::Velocity([0, 450, 0]));
    robot.advance(2_000);
    let turning = state(&mut robot);
    assert_eq!((turning.motors, turning.velocity), (2, [0, 450, 0]));
    assert_eq!(turning.pose[0], blocked.pose[0]);
}
