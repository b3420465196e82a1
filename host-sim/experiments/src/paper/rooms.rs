//! Avoidance in many random rooms by the maps alone: the source of most rows of the claims.

use super::gaps::Gaps;
use super::observer::ObservedController;
use super::plans::{GoalPaths, Plans};
use super::recall::{ActionRecall, Discreteness, samples_alike};
use super::topology::{MapTopology, topology_of};
use super::{PaperReading, STEPS};
use amp::goal::Goal;
use amp::memory::from_bytes;
use amp::scan::{Situation, rotated};
use arena::sonar::SonarModel;
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{EpisodeReport, Setup, run_with};
use sim::error::EpisodeError;
use sim::pilot::SimState;

/// Added to an episode's seed: draws random moves that its maps have not learned.
const OTHER_MOVES: u64 = 1_000_000;

/// Results of one room.
#[derive(Debug, Clone, PartialEq)]
pub struct RoomResult {
    /// Metrics of the episode.
    pub report: EpisodeReport,
    /// Outcome of its plans.
    pub plans: Plans,
    /// Paths over the situation map after the random moves.
    pub goal_paths: GoalPaths,
    /// Topology of that map.
    pub topology: MapTopology,
    /// Gaps to passed surfaces.
    pub gaps: Gaps,
    /// Recall of moves that were not learned.
    pub recalled: ActionRecall,
    /// Number of samples like the present situation.
    pub alike: Vec<usize>,
    /// Effect of online learning on the situation map.
    pub discreteness: Option<Discreteness>,
}

/// Setup of an episode without the shield; `seed` also draws the room.
#[must_use]
pub fn setup(reading: &PaperReading, behavior: Behavior, seed: u64, steps: u32) -> Setup {
    Setup {
        config: reading.config.clone(),
        preset: reading.name.to_owned(),
        behavior,
        explore_moves: super::any_ring::MOVES,
        steps,
        seed,
        sonar: SonarModel::Ideal,
        turret: reading.turret,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: true,
    }
}

/// Measures all rooms of one reading, on all cores; results are in order. `done` is called after
/// each.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    reading: &PaperReading,
    rooms: u32,
    seed: u64,
    done: &(impl Fn() + Sync),
) -> Result<Vec<RoomResult>, EpisodeError> {
    (0..u64::from(rooms))
        .into_par_iter()
        .map(|room| {
            let world = World::random(room.wrapping_add(1));
            let found = one(reading, &world, seed.wrapping_add(room));
            done();
            found
        })
        .collect()
}

fn one(reading: &PaperReading, world: &World, seed: u64) -> Result<RoomResult, EpisodeError> {
    let half = STEPS as usize / 2;
    let setup = setup(reading, Behavior::Avoid, seed, STEPS);
    let mut observer = ObservedController::new(reading.config.clone(), half);
    let episode = run_with(world, &setup, &mut observer, |_, _, _| {})?;
    let others = other_moves(&setup, world)?;
    let steps = episode.recording.map_or(Vec::new(), |r| r.seeking);
    let goal = Goal::avoiding(&reading.config);
    let learned = observer.learned.as_deref().ok_or(EpisodeError::Silent)?;
    let late = observer.observed.get(half..).unwrap_or_default();
    Ok(RoomResult {
        report: episode.report,
        plans: Plans::of(&observer.observed),
        goal_paths: GoalPaths::of(learned, &goal),
        topology: topology_of(
            learned.situations(),
            &learned_situations(learned, reading),
            seed,
        ),
        gaps: Gaps::of(world, &steps),
        recalled: ActionRecall::of(learned, &others, &reading.config),
        alike: samples_alike(learned, &observer.observed),
        discreteness: observer
            .later
            .as_deref()
            .map(|later| Discreteness::of(learned, later, late)),
    })
}

/// The situations from which the map has learned, in all rotations if the configuration learns
/// those.
fn learned_situations(state: &SimState, reading: &PaperReading) -> Vec<Situation<16>> {
    let turns = if reading.config.learning.augment_rotations {
        16
    } else {
        1
    };
    let samples = state.memory().samples().iter();
    samples
        .flat_map(|sample| {
            let after = from_bytes(&sample.after).0;
            (0..turns).map(move |places| rotated(&after, places))
        })
        .collect()
}

/// State of a controller after other random moves in the same room.
fn other_moves(setup: &Setup, world: &World) -> Result<Box<SimState>, EpisodeError> {
    let other = Setup {
        seed: setup.seed.wrapping_add(OTHER_MOVES),
        steps: 1,
        record: false,
        ..setup.clone()
    };
    let mut observer = ObservedController::new(other.config.clone(), 0);
    run_with(world, &other, &mut observer, |_, _, _| {})?;
    observer.learned.ok_or(EpisodeError::Silent)
}
