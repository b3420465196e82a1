//! The arithmetic of the maps on flat slices: `code` holds the code vectors one after another, `dims` components each.
//!
//! The functions are inlined so that a caller with sizes known at compile time gets loops without bounds or remainders;
//! the same functions serve sizes known only at run time. A slice that is too short ends the loop, nothing panics.
//! Measured in scalar products: a search of 16 neurons of 16 components is 256 multiply–adds and 16 comparisons.

use crate::fixed::{
    Gain, Mask, ONE_BITS, Scalar, Weight, Weight32, approach, approach_slowly, block_dot, dot,
    high_product, isqrt, quotient, squared_distance, squared_norm,
};

/// Squared distance of the probe to each code vector less the probe's own squared length:
/// |w|² − 2 w·x, in units of 2⁻²⁶.
#[inline(always)]
pub fn scores<P: Scalar>(
    code: &[Weight32],
    norms: impl Iterator<Item = i64>,
    dims: usize,
    probe: &[P],
    scores: &mut [i64],
) {
    for ((row, norm), score) in rows(code, dims).zip(norms).zip(scores) {
        *score = norm.wrapping_sub(dot(row, probe).wrapping_mul(2));
    }
}

/// As [`scores`], over the components that `mask` believes.
pub fn scores_masked(
    code: &[Weight32],
    dims: usize,
    probe: &[Weight],
    mask: Mask,
    scores: &mut [i64],
) {
    for (row, score) in rows(code, dims).zip(scores) {
        let (norm, product) = masked_products(row, probe, mask);
        *score = norm.wrapping_sub(product.wrapping_mul(2));
    }
}

/// Dot product of the probe with each code vector over the components `mask` believes.
pub fn projections(
    code: &[Weight32],
    dims: usize,
    probe: &[Weight],
    mask: Mask,
    projections: &mut [i64],
) {
    for (row, projection) in rows(code, dims).zip(projections) {
        *projection = masked_products(row, probe, mask).1;
    }
}

/// How far each code vector points the probe's way: the dot product over the sum of the code vector's length and the mean
/// length of all, in units of 2⁻¹³ · the probe's. The mean keeps code vectors much shorter than it, whose direction is
/// mostly chance, from answering; where all are equally long, this is half the probe's length times the cosine.
pub fn alignments(
    code: &[Weight32],
    norms: impl Iterator<Item = i64>,
    dims: usize,
    probe: &[Weight],
    mask: Mask,
    out: &mut [i64],
) {
    let mean = mean_length(norms, out);
    let whole = mask.covers(dims);
    for (row, alignment) in rows(code, dims).zip(out) {
        let (length, product) = if whole {
            (*alignment, dot(row, probe))
        } else {
            let (norm, product) = masked_products(row, probe, mask);
            (root(norm), product)
        };
        *alignment = quotient(product, length.wrapping_add(mean));
    }
}

/// As [`alignments`], of squared lengths and dot products by [`Kernels::measure`].
pub(crate) fn measured_alignments(measures: &[[i32; 2]], out: &mut [i64]) {
    let norms = measures.iter().map(|[norm, _]| i64::from(*norm));
    let mean = mean_length(norms, out);
    for (alignment, [_, product]) in out.iter_mut().zip(measures) {
        *alignment = quotient(i64::from(*product), alignment.wrapping_add(mean));
    }
}

/// Writes the lengths and returns their mean.
#[inline(always)]
fn mean_length(norms: impl Iterator<Item = i64>, lengths: &mut [i64]) -> i64 {
    let (mut sum, mut count) = (0_i64, 0_i64);
    for (length, norm) in lengths.iter_mut().zip(norms) {
        *length = root(norm);
        sum = sum.wrapping_add(*length);
        count = count.wrapping_add(1);
    }
    sum.checked_div(count).unwrap_or(0)
}

fn root(norm: i64) -> i64 {
    i64::from(isqrt(norm.unsigned_abs()))
}

