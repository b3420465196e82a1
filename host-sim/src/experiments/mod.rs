//! Measurements over many rooms.

pub mod ablation;
