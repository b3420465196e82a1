//! Associative memories: a codebook with one action per code vector.
//!
//! A memory recalls the action of the code vector nearest to the input. The memories are:
//!
//! * the action map: input and action are trained as one vector, the input alone is probed;
//! * a situation map labeled with the mean action of the samples that each neuron wins;
//! * the baselines: all samples (1-nearest neighbor), and the mean action (most frequent class or
//!   mean velocities).

use super::dataset::InputActionPairs;
use crate::som::init::{init_from_samples, new_map};
use arena::noise::Noise;
use files::error::BadInput;
use tinysom::fixed::{FINE_ONE_BITS, Weight32};
use tinysom::{DynSom, Grid, Mask, TrainConfig};

/// By neuron: mean action of the samples that it wins; `None` if it wins none.
pub type NeuronLabels = Vec<Option<Vec<f64>>>;

/// A codebook with one action per code vector.
#[derive(Debug, Clone)]
pub struct AssociativeMemory {
    codebook: DynSom,
    actions: Vec<Vec<f64>>,
}

impl AssociativeMemory {
    fn new(code: Vec<Weight32>, dims: usize, actions: Vec<Vec<f64>>) -> Result<Self, BadInput> {
        // Recall needs only the nearest code vector, so any grid serves.
        let count = u16::try_from(actions.len()).unwrap_or(u16::MAX);
        Ok(Self {
            codebook: new_map(Grid::chain(count), dims, code)?,
            actions,
        })
    }

    /// The action stored with the code vector nearest to the input.
    pub fn recall(&self, input: &[Weight32]) -> &[f64] {
        let bmu = self.codebook.bmu(input, Mask::ALL);
        self.actions.get(bmu).map_or(&[], Vec::as_slice)
    }

    /// A memory that recalls the mean of all actions for every input.
    ///
    /// # Errors
    /// Too many components for a map.
    pub fn from_mean(pairs: &InputActionPairs) -> Result<Self, BadInput> {
        let all: Vec<usize> = (0..pairs.actions.len()).collect();
        Self::new(
            vec![Weight32::ZERO; pairs.dims],
            pairs.dims,
            vec![mean(pairs, &all)],
        )
    }

    /// A memory of all samples: recall is 1-nearest neighbor.
    ///
    /// # Errors
    /// See [`from_mean`](Self::from_mean).
    pub fn from_samples(pairs: &InputActionPairs) -> Result<Self, BadInput> {
        Self::new(pairs.inputs.clone(), pairs.dims, pairs.actions.clone())
    }

    /// Trains an action map on (input, action) pairs; recall probes it with the input alone.
    /// `weight`, above 0 and at most 1, is the weight of an action's full range relative to a
    /// component of the input.
    ///
    /// # Errors
    /// See [`from_mean`](Self::from_mean).
    pub fn train_action_map(
        pairs: &InputActionPairs,
        grid: Grid,
        config: &TrainConfig,
        weight: f64,
        noise: &mut Noise,
    ) -> Result<Self, BadInput> {
        let ranges = ComponentRanges::new(&pairs.actions);
        let width = pairs.dims + ranges.0.len();
        let mut samples = Vec::with_capacity(pairs.actions.len() * width);
        for (input, action) in pairs.inputs.chunks_exact(pairs.dims).zip(&pairs.actions) {
            samples.extend_from_slice(input);
            samples.extend(ranges.to_weights(action, weight));
        }
        let mut map = init_from_samples(grid, width, &samples, noise)?;
        map.train(&mut samples, config, |below| noise.index(below));
        let (mut code, mut actions) = (Vec::new(), Vec::new());
        for vector in map.code_vectors() {
            let (input, action) = vector.split_at(pairs.dims);
            code.extend_from_slice(input);
            actions.push(ranges.to_action(action, weight));
        }
        Self::new(code, pairs.dims, actions)
    }

    /// Labels each neuron of a trained map with the mean action of the samples that it wins.
    /// Neurons that win no sample are left out of the memory.
    ///
    /// # Errors
    /// See [`from_mean`](Self::from_mean).
    pub fn from_labeled_map(
        map: &DynSom,
        pairs: &InputActionPairs,
    ) -> Result<(Self, NeuronLabels), BadInput> {
        let mut won = vec![Vec::new(); map.grid().len()];
        for (index, input) in pairs.inputs.chunks_exact(pairs.dims).enumerate() {
            let bmu = map.bmu(input, Mask::ALL);
            if let Some(won) = won.get_mut(bmu) {
                won.push(index);
            }
        }
        let label = |won: &Vec<usize>| (!won.is_empty()).then(|| mean(pairs, won));
        let labels: Vec<_> = won.iter().map(label).collect();
        let (mut code, mut actions) = (Vec::new(), Vec::new());
        for (vector, label) in map.code_vectors().zip(&labels) {
            if let Some(label) = label {
                code.extend_from_slice(vector);
                actions.push(label.clone());
            }
        }
        Ok((Self::new(code, pairs.dims, actions)?, labels))
    }
}

/// Mean action of the pairs at these indices.
fn mean(pairs: &InputActionPairs, indices: &[usize]) -> Vec<f64> {
    let width = pairs.actions.first().map_or(0, Vec::len);
    let mut sums = vec![0.0; width];
    for action in indices.iter().filter_map(|&index| pairs.actions.get(index)) {
        for (sum, value) in sums.iter_mut().zip(action) {
            *sum += value;
        }
    }
    sums.iter()
        .map(|sum| sum / indices.len().max(1) as f64)
        .collect()
}

/// Minimum and span of each component of the actions.
struct ComponentRanges(Vec<(f64, f64)>);

impl ComponentRanges {
    fn new(actions: &[Vec<f64>]) -> Self {
        let width = actions.first().map_or(0, Vec::len);
        let range = |component: usize| {
            let values = || {
                actions
                    .iter()
                    .filter_map(|action| action.get(component))
                    .copied()
            };
            let min = values().fold(f64::INFINITY, f64::min);
            let span = values().fold(f64::NEG_INFINITY, f64::max) - min;
            (min, if span > 0.0 { span } else { 1.0 })
        };
        Self((0..width).map(range).collect())
    }

    /// Scales an action to [0, `weight`].
    fn to_weights(&self, action: &[f64], weight: f64) -> Vec<Weight32> {
        let scaled = |((min, span), value): (&(f64, f64), &f64)| {
            let share = (value - min) / span * weight;
            Weight32::from_bits(libm::rint(share.clamp(0.0, 1.0) * f64::from(FINE_ONE_BITS)) as i32)
        };
        self.0.iter().zip(action).map(scaled).collect()
    }

    /// The inverse of [`to_weights`](Self::to_weights).
    fn to_action(&self, code: &[Weight32], weight: f64) -> Vec<f64> {
        let unscaled = |((min, span), value): (&(f64, f64), &Weight32)| {
            let share = f64::from(value.to_bits()) / f64::from(FINE_ONE_BITS);
            min + span * share / weight
        };
        self.0.iter().zip(code).map(unscaled).collect()
    }
}
