//! Starting code vectors, the order of the samples and the training itself.
//!
//! All randomness comes from one generator, [`Noise`] (xoshiro256++), seeded with `--seed`: first the starting code
//! vectors, then one shuffle per epoch (Fisher and Yates). Training runs on one thread; a seed gives the same bytes
//! everywhere.

use super::map::DynSom;
use amp::fixed::Weight32;
use amp::som::neighborhood::View;
use amp::som::{Grid, Neighborhood, Schedule};
use arena::noise::Noise;

/// How often learning rate and radius fall during a training, at most: in shorter trainings with every presentation.
const RENEWALS: u32 = 16_384;

/// The order in which samples are presented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Order {
    /// As in the file, epoch by epoch
    File,
    /// Shuffled anew for each epoch
    Shuffled,
}

/// How a map learns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Training {
    /// Shape of the neighborhood.
    pub neighborhood: Neighborhood,
    /// Learning rate.
    pub rate: Schedule,
    /// Radius of the neighborhood in grid steps, or the direct neighbors' share of the rate.
    pub radius: Schedule,
    /// Presentations of every sample.
    pub epochs: u32,
    /// Their order.
    pub order: Order,
}

/// Code vectors that are random samples: different ones as long as there are enough.
#[must_use]
pub fn start_at_samples(
    grid: Grid,
    dims: usize,
    samples: &[Weight32],
    noise: &mut Noise,
) -> DynSom {
    let rows: Vec<_> = samples.chunks_exact(dims.max(1)).collect();
    let mut left = Vec::new();
    let mut code = Vec::with_capacity(grid.len() * dims);
    for _ in 0..grid.len() {
        if left.is_empty() {
            left.clone_from(&rows);
        }
        if !left.is_empty() {
            code.extend_from_slice(left.swap_remove(noise.index(left.len())));
        }
    }
    DynSom::new(grid, dims, code)
}

/// Code vectors whose components are uniform between the least and the greatest value of each component.
#[must_use]
pub fn start_at_random(grid: Grid, dims: usize, samples: &[Weight32], noise: &mut Noise) -> DynSom {
    let mut ends = vec![(Weight32::MAX, Weight32::MIN); dims];
    for sample in samples.chunks_exact(dims.max(1)) {
        for ((low, high), &value) in ends.iter_mut().zip(sample) {
            (*low, *high) = (value.min(*low), value.max(*high));
        }
    }
    let mut draw = |&(low, high): &(Weight32, Weight32)| {
        let width = high.to_bits() - low.to_bits();
        let steps = noise.index(usize::try_from(width + 1).unwrap_or(1));
        low.saturating_add(Weight32::from_bits(steps as i32))
    };
    let code = (0..grid.len()).flat_map(|_| ends.iter().map(&mut draw).collect::<Vec<_>>());
    DynSom::new(grid, dims, code.collect())
}

/// Trains a map on samples that stand one after another.
pub fn train(map: &mut DynSom, samples: &[Weight32], training: &Training, noise: &mut Noise) {
    let dims = map.dims();
    let count = samples.len() / dims;
    let steps = u32::try_from(count as u64 * u64::from(training.epochs)).unwrap_or(u32::MAX);
    let slice = (steps / RENEWALS).max(1);
    let mut axis = map.axis();
    let mut samples = samples.to_vec();
    let mut step = 0;
    for _ in 0..training.epochs {
        if training.order == Order::Shuffled {
            shuffle(&mut samples, dims, noise);
        }
        for batch in samples.chunks(slice as usize * dims) {
            let rate = training.rate.at(step, steps);
            let radius = training.radius.at(step, steps);
            let pull = View::new(training.neighborhood, rate, radius, &mut axis);
            map.learn_all(batch, pull);
            step += (batch.len() / dims) as u32;
        }
    }
}

/// Exchanges rows until every order is equally likely.
pub(super) fn shuffle(rows: &mut [Weight32], dims: usize, noise: &mut Noise) {
    for last in (1..rows.len() / dims).rev() {
        let other = noise.index(last + 1);
        if other != last {
            let (head, tail) = rows.split_at_mut(last * dims);
            head[other * dims..][..dims].swap_with_slice(&mut tail[..dims]);
        }
    }
}