/// Kernels written for a processor, for maps of 16 neurons with 16 components, in which a robot of the paper's size spends
/// its time. What a map answers and learns is the same with them and without; [`Som::use_kernels`](super::Som::use_kernels).
#[derive(Debug)]
pub struct Kernels {
    /// The neuron whose rank, (base − 2 w·x) / 2 in units of 2⁻²⁶, is the least, if all others are above it by more than
    /// `margin`. Or else bit 16 + `k` for each neuron that is not; a single one, if some were close to another only. Half of
    /// a base and each product w x are rounded down; bases are such that no rank leaves 32 bits.
    pub candidates: extern "C" fn(
        code: &[[Weight32; 16]; 16],
        bases: &[i32; 16],
        probe: &[Weight; 16],
        margin: i32,
    ) -> u32,
    /// Adds to each base, in units of 2⁻²⁶, a short code vector's part of its rank, in units of 2⁻¹⁷: the upper halves of
    /// its squared length times the first factor and of its components times the others.
    pub weigh: extern "C" fn(
        bases: &mut [i32; 16],
        code: &[[Weight32; 2]; 16],
        norms: &[i32; 16],
        factors: &[i32; 3],
    ),
    /// Moves the code vectors of two groups of neurons towards the probe as [`approach`], and keeps their squared lengths
    /// in step, the sums of their components' squares in units of 2⁻²⁶, each rounded down.
    pub pull: extern "C" fn(
        code: &mut [[Weight32; 16]; 16],
        norms: &mut [i32; 16],
        probe: &[Weight; 16],
        groups: &[Group; 2],
    ),
    /// Of the upper halves of each code vector the squared length and the dot product with the probe, in units of 2⁻²⁶.
    pub measure: extern "C" fn(
        code: &[[Weight32; 16]; 16],
        probe: &[Weight; 16],
        measures: &mut [[i32; 2]; 16],
    ),
}

/// Squared length of a code vector in units of 2⁻²⁶, the square of each component rounded down.
#[inline(always)]
pub(crate) fn length_squared(row: &[Weight32]) -> i32 {
    row.iter().copied().map(square).fold(0, i32::wrapping_add)
}

/// Neurons that move by the same gain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Group {
    /// The gain, below 1/2, in units of 2⁻³².
    pub gain_q32: i32,
    /// Bit `k` for neuron `k`.
    pub neurons: u32,
}

/// Bits between the units of ranks, 2⁻¹⁷, and those of squared lengths.
pub(crate) const RANK_BITS: u32 = 9;

/// Adds −2 w·x of each code vector, by its upper halves, to its rank, in units of 2⁻¹⁷, rounded up.
#[inline(always)]
pub(crate) fn rank_products<const NEURONS: usize, const DIMS: usize>(
    code: &[[Weight32; DIMS]; NEURONS],
    probe: &[Weight; DIMS],
    ranks: &mut [i32; NEURONS],
) {
    const { assert!(DIMS <= 31, "a rank has 32 bits") };
    for (row, rank) in code.iter().zip(ranks) {
        *rank = rank.wrapping_sub(row_product(row, probe) >> (RANK_BITS - 1));
    }
}

/// As a function of its own, which compilers do not write out twice: the chip's kernels have no use for it.
#[inline(never)]
fn row_product<const DIMS: usize>(row: &[Weight32; DIMS], probe: &[Weight; DIMS]) -> i32 {
    block_dot(row, probe)
}

/// By how much more the ranks of two neurons may be out of order by [`rank_products`]: the lower halves that are left off
/// are less than a unit of 2⁻¹³ each, times a probe's component of at most 1, twice.
pub(crate) const fn halves_margin<const DIMS: usize>() -> i32 {
    (2 * ONE_BITS as i32 * DIMS as i32) >> RANK_BITS
}

/// −2 λ x for [`rank_sum`]; λ is `weight_q8` in 1/256.
#[inline(always)]
pub(crate) const fn rank_factor(x: Weight, weight_q8: u16) -> i32 {
    (x.to_bits() as i32).wrapping_mul(-(weight_q8 as i32))
}

/// A rank plus the products of a code vector and a probe's factors, each rounded down.
#[inline(always)]
pub(crate) fn rank_sum<const DIMS: usize>(
    rank: i32,
    row: &[Weight32; DIMS],
    factors: &[i32; DIMS],
) -> i32 {
    let products = row.iter().zip(factors);
    let products = products.map(|(w, factor)| high_product(w.to_bits(), *factor));
    products.fold(rank, i32::wrapping_add)
}

/// λ |w|² in units of 2⁻¹⁷, rounded down, of a squared length in units of 2⁻²⁶; λ is `weight_q8` in 1/256.
#[inline(always)]
pub(crate) const fn rank_norm(norm: i32, weight_q8: u16) -> i32 {
    high_product(norm, norm_factor(weight_q8))
}

