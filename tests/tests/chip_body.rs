//! A robot whose sensors stand on its body: the firmware in emulated chips finds where they look,
//! learns and drives as the crate on this machine does, to the byte.

use amp::wire::message::{GoalSpec, RobotCommand};
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::World;
use firmware::AnyBody;
use remote::link::{Machine, build_image};
use sim::episode::Body;
use sim::robot::{AnyRobot, Origin, Ranges};
use tests::chip::EmulatedChip;
use tests::twin::NodeTwin;

/// The room, and the seed of everything.
const ROOM: u64 = 3;
/// Decisions toward the goal.
const STEPS: usize = 30;

/// A Pioneer 3-DX with its wires permuted, whose controller is told nothing of its geometry.
fn pioneer() -> AnyRobot {
    let model = RobotModel::builtin("p3dx").expect("built in");
    let robot = AnyRobot::new(model, Ranges::Own, true).expect("16 sensors");
    let robot = robot.scrambled(1).with_geometry(Origin::Learned);
    robot.expect("it turns")
}

/// Finds its sensors, explores, learns, seeks; returns the peak of the stack.
fn episode(machine: &Machine) -> u32 {
    let robot = pioneer();
    let world = World::random(ROOM);
    let image = build_image(machine).unwrap_or_else(|error| panic!("{error}"));
    let chip = EmulatedChip::start_on(machine, &image);
    let mut twin = NodeTwin::<AnyBody>::of_robot(chip, &robot, false);
    let mut body = Body::of_robot(&world, &robot, SonarModel::Ideal, ROOM);
    twin.command(RobotCommand::Calibrate {
        moves: 20,
        seed: ROOM,
        actuators: false,
    });
    twin.finish(&mut body);
    twin.think();
    twin.command(RobotCommand::Explore {
        moves: 30,
        seed: ROOM,
    });
    twin.finish(&mut body);
    twin.learn();
    let [median_deg, worst_deg] = robot
        .bearing_errors_deg(twin.local().body().known())
        .expect("sensors were found");
    assert!(median_deg < 5.0, "{median_deg}°, at worst {worst_deg}°");
    twin.seek(GoalSpec::Avoid);
    twin.decide(&mut body, STEPS);
    let knowledge = twin.compare_knowledge();
    assert!(knowledge >= 4_000, "{knowledge} bytes of knowledge");
    assert!(twin.compared() >= 25_000, "{} bytes", twin.compared());
    let (bytes, peak) = (twin.compared(), twin.stack_peak_bytes());
    println!(
        "{}: {bytes} bytes the same; bearings off by {median_deg:.1}° (median), {worst_deg:.1}° (worst); peak of the stack {peak} bytes",
        machine.target
    );
    peak
}

#[test]
fn a_pioneer_that_finds_its_sensors_is_the_same_to_the_byte() {
    let peak = episode(&Machine::OLIMEX_H405_ANY_BODY);
    assert!((200..=4_608).contains(&peak), "{peak} bytes of stack");
}

#[test]
fn and_on_a_riscv() {
    episode(&Machine::RISCV32_VIRT_ANY_BODY);
}
