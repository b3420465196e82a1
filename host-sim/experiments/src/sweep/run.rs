//! Runs the episodes of a shard and appends their results.

use super::in_order::in_order;
use super::plan::{EpisodeIndex, SweepPlan};
use super::results::{ResultsFile, row};
use super::shard::Shard;
use arena::loaders::WorldSource;
use arena::world::World;
use files::error::BadInput;
use rayon::ThreadPool;
use sim::episode::{self, Setup};
use sim::pilot::LocalController;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// Progress of a shard, in episodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SweepProgress {
    /// Episodes in the file at the start of the program.
    pub before: u64,
    /// Episodes in the file now.
    pub done: u64,
    /// All episodes of the shard.
    pub all: u64,
}

/// Appends the missing rows of a shard to the file at `path`; calls `progress` at the start and
/// after each row.
///
/// # Errors
/// Those of [`ResultsFile`]; a world that no longer loads; an episode that fails. Earlier rows
/// stay.
pub fn run(
    plan: &SweepPlan,
    shard: Shard,
    path: &Path,
    pool: &ThreadPool,
    mut progress: impl FnMut(SweepProgress),
) -> Result<SweepProgress, BadInput> {
    let (mut file, before) = ResultsFile::open(path, plan.header(), shard)?;
    let all = shard.len(plan.episodes());
    let mut now = SweepProgress {
        before,
        done: before,
        all,
    };
    progress(now);
    let mut jobs = EpisodeJobs { plan, held: None };
    let jobs = (before..all).map(|nth| jobs.job(shard.number(nth)));
    in_order(
        pool,
        jobs,
        |job: Result<EpisodeJob, BadInput>| job?.row(),
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

/// A world, loaded by the first episode that needs it.
struct Arena {
    source: WorldSource,
    world: OnceLock<Result<World, BadInput>>,
}

/// What consecutive episodes share.
#[derive(Clone)]
struct SharedSetup {
    place: EpisodeIndex,
    setup: Arc<Setup>,
    cells: Arc<Vec<String>>,
    arena: Arc<Arena>,
}

/// Creates jobs; reuses the data of the previous job where it is the same.
struct EpisodeJobs<'p> {
    plan: &'p SweepPlan,
    held: Option<SharedSetup>,
}

struct EpisodeJob {
    number: u64,
    seed: u64,
    shared: SharedSetup,
}

impl EpisodeJobs<'_> {
    fn job(&mut self, number: u64) -> Result<EpisodeJob, BadInput> {
        let place = self.plan.place(number);
        let description = self.plan.description();
        let held = self.held.take();
        let same = |held: &&SharedSetup| {
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
        let shared = SharedSetup {
            place,
            setup,
            cells,
            arena,
        };
        self.held = Some(shared.clone());
        let seed = description.seeds.get(place.seed).copied().unwrap_or(0);
        Ok(EpisodeJob {
            number,
            seed,
            shared,
        })
    }
}

impl EpisodeJob {
    /// Runs the episode; returns its row.
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
