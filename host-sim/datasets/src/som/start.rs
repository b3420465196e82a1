//! Starting code vectors.
//!
//! All randomness comes from one generator, [`Noise`] (xoshiro256++), seeded with `--seed`: first
//! the starting code vectors, then one shuffle per epoch. Training runs on one thread.

use arena::noise::Noise;
use files::error::BadInput;
use tinysom::{DynSom, Grid, Weight32};

/// A map with these code vectors, one after another.
///
/// # Errors
/// More components than a map may have.
pub fn map_of(grid: Grid, dims: usize, code: Vec<Weight32>) -> Result<DynSom, BadInput> {
    DynSom::new(grid, dims, code).map_err(|error| BadInput::new(format!("the samples: {error}")))
}

/// Code vectors that are random samples: different ones as long as there are enough.
///
/// # Errors
/// As [`map_of`].
pub fn start_at_samples(
    grid: Grid,
    dims: usize,
    samples: &[Weight32],
    noise: &mut Noise,
) -> Result<DynSom, BadInput> {
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
    map_of(grid, dims, code)
}

/// Code vectors whose components are uniform between the least and the greatest value of each
/// component.
///
/// # Errors
/// As [`map_of`].
pub fn start_at_random(
    grid: Grid,
    dims: usize,
    samples: &[Weight32],
    noise: &mut Noise,
) -> Result<DynSom, BadInput> {
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
    map_of(grid, dims, code.collect())
}
