//! The noise generator of an episode: everything random in the simulated world comes from here,
//! in the order of the calls, from one seed.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A seeded generator (xoshiro256++, Blackman and Vigna) with the draws a sensor model needs. Its
/// transcendental functions come from `libm`, so a seed gives the same bits on every machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Noise(Xoshiro256PlusPlus);

impl Noise {
    /// A generator whose whole future is fixed by `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1), a multiple of 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * STEP
    }

    /// Uniform in [`low`, `high`).
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// One of `0..count`, all equally likely; 0 when `count` is 0.
    pub fn index(&mut self, count: usize) -> usize {
        let product = u128::from(self.next_u64()) * count as u128;
        (product >> 64) as usize
    }

    /// Normal with mean 0 and standard deviation 1 (Box–Muller; two draws each, none is kept).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        radius * libm::cos(core::f64::consts::TAU * self.uniform())
    }

    /// True with the given probability: never for 0, always for 1. Draws once in either case.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seed_fixes_every_draw() {
        let draw = |seed| {
            let mut noise = Noise::new(seed);
            (noise.uniform(), noise.normal(), noise.index(16))
        };
        assert_eq!(draw(7), draw(7));
        assert_ne!(draw(7), draw(8));
    }

    #[test]
    fn draws_have_the_moments_they_promise() {
        let mut noise = Noise::new(1);
        let draws = 20_000;
        let (mut sum, mut squares, mut hits, mut highest) = (0.0, 0.0, 0, 0);
        for _ in 0..draws {
            let x = noise.normal();
            sum += x;
            squares += x * x;
            hits += u32::from(noise.chance(0.25));
            highest = highest.max(noise.index(5));
            assert!((2.0..3.0).contains(&noise.uniform_in(2.0, 3.0)));
        }
        let n = f64::from(draws);
        // Four standard errors of each estimate.
        assert!((sum / n).abs() < 4.0 / n.sqrt());
        assert!((squares / n - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
        assert!((f64::from(hits) / n - 0.25).abs() < 4.0 * (0.1875 / n).sqrt());
        assert_eq!(highest, 4);
        assert!(!noise.chance(0.0) && noise.chance(1.0));
    }
}
