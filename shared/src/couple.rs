//! A couple of maps for any body: an action is one value per actuator, not a displacement.
//!
//! The parts are those of the paper. The *lazy memory* stores (situation, action, situation
//! afterwards) of random moves. The *situation map* codes situations. The *action map* tells which
//! action brings which change of situation. A goal is an [interval](crate::goal::Component) for
//! each value of the situation.
//!
//! What an action of an arm changes depends on its posture. So the action map holds, for each
//! neuron k of the situation map, the change J_k,i that the whole action of each actuator i brings
//! there, and predicts
//!
//! ```text
//! change = Σ_i a_i J_k,i
//! ```
//!
//! as in T. M. Martinetz, H. J. Ritter and K. J. Schulten, "Three-Dimensional Neural Net for
//! Learning Visuomotor Coordination of a Robot Arm", IEEE Transactions on Neural Networks 1(1),
//! 1990, 131–136. Each executed action corrects the changes of the winning neuron by the
//! normalized Widrow–Hoff rule, and draws those of its neighbors on the grid along. A map of one
//! neuron is Broyden's rule for a single linear model.
//!
//! Planning takes the paper's steps: the goal neuron, the current neuron, an intermediate
//! situation, and the action that brings the wanted change. The intermediate situation is the goal
//! itself, or a neuron nearer to the goal where the way of ever smaller deviation has ended.
//!
//! Cost: a plan takes `NEURONS · VALUES` products for each of two searches, and at most
//! [`MAX_SWEEPS`] · `ACTION · VALUES` for the action; a correction `NEURONS · ACTION · VALUES`.

mod effects;
mod goal;
mod seek;
mod solver;

pub use effects::Effects;
pub use goal::{Avoided, CoupleGoal};
pub use seek::Seek;
pub use solver::MAX_SWEEPS;

use crate::fixed::{Mask, Weight};
use crate::som::{Decay, Grid, Neighborhood, Schedule, Som, Update};
use heapless::Vec;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;
use seek::Target;

/// Presentations of samples by one call of [`Couple::learn`].
const PRESENTATIONS_PER_CALL: u32 = 16;

/// One move: the situation before it, the executed action and the situation after it.
///
/// Values lie in [0, 1]. An action has one value in [−1, 1] per actuator, in units of its longest
/// move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoupleSample<const VALUES: usize, const ACTION: usize> {
    /// Situation before the move.
    pub before: [Weight; VALUES],
    /// The executed action.
    pub action: [Weight; ACTION],
    /// Situation after it.
    pub after: [Weight; VALUES],
}

/// The open choices of the method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoupleConfig {
    /// Grid of both maps; it should have as many neurons as they.
    pub grid: Grid,
    /// Presentations of samples in a training.
    pub presentations: u32,
    /// Learning rate of a training.
    pub rate: Schedule,
    /// Width of the Gaussian neighborhood in a training, grid steps.
    pub radius: Schedule,
    /// Update of the situation map by an executed action.
    pub online_situation: Update,
    /// Update of the action map by an executed action.
    pub online_action: Update,
    /// A neuron is reached within this root mean squared difference of all values.
    pub near: Weight,
    /// Moves without progress until another target is pursued.
    pub patience: u8,
    /// What is to be avoided is kept off by this beyond its distance.
    pub margin: Weight,
    /// Below this clearance of what is to be avoided moves are shorter, in proportion.
    pub slow: Weight,
}

impl CoupleConfig {
    /// The recommended values for a grid of `columns` × `rows` neurons.
    #[must_use]
    pub const fn of_grid(columns: u16, rows: u16) -> Self {
        let longer = if columns > rows { columns } else { rows };
        Self {
            grid: Grid::rectangle(columns, rows),
            presentations: 10_000,
            rate: Schedule::new(0.5, 0.05, Decay::Exponential),
            radius: Schedule::new(longer as f32 / 2.0, 0.4, Decay::Exponential),
            online_situation: Update::new(Neighborhood::Direct, 0.3, 0.0),
            online_action: Update::new(Neighborhood::Gaussian, 0.8, 0.4),
            near: Weight::from_bits(270),
            patience: 4,
            margin: Weight::from_bits(246),
            slow: Weight::from_bits(1_638),
        }
    }
}

/// One decision with its intermediate values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CouplePlan<const VALUES: usize, const ACTION: usize> {
    /// Best-matching unit of the situation.
    pub current_neuron: usize,
    /// Neuron that is the intermediate situation; `None` = the goal itself.
    pub subgoal_neuron: Option<usize>,
    /// The intermediate situation: the values wanted next.
    pub wanted: [Weight; VALUES],
    /// The action.
    pub action: [Weight; ACTION],
    /// The situation expected after it.
    pub expected: [Weight; VALUES],
    /// The goal holds; the action is zero.
    pub at_goal: bool,
}

/// Two maps of `NEURONS` neurons and a memory of `MEMORY` samples; a situation has `VALUES` values,
/// an action `ACTION`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Couple<
    const VALUES: usize,
    const ACTION: usize,
    const NEURONS: usize,
    const MEMORY: usize,
