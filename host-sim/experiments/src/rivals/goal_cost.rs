//! The cost of a situation under a goal, also of one that is known only as a normal distribution.
//!
//! As the controller's planner counts it: squared deviations from the bounds of each transducer,
//! weighted, each at most that of the goal's cap. Values are at least 0.

use crate::baselines::learning::Values;
use amp::fixed::Weight;
use amp::goal::Goal;
use arena::world::Point;
use std::f64::consts::{PI, SQRT_2};

/// Standard deviations beyond which a normal variable is not looked at.
const FARTHEST: f64 = 5.0;

/// A goal as costs, for one decision.
#[derive(Debug, Clone)]
pub struct GoalCost {
    low: Values,
    high: Values,
    weight: Values,
    cap: f64,
    progress: f64,
    preferred: Point,
}

impl GoalCost {
    /// Of a goal in the frame of a robot that travels towards place `place` of the ring; it makes
    /// progress along `preferred`, a unit vector, or zero for none.
    #[must_use]
    pub fn new(goal: &Goal<16>, place: usize, preferred: Point) -> Self {
        let asked = goal.towards(place).components;
        Self {
            low: asked.map(|component| number(component.low)),
            high: asked.map(|component| number(component.high)),
            weight: asked.map(|component| f64::from(component.weight)),
            cap: number(goal.cap).max(0.0),
            progress: q16(goal.progress_q16),
            preferred,
        }
    }

    /// The cost of a situation.
    #[must_use]
    pub fn of(&self, values: &Values) -> f64 {
        let cost = |sensor: usize| {
            let value = values[sensor].max(0.0);
            let below = (self.low[sensor] - value).clamp(0.0, self.cap);
            let above = (value - self.high[sensor]).clamp(0.0, self.cap);
            self.weight[sensor] * (below * below + above * above)
        };
        (0..16).map(cost).sum()
    }

    /// The expected cost of independent normal values with these means and variances.
    #[must_use]
    pub fn expected(&self, means: &Values, variances: &Values) -> f64 {
        let cost = |sensor: usize| {
            if self.weight[sensor] == 0.0 {
                return 0.0;
            }
            let (mean, deviation) = (means[sensor], variances[sensor].max(0.0).sqrt());
            let (low, high) = (self.low[sensor], self.high[sensor]);
            // No value is below 0: it falls short of the lower bound by that bound at most.
            let below = capped_square(low - mean, deviation, self.cap.min(low));
            let above = capped_square(mean - high, deviation, self.cap);
            self.weight[sensor] * (below + above)
        };
        (0..16).map(cost).sum()
    }

    /// What a move (in units of the longest step) gains by its progress.
    #[must_use]
    pub fn progress(&self, moved: Point) -> f64 {
        self.progress * moved.dot(self.preferred)
    }
}

/// The number that a weight stands for.
pub(super) fn number(weight: Weight) -> f64 {
    f64::from(weight.to_bits()) / f64::from(amp::fixed::ONE_BITS)
}

/// The number that Q16 stands for.
pub(super) fn q16(bits: u16) -> f64 {
    f64::from(bits) / 65_536.0
}

/// Mean of min(max(u, 0), cap)² of a normal u.
fn capped_square(mean: f64, deviation: f64, cap: f64) -> f64 {
    if mean + FARTHEST * deviation <= 0.0 || cap <= 0.0 {
        return 0.0;
    }
    if deviation < 1e-9 {
        let within = mean.clamp(0.0, cap);
        return within * within;
    }
    // Share of u above `from`, and mean of u² there (0 elsewhere).
    let above = |from: f64| {
        let z = (from - mean) / deviation;
        let share = 0.5 * libm::erfc(z / SQRT_2);
        let density = libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt();
        let square =
            (mean * mean + deviation * deviation) * share + deviation * (mean + from) * density;
        (share, square)
    };
    let ((_, positive), (capped, beyond)) = (above(0.0), above(cap));
    positive - beyond + cap * cap * capped
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::config::Config;
    use amp::fixed::Mask;
    use amp::goal::{Component, Side};
    use amp::units::Range;
    use arena::noise::Noise;

    #[test]
    fn the_mean_of_a_capped_square_is_that_of_many_draws() {
        let mut noise = Noise::new(5);
        for (mean, deviation, cap) in [(0.1, 0.2, 0.3), (-0.2, 0.3, 1.0), (0.4, 0.1, 0.3)] {
            let square = |_| (mean + deviation * noise.normal()).clamp(0.0, cap).powi(2);
            let drawn = (0..200_000).map(square).sum::<f64>() / 2e5;
            let found = capped_square(mean, deviation, cap);
            // Four standard errors of squares that vary by less than 0.1.
            assert!((found - drawn).abs() < 9e-4, "{mean}: {found} {drawn}");
        }
        assert_eq!(capped_square(0.5, 0.0, 0.3), 0.3 * 0.3);
        assert_eq!(capped_square(-1.0, 0.1, 0.3), 0.0);
    }

    /// Goals without a cap: the cost is the squared deviation that `amp` computes.
    #[test]
    fn the_cost_is_that_of_the_controller() {
        let config = Config::recommended();
        let mut noise = Noise::new(6);
        let goals = [
            Goal::avoiding(&config),
            Goal::wall(Side::Right, Range::from_mm(600), &config),
            Goal::of([Component::equal(Weight::from_num(0.5)); 16]),
        ];
        for goal in goals {
            for place in [0, 5] {
                let bits: [i16; 16] = std::array::from_fn(|_| noise.index(8_193) as i16);
                let situation = bits.map(Weight::from_bits);
                let exact = goal.towards(place).distance(&situation, Mask::ALL);
                let cost = GoalCost::new(&goal, place, Point::default());
                let (values, none) = (situation.map(number), [0.0; 16]);
                let unit = f64::from(1 << 26);
                assert!((cost.of(&values) * unit - exact as f64).abs() < 1.0);
                assert!((cost.expected(&values, &none) - cost.of(&values)).abs() < 1e-9);
                assert!(cost.expected(&values, &[1e-3; 16]) > cost.of(&values));
            }
        }
    }
}
