//! Hand-written drivers to compare the mind with.

mod braitenberg;

pub use braitenberg::{Braitenberg, Tuning};
