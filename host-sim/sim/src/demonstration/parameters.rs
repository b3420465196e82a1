//! What is to be found of a goal, as real numbers, and its gradient.

use super::family::Family;
use amp::fixed::Weight;
use amp::goal::{Component, Goal};

/// Number of parameters.
pub const COUNT: usize = 50;
/// Places of the parameters in a gradient: logarithms of the weights, lower and upper bounds,
/// logarithms of the weights of progress and of the heading.
const LOW: usize = 16;
const HIGH: usize = 32;
const PROGRESS: usize = 48;
const HEADING_HOLD: usize = 49;
/// Bounds of all weights.
const WEIGHTS: (f64, f64) = (1e-3, 1e6);
/// Greatest preference of a goal file, as a share of 1.
const MAX_PREFERENCE: f64 = 0.99;

/// Costs are in units of the choice model: a difference of 1 makes a choice e times as probable.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// Weight of a squared deviation, by component.
    pub weights: [f64; 16],
    /// Least values wanted.
    pub low: [f64; 16],
    /// Greatest values wanted.
    pub high: [f64; 16],
    /// Weight of progress.
    pub progress: f64,
    /// Weight of keeping the heading.
    pub heading_hold: f64,
}

/// Derivatives by the parameters.
pub type Gradient = [f64; COUNT];

impl Parameters {
    /// What is asked of the ring by a robot that goes towards place `place` of it.
    pub fn towards(&self, place: usize) -> RingBounds {
        let turned =
            |values: &[f64; 16]| std::array::from_fn(|sensor| values[(sensor + 16 - place) % 16]);
        RingBounds {
            weights: turned(&self.weights),
            low: turned(&self.low),
            high: turned(&self.high),
        }
    }

    /// The same towards each place that a goal of this kind may look along.
    pub fn towards_all(&self, family: Family) -> Vec<RingBounds> {
        let places = 0..family.directions();
        places.map(|place| self.towards(place)).collect()
    }

    /// Derivatives of `strength` times the squared distance of the logarithms of the weights from
    /// those of `prior`, but for a common factor.
    pub fn pull_to(&self, prior: &Self, strength: f64) -> Gradient {
        let mut gradient = [0.0; COUNT];
        let distances: [f64; 16] = std::array::from_fn(|component| {
            libm::log(self.weights[component] / prior.weights[component])
        });
        let common = distances.iter().sum::<f64>() / 16.0;
        for (slope, distance) in gradient.iter_mut().zip(distances) {
            *slope = 2.0 * strength * (distance - common);
        }
        gradient
    }

    /// Adds the derivative of −`factor` times the weight of progress.
    pub fn add_progress(&self, gradient: &mut Gradient, factor: f64) {
        gradient[PROGRESS] -= factor * self.progress;
    }

    /// Adds the derivative of −`factor` times the weight of keeping the heading.
    pub fn add_heading_hold(&self, gradient: &mut Gradient, factor: f64) {
        gradient[HEADING_HOLD] -= factor * self.heading_hold;
    }

    /// Goes `step` of each parameter downhill.
    pub fn descend(&mut self, step: &Gradient) {
        let scale = |weight: &mut f64, step: f64| {
            *weight = (*weight * libm::exp(-step)).clamp(WEIGHTS.0, WEIGHTS.1);
        };
        for component in 0..16 {
            scale(&mut self.weights[component], step[component]);
            let moved = |bound: f64, step: f64| (bound - BOUND_RATE * step).clamp(0.0, 1.0);
            let low = moved(self.low[component], step[LOW + component]);
            let high = moved(self.high[component], step[HIGH + component]);
            // Bounds that have crossed meet.
            let middle = f64::midpoint(low, high);
            self.low[component] = low.min(middle);
            self.high[component] = high.max(middle);
        }
        scale(&mut self.progress, step[PROGRESS]);
        scale(&mut self.heading_hold, step[HEADING_HOLD]);
    }

    /// The goal: the greatest weight is 255, or the greatest preference just below 1. `deviation`
    /// is up to which weighted mean squared deviation it holds.
    pub fn goal(&self, family: Family, deviation: f64) -> Goal<16> {
        let progress = if family.stands { 0.0 } else { self.progress };
        let most = self.weights.iter().copied().fold(1e-9, f64::max);
        let preference = progress.max(self.heading_hold);
        let scale = (255.0 / most).min(MAX_PREFERENCE / preference);
        let q16 = |weight: f64| libm::rint(weight * scale * 65_536.0) as u16;
        Goal {
            frame: family.frame,
            progress_q16: q16(progress),
            heading_hold_q16: q16(self.heading_hold),
            cap: Weight::ONE,
            tolerance: weight_of(deviation.sqrt()),
            ..Goal::of(std::array::from_fn(|component| Component {
                low: weight_of(self.low[component]),
                high: weight_of(self.high[component]),
                weight: libm::rint(self.weights[component] * scale) as u8,
            }))
        }
    }
}

/// Rate of the bounds relative to that of the logarithms of weights.
const BOUND_RATE: f64 = 0.15;

/// Weights and bounds of the components in the order of the ring's places.
#[derive(Debug, Clone)]
pub struct RingBounds {
    weights: [f64; 16],
    low: [f64; 16],
    high: [f64; 16],
}

impl RingBounds {
    /// How far a value lies below (negative) and above an interval; zeros for an unknown one (NaN).
    fn gaps(&self, sensor: usize, value: f64) -> (f64, f64) {
        // `min` and `max` drop an operand that is not a number.
        let below = (value - self.low[sensor]).min(0.0);
        let above = (value - self.high[sensor]).max(0.0);
        (below, above)
    }

    /// Weighted sum of the squared deviations.
    pub fn cost(&self, values: &[f64; 16]) -> f64 {
        let mut sum = 0.0;
        for (sensor, value) in values.iter().enumerate() {
            let (below, above) = self.gaps(sensor, *value);
            let gap = below + above;
            sum += self.weights[sensor] * gap * gap;
        }
        sum
    }

    /// Adds `factor` times the derivatives of that cost.
    pub fn add_cost(&self, gradient: &mut RingGradient, values: &[f64; 16], factor: f64) {
        for (sensor, value) in values.iter().enumerate() {
            let (below, above) = self.gaps(sensor, *value);
            let weight = factor * self.weights[sensor];
            gradient.weights[sensor] += weight * (below + above) * (below + above);
            gradient.low[sensor] -= 2.0 * weight * below;
            gradient.high[sensor] -= 2.0 * weight * above;
        }
    }
}

/// Derivatives in the order of the ring's places.
#[derive(Debug, Clone, Default)]
pub struct RingGradient {
    weights: [f64; 16],
    low: [f64; 16],
    high: [f64; 16],
}

impl RingGradient {
    /// Adds these derivatives for a robot that goes towards place `place`.
    pub fn add_to(&self, gradient: &mut Gradient, place: usize) {
        for sensor in 0..16 {
            let component = (sensor + 16 - place) % 16;
            gradient[component] += self.weights[sensor];
            gradient[LOW + component] += self.low[sensor];
            gradient[HIGH + component] += self.high[sensor];
        }
    }
}

/// The nearest value of a situation.
pub fn weight_of(value: f64) -> Weight {
    Weight::from_num(value.clamp(0.0, 1.0))
}
