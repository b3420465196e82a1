//! An episode with a log.

use super::record::{FORMAT, Setup as SetupRecord};
use super::tap::{Tap, Watcher};
use super::write::Log;
use crate::episode::{self, Episode, Failure, Setup};
use crate::pilot::Thinker;
use crate::world::World;
use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

/// Runs an episode and writes down what the mind is told and answers, into a new file.
///
/// # Errors
/// As [`episode::run_with`], and [`Failure::Log`] where the file is there already or cannot be written. What was written
/// until then stays.
pub fn run(
    world: &World,
    setup: &Setup,
    mind: impl Thinker,
    path: &Path,
) -> Result<Episode, Failure> {
    let log = Log::create(path).map_err(|error| Failure::Log(error.to_string()))?;
    let log = Rc::new(RefCell::new(log));
    log.borrow_mut().setup(&of(world, setup), world);
    let mut tap = Tap::new(mind, Rc::clone(&log));
    let mut watcher = Watcher::new(Rc::clone(&log));
    let done = episode::run_observed(world, setup, &mut tap, Some(&mut watcher), |_, _, _| {});
    drop((tap, watcher));
    // Whatever came of the episode, its log ends as it should.
    if let Some(log) = Rc::into_inner(log) {
        log.into_inner().finish().map_err(Failure::Log)?;
    }
    done
}

fn of(world: &World, setup: &Setup) -> SetupRecord {
    SetupRecord {
        format: FORMAT,
        program: env!("CARGO_PKG_VERSION").to_owned(),
        world: world.name().to_owned(),
        behavior: setup.behavior.name(),
        preset: setup.preset.clone(),
        seed: setup.seed,
        sonar: setup.sonar.name().to_owned(),
        config: setup.config.clone(),
    }
}
