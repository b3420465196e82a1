//! Interface for CPU-specific kernels: BMU search and update of 16 neurons with 16 components.
//!
//! Results are bit-identical to those of the portable code; tests on the chip compare them. Maps of
//! other sizes and gains of 1/2 or more always use the portable code.

use crate::fixed::{Mask, Scalar as _, Weight, Weight32, high_product};
use crate::grid::Grid;
use crate::neighborhood::{NeighborhoodShape, Update};

/// Two kernel functions that a board passes to [`Som::use_kernels`](crate::Som::use_kernels).
#[derive(Debug)]
pub struct Kernels {
    /// Finds the candidates for the BMU by rank, (base − 2 w·x) / 2 in units of 2⁻²⁶.
    ///
    /// Returns the neuron of lowest rank if every other rank exceeds it by more than `margin`.
    /// Otherwise sets bit 16 + `k` for each neuron `k` within `margin` of the lowest rank; this may
    /// be one neuron. Half a base and each product are rounded down. Ranks fit 32 bits.
    pub candidates: extern "C" fn(
        code: &[[Weight32; 16]; 16],
        bases: &[i32; 16],
        probe: &[Weight; 16],
        margin: i32,
    ) -> u32,
    /// Moves two groups of neurons towards the probe, with the result of
    /// [`approach`](crate::fixed::approach).
    ///
    /// Also updates `norms`: the sum of a code vector's squared components in units of 2⁻²⁶, each
    /// square rounded down.
    pub update: extern "C" fn(
        code: &mut [[Weight32; 16]; 16],
        norms: &mut [i32; 16],
        probe: &[Weight; 16],
        groups: &[Group; 2],
    ),
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

impl Group {
    const NONE: Self = Self {
        gain_q32: 0,
        neurons: 0,
    };
}

/// Largest rounding error of the difference of two ranks with `dims` components.
///
/// Errors per component in units of 2⁻²⁶: squared distances below 16, squares 1, products 2. The
/// base and its half add 1 each. The difference has two errors, and a rank is half a distance.
const fn margin(dims: usize) -> i32 {
    (16 + 1 + 2) * dims as i32 + 2
}

/// Limit of the weight of a second map with two components, in 1/256: below it, a base fits 31
/// bits.
const MAX_JOINT_WEIGHT_Q8: u16 = 512;

/// Result of a search by ranks.
pub(crate) enum BmuCandidates {
    /// The BMU.
    One(usize),
    /// One of these is the BMU.
    Several(Mask),
}

/// Kernels, and the squared lengths of the code vectors that their search needs.
#[derive(Debug, Clone)]
pub(crate) struct Accelerator {
    kernels: &'static Kernels,
    norms: [i32; 16],
}

impl Accelerator {
    /// `None` if the map does not have the kernels' size.
    pub(crate) fn new<const NEURONS: usize, const DIMS: usize>(
        kernels: &'static Kernels,
        code: &[[Weight32; DIMS]; NEURONS],
    ) -> Option<Self> {
        let norms = sized(code)?.each_ref().map(|row| norm(row));
        Some(Self { kernels, norms })
    }

    /// Updates the norm of neuron `k` after a change of its code vector.
    pub(crate) fn renew(&mut self, k: usize, row: &[Weight32]) {
        if let Some(old) = self.norms.get_mut(k) {
            *old = norm(row);
        }
    }

    #[inline]
    pub(crate) fn candidates<const NEURONS: usize, const DIMS: usize>(
        &self,
        code: &[[Weight32; DIMS]; NEURONS],
        probe: &[Weight; DIMS],
        mask: Mask,
    ) -> Option<BmuCandidates> {
        self.search(code, &self.norms, probe, mask, margin(DIMS))
    }

    /// As [`candidates`](Self::candidates), with the weighted distances of a second map. `None` if
    /// that map does not have two components or the weight is too large.
    #[inline]
    pub(crate) fn joint_candidates<const NEURONS: usize, const DIMS: usize, const OTHER: usize>(
        &self,
        code: &[[Weight32; DIMS]; NEURONS],
        (probe, mask): (&[Weight; DIMS], Mask),
        other: &[[Weight32; OTHER]; NEURONS],
        other_probe: &[Weight; OTHER],
        weight_q8: u16,
    ) -> Option<BmuCandidates> {
        let [x, y] = other_probe.as_slice() else {
            return None;
        };
        let (x, y) = (x.to_weight32().to_bits(), y.to_weight32().to_bits());
        if weight_q8 >= MAX_JOINT_WEIGHT_Q8 {
            return None;
        }
        let mut bases = self.norms;
        let (pairs, _) = other.as_flattened().as_chunks();
        for (base, [u, v]) in bases.iter_mut().zip(pairs) {
            let (du, dv) = (u.to_bits().wrapping_sub(x), v.to_bits().wrapping_sub(y));
            let squared = high_product(du, du).wrapping_add(high_product(dv, dv));
            let weighted = i64::from(squared).wrapping_mul(i64::from(weight_q8)) >> 8;
            *base = base.wrapping_add(weighted as i32);
        }
        // The weight is below 2, so each of its two components adds less than two errors.
        self.search(code, &bases, probe, mask, margin(DIMS + 4))
    }

