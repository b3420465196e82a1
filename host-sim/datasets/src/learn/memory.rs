//! Associative memories: a codebook, an answer for each of its code vectors, and the nearest one
//! answers.
//!
//! The action map is one (both parts of its code vectors are trained together, one is probed), a
//! situation map whose neurons carry what was done in the situations they won is another, and so
//! are what they are compared with: all the samples (1-nearest neighbor) and a single answer (the
//! most frequent class, the mean velocities).

use super::task::Pairs;
use crate::som::start::{map_of, start_at_samples};
use arena::noise::Noise;
use files::error::BadInput;
use tinysom::fixed::{FINE_ONE_BITS, Weight32};
use tinysom::{DynSom, Grid, Mask, TrainConfig};

/// By neuron: the mean action of the samples it won; `None` where it won none.
pub type Labels = Vec<Option<Vec<f64>>>;

/// A codebook with answers.
#[derive(Debug, Clone)]
pub struct Memory {
    codebook: DynSom,
    answers: Vec<Vec<f64>>,
}

impl Memory {
    fn new(code: Vec<Weight32>, dims: usize, answers: Vec<Vec<f64>>) -> Result<Self, BadInput> {
        // Only the nearest code vector is asked for: the shape of the grid does not matter.
        let count = u16::try_from(answers.len()).unwrap_or(u16::MAX);
        Ok(Self {
            codebook: map_of(Grid::chain(count), dims, code)?,
            answers,
        })
    }

    /// The action that goes with an input.
    pub fn recall(&self, input: &[Weight32]) -> &[f64] {
        let bmu = self.codebook.bmu(input, Mask::ALL);
        self.answers.get(bmu).map_or(&[], Vec::as_slice)
    }

    /// The mean of all actions, whatever the input.
    ///
    /// # Errors
    /// As all of these: more components than a map may have.
    pub fn of_the_mean(pairs: &Pairs) -> Result<Self, BadInput> {
        let all: Vec<usize> = (0..pairs.actions.len()).collect();
        Self::new(
            vec![Weight32::ZERO; pairs.dims],
            pairs.dims,
            vec![mean(pairs, &all)],
        )
    }

    /// All the samples.
    ///
    /// # Errors
    /// See [`of_the_mean`](Self::of_the_mean).
    pub fn of_samples(pairs: &Pairs) -> Result<Self, BadInput> {
        Self::new(pairs.inputs.clone(), pairs.dims, pairs.actions.clone())
    }

    /// The action map: (input, action) pairs learned together, probed with the input alone.
    /// `weight` is that of an action's whole range beside an input's component, 0 to 1.
    ///
    /// # Errors
    /// See [`of_the_mean`](Self::of_the_mean).
    pub fn of_pairs(
        pairs: &Pairs,
        grid: Grid,
        config: &TrainConfig,
        weight: f64,
        noise: &mut Noise,
    ) -> Result<Self, BadInput> {
        let ranges = Ranges::of(&pairs.actions);
        let width = pairs.dims + ranges.0.len();
        let mut samples = Vec::with_capacity(pairs.actions.len() * width);
        for (input, action) in pairs.inputs.chunks_exact(pairs.dims).zip(&pairs.actions) {
            samples.extend_from_slice(input);
            samples.extend(ranges.weights(action, weight));
        }
        let mut map = start_at_samples(grid, width, &samples, noise)?;
        map.train(&mut samples, config, |below| noise.index(below));
        let (mut code, mut answers) = (Vec::new(), Vec::new());
        for vector in map.code_vectors() {
            let (input, action) = vector.split_at(pairs.dims);
            code.extend_from_slice(input);
            answers.push(ranges.action(action, weight));
        }
        Self::new(code, pairs.dims, answers)
    }

    /// A trained map whose neurons answer with the mean action of the samples they win; those that
    /// win none never answer.
    ///
    /// # Errors
    /// See [`of_the_mean`](Self::of_the_mean).
    pub fn of_map(map: &DynSom, pairs: &Pairs) -> Result<(Self, Labels), BadInput> {
        let mut won = vec![Vec::new(); map.grid().len()];
        for (index, input) in pairs.inputs.chunks_exact(pairs.dims).enumerate() {
            let bmu = map.bmu(input, Mask::ALL);
            if let Some(won) = won.get_mut(bmu) {
                won.push(index);
            }
        }
        let answer = |won: &Vec<usize>| (!won.is_empty()).then(|| mean(pairs, won));
        let labels: Vec<_> = won.iter().map(answer).collect();
        let (mut code, mut answers) = (Vec::new(), Vec::new());
        for (vector, label) in map.code_vectors().zip(&labels) {
            if let Some(label) = label {
                code.extend_from_slice(vector);
                answers.push(label.clone());
            }
        }
        Ok((Self::new(code, pairs.dims, answers)?, labels))
    }
}

/// The mean action of some pairs.
fn mean(pairs: &Pairs, of: &[usize]) -> Vec<f64> {
    let width = pairs.actions.first().map_or(0, Vec::len);
    let mut sums = vec![0.0; width];
    for action in of.iter().filter_map(|&index| pairs.actions.get(index)) {
        for (sum, value) in sums.iter_mut().zip(action) {
            *sum += value;
        }
    }
    sums.iter()
        .map(|sum| sum / of.len().max(1) as f64)
        .collect()
}

/// The least value of each component of the actions, and how far they go.
struct Ranges(Vec<(f64, f64)>);

impl Ranges {
    fn of(actions: &[Vec<f64>]) -> Self {
        let width = actions.first().map_or(0, Vec::len);
        let range = |component: usize| {
            let values = || {
                actions
                    .iter()
                    .filter_map(|action| action.get(component))
                    .copied()
            };
            let least = values().fold(f64::INFINITY, f64::min);
            let span = values().fold(f64::NEG_INFINITY, f64::max) - least;
            (least, if span > 0.0 { span } else { 1.0 })
        };
        Self((0..width).map(range).collect())
    }

    fn weights(&self, action: &[f64], weight: f64) -> Vec<Weight32> {
        let part = |((least, span), value): (&(f64, f64), &f64)| {
            let share = (value - least) / span * weight;
            Weight32::from_bits(libm::rint(share.clamp(0.0, 1.0) * f64::from(FINE_ONE_BITS)) as i32)
        };
        self.0.iter().zip(action).map(part).collect()
    }

    fn action(&self, code: &[Weight32], weight: f64) -> Vec<f64> {
        let part = |((least, span), value): (&(f64, f64), &Weight32)| {
            let share = f64::from(value.to_bits()) / f64::from(FINE_ONE_BITS);
            least + span * share / weight
        };
        self.0.iter().zip(code).map(part).collect()
    }
}
