//! The BARN benchmark: through a field of cylinders to a goal 10 m ahead, `host-sim barn`.
//!
//! Worlds: D. Perille et al., *Benchmarking metric ground navigation*, 2020
//! ([`barn`](arena::loaders::barn)). Rules and score: X. Xiao et al., IEEE Robotics & Automation
//! Magazine 29(4), 2022, 148–156.

mod known_way;
mod led;
mod routes;
mod seeker;

pub use routes::{RoutePanel, routes};
pub use seeker::{Seeker, SeekerTuning};

use known_way::KnownWay;

use crate::baselines::{PotentialField, VfhPlus, potential_field, vfh_plus};

use amp::config::Config;
use amp::controller::{Event, Outputs};
use amp::shield::ShieldConfig;
use amp::units::Millis;
use arena::robot::{COLLISION_RADIUS_M, TurretMode};
use arena::route::route;
use arena::sonar::SonarModel;
use arena::world::{Point, World};
use files::error::BadInput;
use sim::behavior::Behavior;
use sim::episode::{self, Body, Seeds, Setup};
use sim::error::EpisodeError;
use sim::pilot::{LocalController, Pilot};
use sim::ring_pilot::{Perception, Policy, RingPilot, STEP_M, Steerable};
use sim::turret_pilot::TurretPolicy;
use std::fmt::Display;

/// A run succeeds within this distance of the goal, m.
pub const REACHED_M: f64 = 1.0;
/// Time limit of a run, s.
pub const LIMIT_S: f64 = 100.0;
/// Highest speed of the challenge's robot, m/s.
pub const CHALLENGE_M_S: f64 = 2.0;

/// The challenge's score of a run, 0.125 to 0.25; a failed run scores 0.
///
/// Optimal time (path length at the highest speed) divided by the actual time, which is clamped to
/// 4 to 8 times the optimal time.
#[must_use]
pub fn score(time_s: Option<f64>, path_m: f64, speed_m_s: f64) -> f64 {
    let best_s = path_m / speed_m_s;
    time_s.map_or(0.0, |time_s| {
        best_s / time_s.clamp(4.0 * best_s, 8.0 * best_s)
    })
}

/// What drives the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum BarnMethod {
    /// The maps, led to the goal's position by a memory of places
    Places,
    /// The maps, given the goal's bearing
    Maps,
    /// The maps without the bearing: obstacle avoidance with the first heading toward the goal
    MapsUntold,
    /// VFH+, given the goal's bearing
    VfhPlus,
    /// The potential field, given the goal's bearing
    PotentialField,
    /// Straight toward the goal as far as the shield allows
    Straight,
    /// The widest way, known beforehand, as far as the guard of `places` allows
    KnownWay,
}

impl BarnMethod {
    /// All methods.
    pub const ALL: [Self; 7] = [
        Self::Places,
        Self::Maps,
        Self::MapsUntold,
        Self::VfhPlus,
        Self::PotentialField,
        Self::Straight,
        Self::KnownWay,
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Places => "places",
            Self::Maps => "maps",
            Self::MapsUntold => "maps-untold",
            Self::VfhPlus => "vfh-plus",
            Self::PotentialField => "potential-field",
            Self::Straight => "straight",
            Self::KnownWay => "known-way",
        }
    }
}

/// What all runs share.
#[derive(Debug, Clone)]
pub struct RunConditions {
    /// The controller's configuration; its shield applies to every method.
    pub config: Config<16>,
    /// Sonar model.
    pub sonar: SonarModel,
    /// Number of random moves from which the maps learn.
    pub explore_moves: u16,
    /// Seed of the first world's run; each further world uses the next seed.
    pub seed: u64,
    /// Clearance and attraction of the maps.
    pub tuning: SeekerTuning,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RunEnd {
    /// The robot reached the goal.
    Reached,
    /// The robot touched something.
    Touched,
    /// The time limit passed.
    TimedOut,
}

/// Result of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// How it ended.
    pub end: RunEnd,
    /// When it ended, s after the start.
    pub time_s: f64,
    /// Positions of the robot, beginning at the start.
    pub places: Vec<Point>,
}

impl Run {
    /// Time of a run that reached the goal, s.
    #[must_use]
    pub fn success_s(&self) -> Option<f64> {
        (self.end == RunEnd::Reached).then_some(self.time_s)
    }
}

