//! Every behaviour in its scenes: many seeds in many worlds, mean and 95 % interval.

use super::rooms;
use crate::episode::{Failure, Report, Setup, run};
use crate::noise::Noise;
use crate::robot::TurretMode;
use crate::scenes::{Behavior, Captured};
use crate::sonar::{Ring, SonarModel};
use crate::world::{Point, Pose, World};
use amp::config::Config;
use amp::units::Range;
use rayon::prelude::*;

/// A behaviour, its worlds and what it is to reach.
pub struct Scene {
    /// The behaviour's name.
    pub behavior: &'static str,
    /// What the worlds are.
    pub place: &'static str,
    /// Decisions.
    pub steps: u32,
    /// What is asked of the measure.
    pub asked: &'static str,
    /// What the measure is.
    pub measure: &'static str,
    make: fn(u64) -> World,
    value: fn(&Report) -> f64,
}

/// All scenes, in the table's order.
pub static SCENES: &[Scene] = &[
    scene(
        "avoid",
        "12 boxes",
        1_000,
        "≥ 0.995",
        "clean rooms",
        World::random,
        clean,
    ),
    scene(
        "avoid",
        "12 boxes",
        1_000,
        "≥ 18.8",
        "area m²",
        World::random,
        area,
    ),
    scene(
        "avoid-right",
        "one obstacle",
        1_000,
        "≥ 0.80",
        "passed on its left",
        rooms::one_obstacle,
        success,
    ),
    scene(
        "wall-right",
        "plain room",
        1_000,
        "≤ 0.20",
        "error m",
        rooms::plain,
        success,
    ),
    scene(
        "wall-right",
        "five boxes",
        1_000,
        "≤ 0.20",
        "error m",
        rooms::boxes,
        success,
    ),
    scene(
        "wall-right",
        "corridor",
        1_000,
        "≤ 0.20",
        "error m",
        rooms::corridor,
        success,
    ),
    scene(
        "wall-left",
        "plain room",
        1_000,
        "≤ 0.20",
        "error m",
        rooms::plain,
        success,
    ),
    scene(
        "wall-left",
        "five boxes",
        1_000,
        "≤ 0.20",
        "error m",
        rooms::boxes,
        success,
    ),
    scene(
        "wall-left",
        "corridor",
        1_000,
        "≤ 0.20",
        "error m",
        rooms::corridor,
        success,
    ),
    scene(
        "nest",
        "4 m × 4 m",
        1_000,
        "≥ 0.98",
        "reached",
        rooms::small,
        success,
    ),
    scene(
        "nest",
        "six boxes",
        1_000,
        "≥ 0.80",
        "reached",
        rooms::six_boxes,
        success,
    ),
    scene(
        "seek",
        "4 m × 4 m",
        1_000,
        "≥ 0.98",
        "reached",
        rooms::small,
        success,
    ),
    scene(
        "seek",
        "six boxes",
        1_000,
        "≥ 0.80",
        "reached",
        rooms::six_boxes,
        success,
    ),
    scene(
        "follow",
        "plain room",
        400,
        "≥ 0.80",
        "share of 300 s",
        rooms::plain,
        success,
    ),
    scene(
        "follow",
        "five boxes",
        400,
        "≥ 0.80",
        "share of 300 s",
        rooms::boxes,
        success,
    ),
    scene(
        "avoid-right,wall-right,nest",
        "six boxes",
        1_000,
        "",
        "goals reached",
        rooms::six_boxes,
        success,
    ),
];

const fn scene(
    behavior: &'static str,
    place: &'static str,
    steps: u32,
    asked: &'static str,
    measure: &'static str,
    make: fn(u64) -> World,
    value: fn(&Report) -> f64,
) -> Scene {
    Scene {
        behavior,
        place,
        steps,
        asked,
        measure,
        make,
        value,
    }
}

fn clean(report: &Report) -> f64 {
    f64::from(u8::from(report.contacts == 0))
}

fn area(report: &Report) -> f64 {
    report.coverage_m2
}

fn success(report: &Report) -> f64 {
    report.success
}

/// How much is measured, and with what.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Worlds per scene.
    pub worlds: u32,
    /// Seeds per world.
    pub seeds: u32,
    /// The mind's open choices.
    pub config: Config<16>,
    /// What the ring does while the base steers.
    pub turret: TurretMode,
    /// What the sonars return.
    pub sonar: SonarModel,
}

/// A mean with its 95 % interval by the bootstrap over worlds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// The interval's ends.
    pub interval: [f64; 2],
}

/// What came of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The measure.
    pub value: Mean,
    /// Steps with contact, %.
    pub contacts_percent: f64,
    /// Episodes.
    pub episodes: usize,
}

