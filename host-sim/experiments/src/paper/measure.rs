//! All measurements, from one seed.

use super::any_ring::{AnyRing, Count, MOVES, Sight};
use super::at_once::{self, AtOnce};
use super::chain::{Chain, Cloud};
use super::decision::{self, DecisionFigure, decision};
use super::gaps::Gaps;
use super::miniature::{self, Miniature};
use super::rooms::{self, Room};
use super::{Reading, STEPS, readings};
use crate::ablation::{self, Driver, Figures, Variant};
use crate::behaviors::{self, Outcome};
use crate::compare::{self, Conditions, Method, Plan, Row};
use crate::repetition::{self, Curve};
use crate::scenes::{SCENES, Scene};
use amp::config::Config;
use amp::goal::Goal;
use amp::robot::{RobotSpec, evenly_spaced};
use arena::robot::TurretMode;
use arena::sonar::{SonarConfig, SonarModel};
use arena::world::World;
use files::error::BadInput;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Seeds, run};
use sim::error::EpisodeError;
use sim::recording::Recording;

/// Random moves with which avoidance is tried.
pub const FEWER_MOVES: [u16; 5] = [10, 25, 50, 100, 200];

/// Moves after which Q-learners are measured.
pub const LEARNING_MOVES: [u32; 4] = [100, 200, 1_000, 5_000];

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Random rooms in which every decision is watched.
    pub rooms: u32,
    /// Worlds of each behavior.
    pub worlds: u32,
    /// Seeds per world of the behaviors and repetitions.
    pub seeds: u32,
    /// Chains of each kind, miniature robots, and episodes in the arena.
    pub draws: u32,
    /// Repetitions of each behavior, at least 2.
    pub times: u32,
    /// Seed of everything.
    pub seed: u64,
}