> {
    situations: Som<NEURONS, VALUES>,
    effects: Effects<VALUES, ACTION, NEURONS>,
    memory: Vec<CoupleSample<VALUES, ACTION>, MEMORY>,
    /// Presentations so far.
    presented: u32,
    generator: Xoshiro128PlusPlus,
}

impl<const VALUES: usize, const ACTION: usize, const NEURONS: usize, const MEMORY: usize>
    Couple<VALUES, ACTION, NEURONS, MEMORY>
{
    /// Nothing remembered or learned. The seed determines the order of the presentations.
    #[must_use]
    pub fn new(config: &CoupleConfig, seed: u64) -> Self {
        Self {
            situations: Som::zeroed(config.grid),
            effects: Effects::zeroed(config.grid),
            memory: Vec::new(),
            presented: 0,
            generator: Xoshiro128PlusPlus::seed_from_u64(seed),
        }
    }

    /// Stores a sample; returns whether there was room for it.
    pub fn remember(&mut self, sample: CoupleSample<VALUES, ACTION>) -> bool {
        self.memory.push(sample).is_ok()
    }

    /// The samples in the order they came.
    #[must_use]
    pub fn memory(&self) -> &[CoupleSample<VALUES, ACTION>] {
        &self.memory
    }

    /// The map of situations.
    #[must_use]
    pub const fn situations(&self) -> &Som<NEURONS, VALUES> {
        &self.situations
    }

    /// The map of changes and actions.
    #[must_use]
    pub const fn effects(&self) -> &Effects<VALUES, ACTION, NEURONS> {
        &self.effects
    }

    /// Presents 16 samples of the memory to both maps; returns whether the training is over.
    /// Without samples it is over at once.
    pub fn learn(&mut self, config: &CoupleConfig) -> bool {
        if self.memory.is_empty() {
            return true;
        }
        if self.presented == 0 {
            self.start();
        }
        for _ in 0..PRESENTATIONS_PER_CALL {
            if self.presented >= config.presentations {
                return true;
            }
            let (step, steps) = (self.presented, config.presentations);
            let (rate, radius) = (config.rate.at(step, steps), config.radius.at(step, steps));
            let update = Update::from_q16(Neighborhood::Gaussian, rate, radius);
            let index = self.below(self.memory.len());
            if let Some(sample) = self.memory.get(index).copied() {
                self.present(&sample, &update, &update);
            }
            self.presented = self.presented.saturating_add(1);
        }
        self.presented >= config.presentations
    }

    /// Learns from an executed action: the maps go on while behaving.
    pub fn correct(&mut self, config: &CoupleConfig, sample: &CoupleSample<VALUES, ACTION>) {
        self.present(sample, &config.online_situation, &config.online_action);
    }

    /// The action towards a goal. `seek` holds what was tried for this goal: begin each goal with
    /// [`Seek::new`].
    #[must_use]
    pub fn plan(
        &self,
        config: &CoupleConfig,
        situation: &[Weight; VALUES],
        goal: &CoupleGoal<VALUES>,
        seek: &mut Seek<NEURONS>,
    ) -> CouplePlan<VALUES, ACTION> {
        // Steps 1 and 2: the goal neuron, if one is needed, and the current neuron.
        let target = seek.target(config, &self.situations, situation, goal);
        let current_neuron = self.situations.bmu(situation, Mask::ALL);
        // Step 3: the intermediate situation.
        let bounds = match target {
            Target::Neuron(neuron) => goal.at_neuron(&self.situations.code_vector(neuron)),
            Target::Goal => goal.goal.components,
        };
        // Step 4: the action that changes the situation towards it.
        let at_goal = goal.holds(situation);
        let action = if at_goal {
            [Weight::ZERO; ACTION]
        } else {
            let keep_off = goal.keep_off(config, situation);
            let rows = self.effects.rows(current_neuron);
            solver::solve(&rows, situation, &bounds, keep_off.as_ref())
        };
        let mut wanted = *situation;
        for (value, component) in wanted.iter_mut().zip(&bounds) {
            *value = component.nearest(*value);
        }
        CouplePlan {
            current_neuron,
            subgoal_neuron: target.neuron(),
            wanted,
            action,
            expected: self.effects.expected(current_neuron, situation, &action),
            at_goal,
        }
    }

    /// Makes situations of the memory the first code vectors.
    fn start(&mut self) {
        for neuron in 0..NEURONS {
            let index = neuron.saturating_mul(self.memory.len());
            let index = index.checked_div(NEURONS).unwrap_or(0);
            if let Some(sample) = self.memory.get(index) {
                self.situations.set_code_vector(neuron, &sample.before);
            }
        }
    }

    /// One sample for both maps. The situation map learns where the move led: there the robot is.
    fn present(
        &mut self,
        sample: &CoupleSample<VALUES, ACTION>,
        situation: &Update,
        action: &Update,
    ) {
        let before = self.situations.bmu(&sample.before, Mask::ALL);
        self.effects.correct(before, sample, action);
        (self.situations).train_step(&sample.after, Mask::ALL, situation);
    }

    /// A random number below `count`; 0 for 0.
    fn below(&mut self, count: usize) -> usize {
        let product = u64::from(self.generator.next_u32()).wrapping_mul(count as u64);
        usize::try_from(product >> 32).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests;
