//! Measurements over many rooms.

pub mod ablation;
pub mod behaviors;
pub mod compare;
pub mod faults;
pub mod paper;
pub mod repetition;
pub mod rooms;
pub mod scenes;
pub mod statistics;
