//! A map of any size on borrowed slices: the common implementation of `Som` and `DynSom`.
//!
//! Nothing here panics: a slice that is too short ends a loop early.

use crate::fixed::{
    Gain, Mask, Scalar, Weight32, approach, dot, isqrt, quotient, squared_distance, squared_norm,
};
use crate::grid::Grid;

/// Concatenated code vectors with `dims` components each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Codebook<'a> {
    pub(crate) grid: Grid,
    pub(crate) dims: usize,
    pub(crate) code: &'a [Weight32],
}

impl<'a> Codebook<'a> {
    /// The code vectors, neuron by neuron.
    #[inline]
    pub(crate) fn rows(self) -> impl Iterator<Item = &'a [Weight32]> {
        self.code.chunks_exact(self.dims.max(1))
    }

    /// The code vector of neuron `k`; empty for a neuron that does not exist.
    #[inline]
    pub(crate) fn row(self, k: usize) -> &'a [Weight32] {
        let start = k.saturating_mul(self.dims);
        let end = start.saturating_add(self.dims);
        self.code.get(start..end).unwrap_or(&[])
    }

    /// Squared distance of the probe to each code vector, in units of 2⁻⁵⁰.
    #[inline]
    pub(crate) fn distances<P: Scalar>(self, probe: &[P], mask: Mask) -> impl Iterator<Item = u64> {
        self.rows()
            .map(move |row| squared_distance(row, probe, mask))
    }

    /// |w|² − 2 w·x of each code vector, from 16-bit values, in units of 2⁻²⁶: the squared distance
    /// minus the probe's squared length.
    pub(crate) fn scores<P: Scalar>(self, probe: &[P], mask: Mask, scores: &mut [i64]) {
        for (row, score) in self.rows().zip(scores) {
            let (norm, product) = products(row, probe, mask);
            *score = norm.wrapping_sub(product.wrapping_mul(2));
        }
    }

    /// Dot product of the probe with each code vector, in units of 2⁻²⁶.
    pub(crate) fn projections<P: Scalar>(self, probe: &[P], mask: Mask, projections: &mut [i64]) {
        for (row, projection) in self.rows().zip(projections) {
            *projection = products(row, probe, mask).1;
        }
    }

    /// Dot product divided by the code vector's length plus the mean length of all code vectors.
    pub(crate) fn alignments<P: Scalar>(self, probe: &[P], mask: Mask, alignments: &mut [i64]) {
        let (mut sum, mut count) = (0_i64, 0_i64);
        for row in self.rows() {
            sum = sum.wrapping_add(root(squared_norm(row)));
            count = count.wrapping_add(1);
        }
        let mean = sum.checked_div(count).unwrap_or(0);
        for (row, alignment) in self.rows().zip(alignments) {
            let (norm, product) = products(row, probe, mask);
            *alignment = quotient(product, root(norm).wrapping_add(mean));
        }
    }
}

/// Squared length of a code vector and its dot product with the probe over the components in
/// `mask`, from 16-bit values, in units of 2⁻²⁶.
fn products<P: Scalar>(row: &[Weight32], probe: &[P], mask: Mask) -> (i64, i64) {
    if mask.covers(row.len()) {
        return (squared_norm(row), dot(row, probe));
    }
    let (mut norm, mut product) = (0_i64, 0_i64);
    for (index, (w, x)) in row.iter().zip(probe).enumerate() {
        if mask.contains(index) {
            let w = i64::from(w.to_weight16().to_bits());
            let x = i64::from(x.to_weight16().to_bits());
            norm = norm.wrapping_add(w * w);
            product = product.wrapping_add(w * x);
        }
    }
    (norm, product)
}

fn root(norm: i64) -> i64 {
    i64::from(isqrt(norm.unsigned_abs()))
}

/// Index of the smallest value, the lowest on ties; 0 if there are no values.
#[inline]
pub(crate) fn least(values: impl Iterator<Item = u64>) -> usize {
    let mut best = (0, u64::MAX);
    for (index, value) in values.enumerate() {
        if value < best.1 {
            best = (index, value);
        }
    }
    best.0
}

/// Moves a code vector towards the probe over the components in `mask`.
#[inline]
pub(crate) fn pull<P: Scalar>(row: &mut [Weight32], probe: &[P], mask: Mask, gain: Gain) {
    let is_whole = mask.covers(row.len());
    for (index, (w, x)) in row.iter_mut().zip(probe).enumerate() {
        if is_whole || mask.contains(index) {
            *w = approach(*w, x.to_weight32(), gain);
        }
    }
}
