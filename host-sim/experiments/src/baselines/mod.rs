//! Baselines: other methods with the same robot, sonars, shield and number of moves.
//!
//! A rule is a [`Policy`](sim::ring_pilot::Policy), which [`RingPilot`](sim::ring_pilot::RingPilot)
//! drives. A [`Learner`] becomes a policy as a [`LearnerDriver`].

mod certainty_grid;
pub mod learning;
pub mod nearest;
pub mod potential_field;
pub mod q_lazy;
pub mod q_som;
pub mod q_table;
pub mod q_two_soms;
mod random_moves;
mod rotation;
pub mod vfh_plus;

pub use learning::{Learner, LearnerDriver};
pub use nearest::NearestSample;
pub use potential_field::PotentialField;
pub use q_lazy::QLazy;
pub use q_som::QSom;
pub use q_table::QTable;
pub use q_two_soms::QTwoSoms;
pub use random_moves::RandomMoves;
pub use vfh_plus::VfhPlus;
