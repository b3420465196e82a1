//! Whether the neuron aimed at is reached by preset `graph` (section 2.5), in an eighth as many
//! worlds as there are rooms, of twelve other kinds.

use super::measure::{ProgressListener, Size};
use crate::bodies::Generator;
use crate::traversed::{self, Aims, Drives};
use amp::config::Config;
use arena::robot::TurretMode;
use sim::error::EpisodeError;

/// Added to the first seed: the constants of the graph were chosen in worlds below.
const FIRST: u64 = 10_000;

/// The sum over all drives to the nest.
///
/// # Errors
/// When an episode fails.
pub(super) fn measure(size: Size, progress: &impl ProgressListener) -> Result<Aims, EpisodeError> {
    let drives = Drives {
        generator: Generator::Random2,
        first: size.seed.wrapping_add(FIRST),
        worlds: size.rooms.div_ceil(8),
        tour: 300,
    };
    progress.begin("several steps", u64::from(drives.worlds));
    let done = || progress.done();
    let aims = traversed::measure(&Config::traversing(), TurretMode::Held, &drives, &done)?;
    Ok(aims.into_iter().fold(Aims::default(), Aims::plus))
}