    #[inline]
    fn search<const NEURONS: usize, const DIMS: usize>(
        &self,
        code: &[[Weight32; DIMS]; NEURONS],
        bases: &[i32; 16],
        probe: &[Weight; DIMS],
        mask: Mask,
        margin: i32,
    ) -> Option<BmuCandidates> {
        let (code, probe) = (sized(code)?, probe.as_slice().try_into().ok()?);
        let found = if mask.covers(DIMS) {
            (self.kernels.candidates)(code, bases, probe, margin)
        } else {
            self.candidates_in_part(code, bases, probe, mask, margin)
        };
        Some(if found < 1 << 16 {
            BmuCandidates::One(found as usize)
        } else {
            BmuCandidates::Several(Mask::from_bits(found >> 16))
        })
    }

    /// The components outside the mask change no rank: their squares are not part of the bases, and
    /// the probe is zero there.
    #[inline(never)]
    fn candidates_in_part(
        &self,
        code: &[[Weight32; 16]; 16],
        bases: &[i32; 16],
        probe: &[Weight; 16],
        mask: Mask,
        margin: i32,
    ) -> u32 {
        let (mut bases, mut probe) = (*bases, *probe);
        for gap in mask.complement().indices(16) {
            if let Some(value) = probe.get_mut(gap) {
                *value = Weight::ZERO;
            }
            for (base, row) in bases.iter_mut().zip(code) {
                let w = row.get(gap).map_or(0, |w| w.to_bits());
                *base = base.wrapping_sub(high_product(w, w));
            }
        }
        (self.kernels.candidates)(code, &bases, &probe, margin)
    }

    /// `None` if the map does not have the kernel's size; the map is then unchanged.
    #[inline]
    pub(crate) fn update<const NEURONS: usize, const DIMS: usize>(
        &mut self,
        code: &mut [[Weight32; DIMS]; NEURONS],
        probe: &[Weight; DIMS],
        mask: Mask,
        groups: &[Group; 2],
    ) -> Option<()> {
        let (code, probe) = (sized_mut(code)?, probe.as_slice().try_into().ok()?);
        if mask.covers(DIMS) {
            (self.kernels.update)(code, &mut self.norms, probe, groups);
        } else {
            self.update_in_part(code, probe, mask, groups);
        }
        Some(())
    }

    /// The kernel moves whole code vectors; what lies outside the mask is put back.
    #[inline(never)]
    fn update_in_part(
        &mut self,
        code: &mut [[Weight32; 16]; 16],
        probe: &[Weight; 16],
        mask: Mask,
        groups: &[Group; 2],
    ) {
        for Group { gain_q32, neurons } in *groups {
            for k in Mask::from_bits(neurons).indices(16) {
                let Some(before) = code.get(k).copied() else {
                    continue;
                };
                let neurons = Mask::NONE.with(k).to_bits();
                let alone = [Group { gain_q32, neurons }, Group::NONE];
                (self.kernels.update)(code, &mut self.norms, probe, &alone);
                if let (Some(row), Some(norm)) = (code.get_mut(k), self.norms.get_mut(k)) {
                    put_back(row, norm, &before, mask);
                }
            }
        }
    }
}

/// Restores the components outside the mask, and the code vector's squared length.
fn put_back(row: &mut [Weight32; 16], norm: &mut i32, before: &[Weight32; 16], mask: Mask) {
    for gap in mask.complement().indices(16) {
        if let (Some(now), Some(before)) = (row.get_mut(gap), before.get(gap)) {
            let (new, old) = (now.to_bits(), before.to_bits());
            *norm =
                (norm.wrapping_add(high_product(old, old))).wrapping_sub(high_product(new, new));
            *now = *before;
        }
    }
}

/// The neurons that move, grouped by gain; `None` for a Gaussian and for gains of 1/2 or more.
#[inline]
pub(crate) fn groups(update: &Update, grid: Grid, bmu: usize) -> Option<[Group; 2]> {
    let NeighborhoodShape::Direct { share } = update.shape else {
        return None;
    };
    // The neighbors' gain is at most the rate.
    if !update.rate.is_below_half() {
        return None;
    }
    let share_q32 = share.to_q32();
    let neighbors = if share_q32 == 0 {
        Mask::NONE
    } else {
        grid.neighbor_mask(bmu)
    };
    Some([
        Group {
            gain_q32: update.rate.to_q32(),
            neurons: Mask::NONE.with(bmu).to_bits(),
        },
        Group {
            gain_q32: share_q32,
            neurons: neighbors.to_bits(),
        },
    ])
}

/// Whether a map has the kernels' size.
pub(crate) const fn fit(neurons: usize, dims: usize) -> bool {
    neurons == 16 && dims == 16
}

/// The code vectors if the map has the kernels' size.
#[inline]
fn sized<const NEURONS: usize, const DIMS: usize>(
    code: &[[Weight32; DIMS]; NEURONS],
) -> Option<&[[Weight32; 16]; 16]> {
    let (rows, _) = code.as_flattened().as_chunks();
    rows.try_into().ok().filter(|_| fit(NEURONS, DIMS))
}

#[inline]
fn sized_mut<const NEURONS: usize, const DIMS: usize>(
    code: &mut [[Weight32; DIMS]; NEURONS],
) -> Option<&mut [[Weight32; 16]; 16]> {
    let (rows, _) = code.as_flattened_mut().as_chunks_mut();
    rows.try_into().ok().filter(|_| fit(NEURONS, DIMS))
}

/// Squared length in units of 2⁻²⁶; the square of each component is rounded down.
fn norm(row: &[Weight32]) -> i32 {
    let squares = row.iter().map(|w| high_product(w.to_bits(), w.to_bits()));
    squares.fold(0, i32::wrapping_add)
}
