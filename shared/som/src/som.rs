//! A map whose size is known at compile time.

use crate::MAX_DIMS;
use crate::codebook::{Codebook, least, pull};
use crate::fixed::{Gain, Mask, Scalar as _, Weight, Weight32, to_weight16, unit_weight32};
use crate::grid::Grid;
use crate::kernels::{Accelerator, BmuCandidates, Kernels, fit, groups};
use crate::neighborhood::Update;
use crate::quality::Quality;
use crate::train::{TrainConfig, shuffle};

/// A map of `NEURONS` neurons with code vectors of `DIMS` components in [−1, 1].
///
/// `DIMS` is at most [`MAX_DIMS`]; a larger value does not compile.
#[derive(Debug, Clone)]
pub struct Som<const NEURONS: usize, const DIMS: usize> {
    grid: Grid,
    code: [[Weight32; DIMS]; NEURONS],
    accelerator: Option<Accelerator>,
}

/// Compares grid and code vectors, not kernels.
impl<const NEURONS: usize, const DIMS: usize> PartialEq for Som<NEURONS, DIMS> {
    fn eq(&self, other: &Self) -> bool {
        self.grid == other.grid && self.code == other.code
    }
}

impl<const NEURONS: usize, const DIMS: usize> Eq for Som<NEURONS, DIMS> {}

impl<const NEURONS: usize, const DIMS: usize> Som<NEURONS, DIMS> {
    /// A map with these code vectors; components are clamped to [−1, 1].
    ///
    /// `grid` should have `NEURONS` neurons; those beyond it have no neighbors.
    #[must_use]
    pub fn new(grid: Grid, code: [[Weight; DIMS]; NEURONS]) -> Self {
        let mut map = Self::zeroed(grid);
        for (k, vector) in code.iter().enumerate() {
            map.set_code_vector(k, vector);
        }
        map
    }

    /// A map whose code vectors are all zero.
    #[must_use]
    pub const fn zeroed(grid: Grid) -> Self {
        const { assert!(DIMS <= MAX_DIMS, "a squared distance has 64 bits") };
        Self {
            grid,
            code: [[Weight32::ZERO; DIMS]; NEURONS],
            accelerator: None,
        }
    }

    /// Uses CPU-specific kernels where they fit the map's size; results are bit-identical.
    pub fn use_kernels(&mut self, kernels: &'static Kernels) {
        self.accelerator = Accelerator::new(kernels, &self.code);
    }

    /// Whether CPU-specific kernels are in use.
    #[must_use]
    pub const fn has_kernels(&self) -> bool {
        self.accelerator.is_some()
    }

    /// The grid.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Replaces the grid by another with the same number of neurons.
    pub const fn set_grid(&mut self, grid: Grid) {
        self.grid = grid;
    }

    /// The code vectors, neuron by neuron.
    #[must_use]
    pub const fn code(&self) -> &[[Weight32; DIMS]; NEURONS] {
        &self.code
    }

    /// The code vector of neuron `k`, rounded down to 16 bits; zeros if there is no such neuron.
    #[must_use]
    pub fn code_vector(&self, k: usize) -> [Weight; DIMS] {
        self.code
            .get(k)
            .map_or([Weight::ZERO; DIMS], |row| row.map(to_weight16))
    }

    /// Replaces the code vector of neuron `k`, clamped to [−1, 1]; no effect if there is no such
    /// neuron.
    pub fn set_code_vector(&mut self, k: usize, vector: &[Weight; DIMS]) {
        self.write(k, |row| {
            for (component, value) in row.iter_mut().zip(vector) {
                *component = unit_weight32(value.to_weight32());
            }
        });
    }

    /// The component at `index` in the concatenated code vectors.
    #[must_use]
    pub fn component(&self, index: usize) -> Option<Weight32> {
        self.code.as_flattened().get(index).copied()
    }

    /// Replaces the component at `index`, clamped to [−1, 1]; no effect beyond the last.
    pub fn set_component(&mut self, index: usize, value: Weight32) {
        let (k, position) = (
            index.checked_div(DIMS).unwrap_or(0),
            index.checked_rem(DIMS).unwrap_or(0),
        );
        self.write(k, |row| {
            if let Some(component) = row.get_mut(position) {
                *component = unit_weight32(value);
            }
        });
    }

