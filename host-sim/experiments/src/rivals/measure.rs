//! Measures rivals in many worlds: obstacle avoidance, along a wall, and back to the nest.

use super::Rival;
use super::controller::{Learned, RivalController, RivalTimes};
use crate::bodies::Generator;
use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{EpisodeReport, Seeds, Setup, run_with};
use sim::error::EpisodeError;
use sim::statistics::{Mean, bootstrap, bootstrap_of, wilson};

/// What all rows of a table share.
#[derive(Debug, Clone)]
pub struct RivalTrial {
    /// Where the worlds come from.
    pub generator: Generator,
    /// Seed of the first world; each episode uses the seed of its world.
    pub first: u64,
    /// Number of worlds.
    pub worlds: u32,
    /// Steps of each behavior.
    pub steps: u32,
    /// Sonar model.
    pub sonar: SonarModel,
    /// The shield limits every motion, including the random ones.
    pub shield: bool,
    /// Measures wall times.
    pub timed: bool,
}

/// What is measured: a rival, with or without the symmetry, after so many random moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RivalRow {
    /// The rival.
    pub rival: Rival,
    /// It learns each move turned by all 16 ring steps.
    pub symmetric: bool,
    /// Random moves.
    pub moves: u16,
}

/// Figures of a row over all worlds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RivalOutcome {
    /// Share of the worlds without a contact while avoiding obstacles, with Wilson's interval.
    pub clean: Mean,
    /// Contacts per 100 m while avoiding obstacles.
    pub contacts_per_100_m: Mean,
    /// Area swept while avoiding obstacles, m².
    pub coverage_m2: Mean,
    /// Error of the distance to a wall on the right, m.
    pub wall_error_m: Mean,
    /// Share of the worlds in which the robot was at its nest at the end, with Wilson's interval.
    pub nest: Mean,
    /// Bytes of what a decision needs.
    pub bytes: f64,
    /// Wall time of learning, µs; 0 unless it was measured.
    pub learning_us: f64,
    /// Wall time of a decision, µs; 0 unless it was measured.
    pub decision_us: f64,
}

const GOALS: [Behavior; 3] = [Behavior::Avoid, Behavior::WallRight, Behavior::NEST];

/// One world: the reports of the three goals, bytes, and wall times.
struct Driven {
    reports: [EpisodeReport; 3],
    bytes: usize,
    times: [RivalTimes; 3],
}

/// Measures a row in all worlds, on all cores; `done` is called after each world.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    row: &RivalRow,
    trial: &RivalTrial,
    done: &(impl Fn() + Sync),
) -> Result<RivalOutcome, EpisodeError> {
    let seeds = trial.first..trial.first + u64::from(trial.worlds);
    let driven: Result<Vec<Driven>, EpisodeError> = seeds
        .into_par_iter()
        .map(|seed| {
            let driven = drive(row, trial, seed);
            done();
            driven
        })
        .collect();
    Ok(outcome(&driven?))
}

fn drive(row: &RivalRow, trial: &RivalTrial, seed: u64) -> Result<Driven, EpisodeError> {
    let world = trial.generator.world(seed);
    // The random moves are the same for all goals: learned from once.
    let mut learned = None;
    let mut pursue = |goal: Behavior| pursue(row, trial, &world, seed, goal, &mut learned);
    let [avoid, wall, nest] = GOALS.map(&mut pursue);
    let (avoid, wall, nest) = (avoid?, wall?, nest?);
    Ok(Driven {
        bytes: avoid.1.bytes(),
        times: [&avoid, &wall, &nest].map(|(_, controller)| controller.times()),
        reports: [avoid.0, wall.0, nest.0],
    })
}

