//! Self-organizing maps in fixed point (T. Kohonen, *Self-Organizing Maps*, 3rd ed., Springer 2001).
//!
//! A map is a [`Grid`] of *neurons*, each with a *code vector*; the *best-matching unit* (BMU, here [`Som::winner`]) of a
//! probe is the neuron whose code vector is nearest. Learning moves the winner and its neighbors towards the probe:
//!
//! ```text
//! w_k ← w_k + α(t) · h(k, winner) · (x − w_k)
//! ```
//!
//! with a falling *learning rate* α ([`Schedule`]) and a *neighborhood* h ([`Neighborhood`]). What we changed: the maps
//! are associative memories as in the paper, so they can be probed with a part of the vector (a [`Mask`]) and by the
//! *direction* of a probe instead of its distance.
//!
//! The arithmetic stands once, in [`kernels`], on flat slices: [`Som`] lends it arrays of a fixed size, a host program
//! may lend it vectors of any size.

pub mod grid;
pub mod kernels;
pub mod metrics;
pub mod neighborhood;
pub mod schedule;

pub use grid::{Edges, Grid};
pub use neighborhood::Neighborhood;
pub use schedule::{Decay, Schedule};

use crate::fixed::{
    FINE_ONE_BITS, Gain, Mask, Scalar, Weight, Weight32, squared_norm, to_weight16,
};
use kernels::{Found, Group, Kernels};
use neighborhood::Update;

/// A map of `NEURONS` neurons with code vectors of `DIMS` components in [−1, 1].
#[derive(Debug, Clone)]
pub struct Som<const NEURONS: usize, const DIMS: usize> {
    grid: Grid,
    /// Used where the map has their size; `None` = the portable ones alone.
    kernels: Option<&'static Kernels>,
    code: [[Weight32; DIMS]; NEURONS],
    /// Squared lengths of the code vectors as of [`kernels::length_squared`], kept in step with `code`.
    norms: [i32; NEURONS],
}

/// What the map knows, whoever computes with it.
impl<const NEURONS: usize, const DIMS: usize> PartialEq for Som<NEURONS, DIMS> {
    fn eq(&self, other: &Self) -> bool {
        self.grid == other.grid && self.code == other.code && self.norms == other.norms
    }
}

impl<const NEURONS: usize, const DIMS: usize> Eq for Som<NEURONS, DIMS> {}

impl<const NEURONS: usize, const DIMS: usize> Som<NEURONS, DIMS> {
    /// A map with these code vectors; components are clamped to [−1, 1]. `grid` should have `NEURONS` places: neurons
    /// beyond them are searched but have no neighbors.
    #[must_use]
    pub fn new(grid: Grid, code: [[Weight; DIMS]; NEURONS]) -> Self {
        let unit = |w: Weight| crate::fixed::unit_weight(i32::from(w.to_bits())).to_weight32();
        let code = code.map(|row| row.map(unit));
        const { assert!(DIMS <= 31, "squared lengths are kept in 32 bits") };
        let norms =
            core::array::from_fn(|k| code.get(k).map_or(0, |row| kernels::length_squared(row)));
        Self {
            grid,
            kernels: None,
            code,
            norms,
        }
    }

    /// A map whose code vectors are all zero.
    #[must_use]
    pub const fn zeroed(grid: Grid) -> Self {
        const { assert!(DIMS <= 31, "squared lengths are kept in 32 bits") };
        Self {
            grid,
            kernels: None,
            code: [[Weight32::ZERO; DIMS]; NEURONS],
            norms: [0; NEURONS],
        }
    }

    /// Has the processor's own kernels do what they can; a map of another size than theirs goes on without.
    pub const fn use_kernels(&mut self, kernels: &'static Kernels) {
        self.kernels = Some(kernels);
    }

    /// The grid.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Makes all code vectors zero.
    pub(crate) fn clear(&mut self) {
        for component in self.code.as_flattened_mut() {
            *component = Weight32::ZERO;
        }
        self.norms = [0; NEURONS];
    }

    /// Gives the map another grid of as many places.
    pub(crate) const fn set_grid(&mut self, grid: Grid) {
        self.grid = grid;
    }

    /// Replaces the code vector of neuron `k`; components are clamped to [−1, 1].
    pub(crate) fn set_code_vector(&mut self, k: usize, vector: &[Weight; DIMS]) {
        for (index, weight) in (k.wrapping_mul(DIMS)..).zip(vector) {
            self.set_component(index, weight.to_weight32());
        }
    }

