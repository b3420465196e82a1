//! Maps on the host: look-ups and training of 16 neurons with 16 components, by the map of fixed size that thinks for the
//! robot and by the one of any size behind `host-sim som`.

use amp::fixed::{Mask, Scalar as _, Weight};
use amp::som::neighborhood::Update;
use amp::som::{Decay, Grid, Neighborhood, Schedule, Som};
use arena::noise::Noise;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use datasets::som::train::{Order, Training, start_at_samples, train};
use std::hint::black_box;

const SAMPLES: usize = 1_000;

/// Uniform in [0, 1), as perceptions are.
fn samples(noise: &mut Noise) -> Vec<[Weight; 16]> {
    let mut sample = || std::array::from_fn(|_| Weight::from_num(noise.uniform()));
    (0..SAMPLES).map(|_| sample()).collect()
}

fn maps(c: &mut Criterion) {
    let mut noise = Noise::new(1);
    let samples = samples(&mut noise);
    let flat: Vec<_> = samples
        .iter()
        .flatten()
        .map(|value| value.to_weight32())
        .collect();
    let grid = Grid::rectangle(4, 4);
    let code = std::array::from_fn(|neuron| samples[neuron]);
    let map: Som<16, 16> = Som::new(grid, code);
    let any_size = start_at_samples(grid, 16, &flat, &mut noise);

    let mut group = c.benchmark_group("16 neurons of 16");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    group.bench_function("look-ups, fixed size", |b| {
        let winner = |sample: &[Weight; 16]| map.winner(black_box(sample), Mask::ALL);
        b.iter(|| samples.iter().map(winner).sum::<usize>());
    });
    group.bench_function("look-ups, any size", |b| {
        let mut map = any_size.clone();
        b.iter(|| {
            let mut winner = |sample| map.winner(black_box(sample));
            flat.chunks_exact(16).map(&mut winner).sum::<usize>()
        });
    });
    group.bench_function("training, fixed size", |b| {
        let pull = Update::<16>::new(Neighborhood::Direct, 6_554, 16_384);
        let mut map = map.clone();
        b.iter(|| {
            for sample in &samples {
                let winner = map.winner(sample, Mask::ALL);
                map.learn(winner, sample, Mask::ALL, &pull);
            }
        });
    });
    for neighborhood in [Neighborhood::Direct, Neighborhood::Gaussian] {
        let training = Training {
            neighborhood,
            rate: Schedule::new(32_768, 655, Decay::Exponential),
            radius: Schedule::new(65_536, 16_384, Decay::Exponential),
            epochs: 1,
            order: Order::File,
        };
        group.bench_function(format!("training, any size, {neighborhood:?}"), |b| {
            let mut map = any_size.clone();
            b.iter(|| train(&mut map, &flat, &training, &mut noise));
        });
    }
}

criterion_group!(all, maps);
criterion_main!(all);
