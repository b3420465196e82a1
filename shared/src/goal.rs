//! Behaviors as goal situations: per transducer at least, at most or equal, with a weight.
//!
//! A component asks its value to lie within an interval. "Nothing near me" asks every value to be
//! at most 0; "a wall 0.6 m to my right" asks the value there to equal that of 0.6 m; "what I
//! perceived at the nest" asks every value to equal a captured one.

use crate::config::Config;
use crate::fixed::{Mask, ONE_BITS, Weight};
use crate::scan::{Encoding, Situation};
use crate::units::Range;
use serde::{Deserialize, Serialize};

mod behaviors;
mod named;
mod value_bounds;

pub use behaviors::Side;
pub use named::{MAX_NAMED_GOALS, Name, NamedGoal, NamedGoals, SaveGoalError};
pub(crate) use value_bounds::{Over, ValueBounds, cost_of};

/// Weight of progress in obstacle avoidance: the robot crosses free space but does not graze walls.
const AVOIDING_Q16: u16 = 33;
/// Weight of progress on the way to a place.
const LEADING_Q16: u16 = 164;

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

    /// All zeros, for a goal that has not been set.
    #[cfg(feature = "link")]
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
    #[must_use]
    #[inline]
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

/// Whose frame a goal's components are counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GoalFrame {
    /// The ring's: component `i` is transducer `i`.
    #[default]
    Ring,
    /// That of travel: component 0 looks along the motion, the others follow counter-clockwise.
    /// Only for symmetric rings.
    Travel,
}

/// A goal situation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(align(4))]
pub struct Goal<const SENSORS: usize> {
    /// What is asked of each value.
    #[serde(with = "crate::arrays")]
    pub components: [Component; SENSORS],
    /// Whose frame the components are counted in.
    pub frame: GoalFrame,
    /// Weight of progress: a whole step counts as much as this squared deviation, Q16 of 1 with
    /// weight 1. 0 = a place to be, where the robot may stand (look-ahead only).
    #[serde(alias = "going_q16")]
    pub progress_q16: u16,
    /// Weight of keeping the heading, likewise.
    #[serde(alias = "steady_q16")]
    pub heading_hold_q16: u16,
    /// Greatest deviation that counts for one component: a surface hidden behind a corner does not
    /// outweigh the rest.
    pub cap: Weight,
    /// The goal holds when the root of the mean squared deviation is at most this.
    pub tolerance: Weight,
}

impl<const SENSORS: usize> Goal<SENSORS> {
    /// These components in the ring's frame: a place to be.
    #[must_use]
    pub const fn of(components: [Component; SENSORS]) -> Self {
        Self {
            components,
            frame: GoalFrame::Ring,
            progress_q16: 0,
            heading_hold_q16: 0,
            cap: Weight::ONE,
            tolerance: Weight::ZERO,
        }
    }

    /// All zeros, as [`Config::zeroed`].
    #[cfg(feature = "link")]
    pub(crate) const fn zeroed() -> Self {
        Self {
            components: [Component::ZERO; SENSORS],
            frame: GoalFrame::Ring,
            progress_q16: 0,
            heading_hold_q16: 0,
            cap: Weight::ZERO,
            tolerance: Weight::ZERO,
        }
    }

    /// The paper's obstacle avoidance: no obstacle within the far limit anywhere.
    #[must_use]
    pub const fn free_of_obstacles() -> Self {
        Self {
            progress_q16: AVOIDING_Q16,
            ..Self::of([Component::at_most(Weight::ZERO); SENSORS])
        }
    }

    /// Nothing nearer than `range` anywhere.
    #[must_use]
    pub fn nothing_within(range: Range, encoding: Encoding) -> Self {
        Self {
            components: [Component::at_most(encoding.value(Some(range))); SENSORS],
            ..Self::free_of_obstacles()
        }
    }

    /// Obstacle avoidance as the configuration has it: nothing within its clearance.
    #[must_use]
    pub fn avoiding(config: &Config<SENSORS>) -> Self {
        let clearance = Range::from_mm(config.clearance_mm);
        Self::nothing_within(clearance, config.encoding)
    }

    /// On the way to a place: along the course, with this room beside the body.
    #[must_use]
    pub fn leading(config: &Config<SENSORS>, room_mm: u16) -> Self {
        let robot = &config.robot;
        let clearance_mm = robot
            .body_radius_mm
            .saturating_sub(robot.face_radius_mm)
            .saturating_add(room_mm);
        Self {
            progress_q16: LEADING_Q16,
            ..Self::nothing_within(Range::from_mm(clearance_mm), config.encoding)
        }
    }

    /// A situation perceived before.
    #[must_use]
    pub fn perceived(situation: &Situation<SENSORS>) -> Self {
        Self::place(situation.map(Component::equal))
    }

