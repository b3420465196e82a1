//! What was tried for a goal, and what is pursued next.

use super::{CoupleConfig, CoupleGoal};
use crate::fixed::{Mask, Weight};
use crate::som::Som;

/// The state of the pursuit of one goal.
///
/// The goal is pursued directly as long as the deviation falls. Where it does not fall any more, at
/// a limit of a joint for example, the untried neuron nearest to the goal is pursued, and from
/// there the goal again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seek<const NEURONS: usize> {
    /// What is pursued; `None` = nothing was pursued yet.
    target: Option<Target>,
    /// Neurons that were pursued.
    tried: [bool; NEURONS],
    /// Least deviation from the target so far.
    least: u64,
    /// Moves since then.
    since: u8,
}

/// What is pursued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    Goal,
    Neuron(usize),
}

impl Target {
    pub(super) const fn neuron(self) -> Option<usize> {
        match self {
            Self::Goal => None,
            Self::Neuron(neuron) => Some(neuron),
        }
    }
}

impl<const NEURONS: usize> Default for Seek<NEURONS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const NEURONS: usize> Seek<NEURONS> {
    /// Nothing was tried.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            target: None,
            tried: [false; NEURONS],
            least: u64::MAX,
            since: 0,
        }
    }

    /// What is pursued from this situation on.
    pub(super) fn target<const VALUES: usize>(
        &mut self,
        config: &CoupleConfig,
        situations: &Som<NEURONS, VALUES>,
        situation: &[Weight; VALUES],
        goal: &CoupleGoal<VALUES>,
    ) -> Target {
        let Some(target) = self.target else {
            return self.first(config, situations, situation, goal);
        };
        let deviation = match target {
            Target::Goal => goal.deviation(situation).unsigned_abs(),
            Target::Neuron(neuron) => situations.distance(neuron, situation, Mask::ALL),
        };
        // Progress is an eighth less.
        if deviation < self.least.saturating_sub(self.least >> 3) {
            (self.least, self.since) = (deviation, 0);
        } else {
            self.since = self.since.saturating_add(1);
        }
        let is_stuck = self.since >= config.patience;
        match target {
            Target::Neuron(_) if is_stuck || deviation <= reached::<VALUES>(config) => {
                self.pursue(Target::Goal)
            }
            Target::Goal if is_stuck => match self.next(config, situations, goal) {
                Some(neuron) => self.pursue(Target::Neuron(neuron)),
                None => {
                    self.tried = [false; NEURONS];
                    self.pursue(Target::Goal)
                }
            },
            _ => target,
        }
    }

    /// The goal neuron if it is nearer to the goal than the situation, otherwise the goal.
    fn first<const VALUES: usize>(
        &mut self,
        config: &CoupleConfig,
        situations: &Som<NEURONS, VALUES>,
        situation: &[Weight; VALUES],
        goal: &CoupleGoal<VALUES>,
    ) -> Target {
        let nearer = self.next(config, situations, goal).filter(|neuron| {
            goal.deviation(&situations.code_vector(*neuron)) < goal.deviation(situation)
        });
        self.pursue(nearer.map_or(Target::Goal, Target::Neuron))
    }

    fn pursue(&mut self, target: Target) -> Target {
        if let Some(tried) = target.neuron().and_then(|n| self.tried.get_mut(n)) {
            *tried = true;
        }
        (self.target, self.least, self.since) = (Some(target), u64::MAX, 0);
        target
    }

    /// The untried neuron nearest to the goal of those clear of what is to be avoided; the lowest
    /// index on ties.
    fn next<const VALUES: usize>(
        &self,
        config: &CoupleConfig,
        situations: &Som<NEURONS, VALUES>,
        goal: &CoupleGoal<VALUES>,
    ) -> Option<usize> {
        let untried = self.tried.iter().enumerate().filter(|(_, tried)| !**tried);
        let codes = untried.map(|(neuron, _)| (neuron, situations.code_vector(neuron)));
        let clear = codes.filter(|(_, code)| goal.is_clear(config, code));
        let nearest = clear.min_by_key(|(_, code)| goal.deviation(code));
        nearest.map(|(neuron, _)| neuron)
    }
}

/// Squared distance of all values within which a neuron is reached, in units of 2⁻⁵⁰.
fn reached<const VALUES: usize>(config: &CoupleConfig) -> u64 {
    let near = u64::from(config.near.to_bits().unsigned_abs());
    (near.wrapping_mul(near) << 24).saturating_mul(VALUES as u64)
}