/// Of a squared length's part in a rank.
#[inline(always)]
pub(crate) const fn norm_factor(weight_q8: u16) -> i32 {
    (weight_q8 as i32) << 15
}

fn masked_products(row: &[Weight32], probe: &[Weight], mask: Mask) -> (i64, i64) {
    if mask.covers(row.len()) {
        return (squared_norm(row), dot(row, probe));
    }
    let (mut norm, mut product) = (0_i64, 0_i64);
    for (index, (w, x)) in row.iter().zip(probe).enumerate() {
        if mask.contains(index) {
            let (w, x) = (i64::from(w.to_weight16().to_bits()), i64::from(x.to_bits()));
            norm = norm.wrapping_add(w * w);
            product = product.wrapping_add(w * x);
        }
    }
    (norm, product)
}

fn rows(code: &[Weight32], dims: usize) -> impl Iterator<Item = &[Weight32]> {
    code.chunks_exact(dims.max(1))
}

/// Index of the least score, the lowest on ties; 0 for none.
#[inline(always)]
#[must_use]
pub fn least(scores: &[i64]) -> usize {
    let mut best = (0, i64::MAX);
    for (index, &score) in scores.iter().enumerate() {
        if score < best.1 {
            best = (index, score);
        }
    }
    best.0
}

/// Index of the greatest score among the neurons that `allowed` counts, the lowest on ties; among all where it counts
/// none.
#[must_use]
pub fn greatest(scores: &[i64], allowed: Mask) -> usize {
    let mut best: Option<(usize, i64)> = None;
    for (index, &score) in scores.iter().enumerate() {
        if allowed.contains(index) && best.is_none_or(|(_, least)| score > least) {
            best = Some((index, score));
        }
    }
    match best {
        Some((index, _)) => index,
        None if allowed == Mask::ALL => 0,
        None => greatest(scores, Mask::ALL),
    }
}

/// Indices of the least and the second least score, the lower first on ties; equal for a single neuron.
#[must_use]
pub fn two_least(scores: &[i64]) -> (usize, usize) {
    let first = least(scores);
    let mut second: Option<(usize, i64)> = None;
    for (index, &score) in scores.iter().enumerate() {
        if index != first && second.is_none_or(|(_, best)| score < best) {
            second = Some((index, score));
        }
    }
    (first, second.map_or(first, |(index, _)| index))
}

/// How far scores by 16-bit values may be out of order, per component: a code vector's and a probe's lower halves shift a
/// difference by less than one unit, its square by less than 2 · 2 · 8192 + 1, and two scores are compared.
const MARGIN: i64 = 2 * (4 * 8192 + 1);

/// The neuron nearest in full precision, the lowest index on ties: `scores` are the 16-bit scores of all neurons and leave
/// few to ask; `dims` components took part in them with a factor of at most `factor`.
#[inline(always)]
#[must_use]
pub fn nearest(scores: &[i64], dims: usize, factor: i64, distance: impl Fn(usize) -> u64) -> usize {
    let (mut first, mut least, mut second) = (0, i64::MAX, i64::MAX);
    for (index, &score) in scores.iter().enumerate() {
        second = second.min(score.max(least));
        if score < least {
            (first, least) = (index, score);
        }
    }
    let margin = MARGIN.wrapping_mul(factor).wrapping_mul(dims as i64);
    let most = least.saturating_add(margin);
    // Mostly nobody else is so close that only distances in full precision tell who is nearer.
    if second > most {
        return first;
    }
    let mut best = (first, u64::MAX);
    for (rival, _) in scores
        .iter()
        .enumerate()
        .filter(|(_, score)| **score <= most)
    {
        let distance = distance(rival);
        if distance < best.1 {
            best = (rival, distance);
        }
    }
    best.0
}

/// By how much ranks may be out of order per component and λ, in units of 2⁻²⁶: squares are rounded down, squared
/// distances by at most 16, and two ranks are compared.
const RANK_MARGIN: i32 = 2 * (1 + 16);

/// By how much the ranks of two neurons may be out of order by `dims` components of weight λ, in units of 2⁻¹⁷; λ is
/// `weight_q8` in 1/256. Beside it stand the rounding of the products and of the squared lengths, less than one each.
pub(crate) const fn rank_margin<const DIMS: usize>(weight_q8: u16) -> i32 {
    const { assert!(DIMS <= 31, "it fits 32 bits") };
    let dims = DIMS as i32;
    ((RANK_MARGIN * dims * weight_q8 as i32) >> 17) + dims + 2
}

