//! How much faster two cores are than one: 256 episodes by one thread and by two, in turns, so that
//! what else the machine does falls on both.

use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use sim::behavior::Behavior;
use sim::episode::{self, Setup};
use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 20;

fn main() {
    let worlds: Vec<_> = (1..=256).map(World::random).collect();
    let [one, two] = [1, 2].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
    });
    let mut rounds: Vec<_> = (0..ROUNDS)
        .map(|_| [&one, &two].map(|pool| seconds(pool, &worlds)))
        .collect();
    let best = |threads: usize| {
        rounds
            .iter()
            .map(|round| round[threads])
            .fold(f64::INFINITY, f64::min)
    };
    let by_best = best(0) / best(1);
    let ratio = |round: &[f64; 2]| round[0] / round[1];
    rounds.sort_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    let [quarter, half, three] = [1, 2, 3].map(|part| ratio(&rounds[part * ROUNDS / 4]));
    println!(
        "two cores: {by_best:.2} times as fast by the best of {ROUNDS} rounds, {half:.2} by the median round, {quarter:.2} to {three:.2} in the \
         middle half of them"
    );
}

fn seconds(pool: &ThreadPool, worlds: &[World]) -> f64 {
    let setup = Setup {
        config: Config::recommended(),
        preset: "default".to_owned(),
        behavior: Behavior::Avoid,
        explore_moves: 100,
        steps: 1_000,
        seed: 1,
        sonar: SonarModel::Ideal,
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    };
    let contacts = |world| {
        let episode = episode::run(world, &setup, |_, _, _| {});
        episode.expect("it runs").report.contacts
    };
    let begun = Instant::now();
    black_box(pool.install(|| worlds.par_iter().map(contacts).sum::<u32>()));
    begun.elapsed().as_secs_f64()
}
