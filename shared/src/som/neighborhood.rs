//! How strongly the winner's neighbors learn with it.

use super::grid::{Grid, NOBODY};
use super::kernels::Group;
use crate::fixed::{Gain, Mask, exp_neg};
use serde::{Deserialize, Serialize};

/// The shape of the neighborhood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Neighborhood {
    /// The paper's: the winner and its direct neighbors (four on a rectangle, two on a chain), nobody else. The radius of
    /// the schedule is the neighbors' share of the learning rate, at most 1.
    Direct,
    /// exp(−d²/2σ²) over the grid distance d, with the schedule's radius as σ.
    Gaussian,
}

/// Learning rate and neighborhood of one step, ready to apply to maps whose grid is at most `REACH` neurons long.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Update<const REACH: usize> {
    rate: Gain,
    shape: Shape<REACH>,
    /// What the processor's kernels need of both, if they can do with it.
    by_hand: Option<ByHand>,
}

/// Gains of the winner and of its direct neighbors, in units of 2⁻³².
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ByHand {
    rate_q32: i32,
    share_q32: i32,
}

impl ByHand {
    /// Only gains below 1/2 fit.
    fn new(rate: Gain, share: Gain) -> Option<Self> {
        (rate.is_below_half() && share.is_below_half()).then(|| Self {
            rate_q32: rate.to_q32(),
            share_q32: share.to_q32(),
        })
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Shape<const REACH: usize> {
    Direct { share: Gain },
    Gaussian { axis: [Gain; REACH] },
}

/// An [`Update`] without its size, for maps of any size.
#[derive(Debug, Clone, Copy)]
pub enum View<'a> {
    /// The winner's gain and that of its direct neighbors.
    Direct {
        /// Gain of the winner.
        rate: Gain,
        /// Gain of the direct neighbors.
        share: Gain,
    },
    /// Gains by distance along one axis; the two axes multiply.
    Gaussian {
        /// Gain of the winner.
        rate: Gain,
        /// Neighborhood value by grid steps along one axis.
        axis: &'a [Gain],
    },
}

impl<'a> View<'a> {
    /// The pull at learning rate `rate_q16` and radius `radius_q16` (both Q16); `axis` is room for one value per grid
    /// step along the longer side of the grid.
    #[must_use]
    pub fn new(
        neighborhood: Neighborhood,
        rate_q16: u32,
        radius_q16: u32,
        axis: &'a mut [Gain],
    ) -> Self {
        let rate = Gain::from_q16(rate_q16);
        match neighborhood {
            Neighborhood::Direct => Self::Direct {
                rate,
                share: rate.times(Gain::from_q16(radius_q16)),
            },
            Neighborhood::Gaussian => {
                gaussian(radius_q16, axis);
                Self::Gaussian { rate, axis }
            }
        }
    }

    /// Hands over each neuron that learns around `winner`, and its gain.
    pub fn each(self, grid: Grid, winner: usize, mut learns: impl FnMut(usize, Gain)) {
        match self {
            Self::Direct { rate, share } => {
                learns(winner, rate);
                if share != Gain::ZERO {
                    for neuron in grid.around(winner) {
                        if neuron != NOBODY {
                            learns(neuron, share);
                        }
                    }
                }
            }
            Self::Gaussian { rate, axis } => {
                let along = |d: usize| axis.get(d).copied().unwrap_or(Gain::ZERO);
                let (column, row) = grid.position(winner);
                let mut neurons = 0_usize..;
                for y in 0..grid.rows() {
                    let row_gain = rate.times(along(grid.row_distance(row, y)));
                    for (x, neuron) in (0..grid.columns()).zip(&mut neurons) {
                        let gain = row_gain.times(along(grid.column_distance(column, x)));
                        if gain != Gain::ZERO {
                            learns(neuron, gain);
                        }
                    }
                }
            }
        }
    }
}

impl<const REACH: usize> Update<REACH> {
    /// The pull at learning rate `rate_q16` and radius `radius_q16` (both Q16).
    #[must_use]
    pub fn new(neighborhood: Neighborhood, rate_q16: u32, radius_q16: u32) -> Self {
        let rate = Gain::from_q16(rate_q16);
        let (shape, by_hand) = match neighborhood {
            Neighborhood::Direct => {
                let share = rate.times(Gain::from_q16(radius_q16));
                (Shape::Direct { share }, ByHand::new(rate, share))
            }
            Neighborhood::Gaussian => {
                let mut axis = [Gain::ZERO; REACH];
                gaussian(radius_q16, &mut axis);
                (Shape::Gaussian { axis }, None)
            }
        };
        Self {
            rate,
            shape,
            by_hand,
        }
    }

    /// Whether the winner learns alone.
    pub(crate) fn is_alone(&self) -> bool {
        self.shape == Shape::Direct { share: Gain::ZERO }
    }

    /// Who moves by how much around `winner`, for [`Kernels::pull`](super::kernels::Kernels::pull); `None` for a gain or a shape
    /// that it does not know.
    pub(crate) fn groups(&self, grid: Grid, winner: usize) -> Option<[Group; 2]> {
        let ByHand {
            rate_q32,
            share_q32,
        } = self.by_hand?;
        let neighbors = match share_q32 {
            0 => Mask::NONE,
            _ => grid.mask_around(winner),
        };
        Some([
            Group {
                gain_q32: rate_q32,
                neurons: Mask::NONE.with(winner).to_bits(),
            },
            Group {
                gain_q32: share_q32,
                neurons: neighbors.to_bits(),
            },
        ])
    }

    /// This pull without its size.
    #[must_use]
    pub const fn view(&self) -> View<'_> {
        match &self.shape {
            Shape::Direct { share } => View::Direct {
                rate: self.rate,
                share: *share,
            },
            Shape::Gaussian { axis } => View::Gaussian {
                rate: self.rate,
                axis,
            },
        }
    }
}

/// exp(−j²/2σ²) for j = 0, 1, 2 … into `axis`; σ in Q16. A σ of 0 leaves the winner alone. Error at most 5·10⁻⁵.
pub fn gaussian(sigma_q16: u32, axis: &mut [Gain]) {
    // 2σ² in Q16, rounded down; the exponent j²/2σ² saturates, which is e^(−65 535) = 0.
    let width = (u64::from(sigma_q16) * u64::from(sigma_q16)) >> 15;
    for (j, gain) in axis.iter_mut().enumerate() {
        let squared = (j as u64).saturating_mul(j as u64);
        *gain = if j == 0 {
            Gain::ONE
        } else {
            let exponent = squared
                .saturating_mul(1 << 32)
                .checked_div(width)
                .unwrap_or(u64::MAX);
            Gain::from_bits(exp_neg(u32::try_from(exponent).unwrap_or(u32::MAX)) >> 1)
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaussian_follows_its_formula() {
        for sigma in [0.05, 0.3, 0.7, 1.0, 1.7, 3.0, 9.0] {
            let mut axis = [Gain::ZERO; 12];
            gaussian((sigma * 65_536.0) as u32, &mut axis);
            for (j, gain) in axis.iter().enumerate() {
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
    fn no_width_leaves_the_winner_alone() {
        let mut axis = [Gain::ZERO; 3];
        gaussian(0, &mut axis);
        assert_eq!(axis, [Gain::ONE, Gain::ZERO, Gain::ZERO]);
    }
}
