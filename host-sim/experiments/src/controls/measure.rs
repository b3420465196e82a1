//! Measures rows over all scenes: means with 95 % intervals, and differences from the two maps,
//! paired by world and seed.

use super::ControlRow;
use super::pilot::ControlPilot;
use crate::behaviors::{BehaviorTrial, BySeed, run_all};
use crate::scenes::{BehaviorScene, OTHER_KINDS, SCENES};
use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use sim::episode::{EpisodeReport, Setup, run_with};
use sim::error::EpisodeError;
use sim::statistics::{Mean, bootstrap};

/// Where the worlds come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorldSet {
    /// The rooms of the behaviors' scenes.
    Rooms,
    /// Corridors, mazes, halls and other kinds.
    OtherKinds,
}

impl WorldSet {
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rooms => "rooms",
            Self::OtherKinds => "other kinds",
        }
    }
}

/// Size and conditions.
#[derive(Debug, Clone)]
pub struct ControlTrial {
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
    /// Sonar model.
    pub sonar: SonarModel,
    /// Neurons of each map, one of [`NEURON_COUNTS`](sim::episode::NEURON_COUNTS).
    pub neurons: u8,
}

/// A measure, taken in one scene.
#[derive(Clone, Copy)]
pub struct ControlMeasure {
    /// Its name, with the unit.
    pub name: &'static str,
    /// The scene.
    pub scene: &'static BehaviorScene,
    /// A smaller value is better.
    pub is_error: bool,
    /// A share, shown in percent.
    pub is_share: bool,
}

/// Measures in the rooms: behavior, place and measure of the scene, and their name here.
const IN_ROOMS: [(&str, &str, &str, &str); 7] = [
    ("avoid", "12 boxes", "clean rooms", "clean rooms, %"),
    ("avoid", "12 boxes", "area m²", "area, m²"),
    ("wall-right", "plain room", "error m", "wall error plain, m"),
    ("wall-right", "five boxes", "error m", "wall error boxes, m"),
    (
        "wall-right",
        "corridor",
        "error m",
        "wall error corridor, m",
    ),
    ("nest", "six boxes", "reached", "nest reached, %"),
    ("follow", "five boxes", "share of 300 s", "followed, %"),
];

/// Measures in the worlds of other kinds.
const IN_OTHER_KINDS: [(&str, &str, &str, &str); 4] = [
    ("avoid", "other kinds", "clean worlds", "clean worlds, %"),
    ("avoid", "other kinds", "area m²", "area, m²"),
    ("wall-right", "other kinds", "error m", "wall error, m"),
    ("nest", "other kinds", "reached", "nest reached, %"),
];

/// The measures of a set of worlds, in the order of the table.
#[must_use]
pub fn measures(set: WorldSet) -> Vec<ControlMeasure> {
    let (scenes, names) = match set {
        WorldSet::Rooms => (SCENES, IN_ROOMS.as_slice()),
        WorldSet::OtherKinds => (OTHER_KINDS, IN_OTHER_KINDS.as_slice()),
    };
    let named = names
        .iter()
        .filter_map(|&(behavior, place, measure, name)| {
            let fits = |scene: &&BehaviorScene| {
                (scene.behavior, scene.place, scene.measure) == (behavior, place, measure)
            };
            scenes.iter().find(fits).map(|scene| ControlMeasure {
                name,
                scene,
                is_error: measure.starts_with("error"),
                is_share: name.ends_with('%'),
            })
        });
    named.collect()
}

/// Episodes of one row: measures of the same behavior and place share theirs.
#[must_use]
pub fn episodes_per_row(measures: &[ControlMeasure], trial: &ControlTrial) -> u64 {
    let sites = measures.chunk_by(share_episodes).count() as u64;
    sites * u64::from(trial.worlds) * u64::from(trial.seeds)
}

fn share_episodes(a: &ControlMeasure, b: &ControlMeasure) -> bool {
    (a.scene.behavior, a.scene.place) == (b.scene.behavior, b.scene.place)
}

/// Values of one measure by world and seed.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    values: BySeed<f64>,
}

impl Results {
    /// Mean with its 95 % interval.
    #[must_use]
    pub fn mean(&self) -> Mean {
        bootstrap(&self.values)
    }

    /// This minus other results of the same episodes.
    #[must_use]
    pub fn less(&self, other: &Self) -> Mean {
        let pairs = self.values.iter().zip(&other.values);
        let differences = pairs.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a - b).collect());
        bootstrap(&differences.collect::<Vec<_>>())
    }
}

/// Whether a difference is for the better (1), for the worse (−1) or within its interval of zero.
#[must_use]
pub fn better(measure: &ControlMeasure, difference: Mean) -> i8 {
    let [low, high] = difference.interval;
    let up = i8::from(low > 0.0) - i8::from(high < 0.0);
    if measure.is_error { -up } else { up }
}

/// Measures a row on all cores, results in the order of `measures`; `done` is called after each
/// episode.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    row: &ControlRow,
    measures: &[ControlMeasure],
    trial: &ControlTrial,
    done: &(impl Fn() + Sync),
) -> Result<Vec<Results>, EpisodeError> {
    let trial_of_scene = BehaviorTrial {
        first: trial.first,
        worlds: trial.worlds,
        seeds: trial.seeds,
        explore_moves: trial.explore_moves,
        preset: trial.preset,
        config: row.config(&trial.config),
        turret: TurretMode::Held,
        robot: None,
        sonar: trial.sonar,
    };
    let mut results = Vec::new();
    for site in measures.chunk_by(share_episodes) {
        let Some(first) = site.first() else { continue };
        let reports = run_all(first.scene, &trial_of_scene, |world, setup| {
            let report = drive(trial.neurons, row, world, setup)?;
            done();
            Ok(report)
        })?;
        results.extend(site.iter().map(|measure| of_reports(measure, &reports)));
    }
    Ok(results)
}

fn of_reports(measure: &ControlMeasure, reports: &BySeed<EpisodeReport>) -> Results {
    let factor = if measure.is_share { 100.0 } else { 1.0 };
    let value = |report: &EpisodeReport| factor * measure.scene.value(report);
    let of_world = |world: &Vec<EpisodeReport>| world.iter().map(value).collect();
    Results {
        values: reports.iter().map(of_world).collect(),
    }
}

fn drive(
    neurons: u8,
    row: &ControlRow,
    world: &World,
    setup: &Setup,
) -> Result<EpisodeReport, EpisodeError> {
    match neurons {
        4 => drive_with::<4>(row, world, setup),
        9 => drive_with::<9>(row, world, setup),
        16 => drive_with::<16>(row, world, setup),
        25 => drive_with::<25>(row, world, setup),
        36 => drive_with::<36>(row, world, setup),
        49 => drive_with::<49>(row, world, setup),
        64 => drive_with::<64>(row, world, setup),
        _ => Err(EpisodeError::OtherNeurons),
    }
}

fn drive_with<const NEURONS: usize>(
    row: &ControlRow,
    world: &World,
    setup: &Setup,
) -> Result<EpisodeReport, EpisodeError> {
    let mut pilot = ControlPilot::<NEURONS>::new(setup.config.clone(), row.slot);
    Ok(run_with(world, setup, &mut pilot, |_, _, _| {})?.report)
}
