//! Comparison with other methods: the same robot, sonars, worlds, seeds and numbers of moves.
//!
//! Prints means with intervals, and differences from the preset `default` paired by world and seed.

mod drive;
mod method;
mod observer;
mod row;
pub mod search;

pub use drive::{Conditions, MethodOutcome, MethodUnderTest, drive};
pub use method::{ComparedMethod, Constants, MOVES};
pub use observer::DriverObservation;
pub use row::{ComparisonRow, Differences, MethodFigures};

use arena::world::World;
use rayon::prelude::*;
use sim::error::EpisodeError;

/// What is compared.
#[derive(Debug, Clone)]
pub struct ComparisonPlan {
    /// The worlds.
    pub worlds: Vec<World>,
    /// Seed of the first episode in each world; each further episode uses the next seed.
    pub first_seed: u64,
    /// Episodes in each world.
    pub seeds: u32,
    /// Methods, in the order of the tables.
    pub methods: Vec<ComparedMethod>,
    /// Learning moves of the methods that learn by reward, rising.
    pub moves: Vec<u32>,
    /// Shield off, on, or both one after the other; everything else is equal.
    pub conditions: Vec<Conditions>,
}

impl ComparisonPlan {
    /// Number of (world, seed, method, conditions): how often `done` is called.
    #[must_use]
    pub fn len(&self) -> usize {
        self.worlds.len() * self.seeds as usize * self.methods.len() * self.conditions.len()
    }

    /// Whether there is nothing to measure.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Measures everything on all cores; rows are ordered by condition, method and budget. `done` is
/// called after each episode.
///
/// # Errors
/// When an episode fails.
pub fn measure(
    plan: &ComparisonPlan,
    done: &(impl Fn() + Sync),
) -> Result<Vec<ComparisonRow>, EpisodeError> {
    let mut rows = Vec::new();
    for conditions in &plan.conditions {
        let constants = Constants::of(conditions.shield);
        for method in &plan.methods {
            let budgets = method.budgets(&plan.moves);
            let candidate = MethodUnderTest {
                method: *method,
                constants: &constants,
                budgets: &budgets,
            };
            let measured = measure_method(plan, &candidate, conditions, done)?;
            for (index, moves) in budgets.iter().enumerate() {
                let of_world = |world: &Vec<Vec<MethodOutcome>>| {
                    world
                        .iter()
                        .filter_map(|all| all.get(index).copied())
                        .collect()
                };
                rows.push(ComparisonRow {
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

/// Outcomes by world, seed and budget.
fn measure_method(
    plan: &ComparisonPlan,
    candidate: &MethodUnderTest<'_>,
    conditions: &Conditions,
    done: &(impl Fn() + Sync),
) -> Result<Vec<Vec<Vec<MethodOutcome>>>, EpisodeError> {
    let of_seed = |world: &World, seed: u32| {
        let seed = plan.first_seed.wrapping_add(u64::from(seed));
        let outcomes = drive(candidate, world, seed, conditions);
        done();
        outcomes
    };
    let of_world = |world: &World| {
        let seeds = (0..plan.seeds).into_par_iter();
        seeds.map(|seed| of_seed(world, seed)).collect()
    };
    plan.worlds.par_iter().map(of_world).collect()
}
