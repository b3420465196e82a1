//! The door for processor-specific code: BMU search and update of 16 neurons with 16 components.
//!
//! Results are those of the portable code, bit for bit; tests on the chip compare them. Maps of
//! other sizes, partial masks and gains of 1/2 or more always take the portable code.

use crate::fixed::{Mask, Scalar as _, Weight, Weight32, high_product};
use crate::grid::Grid;
use crate::neighborhood::{Shape, Update};

/// A table of two functions that a board hands to [`Som::use_kernels`](crate::Som::use_kernels).
#[derive(Debug)]
pub struct Kernels {
    /// Finds the neurons that may be nearest by their ranks, (base − 2 w·x) / 2 in units of 2⁻²⁶.
    ///
    /// Returns the neuron of least rank if every other rank is above it by more than `margin`.
    /// Otherwise returns bit 16 + `k` for each neuron `k` within the margin of the least rank, and
    /// possibly for that neuron alone. Half a base and each product are rounded down. No rank
    /// leaves 32 bits.
    pub candidates: extern "C" fn(
        code: &[[Weight32; 16]; 16],
        bases: &[i32; 16],
        probe: &[Weight; 16],
        margin: i32,
    ) -> u32,
    /// Moves two groups of neurons towards the probe as [`approach`](crate::fixed::approach) does.
    ///
    /// Keeps `norms` in step: the sum of a code vector's squared components in units of 2⁻²⁶, each
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

/// By how much two ranks of `dims` components may be out of order.
///
/// Per component, in units of 2⁻²⁶: squared distances are rounded by less than 16, squares by 1,
/// products by 2. Beside them the base and its half by 1 each. Two ranks are compared, and ranks
/// are half as large.
const fn margin(dims: usize) -> i32 {
    (16 + 1 + 2) * dims as i32 + 2
}

/// A second map of two components has less than this weight, in 1/256: then a base fits 31 bits.
const MAX_JOINT_WEIGHT_Q8: u16 = 512;

/// What a search by ranks leaves.
pub(crate) enum Candidates {
    /// The BMU.
    One(usize),
    /// One of these is the BMU.
    Several(Mask),
}

/// Kernels and the squared lengths that they search by, for a map of their size.
#[derive(Debug, Clone)]
pub(crate) struct Accelerator {
    kernels: &'static Kernels,
    norms: [i32; 16],
}

impl Accelerator {
    /// `None` for a map of another size.
    pub(crate) fn new<const NEURONS: usize, const DIMS: usize>(
        kernels: &'static Kernels,
        code: &[[Weight32; DIMS]; NEURONS],
    ) -> Option<Self> {
        let norms = sized(code)?.each_ref().map(|row| norm(row));
        Some(Self { kernels, norms })
    }

    /// The code vector of neuron `k` has changed.
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
    ) -> Option<Candidates> {
        self.search(code, &self.norms, probe, margin(DIMS))
    }

    /// The same with the weighted distances of a second map of two components; `None` for another
    /// one and for a large weight.
    #[inline]
    pub(crate) fn joint_candidates<const NEURONS: usize, const DIMS: usize, const OTHER: usize>(
        &self,
        code: &[[Weight32; DIMS]; NEURONS],
        probe: &[Weight; DIMS],
        other: &[[Weight32; OTHER]; NEURONS],
        other_probe: &[Weight; OTHER],
        weight_q8: u16,
    ) -> Option<Candidates> {
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
        // Each component of the second map counts less than twice.
        self.search(code, &bases, probe, margin(DIMS + 4))
    }

    #[inline]
    fn search<const NEURONS: usize, const DIMS: usize>(
        &self,
        code: &[[Weight32; DIMS]; NEURONS],
        bases: &[i32; 16],
        probe: &[Weight; DIMS],
        margin: i32,
    ) -> Option<Candidates> {
        let probe = probe.as_slice().try_into().ok()?;
        let found = (self.kernels.candidates)(sized(code)?, bases, probe, margin);
        Some(if found < 1 << 16 {
            Candidates::One(found as usize)
        } else {
            Candidates::Several(Mask::from_bits(found >> 16))
        })
    }

    /// `None` where the kernel cannot do this step: nothing has moved then.
    #[inline]
    pub(crate) fn update<const NEURONS: usize, const DIMS: usize>(
        &mut self,
        code: &mut [[Weight32; DIMS]; NEURONS],
        probe: &[Weight; DIMS],
        groups: &[Group; 2],
    ) -> Option<()> {
        let probe = probe.as_slice().try_into().ok()?;
        (self.kernels.update)(sized_mut(code)?, &mut self.norms, probe, groups);
        Some(())
    }
}

/// The neurons that move, by their gains; `None` for a Gaussian and for gains of 1/2 or more.
#[inline]
pub(crate) fn groups(update: &Update, grid: Grid, bmu: usize) -> Option<[Group; 2]> {
    let Shape::Direct { share } = update.shape else {
        return None;
    };
    // The share is not above the rate.
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

/// The code vectors, if there are 16 of 16 components.
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

/// Squared length in units of 2⁻²⁶, the square of each component rounded down.
fn norm(row: &[Weight32]) -> i32 {
    let squares = row.iter().map(|w| high_product(w.to_bits(), w.to_bits()));
    squares.fold(0, i32::wrapping_add)
}
