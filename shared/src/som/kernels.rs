//! The arithmetic of the maps on flat slices: `code` holds the code vectors one after another, `dims` components each.
//!
//! The functions are inlined so that a caller with sizes known at compile time gets loops without bounds or remainders;
//! the same functions serve sizes known only at run time. A slice that is too short ends the loop, nothing panics.
//! Measured in scalar products: a search of 16 neurons of 16 components is 256 multiply–adds and 16 comparisons.

use crate::fixed::{Dither, Gain, Mask, Weight, approach, dot, isqrt, squared_norm};

/// Squared distance of the probe to each code vector less the probe's own squared length:
/// |w|² − 2 w·x, in units of 2⁻²⁶.
#[inline(always)]
pub fn scores(code: &[Weight], norms: &[i64], dims: usize, probe: &[Weight], scores: &mut [i64]) {
    for ((row, norm), score) in rows(code, dims).zip(norms).zip(scores) {
        *score = norm.wrapping_sub(dot(row, probe).wrapping_mul(2));
    }
}

/// As [`scores`], over the components that `mask` believes.
pub fn scores_masked(
    code: &[Weight],
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
    code: &[Weight],
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
    code: &[Weight],
    norms: &[i64],
    dims: usize,
    probe: &[Weight],
    mask: Mask,
    out: &mut [i64],
) {
    let root = |norm: i64| i64::from(isqrt(norm.unsigned_abs()));
    let sum = norms
        .iter()
        .fold(0_i64, |sum, norm| sum.wrapping_add(root(*norm)));
    let mean = sum.checked_div(norms.len() as i64).unwrap_or(0);
    let whole = mask.covers(dims);
    for ((row, norm), alignment) in rows(code, dims).zip(norms).zip(out) {
        let (norm, product) = if whole {
            (*norm, dot(row, probe))
        } else {
            masked_products(row, probe, mask)
        };
        *alignment = product
            .checked_div(root(norm).wrapping_add(mean))
            .unwrap_or(0);
    }
}

fn masked_products(row: &[Weight], probe: &[Weight], mask: Mask) -> (i64, i64) {
    if mask.covers(row.len()) {
        return (squared_norm(row), dot(row, probe));
    }
    let (mut norm, mut product) = (0_i64, 0_i64);
    for (index, (w, x)) in row.iter().zip(probe).enumerate() {
        if mask.contains(index) {
            let (w, x) = (i64::from(w.to_bits()), i64::from(x.to_bits()));
            norm = norm.wrapping_add(w * w);
            product = product.wrapping_add(w * x);
        }
    }
    (norm, product)
}

fn rows(code: &[Weight], dims: usize) -> impl Iterator<Item = &[Weight]> {
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

/// Moves a code vector towards the probe by `gain`, rounded by `dither`, over the components that `mask` believes.
#[inline(always)]
pub fn pull(row: &mut [Weight], probe: &[Weight], mask: Mask, gain: Gain, dither: Dither) {
    if mask.covers(row.len()) {
        pull_all(row, probe, gain, dither);
    } else {
        for (index, (w, x)) in row.iter_mut().zip(probe).enumerate() {
            if mask.contains(index) {
                *w = approach(*w, *x, gain, dither.threshold(index));
            }
        }
    }
}

/// [`approach`] for every component, in products of 16-bit factors, which the vector units of common processors have:
/// w · 2¹⁵ + (x − w) · g = w · (2¹⁵ − g) + x · g. Both factors fit as long as neither is 2¹⁵ itself.
#[inline(always)]
fn pull_all(row: &mut [Weight], probe: &[Weight], gain: Gain, dither: Dither) {
    let towards = gain.to_bits() as i16;
    let keep = Gain::ONE.to_bits().wrapping_sub(gain.to_bits()) as i16;
    let (row_blocks, row_rest) = row.as_chunks_mut();
    let (probe_blocks, probe_rest) = probe.as_chunks();
    let whole = row_blocks.len().min(probe_blocks.len()).wrapping_mul(LANES);
    for (block, (w, x)) in row_blocks.iter_mut().zip(probe_blocks).enumerate() {
        let shifted = Dither::from_bits(dither.threshold(block.wrapping_mul(LANES)));
        if towards > 0 && keep > 0 {
            blend(w, x, keep, towards, shifted);
        } else {
            step_by_step(w, x, gain, shifted);
        }
    }
    step_by_step(
        row_rest,
        probe_rest,
        gain,
        Dither::from_bits(dither.threshold(whole)),
    );
}

#[inline(always)]
fn step_by_step(row: &mut [Weight], probe: &[Weight], gain: Gain, dither: Dither) {
    for (lane, (w, x)) in row.iter_mut().zip(probe).enumerate() {
        *w = approach(*w, *x, gain, dither.threshold(lane));
    }
}

/// Components moved at once.
const LANES: usize = 16;

/// Each lane's threshold for a dither of 0.
const THRESHOLDS: [u16; LANES] = {
    let mut thresholds = [0; LANES];
    let mut lane = 0;
    while lane < LANES {
        thresholds[lane] = Dither::from_bits(0).threshold(lane);
        lane += 1;
    }
    thresholds
};

/// A function of its own, because inside the caller's loop compilers lose sight of the factors' 16 bits.
#[inline(never)]
fn blend(
    row: &mut [Weight; LANES],
    probe: &[Weight; LANES],
    keep: i16,
    towards: i16,
    dither: Dither,
) {
    let before = *row;
    for (((w, from), to), threshold) in row.iter_mut().zip(before).zip(probe).zip(THRESHOLDS) {
        let kept = i32::from(from.to_bits()).wrapping_mul(i32::from(keep));
        let come = i32::from(to.to_bits()).wrapping_mul(i32::from(towards));
        let threshold = threshold.wrapping_add(dither.to_bits()) & 0x7fff;
        let sum = kept.wrapping_add(come).wrapping_add(i32::from(threshold));
        *w = Weight::from_bits((sum >> 15) as i16);
    }
}
