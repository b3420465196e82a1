//! The BARN benchmark: through a field of cylinders to a place 10 m ahead, `host-sim barn`.
//!
//! D. Perille et al., *Benchmarking metric ground navigation*, 2020 (the worlds, see [`barn`](arena::world::barn)); X. Xiao et
//! al., *Autonomous ground navigation in highly constrained spaces: lessons learned from the BARN Challenge at ICRA 2022*,
//! IEEE Robotics & Automation Magazine 29(4), 2022, 148–156 (rules and score). A run succeeds when the robot's center comes
//! within 1 m of the goal in 100 s without touching anything. Its score is [`score`].
//!
//! All methods drive the same Nomad 200: a disc of 0.269 m, 16 sonars, at most 0.508 m/s, a decision after each ring, under
//! the same shield. They know the bearing of the goal by dead reckoning and nothing else of the world. The maps learn
//! from their random moves in a random room, never in the field.

mod route;
mod routes;
mod seeker;

pub use route::{length, route};
pub use routes::{RoutePanel, routes};
pub use seeker::{Seeker, Tuning};

use crate::baselines::{PotentialField, VfhPlus, potential_field, vfh_plus};

use amp::config::Config;
use amp::controller::{Event, Outputs};
use amp::shield::Shielding;
use amp::units::Millis;
use arena::robot::{COLLISION_RADIUS_M, TurretMode};
use arena::sonar::SonarModel;
use arena::world::{Point, World};
use files::error::BadInput;
use sim::behavior::Behavior;
use sim::episode::{self, Body, Seeds, Setup};
use sim::error::EpisodeError;
use sim::pilot::{LocalController, Pilot};
use sim::ring_pilot::{Perception, Policy, RingPilot, STEP_M, Steerable};

/// A run succeeds within this distance of the goal, m.
pub const REACHED_M: f64 = 1.0;
/// Time for a run, s.
pub const LIMIT_S: f64 = 100.0;
/// Highest speed of the challenge's robot, m/s.
pub const CHALLENGE_M_S: f64 = 2.0;

/// The challenge's score of a successful run, 0.125 to 0.25: the time the way takes at the highest speed, divided by the time
/// it took, which counts as at least four and at most eight times that. A run that fails scores 0.
#[must_use]
pub fn score(time_s: Option<f64>, way_m: f64, speed_m_s: f64) -> f64 {
    let best_s = way_m / speed_m_s;
    time_s.map_or(0.0, |time_s| {
        best_s / time_s.clamp(4.0 * best_s, 8.0 * best_s)
    })
}

/// Who drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Method {
    /// The maps, told the goal's bearing
    Maps,
    /// The maps without the bearing: obstacle avoidance on a course that begins towards the goal
    MapsUntold,
    /// VFH+, told the goal's bearing
    VfhPlus,
    /// The potential field, told the goal's bearing
    PotentialField,
    /// Straight towards the goal as far as the shield lets it
    Straight,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Maps,
        Self::MapsUntold,
        Self::VfhPlus,
        Self::PotentialField,
        Self::Straight,
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Maps => "maps",
            Self::MapsUntold => "maps-untold",
            Self::VfhPlus => "vfh-plus",
            Self::PotentialField => "potential-field",
            Self::Straight => "straight",
        }
    }
}

/// What all runs have in common.
#[derive(Debug, Clone)]
pub struct Rules {
    /// The mind's open choices; its shield is everybody's.
    pub config: Config<16>,
    /// What the sonars return.
    pub sonar: SonarModel,
    /// Random moves the maps learn from.
    pub explore_moves: u16,
    /// Seed of the first world's run; each further world has the next one.
    pub seed: u64,
    /// What the maps want on the way.
    pub tuning: Tuning,
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// At the goal.
    Reached,
    /// Something was touched.
    Touched,
    /// The time was over.
    TimedOut,
}

/// What came of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// How it ended.
    pub end: End,
    /// When it ended, s.
    pub time_s: f64,
    /// Where the robot has been, from the start on.
    pub places: Vec<Point>,
}

