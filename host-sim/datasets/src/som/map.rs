//! A map of run-time size that searches and learns as the maps of the robot, bit for bit.

use super::lanes::{self, Upper};
use amp::fixed::{FINE_ONE_BITS, Gain, Mask, ONE_BITS, Weight32, squared_norm};
use amp::som::metrics::{MapView, Quality, u_matrix_value};
use amp::som::neighborhood::View;
use amp::som::{Grid, kernels};

/// A self-organizing map whose size is known at run time only.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DynSom {
    grid: Grid,
    dims: usize,
    code: Vec<Weight32>,
    /// The upper halves of the code vectors, which searches read: of all neurons the first block, then the second.
    upper: Vec<Upper>,
    norms: Vec<i64>,
    /// Room for a search: the probe's upper halves and the scores.
    probe: Vec<Upper>,
    scores: Vec<i64>,
}

/// How good a map is for a set of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Measures {
    /// Mean distance of a sample to its best-matching unit, in units of a weight's 1.0.
    pub quantization_error: f64,
    /// Share of the samples whose best two neurons are not direct neighbors, 0 to 1.
    pub topographic_error: f64,
    /// How many samples each neuron wins.
    pub hits: Vec<usize>,
}

impl DynSom {
    /// A map of `dims` ≥ 1 components with these code vectors, one after another; components are clamped to [−1, 1],
    /// missing ones are 0.
    #[must_use]
    pub fn new(grid: Grid, dims: usize, mut code: Vec<Weight32>) -> Self {
        let dims = dims.max(1);
        code.resize(grid.len() * dims, Weight32::ZERO);
        for weight in &mut code {
            *weight = Weight32::from_bits(weight.to_bits().clamp(-FINE_ONE_BITS, FINE_ONE_BITS));
        }
        let blocks = lanes::blocks(dims);
        let mut upper = vec![Upper::default(); grid.len() * blocks];
        for (k, row) in code.chunks_exact(dims).enumerate() {
            lanes::round_down(row, upper.iter_mut().skip(k).step_by(grid.len()));
        }
        Self {
            norms: code.chunks_exact(dims).map(squared_norm).collect(),
            upper,
            probe: vec![Upper::default(); blocks],
            scores: vec![0; grid.len()],
            grid,
            dims,
            code,
        }
    }

    /// The grid.
    #[must_use]
    pub const fn grid(&self) -> Grid {
        self.grid
    }

    /// Components of a code vector.
    #[must_use]
    pub const fn dims(&self) -> usize {
        self.dims
    }

    /// The code vectors, neuron by neuron.
    pub fn code_vectors(&self) -> impl Iterator<Item = &[Weight32]> {
        self.code.chunks_exact(self.dims)
    }

    /// The best-matching unit of a probe, whose components lie in [−1, 1]; the lowest index on ties.
    #[inline]
    pub fn winner(&mut self, probe: &[Weight32]) -> usize {
        lanes::round_down(probe, self.probe.iter_mut());
        self.scores.copy_from_slice(&self.norms);
        let blocks = self.upper.chunks_exact(self.grid.len()).zip(&self.probe);
        for (neurons, probe) in blocks {
            for (score, upper) in self.scores.iter_mut().zip(neurons) {
                *score = score.wrapping_sub(2 * lanes::dot(upper, probe));
            }
        }
        kernels::nearest(&self.scores, self.dims, 1, |k| {
            kernels::distance(&self.code, self.dims, k, probe, Mask::ALL)
        })
    }

    /// One presentation: moves the winner and its neighbors towards the probe. Returns the winner.
    #[inline]
    pub fn learn(&mut self, probe: &[Weight32], pull: View<'_>) -> usize {
        let winner = self.winner(probe);
        pull.each(self.grid, winner, |k, gain| {
            let row = &mut self.code[k * self.dims..][..self.dims];
            let upper = self.upper.iter_mut().skip(k).step_by(self.grid.len());
            self.norms[k] = lanes::pull(row, upper, probe, gain);
        });
        winner
    }

    /// One presentation of each sample with the same pull; `samples` holds them one after another.
    pub fn learn_all(&mut self, samples: &[Weight32], pull: View<'_>) {
        for probe in samples.chunks_exact(self.dims) {
            self.learn(probe, pull);
        }
    }

    /// How good the map is for these samples, which stand one after another.
    pub fn measure(&mut self, samples: &[Weight32]) -> Measures {
        let mut scores = std::mem::take(&mut self.scores);
        let mut quality = Quality::default();
        let mut hits = vec![0; self.grid.len()];
        for sample in samples.chunks_exact(self.dims) {
            let winner = quality.add(self.view(), sample, &mut scores);
            if let Some(hit) = hits.get_mut(winner) {
                *hit += 1;
            }
        }
        self.scores = scores;
        Measures {
            quantization_error: quality.quantization_error_q21() as f64 / f64::from(1 << 21),
            topographic_error: f64::from(quality.apart()) / f64::from(quality.samples().max(1)),
            hits,
        }
    }

    /// Mean distance of each neuron to its direct neighbors, in units of a weight's 1.0.
    #[must_use]
    pub fn u_matrix(&self) -> Vec<f64> {
        (0..self.grid.len())
            .map(|k| f64::from(u_matrix_value(self.view(), k)) / f64::from(ONE_BITS))
            .collect()
    }

    /// Room for the neighborhood values of a [`View`].
    #[must_use]
    pub fn axis(&self) -> Vec<Gain> {
        vec![Gain::ZERO; self.grid.columns().max(self.grid.rows())]
    }

    fn view(&self) -> MapView<'_> {
        MapView {
            grid: self.grid,
            code: &self.code,
            dims: self.dims,
        }
    }
}