/// Runs one method in one world; `number` counts the worlds.
///
/// # Errors
/// When the world has no goal or the controller cannot learn.
pub fn run(
    world: &World,
    method: BarnMethod,
    rules: &RunConditions,
    number: u64,
) -> Result<Run, BadInput> {
    let goal = world
        .goal()
        .ok_or_else(|| BadInput::new(format!("world {}: it has no goal", world.name())))?;
    let start = world.start();
    let target = (goal - start.position).turned_back(Point::unit(start.heading));
    let seed = rules.seed.wrapping_add(number);
    let noise_seed = Seeds::of(seed).noise;
    let shield = rules.config.shield;
    let course = target.angle();
    let known_target = Some(target);
    let named = |failure: &dyn Display| BadInput::new(format!("world {}: {failure}", world.name()));
    let maps = || {
        let trained_controller = trained_controller(rules, seed)
            .and_then(|mind| Seeker::new(mind, rules.tuning, course));
        trained_controller.map_err(|failure| named(&failure))
    };
    let body = || Body::new(world, rules.sonar, TurretMode::Held, noise_seed);
    Ok(match method {
        BarnMethod::Places => {
            let robot = led::robot(shield)?;
            let pilot = led::controller(rules, &robot, seed, target);
            let pilot = pilot.map_err(|failure| named(&failure))?;
            let body = Body::of_robot(world, &robot, rules.sonar, noise_seed);
            drive(goal, body, pilot)
        }
        BarnMethod::Maps => drive(goal, body(), Homing::new(maps()?, shield, known_target)),
        BarnMethod::MapsUntold => drive(goal, body(), Homing::new(maps()?, shield, None)),
        BarnMethod::VfhPlus => {
            let policy = VfhPlus::new(vfh_plus::VfhPlusTuning::of(shield.is_some()), course);
            drive(goal, body(), Homing::new(policy, shield, known_target))
        }
        BarnMethod::PotentialField => {
            let policy =
                PotentialField::new(potential_field::PotentialFieldTuning::default(), course);
            drive(goal, body(), Homing::new(policy, shield, known_target))
        }
        BarnMethod::Straight => drive(
            goal,
            body(),
            Homing::new(StraightLine(course), shield, known_target),
        ),
        BarnMethod::KnownWay => {
            let robot = led::robot(shield)?;
            let policy = KnownWay::new(world)?;
            let pilot = TurretPolicy::new(robot.config(rules.config.clone()), &robot, policy);
            let body = Body::of_robot(world, &robot, rules.sonar, noise_seed);
            drive(goal, body, pilot)
        }
    })
}

/// A controller that has explored a random room and learned.
fn trained_controller(rules: &RunConditions, seed: u64) -> Result<LocalController, EpisodeError> {
    let setup = learning(rules, seed);
    let mut mind = LocalController::new(setup.config.clone());
    episode::explore_and_learn(&World::random(seed), &setup, &mut mind)?;
    Ok(mind)
}

/// The conditions in which a controller learns.
fn learning(rules: &RunConditions, seed: u64) -> Setup {
    Setup {
        config: rules.config.clone(),
        preset: String::new(),
        behavior: Behavior::Avoid,
        explore_moves: rules.explore_moves,
        steps: 1,
        seed,
        sonar: rules.sonar,
        turret: TurretMode::Held,
        robot: None,
        set_down: None,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        record: false,
    }
}

fn drive(goal: Point, mut body: Body<'_>, mut pilot: impl Pilot) -> Run {
    let mut places = Vec::new();
    let ended = |end, time_s, places| Run {
        end,
        time_s,
        places,
    };
    while body.time_s() < LIMIT_S {
        let happened = body.advance(&mut pilot);
        let Some(moved) = happened.moved else {
            continue;
        };
        if places.is_empty() {
            places.push(moved.from);
        }
        places.push(moved.to);
        if moved.touched {
            return ended(RunEnd::Touched, body.time_s(), places);
        }
        if moved.to.distance(goal) <= REACHED_M && body.time_s() <= LIMIT_S {
            return ended(RunEnd::Reached, body.time_s(), places);
        }
    }
    ended(RunEnd::TimedOut, LIMIT_S, places)
}

/// A policy that is steered toward a point, which it knows by dead reckoning.
struct Homing<P> {
    pilot: RingPilot<P>,
    /// The point relative to the start, in the ring's frame there; `None` = not given.
    target: Option<Point>,
}

impl<P: Policy> Homing<P> {
    fn new(policy: P, shield: Option<ShieldConfig>, target: Option<Point>) -> Self {
        Self {
            pilot: RingPilot::new(policy, shield),
            target,
        }
    }
}

impl<P: Steerable> Pilot for Homing<P> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if let Some(target) = self.target {
            let bearing = (target - self.pilot.pose().position).angle();
            self.pilot.policy_mut().steer(Some(bearing));
        }
        self.pilot.handle(at, event)
    }
}

/// Whole steps along one bearing, whatever the sonars report: measures the shield alone.
struct StraightLine(f64);

impl Policy for StraightLine {
    fn decide(&mut self, perceived: &Perception) -> Point {
        Point::unit(self.0).turned_back(Point::unit(perceived.pose.heading)) * STEP_M
    }
}

impl Steerable for StraightLine {
    fn steer(&mut self, target: Option<f64>) {
        self.0 = target.unwrap_or(self.0);
    }
}

/// The shortest path of the robot's body to the goal with `margin_m` of clearance; `None` if there
/// is none.
///
/// # Errors
/// When the world has no goal or is too large for the search.
pub fn shortest(world: &World, margin_m: f64) -> Result<Option<Vec<Point>>, BadInput> {
    let goal = world
        .goal()
        .ok_or_else(|| BadInput::new(format!("world {}: it has no goal", world.name())))?;
    route(
        world,
        world.start().position,
        goal,
        COLLISION_RADIUS_M + margin_m,
    )
}

#[cfg(test)]
mod tests;
