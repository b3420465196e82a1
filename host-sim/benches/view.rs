//! What a look at a seeking robot costs its loop (ten times a second while somebody watches), and
//! the viewers' tasks.

use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use remote::link::ControllerPlace;
use sim::behavior::Behavior;
use sim::episode::Setup;
use view::command::PageCommand;
use view::{Simulator, SimulatorStart, StepOutcome, ViewSource};

fn seeking() -> Simulator {
    let config = Config::recommended();
    let start = SimulatorStart {
        world: World::random(1),
        named: "random:1".to_owned(),
        setup: Setup {
            config: config.clone(),
            preset: "default".to_owned(),
            behavior: Behavior::Avoid,
            explore_moves: 100,
            steps: 1,
            seed: 1,
            sonar: SonarModel::Ideal,
            turret: TurretMode::Held,
            robot: None,
            set_down: None,
            faults: Vec::new(),
            goal: None,
            second_robot: false,
            record: false,
        },
        whole: config,
        presets: Vec::new(),
    };
    let mut robot =
        Simulator::new(start, ControllerPlace::Host, None).expect("a mind in this process");
    for order in [PageCommand::Explore, PageCommand::Learn] {
        robot.execute(&order).expect("it is done");
        while robot.step() != StepOutcome::Idle {}
    }
    robot.execute(&PageCommand::Seek).expect("it seeks");
    for _ in 0..1_000 {
        robot.step();
    }
    robot
}

fn benches(c: &mut Criterion) {
    let mut robot = seeking();
    c.bench_function("a step", |b| b.iter(|| robot.step()));
    c.bench_function("a step and a snapshot", |b| {
        b.iter(|| {
            robot.step();
            robot.snapshot().into_parts()
        });
    });
    c.bench_function("the texts of a snapshot", |b| {
        let snapshot = |robot: &mut Simulator| {
            robot.step();
            robot.snapshot().into_parts()
        };
        let texts = |parts: Vec<_>| parts.iter().map(text_len).sum::<usize>();
        b.iter_batched(|| snapshot(&mut robot), texts, BatchSize::SmallInput);
    });
}

fn text_len(part: &std::sync::Arc<dyn view::snapshot::PartMessage>) -> usize {
    part.text().len()
}

criterion_group!(all, benches);
criterion_main!(all);
