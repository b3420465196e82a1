//! Does a shard's episodes.

use super::in_order::in_order;
use super::plan::{Place, Plan};
use super::results::{ResultsFile, row};
use super::shard::Shard;
use arena::world::{World, WorldSource};
use files::error::BadInput;
use rayon::ThreadPool;
use sim::episode::{self, Setup};
use sim::pilot::LocalController;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// How far a shard is, in episodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// In the file already when the program began.
    pub before: u64,
    /// In the file now.
    pub done: u64,
    /// To be done altogether.
    pub all: u64,
}

/// Adds the rows of a shard that are not yet in the file at `path`; tells `progress` at the beginning and after each row.
///
/// # Errors
/// Those of [`ResultsFile`]; a world that cannot be loaded any more; an episode that fails. Rows written before stay.
pub fn run(
    plan: &Plan,
    shard: Shard,
    path: &Path,
    pool: &ThreadPool,
    mut progress: impl FnMut(Progress),
) -> Result<Progress, BadInput> {
    let (mut file, before) = ResultsFile::open(path, plan.header(), shard)?;
    let all = shard.len(plan.episodes());
    let mut now = Progress {
        before,
        done: before,
        all,
    };
    progress(now);
    let mut jobs = Jobs { plan, held: None };
    let jobs = (before..all).map(|nth| jobs.job(shard.number(nth)));
    in_order(
        pool,
        jobs,
        |job: Result<Job, BadInput>| job?.row(),
        |row: Result<Vec<u8>, BadInput>| {
            file.add(&row?)?;
            now.done += 1;
            progress(now);
            Ok::<_, BadInput>(())
        },
    )?;
    file.finish()?;
    Ok(now)
}

/// A world that is loaded by the first episode in it.
struct Arena {
    source: WorldSource,
    world: OnceLock<Result<World, BadInput>>,
}

/// What episodes that follow each other share.
#[derive(Clone)]
struct Shared {
    place: Place,
    setup: Arc<Setup>,
    cells: Arc<Vec<String>>,
    arena: Arc<Arena>,
}

/// Makes jobs; keeps what the last one had, for the next one mostly needs the same.
struct Jobs<'p> {
    plan: &'p Plan,
    held: Option<Shared>,
}

struct Job {
    number: u64,
    seed: u64,
    shared: Shared,
}

impl Jobs<'_> {
    fn job(&mut self, number: u64) -> Result<Job, BadInput> {
        let place = self.plan.place(number);
        let description = self.plan.description();
        let held = self.held.take();
        let same = |held: &&Shared| {
            (held.place.point, held.place.behavior) == (place.point, place.behavior)
        };
        let (setup, cells) = match held.as_ref().filter(same) {
            Some(held) => (held.setup.clone(), held.cells.clone()),
            None => (
                Arc::new(self.plan.setup(place)?),
                Arc::new(description.points.cells(place.point)),
            ),
        };
        let arena = match held.as_ref().filter(|held| held.place.world == place.world) {
            Some(held) => held.arena.clone(),
            None => {
                let source = description.worlds.get(place.world).cloned();
                let source = source.unwrap_or(WorldSource::Random(0));
                Arc::new(Arena {
                    source,
                    world: OnceLock::new(),
                })
            }
        };
        let shared = Shared {
            place,
            setup,
            cells,
            arena,
        };
        self.held = Some(shared.clone());
        let seed = description.seeds.get(place.seed).copied().unwrap_or(0);
        Ok(Job {
            number,
            seed,
            shared,
        })
    }
}

impl Job {
    /// Drives the episode; its row.
    fn row(self) -> Result<Vec<u8>, BadInput> {
        let Self {
            number,
            seed,
            shared,
        } = self;
        let of_episode =
            |what: &dyn std::fmt::Display| BadInput::new(format!("episode {number}: {what}"));
        let Arena { source, world } = &*shared.arena;
        let world = world.get_or_init(|| source.load());
        let world = world.as_ref().map_err(|error| of_episode(error))?;
        let setup = Setup {
            seed,
            ..(*shared.setup).clone()
        };
        let mut mind = LocalController::new(setup.config.clone());
        let episode = episode::run_with(world, &setup, &mut mind, |_, _, _| {});
        let report = episode.map_err(|failure| of_episode(&failure))?.report;
        row(number, &shared.cells, &report).map_err(|error| of_episode(&error))
    }
}