impl Scene {
    /// The setup of one episode in one world.
    #[must_use]
    pub fn setup(&self, trial: &Trial, world: &World, seed: u64) -> Setup {
        let behavior = match self.behavior {
            "seek" => show(world, &trial.config, seed),
            name => name.parse().unwrap_or(Behavior::Avoid),
        };
        Setup {
            config: behavior.adapted(trial.config.clone()),
            preset: String::new(),
            behavior,
            explore_moves: 100,
            steps: self.steps,
            seed,
            sonar: trial.sonar,
            turret: trial.turret,
            record: false,
        }
    }

    /// The scene's measure of an episode.
    #[must_use]
    pub fn value(&self, report: &Report) -> f64 {
        (self.value)(report)
    }

    /// The scene's world number `index`.
    #[must_use]
    pub fn world(&self, index: u64) -> World {
        (self.make)(index)
    }

    /// Measures all seeds in all worlds.
    ///
    /// # Errors
    /// When an episode fails.
    pub fn measure(&self, trial: &Trial) -> Result<Outcome, Failure> {
        let worlds: Result<Vec<_>, _> = (0..u64::from(trial.worlds))
            .into_par_iter()
            .map(|index| {
                let world = self.world(index + 1);
                let seeds = 0..u64::from(trial.seeds);
                let reports = seeds.into_par_iter().map(|seed| {
                    let setup = self.setup(trial, &world, 1_000 * (index + 1) + seed);
                    Ok(run(&world, &setup, |_, _, _| {})?.report)
                });
                reports.collect::<Result<Vec<_>, Failure>>()
            })
            .collect();
        let worlds = worlds?;
        let values: Vec<Vec<f64>> = worlds
            .iter()
            .map(|reports| reports.iter().map(self.value).collect())
            .collect();
        let all: Vec<_> = worlds.iter().flatten().collect();
        let steps: f64 = all.iter().map(|report| f64::from(report.steps)).sum();
        let contacts: f64 = all.iter().map(|report| f64::from(report.contacts)).sum();
        Ok(Outcome {
            value: bootstrap(&values),
            contacts_percent: 100.0 * contacts / steps.max(1.0),
            episodes: all.len(),
        })
    }
}

/// A situation shown to the robot: what an exact ring hears at a free place drawn by `seed`.
fn show(world: &World, config: &Config<16>, seed: u64) -> Behavior {
    let mut noise = Noise::new(seed);
    let start = world.start();
    let place = crate::episode::elsewhere(world, start.position, &mut noise);
    let mut ranges = [None; 16];
    let mut ring = Ring::new(SonarModel::Ideal, &mut noise);
    ring.scan(world, &Pose::new(place, start.heading), &mut ranges);
    let situation = ranges.map(|range: Option<f64>| {
        let range = range.map(|m| Range::from_mm((m * 1e3) as u16));
        config.encoding.value(range)
    });
    let Point { x, y } = place;
    Behavior::Seek(Box::new(Captured {
        path: "shown".to_owned(),
        situation,
        place_mm: Some([x, y].map(|m| libm::rint(m * 1e3) as i32)),
    }))
}

/// Draws of the bootstrap.
const DRAWS: usize = 2_000;

/// Mean and percentile interval; both worlds and the seeds within them are drawn anew.
#[must_use]
pub fn bootstrap(worlds: &[Vec<f64>]) -> Mean {
    let all: Vec<f64> = worlds.iter().flatten().copied().collect();
    let mean_of = |sum: f64, count: usize| sum / count.max(1) as f64;
    let mut noise = Noise::new(1);
    let mut means: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let (mut sum, mut count) = (0.0, 0);
            for _ in worlds {
                let Some(world) = worlds.get(noise.index(worlds.len())) else {
                    continue;
                };
                for _ in world {
                    sum += world.get(noise.index(world.len())).copied().unwrap_or(0.0);
                    count += 1;
                }
            }
            mean_of(sum, count)
        })
        .collect();
    means.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = (share * (DRAWS - 1) as f64) as usize;
        means.get(index).copied().unwrap_or(0.0)
    };
    Mean {
        mean: mean_of(all.iter().sum(), all.len()),
        interval: [at(0.025), at(0.975)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_holds_the_mean_and_narrows() {
        let worlds = |count: usize| vec![vec![0.0, 1.0, 0.0, 1.0]; count];
        let (few, many) = (bootstrap(&worlds(3)), bootstrap(&worlds(300)));
        for found in [few, many] {
            assert!((found.mean - 0.5).abs() < 1e-12);
            assert!(found.interval[0] < 0.5 && found.interval[1] > 0.5);
        }
        let width = |found: Mean| found.interval[1] - found.interval[0];
        assert!(width(many) < width(few) / 5.0);
    }

    #[test]
    fn every_scene_names_a_behaviour() {
        for scene in SCENES {
            let known = scene.behavior == "seek" || scene.behavior.parse::<Behavior>().is_ok();
            assert!(known, "{}", scene.behavior);
        }
    }
}
