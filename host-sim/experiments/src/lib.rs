//! Measurements over many rooms: the paper's claims, comparisons with other methods, ablations,
//! controls, rivals, demonstrations, arms, sequences, BARN, sweeps.

pub mod ablation;
pub mod arm;
pub mod barn;
pub mod baselines;
pub mod behaviors;
pub mod bodies;
pub mod compare;
pub mod controls;
pub mod demonstrations;
pub mod errands;
pub mod faults;
pub mod paper;
pub mod patrol;
pub mod pictures;
pub mod repetition;
pub mod rivals;
pub mod scenes;
pub mod sequence;
pub mod sweep;
pub mod traversed;
