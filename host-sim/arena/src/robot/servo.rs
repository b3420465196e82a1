//! Position servos with limited velocity and acceleration, in discrete time steps.
//!
//! [`Ramp::approach`] computes one step of any kind. [`Ramp::stride`] computes four steps at once
//! if the servo is far from its goal or brakes towards it, as in most steps.

use super::limits::NEGLIGIBLE;
use crate::geometry::{max, min};

/// Steps of a stride: 40 ms.
pub(super) const STEPS_PER_STRIDE: usize = 4;

/// If x exceeds y² by this factor, √x exceeds y whatever the rounding.
const SQUARE_MARGIN: f64 = 1.0 + 1e-9;

/// Limits of velocity and acceleration, for steps of one length.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ramp {
    max_velocity: f64,
    /// Twice the acceleration.
    double_a: f64,
    /// Greatest change of velocity in a step, and half of it.
    max_change: f64,
    half_change: f64,
    /// Half a time step. Halving is exact, so halving a factor equals halving the product.
    half_dt: f64,
}

/// Position of a servo relative to its goal.
pub(super) trait RemainingDistance: Copy {
    /// Distance to the goal, positive while it is ahead. Advancing never increases it, even with
    /// rounding.
    fn remaining(&self) -> f64;

    /// Advances by `distance`.
    fn advance(&mut self, distance: f64);
}

/// Result of a stride: distance of each step, position and velocity at the end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ServoStride<W> {
    pub(super) distances: [f64; STEPS_PER_STRIDE],
    pub(super) end: W,
    pub(super) velocity: f64,
}

impl Ramp {
    pub(super) fn new(max_velocity: f64, a: f64, dt: f64) -> Self {
        let max_change = a * dt;
        Self {
            max_velocity,
            double_a: 2.0 * a,
            max_change,
            half_change: max_change / 2.0,
            half_dt: dt / 2.0,
        }
    }

    /// One time step towards rest at the distance `left`: returns its distance and the velocity
    /// after it.
    ///
    /// Keeps the limits and ends exactly at the goal: a step that starts on the braking curve
    /// v² = 2·a·left stays on it.
    pub(super) fn approach(&self, left: f64, velocity: f64) -> (f64, f64) {
        let sign = sign(left);
        let (left, v) = (left * sign, velocity * sign);
        if (0.0..=self.max_change).contains(&v) && left <= self.braking_distance(v) + NEGLIGIBLE {
            return (left * sign, 0.0);
        }
        let next = self.next_velocity(left, v);
        (self.distance(v, next) * sign, next * sign)
    }

    /// Computes a whole stride. `None` if one of its steps may end at the goal, reverse, or begin
    /// slowly; such steps need [`approach`](Self::approach).
    #[inline]
    pub(super) fn stride<W: RemainingDistance>(
        &self,
        position: W,
        velocity: f64,
    ) -> Option<ServoStride<W>> {
        if self.needs_no_braking(position.remaining(), velocity)
            && let Some(stride) = self.stride_without_braking(position, velocity)
        {
            return Some(stride);
        }
        self.stride_with_braking(position, velocity)
    }

    /// A stride without braking, from a velocity within the limits.
    ///
    /// The velocity never decreases and the remaining distance never increases, also with rounding.
    /// So if the last step needs no braking and does not end at the goal, the same holds for all.
    #[inline]
    fn stride_without_braking<W: RemainingDistance>(
        &self,
        mut end: W,
        mut velocity: f64,
    ) -> Option<ServoStride<W>> {
        let mut distances = [0.0; STEPS_PER_STRIDE];
        let mut last = (end.remaining(), velocity);
        for distance in &mut distances {
            last = (end.remaining(), velocity);
            velocity = self.accelerated(velocity);
            *distance = self.distance(last.1, velocity);
            end.advance(*distance);
        }
        let (left, v) = last;
        let no_braking =
            self.needs_no_braking(left, v) && left > self.braking_distance(v) + NEGLIGIBLE;
        no_braking.then_some(ServoStride {
            distances,
            end,
            velocity,
        })
    }

    /// A stride whose steps may brake but are too fast to end at the goal.
    #[inline]
    fn stride_with_braking<W: RemainingDistance>(
        &self,
        mut end: W,
        mut velocity: f64,
    ) -> Option<ServoStride<W>> {
        let mut distances = [0.0; STEPS_PER_STRIDE];
        for distance in &mut distances {
            let (left, v) = (end.remaining(), velocity);
            if !(left > 0.0 && v > self.max_change) {
                return None;
            }
            velocity = self.next_velocity(left, v);
            *distance = self.distance(v, velocity);
            end.advance(*distance);
        }
        Some(ServoStride {
            distances,
            end,
            velocity,
        })
    }

    /// Whether a step forward needs no braking: [`next_velocity`](Self::next_velocity) would return
    /// [`accelerated`](Self::accelerated).
    #[inline]
    fn needs_no_braking(&self, left: f64, v: f64) -> bool {
        let fastest = self.accelerated(v) + self.half_change;
        (0.0..=self.max_velocity).contains(&v)
            && self.braking_squared(left, v) > fastest * fastest * SQUARE_MARGIN
    }

    /// The velocity after a step without braking, from a velocity within the limits.
    #[inline]
    fn accelerated(&self, v: f64) -> f64 {
        min(v + self.max_change, self.max_velocity)
    }

