//! A map as a watch: trained on a machine's vibration at three speeds, it tells what is new.
use amp::som::{Decay, Grid, Neighborhood, SampleOrder, Schedule, Som, TrainConfig, Weight};
use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Energy in eight bands of frequency: a peak at `speed`, its overtone, and noise.
fn spectrum(speed: f64, generator: &mut Xoshiro128PlusPlus) -> [Weight; 8] {
    core::array::from_fn(|band| {
        let peak = |at: f64| (-(band as f64 - at).powi(2)).exp();
        let noise = f64::from(generator.next_u32() >> 16) / 65_536.0;
        Weight::from_num(0.7 * peak(speed) + 0.2 * peak(2.0 * speed) + 0.05 * noise)
    })
}

fn main() {
    let mut generator = Xoshiro128PlusPlus::seed_from_u64(1);
    let mut samples: Vec<_> = (0..300)
        .map(|i| spectrum([1.0, 2.0, 3.0][i % 3], &mut generator))
        .collect();
    let start = core::array::from_fn(|k| samples[k * 10]);
    let mut map = Som::<16, 8>::new(Grid::rectangle(4, 4), start);
    let config = TrainConfig {
        neighborhood: Neighborhood::Gaussian,
        rate: Schedule::new(0.5, 0.02, Decay::Exponential),
        radius: Schedule::new(1.5, 0.4, Decay::Exponential),
        epochs: 20,
        order: SampleOrder::Shuffled,
    };
    map.train(&mut samples, &config, |below| {
        generator.next_u32() as usize % below
    });

    // What training saw sets the scale, and its farthest sample the threshold.
    let (seen, _) = map.quality(&samples);
    let threshold = 1.5 * seen.largest_novelty();
    for (name, speed, is_new) in [("known speed", 2.0, false), ("worn bearing", 5.5, true)] {
        let novelty = map.novelty(&spectrum(speed, &mut generator), &seen);
        println!("{name}: {novelty:.1} times as far as usual, threshold {threshold:.1}");
        assert_eq!(novelty > threshold, is_new);
    }
}
