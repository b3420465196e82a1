//! Goals by demonstration: finds the goal that a demonstrated drive pursued.
//!
//! The planner is taken as a model of the demonstrator, and the goal is chosen by which it would
//! most probably have made the demonstrated moves (maximum-likelihood inverse optimal control; the
//! choice model is that of B. Ziebart et al., *Maximum Entropy Inverse Reinforcement Learning*,
//! AAAI 2008, for one step). All of a goal is found that way: frame, interval and weight of each
//! component, weights of progress and of the heading. The predictions come from the maps that the
//! robot learned by its random moves.
//!
//! The search begins at what the demonstrated situations have in common: a component that stays the
//! same matters, one that varies does not. It moves from there along the gradient.

mod examples;
mod family;
mod likelihood;
mod parameters;
mod record;
mod start;

pub use record::DemonstrationRecorder;

use amp::action_map::ActionMap;
use amp::fixed::Mask;
use amp::goal::{Component, Goal};
use amp::scan::Situation;
use amp::units::Displacement;
use examples::Examples;
use family::{FAMILIES, Family};
use likelihood::Fit;

/// Fewest moves of a demonstration.
pub const MIN_MOVES: usize = 10;
/// Iterations from each start.
const FIRST_ITERATIONS: u32 = 60;
/// They see one example in this many.
const FIRST_EXAMPLES: usize = 3;
/// Starts of each family that are continued: those that are best after these.
const FINALISTS_OF_FAMILY: usize = 2;
/// Iterations that show which of them are best.
const SECOND_ITERATIONS: u32 = 60;
/// Starts that are continued to the end, of all families.
const FINALISTS: usize = 4;
/// Iterations in all.
const ITERATIONS: u32 = 250;
/// A shorter displacement is none, as a share of the longest step.
const STANDING: f64 = 0.1;

/// A situation of a demonstration and how it was left, in the ring's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShownStep {
    /// What was perceived.
    pub situation: Situation<16>,
    /// Transducers whose value is known.
    pub known: Mask,
    /// The displacement before it; zero where there was none.
    pub course: Displacement,
    /// The displacement after it; zero where the robot stood.
    pub moved: Displacement,
}

/// Why no goal can be inferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DemonstrationError {
    /// Fewer moves than [`MIN_MOVES`].
    TooFewMoves {
        /// Number of moves.
        moves: usize,
    },
    /// No situation, or nothing known in any of them.
    NothingPerceived,
}

impl std::error::Error for DemonstrationError {}

impl std::fmt::Display for DemonstrationError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooFewMoves { moves } => write!(
                f,
                "a demonstration needs at least {MIN_MOVES} moves, not {moves}"
            ),
            Self::NothingPerceived => f.write_str("nothing was perceived"),
        }
    }
}

/// Steps of one robot, and what it had learned of its moves.
#[derive(Debug, Clone, Copy)]
pub struct Demonstration<'a> {
    /// The steps.
    pub shown: &'a [ShownStep],
    /// The robot's action map.
    pub actions: &'a ActionMap<16, 16>,
    /// Longest displacement, mm.
    pub step_mm: u16,
}

