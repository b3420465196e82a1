//! A memory of places on the chip: the firmware in emulated chips, which thinks in slices between
//! events, leads a robot as the crate on this machine does, to the byte.

use amp::config::MAX_CONFIG;
use amp::goal::Name;
use amp::places::Aim;
use amp::units::Displacement;
use amp::wire::message::{
    Clock, DeviceMessage, FlashOperation, GoalSpec, HostMessage, Report, RobotCommand, TransferPart,
};
use arena::robot_model::RobotModel;
use arena::sonar::SonarModel;
use arena::world::World;
use firmware::AnyBodyWithPlaces;
use remote::link::{Machine, build_image};
use sim::episode::Body;
use sim::robot::{AnyRobot, Ranges};
use tests::chip::{EmulatedChip, SESSION};
use tests::twin::NodeTwin;
use tests::{host_sim, words};

/// The world, and the seed of everything.
const WORLD: u64 = 3;
/// Decisions towards each goal.
const DECISIONS: usize = 40;
/// It is nowhere: where the robot comes no nearer it is led to where it has not been.
const NOWHERE: [u8; 16] = [
    200, 20, 200, 20, 200, 20, 200, 20, 200, 20, 200, 20, 200, 20, 200, 20,
];

/// Explores, learns, drives away, is led, seeks its nest; returns the peak of the stack.
fn episode(machine: &Machine) -> u32 {
    let model = RobotModel::builtin("p3dx").expect("built in");
    let robot = AnyRobot::new(model, Ranges::Own, true).expect("16 sensors");
    let world = World::random2(WORLD);
    let image = build_image(machine).unwrap_or_else(|error| panic!("{error}"));
    let chip = EmulatedChip::start_on(machine, &image);
    let mut twin = NodeTwin::<AnyBodyWithPlaces>::of_robot(chip, &robot, true);
    let mut body = Body::of_robot(&world, &robot, SonarModel::Ideal, WORLD);
    twin.command(RobotCommand::Explore {
        moves: 40,
        seed: WORLD,
    });
    twin.finish(&mut body);
    twin.learn();
    let nest = Name::new("nest").expect("a name");
    twin.command(RobotCommand::Goal(GoalSpec::Perceived));
    twin.save_goal(nest);
    twin.seek(GoalSpec::Avoid);
    twin.decide(&mut body, DECISIONS);
    assert_eq!(twin.led_decisions(), 0);
    for goal in [GoalSpec::Situation(NOWHERE), GoalSpec::Saved(nest)] {
        twin.seek(goal);
        twin.decide(&mut body, DECISIONS);
    }
    let places = twin.local().body().turret().places().positions().len();
    twin.command(RobotCommand::Lead(Some(Aim::Position(Displacement::ZERO))));
    twin.seek(GoalSpec::Avoid);
    twin.decide(&mut body, DECISIONS);
    let off_m = body.pose().position.distance(world.start().position);
    assert!(off_m < 0.3, "{off_m} m from home");
    twin.command(RobotCommand::Stop);
    let known = twin.compare_knowledge();
    assert!(known > 56 * places, "{known} bytes");
    twin.command(RobotCommand::SetDown);
    twin.seek(GoalSpec::Avoid);
    twin.decide(&mut body, 2);
    let lost = twin.local().body().turret().places();
    let begins_anew = lost.positions().len() < 3;
    assert!(begins_anew || lost.aside().is_some(), "it was carried");
    let (slices, bytes) = (twin.longest_thought(), twin.compared());
    let peak = twin.stack_peak_bytes();
    println!(
        "{}: {bytes} bytes the same; {places} places; a decision takes {slices} slices at most; peak of the stack {peak} bytes",
        machine.target
    );
    // It hears walls in 32, and thinks on.
    assert!(slices > 100, "{slices} slices");
    assert!(twin.led_decisions() > 10, "{}", twin.led_decisions());
    assert!(places > 10, "{places} places");
    assert!(bytes >= 20_000, "{bytes} bytes");
    peak
}

#[test]
fn a_pioneer_led_by_its_places_is_the_same_to_the_byte() {
    let peak = episode(&Machine::OLIMEX_H405_PLACES);
    assert!((200..=4_608).contains(&peak), "{peak} bytes of stack");
}

