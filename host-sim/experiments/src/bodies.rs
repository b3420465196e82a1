//! Robots of all layouts: how many worlds each leaves clean, how near a wall it keeps, and whether
//! it finds its nest.

use amp::config::Config;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::World;
use files::error::BadInput;
use rayon::prelude::*;
use sim::behavior::Behavior;
use sim::episode::{Body, Episode, Metrics, Seeds, Setup, drive_pilot, run};
use sim::error::EpisodeError;
use sim::robot::AnyRobot;
use sim::statistics::{Mean, bootstrap, median, wilson};
use sim::turret_pilot::PolicyPilot;

mod control;

pub use control::Control;
use control::ControlPolicy;

/// Which generator makes the worlds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Generator {
    /// Rooms with boxes.
    Random,
    /// Worlds of many other kinds.
    Random2,
}

impl Generator {
    /// The world of a seed.
    #[must_use]
    pub fn world(self, seed: u64) -> World {
        match self {
            Self::Random => World::random(seed),
            Self::Random2 => World::random2(seed),
        }
    }

    /// Its name, as `--world` takes it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Random2 => "random2",
        }
    }
}

impl std::str::FromStr for Generator {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let all = [Self::Random, Self::Random2];
        let found = all.into_iter().find(|generator| generator.name() == text);
        found.ok_or_else(|| BadInput::unknown("generator", text, &all.map(Self::name)))
    }
}

/// What all episodes of a table share.
#[derive(Debug, Clone)]
pub struct BodyTrial {
    /// Where the worlds come from.
    pub generator: Generator,
    /// Seed of the first world; each episode uses the seed of its world.
    pub first: u64,
    /// Number of worlds.
    pub worlds: u32,
    /// Random moves before the behavior.
    pub explore_moves: u16,
    /// Steps of the behavior.
    pub steps: u32,
    /// The controller's configuration.
    pub config: Config<16>,
}

/// What one robot did in all worlds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyOutcome {
    /// Worlds.
    pub worlds: usize,
    /// Share of the worlds without a contact while avoiding obstacles, with Wilson's interval. A
    /// robot that stops by itself before the end leaves no clean world.
    pub clean: Mean,
    /// Worlds in which the robot stopped by itself while avoiding obstacles.
    pub stopped: usize,
    /// Contacts while avoiding obstacles.
    pub contacts: u32,
    /// Distance while avoiding obstacles, m.
    pub distance_m: f64,
    /// Error of the distance to a wall on the right, m, with an interval over the worlds; `None`
    /// if that was not tried.
    pub wall_error_m: Option<Mean>,
    /// Share of the worlds in which the robot was at its nest at the end, with Wilson's interval;
    /// `None` if that was not tried.
    pub nest: Option<Mean>,
    /// Median over the worlds of the median and of the greatest error of the sensors' bearings,
    /// degrees, where they were learned.
    pub bearing_errors_deg: Option<[f64; 2]>,
}

impl BodyOutcome {
    /// Contacts per km.
    #[must_use]
    pub fn contacts_per_km(&self) -> f64 {
        f64::from(self.contacts) / (self.distance_m / 1e3).max(1e-9)
    }
}

/// Measures one robot, avoiding obstacles, along walls and back to its nest; `None` = the Nomad
/// with its ring on a held turret and no virtual one. `done` is called after each episode.
pub fn measure(
    robot: Option<&AnyRobot>,
    sonar: SonarModel,
    trial: &BodyTrial,
    done: &(impl Fn() + Sync),
) -> BodyOutcome {
    let drive = |behavior: Behavior| {
        let seeds = trial.first..trial.first + u64::from(trial.worlds);
        let episodes: Vec<Result<Episode, EpisodeError>> = seeds
            .into_par_iter()
            .map(|seed| {
                let setup = setup(robot, sonar, trial, &behavior, seed);
                let episode = run(&trial.generator.world(seed), &setup, |_, _, _| {});
                done();
                episode
            })
            .collect();
        episodes
    };
    let avoiding = drive(Behavior::Avoid);
    let episodes: Vec<_> = avoiding.iter().flatten().collect();
    let reports: Vec<_> = episodes.iter().map(|episode| &episode.report).collect();
    let successes = |behavior| {
        let episodes = drive(behavior);
        let driven = episodes.iter().flatten();
        driven.map(|e| e.report.success).collect::<Vec<_>>()
    };
    let wall_errors_m = successes(Behavior::WallRight);
    let at_nest = successes(Behavior::NEST);
    let found = at_nest.iter().filter(|success| **success == 1.0).count();
    let bearing_errors = |which: usize| {
        let errors = episodes.iter().filter_map(|e| e.bearing_errors_deg);
        let errors: Vec<_> = errors.map(|errors| errors[which]).collect();
        (!errors.is_empty()).then(|| median(errors))
    };
    BodyOutcome {
        worlds: avoiding.len(),
        clean: wilson(
            reports.iter().filter(|report| report.contacts == 0).count(),
            avoiding.len(),
        ),
        stopped: avoiding.len() - reports.len(),
        contacts: reports.iter().map(|report| report.contacts).sum(),
        distance_m: reports.iter().map(|report| report.distance_m).sum(),
        wall_error_m: (!wall_errors_m.is_empty()).then(|| over_worlds(&wall_errors_m)),
        nest: Some(wilson(found, avoiding.len())),
        bearing_errors_deg: bearing_errors(0)
            .zip(bearing_errors(1))
            .map(<[f64; 2]>::from),
    }
}