/// The goal that was most probably pursued in some demonstrations. `progress` is called with the
/// number of iterations done and their number in all.
///
/// # Errors
/// When there are too few moves, or nothing was perceived.
pub fn goal_of_demonstrations(
    demonstrations: &[Demonstration<'_>],
    mut progress: impl FnMut(u32, u32),
) -> Result<Goal<16>, DemonstrationError> {
    let examples = examples_of(demonstrations)?;
    let some = examples.every(FIRST_EXAMPLES);
    let mut families: Vec<Vec<Fit>> = FAMILIES
        .into_iter()
        .map(|family| fits_of(&examples, family))
        .collect();
    let count: usize = families.iter().map(Vec::len).sum();
    let second = (FINALISTS_OF_FAMILY * FAMILIES.len()) as u32;
    let all = count as u32 * FIRST_ITERATIONS
        + second * SECOND_ITERATIONS
        + FINALISTS as u32 * (ITERATIONS - FIRST_ITERATIONS - SECOND_ITERATIONS);
    let mut done = 0;
    let mut improve = |fits: &mut [Fit], examples: &Examples, iterations: u32| {
        for fit in fits {
            for _ in 0..iterations {
                fit.improve(examples, ITERATIONS);
                done += 1;
                progress(done, all);
            }
        }
    };
    for fits in &mut families {
        improve(fits, &some, FIRST_ITERATIONS);
        keep_best(fits, &examples, FINALISTS_OF_FAMILY);
    }
    let mut fits: Vec<Fit> = families.into_iter().flatten().collect();
    improve(&mut fits, &examples, SECOND_ITERATIONS);
    keep_best(&mut fits, &examples, FINALISTS);
    let left = ITERATIONS - FIRST_ITERATIONS - SECOND_ITERATIONS;
    improve(&mut fits, &examples, left);
    keep_best(&mut fits, &examples, 1);
    let goal = fits.first().map(|best| best.goal(&examples));
    goal.ok_or(DemonstrationError::NothingPerceived)
}

fn fits_of(examples: &Examples, family: Family) -> Vec<Fit> {
    let starts = start::starts(examples, family).into_iter();
    starts
        .map(|parameters| Fit::new(family, parameters))
        .collect()
}

/// Keeps those under which the moves are most probable; equals stay in their order.
fn keep_best(fits: &mut Vec<Fit>, examples: &Examples, count: usize) {
    for fit in &mut *fits {
        fit.loss = fit.loss_at(examples);
    }
    fits.sort_by(|a, b| a.loss.total_cmp(&b.loss));
    fits.truncate(count);
}

/// The steps in numbers.
fn examples_of(demonstrations: &[Demonstration<'_>]) -> Result<Examples, DemonstrationError> {
    let shown = || demonstrations.iter().flat_map(|one| one.shown);
    if shown().all(|step| step.known == Mask::NONE) {
        return Err(DemonstrationError::NothingPerceived);
    }
    let moves = shown().filter(|step| step.moved != Displacement::ZERO);
    let moves = moves.count();
    if moves < MIN_MOVES {
        return Err(DemonstrationError::TooFewMoves { moves });
    }
    Ok(Examples::new(demonstrations))
}

/// The control of [`goal_of_demonstrations`]: the start of its search under which the moves are
/// most probable, as it is. It is what the demonstrated situations have in common.
///
/// # Errors
/// As [`goal_of_demonstrations`].
pub fn goal_of_spread(
    demonstrations: &[Demonstration<'_>],
) -> Result<Goal<16>, DemonstrationError> {
    let examples = examples_of(demonstrations)?;
    let fits = FAMILIES
        .into_iter()
        .flat_map(|family| fits_of(&examples, family));
    let mut fits: Vec<Fit> = fits.collect();
    keep_best(&mut fits, &examples, 1);
    let goal = fits.first().map(|best| best.goal(&examples));
    goal.ok_or(DemonstrationError::NothingPerceived)
}

/// The goal that some situations have in common, as a place to be: one situation is asked for as it
/// is, several by the interval that they span, weighted by how little they vary.
///
/// # Errors
/// When nothing was perceived.
pub fn goal_of_situations(shown: &[(Situation<16>, Mask)]) -> Result<Goal<16>, DemonstrationError> {
    match shown {
        [(situation, known)] if *known != Mask::NONE => {
            return Ok(Goal::perceived(situation).for_known(*known));
        }
        _ if shown.iter().all(|(_, known)| *known == Mask::NONE) => {
            return Err(DemonstrationError::NothingPerceived);
        }
        _ => {}
    }
    let components: [Component; 16] = std::array::from_fn(|sensor| {
        let known = shown.iter().filter(|(_, known)| known.contains(sensor));
        let values = known.map(|(situation, _)| situation[sensor].to_num::<f64>());
        start::spread(values, 0.0).map_or(Component::ANY, |spread| Component {
            low: parameters::weight_of(spread.low),
            high: parameters::weight_of(spread.high),
            // Relative to a spread of 1 % of the scale, at least 1.
            weight: libm::rint(16.0 * start::LEAST_VARIANCE * spread.precision).max(1.0) as u8,
        })
    });
    Ok(Goal::place(components))
}

#[cfg(test)]
mod tests;
