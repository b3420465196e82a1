//! Gain of each neuron in a training step, by its grid distance to the BMU.

use crate::fixed::{Gain, exp_neg, q16};
use crate::grid::Grid;

/// Neighborhood function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Neighborhood {
    /// The BMU and its direct neighbors: four on a rectangle, two on a chain. The radius is the
    /// neighbors' share of the learning rate, at most 1.
    Direct,
    /// exp(−d²/2σ²) over the grid distance d; the radius is σ in grid steps.
    Gaussian,
}

/// Learning rate and neighborhood of one training step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Update {
    /// Gain of the BMU.
    pub(crate) rate: Gain,
    pub(crate) shape: NeighborhoodShape,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) enum NeighborhoodShape {
    /// Gain of the direct neighbors.
    Direct { share: Gain },
    /// 2σ² in Q16.
    Gaussian { width_q16: u64 },
}

impl Update {
    /// A step with a learning rate from 0 to 1; the radius is that of the [`Neighborhood`].
    ///
    /// ```
    /// # use tinysom::{Neighborhood, Update};
    /// let update = Update::new(Neighborhood::Gaussian, 0.5, 1.5);
    /// assert_eq!(update, Update::from_q16(Neighborhood::Gaussian, 32_768, 98_304));
    /// ```
    #[must_use]
    pub const fn new(neighborhood: Neighborhood, rate: f32, radius: f32) -> Self {
        Self::from_q16(neighborhood, q16(rate), q16(radius))
    }

    /// The same with rate and radius in Q16 (65 536 = 1.0).
    #[must_use]
    pub const fn from_q16(neighborhood: Neighborhood, rate_q16: u32, radius_q16: u32) -> Self {
        let rate = Gain::from_q16(rate_q16);
        let shape = match neighborhood {
            Neighborhood::Direct => NeighborhoodShape::Direct {
                share: rate.times(Gain::from_q16(radius_q16)),
            },
            Neighborhood::Gaussian => NeighborhoodShape::Gaussian {
                width_q16: (radius_q16 as u64 * radius_q16 as u64) >> 15,
            },
        };
        Self { rate, shape }
    }

    /// Whether only the BMU moves.
    #[must_use]
    pub fn is_alone(&self) -> bool {
        self.shape == NeighborhoodShape::Direct { share: Gain::ZERO }
    }

    /// Calls `moves` with the index and gain of each neuron that moves if `bmu` wins.
    #[inline]
    pub fn for_each(&self, grid: Grid, bmu: usize, mut moves: impl FnMut(usize, Gain)) {
        match self.shape {
            NeighborhoodShape::Direct { share } => {
                moves(bmu, self.rate);
                if share != Gain::ZERO {
                    self.for_neighbors(grid, bmu, share, moves);
                }
            }
            NeighborhoodShape::Gaussian { width_q16 } => self.for_all(grid, bmu, width_q16, moves),
        }
    }

    #[inline]
    fn for_neighbors(
        &self,
        grid: Grid,
        bmu: usize,
        share: Gain,
        mut moves: impl FnMut(usize, Gain),
    ) {
        if grid.len() <= 32 {
            let neighbors = grid.neighbor_mask(bmu).indices(32);
            neighbors.for_each(|neuron| moves(neuron, share));
        } else {
            grid.neighbors(bmu).for_each(|neuron| moves(neuron, share));
        }
    }

    #[inline(never)]
    fn for_all(&self, grid: Grid, bmu: usize, width_q16: u64, mut moves: impl FnMut(usize, Gain)) {
        let (column, row) = grid.position(bmu);
        for y in 0..grid.rows() {
            let row_gain = gaussian(grid.row_distance(row, y), width_q16);
            let row_gain = self.rate.times(row_gain);
            for x in 0..grid.columns() {
                let gain = gaussian(grid.column_distance(column, x), width_q16);
                let gain = row_gain.times(gain);
                if gain != Gain::ZERO {
                    moves(y * grid.columns() + x, gain);
                }
            }
        }
    }
}

/// exp(−d²/2σ²) of a distance along one axis; `width_q16` is 2σ². With σ = 0 only the BMU moves.
/// Absolute error at most 5·10⁻⁵.
fn gaussian(distance: usize, width_q16: u64) -> Gain {
    if distance == 0 {
        return Gain::ONE;
    }
    let squared = (distance as u64).saturating_mul(distance as u64);
    // Saturates at e^(−65 535), which is 0.
    let exponent = squared.saturating_mul(1 << 32).checked_div(width_q16);
    let exponent = exponent.map_or(u32::MAX, |x| u32::try_from(x).unwrap_or(u32::MAX));
    Gain::from_bits(exp_neg(exponent) >> 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn gaussian_follows_its_formula() {
        for sigma in [0.05, 0.3, 0.7, 1.0, 1.7, 3.0, 9.0] {
            let radius = (sigma * 65_536.0) as u32;
            let update = Update::from_q16(Neighborhood::Gaussian, 1 << 16, radius);
            let mut gains = [Gain::ZERO; 12];
            update.for_each(Grid::chain(12), 0, |k, gain| gains[k] = gain);
            for (j, gain) in gains.iter().enumerate() {
                let exact = libm::exp(-((j * j) as f64) / (2.0 * sigma * sigma));
                let value = f64::from(gain.to_bits()) / f64::from(1 << 30);
                assert!(
                    (value - exact).abs() < 5e-5,
                    "sigma {sigma}, j {j}: {value} {exact}"
                );
            }
        }
    }

    #[test]
    fn a_radius_of_0_moves_only_the_bmu() {
        for neighborhood in [Neighborhood::Gaussian, Neighborhood::Direct] {
            let update = Update::from_q16(neighborhood, 1 << 16, 0);
            let mut moved = Vec::new();
            update.for_each(Grid::chain(3), 1, |k, gain| moved.push((k, gain)));
            assert_eq!(moved, [(1, Gain::ONE)]);
            assert_eq!(update.is_alone(), neighborhood == Neighborhood::Direct);
        }
        assert!(!Update::from_q16(Neighborhood::Direct, 100, 40_000).is_alone());
    }
}
