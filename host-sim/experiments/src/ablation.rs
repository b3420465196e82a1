//! Ablation: the preset `default` with one option changed at a time, over the same random rooms.
//!
//! Also measures the preset `touzet` and the hand-written reference (Braitenberg).

use sim::braitenberg::{Braitenberg, BraitenbergTuning};

use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use files::error::BadInput;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Body, Seeds, Setup, drive_pilot, run_sized};
use sim::error::EpisodeError;
use sim::ring_pilot::RingPilot;
use sim::settings;

/// One row: a preset with some options changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// What differs from the preset, in words or in the form of `--set`.
    pub name: String,
    /// What drives the robot.
    pub driver: VariantDriver,
}

/// What drives the robot.
#[derive(Debug, Clone, PartialEq)]
pub enum VariantDriver {
    /// The controller with this configuration.
    Mind(Box<Config<16>>, TurretMode),
    /// The hand-written reference.
    Braitenberg,
}

/// Rooms, steps and sonars of a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AblationTrial {
    /// Seed of the first room.
    pub first: u64,
    /// Number of rooms.
    pub rooms: u32,
    /// Random moves.
    pub explore_moves: u16,
    /// Steps in each room.
    pub steps: u32,
    /// Seed of the first room's episode; each further room uses the next seed.
    pub seed: u64,
    /// Sonar model.
    pub sonar: SonarModel,
    /// Neurons of each map, one of [`NEURON_COUNTS`](sim::episode::NEURON_COUNTS).
    pub neurons: u8,
}

/// Means over the rooms.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AblationFigures {
    /// Rooms without contact while seeking.
    pub clean: u32,
    /// Rooms without contact while exploring.
    pub clean_exploring: u32,
    /// Contacts per room.
    pub contacts: f64,
    /// Distance, meters.
    pub distance_m: f64,
    /// Area swept, square meters.
    pub coverage_m2: f64,
    /// Share of the steps in which the goal is met.
    pub goal_share: f64,
    /// Number of steps that the shield shortens.
    pub shield_stops: f64,
}

/// Options changed one at a time from the preset `default`.
const CHANGES: [&str; 40] = [
    "planner=neurons",
    "planner=recall",
    "near=0.15",
    "far=1",
    "far=2",
    "far=3",
    "far=6.5",
    "clearance=0.5",
    "clearance=0.7",
    "clearance=0.9",
    "explore.shortest=0.125",
    "explore.shortest=0.25",
    "action=turn-step",
    "epochs=10",
    "epochs=30",
    "epochs=300",
    "order=recorded",
    "initialization=samples",
    "initialization=random",
    "augment-rotations=off",
    "action-weight=0",
    "action-weight=0.25",
    "action-weight=4",
    "learn-from=commanded",
    "largest-change=10",
    "edges=wrapped",
    "situation.neighborhood=gaussian",
    "situation.rate=0.2:0.02:inverse",
    "action.neighborhood=gaussian",
    "action.rate=0.5:0.05:linear",
    "action.radius=0.5",
    "action.radius=0",
    "online.situation-rate=0",
    "online.action-rate=0",
    "online.action-rate=0.05",
    "online.action-rate=0.2",
    "online.share=0.5",
    "online.learner=recalled",
    "tolerance=0.05",
    "inhibition=0",
];

/// Options of the paper's four steps, changed one at a time from the preset `probe`.
const PROBE_CHANGES: [&str; 12] = [
    "subgoal=hops",
    "subgoal=goal",
    "probe-components=all",
    "probe-neurons=best",
    "recall=distance",
    "recall=projection",
    "change-from=code",
    "straight=0.1",
    "inertia=0.25",
    "full-steps=off",
    "at-goal=ahead",
    "inhibition=0",
];

/// Options that matter to the behaviors other than avoidance.
const BEHAVIOR_CHANGES: [&str; 13] = [
    "planner=neurons",
    "planner=recall",
    "wander=off",
    "wander=3:30",
    "wander=6:10",
    "clearance=0.4",
    "clearance=0.8",
    "far=2",
    "far=3",
    "far=6.5",
    "augment-rotations=off",
    "action.radius=0",
    "epochs=10",
];

/// The rows of the ablation table, in order.
///
/// # Errors
/// When a change is not a valid setting; a test checks all of them.
pub fn variants() -> Result<Vec<Variant>, BadInput> {
    let (held, follow) = (TurretMode::Held, TurretMode::Follow);
    let (default, probe, touzet) = (Config::recommended, Config::probing, Config::touzet);
    let mut rows = vec![
        Variant {
            name: "Braitenberg (reference)".to_owned(),
            driver: VariantDriver::Braitenberg,
        },
        mind_of("default, shield on", default(), held),
        mind_of("default", bare(default()), held),
        mind_of("default, online off", bare(frozen(default())), held),
        mind_of("default, turret follow", bare(default()), follow),
        mind_of("probe, shield on", probe(), held),
        mind_of("probe", bare(probe()), held),
        mind_of("touzet, shield on", touzet(), follow),
        mind_of("touzet", bare(touzet()), follow),
        mind_of("touzet, turret held", bare(touzet()), held),
    ];
    for change in CHANGES {
        rows.push(changed(default(), change, change)?);
    }
    for change in PROBE_CHANGES {
        rows.push(changed(probe(), change, &format!("probe, {change}"))?);
    }
    Ok(rows)
}