    /// Whether it is a place to be, not a way to go.
    pub(crate) fn is_place(&self) -> bool {
        self.progress_q16 == 0 && self.frame == GoalFrame::Ring
    }

    /// The same goal for these transducers only: of the others nothing was known.
    #[must_use]
    pub fn for_known(mut self, known: Mask) -> Self {
        for (sensor, component) in self.components.iter_mut().enumerate() {
            if !known.contains(sensor) {
                *component = Component::ANY;
            }
        }
        self
    }

    /// These components as a place to come back to, from behind corners as well.
    #[must_use]
    pub fn place(components: [Component; SENSORS]) -> Self {
        Self {
            // A third of the scale; a mean deviation of 0.035 is 16 cm over 4.5 m.
            cap: Weight::from_bits(ONE_BITS / 3),
            tolerance: Weight::from_bits(287),
            ..Self::of(components)
        }
    }

    /// Squared deviation of a situation from the goal, over the components of `mask`, in units of
    /// 2⁻²⁶ · weight.
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

    /// Whether every component of `mask` lies within `tolerance` of the goal.
    #[must_use]
    pub fn holds(&self, situation: &Situation<SENSORS>, mask: Mask, tolerance: Weight) -> bool {
        let mut parts = self.components.iter().zip(situation).enumerate();
        parts.all(|(index, (component, value))| {
            !mask.contains(index) || value.abs_diff(component.nearest(*value)) <= tolerance
        })
    }

    /// The wanted situation nearest to `situation`.
    #[must_use]
    #[inline(never)]
    pub fn nearest(&self, situation: &Situation<SENSORS>) -> Situation<SENSORS> {
        let mut target = *situation;
        for (value, component) in target.iter_mut().zip(&self.components) {
            *value = component.nearest(*value);
        }
        target
    }

    /// This goal in the ring's frame for a robot that goes towards place `place` of the ring.
    #[must_use]
    pub fn towards(&self, place: usize) -> Self {
        let mut components = self.components;
        components.rotate_right(place.checked_rem(SENSORS).unwrap_or(0));
        Self {
            components,
            frame: GoalFrame::Ring,
            ..*self
        }
    }

    /// What is asked of each transducer in the ring's frame by a robot that goes towards place
    /// `place` of the ring; nothing of the disabled ones.
    pub(crate) fn asked(&self, place: usize, enabled: Mask) -> impl Iterator<Item = ValueBounds> {
        (0..SENSORS).map(move |sensor| self.asked_of(sensor, place, enabled))
    }

    /// What is asked of one transducer.
    pub(crate) fn asked_of(&self, sensor: usize, place: usize, enabled: Mask) -> ValueBounds {
        if enabled.contains(sensor) {
            self.asked_of_enabled(sensor, place)
        } else {
            ValueBounds::ANYTHING
        }
    }

    fn asked_of_enabled(&self, sensor: usize, place: usize) -> ValueBounds {
        let component = sensor.wrapping_add(SENSORS.wrapping_sub(place));
        let component = component.checked_rem(SENSORS);
        component
            .and_then(|component| self.components.get(component))
            .map_or(ValueBounds::ANYTHING, ValueBounds::of)
    }

    /// Squared deviation of a situation in the ring's frame from what is
    /// [`asked`](Self::asked), in units of 2⁻²⁶ · weight; what reaches `limit` may be more.
    #[inline(never)]
    pub(crate) fn cost(
        &self,
        place: usize,
        enabled: Mask,
        situation: &Situation<SENSORS>,
        limit: i64,
    ) -> i64 {
        let cap = self.cap_bits();
        let mut total = 0_i64;
        for (sensor, value) in situation.iter().enumerate() {
            let (asked, value) = (
                self.asked_of_enabled(sensor, place),
                i32::from(value.to_bits()),
            );
            // Most values are as asked.
            if asked.holds(value) || !enabled.contains(sensor) {
                continue;
            }
            total = total.wrapping_add(asked.deviation(value, cap));
            if total >= limit {
                break;
            }
        }
        total
    }

    /// The cap in units of 2⁻¹³, not below 0.
    pub(crate) fn cap_bits(&self) -> i32 {
        i32::from(self.cap.to_bits()).max(0)
    }