    /// The velocity after a step that may brake.
    #[inline]
    fn next_velocity(&self, left: f64, v: f64) -> f64 {
        let wanted = min(
            self.braking_squared(left, v).sqrt() - self.half_change,
            self.max_velocity,
        );
        let low = v - self.max_change;
        if wanted <= low {
            low
        } else {
            core::hint::cold_path();
            min(wanted, v + self.max_change)
        }
    }

    /// Square of (the velocity from which braking ends at the goal, plus half the maximum change).
    #[inline]
    fn braking_squared(&self, left: f64, v: f64) -> f64 {
        self.half_change * self.half_change + self.double_a * max(left - v * self.half_dt, 0.0)
    }

    /// The braking distance.
    #[inline]
    fn braking_distance(&self, v: f64) -> f64 {
        v * v / self.double_a
    }

    /// The distance of a step.
    #[inline]
    fn distance(&self, v: f64, next: f64) -> f64 {
        (v + next) * self.half_dt
    }
}

/// 1 or −1: direction of the goal.
fn sign(left: f64) -> f64 {
    if left < 0.0 { -1.0 } else { 1.0 }
}

/// 1 or −1: direction of a stride, which never reverses.
pub(super) fn stride_sign(velocity: f64, left: f64) -> f64 {
    if velocity == 0.0 {
        sign(left)
    } else {
        1f64.copysign(velocity)
    }
}

/// One time step of braking: returns its distance and the velocity after it.
pub(super) fn brake(velocity: f64, a: f64, dt: f64) -> (f64, f64) {
    let max_change = a * dt;
    if velocity.abs() <= max_change {
        return (velocity * velocity.abs() / (2.0 * a), 0.0);
    }
    let next = velocity
        - if velocity > 0.0 {
            max_change
        } else {
            -max_change
        };
    ((velocity + next) / 2.0 * dt, next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// A remaining distance.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Remaining(f64);

    impl RemainingDistance for Remaining {
        fn remaining(&self) -> f64 {
            self.0
        }

        fn advance(&mut self, distance: f64) {
            self.0 -= distance;
        }
    }

    /// A step by the plain formula.
    fn reference_step(left: f64, velocity: f64, limit: f64, a: f64, dt: f64) -> (f64, f64) {
        let sign = if left < 0.0 { -1.0 } else { 1.0 };
        let (left, v) = (left * sign, velocity * sign);
        if (0.0..=a * dt).contains(&v) && left <= v * v / (2.0 * a) + NEGLIGIBLE {
            return (left * sign, 0.0);
        }
        let half = a * dt / 2.0;
        let wanted = (half * half + 2.0 * a * (left - v * dt / 2.0).max(0.0)).sqrt() - half;
        let next = wanted.min(limit).clamp(v - a * dt, v + a * dt);
        ((v + next) / 2.0 * dt * sign, next * sign)
    }

    /// Draws a distance, a velocity (zero, within or above the limit) and a limit.
    fn draw_case(noise: &mut Noise) -> (f64, f64, f64) {
        let left = noise.uniform_in(-1.0, 1.0).powi(3);
        let limit = noise.uniform_in(0.0, 0.8).powi(3);
        let velocity = noise.uniform_in(-1.0, 1.0).powi(3).clamp(-0.6, 0.6);
        let velocities = [0.0, velocity, 0.01 * velocity, limit];
        (left, velocities[noise.index(4)], limit)
    }

    #[test]
    fn approach_equals_the_plain_formula() {
        let mut noise = Noise::new(1);
        for _ in 0..200_000 {
            let (left, velocity, limit) = draw_case(&mut noise);
            let found = Ramp::new(limit, 0.762, 0.01).approach(left, velocity);
            let (distance, next) = reference_step(left, velocity, limit, 0.762, 0.01);
            assert_eq!(
                [found.0.to_bits(), found.1.to_bits()],
                [distance.to_bits(), next.to_bits()],
                "{left} {velocity} {limit}"
            );
        }
    }

    #[test]
    fn a_stride_equals_its_steps() {
        let mut noise = Noise::new(2);
        let (mut unbraked, mut braking) = (0, 0);
        for _ in 0..200_000 {
            let (left, velocity, limit) = draw_case(&mut noise);
            let ramp = Ramp::new(limit, 0.762, 0.01);
            let no_braking = ramp.needs_no_braking(left, velocity);
            let (mut end, mut next) = (Remaining(left), velocity);
            let distances = core::array::from_fn(|_| {
                let (distance, velocity) = reference_step(end.0, next, limit, 0.762, 0.01);
                end.advance(distance);
                next = velocity;
                distance
            });
            let steps = ServoStride {
                distances,
                end,
                velocity: next,
            };
            if no_braking
                && let Some(stride) = ramp.stride_without_braking(Remaining(left), velocity)
            {
                assert_eq!(stride, steps, "{left} {velocity} {limit}");
                unbraked += 1;
            }
            if let Some(stride) = ramp.stride_with_braking(Remaining(left), velocity) {
                assert_eq!(stride, steps, "{left} {velocity} {limit}");
                braking += 1;
            }
        }
        assert!(
            unbraked > 10_000 && braking > 10_000,
            "{unbraked} {braking}"
        );
    }
}