/// What hears of the progress.
pub trait Watcher: Sync {
    /// A part begins that has so many pieces.
    fn begin(&self, part: &'static str, pieces: u64);
    /// One piece is done.
    fn done(&self);
}

/// A behavior's scene and what came of it by each reading.
pub type Reached = (&'static Scene, [Outcome; 3]);

/// Everything that was measured.
pub struct Measured {
    /// How much.
    pub size: Size,
    /// Of each cloud (uniform, clusters, uneven) the chain that is drawn and those of the other seeds.
    pub chains: [Vec<Chain>; 3],
    /// The miniature robot that is drawn and those of the other seeds.
    pub miniatures: Vec<Miniature>,
    /// A decision of `probe` and one of `touzet`.
    pub decisions: [DecisionFigure; 2],
    /// An episode in the arena after Fig. 5 by each of them.
    pub episodes: [Recording; 2],
    /// Gaps to walls and to small obstacles in that arena, by reading and seed.
    pub arena: [Vec<Gaps>; 3],
    /// Rooms by reading.
    pub rooms: [Vec<Room>; 3],
    /// Changes of goal by reading and behavior, in the order of [`Behavior::NAMES`].
    pub at_once: [Vec<AtOnce>; 3],
    /// Avoidance after fewer and more random moves, by [`FEWER_MOVES`], `default` and `probe`.
    pub moves: Vec<[Figures; 2]>,
    /// Behaviors by scene.
    pub behaviors: Vec<Reached>,
    /// Repetitions by scene, `default`.
    pub repetitions: Vec<(&'static Scene, Curve)>,
    /// Avoidance by rings of 8, 16 and 24 transducers: clean rooms and steps with contact, `default`.
    pub rings: Vec<(usize, Vec<Count>)>,
    /// Avoidance with a ring that turns with the heading, `default`.
    pub following: Figures,
    /// Avoidance by the presets and by Q-learners after [`LEARNING_MOVES`].
    pub compared: Vec<Row>,
}

/// Why not everything was measured.
#[derive(Debug)]
pub enum Unmeasured {
    /// An episode failed.
    Episode(EpisodeError),
    /// A world could not be made.
    World(BadInput),
}

impl std::fmt::Display for Unmeasured {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Episode(failure) => failure.fmt(f),
            Self::World(bad) => bad.fmt(f),
        }
    }
}

impl std::error::Error for Unmeasured {}

impl From<EpisodeError> for Unmeasured {
    fn from(failure: EpisodeError) -> Self {
        Self::Episode(failure)
    }
}

impl From<BadInput> for Unmeasured {
    fn from(bad: BadInput) -> Self {
        Self::World(bad)
    }
}

/// Measures everything; results are put together in a fixed order whatever the number of threads.
///
/// # Errors
/// When an episode fails.
pub fn measure(size: Size, watcher: &impl Watcher) -> Result<Measured, Unmeasured> {
    let readings = readings();
    Ok(Measured {
        size,
        chains: chains(size, watcher),
        miniatures: miniatures(size, watcher)?,
        decisions: decisions(size, &readings, watcher)?,
        episodes: [
            episode(&World::paper()?, &readings[1], size.seed)?,
            episode(&World::paper()?, &readings[2], size.seed)?,
        ],
        arena: arena(size, &readings)?,
        rooms: by_reading(&readings, |reading| {
            watcher.begin("rooms", u64::from(size.rooms));
            rooms::measure(reading, size.rooms, size.seed, &|| watcher.done())
        })?,
        at_once: by_reading(&readings, |reading| {
            let rooms = size.rooms.div_ceil(10);
            at_once::measure(reading, &Behavior::NAMES, rooms, size.seed)
        })?,
        moves: moves(size, &readings, watcher)?,
        behaviors: reached(size, &readings, watcher)?,
        repetitions: repetitions(size, &readings[0], watcher)?,
        rings: rings(size, &readings[0], watcher),
        following: following(size, &readings[0])?,
        compared: compared(size, watcher)?,
    })
}

fn by_reading<T>(
    readings: &[Reading; 3],
    one: impl Fn(&Reading) -> Result<T, EpisodeError>,
) -> Result<[T; 3], EpisodeError> {
    let [first, second, third] = readings;
    Ok([one(first)?, one(second)?, one(third)?])
}

fn seeds(size: Size) -> impl ParallelIterator<Item = u64> {
    (0..u64::from(size.draws))
        .into_par_iter()
        .map(move |i| size.seed.wrapping_add(i))
}

fn chains(size: Size, watcher: &impl Watcher) -> [Vec<Chain>; 3] {
    watcher.begin("chains", 3 * u64::from(size.draws));
    [Cloud::Uniform, Cloud::Clusters, Cloud::Uneven].map(|cloud| {
        let of_seed = |seed| {
            let chain = Chain::trained(cloud, seed);
            watcher.done();
            chain
        };
        seeds(size).map(of_seed).collect()
    })
}

fn miniatures(size: Size, watcher: &impl Watcher) -> Result<Vec<Miniature>, BadInput> {
    watcher.begin("minis", u64::from(size.draws));
    let of_seed = |seed| {
        let walked = miniature::walk(seed);
        watcher.done();
        walked
    };
    seeds(size).map(of_seed).collect()
}

fn decisions(
    size: Size,
    readings: &[Reading; 3],
    watcher: &impl Watcher,
) -> Result<[DecisionFigure; 2], Unmeasured> {
    watcher.begin("decision", 2);
    let world = World::paper()?;
    let one = |reading| {
        let shown = decision(reading, &world, size.seed);
        watcher.done();
        shown
    };
    Ok([one(&readings[1])?, one(&readings[2])?])
}

fn episode(world: &World, reading: &Reading, seed: u64) -> Result<Recording, EpisodeError> {
    let setup = rooms::setup(reading, Behavior::Avoid, seed, decision::STEPS);
    let episode = run(world, &setup, |_, _, _| {})?;
    episode.recording.ok_or(EpisodeError::Silent)
}

fn arena(size: Size, readings: &[Reading; 3]) -> Result<[Vec<Gaps>; 3], Unmeasured> {
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

/// A measurement of avoidance in half of the rooms.
fn trial(size: Size, explore_moves: u16) -> ablation::Trial {
    ablation::Trial {
        first: 1,
        rooms: size.rooms.div_ceil(2),
        explore_moves,
        steps: STEPS,
        seed: size.seed,
        sonar: SonarModel::Ideal,
    }
}

fn variant(reading: &Reading, turret: TurretMode) -> Variant {
    Variant {
        name: reading.name.to_owned(),
        driver: Driver::Mind(Box::new(reading.config.clone()), turret),
    }
}

fn moves(
    size: Size,
    readings: &[Reading; 3],
    watcher: &impl Watcher,
) -> Result<Vec<[Figures; 2]>, EpisodeError> {
    watcher.begin("moves", 2 * FEWER_MOVES.len() as u64);
    let one = |reading: &Reading, moves| {
        let figures = ablation::measure(&variant(reading, reading.turret), &trial(size, moves));
        watcher.done();
        figures
    };
    FEWER_MOVES
        .into_iter()
        .map(|moves| Ok([one(&readings[0], moves)?, one(&readings[1], moves)?]))
        .collect()
}

fn following(size: Size, reading: &Reading) -> Result<Figures, EpisodeError> {
    ablation::measure(&variant(reading, TurretMode::Follow), &trial(size, MOVES))
}

fn compared(size: Size, watcher: &impl Watcher) -> Result<Vec<Row>, EpisodeError> {
    let plan = Plan {
        worlds: (1..=u64::from(size.worlds)).map(World::random).collect(),
        first_seed: size.seed,
        seeds: size.seeds,
        methods: vec![
            Method::Default,
            Method::Probe,
            Method::Touzet,
            Method::QTable,
            Method::QSom,
            Method::QTwoSoms,
        ],
        moves: LEARNING_MOVES.into(),
        conditions: vec![Conditions {
            steps: STEPS,
            sonar: SonarModel::Ideal,
            shield: false,
            timed: false,
        }],
    };
    watcher.begin("learners", plan.len() as u64);
    compare::measure(&plan, &|| watcher.done())
}

fn behavior_trial(size: Size, reading: &Reading) -> behaviors::Trial {
    behaviors::Trial {
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
fn scenes() -> impl Iterator<Item = &'static Scene> {
    SCENES.iter().filter(|scene| scene.sonar.is_none())
}

fn reached(
    size: Size,
    readings: &[Reading; 3],
    watcher: &impl Watcher,
) -> Result<Vec<Reached>, EpisodeError> {
    // Avoidance has rooms of its own, and a way is no success.
    let asked: Vec<_> = scenes()
        .filter(|scene| scene.behavior != "avoid" && scene.measure != "way m")
        .collect();
    let each = 3 * u64::from(size.worlds) * u64::from(size.seeds);
    watcher.begin("goals", asked.len() as u64 * each);
    let of_scene = |scene: &'static Scene| {
        let outcomes = by_reading(readings, |reading| {
            behaviors::measure(scene, &behavior_trial(size, reading), &|| watcher.done())
        })?;
        Ok((scene, outcomes))
    };
    asked.into_iter().map(of_scene).collect()
}

fn repetitions(
    size: Size,
    reading: &Reading,
    watcher: &impl Watcher,
) -> Result<Vec<(&'static Scene, Curve)>, EpisodeError> {
    // What is perfect from the first time on cannot improve; a chain repeats its parts already.
    let asked: Vec<_> = scenes()
        .filter(|scene| {
            let settled = ["clean rooms", "way m"].contains(&scene.measure);
            !settled && scene.place != "4 m × 4 m" && !scene.behavior.contains(',')
        })
        .collect();
    let each = 2 * u64::from(size.worlds) * u64::from(size.seeds);
    watcher.begin("repeat", asked.len() as u64 * each);
    let of_scene = |scene: &'static Scene| {
        let trial = behavior_trial(size, reading);
        let curve = repetition::measure(scene, &trial, size.times, &|| watcher.done())?;
        Ok((scene, curve))
    };
    asked.into_iter().map(of_scene).collect()
}

fn rings(size: Size, reading: &Reading, watcher: &impl Watcher) -> Vec<(usize, Vec<Count>)> {
    watcher.begin("rings", 3);
    let one = |counts: Vec<Count>, sensors| {
        watcher.done();
        (sensors, counts)
    };
    vec![
        one(ring::<8>(size, reading), 8),
        one(ring::<16>(size, reading), 16),
        one(ring::<24>(size, reading), 24),
    ]
}

/// Avoidance in half of the rooms by a Nomad with another ring, whose cones together leave no gap: ±200° by their number.
fn ring<const SENSORS: usize>(size: Size, reading: &Reading) -> Vec<Count> {
    let nomad = RobotSpec::nomad200();
    let robot = RobotSpec {
        directions: evenly_spaced::<SENSORS>(),
        symmetric: true,
        face_radius_mm: nomad.face_radius_mm,
        body_radius_mm: nomad.body_radius_mm,
        step_mm: nomad.step_mm,
        speed_mm_s: nomad.speed_mm_s,
        braking_mm_s2: nomad.braking_mm_s2,
        ring_period_ms: nomad.ring_period_ms,
        steer_ms: nomad.steer_ms,
    };
    let config: Config<SENSORS> = reading.config.for_robot(robot);
    let sight = Sight {
        half_angle_rad: 200.0_f64.to_radians() / SENSORS as f64,
        reach_m: SonarConfig::ideal().max_range_m,
    };
    (0..u64::from(size.rooms.div_ceil(2)))
        .into_par_iter()
        .map(|room| {
            let world = World::random(room.wrapping_add(1));
            let mut robot = AnyRing::new(config.clone(), &world, reading.turret, sight);
            let seed = size.seed.wrapping_add(room);
            robot.explore_and_learn(Seeds::of(seed).exploration, |_| {});
            robot.seek(Goal::avoiding(&config), STEPS)
        })
        .collect()
}