    /// The component at place `index`, counted through the code vectors one after another.
    pub(crate) fn component(&self, index: usize) -> Option<Weight32> {
        self.code.as_flattened().get(index).copied()
    }

    /// Replaces the component at place `index`, clamped to [−1, 1]; nothing happens beyond the last.
    pub(crate) fn set_component(&mut self, index: usize, value: Weight32) {
        if let Some(place) = self.code.as_flattened_mut().get_mut(index) {
            let bits = value.to_bits().clamp(-FINE_ONE_BITS, FINE_ONE_BITS);
            *place = Weight32::from_bits(bits);
        }
        let row = index.checked_div(DIMS).unwrap_or(0);
        if let (Some(norm), Some(code)) = (self.norms.get_mut(row), self.code.get(row)) {
            *norm = kernels::length_squared(code);
        }
    }

    /// The code vectors, neuron by neuron.
    #[must_use]
    pub const fn code(&self) -> &[[Weight32; DIMS]; NEURONS] {
        &self.code
    }

    /// The code vector of neuron `k` to 16 bits; zeros for a neuron that does not exist.
    #[must_use]
    pub fn code_vector(&self, k: usize) -> [Weight; DIMS] {
        self.code
            .get(k)
            .map_or([Weight::ZERO; DIMS], |row| row.map(to_weight16))
    }

    /// Squared distance of the probe to every code vector less the probe's own squared length, in units of 2⁻²⁶: the
    /// smaller, the nearer.
    #[inline]
    #[must_use]
    pub fn scores(&self, probe: &[Weight; DIMS]) -> [i64; NEURONS] {
        let mut scores = [0; NEURONS];
        self.score(probe, Mask::ALL, &mut scores);
        scores
    }

    /// As [`scores`](Self::scores), over the components that `mask` believes.
    #[must_use]
    #[inline(never)]
    pub fn scores_masked(&self, probe: &[Weight; DIMS], mask: Mask) -> [i64; NEURONS] {
        let mut scores = [0; NEURONS];
        self.score(probe, mask, &mut scores);
        scores
    }

    /// The scores into room lent for them: a search runs 20 000 times in a training and must not copy its result.
    pub(crate) fn score(&self, probe: &[Weight; DIMS], mask: Mask, scores: &mut [i64; NEURONS]) {
        let code = self.code.as_flattened();
        if mask.covers(DIMS) {
            let norms = self.code.iter().map(|row| squared_norm(row));
            kernels::scores(code, norms, DIMS, probe, scores);
        } else {
            kernels::scores_masked(code, DIMS, probe, mask, scores);
        }
    }

    /// The best-matching unit over the components that `mask` believes, in full precision; the lowest index on ties. Maps
    /// of more than 32 neurons do not compile here: they are searched by [`kernels::nearest`].
    #[inline(never)]
    #[must_use]
    pub fn winner(&self, probe: &[Weight; DIMS], mask: Mask) -> usize {
        self.search(probe, mask)
    }

    #[inline]
    fn search(&self, probe: &[Weight; DIMS], mask: Mask) -> usize {
        let by_hand = match mask.covers(DIMS) {
            true => self.candidates_simd(&self.norms, probe, Self::MARGIN),
            false => None,
        };
        match by_hand.unwrap_or_else(|| Found::among(self.candidates(probe, mask))) {
            Found::One(neuron) => neuron,
            Found::Rivals(candidates) => self.nearest_of(candidates, probe, mask),
        }
    }

    /// By how much the ranks of two neurons may be out of order.
    pub(crate) const MARGIN: i32 = kernels::rank_margin::<DIMS>(1 << 8);

    /// By how much more they may be where upper halves are ranked.
    pub(crate) const HALVES_MARGIN: i32 = kernels::halves_margin::<DIMS>();

    /// The neurons that may be nearest.
    #[inline(never)]
    fn candidates(&self, probe: &[Weight; DIMS], mask: Mask) -> Mask {
        kernels::candidates(&self.ranks(probe, mask), Self::MARGIN + Self::HALVES_MARGIN)
    }

    #[inline(never)]
    fn nearest_of(&self, candidates: Mask, probe: &[Weight; DIMS], mask: Mask) -> usize {
        kernels::nearest_of(candidates, |k| self.distance(k, probe, mask))
    }

