//! An episode: one robot in one world explores, learns and pursues a goal.
//!
//! The simulated body turns what happens into the events of [`amp::controller`] and carries out the
//! motions that come back; the pilot never sees the world itself. Randomness: from the episode's
//! seed, SplitMix64 draws first the seed of the robot's own generator (its random moves), then that
//! of the noise of sonars and wheels, so that a run without noise makes the same random moves.

mod body;
mod capture;
mod drive;
mod leader;
mod measure;
mod places;
mod pursue;
mod record;
mod metrics;

pub use body::milliseconds;
pub use body::{Body, Collision, Moved, StepResult};
pub use capture::perceive;
pub use drive::{
    Episode, Observer, Phase, Setup, drive_pilot, explore_and_learn, run, run_observed, run_with,
};
pub use leader::Leader;
pub use measure::{FOLLOWED_S, KEPT_M, NEST_M};
pub use places::elsewhere;
pub use pursue::{CARRIED_S, repeat};
pub use metrics::rounded;
pub use metrics::{Metrics, EpisodeReport, StepFlags};

use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::SplitMix64;

/// The two seeds of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seeds {
    /// For the robot's own generator.
    pub exploration: u64,
    /// For the noise of sonars and wheels.
    pub noise: u64,
}

impl Seeds {
    /// The first two outputs of SplitMix64 seeded with `seed`.
    #[must_use]
    pub fn of(seed: u64) -> Self {
        let mut generator = SplitMix64::seed_from_u64(seed);
        Self {
            exploration: generator.next_u64(),
            noise: generator.next_u64(),
        }
    }
}
