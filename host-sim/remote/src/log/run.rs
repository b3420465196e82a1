//! Runs an episode and writes its log.

use super::logged_pilot::{LoggedPilot, WorldLogger};
use super::setup_record::SetupRecord;
use super::shared::SharedLog;
use super::write::LogWriter;
use arena::world::World;
use sim::episode::{self, Episode, Setup, completed_world};
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
    let completed = completed_world(world, setup)?;
    let world = completed.as_ref().unwrap_or(world);
    let log = LogWriter::create(path).map_err(|error| EpisodeError::Log(error.to_string()))?;
    let log = SharedLog::new(log);
    let mut logged = LoggedPilot::new(controller, Some(log.clone()));
    logged.begin(&SetupRecord::of(world.name(), setup), Some(world));
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