fn pursue(
    row: &RivalRow,
    trial: &RivalTrial,
    world: &World,
    seed: u64,
    behavior: Behavior,
    learned: &mut Option<Learned>,
) -> Result<(EpisodeReport, RivalController), EpisodeError> {
    let mut config = Config::recommended();
    if !trial.shield {
        config.shield = None;
    }
    let setup = Setup {
        preset: "default".to_owned(),
        behavior,
        explore_moves: row.moves,
        steps: trial.steps,
        seed,
        sonar: trial.sonar,
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
        config,
    };
    let own = Seeds::of(seed).exploration;
    let RivalRow {
        rival, symmetric, ..
    } = *row;
    let mut controller = RivalController::new(
        rival,
        symmetric,
        &setup.config,
        own,
        learned.take(),
        trial.timed,
    );
    let report = run_with(world, &setup, &mut controller, |_, _, _| {})?.report;
    *learned = controller.learned().cloned();
    Ok((report, controller))
}

fn outcome(driven: &[Driven]) -> RivalOutcome {
    let count = driven.len();
    let of = |goal: usize, value: fn(&EpisodeReport) -> f64| -> Vec<f64> {
        driven.iter().map(|one| value(&one.reports[goal])).collect()
    };
    let share = |values: Vec<f64>| wilson(values.iter().filter(|v| **v == 1.0).count(), count);
    let by_world = |values: Vec<f64>| -> Vec<Vec<f64>> {
        values.into_iter().map(|value| vec![value]).collect()
    };
    let contacts = of(0, |report| f64::from(report.contacts));
    let distances = of(0, |report| report.distance_m);
    let pairs = contacts.iter().zip(&distances);
    let pairs: Vec<_> = pairs.map(|(c, d)| vec![[100.0 * c, *d]]).collect();
    let times = driven.iter().flat_map(|one| one.times);
    let decisions: u32 = times.clone().map(|times| times.count).sum();
    let thought: f64 = times.map(|times| times.decisions.as_secs_f64()).sum();
    let learning = driven.iter().map(|one| one.times[0].learning.as_secs_f64());
    RivalOutcome {
        clean: share(of(0, |report| f64::from(u8::from(report.contacts == 0)))),
        contacts_per_100_m: bootstrap_of(&pairs, |[contacts, distance], _| {
            contacts / distance.max(1.0)
        }),
        coverage_m2: bootstrap(&by_world(of(0, |report| report.coverage_m2))),
        wall_error_m: bootstrap(&by_world(of(1, |report| report.success))),
        nest: share(of(2, |report| report.success)),
        bytes: driven.iter().map(|one| one.bytes as f64).sum::<f64>() / count.max(1) as f64,
        learning_us: 1e6 * learning.sum::<f64>() / count.max(1) as f64,
        decision_us: 1e6 * thought / f64::from(decisions.max(1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial() -> RivalTrial {
        RivalTrial {
            generator: Generator::Random,
            first: 210,
            worlds: 3,
            steps: 40,
            sonar: SonarModel::Nomad,
            shield: false,
            timed: false,
        }
    }

    fn measured(rival: Rival, threads: usize) -> RivalOutcome {
        let row = RivalRow {
            rival,
            symmetric: true,
            moves: 20,
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let run = || measure(&row, &trial(), &|| {}).expect("it drives");
        pool.expect("threads").install(run)
    }

    #[test]
    fn any_number_of_threads_gives_the_same_figures() {
        for rival in Rival::ALL {
            assert_eq!(measured(rival, 1), measured(rival, 3), "{rival:?}");
        }
    }

    /// What is handed on from goal to goal is what each goal would learn anew.
    #[test]
    fn the_random_moves_are_learned_from_once_for_all_goals() {
        let world = World::random(210);
        for rival in [Rival::Maps, Rival::Forest, Rival::GrowingGas] {
            let row = RivalRow {
                rival,
                symmetric: false,
                moves: 20,
            };
            let wall = |learned| pursue(&row, &trial(), &world, 210, Behavior::WallRight, learned);
            let alone = wall(&mut None).expect("it drives").0;
            let both = drive(&row, &trial(), 210).expect("it drives");
            assert_eq!(alone, both.reports[1], "{rival:?}");
        }
    }
}
