//! Every behavior in its scenes: many seeds in many worlds, mean and 95 % interval.

use super::scenes::BehaviorScene;
use amp::config::Config;
use arena::noise::Noise;
use arena::robot::{COLLISION_RADIUS_M, TurretMode};
use arena::sonar::SonarModel;
use arena::world::{Pose, World};
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Episode, EpisodeReport, Setup, elsewhere, perceive, run};
use sim::error::EpisodeError;
use sim::goal_file::GoalFile;
use sim::robot::AnyRobot;
use sim::statistics::{Mean, bootstrap};

/// Size and conditions of the measurement.
#[derive(Debug, Clone)]
pub struct BehaviorTrial {
    /// Number of the first world.
    pub first: u64,
    /// Worlds per scene.
    pub worlds: u32,
    /// Seeds per world.
    pub seeds: u32,
    /// Random moves before each behavior.
    pub explore_moves: u16,
    /// Name of the preset behind `config`.
    pub preset: &'static str,
    /// The controller's configuration.
    pub config: Config<16>,
    /// Motion of the turret while the base steers.
    pub turret: TurretMode,
    /// The robot, if it is not the Nomad.
    pub robot: Option<AnyRobot>,
    /// Sonar model, unless the scene has its own.
    pub sonar: SonarModel,
}

/// Result of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOutcome {
    /// The measure.
    pub value: Mean,
    /// Steps with contact, %.
    pub contacts_percent: f64,
    /// Number of episodes.
    pub episodes: usize,
}

/// A value per seed in every world: `[world][seed]`.
pub type BySeed<T> = Vec<Vec<T>>;

/// Runs `one` for all seeds in all worlds of a scene, on all cores. Seeds of world n begin at 1000
/// n.
///
/// # Errors
/// When an episode fails.
pub fn run_all<T: Send>(
    scene: &BehaviorScene,
    trial: &BehaviorTrial,
    one: impl Fn(&World, &Setup) -> Result<T, EpisodeError> + Sync,
) -> Result<BySeed<T>, EpisodeError> {
    let worlds = (0..u64::from(trial.worlds)).into_par_iter();
    let of_world = |index: u64| {
        let number = trial.first.saturating_add(index);
        let world = scene.world(number);
        let seeds = (0..u64::from(trial.seeds)).into_par_iter();
        let of_seed = |seed| one(&world, &setup(scene, trial, &world, seed_of(number, seed)));
        seeds.map(of_seed).collect()
    };
    worlds.map(of_world).collect()
}

/// Measures all seeds in all worlds; `done` is called after each episode.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    scene: &BehaviorScene,
    trial: &BehaviorTrial,
    done: &(impl Fn() + Sync),
) -> Result<SceneOutcome, EpisodeError> {
    let worlds: BySeed<EpisodeReport> = run_all(scene, trial, |world, setup| {
        let report = run(world, setup, |_, _, _| {})?.report;
        done();
        Ok(report)
    })?;
    let values: BySeed<f64> = worlds
        .iter()
        .map(|reports| reports.iter().map(|report| scene.value(report)).collect())
        .collect();
    let all: Vec<_> = worlds.iter().flatten().collect();
    let steps: f64 = all.iter().map(|report| f64::from(report.steps)).sum();
    let contacts: f64 = all.iter().map(|report| f64::from(report.contacts)).sum();
    Ok(SceneOutcome {
        value: bootstrap(&values),
        contacts_percent: 100.0 * contacts / steps.max(1.0),
        episodes: all.len(),
    })
}

/// The first episode of a scene, with every step recorded.
///
/// # Errors
/// When it fails.
pub fn first(scene: &BehaviorScene, trial: &BehaviorTrial) -> Result<Episode, EpisodeError> {
    let world = scene.world(trial.first);
    let mut setup = setup(scene, trial, &world, seed_of(trial.first, 0));
    setup.record = true;
    run(&world, &setup, |_, _, _| {})
}

/// Seed number `seed` of world `number`; each world has a range of 1000.
fn seed_of(number: u64, seed: u64) -> u64 {
    number.wrapping_mul(1_000).wrapping_add(seed)
}

/// One episode in one of the scene's worlds.
fn setup(scene: &BehaviorScene, trial: &BehaviorTrial, world: &World, seed: u64) -> Setup {
    let behavior = match scene.behavior {
        "seek" => shown_place(world, &trial.config, trial.robot.as_ref(), seed),
        name => name.parse().unwrap_or(Behavior::Avoid),
    };
    Setup {
        config: trial.config.clone(),
        preset: trial.preset.to_owned(),
        behavior,
        explore_moves: trial.explore_moves,
        steps: scene.steps,
        seed,
        sonar: scene.sonar.unwrap_or(trial.sonar),
        turret: trial.turret,
        robot: trial.robot.clone(),
        set_down: scene.set_down.map(|place| place(seed)),
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    }
}

/// Seeks a free position drawn by `seed`, of which a robot is shown what exact sensors report
/// there; `None` is the Nomad. `config` is the robot's.
#[must_use]
pub fn shown_place(
    world: &World,
    config: &Config<16>,
    robot: Option<&AnyRobot>,
    seed: u64,
) -> Behavior {
    let mut noise = Noise::new(seed);
    let start = world.start();
    let radius_m = robot.map_or(COLLISION_RADIUS_M, |robot| robot.model().radius_m);
    let place = elsewhere(world, radius_m, start.position, &mut noise);
    let pose = Pose::new(place, start.heading);
    let (situation, known) = perceive(world, pose, robot, SonarModel::Ideal, seed, config);
    Behavior::Seek(Box::new(GoalFile::perceived(
        "shown", &situation, known, place,
    )))
}
