//! Behaviours as goal situations: per transducer at least, at most or equal, with a weight.
//!
//! A component asks its value to lie within an interval. "Nothing near me" asks every value to be at most 0; "a wall
//! 0.6 m to my right" asks the value there to equal that of 0.6 m; "what I perceived at the nest" asks every value to
//! equal a captured one.

use crate::config::Config;
use crate::fixed::{Mask, Weight};
use crate::scan::{Encoding, Situation};
use crate::units::Range;
use serde::{Deserialize, Serialize};

/// What is asked of one transducer's value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Component {
    /// Least value wanted.
    pub low: Weight,
    /// Greatest value wanted; not below `low`.
    pub high: Weight,
    /// How much a deviation counts; 0 = not at all.
    pub weight: u8,
}

impl Component {
    /// Any value will do.
    pub const ANY: Self = Self {
        low: Weight::ZERO,
        high: Weight::ONE,
        weight: 0,
    };

    /// All zeros, in a goal that nobody has set.
    pub(crate) const ZERO: Self = Self {
        low: Weight::ZERO,
        high: Weight::ZERO,
        weight: 0,
    };

    /// At least `value`: something as near as that.
    #[must_use]
    pub const fn at_least(value: Weight) -> Self {
        Self {
            low: value,
            high: Weight::ONE,
            weight: 1,
        }
    }

    /// At most `value`: nothing nearer than that.
    #[must_use]
    pub const fn at_most(value: Weight) -> Self {
        Self {
            low: Weight::ZERO,
            high: value,
            weight: 1,
        }
    }

    /// Just `value`.
    #[must_use]
    pub const fn equal(value: Weight) -> Self {
        Self {
            low: value,
            high: value,
            weight: 1,
        }
    }

    /// Squared deviation of a value from what is asked, in units of 2⁻²⁶ · weight.
    #[inline]
    #[must_use]
    pub fn deviation(self, value: Weight) -> i64 {
        // 17 bits, with the weight 25: products are widened as late as possible.
        let nearest = value.max(self.low).min(self.high);
        let gap = i32::from(value.to_bits()) - i32::from(nearest.to_bits());
        i64::from(gap) * i64::from(gap * i32::from(self.weight))
    }

    /// The value nearest to `value` that is wanted; `value` itself where any will do.
    #[must_use]
    pub fn nearest(self, value: Weight) -> Weight {
        if self.weight == 0 {
            value
        } else {
            value.max(self.low).min(self.high)
        }
    }
}

/// A goal situation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Goal<const SENSORS: usize> {
    /// What is asked of each transducer's value.
    #[serde(with = "crate::arrays")]
    pub components: [Component; SENSORS],
}

impl<const SENSORS: usize> Goal<SENSORS> {
    /// The paper's obstacle avoidance: no obstacle within the far limit anywhere.
    #[must_use]
    pub const fn free_of_obstacles() -> Self {
        Self {
            components: [Component::at_most(Weight::ZERO); SENSORS],
        }
    }

    /// Nothing nearer than `range` anywhere.
    #[must_use]
    pub fn nothing_within(range: Range, encoding: Encoding) -> Self {
        Self {
            components: [Component::at_most(encoding.value(Some(range))); SENSORS],
        }
    }

    /// Obstacle avoidance as the configuration has it: nothing within its clearance.
    #[must_use]
    pub fn avoiding(config: &Config<SENSORS>) -> Self {
        let clearance = Range::from_mm(config.clearance_mm);
        Self::nothing_within(clearance, config.encoding)
    }

    /// A situation perceived before.
    #[must_use]
    pub fn perceived(situation: &Situation<SENSORS>) -> Self {
        Self {
            components: situation.map(Component::equal),
        }
    }

    /// Squared deviation of a situation from what is asked, over the believed components, in units of 2⁻²⁶ · weight.
    #[must_use]
    pub fn distance(&self, situation: &Situation<SENSORS>, mask: Mask) -> i64 {
        let mut total = 0_i64;
        for (index, (component, value)) in self.components.iter().zip(situation).enumerate() {
            if mask.contains(index) {
                // Of 2⁴⁰ at most.
                total = total.wrapping_add(component.deviation(*value));
            }
        }
        total
    }

    /// Whether every believed component lies within `tolerance` of what is asked.
    #[must_use]
    pub fn holds(&self, situation: &Situation<SENSORS>, mask: Mask, tolerance: Weight) -> bool {
        let mut parts = self.components.iter().zip(situation).enumerate();
        parts.all(|(index, (component, value))| {
            !mask.contains(index) || value.abs_diff(component.nearest(*value)) <= tolerance
        })
    }

    /// The wanted situation nearest to `situation`.
    #[must_use]
    pub fn nearest(&self, situation: &Situation<SENSORS>) -> Situation<SENSORS> {
        let mut target = *situation;
        for (value, component) in target.iter_mut().zip(&self.components) {
            *value = component.nearest(*value);
        }
        target
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights<const N: usize>(values: [f64; N]) -> [Weight; N] {
        values.map(Weight::from_num)
    }

    #[test]
    fn intervals_ask_for_what_they_say() {
        let goal = Goal {
            components: [
                Component::at_least(Weight::from_num(0.5)),
                Component::at_most(Weight::from_num(0.25)),
                Component::equal(Weight::from_num(0.75)),
                Component::ANY,
            ],
        };
        let met = weights([0.5, 0.25, 0.75, 0.9]);
        let missed = weights([0.25, 0.5, 0.25, 0.9]);
        assert_eq!(goal.distance(&met, Mask::ALL), 0);
        assert!(goal.holds(&met, Mask::ALL, Weight::ZERO));
        assert_eq!(goal.nearest(&missed), weights([0.5, 0.25, 0.75, 0.9]));
        let unit = 1_i64 << 26;
        assert_eq!(
            goal.distance(&missed, Mask::ALL),
            unit / 16 + unit / 16 + unit / 4
        );
        assert!(!goal.holds(&missed, Mask::ALL, Weight::from_num(0.4)));
        assert!(goal.holds(&missed, Mask::ALL, Weight::from_num(0.5)));
    }

    #[test]
    fn a_masked_transducer_does_not_count() {
        let goal = Goal::<2>::free_of_obstacles();
        let blocked = weights([0.0, 1.0]);
        assert!(!goal.holds(&blocked, Mask::ALL, Weight::ZERO));
        assert!(goal.holds(&blocked, Mask::ALL.without(1), Weight::ZERO));
        assert_eq!(goal.distance(&blocked, Mask::ALL.without(1)), 0);
    }
}
