//! An episode with a log.

use super::record::Setup as SetupRecord;
use super::shared::SharedLog;
use super::tap::{Tap, Watcher};
use super::write::Log;
use arena::world::World;
use sim::episode::{self, Episode, Setup};
use sim::error::EpisodeError;
use sim::pilot::InspectableController;
use std::path::Path;

/// Runs an episode and writes down what the mind is told and answers, into a new file.
///
/// # Errors
/// As [`episode::run_with`], and [`EpisodeError::Log`] where the file is there already or cannot be written. What was written
/// until then stays.
pub fn run(
    world: &World,
    setup: &Setup,
    mind: impl InspectableController,
    path: &Path,
) -> Result<Episode, EpisodeError> {
    let log = Log::create(path).map_err(|error| EpisodeError::Log(error.to_string()))?;
    let log = SharedLog::new(log);
    let record = SetupRecord::of(world.name(), setup);
    log.write(|log| log.setup(&record, Some(world)));
    let mut tap = Tap::new(mind, Some(log.clone()));
    let mut watcher = Watcher::new(log.clone());
    let done = episode::run_observed(world, setup, &mut tap, Some(&mut watcher), |_, _, _| {});
    // Whatever came of the episode, its log ends as it should.
    log.finish().map_err(EpisodeError::Log)?;
    done
}
