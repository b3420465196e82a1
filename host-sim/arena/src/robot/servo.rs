//! Position servos with limited velocity and acceleration, one time step at a time.
//!
//! Mostly a servo is either far from its goal, so that only its limits matter, or brakes towards
//! it. [`Ramp::stride`] takes four such steps at once; [`Ramp::approach`] takes one of any kind.

use super::limits::NEGLIGIBLE;
use crate::geometry::{max, min};

/// Steps taken at once: those of 40 ms.
pub(super) const STEPS_PER_STRIDE: usize = 4;

/// What exceeds a square by this factor has a root that is greater, whatever the rounding.
const FAR: f64 = 1.0 + 1e-9;

/// How high a velocity may get, and how fast.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ramp {
    limit: f64,
    /// Twice the acceleration.
    double_a: f64,
    /// Greatest change of velocity in a step, and half of it.
    change: f64,
    half: f64,
    /// Half a time step: half of a product is rounded as the product with the half.
    half_dt: f64,
}

/// A way along which a servo goes: positive while the goal is ahead.
pub(super) trait TravelLeft: Copy {
    /// What is left of it. It never grows by going, rounded or not.
    fn left(&self) -> f64;

    /// Goes `way` along it.
    fn go(&mut self, way: f64);
}

/// Some steps: how far each goes, where they end, and the velocity there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ServoStride<W> {
    pub(super) ways: [f64; STEPS_PER_STRIDE],
    pub(super) end: W,
    pub(super) velocity: f64,
}

impl Ramp {
    pub(super) fn new(limit: f64, a: f64, dt: f64) -> Self {
        let change = a * dt;
        Self {
            limit,
            double_a: 2.0 * a,
            change,
            half: change / 2.0,
            half_dt: dt / 2.0,
        }
    }

    /// One time step towards rest at `left`: returns how far it goes and the velocity after it.
    /// Neither the limit nor the acceleration is exceeded, and the end is met exactly: on the
    /// braking curve v² = 2·a·left each step stays on it.
    pub(super) fn approach(&self, left: f64, velocity: f64) -> (f64, f64) {
        let sign = sign(left);
        let (left, v) = (left * sign, velocity * sign);
        if (0.0..=self.change).contains(&v) && left <= self.stopping(v) + NEGLIGIBLE {
            return (left * sign, 0.0);
        }
        let next = self.by_root(left, v);
        (self.way(v, next) * sign, next * sign)
    }

    /// Takes a whole stride. `None` where one of its steps may end at the goal or turn back, or
    /// begins slow; they are to be taken one by one.
    #[inline]
    pub(super) fn stride<W: TravelLeft>(&self, way: W, velocity: f64) -> Option<ServoStride<W>> {
        if self.is_free(way.left(), velocity)
            && let Some(stride) = self.stride_freely(way, velocity)
        {
            return Some(stride);
        }
        self.stride_by_root(way, velocity)
    }

    /// A stride that only the limits govern, from a velocity within them. With every step the
    /// velocity grows and the way left shrinks, neither strictly, and what is compared of them with
    /// either; rounding keeps the order. If the last step is free and does not end at the goal,
    /// that is so of all.
    #[inline]
    fn stride_freely<W: TravelLeft>(
        &self,
        mut end: W,
        mut velocity: f64,
    ) -> Option<ServoStride<W>> {
        let mut ways = [0.0; STEPS_PER_STRIDE];
        let mut last = (end.left(), velocity);
        for way in &mut ways {
            last = (end.left(), velocity);
            velocity = self.fastest(velocity);
            *way = self.way(last.1, velocity);
            end.go(*way);
        }
        let (left, v) = last;
        let free = self.is_free(left, v) && left > self.stopping(v) + NEGLIGIBLE;
        free.then_some(ServoStride {
            ways,
            end,
            velocity,
        })
    }

    /// A stride of steps too fast to end at the goal.
    #[inline]
    fn stride_by_root<W: TravelLeft>(
        &self,
        mut end: W,
        mut velocity: f64,
    ) -> Option<ServoStride<W>> {
        let mut ways = [0.0; STEPS_PER_STRIDE];
        for way in &mut ways {
            let (left, v) = (end.left(), velocity);
            if !(left > 0.0 && v > self.change) {
                return None;
            }
            velocity = self.by_root(left, v);
            *way = self.way(v, velocity);
            end.go(*way);
        }
        Some(ServoStride {
            ways,
            end,
            velocity,
        })
    }

    /// Whether only the limits govern a step forward: [`Ramp::by_root`] would return
    /// [`Ramp::fastest`].
    #[inline]
    fn is_free(&self, left: f64, v: f64) -> bool {
        let most = self.fastest(v) + self.half;
        (0.0..=self.limit).contains(&v) && self.squared(left, v) > most * most * FAR
    }

