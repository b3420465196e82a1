//! **Self-organizing maps in fixed point** (T. Kohonen, *Self-Organizing Maps*, 3rd ed., Springer
//! 2001), for microcontrollers and desktop machines: the same samples give the same bytes on both.
//!
//! A map is a [`Grid`] of *neurons*, each with a *code vector*. The *best-matching unit* (BMU) of a
//! sample is the neuron whose code vector is nearest. Training moves the BMU and its neighbors:
//!
//! ```text
//! w_k ← w_k + α(t) · h(k, BMU) · (x − w_k)
//! ```
//!
//! with a falling *learning rate* α ([`Schedule`]) and a *neighborhood* h ([`Neighborhood`]).
//!
//! ```
//! use tinysom::{Decay, Grid, Mask, Neighborhood, SampleOrder, Schedule, Som, TrainConfig, Weight};
//!
//! let value = Weight::from_num::<f32>;
//! let mut samples = [[0.1, 0.2], [0.9, 0.8], [0.15, 0.25], [0.85, 0.9]].map(|row| row.map(value));
//! let mut map = Som::<4, 2>::new(Grid::rectangle(2, 2), samples);
//! let config = TrainConfig {
//!     neighborhood: Neighborhood::Gaussian,
//!     rate: Schedule::new(0.5, 0.01, Decay::Exponential),
//!     radius: Schedule::new(1.0, 0.3, Decay::Exponential),
//!     epochs: 50,
//!     order: SampleOrder::AsGiven,
//! };
//! map.train(&mut samples, &config, |_| 0);
//!
//! let (quality, hits) = map.quality(&samples);
//! assert!(quality.quantization_error() < 0.1);
//! assert_eq!(hits.iter().sum::<u32>(), 4);
//! let bmu = map.bmu(&[0.1, 0.2].map(value), Mask::ALL);
//! assert_eq!(map.code_vector(bmu).map(|w| (w.to_num::<f32>() * 4.0) as u8), [0, 0]);
//! // Distance of a new sample to its BMU, relative to the mean over the training samples.
//! assert!(map.novelty(&[0.9, 0.1].map(value), &quality) > 3.0);
//! ```
//!
//! # Sizes
//!
//! [`Som`] holds `NEURONS` code vectors of up to 4095 components in an array of
//! `4 · NEURONS · DIMS` bytes. `DynSom` (feature `alloc`) has sizes known at run time. Both share
//! one implementation. Values lie in [−1, 1]: scale samples first.
//!
//! # Associative memory
//!
//! A map can recall the rest of a vector from a part of it. A [`Mask`] selects the components that
//! are compared. [`Som::alignments`] compares directions instead of distances. [`Som::joint_bmu`]
//! searches two maps on the same grid together.
//!
//! # Features
//!
//! None is on by default. `alloc` (or `std`): [`DynSom`](https://docs.rs/tinysom); `serde`;
//! `defmt`.
#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![cfg_attr(
    not(test),
    deny(clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(test)]
extern crate std;

/// Runs the examples in the README as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod codebook;
#[cfg(feature = "alloc")]
mod dyn_som;
pub mod fixed;
mod grid;
pub mod kernels;
mod neighborhood;
mod quality;
mod schedule;
#[cfg(feature = "serde")]
mod serialize;
mod som;
mod train;

#[cfg(feature = "alloc")]
pub use dyn_som::{DynSom, TooManyComponents};
pub use fixed::{Gain, Mask, Weight, Weight32};
pub use grid::{Edges, Grid};
pub use neighborhood::{Neighborhood, Update};
pub use quality::Quality;
pub use schedule::{Decay, Schedule};
pub use som::Som;
pub use train::{SampleOrder, TrainConfig};

/// Largest number of components of a code vector; their squared distance fits 64 bits.
pub const MAX_DIMS: usize = 4095;

#[cfg(test)]
mod tests;
