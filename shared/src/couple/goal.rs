//! What a couple of maps is asked for: intervals to reach, and intervals to keep away from.

use super::CoupleConfig;
use super::solver::KeepOff;
use crate::fixed::{Mask, ONE_BITS, Weight, isqrt};
use crate::goal::{Component, Goal};

/// What is to be avoided: situations nearer to these intervals than a distance.
///
/// Equal bounds in some components make it a ball, intervals a box with rounded edges. Components
/// of weight 0 do not count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Avoided<const VALUES: usize> {
    /// The intervals.
    pub components: [Component; VALUES],
    /// The distance to be kept from them.
    pub distance: Weight,
}

impl<const VALUES: usize> Avoided<VALUES> {
    /// How much farther than the distance a situation is, in units of 2⁻¹³; negative inside.
    #[must_use]
    pub fn clearance(&self, situation: &[Weight; VALUES]) -> i32 {
        self.away(situation)
            .saturating_sub(i32::from(self.distance.to_bits()))
    }

    /// Distance of a situation from the intervals, in units of 2⁻¹³.
    fn away(&self, situation: &[Weight; VALUES]) -> i32 {
        let pairs = self.components.iter().zip(situation);
        let squares = pairs.map(|(component, value)| component.deviation(*value));
        let squared = squares.fold(0_i64, i64::saturating_add);
        i32::try_from(isqrt(squared.unsigned_abs())).unwrap_or(i32::MAX)
    }
}

/// A goal situation and what is to be avoided on the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoupleGoal<const VALUES: usize> {
    /// The goal: its components, cap and tolerance count.
    pub goal: Goal<VALUES>,
    /// What is to be avoided.
    pub avoided: Option<Avoided<VALUES>>,
}

impl<const VALUES: usize> CoupleGoal<VALUES> {
    /// These components to be reached, and nothing to be avoided.
    #[must_use]
    pub const fn of(components: [Component; VALUES]) -> Self {
        Self {
            goal: Goal::of(components),
            avoided: None,
        }
    }

    /// Squared deviation of a situation from the goal, in units of 2⁻²⁶ · weight.
    pub(super) fn deviation(&self, situation: &[Weight; VALUES]) -> i64 {
        self.goal.cost(0, Mask::ALL, situation, i64::MAX)
    }

    pub(super) fn holds(&self, situation: &[Weight; VALUES]) -> bool {
        let bounds = self.goal.asked(0, Mask::ALL);
        self.goal.is_met_by(self.deviation(situation), bounds)
    }

    /// Whether a situation is farther from what is to be avoided than the margin.
    pub(super) fn is_clear(&self, config: &CoupleConfig, situation: &[Weight; VALUES]) -> bool {
        let margin = i32::from(config.margin.to_bits());
        let clear = |avoided: &Avoided<VALUES>| avoided.clearance(situation) > margin;
        self.avoided.as_ref().is_none_or(clear)
    }

    /// What is asked of each value on the way to a neuron: that it equals the neuron's.
    pub(super) fn at_neuron(&self, code: &[Weight; VALUES]) -> [Component; VALUES] {
        code.map(Component::equal)
    }

    /// The tangent plane at what is to be avoided: values may change along its normal as far as the
    /// distance and the margin allow.
    pub(super) fn keep_off(
        &self,
        config: &CoupleConfig,
        situation: &[Weight; VALUES],
    ) -> Option<KeepOff<VALUES>> {
        let avoided = self.avoided.as_ref()?;
        let away = i64::from(avoided.away(situation));
        let mut normal = [0_i64; VALUES];
        let pairs = avoided.components.iter().zip(situation);
        for (part, (component, value)) in normal.iter_mut().zip(pairs) {
            let nearest = component.nearest(*value);
            let gap = i64::from(value.to_bits()).wrapping_sub(i64::from(nearest.to_bits()));
            let weighted = gap.wrapping_mul(i64::from(component.weight)) << 20;
            *part = weighted.checked_div(away).unwrap_or(0);
        }
        let clearance = avoided.clearance(situation);
        let margin = i32::from(config.margin.to_bits());
        let slow = i64::from(config.slow.to_bits()).max(1);
        let one = i64::from(ONE_BITS);
        let longest = i64::from(clearance).wrapping_mul(one);
        let longest = longest.checked_div(slow).unwrap_or(one);
        Some(KeepOff {
            normal,
            // From 2⁻¹³ to 2⁻²⁰.
            least: i64::from(margin.saturating_sub(clearance)) << 7,
            // A fifth of the longest move at least, so that it can get away.
            longest: longest.clamp(one / 5, one) << 7,
        })
    }
}
