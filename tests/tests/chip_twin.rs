//! The firmware in the emulated chip and the same crate on this machine: every byte they say and everything they know is
//! the same.

use amp::wire::message::Order;
use host_sim::episode::Body;
use host_sim::robot::TurretMode;
use host_sim::sonar::SonarModel;
use host_sim::world::World;
use tests::twin::Twin;

/// Explores a hundred moves, learns, seeks a thousand steps.
fn episode(room: u64, sonar: SonarModel, steps: usize) {
    let world = World::random(room);
    let mut body = Body::new(&world, sonar, TurretMode::Held, room);
    let mut twin = Twin::new(sonar == SonarModel::Ideal);
    twin.order(Order::Explore {
        moves: 100,
        seed: room,
    });
    while !body.advance(&mut twin).mode_changed {}
    twin.learn();
    let maps = twin.compare_knowledge();
    twin.seek();
    let mut decisions = 0;
    while decisions < steps {
        let happened = body.advance(&mut twin);
        decisions += usize::from(happened.decision.is_some());
        assert!(!happened.mode_changed, "it stopped");
    }
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

/// Echo by echo, with motions shortened on the way.
#[test]
fn a_room_with_noisy_sonars_is_the_same_to_the_byte() {
    episode(6, SonarModel::Nomad, 60);
}
