//! Avoidance in many random rooms by the maps alone, each decision watched: what most rows of the table are made of.

use super::gaps::Gaps;
use super::knowing::{Discreteness, Recalled, samples_alike};
use super::order::{Order, order_of};
use super::plans::{Plans, Ways};
use super::watch::Watched;
use super::{Reading, STEPS};
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

/// Added to an episode's seed for random moves that its maps have not learned.
const OTHER_MOVES: u64 = 1_000_000;

/// What was found in one room.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    /// The episode's figures.
    pub report: EpisodeReport,
    /// What became of its plans.
    pub plans: Plans,
    /// Ways over the situation map as the random moves made it.
    pub ways: Ways,
    /// The order of that map.
    pub order: Order,
    /// Gaps to what was passed.
    pub gaps: Gaps,
    /// Recall of moves that were not learned.
    pub recalled: Recalled,
    /// Samples like the present situation.
    pub alike: Vec<usize>,
    /// What going on to learn did to the situation map.
    pub discreteness: Option<Discreteness>,
}

/// An episode's setup in a room of its own seed, without the shield.
#[must_use]
pub fn setup(reading: &Reading, behavior: Behavior, seed: u64, steps: u32) -> Setup {
    Setup {
        config: reading.config.clone(),
        preset: reading.name.to_owned(),
        behavior,
        explore_moves: super::any_ring::MOVES,
        steps,
        seed,
        sonar: SonarModel::Ideal,
        turret: reading.turret,
        set_down: None,
        faults: Vec::new(),
        record: true,
    }
}

/// All rooms of one reading in order, on all cores; `done` is called after each.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    reading: &Reading,
    rooms: u32,
    seed: u64,
    done: &(impl Fn() + Sync),
) -> Result<Vec<Room>, EpisodeError> {
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

fn one(reading: &Reading, world: &World, seed: u64) -> Result<Room, EpisodeError> {
    let half = STEPS as usize / 2;
    let setup = setup(reading, Behavior::Avoid, seed, STEPS);
    let mut watched = Watched::new(reading.config.clone(), half);
    let episode = run_with(world, &setup, &mut watched, |_, _, _| {})?;
    let others = other_moves(&setup, world)?;
    let steps = episode.recording.map_or(Vec::new(), |r| r.seeking);
    let goal = Goal::avoiding(&reading.config);
    let learned = watched.learned.as_deref().ok_or(EpisodeError::Silent)?;
    let late = watched.seen.get(half..).unwrap_or_default();
    Ok(Room {
        report: episode.report,
        plans: Plans::of(&watched.seen),
        ways: Ways::of(learned, &goal),
        order: order_of(learned.situations(), &lessons(learned, reading), seed),
        gaps: Gaps::of(world, &steps),
        recalled: Recalled::of(learned, &others, &reading.config),
        alike: samples_alike(learned, &watched.seen),
        discreteness: watched
            .later
            .as_deref()
            .map(|later| Discreteness::of(learned, later, late)),
    })
}

/// The situations the map has learned from: where every sample counts turned by each ring step, all of those.
fn lessons(state: &SimState, reading: &Reading) -> Vec<Situation<16>> {
    let turns = if reading.config.learning.turned {
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

/// What a mind knows after other random moves in the same room.
fn other_moves(setup: &Setup, world: &World) -> Result<Box<SimState>, EpisodeError> {
    let other = Setup {
        seed: setup.seed.wrapping_add(OTHER_MOVES),
        steps: 1,
        record: false,
        ..setup.clone()
    };
    let mut watched = Watched::new(other.config.clone(), 0);
    run_with(world, &other, &mut watched, |_, _, _| {})?;
    watched.learned.ok_or(EpisodeError::Silent)
}
