//! What the mind is compared with: other methods on the same robot, with the same sonars, the same shield and the same
//! budget of moves. A rule is a [`Policy`]; [`RingPilot`] makes it a driver.

pub mod braitenberg;
mod ring_pilot;

pub use braitenberg::Braitenberg;
pub use ring_pilot::{Done, Perceived, Policy, RingPilot, STEP_M, Steered, axis};
