//! Goals by demonstration: each behavior is shown by a teacher and then pursued by robots with
//! other random moves in other worlds.
//!
//! A teacher drives a few times in worlds of its own. Each fifth of its moves is random and is not
//! part of the demonstration, so that it shows how to come back as well (M. Laskey et al., *DART:
//! Noise Injection for Robust Imitation Learning*, CoRL 2017).

mod measure;
mod rules;
mod tasks;
mod teacher;

pub use tasks::{TASKS, Task, TaskKind, TaskWorlds};

use crate::behaviors::BySeed;
use amp::config::Config;
use amp::goal::Goal;
use arena::noise::Noise;
use arena::robot::{COLLISION_RADIUS_M, TurretMode};
use arena::sonar::SonarModel;
use arena::world::{Point, World};
use measure::PathObserver;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::demonstration::{Demonstration, ShownStep, goal_of_demonstrations, goal_of_spread};
use sim::episode::{Setup, elsewhere, explore_and_learn, run_observed};
use sim::error::EpisodeError;
use sim::goal_file::GoalFile;
use sim::pilot::{InspectableController as _, LocalController};
use sim::statistics::{Mean, bootstrap};
use teacher::Demonstrator;

/// The worlds of the demonstrations begin so many numbers after those in which they are pursued.
const DEMONSTRATIONS_AFTER: u64 = 1_000;
/// Most drives of a demonstration.
pub const MAX_DRIVES: u32 = 20;

/// Size and conditions of the measurement.
#[derive(Debug, Clone)]
pub struct DemonstrationTrial {
    /// Number of the first world in which the goal is pursued.
    pub first: u64,
    /// Worlds of each kind; each has a demonstration of its own.
    pub worlds: u32,
    /// Robots in each world, each with its own random moves.
    pub seeds: u32,
    /// Drives of a demonstration, at most [`MAX_DRIVES`].
    pub drives: u32,
    /// Situations of a drive.
    pub length: u32,
    /// Sonar model of the demonstrations and of the robots.
    pub sonar: SonarModel,
    /// The controller's configuration.
    pub config: Config<16>,
}

/// What one demonstration gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DemonstratedGoal {
    /// The goal that was most probably pursued.
    pub learned: Goal<16>,
    /// The control: what the situations have in common.
    pub spread_alone: Goal<16>,
}

/// What pursues a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pursuit<'a> {
    /// The goals of the demonstrations, by world.
    Demonstrated(&'a [DemonstratedGoal]),
    /// Their controls.
    SpreadAlone(&'a [DemonstratedGoal]),
    /// The built-in goal, or the rule that demonstrated it.
    HandWritten,
    /// Obstacle avoidance: no demonstration.
    Avoiding,
}

/// Result of a task.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TaskOutcome {
    /// The task's measure.
    pub value: Mean,
    /// Steps in which the robot touched something, %.
    pub contacts_percent: f64,
}

/// One episode: the measure, steps, and steps with contact.
type Measured = (f64, u32, u32);

/// Measures a task in worlds of one kind; `done` is called after each episode.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    task: &Task,
    worlds: TaskWorlds,
    pursuit: Pursuit<'_>,
    trial: &DemonstrationTrial,
    done: &(impl Fn() + Sync),
) -> Result<TaskOutcome, EpisodeError> {
    let numbers = (0..u64::from(trial.worlds)).into_par_iter();
    let of_world = |index: u64| {
        let number = trial.first + index;
        let goal = match pursuit {
            Pursuit::Demonstrated(goals) => goals.get(index as usize).map(|goal| goal.learned),
            Pursuit::SpreadAlone(goals) => goals.get(index as usize).map(|goal| goal.spread_alone),
            Pursuit::Avoiding => Some(Goal::avoiding(&trial.config)),
            Pursuit::HandWritten => None,
        };
        let world = task.world(worlds, number);
        let seeds = (0..u64::from(trial.seeds)).into_par_iter();
        let of_seed = |seed| {
            let seed = number.wrapping_mul(1_000).wrapping_add(seed);
            let measured = pursue(task, worlds, &world, goal, seed, trial);
            done();
            measured
        };
        seeds.map(of_seed).collect()
    };
    let all: BySeed<Measured> = numbers.map(of_world).collect::<Result<_, _>>()?;
    let values: BySeed<f64> = all
        .iter()
        .map(|world| world.iter().map(|(value, _, _)| *value).collect())
        .collect();
    let sum = |part: fn(&Measured) -> u32| -> u32 { all.iter().flatten().map(part).sum() };
    let (steps, contacts) = (sum(|one| one.1), sum(|one| one.2));
    Ok(TaskOutcome {
        value: bootstrap(&values),
        contacts_percent: 100.0 * f64::from(contacts) / f64::from(steps.max(1)),
    })
}

