//! Runs an episode and writes its log.

use super::logged_pilot::{LoggedPilot, WorldLogger};
use super::record::SetupRecord;
use super::shared::SharedLog;
use super::write::LogWriter;
use arena::world::World;
use sim::episode::{self, Episode, Setup};
use sim::error::EpisodeError;
use sim::pilot::InspectableController;
use std::path::Path;

/// Runs an episode and writes its log into a new file.
///
/// # Errors
/// As [`episode::run_with`], and [`EpisodeError::Log`] where the file exists or cannot be written.
/// What was written until then remains.
pub fn run(
    world: &World,
    setup: &Setup,
    controller: impl InspectableController,
    path: &Path,
) -> Result<Episode, EpisodeError> {
    let log = LogWriter::create(path).map_err(|error| EpisodeError::Log(error.to_string()))?;
    let log = SharedLog::new(log);
    let record = SetupRecord::of(world.name(), setup);
    log.write(|log| log.setup(&record, Some(world)));
    let mut logged = LoggedPilot::new(controller, Some(log.clone()));
    let mut world_logger = WorldLogger::new(log.clone());
    let result = episode::run_observed(
        world,
        setup,
        &mut logged,
        Some(&mut world_logger),
        |_, _, _| {},
    );
    // The log is finished even after an error.
    log.finish().map_err(EpisodeError::Log)?;
    result
}
