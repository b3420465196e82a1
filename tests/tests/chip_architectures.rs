//! One episode on three emulated architectures: messages, maps and memory equal those of the host,
//! bit for bit.

use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use remote::link::{Machine, build_image};
use sim::episode::Body;
use tests::chip::{EmulatedChip, SESSION};
use tests::twin::NodeTwin;

use amp::wire::message::{Clock, GoalSpec, RobotCommand};

/// The room, and the seed of the exploration.
const ROOM: u64 = 3;
/// Random moves.
const MOVES: u16 = 100;
/// Decisions toward the goal.
const STEPS: usize = 60;
/// The stack's region on the micro:bit: see `microbit.x`.
const MICROBIT_STACK_BYTES: u32 = 4_608;

/// Result of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct EpisodeResult {
    maps_crc: u32,
    memory_crc: u32,
}

fn start(machine: &Machine) -> EmulatedChip {
    let image = build_image(machine).unwrap_or_else(|error| panic!("{error}"));
    EmulatedChip::start_on(machine, &image)
}

/// Explores, learns, seeks; compares every byte with the node on the host. Also returns the peak of
/// the stack.
fn episode(machine: &Machine) -> (EpisodeResult, u32) {
    let world = World::random(ROOM);
    let mut body = Body::new(&world, SonarModel::Ideal, TurretMode::Held, ROOM);
    // Without lag, because small chips have short queues.
    let mut twin: NodeTwin = NodeTwin::with(start(machine), 0, true);
    twin.command(RobotCommand::Explore {
        moves: MOVES,
        seed: ROOM,
    });
    twin.finish(&mut body);
    twin.learn();
    twin.seek(GoalSpec::Avoid);
    twin.decide(&mut body, STEPS);
    let knowledge = twin.compare_knowledge();
    assert!(knowledge >= 6_000, "{knowledge} bytes of knowledge");
    assert!(twin.compared() >= 25_000, "{} bytes", twin.compared());
    let [maps_crc, memory_crc] = twin.checksums();
    let bytes = twin.compared();
    let stack_peak_bytes = twin.stack_peak_bytes();
    println!(
        "{}: {bytes} bytes the same; maps {maps_crc:08x}, memory {memory_crc:08x}; peak of the stack {stack_peak_bytes} bytes",
        machine.target
    );
    let outcome = EpisodeResult {
        maps_crc,
        memory_crc,
    };
    (outcome, stack_peak_bytes)
}

#[test]
fn three_architectures_send_the_same_bytes() {
    let (cortex_m4, _) = episode(&Machine::OLIMEX_H405);
    let (cortex_m0, stack_peak_bytes) = episode(&Machine::MICROBIT);
    let (riscv32, _) = episode(&Machine::RISCV32_VIRT);
    assert_eq!(cortex_m0, cortex_m4);
    assert_eq!(riscv32, cortex_m4);
    assert!(
        (500..MICROBIT_STACK_BYTES).contains(&stack_peak_bytes),
        "{stack_peak_bytes} bytes of stack on the micro:bit"
    );
}

/// Its link uses another port of the chip.
#[test]
fn the_feather_answers_at_its_own_port() {
    let mut chip = start(&Machine::FEATHER_F405);
    let hello = chip.open(SESSION, Clock::Device);
    assert_eq!(hello.dimensions, tests::chip::dimensions());
}