/// The goals of a task's demonstrations, one for each world; `done` is called after each.
///
/// # Errors
/// When a teacher cannot explore or drive.
pub fn demonstrated_goals(
    task: &Task,
    trial: &DemonstrationTrial,
    done: &(impl Fn() + Sync),
) -> Result<Vec<DemonstratedGoal>, EpisodeError> {
    let goal = |index| {
        let goal = demonstrated_goal(task, index, trial);
        done();
        goal
    };
    (0..u64::from(trial.worlds))
        .into_par_iter()
        .map(goal)
        .collect()
}

/// The goal of demonstration number `index`.
fn demonstrated_goal(
    task: &Task,
    index: u64,
    trial: &DemonstrationTrial,
) -> Result<DemonstratedGoal, EpisodeError> {
    let number = trial.first + DEMONSTRATIONS_AFTER + index * u64::from(MAX_DRIVES);
    let world = task.world(TaskWorlds::Usual, number);
    let mut controller = LocalController::new(trial.config.clone());
    let setup = setup(task, number, trial);
    explore_and_learn(&world, &setup, &mut controller)?;
    let mut shown: Vec<ShownStep> = Vec::new();
    for drive in 0..u64::from(trial.drives) {
        // Each drive is in another world.
        let seed = number + drive;
        let world = task.world(TaskWorlds::Usual, seed);
        let demonstrator = Demonstrator {
            task,
            config: &trial.config,
            state: controller.knowledge()?,
            disturbed: true,
        };
        let start = start(task, TaskWorlds::Usual, &world, seed);
        let driven = demonstrator.drive(&world, start, trial.sonar, trial.length, seed)?;
        shown.extend(driven.shown);
    }
    let demonstration = [Demonstration {
        shown: &shown,
        actions: controller.state().actions(),
        step_mm: trial.config.robot.step_mm,
    }];
    // A teacher that stood all the time shows nothing but to stand.
    let avoiding = |_| Goal::avoiding(&trial.config);
    Ok(DemonstratedGoal {
        learned: goal_of_demonstrations(&demonstration, |_, _| {}).unwrap_or_else(avoiding),
        spread_alone: goal_of_spread(&demonstration).unwrap_or_else(avoiding),
    })
}

fn setup(task: &Task, seed: u64, trial: &DemonstrationTrial) -> Setup {
    Setup {
        config: trial.config.clone(),
        preset: "default".to_owned(),
        behavior: task.behavior(),
        explore_moves: 100,
        steps: task.steps,
        seed,
        sonar: trial.sonar,
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: task.leader,
        record: false,
    }
}

/// Where the robot begins.
fn start(task: &Task, worlds: TaskWorlds, world: &World, seed: u64) -> Point {
    let mut noise = Noise::new(seed);
    let place = elsewhere(
        world,
        COLLISION_RADIUS_M,
        world.start().position,
        &mut noise,
    );
    match task.start {
        Some(start) => start(worlds, world, seed),
        None if task.leader => world.start().position,
        None => place,
    }
}

/// One robot pursues the task; without a goal by the built-in one, or by the teacher's rule.
fn pursue(
    task: &Task,
    worlds: TaskWorlds,
    world: &World,
    goal: Option<Goal<16>>,
    seed: u64,
    trial: &DemonstrationTrial,
) -> Result<Measured, EpisodeError> {
    let mut setup = setup(task, seed, trial);
    let place = start(task, worlds, world, seed);
    setup.set_down = Some(place);
    setup.goal = goal.map(|goal| {
        Box::new(GoalFile {
            path: task.name.to_owned(),
            goal,
            place_mm: None,
        })
    });
    let mut controller = LocalController::new(trial.config.clone());
    if let (None, TaskKind::ByRule { measure, .. }) = (goal, task.kind) {
        explore_and_learn(world, &setup, &mut controller)?;
        let demonstrator = Demonstrator {
            task,
            config: &trial.config,
            state: controller.knowledge()?,
            disturbed: false,
        };
        let driven = demonstrator.drive(world, place, trial.sonar, task.steps, seed)?;
        let value = measure(world, &driven.path);
        return Ok((value, task.steps, driven.path.contacts));
    }
    let mut observer = PathObserver::default();
    let episode = run_observed(
        world,
        &setup,
        &mut controller,
        Some(&mut observer),
        |_, _, _| {},
    )?;
    let report = &episode.report;
    let value = match (task.kind, &setup.behavior) {
        (TaskKind::ByRule { measure, .. }, _) => measure(world, &observer.last(task.steps)),
        (TaskKind::BuiltIn, Behavior::Avoid) => report.coverage_m2,
        (TaskKind::BuiltIn, _) => report.success,
    };
    Ok((value, report.steps, report.contacts))
}