impl Run {
    /// Time of a run that reached the goal, s.
    #[must_use]
    pub fn success_s(&self) -> Option<f64> {
        (self.end == End::Reached).then_some(self.time_s)
    }
}

/// One method in one world; `number` counts the worlds.
///
/// # Errors
/// A world without a goal, a mind that cannot learn.
pub fn run(world: &World, method: Method, rules: &Rules, number: u64) -> Result<Run, BadInput> {
    let goal = world
        .goal()
        .ok_or_else(|| BadInput::new(format!("world {}: it has no goal", world.name())))?;
    let start = world.start();
    let target = (goal - start.position).turned_back(Point::unit(start.heading));
    let seed = rules.seed.wrapping_add(number);
    let shield = rules.config.shield;
    let body = Body::new(world, rules.sonar, TurretMode::Held, Seeds::of(seed).noise);
    let course = target.angle();
    let told = Some(target);
    let maps = || {
        let taught = taught(rules, seed).and_then(|mind| Seeker::new(mind, rules.tuning, course));
        taught.map_err(|failure| BadInput::new(format!("world {}: {failure}", world.name())))
    };
    Ok(match method {
        Method::Maps => drive(goal, body, Homing::new(maps()?, shield, told)),
        Method::MapsUntold => drive(goal, body, Homing::new(maps()?, shield, None)),
        Method::VfhPlus => {
            let policy = VfhPlus::new(vfh_plus::Tuning::of(shield.is_some()), course);
            drive(goal, body, Homing::new(policy, shield, told))
        }
        Method::PotentialField => {
            let policy = PotentialField::new(potential_field::Tuning::default(), course);
            drive(goal, body, Homing::new(policy, shield, told))
        }
        Method::Straight => drive(goal, body, Homing::new(Straight(course), shield, told)),
    })
}

/// A mind that has explored a random room and learned.
fn taught(rules: &Rules, seed: u64) -> Result<LocalController, EpisodeError> {
    let room = World::random(seed);
    let setup = Setup {
        config: rules.config.clone(),
        preset: String::new(),
        behavior: Behavior::Avoid,
        explore_moves: rules.explore_moves,
        steps: 1,
        seed,
        sonar: rules.sonar,
        turret: TurretMode::Held,
        set_down: None,
        faults: Vec::new(),
        record: false,
    };
    let mut mind = LocalController::new(setup.config.clone());
    episode::explore_and_learn(&room, &setup, &mut mind)?;
    Ok(mind)
}

fn drive<P: Steerable>(goal: Point, mut body: Body<'_>, mut pilot: Homing<P>) -> Run {
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
            return ended(End::Touched, body.time_s(), places);
        }
        if moved.to.distance(goal) <= REACHED_M && body.time_s() <= LIMIT_S {
            return ended(End::Reached, body.time_s(), places);
        }
    }
    ended(End::TimedOut, LIMIT_S, places)
}

/// A policy that is steered towards a place, as far as dead reckoning tells where that is.
struct Homing<P> {
    pilot: RingPilot<P>,
    /// From the start, in the ring's frame there; `None` = it is not told.
    target: Option<Point>,
}

impl<P: Policy> Homing<P> {
    fn new(policy: P, shield: Option<Shielding>, target: Option<Point>) -> Self {
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

/// Whole steps along a bearing, whatever is heard: what the shield alone is worth.
struct Straight(f64);

impl Policy for Straight {
    fn decide(&mut self, perceived: &Perception) -> Point {
        Point::unit(self.0).turned_back(Point::unit(perceived.pose.heading)) * STEP_M
    }
}

impl Steerable for Straight {
    fn steer(&mut self, target: Option<f64>) {
        self.0 = target.unwrap_or(self.0);
    }
}

/// The shortest way of the robot's body to the goal, with `margin_m` more around it; `None` where there is none.
///
/// # Errors
/// A world without a goal or too large to be searched.
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