    /// Whether a deviation is within the tolerance, by the bounds of the enabled transducers.
    pub(crate) fn is_met_by(
        &self,
        deviation: i64,
        asked: impl Iterator<Item = ValueBounds>,
    ) -> bool {
        let tolerance = i32::from(self.tolerance.to_bits());
        let weights: i32 = asked.map(|asked| asked.weight()).sum();
        deviation <= i64::from(weights).wrapping_mul(i64::from(tolerance * tolerance))
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
        let goal = Goal::of([
            Component::at_least(Weight::from_num(0.5)),
            Component::at_most(Weight::from_num(0.25)),
            Component::equal(Weight::from_num(0.75)),
            Component::ANY,
        ]);
        let met = weights([0.5, 0.25, 0.75, 0.9]);
        let cost_of = weights([0.25, 0.5, 0.25, 0.9]);
        assert_eq!(goal.distance(&met, Mask::ALL), 0);
        assert!(goal.holds(&met, Mask::ALL, Weight::ZERO));
        assert_eq!(goal.nearest(&cost_of), weights([0.5, 0.25, 0.75, 0.9]));
        let unit = 1_i64 << 26;
        assert_eq!(
            goal.distance(&cost_of, Mask::ALL),
            unit / 16 + unit / 16 + unit / 4
        );
        assert!(!goal.holds(&cost_of, Mask::ALL, Weight::from_num(0.4)));
        assert!(goal.holds(&cost_of, Mask::ALL, Weight::from_num(0.5)));
    }

    #[test]
    fn a_masked_transducer_does_not_count() {
        let goal = Goal::<2>::free_of_obstacles();
        let blocked = weights([0.0, 1.0]);
        assert!(!goal.holds(&blocked, Mask::ALL, Weight::ZERO));
        assert!(goal.holds(&blocked, Mask::ALL.without(1), Weight::ZERO));
        assert_eq!(goal.distance(&blocked, Mask::ALL.without(1)), 0);
    }

    #[test]
    fn deviations_are_squared_and_weighted() {
        let half = Component {
            weight: 3,
            ..Component::equal(Weight::from_bits(4_096))
        };
        assert_eq!(half.deviation(Weight::from_bits(4_096 + 7)), 3 * 49);
        assert_eq!(half.deviation(Weight::from_bits(4_096 - 7)), 3 * 49);
        // The longest way there is.
        let farthest = Component {
            low: Weight::MAX,
            high: Weight::MAX,
            weight: 255,
        };
        assert_eq!(farthest.deviation(Weight::MIN), 255 * 65_535 * 65_535);
        assert_eq!(Component::ANY.nearest(Weight::MAX), Weight::MAX);
    }

    #[test]
    fn goals_are_made_as_they_say() {
        let config = Config::recommended();
        let avoiding = Goal::avoiding(&config);
        let clear = config
            .encoding
            .value(Some(Range::from_mm(config.clearance_mm)));
        assert_eq!(avoiding.components, [Component::at_most(clear); 16]);
        assert_eq!(
            (avoiding.progress_q16, avoiding.frame),
            (33, GoalFrame::Ring)
        );
        let place = Goal::<2>::perceived(&weights([0.25, 1.0]));
        assert_eq!(place.components, weights([0.25, 1.0]).map(Component::equal));
        assert_eq!(
            (
                place.cap.to_bits(),
                place.tolerance.to_bits(),
                place.progress_q16
            ),
            (2_730, 287, 0)
        );
        assert_eq!(
            Goal {
                cap: Weight::from_bits(-5),
                ..place
            }
            .cap_bits(),
            0
        );
        assert_eq!(place.cap_bits(), 2_730);
        let travel = Goal {
            frame: GoalFrame::Travel,
            ..place
        };
        assert_eq!(
            travel.towards(1).components,
            weights([1.0, 0.25]).map(Component::equal)
        );
        assert_eq!(
            (travel.towards(1).frame, travel.towards(2)),
            (GoalFrame::Ring, place)
        );
    }

    #[test]
    fn a_goal_is_met_up_to_the_mean_square_of_its_tolerance() {
        let goal = Goal {
            tolerance: Weight::from_bits(10),
            ..Goal::of([
                Component {
                    weight: 4,
                    ..Component::equal(Weight::ZERO)
                },
                Component::ANY,
                Component::equal(Weight::ONE),
            ])
        };
        let is_met = |deviation, believed| goal.is_met_by(deviation, goal.asked(0, believed));
        assert!(is_met(500, Mask::ALL) && !is_met(501, Mask::ALL));
        // A disabled transducer has no bounds.
        let without = Mask::ALL.without(0);
        assert!(is_met(100, without) && !is_met(101, without));
    }

    #[test]
    fn a_goal_asks_nothing_of_what_was_not_known() {
        let situation = [Weight::from_bits(4_000); 16];
        let known = Mask::NONE.with(2).with(9);
        let goal = Goal::perceived(&situation).for_known(known);
        for (sensor, component) in goal.components.iter().enumerate() {
            assert_eq!(*component == Component::ANY, !known.contains(sensor));
        }
        assert_eq!(goal.components[2], Component::equal(situation[2]));
    }
}