/// What a search by ranks leaves.
pub(crate) enum Found {
    /// The nearest neuron.
    One(usize),
    /// Some of which one is nearest.
    Rivals(Mask),
}

impl Found {
    /// What [`Kernels::candidates`] says.
    #[inline(always)]
    pub(crate) const fn by_hand(bits: u32) -> Self {
        if bits < 1 << 16 {
            Self::One(bits as usize)
        } else {
            Self::Rivals(Mask::from_bits(bits >> 16))
        }
    }

    #[inline(always)]
    pub(crate) const fn among(candidates: Mask) -> Self {
        let bits = candidates.to_bits();
        if bits & bits.wrapping_sub(1) == 0 {
            Self::One(bits.trailing_zeros() as usize)
        } else {
            Self::Rivals(candidates)
        }
    }
}

/// The nearest of the neurons, the lowest index on ties.
#[inline(always)]
pub(crate) fn nearest_of(candidates: Mask, distance: impl Fn(usize) -> u64) -> usize {
    let mut best = (0, u64::MAX);
    for rival in candidates.indices(32) {
        let distance = distance(rival);
        if distance < best.1 {
            best = (rival, distance);
        }
    }
    best.0
}

/// The neurons, at most 32, whose ranks are above the least by `margin` at most. One copy of it in a program.
#[inline(never)]
pub(crate) fn candidates<const NEURONS: usize>(ranks: &[i32; NEURONS], margin: i32) -> Mask {
    const { assert!(NEURONS <= 32, "a mask has 32 bits") };
    let (mut first, mut least, mut second) = (0, i32::MAX, i32::MAX);
    for (index, &rank) in ranks.iter().enumerate() {
        // Most are not.
        if rank < second {
            if rank < least {
                (first, least, second) = (index, rank, least);
            } else {
                second = rank;
            }
        }
    }
    let most = least.saturating_add(margin);
    let mut candidates = Mask::NONE.with(first);
    if second <= most {
        for (index, _) in ranks.iter().enumerate().filter(|(_, rank)| **rank <= most) {
            candidates = candidates.with(index);
        }
    }
    candidates
}

/// Squared distance in full precision of the probe to code vector `k` over the components that `mask` believes, in units
/// of 2⁻⁵⁰.
#[inline(always)]
#[must_use]
pub fn distance<P: Scalar>(
    code: &[Weight32],
    dims: usize,
    k: usize,
    probe: &[P],
    mask: Mask,
) -> u64 {
    let start = k.wrapping_mul(dims);
    let row = code.get(start..start.wrapping_add(dims)).unwrap_or(&[]);
    squared_distance(row, probe, mask)
}

/// As [`pull`] over all components by a gain below 1/2; returns the code vector's new [`length_squared`].
#[inline(always)]
pub(crate) fn pull_row<const DIMS: usize>(
    row: &mut [Weight32; DIMS],
    probe: &[Weight; DIMS],
    gain: Gain,
) -> i32 {
    let mut norm = 0_i32;
    for (w, x) in row.iter_mut().zip(probe) {
        *w = approach_slowly(*w, x.to_weight32(), gain);
        norm = norm.wrapping_add(square(*w));
    }
    norm
}

/// [`pull_row`] as a function of its own.
#[inline(never)]
pub(crate) fn pull_long_row<const DIMS: usize>(
    row: &mut [Weight32; DIMS],
    probe: &[Weight; DIMS],
    gain: Gain,
) -> i32 {
    pull_row(row, probe, gain)
}

/// As [`pull`]; returns the code vector's new [`length_squared`].
#[inline(never)]
pub(crate) fn pull_row_masked<const DIMS: usize>(
    row: &mut [Weight32; DIMS],
    probe: &[Weight; DIMS],
    mask: Mask,
    gain: Gain,
) -> i32 {
    let mut norm = 0_i32;
    for (index, (w, x)) in row.iter_mut().zip(probe).enumerate() {
        if mask.contains(index) {
            *w = approach(*w, x.to_weight32(), gain);
        }
        norm = norm.wrapping_add(square(*w));
    }
    norm
}

const fn square(w: Weight32) -> i32 {
    high_product(w.to_bits(), w.to_bits())
}
