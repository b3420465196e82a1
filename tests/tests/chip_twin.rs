//! The firmware in the emulated chip equals the crate on this machine: every sent byte and the
//! whole state.

use amp::config::Config;
use amp::goal::{Goal, Side};
use amp::units::Range;
use amp::wire::message::{GoalSpec, RobotCommand};
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use sim::episode::Body;
use tests::twin::NodeTwin;

/// The goal in each room: free space, both goals in the frame of travel, a sought place.
fn goal(room: u64) -> GoalSpec<16> {
    let config = Config::recommended();
    let range = Range::from_mm;
    match room {
        2 => GoalSpec::Components(Goal::wall(Side::Right, range(600), &config)),
        3 => GoalSpec::Components(Goal::passing(Side::Right, range(1_500), &config)),
        4 => GoalSpec::Situation([100; 16]),
        5 => GoalSpec::Components(Goal::following(range(340), &config)),
        _ => GoalSpec::Avoid,
    }
}

/// Explores a hundred moves, learns, seeks a thousand steps.
fn episode(room: u64, sonar: SonarModel, steps: usize) {
    let world = World::random(room);
    let mut body = Body::new(&world, sonar, TurretMode::Held, room);
    let mut twin = NodeTwin::new(sonar == SonarModel::Ideal);
    twin.command(RobotCommand::Explore {
        moves: 100,
        seed: room,
    });
    twin.finish(&mut body);
    twin.learn();
    let maps = twin.compare_knowledge();
    twin.seek(goal(room));
    twin.decide(&mut body, steps);
    let knowledge = twin.compare_knowledge();
    assert!(maps >= 6_000 && knowledge >= 6_000, "{maps} {knowledge}");
    let peak = twin.stack_peak_bytes();
    println!(
        "room {room}: {} bytes the same; peak of the stack {peak} bytes",
        twin.compared()
    );
    assert!((200..=4_096).contains(&peak), "{peak} bytes of stack");
}

#[test]
fn five_rooms_are_the_same_to_the_byte() {
    for room in 1..=5 {
        episode(room, SonarModel::Ideal, 1_000);
    }
}

/// Echo by echo, with motions that are shortened while they run.
#[test]
fn a_room_with_noisy_sonars_is_the_same_to_the_byte() {
    episode(6, SonarModel::Nomad, 60);
}
