//! The action map of a couple: what each actuator changes, by neuron of the situation map.

use super::CoupleSample;
use crate::fixed::{Mask, Weight, Weight32, unit_weight};
use crate::som::{Grid, Som, Update};

/// A squared action below this does not count: a move that hardly happened tells nothing.
/// Units of 2⁻²⁶; 2⁻¹⁴ of a whole move of one actuator, squared.
const MIN_SQUARED: i64 = 1 << 12;

/// For each neuron and actuator, the change of situation that the actuator's whole action brings.
///
/// One map per actuator on the same grid. Changes lie in [−1, 1].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Effects<const VALUES: usize, const ACTION: usize, const NEURONS: usize> {
    by_actuator: [Som<NEURONS, VALUES>; ACTION],
}

impl<const VALUES: usize, const ACTION: usize, const NEURONS: usize>
    Effects<VALUES, ACTION, NEURONS>
{
    /// No action changes anything.
    #[must_use]
    pub fn zeroed(grid: Grid) -> Self {
        Self {
            by_actuator: core::array::from_fn(|_| Som::zeroed(grid)),
        }
    }

    /// The changes at a neuron, actuator by actuator.
    #[must_use]
    pub fn rows(&self, neuron: usize) -> [[Weight32; VALUES]; ACTION] {
        let mut rows = [[Weight32::ZERO; VALUES]; ACTION];
        for (row, map) in rows.iter_mut().zip(&self.by_actuator) {
            if let Some(code) = map.code().get(neuron) {
                *row = *code;
            }
        }
        rows
    }

    /// The situation expected after an action at a neuron, each value within [−1, 1].
    #[must_use]
    pub fn expected(
        &self,
        neuron: usize,
        situation: &[Weight; VALUES],
        action: &[Weight; ACTION],
    ) -> [Weight; VALUES] {
        let change = self.change(neuron, action);
        let mut expected = *situation;
        for (value, change) in expected.iter_mut().zip(change) {
            let bits = i64::from(value.to_bits()).saturating_add(change >> 16);
            *value = clamped(bits);
        }
        expected
    }

    /// Σ a_i J_i at a neuron, in units of 2⁻²⁹.
    fn change(&self, neuron: usize, action: &[Weight; ACTION]) -> [i64; VALUES] {
        let mut change = [0_i64; VALUES];
        for (row, share) in self.rows(neuron).iter().zip(action) {
            let share = i64::from(share.to_bits());
            for (sum, effect) in change.iter_mut().zip(row) {
                // Of 2⁴³ at most; the sum over 2²⁰ actuators would fit.
                let product = share.wrapping_mul(i64::from(effect.to_bits()));
                *sum = sum.wrapping_add(product >> 13);
            }
        }
        change
    }

    /// The neuron learns from a move, and its neighbors on the grid approach what it learns.
    ///
    /// With a learning rate of 1 the neuron predicts the move exactly afterwards, up to rounding.
    pub(super) fn correct(
        &mut self,
        neuron: usize,
        sample: &CoupleSample<VALUES, ACTION>,
        update: &Update,
    ) {
        let squares = sample.action.iter().map(|share| {
            let bits = i64::from(share.to_bits());
            bits.wrapping_mul(bits)
        });
        let squared: i64 = squares.fold(0, i64::wrapping_add);
        if squared < MIN_SQUARED {
            return;
        }
        let expected = self.change(neuron, &sample.action);
        let mut errors = [0_i64; VALUES];
        for (index, error) in errors.iter_mut().enumerate() {
            let value = |row: &[Weight; VALUES]| row.get(index).map_or(0, |v| v.to_bits().into());
            let change: i64 = i64::wrapping_sub(value(&sample.after), value(&sample.before));
            let expected = expected.get(index).copied().unwrap_or(0);
            *error = (change << 16).wrapping_sub(expected);
        }
        let rows = self.rows(neuron);
        for ((map, row), share) in self.by_actuator.iter_mut().zip(&rows).zip(&sample.action) {
            let share = i64::from(share.to_bits());
            let mut target = [Weight::ZERO; VALUES];
            for ((target, effect), error) in target.iter_mut().zip(row).zip(&errors) {
                // An error of 2³⁴ at most, times 2¹³: 13 more bits fit.
                let product = share.wrapping_mul(*error) << 13;
                let step = product.checked_div(squared).unwrap_or(0);
                // Rounded to nearest: 16 bits are those of a sample.
                let sum = i64::from(effect.to_bits()).saturating_add(step);
                *target = clamped(sum.saturating_add(1 << 15) >> 16);
            }
            map.update(neuron, &target, Mask::ALL, update);
        }
    }
}

/// Bits of 2⁻¹³ clamped to [−1, 1].
fn clamped(bits: i64) -> Weight {
    let bits = bits.clamp(i64::from(i16::MIN), i64::from(i16::MAX));
    unit_weight(i32::try_from(bits).unwrap_or(0))
}
