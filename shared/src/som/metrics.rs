//! How good a map is: the field's usual measures.
//!
//! * *quantization error*: mean Euclidean distance of the samples to their best-matching units;
//! * *topographic error*: share of the samples whose best two neurons are not direct neighbors (K. Kiviluoto 1996);
//! * *U-matrix*: mean distance of each neuron to its direct neighbors (A. Ultsch 1990);
//! * *hit map*: how many samples each neuron wins.

use super::{Grid, kernels};
use crate::fixed::{Mask, Scalar, Weight, Weight32, isqrt, squared_distance};

/// A map as the measures see it: any size, on flat slices.
#[derive(Debug, Clone, Copy)]
pub struct MapView<'a> {
    /// The grid.
    pub grid: Grid,
    /// Code vectors one after another.
    pub code: &'a [Weight32],
    /// Components of a code vector.
    pub dims: usize,
}

/// Running sums over samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Quality {
    samples: u32,
    /// Sum of distances in units of 2⁻²¹.
    distance: u64,
    apart: u32,
}

impl Quality {
    /// Takes one sample; `distances` is room for one value per neuron. Returns the winner.
    pub fn add<P: Scalar>(
        &mut self,
        map: MapView<'_>,
        sample: &[P],
        distances: &mut [i64],
    ) -> usize {
        for (row, distance) in map.code.chunks_exact(map.dims.max(1)).zip(&mut *distances) {
            *distance = i64::try_from(squared_distance(row, sample, Mask::ALL)).unwrap_or(i64::MAX);
        }
        let (first, second) = kernels::two_least(distances);
        let least = distances.get(first).copied().unwrap_or(0).unsigned_abs();
        // The root of a number of 2⁻⁵⁰ is one of 2⁻²⁵.
        self.distance = self.distance.saturating_add(u64::from(isqrt(least)) >> 4);
        self.samples = self.samples.saturating_add(1);
        if first != second && !map.grid.are_neighbors(first, second) {
            self.apart = self.apart.saturating_add(1);
        }
        first
    }

    /// Mean Euclidean distance in units of a weight's 1.0, Q21; 0 without samples.
    #[must_use]
    pub fn quantization_error_q21(self) -> u64 {
        self.distance
            .checked_div(u64::from(self.samples))
            .unwrap_or(0)
    }

    /// Number of samples taken.
    #[must_use]
    pub const fn samples(self) -> u32 {
        self.samples
    }

    /// Number of samples whose best two neurons are not direct neighbors.
    #[must_use]
    pub const fn apart(self) -> u32 {
        self.apart
    }

    /// Share of samples whose best two neurons are not direct neighbors, Q16; 0 without samples.
    #[must_use]
    pub fn topographic_error_q16(self) -> u32 {
        let share = (u64::from(self.apart) << 16)
            .checked_div(u64::from(self.samples))
            .unwrap_or(0);
        share as u32
    }
}

/// Mean distance of neuron `k` to its direct neighbors, in units of a weight's 1.0, Q13; 0 without neighbors.
#[must_use]
pub fn u_matrix_value(map: MapView<'_>, k: usize) -> u32 {
    let row = |k: usize| {
        let start = k.saturating_mul(map.dims);
        map.code
            .get(start..start.saturating_add(map.dims))
            .unwrap_or(&[])
    };
    let own = row(k);
    let (mut sum, mut count) = (0_u64, 0_u64);
    for neighbor in map.grid.neighbors(k) {
        let distance = squared_distance(own, row(neighbor), Mask::ALL);
        sum = sum.saturating_add(u64::from(isqrt(distance)) >> 12);
        count += 1;
    }
    sum.checked_div(count).unwrap_or(0) as u32
}

impl<const NEURONS: usize, const DIMS: usize> super::Som<NEURONS, DIMS> {
    /// This map as the measures see it.
    #[must_use]
    pub const fn view(&self) -> MapView<'_> {
        MapView {
            grid: self.grid,
            code: self.code.as_flattened(),
            dims: DIMS,
        }
    }

    /// Quality over samples, and how many of them each neuron wins.
    pub fn quality<'a>(
        &self,
        samples: impl IntoIterator<Item = &'a [Weight; DIMS]>,
    ) -> (Quality, [u32; NEURONS]) {
        let mut quality = Quality::default();
        let mut hits = [0; NEURONS];
        let mut distances = [0; NEURONS];
        for sample in samples {
            let winner = quality.add(self.view(), sample, &mut distances);
            if let Some(hit) = hits.get_mut(winner) {
                *hit += 1;
            }
        }
        (quality, hits)
    }

    /// The U-matrix in units of a weight's 1.0, Q13.
    #[must_use]
    pub fn u_matrix(&self) -> [u32; NEURONS] {
        core::array::from_fn(|k| u_matrix_value(self.view(), k))
    }
}