/// A part of what the chip knows.
fn read(chip: &mut EmulatedChip, part: TransferPart) -> Vec<u8> {
    let mut whole = Vec::new();
    loop {
        let offset = whole.len() as u16;
        let said = chip.ask(&HostMessage::Read { part, offset });
        match said.first().map(|report| &report.message) {
            Some(DeviceMessage::Chunk { total, bytes, .. }) => {
                whole.extend_from_slice(bytes);
                if whole.len() >= usize::from(*total) {
                    return whole;
                }
            }
            other => panic!("{other:?}"),
        }
    }
}

/// Full of places, it saves them in its flash, is reset and knows them again.
#[test]
fn places_are_known_after_a_reset() {
    let machine = &Machine::OLIMEX_H405_PLACES;
    let image = build_image(machine).unwrap_or_else(|error| panic!("{error}"));
    let mut chip = EmulatedChip::start_on(machine, &image);
    chip.open(SESSION, Clock::Device);
    let mut write = |part, offset: usize, bytes: &[u8], last| {
        let said = chip.ask(&HostMessage::Write {
            part,
            offset: offset as u16,
            bytes: bytes.iter().copied().collect(),
            last,
        });
        let is_done = |report: &Report<16>| matches!(report.message, DeviceMessage::Done { .. });
        assert!(said.iter().all(is_done), "{said:?}");
    };
    let model = RobotModel::builtin("p3dx").expect("built in");
    let robot = AnyRobot::new(model, Ranges::Own, true).expect("16 sensors");
    let mut buffer = [0; MAX_CONFIG];
    let body = robot.body().to_bytes(&mut buffer).to_vec();
    for (index, piece) in body.chunks(160).enumerate() {
        write(TransferPart::Body, 160 * index, piece, false);
    }
    write(TransferPart::Body, body.len(), &[], true);
    // A head and 256 places, of 56 bytes each.
    let mut places: Vec<u8> = (0..56 * 257).map(|i| (i % 251) as u8).collect();
    // There is room for more, and the robot is at its start.
    places[33..56].fill(0);
    for (index, piece) in places.chunks(112).enumerate() {
        write(TransferPart::Places, 112 * index, piece, false);
    }
    assert!(read(&mut chip, TransferPart::Places) == places);
    let said = chip.ask(&HostMessage::Flash(FlashOperation::Save));
    println!("{said:?}");
    let busy_ms = said.iter().find_map(|report| match report.message {
        DeviceMessage::Busy { ms } => Some(ms),
        _ => None,
    });
    // 24 240 bytes at 100 us a word.
    assert_eq!(busy_ms, Some(606));
    chip.raw(b"\0!panic\0");
    chip.wait(|header, report| {
        let is_start = header.session == 0 && matches!(report.message, DeviceMessage::Hello(_));
        is_start.then_some(())
    });
    chip.open(SESSION + 1, Clock::Device);
    assert!(read(&mut chip, TransferPart::Places) == places);
    assert!(read(&mut chip, TransferPart::Body) == body);
}

/// What a robot of the simulator knows is written to an emulated chip.
#[test]
fn a_file_of_the_simulator_is_for_the_chip() {
    let program = host_sim!();
    let run = "run --robot p3dx --ranges nomad --behavior home --tour 100 --world office --json";
    let _ = program.ok(&format!("{run} --save robot.mind"));
    let link = "link --to qemu --program";
    let _ = program.ok(&format!("{link} places upload robot.mind"));
    let _ = program.ok(&format!("{link} any-body upload robot.mind"));
    let refused = program.run(&words(&format!("{link} ring upload robot.mind")));
    let why = "its firmware is for a ring on a turret";
    let is_named = refused.stderr.contains(why);
    assert!(refused.code == Some(2) && is_named, "{refused:?}");
}

/// Home, and away again: the program drives the emulated chip as it drives its own controller.
#[test]
fn an_emulated_chip_comes_home_as_this_machine_does() {
    let program = host_sim!();
    let run = "run --explore 60 --world random2:3 --steps 20 --json";
    for flags in [
        "--robot p3dx --ranges nomad --behavior home --tour 30",
        "--robot p3dx --behavior nest --tour 30 --turned",
        "--behavior nest",
    ] {
        let here = program.ok(&format!("{run} {flags}"));
        assert_eq!(program.ok(&format!("{run} {flags} --mind qemu")), here);
        assert!(here.contains("\"steps\":"), "{here}");
    }
}

#[test]
fn and_on_a_riscv() {
    episode(&Machine::RISCV32_VIRT_PLACES);
}
