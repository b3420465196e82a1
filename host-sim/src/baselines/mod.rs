//! What the mind is compared with: other methods on the same robot, with the same sonars, the same shield and the same
//! budget of moves. A rule is a [`Policy`]; [`RingPilot`] makes it a driver.

pub mod braitenberg;
mod certainty_grid;
pub mod potential_field;
mod ring_pilot;
pub mod vfh_plus;

pub use braitenberg::Braitenberg;
pub use potential_field::PotentialField;
pub use ring_pilot::{Done, Perceived, Policy, RingPilot, STEP_M, Steered, axis};
pub use vfh_plus::VfhPlus;
