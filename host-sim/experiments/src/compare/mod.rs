//! The mind against other methods: the same robot, sonars, worlds, seeds and budgets of moves; means with intervals,
//! differences from the preset `default` paired by world and seed.

mod drive;
mod method;
mod row;
pub mod search;
mod watch;

pub use drive::{Candidate, Conditions, Outcome, drive};
pub use method::{Constants, MOVES, Method};
pub use row::{Differences, Figures, Row};
pub use watch::Seen;

use arena::world::World;
use rayon::prelude::*;
use sim::error::EpisodeError;

/// What is compared where.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The worlds.
    pub worlds: Vec<World>,
    /// Seed of the first episode in each world; each further one has the next.
    pub first_seed: u64,
    /// Episodes in each world.
    pub seeds: u32,
    /// Methods, in the tables' order.
    pub methods: Vec<Method>,
    /// Budgets of those that go on learning, rising.
    pub moves: Vec<u32>,
    /// Shield off, on, or both one after the other; the rest is the same for all.
    pub conditions: Vec<Conditions>,
}

impl Plan {
    /// How many (world, seed, method, conditions) there are: how often `done` will be called.
    #[must_use]
    pub fn len(&self) -> usize {
        self.worlds.len() * self.seeds as usize * self.methods.len() * self.conditions.len()
    }

    /// Whether nothing is to be measured.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Measures everything, on all cores; the rows come by condition, method and budget. `done` is called after each episode.
///
/// # Errors
/// When an episode fails.
pub fn measure(plan: &Plan, done: &(impl Fn() + Sync)) -> Result<Vec<Row>, EpisodeError> {
    let mut rows = Vec::new();
    for conditions in &plan.conditions {
        let constants = Constants::of(conditions.shield);
        for method in &plan.methods {
            let budgets = method.budgets(&plan.moves);
            let candidate = Candidate {
                method: *method,
                constants: &constants,
                budgets: &budgets,
            };
            let of_seed = |world: &World, seed: u32| {
                let seed = plan.first_seed.wrapping_add(u64::from(seed));
                let outcomes = drive(&candidate, world, seed, conditions);
                done();
                outcomes
            };
            let of_world = |world: &World| {
                let seeds = (0..plan.seeds).into_par_iter();
                seeds.map(|seed| of_seed(world, seed)).collect()
            };
            let measured: Result<Vec<Vec<Vec<Outcome>>>, EpisodeError> =
                plan.worlds.par_iter().map(of_world).collect();
            let measured = measured?;
            for (index, moves) in budgets.iter().enumerate() {
                let of_world = |world: &Vec<Vec<Outcome>>| {
                    world
                        .iter()
                        .filter_map(|all| all.get(index).copied())
                        .collect()
                };
                rows.push(Row {
                    method: *method,
                    moves: *moves,
                    shield: conditions.shield,
                    outcomes: measured.iter().map(of_world).collect(),
                });
            }
        }
    }
    Ok(rows)
}
