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
//! // How far a sample is from all that was seen, in mean distances of the training's samples.
//! assert!(map.novelty(&[0.9, 0.1].map(value), &quality) > 3.0);
//! ```
//!
//! # Sizes
//!
//! [`Som`] holds `NEURONS` code vectors of up to 4095 components in an array: `4 · NEURONS · DIMS`
//! bytes and a few more. `DynSom` (feature `alloc`) has sizes known at run time. Both share one
//! implementation. Values lie in [−1, 1]: scale samples first.
//!
//! # Beyond the textbook
//!
//! Maps serve as associative memories: a [`Mask`] probes with a part of the vector,
//! [`Som::alignments`] by the *direction* of a probe instead of its distance, and
//! [`Som::joint_bmu`] searches two maps over one grid together.
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

/// The examples of the crate's page run as tests.
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

/// Most components of a code vector: a squared distance of so many fits 64 bits.
pub const MAX_DIMS: usize = 4095;

#[cfg(test)]
mod tests;
