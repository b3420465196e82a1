//! Runs all measurements for the paper's claims from one seed.

use super::aims;
use super::any_ring::{Count, MOVES};
use super::arms::{self, Arms};
use super::chain::{Chain, Cloud};
use super::claims::sequences::{CUES, FLIPPED};
use super::controls::{self, ReducedReading};
use super::decision::{self, DecisionFigure, decision};
use super::far_goals::{self, FarGoals};
use super::gaps::Gaps;
use super::goal_switch::{self, GoalSwitches};
use super::miniature::{self, Miniature};
use super::ring_sizes;
use super::rooms::{self, RoomResult};
use super::{PaperReading, STEPS, readings};
use crate::ablation::{self, AblationFigures, Variant, VariantDriver};
use crate::behaviors::{self, SceneOutcome};
use crate::compare::{self, ComparedMethod, ComparisonPlan, ComparisonRow, Conditions};
use crate::repetition::{self, Curve};
use crate::scenes::{BehaviorScene, SCENES};
use crate::sequence::{self, Row, SequenceTrial};
use crate::traversed::Aims;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use files::error::BadInput;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::run;
use sim::error::EpisodeError;
use sim::recording::Recording;

/// Numbers of random moves for the measurement of avoidance.
pub const FEWER_MOVES: [u16; 5] = [10, 25, 50, 100, 200];

/// Numbers of moves after which Q-learners are measured.
pub const LEARNING_MOVES: [u32; 4] = [100, 200, 1_000, 5_000];

/// Size of the measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Random rooms in which every decision is observed.
    pub rooms: u32,
    /// Worlds per behavior.
    pub worlds: u32,
    /// Seeds per world, for behaviors and repetitions.
    pub seeds: u32,
    /// Chains of each kind, miniature robots, and episodes in the arena of Fig. 5.
    pub draws: u32,
    /// Repetitions of each behavior, at least 2.
    pub times: u32,
    /// Base seed of all measurements.
    pub seed: u64,
}

/// Receives the progress.
pub trait ProgressListener: Sync {
    /// A part begins that consists of `pieces` pieces.
    fn begin(&self, part: &'static str, pieces: u64);
    /// One piece is done.
    fn done(&self);
}

/// A behavior's scene and its result by reading.
pub type SceneResult = (&'static BehaviorScene, [SceneOutcome; 3]);

/// All measurements.
pub struct Measured {
    /// Size of the measurements.
    pub size: Size,
    /// For each cloud (uniform, clusters, uneven): the drawn chain, then those of the other seeds.
    pub chains: [Vec<Chain>; 3],
    /// The drawn miniature robot, then those of the other seeds.
    pub miniatures: Vec<Miniature>,
    /// A decision of `probe` and a decision of `touzet`.
    pub decisions: [DecisionFigure; 2],
    /// An episode of each of them in the arena of Fig. 5.
    pub episodes: [Recording; 2],
    /// Gaps to walls and to small obstacles in that arena, by reading and seed.
    pub arena: [Vec<Gaps>; 3],
    /// Rooms by reading.
    pub rooms: [Vec<RoomResult>; 3],
    /// Changes of goal by reading and behavior, in the order of [`Behavior::NAMES`].
    pub goal_switches: [Vec<GoalSwitches>; 3],
    /// Avoidance by number of random moves ([`FEWER_MOVES`]), for `default` and `probe`.
    pub moves: Vec<[AblationFigures; 2]>,
    /// Behaviors, by scene.
    pub behaviors: Vec<SceneResult>,
    /// Repetitions, by scene, for `default`.
    pub repetitions: Vec<(&'static BehaviorScene, Curve)>,
    /// Avoidance by rings of 8, 16 and 24 transducers, for `default`: clean rooms and steps with
    /// contact.
    pub rings: Vec<(usize, Vec<Count>)>,
    /// Avoidance with a ring that turns with the heading, for `default`.
    pub following: AblationFigures,
    /// Sequences recalled under noise.
    pub sequences: Vec<Row>,
    /// Goals that are far away, for `default`.
    pub far_goals: FarGoals,
    /// Aims of preset `graph` on the way to the nest.
    pub traversed: Aims,
    /// Arms by the couple of maps.
    pub arms: Arms,
    /// `default` and `probe` with something less in place of the maps.
    pub reduced: [ReducedReading; 2],
    /// Avoidance of the presets and of Q-learners after [`LEARNING_MOVES`].
    pub compared: Vec<ComparisonRow>,
}

/// Why a measurement failed.
#[derive(Debug)]
pub enum MeasureError {
    /// An episode failed.
    Episode(EpisodeError),
    /// A world could not be built.
    World(BadInput),
}

impl std::fmt::Display for MeasureError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Episode(failure) => failure.fmt(f),
            Self::World(bad) => bad.fmt(f),
        }
    }
}

