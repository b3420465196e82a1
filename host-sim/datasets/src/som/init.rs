//! Initial code vectors.
//!
//! All random numbers come from one generator, [`Noise`] (xoshiro256++), seeded with `--seed`. It
//! draws the initial code vectors, then shuffles once per epoch. Training runs on one thread.

use arena::noise::Noise;
use files::error::BadInput;
use tinysom::{DynSom, Grid, Weight32};

/// A map with these code vectors, concatenated.
///
/// # Errors
/// Too many components for a map.
pub fn new_map(grid: Grid, dims: usize, code: Vec<Weight32>) -> Result<DynSom, BadInput> {
    DynSom::new(grid, dims, code).map_err(|error| BadInput::new(format!("the samples: {error}")))
}

/// Initial code vectors are random samples, drawn without replacement; if all samples are drawn,
/// drawing starts over.
///
/// # Errors
/// As [`new_map`].
pub fn init_from_samples(
    grid: Grid,
    dims: usize,
    samples: &[Weight32],
    noise: &mut Noise,
) -> Result<DynSom, BadInput> {
    let rows: Vec<_> = samples.chunks_exact(dims.max(1)).collect();
    let mut remaining = Vec::new();
    let mut code = Vec::with_capacity(grid.len() * dims);
    for _ in 0..grid.len() {
        if remaining.is_empty() {
            remaining.clone_from(&rows);
        }
        if !remaining.is_empty() {
            code.extend_from_slice(remaining.swap_remove(noise.index(remaining.len())));
        }
    }
    new_map(grid, dims, code)
}

/// Initial code vectors are random: each component is uniform between its smallest and largest
/// value in the samples.
///
/// # Errors
/// As [`new_map`].
pub fn init_at_random(
    grid: Grid,
    dims: usize,
    samples: &[Weight32],
    noise: &mut Noise,
) -> Result<DynSom, BadInput> {
    let mut limits = vec![(Weight32::MAX, Weight32::MIN); dims];
    for sample in samples.chunks_exact(dims.max(1)) {
        for ((low, high), &value) in limits.iter_mut().zip(sample) {
            (*low, *high) = (value.min(*low), value.max(*high));
        }
    }
    let mut draw = |&(low, high): &(Weight32, Weight32)| {
        let width = high.to_bits() - low.to_bits();
        let steps = noise.index(usize::try_from(width + 1).unwrap_or(1));
        low.saturating_add(Weight32::from_bits(steps as i32))
    };
    let code = (0..grid.len()).flat_map(|_| limits.iter().map(&mut draw).collect::<Vec<_>>());
    new_map(grid, dims, code.collect())
}
