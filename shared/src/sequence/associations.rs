//! A matrix of weights between the bits of two patterns.

use super::Pattern;

/// What each bit of the output gets from each bit of the input: row by output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Associations<const N: usize>([[i8; N]; N]);

impl<const N: usize> Associations<N> {
    pub(super) const fn new() -> Self {
        Self([[0; N]; N])
    }

    /// Hebb's rule.
    pub(super) fn associate(&mut self, from: &Pattern<N>, to: &Pattern<N>) {
        for (row, wanted) in self.0.iter_mut().zip(to.signs()) {
            strengthen(row, *wanted, from);
        }
    }

    /// The same for the bits whose field is less than `N` in the wanted direction. Returns how many
    /// those were.
    pub(super) fn correct(&mut self, from: &Pattern<N>, to: &Pattern<N>) -> u32 {
        let margin = i32::try_from(N).unwrap_or(i32::MAX);
        let mut corrected = 0_u32;
        for (row, wanted) in self.0.iter_mut().zip(to.signs()) {
            // At most 127·N: no overflow below 16 million bits.
            if field(row, from).wrapping_mul(i32::from(*wanted)) < margin {
                strengthen(row, *wanted, from);
                corrected = corrected.saturating_add(1);
            }
        }
        corrected
    }

    /// No bit of an auto-associative network feeds itself.
    pub(super) fn clear_diagonal(&mut self) {
        for (index, row) in self.0.iter_mut().enumerate() {
            if let Some(weight) = row.get_mut(index) {
                *weight = 0;
            }
        }
    }

    /// All bits at once.
    pub(super) fn output(&self, input: &Pattern<N>) -> Pattern<N> {
        let mut output = *input;
        for (index, row) in self.0.iter().enumerate() {
            output.set(index, field(row, input));
        }
        output
    }

    /// One round: each bit after the other, in the order of their numbers. Returns whether any
    /// changed.
    pub(super) fn settle(&self, pattern: &mut Pattern<N>) -> bool {
        let mut has_changed = false;
        for (index, row) in self.0.iter().enumerate() {
            let field = field(row, pattern);
            has_changed |= pattern.set(index, field);
        }
        has_changed
    }
}

fn strengthen<const N: usize>(row: &mut [i8; N], wanted: i8, from: &Pattern<N>) {
    for (weight, sign) in row.iter_mut().zip(from.signs()) {
        // Both are ±1. Never −128, so that a weight and its opposite saturate alike.
        *weight = weight.saturating_add(sign.wrapping_mul(wanted)).max(-127);
    }
}

fn field<const N: usize>(row: &[i8; N], input: &Pattern<N>) -> i32 {
    let products = row.iter().zip(input.signs());
    products.fold(0, |sum: i32, (weight, sign)| {
        sum.wrapping_add(i32::from(*weight).wrapping_mul(i32::from(*sign)))
    })
}