impl std::error::Error for MeasureError {}

impl From<EpisodeError> for MeasureError {
    fn from(failure: EpisodeError) -> Self {
        Self::Episode(failure)
    }
}

impl From<BadInput> for MeasureError {
    fn from(bad: BadInput) -> Self {
        Self::World(bad)
    }
}

/// Runs all measurements. Results are combined in a fixed order, whatever the number of threads.
///
/// # Errors
/// When an episode fails.
pub fn measure(size: Size, progress: &impl ProgressListener) -> Result<Measured, MeasureError> {
    let readings = readings();
    Ok(Measured {
        size,
        chains: chains(size, progress),
        miniatures: miniatures(size, progress)?,
        decisions: decisions(size, &readings, progress)?,
        episodes: [
            episode(&World::paper()?, &readings[1], size.seed)?,
            episode(&World::paper()?, &readings[2], size.seed)?,
        ],
        arena: arena(size, &readings)?,
        rooms: by_reading(&readings, |reading| {
            progress.begin("rooms", u64::from(size.rooms));
            rooms::measure(reading, size.rooms, size.seed, &|| progress.done())
        })?,
        goal_switches: by_reading(&readings, |reading| {
            let rooms = size.rooms.div_ceil(10);
            goal_switch::measure(reading, &Behavior::NAMES, rooms, size.seed)
        })?,
        moves: moves(size, &readings, progress)?,
        behaviors: reached(size, &readings, progress)?,
        repetitions: repetitions(size, &readings[0], progress)?,
        rings: ring_sizes::measure(size, &readings[0], progress),
        following: following(size, &readings[0])?,
        sequences: sequences(size, progress)?,
        far_goals: far_goals::measure(size, &readings[0], progress)?,
        traversed: aims::measure(size, progress)?,
        arms: arms::measure(size, progress),
        reduced: controls::measure(size, [&readings[0], &readings[1]], progress)?,
        compared: compared(size, progress)?,
    })
}

fn by_reading<T>(
    readings: &[PaperReading; 3],
    one: impl Fn(&PaperReading) -> Result<T, EpisodeError>,
) -> Result<[T; 3], EpisodeError> {
    let [first, second, third] = readings;
    Ok([one(first)?, one(second)?, one(third)?])
}

fn seeds(size: Size) -> impl ParallelIterator<Item = u64> {
    (0..u64::from(size.draws))
        .into_par_iter()
        .map(move |i| size.seed.wrapping_add(i))
}

fn chains(size: Size, progress: &impl ProgressListener) -> [Vec<Chain>; 3] {
    progress.begin("chains", 3 * u64::from(size.draws));
    [Cloud::Uniform, Cloud::Clusters, Cloud::Uneven].map(|cloud| {
        let of_seed = |seed| {
            let chain = Chain::trained(cloud, seed);
            progress.done();
            chain
        };
        seeds(size).map(of_seed).collect()
    })
}

fn miniatures(size: Size, progress: &impl ProgressListener) -> Result<Vec<Miniature>, BadInput> {
    progress.begin("minis", u64::from(size.draws));
    let of_seed = |seed| {
        let walked = miniature::walk(seed);
        progress.done();
        walked
    };
    seeds(size).map(of_seed).collect()
}

fn decisions(
    size: Size,
    readings: &[PaperReading; 3],
    progress: &impl ProgressListener,
) -> Result<[DecisionFigure; 2], MeasureError> {
    progress.begin("decision", 2);
    let world = World::paper()?;
    let one = |reading| {
        let shown = decision(reading, &world, size.seed);
        progress.done();
        shown
    };
    Ok([one(&readings[1])?, one(&readings[2])?])
}

fn episode(world: &World, reading: &PaperReading, seed: u64) -> Result<Recording, EpisodeError> {
    let setup = rooms::setup(reading, Behavior::Avoid, seed, decision::STEPS);
    let episode = run(world, &setup, |_, _, _| {})?;
    episode.recording.ok_or(EpisodeError::Silent)
}

fn arena(size: Size, readings: &[PaperReading; 3]) -> Result<[Vec<Gaps>; 3], MeasureError> {
    let world = World::paper()?;
    let gaps = by_reading(readings, |reading| {
        let of_seed = |seed| {
            let recording = episode(&world, reading, seed)?;
            Ok(Gaps::of(&world, &recording.seeking))
        };
        seeds(size).map(of_seed).collect()
    });
    Ok(gaps?)
}

/// Conditions for avoidance in half of the rooms.
fn trial(size: Size, explore_moves: u16) -> ablation::AblationTrial {
    ablation::AblationTrial {
        first: 1,
        rooms: size.rooms.div_ceil(2),
        explore_moves,
        steps: STEPS,
        seed: size.seed,
        sonar: SonarModel::Ideal,
        neurons: 16,
    }
}

