//! The paper's second map: associates actions with changes of situation.
//!
//! A neuron holds a change of situation Δ and an action a: two codebooks on the same grid. Training
//! finds the BMU by both parts, |Δ − Δ_k|² + λ |a − a_k|²; recall probes with the change alone.

mod code;
mod recall;

pub use code::ActionCode;
pub(crate) use recall::Match;
pub use recall::{Answer, Preference, Probe, Recall};

use crate::fixed::{Mask, Weight, Weight32, to_weight16};
use crate::som::kernels::Kernels;
use crate::som::{Grid, Som, Update};

/// A training sample: an action and the change of situation that it caused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effect<const SENSORS: usize> {
    /// Situation after the action minus situation before it.
    pub change: [Weight; SENSORS],
    /// Code of the action.
    pub action: [Weight; 2],
    /// Transducers enabled before and after.
    pub mask: Mask,
}

/// A map of (change of situation, action) pairs.
#[derive(Debug, Clone)]
pub struct ActionMap<const NEURONS: usize, const SENSORS: usize> {
    changes: Som<NEURONS, SENSORS>,
    actions: Som<NEURONS, 2>,
    /// Products of the current code vectors; `None` = not computed.
    products: Option<Products<SENSORS>>,
}

/// Compares code vectors only: the products follow from them.
impl<const NEURONS: usize, const SENSORS: usize> PartialEq for ActionMap<NEURONS, SENSORS> {
    fn eq(&self, other: &Self) -> bool {
        self.changes == other.changes && self.actions == other.actions
    }
}

impl<const NEURONS: usize, const SENSORS: usize> Eq for ActionMap<NEURONS, SENSORS> {}

/// Sums of products over all neurons of a map, at most 31, in units of 2⁻²⁶.
///
/// A decision needs them, and a training step changes the terms of one neuron only. Caching them
/// saves 6 000 instructions per decision on the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Products<const SENSORS: usize> {
    /// Products of the actions' components: x x, x y, y y.
    pub(crate) plane: [i32; 3],
    /// Products of each transducer's change with x and with y.
    pub(crate) changes: [[i32; 2]; SENSORS],
}

impl<const SENSORS: usize> Products<SENSORS> {
    const NONE: Self = Self {
        plane: [0; 3],
        changes: [[0; 2]; SENSORS],
    };

    /// Replaces the terms of a neuron's old code vectors by those of the new ones.
    #[inline(never)]
    fn replace(
        &mut self,
        (old_action, old_change): (&[Weight32; 2], &[Weight32; SENSORS]),
        (action, change): (&[Weight32; 2], &[Weight32; SENSORS]),
    ) {
        let bits = |part: &Weight32| i32::from(to_weight16(*part).to_bits());
        let ([x0, y0], [x, y]) = (old_action, action);
        let (x0, y0, x, y) = (bits(x0), bits(y0), bits(x), bits(y));
        let [xx, xy, yy] = &mut self.plane;
        *xx = xx.wrapping_add(x * x).wrapping_sub(x0 * x0);
        *xy = xy.wrapping_add(x * y).wrapping_sub(x0 * y0);
        *yy = yy.wrapping_add(y * y).wrapping_sub(y0 * y0);
        let changes = old_change.iter().zip(change);
        for ([along_x, along_y], (c0, c)) in self.changes.iter_mut().zip(changes) {
            let (c0, c) = (bits(c0), bits(c));
            *along_x = along_x.wrapping_add(x * c).wrapping_sub(x0 * c0);
            *along_y = along_y.wrapping_add(y * c).wrapping_sub(y0 * c0);
        }
    }
}

impl<const NEURONS: usize, const SENSORS: usize> ActionMap<NEURONS, SENSORS> {
    /// A map with these code vectors.
    #[must_use]
    pub fn new(
        grid: Grid,
        changes: [[Weight; SENSORS]; NEURONS],
        actions: [[Weight; 2]; NEURONS],
    ) -> Self {
        Self {
            changes: Som::new(grid, changes),
            actions: Som::new(grid, actions),
            products: None,
        }
    }

