//! An arm that reaches and goes around a region (section 4), and one that points (section 5.3), as
//! in `host-sim arm`, with fewer seeds and targets.

use super::any_ring::MOVES;
use super::measure::{ProgressListener, Size};
use crate::arm::body::{ArmBody, View};
use crate::arm::pointing::{
    PointingMethod, PointingRow, PointingTrial, pointings, row as pointing_row,
};
use crate::arm::reach::{ArmMethod, Obstruction, ReachRow, ReachTrial, reaches, row};

/// Targets of each seed.
pub const TARGETS: u32 = 100;

/// Added to the first seed: the constants of the arm were set with seeds below.
const REPORTED_SEEDS: u64 = 1_000;

/// Times as many seeds where a region lies between: the hand enters it in few reaches only.
const REGION_SEEDS: u32 = 5;

/// The arm by the couple of maps.
pub struct Arms {
    /// It reaches for targets.
    pub reaching: ReachRow,
    /// A region lies between, of which it is not told.
    pub untold: ReachRow,
    /// The region is part of the goal.
    pub around: ReachRow,
    /// Eye and arm point at targets.
    pub pointing: PointingRow,
}

/// Seeds of the reaches around a region.
pub fn region_seeds(size: Size) -> u32 {
    size.draws.saturating_mul(REGION_SEEDS)
}

/// Measures on all cores.
pub(super) fn measure(size: Size, progress: &impl ProgressListener) -> Arms {
    progress.begin("arms", 2 * u64::from(size.draws + region_seeds(size)));
    let body = ArmBody::coiton(View::Space);
    let done = || progress.done();
    let first_seed = size.seed.wrapping_add(REPORTED_SEEDS);
    let reach = |obstruction, seeds| {
        let trial = ReachTrial {
            first_seed,
            seeds,
            explore_moves: MOVES.into(),
            targets: TARGETS,
            obstruction,
        };
        row(&reaches(&body, ArmMethod::Maps, &trial, &done))
    };
    let trial = PointingTrial {
        first_seed,
        seeds: size.draws,
        explore_moves: MOVES.into(),
        targets: TARGETS,
    };
    let maps = PointingMethod::Learned(ArmMethod::Maps);
    Arms {
        reaching: reach(Obstruction::None, size.draws),
        untold: reach(Obstruction::Untold, region_seeds(size)),
        around: reach(Obstruction::Told, region_seeds(size)),
        pointing: pointing_row(&pointings(maps, &trial, &done)),
    }
}