fn variant(reading: &PaperReading, turret: TurretMode) -> Variant {
    Variant {
        name: reading.name.to_owned(),
        driver: VariantDriver::Mind(Box::new(reading.config.clone()), turret),
    }
}

fn moves(
    size: Size,
    readings: &[PaperReading; 3],
    progress: &impl ProgressListener,
) -> Result<Vec<[AblationFigures; 2]>, EpisodeError> {
    progress.begin("moves", 2 * FEWER_MOVES.len() as u64);
    let one = |reading: &PaperReading, moves| {
        let figures = ablation::measure(&variant(reading, reading.turret), &trial(size, moves));
        progress.done();
        figures
    };
    FEWER_MOVES
        .into_iter()
        .map(|moves| Ok([one(&readings[0], moves)?, one(&readings[1], moves)?]))
        .collect()
}

fn following(size: Size, reading: &PaperReading) -> Result<AblationFigures, EpisodeError> {
    ablation::measure(&variant(reading, TurretMode::Follow), &trial(size, MOVES))
}

fn sequences(size: Size, progress: &impl ProgressListener) -> Result<Vec<Row>, BadInput> {
    progress.begin("sequence", u64::from(size.draws));
    let trial = SequenceTrial {
        seed: size.seed,
        seeds: size.draws,
        cues: CUES,
        corrected_bits: 0,
    };
    sequence::measure_noise(&trial, &FLIPPED, &|| progress.done())
}

fn compared(
    size: Size,
    progress: &impl ProgressListener,
) -> Result<Vec<ComparisonRow>, EpisodeError> {
    let plan = ComparisonPlan {
        worlds: (1..=u64::from(size.worlds)).map(World::random).collect(),
        first_seed: size.seed,
        seeds: size.seeds,
        methods: vec![
            ComparedMethod::Default,
            ComparedMethod::Probe,
            ComparedMethod::Touzet,
            ComparedMethod::QTable,
            ComparedMethod::QSom,
            ComparedMethod::QTwoSoms,
        ],
        moves: LEARNING_MOVES.into(),
        conditions: vec![Conditions {
            robot: None,
            steps: STEPS,
            sonar: SonarModel::Ideal,
            shield: false,
            timed: false,
        }],
    };
    progress.begin("learners", plan.len() as u64);
    compare::measure(&plan, &|| progress.done())
}

fn behavior_trial(size: Size, reading: &PaperReading) -> behaviors::BehaviorTrial {
    behaviors::BehaviorTrial {
        robot: None,
        first: size.seed,
        worlds: size.worlds,
        seeds: size.seeds,
        explore_moves: MOVES,
        preset: reading.name,
        config: reading.config.clone(),
        turret: reading.turret,
        sonar: SonarModel::Ideal,
    }
}

/// The scenes with exact sonars.
fn scenes() -> impl Iterator<Item = &'static BehaviorScene> {
    SCENES.iter().filter(|scene| scene.sonar.is_none())
}

fn reached(
    size: Size,
    readings: &[PaperReading; 3],
    progress: &impl ProgressListener,
) -> Result<Vec<SceneResult>, EpisodeError> {
    // Avoidance is measured in other rooms, and a distance is no success.
    let selected: Vec<_> = scenes()
        .filter(|scene| scene.behavior != "avoid" && scene.measure != "distance m")
        .collect();
    let each = 3 * u64::from(size.worlds) * u64::from(size.seeds);
    progress.begin("goals", selected.len() as u64 * each);
    let of_scene = |scene: &'static BehaviorScene| {
        let outcomes = by_reading(readings, |reading| {
            behaviors::measure(scene, &behavior_trial(size, reading), &|| progress.done())
        })?;
        Ok((scene, outcomes))
    };
    selected.into_iter().map(of_scene).collect()
}

fn repetitions(
    size: Size,
    reading: &PaperReading,
    progress: &impl ProgressListener,
) -> Result<Vec<(&'static BehaviorScene, Curve)>, EpisodeError> {
    // A perfect first result cannot improve; a chain already repeats its parts.
    let selected: Vec<_> = scenes()
        .filter(|scene| {
            let settled = ["clean rooms", "distance m"].contains(&scene.measure);
            !settled && scene.place != "4 m × 4 m" && !scene.behavior.contains(',')
        })
        .collect();
    let each = 2 * u64::from(size.worlds) * u64::from(size.seeds);
    progress.begin("repeat", selected.len() as u64 * each);
    let of_scene = |scene: &'static BehaviorScene| {
        let trial = behavior_trial(size, reading);
        let curve = repetition::measure(scene, &trial, size.times, &|| progress.done())?;
        Ok((scene, curve))
    };
    selected.into_iter().map(of_scene).collect()
}
