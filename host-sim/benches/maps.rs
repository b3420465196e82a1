//! Maps on the host: look-ups and training of 16 neurons with 16 components, by the map of fixed
//! size that thinks for the robot and by the one of any size behind `host-sim som`.

use arena::noise::Noise;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use datasets::som::init::init_from_samples;
use std::hint::black_box;
use tinysom::fixed::Scalar as _;
use tinysom::{
    Decay, Grid, Mask, Neighborhood, SampleOrder, Schedule, Som, TrainConfig, Update, Weight,
};

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
    let any_size = init_from_samples(grid, 16, &flat, &mut noise).expect("16 components");

    let mut group = c.benchmark_group("16 neurons of 16");
    group.throughput(Throughput::Elements(SAMPLES as u64));
    group.bench_function("look-ups, fixed size", |b| {
        let bmu = |sample: &[Weight; 16]| map.bmu(black_box(sample), Mask::ALL);
        b.iter(|| samples.iter().map(bmu).sum::<usize>());
    });
    group.bench_function("look-ups, any size", |b| {
        let bmu = |sample| any_size.bmu(black_box(sample), Mask::ALL);
        b.iter(|| flat.chunks_exact(16).map(bmu).sum::<usize>());
    });
    group.bench_function("training, fixed size", |b| {
        let update = Update::from_q16(Neighborhood::Direct, 6_554, 16_384);
        let mut map = map.clone();
        b.iter(|| {
            for sample in &samples {
                map.train_step(sample, Mask::ALL, &update);
            }
        });
    });
    for neighborhood in [Neighborhood::Direct, Neighborhood::Gaussian] {
        let config = TrainConfig {
            neighborhood,
            rate: Schedule::from_q16(32_768, 655, Decay::Exponential),
            radius: Schedule::from_q16(65_536, 16_384, Decay::Exponential),
            epochs: 1,
            order: SampleOrder::AsGiven,
        };
        group.bench_function(format!("training, any size, {neighborhood:?}"), |b| {
            let (mut map, mut flat) = (any_size.clone(), flat.clone());
            b.iter(|| map.train(&mut flat, &config, |below| noise.index(below)));
        });
    }
}

criterion_group!(all, maps);
criterion_main!(all);
