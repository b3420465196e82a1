//! Whole robot steps per second: sense, mind and motion, in rooms of few and of very many surfaces.
//!
//! With the argument `rounds` many short rounds of two rooms, with and without the shield, in turns
//! instead: on a machine that is not always there for one the best of them tells what the code
//! does, and the median what one gets.

use amp::config::Config;
use amp::controller::{Command, Event};
use amp::units::Millis;
use arena::noise::Noise;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::{Point, Pose, Shape, World};
use criterion::{BatchSize, Criterion, Throughput, criterion_group};
use sim::episode::{Body, drive_pilot};
use sim::pilot::{LocalController, Pilot};
use std::hint::black_box;
use std::time::Instant;

const STEPS: u32 = 1_000;
const ROUNDS: usize = 200;
/// Floor per box, m²: as in the random rooms.
const AREA_PER_BOX_M2: f64 = 64.0 / 12.0;

fn body(world: &World, sonar: SonarModel) -> Body<'_> {
    Body::new(world, sonar, TurretMode::Held, 1)
}

/// A square room `side` m wide with boxes as in the random rooms, `scale` times their size:
/// `segments` straight pieces.
fn hall(segments: usize, side: f64, scale: f64) -> World {
    let mut noise = Noise::new(1);
    let half = side / 2.0;
    let mut shapes = vec![Shape::room(Point::new(half, half))];
    while shapes.len() <= (segments - 4) / 4 {
        let mut size = || 2.0 * scale * noise.uniform_in(0.15, 0.5);
        let size = Point::new(size(), size());
        let mut place = |size: f64| noise.uniform_in(size / 2.0 - half, half - size / 2.0);
        let center = Point::new(place(size.x), place(size.y));
        if center.length() > 1.0 + scale {
            let angle = 0.0;
            shapes.push(Shape::Box {
                center,
                size,
                angle,
            });
        }
    }
    World::new(format!("hall of {segments}"), Pose::default(), shapes).expect("a sound world")
}

/// The hall of so many pieces that is as crowded as a random room.
fn wide(segments: usize) -> World {
    hall(
        segments,
        (segments as f64 / 4.0 * AREA_PER_BOX_M2).sqrt(),
        1.0,
    )
}

/// Explores with 100 moves and learns: what an episode costs before its first step.
fn set_up(world: &World, config: &Config<16>) -> LocalController {
    let mut mind = LocalController::new(config.clone());
    let tell = |mind: &mut LocalController, event| mind.handle(Millis::from_ms(0), event);
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

fn steps(c: &mut Criterion) {
    let config = Config::recommended();
    let room = World::random(1);
    c.bench_function("set-up: 100 moves, two maps", |b| {
        b.iter(|| set_up(&room, &config))
    });

    let mut group = c.benchmark_group("steps");
    group
        .throughput(Throughput::Elements(u64::from(STEPS)))
        .sample_size(20);
    let worlds = [
        ("52", room),
        ("80", wide(80)),
        ("800", wide(800)),
        ("8000", wide(8_000)),
        ("8000 in 8 m", hall(8_000, 8.0, 0.07)),
    ];
    for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
        for (segments, world) in &worlds {
            group.bench_function(format!("{}, {segments} segments", sonar.name()), |b| {
                let drive = |mut mind| drive_pilot(world, &mut mind, body(world, sonar), STEPS);
                b.iter_batched(|| set_up(world, &config), drive, BatchSize::LargeInput);
            });
        }
    }
}

/// Prints the steps per second of each of the eight by the best round and by the median one.
fn rounds() {
    let on = Config::recommended();
    let mut off = on.clone();
    off.shield = None;
    let worlds = [("80", wide(80)), ("8000", wide(8_000))];
    let mut runs = Vec::new();
    for (shield, config) in [("on", &on), ("off", &off)] {
        for sonar in [SonarModel::Ideal, SonarModel::Nomad] {
            for (segments, world) in &worlds {
                let name = format!("shield {shield}, {}, {segments} segments", sonar.name());
                let learned = set_up(world, config);
                runs.push((name, config, sonar, world, learned, Vec::new()));
            }
        }
    }
    for _ in 0..ROUNDS {
        for (_, config, sonar, world, learned, paces) in &mut runs {
            let mut mind = LocalController::with_state((*config).clone(), learned.state().clone());
            let begun = Instant::now();
            black_box(drive_pilot(world, &mut mind, body(world, *sonar), STEPS))
                .expect("it drives");
            paces.push(f64::from(STEPS) / begun.elapsed().as_secs_f64());
        }
    }
    for (name, .., mut paces) in runs {
        paces.sort_by(f64::total_cmp);
        let (best, median) = (paces[ROUNDS - 1], paces[ROUNDS / 2]);
        println!(
            "rounds: {name}: {best:.0} steps/s by the best of {ROUNDS}, {median:.0} by the median"
        );
    }
}

criterion_group!(all, steps);

fn main() {
    if std::env::args().any(|argument| argument == "rounds") {
        return rounds();
    }
    all();
    Criterion::default().configure_from_args().final_summary();
}