/// The rows of the table over the behaviors, in order; without the shield.
///
/// # Errors
/// When a change is not a valid setting; a test checks all of them.
pub fn behavior_variants() -> Result<Vec<Variant>, BadInput> {
    let (held, follow) = (TurretMode::Held, TurretMode::Follow);
    let default = Config::recommended;
    let mut rows = vec![
        mind_of("default", bare(default()), held),
        mind_of("default, online off", bare(frozen(default())), held),
        mind_of("probe", bare(Config::probing()), held),
        mind_of("touzet", bare(Config::touzet()), follow),
    ];
    for change in BEHAVIOR_CHANGES {
        rows.push(changed(default(), change, change)?);
    }
    Ok(rows)
}

fn bare(mut config: Config<16>) -> Config<16> {
    config.shield = None;
    config
}

fn frozen(mut config: Config<16>) -> Config<16> {
    config.online = None;
    config
}

fn mind_of(name: &str, config: Config<16>, turret: TurretMode) -> Variant {
    Variant {
        name: name.to_owned(),
        driver: VariantDriver::Mind(Box::new(config), turret),
    }
}

fn changed(mut config: Config<16>, change: &str, name: &str) -> Result<Variant, BadInput> {
    settings::apply(&mut config, &[change])?;
    Ok(mind_of(name, bare(config), TurretMode::Held))
}

/// Measures one variant over all rooms, on all cores. Sums are taken in the order of the rooms.
///
/// # Errors
/// When an episode fails.
pub fn measure(variant: &Variant, trial: &AblationTrial) -> Result<AblationFigures, EpisodeError> {
    let rooms: Result<Vec<_>, _> = (0..u64::from(trial.rooms))
        .into_par_iter()
        .map(|room| {
            let world = World::random(trial.first.wrapping_add(room));
            let seed = trial.seed.wrapping_add(room);
            one(variant, &AblationTrial { seed, ..*trial }, &world)
        })
        .collect();
    let count = f64::from(trial.rooms.max(1));
    Ok(rooms?
        .iter()
        .fold(AblationFigures::default(), |sum, room| AblationFigures {
            clean: sum.clean + room.clean,
            clean_exploring: sum.clean_exploring + room.clean_exploring,
            contacts: sum.contacts + room.contacts / count,
            distance_m: sum.distance_m + room.distance_m / count,
            coverage_m2: sum.coverage_m2 + room.coverage_m2 / count,
            goal_share: sum.goal_share + room.goal_share / count,
            shield_stops: sum.shield_stops + room.shield_stops / count,
        }))
}

fn one(
    variant: &Variant,
    trial: &AblationTrial,
    world: &World,
) -> Result<AblationFigures, EpisodeError> {
    match &variant.driver {
        VariantDriver::Mind(config, turret) => mind(config, *turret, trial, world),
        VariantDriver::Braitenberg => braitenberg(trial, world),
    }
}

fn mind(
    config: &Config<16>,
    turret: TurretMode,
    trial: &AblationTrial,
    world: &World,
) -> Result<AblationFigures, EpisodeError> {
    let setup = Setup {
        config: config.clone(),
        preset: String::new(),
        behavior: Behavior::Avoid,
        explore_moves: trial.explore_moves,
        steps: trial.steps,
        seed: trial.seed,
        sonar: trial.sonar,
        turret,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    };
    let report = run_sized(trial.neurons, world, &setup, |_, _, _| {})?.report;
    Ok(AblationFigures {
        clean: u32::from(report.contacts == 0),
        clean_exploring: u32::from(report.explore_contacts == 0),
        contacts: f64::from(report.contacts),
        distance_m: report.distance_m,
        coverage_m2: report.coverage_m2,
        goal_share: f64::from(report.goal_steps) / f64::from(report.steps.max(1)),
        shield_stops: f64::from(report.shield_stops),
    })
}

fn braitenberg(trial: &AblationTrial, world: &World) -> Result<AblationFigures, EpisodeError> {
    let body = Body::new(
        world,
        trial.sonar,
        TurretMode::Held,
        Seeds::of(trial.seed).noise,
    );
    let tally = drive_pilot(
        world,
        &mut RingPilot::new(Braitenberg::new(BraitenbergTuning::default()), None),
        body,
        trial.steps,
    )?;
    Ok(AblationFigures {
        clean: u32::from(tally.contacts == 0),
        clean_exploring: 1,
        contacts: f64::from(tally.contacts),
        distance_m: tally.distance_m,
        coverage_m2: tally.coverage_m2(),
        ..AblationFigures::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_changes_something() {
        for rows in [variants(), behavior_variants()] {
            let rows = rows.expect("every change is a setting");
            for row in rows.iter().filter(|row| row.name.contains('=')) {
                let base = match row.name.split_once(", ") {
                    Some((preset, _)) => preset,
                    None => "default",
                };
                let base = rows.iter().find(|other| other.name == base);
                let base = base.expect("the base row");
                assert_ne!(row.driver, base.driver, "{}", row.name);
            }
        }
    }
}
