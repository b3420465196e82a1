//! How much faster two cores are than one: 64 episodes by one thread and by two, in turns, so that what else the machine does
//! falls on both.

use amp::config::Config;
use host_sim::episode::{self, Setup};
use host_sim::robot::TurretMode;
use host_sim::scenes::Behavior;
use host_sim::sonar::SonarModel;
use host_sim::world::World;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 25;

fn main() {
    let worlds: Vec<_> = (1..=64).map(World::random).collect();
    let [one, two] = [1, 2].map(|threads| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
    });
    let mut times_as_fast: Vec<_> = (0..ROUNDS)
        .map(|_| seconds(&one, &worlds) / seconds(&two, &worlds))
        .collect();
    times_as_fast.sort_by(f64::total_cmp);
    let part = |share: f64| times_as_fast[(share * ROUNDS as f64) as usize];
    let [quarter, half, three] = [0.25, 0.5, 0.75].map(part);
    println!(
        "two cores: {half:.2} times as fast (half of {ROUNDS} rounds: {quarter:.2} to {three:.2})"
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
        set_down: None,
        faults: Vec::new(),
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
