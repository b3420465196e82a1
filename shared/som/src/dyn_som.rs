//! A map whose size is known only at run time.

use crate::MAX_DIMS;
use crate::codebook::{Codebook, least, pull};
use crate::fixed::{Mask, Weight32, squared_distance, unit_weight32};
use crate::grid::Grid;
use crate::neighborhood::Update;
use crate::quality::Quality;
use crate::train::{TrainConfig, shuffle};
use alloc::vec;
use alloc::vec::Vec;

/// A map on the heap. Searches and updates are bit-identical to those of [`Som`](crate::Som).
///
/// Samples and code vectors are slices of [`Weight32`] in [−1, 1], `dims` components each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DynSom {
    grid: Grid,
    dims: usize,
    code: Vec<Weight32>,
}

/// A code vector has more than [`MAX_DIMS`] components.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TooManyComponents(
    /// Number of components.
    pub usize,
);

impl core::fmt::Display for TooManyComponents {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} components are more than {MAX_DIMS}", self.0)
    }
}

impl core::error::Error for TooManyComponents {}

impl DynSom {
    /// A map with these concatenated code vectors of `dims` ≥ 1 components. Components are clamped
    /// to [−1, 1]; missing ones are 0.
    ///
    /// # Errors
    /// [`TooManyComponents`] if `dims` is above [`MAX_DIMS`].
    pub fn new(
        grid: Grid,
        dims: usize,
        mut code: Vec<Weight32>,
    ) -> Result<Self, TooManyComponents> {
        if dims > MAX_DIMS {
            return Err(TooManyComponents(dims));
        }
        let dims = dims.max(1);
        code.resize(grid.len().saturating_mul(dims), Weight32::ZERO);
        for component in &mut code {
            *component = unit_weight32(*component);
        }
        Ok(Self { grid, dims, code })
    }

    /// The grid.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Components of a code vector.
    #[must_use]
    pub const fn dims(&self) -> usize {
        self.dims
    }

    /// The code vectors, neuron by neuron.
    pub fn code_vectors(&self) -> impl Iterator<Item = &[Weight32]> {
        self.codebook().rows()
    }

    pub(crate) fn codebook(&self) -> Codebook<'_> {
        Codebook {
            grid: self.grid,
            dims: self.dims,
            code: &self.code,
        }
    }

    /// The best-matching unit of a probe over the components in `mask`; the lowest index on ties.
    #[must_use]
    pub fn bmu(&self, probe: &[Weight32], mask: Mask) -> usize {
        least(self.codebook().distances(probe, mask))
    }

    /// Squared distance of the probe to neuron `k` over the components in `mask`, in units of 2⁻⁵⁰.
    #[must_use]
    pub fn distance(&self, k: usize, probe: &[Weight32], mask: Mask) -> u64 {
        squared_distance(self.codebook().row(k), probe, mask)
    }

    /// Moves `bmu` and its neighbors towards the probe over the components in `mask`.
    pub fn update(&mut self, bmu: usize, probe: &[Weight32], mask: Mask, update: &Update) {
        let dims = self.dims;
        update.for_each(self.grid, bmu, |k, gain| {
            let start = k.saturating_mul(dims);
            if let Some(row) = self.code.get_mut(start..start.saturating_add(dims)) {
                pull(row, probe, mask, gain);
            }
        });
    }

    /// One training step: finds the BMU, moves it and its neighbors, and returns it.
    pub fn train_step(&mut self, probe: &[Weight32], mask: Mask, update: &Update) -> usize {
        let bmu = self.bmu(probe, mask);
        self.update(bmu, probe, mask, update);
        bmu
    }

    /// Trains the map on concatenated samples; see
    /// [`Som::train`](crate::Som::train).
    pub fn train(
        &mut self,
        samples: &mut [Weight32],
        config: &TrainConfig,
        mut index: impl FnMut(usize) -> usize,
    ) {
        let dims = self.dims;
        let count = samples.len() / dims;
        let mut updates = config.updates(count);
        for _ in 0..config.epochs {
            if config.is_shuffled() {
                shuffle(count, &mut index, |a, b| swap_rows(samples, dims, a, b));
            }
            for (sample, update) in samples.chunks_exact(dims).zip(&mut updates) {
                self.train_step(sample, Mask::ALL, &update);
            }
        }
    }

    /// Quality on concatenated samples, and the number of samples that each neuron wins.
    #[must_use]
    pub fn quality(&self, samples: &[Weight32]) -> (Quality, Vec<u32>) {
        let mut quality = Quality::default();
        let mut hits = vec![0; self.grid.len()];
        for sample in samples.chunks_exact(self.dims) {
            let bmu = quality.add(self.codebook(), sample);
            if let Some(hits) = hits.get_mut(bmu) {
                *hits += 1;
            }
        }
        (quality, hits)
    }

    /// The *U-matrix*: mean distance of each neuron to its direct neighbors, Q13.
    #[must_use]
    pub fn u_matrix(&self) -> Vec<u32> {
        (0..self.grid.len())
            .map(|k| self.codebook().u_matrix_value(k))
            .collect()
    }

    /// See [`Som::novelty`](crate::Som::novelty).
    #[must_use]
    pub fn novelty(&self, probe: &[Weight32], seen: &Quality) -> f32 {
        let bmu = self.bmu(probe, Mask::ALL);
        seen.novelty(self.distance(bmu, probe, Mask::ALL))
    }
}

/// Swaps rows `a` and `b`; `a` must be below `b`.
fn swap_rows(rows: &mut [Weight32], dims: usize, a: usize, b: usize) {
    let (start, end) = (a.saturating_mul(dims), b.saturating_mul(dims));
    if let Some((head, tail)) = rows.split_at_mut_checked(end) {
        let first = head.get_mut(start..).unwrap_or_default();
        for (x, y) in first.iter_mut().zip(tail).take(dims) {
            core::mem::swap(x, y);
        }
    }
}
