//! Self-organising maps in 16-bit fixed point (T. Kohonen, *Self-Organizing Maps*, 3rd ed., Springer 2001).
//!
//! A map is a [`Grid`] of *neurons*, each with a *code vector*; the *best-matching unit* (BMU, here [`Som::winner`]) of a
//! probe is the neuron whose code vector is nearest. Learning moves the winner and its neighbours towards the probe:
//!
//! ```text
//! w_k ← w_k + α(t) · h(k, winner) · (x − w_k)
//! ```
//!
//! with a falling *learning rate* α ([`Schedule`]) and a *neighbourhood* h ([`Neighbourhood`]). What we changed: the maps
//! are associative memories as in the paper, so they can be probed with a part of the vector (a [`Mask`]) and by the
//! *direction* of a probe instead of its distance.
//!
//! The arithmetic stands once, in [`kernels`], on flat slices: [`Som`] lends it arrays of a fixed size, a host program
//! may lend it vectors of any size.

pub mod grid;
pub mod kernels;
pub mod metrics;
pub mod neighbourhood;
pub mod schedule;

pub use grid::{Edges, Grid};
pub use neighbourhood::Neighbourhood;
pub use schedule::{Decay, Schedule};

use crate::fixed::{Dither, Gain, Mask, Weight, squared_norm};
use neighbourhood::Pull;

/// A map of `NEURONS` neurons with code vectors of `DIMS` components in [−1, 1].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Som<const NEURONS: usize, const DIMS: usize> {
    grid: Grid,
    code: [[Weight; DIMS]; NEURONS],
    /// Squared lengths of the code vectors, kept in step with `code`.
    norms: [i64; NEURONS],
}

impl<const NEURONS: usize, const DIMS: usize> Som<NEURONS, DIMS> {
    /// A map with these code vectors; components are clamped to [−1, 1]. `grid` should have `NEURONS` places: neurons
    /// beyond them are searched but have no neighbours.
    #[must_use]
    pub fn new(grid: Grid, code: [[Weight; DIMS]; NEURONS]) -> Self {
        let code = code.map(|row| row.map(|w| crate::fixed::unit_weight(i32::from(w.to_bits()))));
        let norms = core::array::from_fn(|k| code.get(k).map_or(0, |row| squared_norm(row)));
        Self { grid, code, norms }
    }

    /// A map whose code vectors are all zero.
    #[must_use]
    pub fn zeroed(grid: Grid) -> Self {
        Self::new(grid, [[Weight::ZERO; DIMS]; NEURONS])
    }

    /// The grid.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// The code vectors, neuron by neuron.
    #[must_use]
    pub const fn code(&self) -> &[[Weight; DIMS]; NEURONS] {
        &self.code
    }

    /// The code vector of neuron `k`; zeros for a neuron that does not exist.
    #[must_use]
    pub fn code_vector(&self, k: usize) -> [Weight; DIMS] {
        self.code.get(k).copied().unwrap_or([Weight::ZERO; DIMS])
    }

    /// Squared distance of the probe to every code vector less the probe's own squared length, in units of 2⁻²⁶: the
    /// smaller, the nearer.
    #[inline]
    #[must_use]
    pub fn scores(&self, probe: &[Weight; DIMS]) -> [i64; NEURONS] {
        let mut scores = [0; NEURONS];
        kernels::scores(
            self.code.as_flattened(),
            &self.norms,
            DIMS,
            probe,
            &mut scores,
        );
        scores
    }

    /// As [`scores`](Self::scores), over the components that `mask` believes.
    #[must_use]
    pub fn scores_masked(&self, probe: &[Weight; DIMS], mask: Mask) -> [i64; NEURONS] {
        if mask.covers(DIMS) {
            return self.scores(probe);
        }
        let mut scores = [0; NEURONS];
        kernels::scores_masked(self.code.as_flattened(), DIMS, probe, mask, &mut scores);
        scores
    }

