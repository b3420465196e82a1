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
        // 53 bits: signed numbers are converted faster.
        (self.0.next_u64() >> 11) as i64 as f64 * STEP
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
        self.deviate().exact()
    }

    /// The same draw, of which it may be enough to know about how much it is.
    pub fn deviate(&mut self) -> Deviate {
        Deviate {
            share: 1.0 - self.uniform(),
            turn: self.uniform(),
        }
    }

    /// True with the given probability: never for 0, always for 1. Draws once in either case.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }
}

/// A normal deviate, drawn but not worked out.
#[derive(Debug, Clone, Copy)]
pub struct Deviate {
    /// In (0, 1].
    share: f64,
    /// In [0, 1).
    turn: f64,
}

impl Deviate {
    /// How much [`Deviate::about`] may be wrong.
    pub const ERROR: f64 = 2e-3;

    /// Its value.
    pub fn exact(self) -> f64 {
        let radius = (-2.0 * libm::log(self.share)).sqrt();
        radius * libm::cos(core::f64::consts::TAU * self.turn)
    }

    /// Its value within [`Deviate::ERROR`], without logarithm and cosine.
    #[inline]
    pub fn about(self) -> f64 {
        let squared = -2.0 * about_ln(self.share);
        squared.max(0.0).sqrt() * about_cos(self.turn)
    }
}

/// ln `x` within 2e-6, for a normal `x` > 0: interpolated at the nodes of Chebyshev over one
/// octave.
#[inline]
fn about_ln(x: f64) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    let bits = x.to_bits();
    let octaves = (bits >> 52) as i64 - 1023;
    let t = f64::from_bits(bits & MANTISSA | 1.0_f64.to_bits()) - 1.5;
    let terms = [
        0.405_465_108,
        0.666_683_390,
        -0.222_232_022,
        0.098_236_101,
        -0.049_072_644,
        0.030_434_346,
        -0.017_029_611,
    ];
    octaves as f64 * core::f64::consts::LN_2 + polynomial(&terms, t)
}

/// The cosine of so many turns, from 0 to 1, within 1e-6, in the same manner.
#[inline]
fn about_cos(turns: f64) -> f64 {
    let x = turns - 0.5;
    let terms = [
        0.605_699_089,
        7.070_343_672,
        -38.051_863_008,
        59.168_846_590,
        -45.621_047_383,
        21.065_429_408,
    ];
    polynomial(&terms, x * x - 0.125)
}

/// The sum of `terms[i]`·tⁱ.
#[inline]
fn polynomial(terms: &[f64], t: f64) -> f64 {
    terms.iter().rev().fold(0.0, |sum, term| sum * t + term)
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

    #[test]
    fn about_is_near_enough() {
        let mut noise = Noise::new(2);
        let mut draws: Vec<_> = (0..200_000).map(|_| noise.deviate()).collect();
        for share in [
            1.0,
            1.0 - 1.0 / (1u64 << 53) as f64,
            1.0 / (1u64 << 53) as f64,
            0.5,
        ] {
            let turns = (0..=1_000).map(|turn| f64::from(turn) / 1_001.0);
            draws.extend(turns.map(|turn| Deviate { share, turn }));
        }
        let error = |draw: &Deviate| (draw.about() - draw.exact()).abs();
        let worst = draws.iter().map(error).fold(0.0, f64::max);
        // Half of what is allowed for, and not nothing.
        assert!((1e-7..Deviate::ERROR).contains(&worst), "{worst}");
        for draw in draws {
            assert!((about_ln(draw.share) - draw.share.ln()).abs() < 2e-6);
            let cos = (core::f64::consts::TAU * draw.turn).cos();
            assert!((about_cos(draw.turn) - cos).abs() < 1e-6);
        }
    }
}
