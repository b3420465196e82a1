//! Metrics of a phase, and the report that is printed of an episode.

use super::measure::Measure;
use super::setup::Setup;
use crate::coverage::Coverage;
use crate::robot::AnyRobot;
use arena::world::{Point, World};
use serde::Serialize;

/// Counts and sums over the steps of one phase.
#[derive(Debug, Clone)]
pub struct Metrics {
    /// Decisions carried out.
    pub steps: u32,
    /// Steps in which the body's own motion touched something.
    pub contacts: u32,
    /// Steps in which another robot ran into the body.
    pub touched_by: u32,
    /// Path length, meters.
    pub distance_m: f64,
    /// Least gap between body and surfaces, meters; `None` before the first step.
    pub min_clearance_m: Option<f64>,
    /// Steps that were decided while the goal held.
    pub goal_steps: u32,
    /// Steps whose motion the shield shortened or stopped.
    pub shield_stops: u32,
    coverage: Coverage,
}

/// Flags of one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StepFlags {
    /// The body's own motion touched something.
    pub touched: bool,
    /// Another robot ran into the body.
    pub touched_by: bool,
    /// The shield shortened or stopped the motion.
    pub shielded: bool,
    /// The goal held when the step was decided.
    pub at_goal: bool,
}

impl Metrics {
    /// Nothing is counted yet of a robot with this radius, meters.
    #[must_use]
    pub fn new(world: &World, radius_m: f64) -> Self {
        Self {
            steps: 0,
            contacts: 0,
            touched_by: 0,
            distance_m: 0.0,
            min_clearance_m: None,
            goal_steps: 0,
            shield_stops: 0,
            coverage: Coverage::new(world.bounds(), radius_m),
        }
    }

    /// Adds a step.
    pub fn step(&mut self, flags: StepFlags) {
        self.steps += 1;
        self.contacts += u32::from(flags.touched);
        self.touched_by += u32::from(flags.touched_by);
        self.goal_steps += u32::from(flags.at_goal);
        self.shield_stops += u32::from(flags.shielded);
    }

    /// Adds a straight piece of the path.
    pub fn moved(&mut self, from: Point, to: Point, traveled_m: f64, clearance_m: f64) {
        self.distance_m += traveled_m;
        let least = self
            .min_clearance_m
            .map_or(clearance_m, |least| least.min(clearance_m));
        self.min_clearance_m = Some(least);
        self.coverage.sweep(from, to);
    }

    /// Area swept, square meters.
    #[must_use]
    pub fn coverage_m2(&self) -> f64 {
        self.coverage.area_m2()
    }
}

/// Result of one world: a line of `host-sim run`, with the fields in this order.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EpisodeReport {
    /// World.
    pub world: String,
    /// Behavior, and the file with its goal, if it has one.
    pub behavior: String,
    /// Robot: [`AnyRobot::label`](crate::robot::AnyRobot::label), `nomad200` for the Nomad.
    pub robot: String,
    /// Preset of the configuration.
    pub preset: String,
    /// Sonar model.
    pub sonar: String,
    /// Seed.
    pub seed: u64,
    /// Random moves made.
    pub explore_moves: u32,
    /// Random moves that touched something.
    pub explore_contacts: u32,
    /// Steps towards the goal.
    pub steps: u32,
    /// Steps in which the body's own motion touched something.
    pub contacts: u32,
    /// Steps in which another robot ran into the body.
    pub touched_by: u32,
    /// Path length while seeking, meters.
    pub distance_m: f64,
    /// Shortest way of the body to the place of the behavior `home`, meters; `None` for others.
    pub shortest_m: Option<f64>,
    /// Least gap to any surface while seeking, meters.
    pub min_clearance_m: f64,
    /// Area swept while seeking, square meters.
    pub coverage_m2: f64,
    /// Steps in which the goal held.
    pub goal_steps: u32,
    /// Steps whose motion the shield shortened or stopped.
    pub shield_stops: u32,
    /// Simulated time of seeking, seconds.
    pub time_s: f64,
    /// The behavior's own measure.
    pub success: f64,
    /// Unit of that measure.
    pub success_unit: &'static str,
}

impl EpisodeReport {
    /// Names of the fields, in order.
    pub const FIELDS: [&str; 20] = [
        "world",
        "behavior",
        "robot",
        "preset",
        "sonar",
        "seed",
        "explore_moves",
        "explore_contacts",
        "steps",
        "contacts",
        "touched_by",
        "distance_m",
        "shortest_m",
        "min_clearance_m",
        "coverage_m2",
        "goal_steps",
        "shield_stops",
        "time_s",
        "success",
        "success_unit",
    ];

    /// The figures of an episode.
    pub(super) fn of(
        world: &World,
        setup: &Setup,
        exploration: &Metrics,
        seeking: &Metrics,
        time_s: f64,
        measure: &Measure,
    ) -> Self {
        let (success, success_unit) = measure.success(&setup.behavior, seeking);
        Self {
            world: world.name().to_owned(),
            behavior: setup.task(),
            robot: setup
                .robot
                .as_ref()
                .map_or_else(|| "nomad200".to_owned(), AnyRobot::label),
            preset: setup.preset.clone(),
            sonar: setup.sonar.name().to_owned(),
            seed: setup.seed,
            explore_moves: exploration.steps,
            explore_contacts: exploration.contacts,
            steps: seeking.steps,
            contacts: seeking.contacts,
            touched_by: seeking.touched_by,
            distance_m: rounded(seeking.distance_m),
            shortest_m: measure.shortest_m.map(rounded),
            min_clearance_m: rounded(seeking.min_clearance_m.unwrap_or(0.0)),
            coverage_m2: rounded(seeking.coverage_m2()),
            goal_steps: seeking.goal_steps,
            shield_stops: seeking.shield_stops,
            time_s: rounded(time_s),
            success: rounded(success),
            success_unit,
        }
    }
}

/// Rounds a figure to four decimals, as it is printed.
#[must_use]
pub fn rounded(value: f64) -> f64 {
    (value * 1e4 + 0.5).floor() / 1e4
}
