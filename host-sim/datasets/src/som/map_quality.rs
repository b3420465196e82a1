//! Quality of a trained map, in floating-point numbers for reports and pictures.

use tinysom::fixed::ONE_BITS;
use tinysom::{DynSom, Weight32};

/// Quality of a map on a set of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct MapQuality {
    /// Mean distance of a sample to its best-matching unit, in units of a weight's 1.0.
    pub quantization_error: f64,
    /// Share of the samples whose two best neurons are not direct neighbors, 0 to 1.
    pub topographic_error: f64,
    /// By neuron: number of samples that it wins.
    pub hits: Vec<usize>,
}

impl MapQuality {
    /// Measures a map on concatenated samples.
    #[must_use]
    pub fn measure(map: &DynSom, samples: &[Weight32]) -> Self {
        let (quality, hits) = map.quality(samples);
        Self {
            quantization_error: quality.quantization_error(),
            topographic_error: quality.topographic_error(),
            hits: hits.into_iter().map(|hits| hits as usize).collect(),
        }
    }
}

/// Mean distance of each neuron to its direct neighbors, in units of a weight's 1.0.
#[must_use]
pub fn u_matrix(map: &DynSom) -> Vec<f64> {
    let values = map.u_matrix().into_iter();
    values
        .map(|value| f64::from(value) / f64::from(ONE_BITS))
        .collect()
}
