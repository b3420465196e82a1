//! The arithmetic of the maps on flat slices: `code` holds the code vectors one after another, `dims` components each.
//!
//! The functions are inlined so that a caller with sizes known at compile time gets loops without bounds or remainders;
//! the same functions serve sizes known only at run time. A slice that is too short ends the loop, nothing panics.
//! Measured in scalar products: a search of 16 neurons of 16 components is 256 multiply–adds and 16 comparisons.

use crate::fixed::{
    Fine, Gain, Mask, Scalar, Weight, approach, dot, isqrt, quotient, squared_distance,
    squared_norm,
};

/// Squared distance of the probe to each code vector less the probe's own squared length:
/// |w|² − 2 w·x, in units of 2⁻²⁶.
#[inline(always)]
pub fn scores<P: Scalar>(
    code: &[Fine],
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
pub fn scores_masked(code: &[Fine], dims: usize, probe: &[Weight], mask: Mask, scores: &mut [i64]) {
    for (row, score) in rows(code, dims).zip(scores) {
        let (norm, product) = masked_products(row, probe, mask);
        *score = norm.wrapping_sub(product.wrapping_mul(2));
    }
}

/// Dot product of the probe with each code vector over the components `mask` believes.
pub fn projections(
    code: &[Fine],
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
    code: &[Fine],
    norms: impl Iterator<Item = i64>,
    dims: usize,
    probe: &[Weight],
    mask: Mask,
    out: &mut [i64],
) {
    let root = |norm: i64| i64::from(isqrt(norm.unsigned_abs()));
    let (mut sum, mut count) = (0_i64, 0_i64);
    // Until their own values are known, the places hold the lengths.
    for (length, norm) in out.iter_mut().zip(norms) {
        *length = root(norm);
        sum = sum.wrapping_add(*length);
        count = count.wrapping_add(1);
    }
    let mean = sum.checked_div(count).unwrap_or(0);
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

fn masked_products(row: &[Fine], probe: &[Weight], mask: Mask) -> (i64, i64) {
    if mask.covers(row.len()) {
        return (squared_norm(row), dot(row, probe));
    }
    let (mut norm, mut product) = (0_i64, 0_i64);
    for (index, (w, x)) in row.iter().zip(probe).enumerate() {
        if mask.contains(index) {
            let (w, x) = (i64::from(w.coarse().to_bits()), i64::from(x.to_bits()));
            norm = norm.wrapping_add(w * w);
            product = product.wrapping_add(w * x);
        }
    }
    (norm, product)
}

fn rows(code: &[Fine], dims: usize) -> impl Iterator<Item = &[Fine]> {
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

/// Whether another neuron's score is so close to the least that only distances in full precision tell which is nearer.
#[inline(always)]
fn is_rival(score: i64, least: i64, margin: i64) -> bool {
    score.wrapping_sub(least) <= margin
}

/// The neuron nearest in full precision, the lowest index on ties: `scores` are the 16-bit scores of all neurons and leave
/// few to ask; `dims` components took part in them with a factor of at most `factor`.
#[inline(always)]
#[must_use]
pub fn nearest(scores: &[i64], dims: usize, factor: i64, distance: impl Fn(usize) -> u64) -> usize {
    let first = least(scores);
    let lowest = scores.get(first).copied().unwrap_or(0);
    let margin = MARGIN.wrapping_mul(factor).wrapping_mul(dims as i64);
    let rivals = || {
        let all = scores.iter().enumerate();
        all.filter(move |(_, score)| is_rival(**score, lowest, margin))
            .map(|(k, _)| k)
    };
    if rivals().count() <= 1 {
        return first;
    }
    let mut best = (first, u64::MAX);
    for rival in rivals() {
        let distance = distance(rival);
        if distance < best.1 {
            best = (rival, distance);
        }
    }
    best.0
}

/// Squared distance in full precision of the probe to code vector `k` over the components that `mask` believes, in units
/// of 2⁻⁵⁰.
#[inline(always)]
#[must_use]
pub fn distance<P: Scalar>(code: &[Fine], dims: usize, k: usize, probe: &[P], mask: Mask) -> u64 {
    let start = k.wrapping_mul(dims);
    let row = code.get(start..start.wrapping_add(dims)).unwrap_or(&[]);
    squared_distance(row, probe, mask)
}

/// Moves a code vector towards the probe by `gain` over the components that `mask` believes.
#[inline(always)]
pub fn pull<P: Scalar>(row: &mut [Fine], probe: &[P], mask: Mask, gain: Gain) {
    if mask.covers(row.len()) {
        for (w, x) in row.iter_mut().zip(probe) {
            *w = approach(*w, x.fine(), gain);
        }
    } else {
        for (index, (w, x)) in row.iter_mut().zip(probe).enumerate() {
            if mask.contains(index) {
                *w = approach(*w, x.fine(), gain);
            }
        }
    }
}