    /// The velocity after a step that only the limits govern, from one within them.
    #[inline]
    fn fastest(&self, v: f64) -> f64 {
        min(v + self.change, self.limit)
    }

    /// The velocity after a step that may have to brake.
    #[inline]
    fn by_root(&self, left: f64, v: f64) -> f64 {
        let wanted = min(self.squared(left, v).sqrt() - self.half, self.limit);
        let low = v - self.change;
        if wanted <= low {
            low
        } else {
            core::hint::cold_path();
            min(wanted, v + self.change)
        }
    }

    /// Square of the velocity from which the rest of the way is braked, and half a step's change
    /// more.
    #[inline]
    fn squared(&self, left: f64, v: f64) -> f64 {
        self.half * self.half + self.double_a * max(left - v * self.half_dt, 0.0)
    }

    /// The way it takes to stop.
    #[inline]
    fn stopping(&self, v: f64) -> f64 {
        v * v / self.double_a
    }

    /// The way of a step.
    #[inline]
    fn way(&self, v: f64, next: f64) -> f64 {
        (v + next) * self.half_dt
    }
}

/// 1 or −1: which way a goal lies.
fn sign(left: f64) -> f64 {
    if left < 0.0 { -1.0 } else { 1.0 }
}

/// 1 or −1: the sense of a stride, which does not turn back.
pub(super) fn sense(velocity: f64, left: f64) -> f64 {
    if velocity == 0.0 {
        sign(left)
    } else {
        1f64.copysign(velocity)
    }
}

/// One time step of braking: how far it goes and the velocity after it.
pub(super) fn slow(velocity: f64, a: f64, dt: f64) -> (f64, f64) {
    let less = a * dt;
    if velocity.abs() <= less {
        return (velocity * velocity.abs() / (2.0 * a), 0.0);
    }
    let next = velocity - if velocity > 0.0 { less } else { -less };
    ((velocity + next) / 2.0 * dt, next)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;

    /// So far is left.
    #[derive(Debug, Clone, Copy, PartialEq)]
    struct Left(f64);

    impl TravelLeft for Left {
        fn left(&self) -> f64 {
            self.0
        }

        fn go(&mut self, way: f64) {
            self.0 -= way;
        }
    }

    /// A step as the formula says it.
    fn plainly(left: f64, velocity: f64, limit: f64, a: f64, dt: f64) -> (f64, f64) {
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

    /// Ways and limits of every size, at rest, within the limits and beyond.
    fn drawn(noise: &mut Noise) -> (f64, f64, f64) {
        let left = noise.uniform_in(-1.0, 1.0).powi(3);
        let limit = noise.uniform_in(0.0, 0.8).powi(3);
        let velocity = noise.uniform_in(-1.0, 1.0).powi(3).clamp(-0.6, 0.6);
        let slow = [0.0, velocity, 0.01 * velocity, limit];
        (left, slow[noise.index(4)], limit)
    }

    #[test]
    fn a_step_is_as_the_formula_says() {
        let mut noise = Noise::new(1);
        for _ in 0..200_000 {
            let (left, velocity, limit) = drawn(&mut noise);
            let found = Ramp::new(limit, 0.762, 0.01).approach(left, velocity);
            let (way, next) = plainly(left, velocity, limit, 0.762, 0.01);
            assert_eq!(
                [found.0.to_bits(), found.1.to_bits()],
                [way.to_bits(), next.to_bits()],
                "{left} {velocity} {limit}"
            );
        }
    }

    #[test]
    fn a_stride_is_its_steps() {
        let mut noise = Noise::new(2);
        let (mut freely, mut by_root) = (0, 0);
        for _ in 0..200_000 {
            let (left, velocity, limit) = drawn(&mut noise);
            let ramp = Ramp::new(limit, 0.762, 0.01);
            let free = ramp.is_free(left, velocity);
            let (mut end, mut next) = (Left(left), velocity);
            let ways = core::array::from_fn(|_| {
                let (way, faster) = plainly(end.0, next, limit, 0.762, 0.01);
                end.go(way);
                next = faster;
                way
            });
            let steps = ServoStride {
                ways,
                end,
                velocity: next,
            };
            if free && let Some(stride) = ramp.stride_freely(Left(left), velocity) {
                assert_eq!(stride, steps, "{left} {velocity} {limit}");
                freely += 1;
            }
            if let Some(stride) = ramp.stride_by_root(Left(left), velocity) {
                assert_eq!(stride, steps, "{left} {velocity} {limit}");
                by_root += 1;
            }
        }
        assert!(freely > 10_000 && by_root > 10_000, "{freely} {by_root}");
    }
}