    /// A map whose code vectors are all zero.
    #[must_use]
    pub const fn zeroed(grid: Grid) -> Self {
        Self {
            changes: Som::zeroed(grid),
            actions: Som::zeroed(grid),
            products: None,
        }
    }

    /// The changes of situation, for writing; discards the products.
    pub(crate) const fn changes_mut(&mut self) -> &mut Som<NEURONS, SENSORS> {
        self.products = None;
        &mut self.changes
    }

    /// The actions, for writing; discards the products.
    pub(crate) const fn actions_mut(&mut self) -> &mut Som<NEURONS, 2> {
        self.products = None;
        &mut self.actions
    }

    /// The changes of situation, as a map.
    #[must_use]
    pub const fn changes(&self) -> &Som<NEURONS, SENSORS> {
        &self.changes
    }

    /// The actions, as a map.
    #[must_use]
    pub const fn actions(&self) -> &Som<NEURONS, 2> {
        &self.actions
    }

    /// Uses CPU-specific kernels: see [`Som::use_kernels`].
    pub fn use_kernels(&mut self, kernels: &'static Kernels) {
        self.changes.use_kernels(kernels);
    }

    /// The best-matching unit of an effect; `action_weight_q8` is λ in 1/256.
    #[inline(never)]
    #[must_use]
    pub fn bmu(&self, effect: &Effect<SENSORS>, action_weight_q8: u16) -> usize {
        let Effect {
            change,
            action,
            mask,
        } = effect;
        let weight = action_weight_q8;
        (self.changes).joint_bmu(change, *mask, &self.actions, action, weight)
    }

    /// Computes the products if they are missing. Maps of more than 31 neurons have none: their
    /// sums could overflow.
    pub(crate) fn keep_products(&mut self) {
        if self.products.is_none() && NEURONS <= 31 {
            let products = self.products.insert(Products::NONE);
            let zeros = (&[Weight32::ZERO; 2], &[Weight32::ZERO; SENSORS]);
            for pair in self.actions.code().iter().zip(self.changes.code()) {
                products.replace(zeros, pair);
            }
        }
    }

    /// The products, if they are computed.
    pub(crate) const fn products(&self) -> Option<&Products<SENSORS>> {
        self.products.as_ref()
    }

    /// Moves `bmu` and its neighbors towards an effect. Updates the products if only the BMU moves,
    /// otherwise discards them.
    pub fn update(&mut self, bmu: usize, effect: &Effect<SENSORS>, update: &Update) {
        if !update.is_alone() {
            self.forget_products();
        }
        let code = (self.actions.code().get(bmu), self.changes.code().get(bmu));
        let (Some(_), (Some(old_action), Some(old_change))) = (&self.products, code) else {
            return self.move_code_vectors(bmu, effect, update);
        };
        let (old_action, old_change) = (*old_action, *old_change);
        self.move_code_vectors(bmu, effect, update);
        let code = (self.actions.code().get(bmu), self.changes.code().get(bmu));
        if let (Some(products), (Some(action), Some(change))) = (&mut self.products, code) {
            products.replace((&old_action, &old_change), (action, change));
        }
    }

    /// Discards the products.
    pub(crate) const fn forget_products(&mut self) {
        self.products = None;
    }

    /// One training step. Call [`forget_products`](Self::forget_products) before it.
    #[inline(never)]
    pub(crate) fn train_step(
        &mut self,
        effect: &Effect<SENSORS>,
        action_weight_q8: u16,
        update: &Update,
    ) {
        let bmu = self.bmu(effect, action_weight_q8);
        self.move_code_vectors(bmu, effect, update);
    }

    /// Moves code vectors without updating the products.
    #[inline(never)]
    fn move_code_vectors(&mut self, bmu: usize, effect: &Effect<SENSORS>, update: &Update) {
        let Effect {
            change,
            action,
            mask,
        } = effect;
        self.changes.update(bmu, change, *mask, update);
        self.actions.update(bmu, action, Mask::ALL, update);
    }
}

#[cfg(test)]
mod tests;
