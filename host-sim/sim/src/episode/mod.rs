//! An episode: one robot in one world explores, learns and pursues a goal.
//!
//! The simulated body sends events to the controller and carries out its motions; the pilot never
//! sees the world. SplitMix64, seeded by the episode's seed, draws three seeds: first that of the
//! random moves, then that of all noise, then that of what is perceived beside ranges. So a run
//! without noise makes the same random moves.

mod body;
mod calibrate;
mod capture;
mod drive;
mod errands;
mod leader;
mod measure;
mod metrics;
mod patrol;
mod places;
mod pursue;
mod record;
mod setup;
mod sized;
mod sources;

pub use body::{Body, Collision, Moved, StepResult};
pub use body::{bearing, milliseconds};
pub use capture::perceive;
pub use drive::{
    Episode, Observer, Phase, drive_pilot, explore_and_learn, run, run_observed, run_with,
};
pub use errands::{Errand, ErrandPlan, Obstacle, Period, errands};
pub use leader::Leader;
pub use measure::{FOLLOW_RANGE_M, FOLLOW_TIME_S, NEST_RADIUS_M};
pub use metrics::rounded;
pub use metrics::{EpisodeReport, Metrics, StepFlags};
pub use patrol::{Arrival, Destination, patrol};
pub use places::elsewhere;
pub use pursue::{CARRY_TIME_S, repeat};
pub use setup::Setup;
pub use sized::{NEURON_COUNTS, run_sized, square_grid};
pub use sources::{completed_world, with_missing_sources};

use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::SplitMix64;

/// The seeds of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seeds {
    /// For the controller's own generator.
    pub exploration: u64,
    /// For the noise of sonars and wheels.
    pub noise: u64,
    /// For what else can be perceived, and where it is in worlds without it.
    pub sources: u64,
}

impl Seeds {
    /// The first three outputs of SplitMix64 seeded with `seed`.
    #[must_use]
    pub fn of(seed: u64) -> Self {
        let mut generator = SplitMix64::seed_from_u64(seed);
        Self {
            exploration: generator.next_u64(),
            noise: generator.next_u64(),
            sources: generator.next_u64(),
        }
    }
}
