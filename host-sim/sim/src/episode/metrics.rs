//! What is counted while a robot drives, and the line that is printed of it.

use crate::coverage::Coverage;
use arena::robot::COLLISION_RADIUS_M;
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
    /// Way traveled, meters.
    pub distance_m: f64,
    /// Least gap between the body and any surface, meters; `None` before the first step.
    pub min_clearance_m: Option<f64>,
    /// Steps decided while the goal held.
    pub goal_steps: u32,
    /// Steps the shield shortened or stopped.
    pub shield_stops: u32,
    coverage: Coverage,
}

/// What one step adds to a [`Metrics`].
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
    /// Nothing counted yet.
    #[must_use]
    pub fn new(world: &World) -> Self {
        Self {
            steps: 0,
            contacts: 0,
            touched_by: 0,
            distance_m: 0.0,
            min_clearance_m: None,
            goal_steps: 0,
            shield_stops: 0,
            coverage: Coverage::new(world.bounds(), COLLISION_RADIUS_M),
        }
    }

    /// A step has ended.
    pub fn step(&mut self, stride: StepFlags) {
        self.steps += 1;
        self.contacts += u32::from(stride.touched);
        self.touched_by += u32::from(stride.touched_by);
        self.goal_steps += u32::from(stride.at_goal);
        self.shield_stops += u32::from(stride.shielded);
    }

    /// The body has moved straight.
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

/// One world's line: what `host-sim run` prints, in this order.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EpisodeReport {
    /// World.
    pub world: String,
    /// Behavior.
    pub behavior: String,
    /// Preset of the open choices.
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
    /// Way traveled while seeking, meters.
    pub distance_m: f64,
    /// Least gap to any surface while seeking, meters.
    pub min_clearance_m: f64,
    /// Area swept while seeking, square meters.
    pub coverage_m2: f64,
    /// Steps in which the goal held.
    pub goal_steps: u32,
    /// Steps the shield shortened or stopped.
    pub shield_stops: u32,
    /// Simulated time of the seeking, seconds.
    pub time_s: f64,
    /// The behavior's own measure.
    pub success: f64,
    /// Unit of that measure.
    pub success_unit: &'static str,
}

impl EpisodeReport {
    /// The names of its fields, in their order.
    pub const FIELDS: [&str; 18] = [
        "world",
        "behavior",
        "preset",
        "sonar",
        "seed",
        "explore_moves",
        "explore_contacts",
        "steps",
        "contacts",
        "touched_by",
        "distance_m",
        "min_clearance_m",
        "coverage_m2",
        "goal_steps",
        "shield_stops",
        "time_s",
        "success",
        "success_unit",
    ];
}

/// A figure as printed: four decimals are below a tenth of a millimeter.
#[must_use]
pub fn rounded(value: f64) -> f64 {
    (value * 1e4 + 0.5).floor() / 1e4
}