    /// Sets all code vectors to zero.
    pub fn clear(&mut self) {
        for k in 0..NEURONS {
            self.write(k, |row| *row = [Weight32::ZERO; DIMS]);
        }
    }

    /// Changes a code vector and updates the kernels' norm of it. All changes go through here.
    #[inline]
    fn write(&mut self, k: usize, change: impl FnOnce(&mut [Weight32; DIMS])) {
        if let Some(row) = self.code.get_mut(k) {
            change(row);
            if fit(NEURONS, DIMS)
                && let Some(accelerator) = &mut self.accelerator
            {
                accelerator.renew(k, row);
            }
        }
    }

    /// The kernels, if they support this size.
    #[inline]
    fn accelerator(&self) -> Option<&Accelerator> {
        if fit(NEURONS, DIMS) {
            self.accelerator.as_ref()
        } else {
            None
        }
    }

    #[inline]
    pub(crate) const fn codebook(&self) -> Codebook<'_> {
        Codebook {
            grid: self.grid,
            dims: DIMS,
            code: self.code.as_flattened(),
        }
    }

    /// The best-matching unit over the components in `mask`; the lowest index on ties.
    #[inline(never)]
    #[must_use]
    pub fn bmu(&self, probe: &[Weight; DIMS], mask: Mask) -> usize {
        let by_ranks = |accelerator: &Accelerator| accelerator.candidates(&self.code, probe, mask);
        match self.accelerator().and_then(by_ranks) {
            Some(BmuCandidates::One(bmu)) => bmu,
            Some(BmuCandidates::Several(candidates)) => {
                nearest_of(candidates, |k| self.distance(k, probe, mask))
            }
            None => least(self.codebook().distances(probe, mask)),
        }
    }

    /// The joint BMU of two maps on the same grid: the neuron with the smallest
    /// |x − w|² + λ |y − v|².
    ///
    /// λ is `weight_q8` in 1/256; all components of `other` are compared.
    #[inline(never)]
    #[must_use]
    pub fn joint_bmu<const OTHER: usize>(
        &self,
        probe: &[Weight; DIMS],
        mask: Mask,
        other: &Som<NEURONS, OTHER>,
        other_probe: &[Weight; OTHER],
        weight_q8: u16,
    ) -> usize {
        let distance = |k: usize| {
            // Divides before it multiplies, so that two components fit 64 bits with any weight.
            let weighted = other.distance(k, other_probe, Mask::ALL) >> 8;
            let weighted = weighted.saturating_mul(u64::from(weight_q8));
            self.distance(k, probe, mask).saturating_add(weighted)
        };
        let by_ranks = |accelerator: &Accelerator| {
            let probe = (probe, mask);
            accelerator.joint_candidates(&self.code, probe, &other.code, other_probe, weight_q8)
        };
        match self.accelerator().and_then(by_ranks) {
            Some(BmuCandidates::One(bmu)) => bmu,
            Some(BmuCandidates::Several(candidates)) => nearest_of(candidates, distance),
            None => least((0..NEURONS).map(distance)),
        }
    }

    /// Squared distance of the probe to neuron `k` over the components in `mask`, in units of 2⁻⁵⁰.
    #[inline(never)]
    #[must_use]
    pub fn distance(&self, k: usize, probe: &[Weight; DIMS], mask: Mask) -> u64 {
        crate::fixed::squared_distance(self.codebook().row(k), probe, mask)
    }

    /// Moves `bmu` and its neighbors towards the probe over the components in `mask`.
    #[inline(never)]
    pub fn update(&mut self, bmu: usize, probe: &[Weight; DIMS], mask: Mask, update: &Update) {
        if self.update_by_kernel(bmu, probe, mask, update).is_none() {
            self.update_portably(bmu, probe, mask, update);
        }
    }

    #[inline]
    fn update_by_kernel(
        &mut self,
        bmu: usize,
        probe: &[Weight; DIMS],
        mask: Mask,
        update: &Update,
    ) -> Option<()> {
        if !fit(NEURONS, DIMS) {
            return None;
        }
        let accelerator = self.accelerator.as_mut()?;
        let groups = groups(update, self.grid, bmu)?;
        accelerator.update(&mut self.code, probe, mask, &groups)
    }

    #[inline(never)]
    fn update_portably(&mut self, bmu: usize, probe: &[Weight; DIMS], mask: Mask, update: &Update) {
        update.for_each(self.grid, bmu, |k, gain: Gain| {
            self.write(k, |row| pull(row, probe, mask, gain));
        });
    }

    /// One training step: finds the BMU, moves it and its neighbors, and returns it.
    pub fn train_step(&mut self, probe: &[Weight; DIMS], mask: Mask, update: &Update) -> usize {
        let bmu = self.bmu(probe, mask);
        self.update(bmu, probe, mask, update);
        bmu
    }

    /// Trains the map on samples, epoch by epoch. Shuffling reorders the samples in place; it calls
    /// `index(n)` for a random number below `n`.
    pub fn train(
        &mut self,
        samples: &mut [[Weight; DIMS]],
        config: &TrainConfig,
        mut index: impl FnMut(usize) -> usize,
    ) {
        let mut updates = config.updates(samples.len());
        for _ in 0..config.epochs {
            if config.is_shuffled() {
                shuffle(samples.len(), &mut index, |a, b| {
                    if let Ok([first, second]) = samples.get_disjoint_mut([a, b]) {
                        core::mem::swap(first, second);
                    }
                });
            }
            for (sample, update) in samples.iter().zip(&mut updates) {
                self.train_step(sample, Mask::ALL, &update);
            }
        }
    }

    /// |w|² − 2 w·x of each code vector over the components in `mask`, from 16-bit values, in units
    /// of 2⁻²⁶. Nearer code vectors have smaller scores.
    #[inline(never)]
    #[must_use]
    pub fn scores(&self, probe: &[Weight; DIMS], mask: Mask) -> [i64; NEURONS] {
        let mut scores = [0; NEURONS];
        self.codebook().scores(probe, mask, &mut scores);
        scores
    }

    /// Dot product of the probe with each code vector over the components in `mask`, in units of
    /// 2⁻²⁶.
    #[inline(never)]
    #[must_use]
    pub fn projections(&self, probe: &[Weight; DIMS], mask: Mask) -> [i64; NEURONS] {
        let mut projections = [0; NEURONS];
        self.codebook().projections(probe, mask, &mut projections);
        projections
    }

    /// Directional similarity of each code vector to the probe over the components in `mask`.
    ///
    /// It is the dot product divided by the code vector's length plus the mean length of all, in
    /// units of 2⁻¹³. The mean prevents very short code vectors from winning: their direction is
    /// mostly noise. For code vectors of equal length it is half the probe's length times the
    /// cosine.
    #[inline(never)]
    #[must_use]
    pub fn alignments(&self, probe: &[Weight; DIMS], mask: Mask) -> [i64; NEURONS] {
        let mut alignments = [0; NEURONS];
        self.codebook().alignments(probe, mask, &mut alignments);
        alignments
    }

    /// Quality on samples, and the number of samples that each neuron wins (the *hit map*).
    pub fn quality<'a>(
        &self,
        samples: impl IntoIterator<Item = &'a [Weight; DIMS]>,
    ) -> (Quality, [u32; NEURONS]) {
        let mut quality = Quality::default();
        let mut hits = [0; NEURONS];
        for sample in samples {
            let bmu = quality.add(self.codebook(), sample);
            if let Some(hits) = hits.get_mut(bmu) {
                *hits += 1;
            }
        }
        (quality, hits)
    }

    /// The *U-matrix* (A. Ultsch 1990): mean distance of each neuron to its direct neighbors, Q13.
    #[must_use]
    pub fn u_matrix(&self) -> [u32; NEURONS] {
        core::array::from_fn(|k| self.codebook().u_matrix_value(k))
    }

    /// Distance of the probe to its BMU divided by the mean distance in `seen`.
    ///
    /// About 1 for a sample like those, larger for an unfamiliar one; see [`Quality::novelty`].
    #[must_use]
    pub fn novelty(&self, probe: &[Weight; DIMS], seen: &Quality) -> f32 {
        let bmu = self.bmu(probe, Mask::ALL);
        seen.novelty(self.distance(bmu, probe, Mask::ALL))
    }
}

/// The nearest of some neurons, the lowest index on ties.
fn nearest_of(candidates: Mask, distance: impl Fn(usize) -> u64) -> usize {
    let nearest = candidates.indices(32).min_by_key(|k| (distance(*k), *k));
    nearest.unwrap_or(0)
}