    /// Those for the processor, if a map of this size has them.
    #[inline]
    pub(crate) const fn kernels(&self) -> Option<&'static Kernels> {
        if NEURONS == 16 && DIMS == 16 {
            self.kernels
        } else {
            None
        }
    }

    /// The same by the processor's kernels, if there are any for this size; `margin` as of [`kernels::rank_margin`].
    #[inline]
    pub(crate) fn candidates_simd(
        &self,
        bases: &[i32; NEURONS],
        probe: &[Weight; DIMS],
        margin: i32,
    ) -> Option<Found> {
        let kernels = self.kernels()?;
        let (code, _) = self.code.as_flattened().as_chunks();
        let (code, bases) = (code.try_into().ok()?, bases.as_slice().try_into().ok()?);
        let probe = probe.as_slice().try_into().ok()?;
        // Ranks are half as large.
        let margin = margin << (kernels::RANK_BITS - 1);
        let candidates = (kernels.candidates)(code, bases, probe, margin);
        Some(Found::by_hand(candidates))
    }

    /// The scores in units of 2⁻¹⁷, see [`kernels::rank_margin`]. Over a part of the components there are no lengths to
    /// rank by, and all ranks are 0.
    #[inline]
    pub(crate) fn ranks(&self, probe: &[Weight; DIMS], mask: Mask) -> [i32; NEURONS] {
        if !mask.covers(DIMS) {
            return [0; NEURONS];
        }
        let mut ranks = self.norms.map(|norm| kernels::rank_norm(norm, 1 << 8));
        self.rank_products(probe, &mut ranks);
        ranks
    }

    #[inline(never)]
    fn rank_products(&self, probe: &[Weight; DIMS], ranks: &mut [i32; NEURONS]) {
        kernels::rank_products(&self.code, probe, ranks);
    }

    /// Adds the scores times a weight in 1/256 to another map's ranks; for few components.
    #[inline(never)]
    pub(crate) fn rank_weighted(
        &self,
        probe: &[Weight; DIMS],
        weight_q8: u16,
        ranks: &mut [i32; NEURONS],
    ) {
        let probe = probe.map(|x| kernels::rank_factor(x, weight_q8));
        for (rank, norm) in ranks.iter_mut().zip(&self.norms) {
            *rank = rank.wrapping_add(kernels::rank_norm(*norm, weight_q8));
        }
        for (rank, row) in ranks.iter_mut().zip(&self.code) {
            *rank = kernels::rank_sum(*rank, row, &probe);
        }
    }

    /// Squared lengths of the code vectors, in units of 2⁻²⁶.
    pub(crate) const fn norms(&self) -> &[i32; NEURONS] {
        &self.norms
    }

    /// Squared distance of the probe to neuron `k` over the components that `mask` believes, in units of 2⁻⁵⁰.
    #[inline(never)]
    #[must_use]
    pub fn distance(&self, k: usize, probe: &[Weight; DIMS], mask: Mask) -> u64 {
        kernels::distance(self.code.as_flattened(), DIMS, k, probe, mask)
    }

    /// How far each code vector points the probe's way, over the components that `mask` believes: see
    /// [`kernels::alignments`].
    #[must_use]
    #[inline(never)]
    pub fn alignments(&self, probe: &[Weight; DIMS], mask: Mask) -> [i64; NEURONS] {
        let mut alignments = [0; NEURONS];
        let measures = match mask.covers(DIMS) {
            true => self.measure_simd(probe),
            false => None,
        };
        match measures {
            Some(measures) => kernels::measured_alignments(&measures, &mut alignments),
            None => kernels::alignments(
                self.code.as_flattened(),
                self.code.iter().map(|row| squared_norm(row)),
                DIMS,
                probe,
                mask,
                &mut alignments,
            ),
        }
        alignments
    }

    /// Squared lengths of the upper halves and their dot products with the probe by the processor's kernels, if there are
    /// any for this size.
    #[inline]
    fn measure_simd(&self, probe: &[Weight; DIMS]) -> Option<[[i32; 2]; 16]> {
        let kernels = self.kernels()?;
        let (code, _) = self.code.as_flattened().as_chunks();
        let (code, probe) = (code.try_into().ok()?, probe.as_slice().try_into().ok()?);
        let mut measures = [[0; 2]; 16];
        (kernels.measure)(code, probe, &mut measures);
        Some(measures)
    }

    /// Dot product of the probe with every code vector over the components that `mask` believes, in units of 2⁻²⁶.
    #[must_use]
    #[inline(never)]
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

    /// One step of learning: moves `winner` and its neighbors towards the probe over the components `mask` believes.
    #[inline(never)]
    pub fn learn(
        &mut self,
        winner: usize,
        probe: &[Weight; DIMS],
        mask: Mask,
        pull: &Update<NEURONS>,
    ) {
        self.step(winner, probe, mask, pull);
    }

    /// One step of learning around the best-matching unit, which is returned.
    #[inline(never)]
    pub(crate) fn teach(
        &mut self,
        probe: &[Weight; DIMS],
        mask: Mask,
        pull: &Update<NEURONS>,
    ) -> usize {
        let winner = self.search(probe, mask);
        self.step(winner, probe, mask, pull);
        winner
    }

    #[inline]
    fn step(&mut self, winner: usize, probe: &[Weight; DIMS], mask: Mask, pull: &Update<NEURONS>) {
        let groups = self.groups(winner, mask, pull);
        if groups.is_none_or(|groups| !self.pull_groups(probe, &groups)) {
            self.learn_portably(winner, probe, mask, pull);
        }
    }

    #[inline(never)]
    fn learn_portably(
        &mut self,
        winner: usize,
        probe: &[Weight; DIMS],
        mask: Mask,
        pull: &Update<NEURONS>,
    ) {
        pull.view().each(self.grid, winner, |k, gain| {
            self.pull(k, probe, mask, gain);
        });
    }

    /// Who moves by how much, if there are kernels for the processor that can do this step.
    #[inline]
    pub(crate) fn groups(
        &self,
        winner: usize,
        mask: Mask,
        pull: &Update<NEURONS>,
    ) -> Option<[Group; 2]> {
        let can = self.kernels().is_some() && mask.covers(DIMS);
        can.then(|| pull.groups(self.grid, winner)).flatten()
    }

    /// Moves groups of neurons by the processor's kernels; `false` if there are none for this size.
    #[inline]
    pub(crate) fn pull_groups(&mut self, probe: &[Weight; DIMS], groups: &[Group; 2]) -> bool {
        if let Some(kernels) = self.kernels
            && let Ok(code) = self.code.as_flattened_mut().as_chunks_mut().0.try_into()
            && let Ok(norms) = self.norms.as_mut_slice().try_into()
            && let Ok(probe) = probe.as_slice().try_into()
        {
            (kernels.pull)(code, norms, probe, groups);
            return true;
        }
        false
    }

    /// Moves groups of neurons one by one: for few components.
    #[inline]
    pub(crate) fn pull_each(&mut self, probe: &[Weight; DIMS], groups: &[Group; 2]) {
        for group in groups {
            for k in Mask::from_bits(group.neurons).indices(NEURONS) {
                self.pull(k, probe, Mask::ALL, Gain::from_q32(group.gain_q32));
            }
        }
    }

    /// Moves neuron `k` towards the probe.
    #[inline]
    pub(crate) fn pull(&mut self, k: usize, probe: &[Weight; DIMS], mask: Mask, gain: Gain) {
        if let (Some(row), Some(norm)) = (self.code.get_mut(k), self.norms.get_mut(k)) {
            *norm = if mask.covers(DIMS) && gain.is_below_half() {
                // A call would cost more than so short a row.
                if DIMS <= 2 {
                    kernels::pull_row(row, probe, gain)
                } else {
                    kernels::pull_long_row(row, probe, gain)
                }
            } else {
                kernels::pull_row_masked(row, probe, mask, gain)
            };
        }
    }
}

impl<const NEURONS: usize> Som<NEURONS, 2> {
    /// Adds weighted scores to another map's squared lengths, as bases for its [`candidates_simd`](Self::candidates_simd);
    /// the weight in 1/256 is below 512. `None` where there are other sizes than the kernels'.
    #[inline]
    pub(crate) fn weigh_simd(
        &self,
        kernels: &Kernels,
        probe: [Weight; 2],
        weight_q8: u16,
        bases: &mut [i32; NEURONS],
    ) -> Option<()> {
        let [x, y] = probe.map(|x| kernels::rank_factor(x, weight_q8));
        let factors = [kernels::norm_factor(weight_q8), x, y];
        let code = self.code.as_slice().try_into().ok()?;
        let norms = self.norms.as_slice().try_into().ok()?;
        (kernels.weigh)(bases.as_mut_slice().try_into().ok()?, code, norms, &factors);
        Some(())
    }
}

#[cfg(test)]
pub(crate) mod tests;