/// As [`measure`], for a rule without maps; it only avoids obstacles.
pub fn measure_control(
    robot: Option<&AnyRobot>,
    control: Control,
    sonar: SonarModel,
    trial: &BodyTrial,
    done: &(impl Fn() + Sync),
) -> BodyOutcome {
    let seeds = trial.first..trial.first + u64::from(trial.worlds);
    let drives: Vec<_> = seeds
        .into_par_iter()
        .map(|seed| {
            let drive = drive_control(robot, control, sonar, trial, seed);
            done();
            drive
        })
        .collect();
    let driven: Vec<_> = drives.iter().flatten().collect();
    BodyOutcome {
        worlds: drives.len(),
        clean: wilson(
            driven.iter().filter(|driven| driven.contacts == 0).count(),
            drives.len(),
        ),
        stopped: drives.len() - driven.len(),
        contacts: driven.iter().map(|metrics| metrics.contacts).sum(),
        distance_m: driven.iter().map(|metrics| metrics.distance_m).sum(),
        wall_error_m: None,
        nest: None,
        bearing_errors_deg: None,
    }
}

/// Mean of one value per world.
fn over_worlds(values: &[f64]) -> Mean {
    let worlds: Vec<_> = values.iter().map(|value| vec![*value]).collect();
    bootstrap(&worlds)
}

/// Distance that a control keeps from obstacles, in units of the goal's clearance: the best of 1,
/// 1.5 and 2 in the rooms 200 to 247.
const CONTROL_CLEARANCE: f64 = 2.0;

fn drive_control(
    robot: Option<&AnyRobot>,
    control: Control,
    sonar: SonarModel,
    trial: &BodyTrial,
    seed: u64,
) -> Result<Metrics, EpisodeError> {
    let (world, seeds) = (trial.generator.world(seed), Seeds::of(seed));
    let config = setup(robot, sonar, trial, &Behavior::Avoid, seed).config;
    let clearance_m = CONTROL_CLEARANCE * f64::from(config.clearance_mm) / 1e3;
    let step_m = f64::from(config.robot.step_mm) / 1e3;
    let policy = ControlPolicy::new(control, clearance_m, step_m, seeds.exploration);
    let drive = |policy, steps| {
        let (mut pilot, body) = match robot {
            None => (
                PolicyPilot::of_nomad(policy, None),
                Body::new(&world, sonar, TurretMode::Held, seeds.noise),
            ),
            Some(robot) => (
                PolicyPilot::of_robot(config.clone(), robot, policy),
                Body::of_robot(&world, robot, sonar, seeds.noise),
            ),
        };
        let metrics = drive_pilot(&world, &mut pilot, body, steps)?;
        Ok((metrics, pilot.into_policy()))
    };
    let policy = if control.learns() {
        drive(policy, trial.explore_moves.into())?.1.learned()
    } else {
        policy
    };
    drive(policy, trial.steps).map(|(metrics, _)| metrics)
}

fn setup(
    robot: Option<&AnyRobot>,
    sonar: SonarModel,
    trial: &BodyTrial,
    behavior: &Behavior,
    seed: u64,
) -> Setup {
    Setup {
        config: match robot {
            None => trial.config.clone(),
            Some(robot) => robot.config(trial.config.clone()),
        },
        preset: "default".to_owned(),
        behavior: behavior.clone(),
        explore_moves: trial.explore_moves,
        steps: trial.steps,
        seed,
        sonar,
        turret: TurretMode::Held,
        robot: robot.cloned(),
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    }
}
