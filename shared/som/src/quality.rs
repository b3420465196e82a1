//! Quality measures of a map.
//!
//! * *quantization error*: mean Euclidean distance of the samples to their BMUs;
//! * *topographic error*: share of the samples whose two best neurons are not direct neighbors
//!   (K. Kiviluoto 1996).

use crate::codebook::Codebook;
use crate::fixed::{Mask, Scalar, isqrt, squared_distance};

/// Accumulated sums over samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Quality {
    samples: u32,
    /// Sum and largest of the distances in units of 2⁻²¹.
    sum_q21: u64,
    largest_q21: u64,
    apart: u32,
}

/// Square root of a squared distance in units of 2⁻⁵⁰, in units of 2⁻²¹.
fn distance_q21(squared: u64) -> u64 {
    u64::from(isqrt(squared)) >> 4
}

/// 2²¹.
const ONE_Q21: f32 = 2_097_152.0;

impl Quality {
    /// Adds one sample and returns its BMU.
    pub(crate) fn add<P: Scalar>(&mut self, map: Codebook<'_>, sample: &[P]) -> usize {
        let (mut first, mut second) = ((0, u64::MAX), None);
        for (k, distance) in map.distances(sample, Mask::ALL).enumerate() {
            if k == 0 {
                first = (k, distance);
            } else if distance < first.1 {
                second = Some(first);
                first = (k, distance);
            } else if second.is_none_or(|(_, least)| distance < least) {
                second = Some((k, distance));
            }
        }
        let distance = distance_q21(first.1);
        self.sum_q21 = self.sum_q21.saturating_add(distance);
        self.largest_q21 = self.largest_q21.max(distance);
        self.samples = self.samples.saturating_add(1);
        if second.is_some_and(|(second, _)| !map.grid.are_neighbors(first.0, second)) {
            self.apart = self.apart.saturating_add(1);
        }
        first.0
    }

    /// Mean Euclidean distance of the samples to their BMUs; 0 without samples.
    #[must_use]
    pub fn quantization_error(&self) -> f64 {
        self.quantization_error_q21() as f64 / f64::from(1 << 21)
    }

    /// The same in Q21.
    #[must_use]
    pub fn quantization_error_q21(&self) -> u64 {
        let samples = u64::from(self.samples);
        self.sum_q21.checked_div(samples).unwrap_or(0)
    }

    /// Share of the samples whose two best neurons are not direct neighbors, 0 to 1; 0 without
    /// samples.
    #[must_use]
    pub fn topographic_error(&self) -> f64 {
        f64::from(self.apart) / f64::from(self.samples.max(1))
    }

    /// Number of samples.
    #[must_use]
    pub const fn samples(&self) -> u32 {
        self.samples
    }

    /// Number of samples whose two best neurons are not direct neighbors.
    #[must_use]
    pub const fn apart(&self) -> u32 {
        self.apart
    }

    /// Distance to a BMU divided by the quantization error. The argument is the squared distance in
    /// units of 2⁻⁵⁰.
    ///
    /// 0 for a distance of 0; otherwise infinite if the quantization error is 0.
    #[must_use]
    pub fn novelty(&self, squared_distance: u64) -> f32 {
        let distance = distance_q21(squared_distance);
        if distance == 0 {
            return 0.0;
        }
        distance as f32 / self.quantization_error_q21() as f32
    }

    /// Largest novelty of the samples so far. A sample above it is unlike any of them.
    #[must_use]
    pub fn largest_novelty(&self) -> f32 {
        match self.largest_q21 {
            0 => 0.0,
            largest => largest as f32 / self.quantization_error_q21() as f32,
        }
    }

    /// The largest distance of a sample to its BMU; 0 without samples.
    #[must_use]
    pub fn largest_distance(&self) -> f32 {
        self.largest_q21 as f32 / ONE_Q21
    }
}

impl Codebook<'_> {
    /// Mean distance of neuron `k` to its direct neighbors, Q13; 0 without neighbors.
    pub(crate) fn u_matrix_value(self, k: usize) -> u32 {
        let own = self.row(k);
        let (mut sum, mut count) = (0_u64, 0_u64);
        for neighbor in self.grid.neighbors(k) {
            let distance = squared_distance(own, self.row(neighbor), Mask::ALL);
            // The square root of units of 2⁻⁵⁰ has units of 2⁻²⁵; the shift converts to 2⁻¹³.
            sum = sum.saturating_add(u64::from(isqrt(distance)) >> 12);
            count += 1;
        }
        sum.checked_div(count).unwrap_or(0) as u32
    }
}
