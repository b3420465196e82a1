//! Whole robot steps per second: sense, mind and motion in a room of 52 surfaces.

use amp::config::Config;
use amp::controller::{Command, Event};
use amp::units::Millis;
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use host_sim::episode::{Body, drive_pilot};
use host_sim::pilot::{Mind, Pilot};
use host_sim::robot::TurretMode;
use host_sim::sonar::SonarModel;
use host_sim::world::World;

const STEPS: u32 = 1_000;

fn body(world: &World, sonar: SonarModel) -> Body<'_> {
    Body::new(world, sonar, TurretMode::Held, 1)
}

/// Explores with 100 moves and learns: what an episode costs before its first step.
fn set_up(world: &World, config: &Config<16>) -> Mind {
    let mut mind = Mind::new(config.clone());
    let tell = |mind: &mut Mind, event| mind.handle(Millis::from_ms(0), event);
    tell(
        &mut mind,
        Event::Command(Command::Explore {
            moves: 100,
            seed: 1,
        }),
    );
    drive_pilot(world, &mut mind, body(world, SonarModel::Ideal), u32::MAX).expect("it explores");
    tell(&mut mind, Event::Command(Command::Learn));
    while !tell(&mut mind, Event::Tick).mode_changed {}
    tell(
        &mut mind,
        Event::Command(Command::Seek(amp::goal::Goal::avoiding(config))),
    );
    mind
}

fn benches(c: &mut Criterion) {
    let world = World::random(1);
    let config = Config::recommended();
    c.bench_function("set-up: 100 moves, two maps", |b| {
        b.iter(|| set_up(&world, &config))
    });

    let mut group = c.benchmark_group("steps");
    group.throughput(Throughput::Elements(u64::from(STEPS)));
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        group.bench_function(sonar.name(), |b| {
            let drive = |mut mind| drive_pilot(&world, &mut mind, body(&world, sonar), STEPS);
            b.iter_batched(|| set_up(&world, &config), drive, BatchSize::LargeInput);
        });
    }
}

criterion_group!(all, benches);
criterion_main!(all);