    /// The best-matching unit over the components that `mask` believes; the lowest index on ties.
    #[inline]
    #[must_use]
    pub fn winner(&self, probe: &[Weight; DIMS], mask: Mask) -> usize {
        kernels::least(&self.scores_masked(probe, mask))
    }

    /// How far each code vector points the probe's way, over the components that `mask` believes: see
    /// [`kernels::alignments`].
    #[must_use]
    pub fn alignments(&self, probe: &[Weight; DIMS], mask: Mask) -> [i64; NEURONS] {
        let mut alignments = [0; NEURONS];
        kernels::alignments(
            self.code.as_flattened(),
            &self.norms,
            DIMS,
            probe,
            mask,
            &mut alignments,
        );
        alignments
    }

    /// Dot product of the probe with every code vector over the components that `mask` believes, in units of 2⁻²⁶.
    #[must_use]
    pub fn projections(&self, probe: &[Weight; DIMS], mask: Mask) -> [i64; NEURONS] {
        let mut projections = [0; NEURONS];
        kernels::projections(
            self.code.as_flattened(),
            DIMS,
            probe,
            mask,
            &mut projections,
        );
        projections
    }

    /// One step of learning: moves `winner` and its neighbours towards the probe over the components `mask` believes.
    #[inline]
    pub fn learn(
        &mut self,
        winner: usize,
        probe: &[Weight; DIMS],
        mask: Mask,
        pull: &Pull<NEURONS>,
        dither: Dither,
    ) {
        let learn = Learn {
            grid: self.grid,
            dims: DIMS,
            winner,
            mask,
            dither,
        };
        learn.apply(
            self.code.as_flattened_mut(),
            &mut self.norms,
            probe,
            pull.view(),
        );
    }
}

/// One step of learning on flat slices.
#[derive(Debug, Clone, Copy)]
pub struct Learn {
    /// The map's grid.
    pub grid: Grid,
    /// Components of a code vector.
    pub dims: usize,
    /// The best-matching unit.
    pub winner: usize,
    /// Components to learn.
    pub mask: Mask,
    /// Where the step is rounded; another one with each step.
    pub dither: Dither,
}

impl Learn {
    /// Moves the winner and its neighbours towards the probe and brings their squared lengths up to date.
    #[inline(always)]
    pub fn apply(
        self,
        code: &mut [Weight],
        norms: &mut [i64],
        probe: &[Weight],
        pull: neighbourhood::View<'_>,
    ) {
        match pull {
            neighbourhood::View::Direct { rate, share } => {
                let near = self.grid.neighbours(self.winner).map(|k| (k, share));
                for (neuron, gain) in core::iter::once((self.winner, rate)).chain(near) {
                    let start = neuron.wrapping_mul(self.dims);
                    let row = code.get_mut(start..start.wrapping_add(self.dims));
                    if let (Some(row), Some(norm)) = (row, norms.get_mut(neuron)) {
                        self.move_row(row, norm, probe, gain);
                    }
                }
            }
            neighbourhood::View::Gaussian { rate, axis } => {
                let along = |d: usize| axis.get(d).copied().unwrap_or(Gain::ZERO);
                let (column, row) = self.grid.position(self.winner);
                let mut rows = code.chunks_exact_mut(self.dims.max(1)).zip(norms);
                for y in 0..self.grid.rows() {
                    let row_gain = rate.times(along(self.grid.row_distance(row, y)));
                    for (x, (row, norm)) in (0..self.grid.columns()).zip(&mut rows) {
                        let gain = row_gain.times(along(self.grid.column_distance(column, x)));
                        if gain != Gain::ZERO {
                            self.move_row(row, norm, probe, gain);
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn move_row(self, row: &mut [Weight], norm: &mut i64, probe: &[Weight], gain: Gain) {
        kernels::pull(row, probe, self.mask, gain, self.dither);
        *norm = squared_norm(row);
    }
}

#[cfg(test)]
mod tests;
