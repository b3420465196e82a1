//! Random number generator of an episode: one seed determines all random draws of the simulated
//! world.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A seeded generator (xoshiro256++, Blackman and Vigna) with the distributions of the sensor
/// models. Transcendental functions are from `libm`, so a seed gives the same bits on every
/// machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Noise(Xoshiro256PlusPlus);

impl Noise {
    /// A generator with this seed.
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
        // The conversion of signed integers is faster.
        (self.0.next_u64() >> 11) as i64 as f64 * STEP
    }

    /// Uniform in [`low`, `high`).
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform in `0..count`; 0 if `count` is 0.
    pub fn index(&mut self, count: usize) -> usize {
        let product = u128::from(self.next_u64()) * count as u128;
        (product >> 64) as usize
    }

    /// Normal with mean 0 and standard deviation 1 (Box–Muller with two uniform draws).
    pub fn normal(&mut self) -> f64 {
        self.normal_deviate().exact()
    }

    /// As [`normal`](Self::normal), before evaluation: an approximate value may suffice.
    pub fn normal_deviate(&mut self) -> NormalDeviate {
        NormalDeviate {
            radius_draw: 1.0 - self.uniform(),
            angle_draw: self.uniform(),
        }
    }

    /// True with the given probability. Draws once, also for probabilities 0 and 1.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }
}

/// A normal deviate as its two uniform draws, not yet evaluated.
#[derive(Debug, Clone, Copy)]
pub struct NormalDeviate {
    /// In (0, 1].
    radius_draw: f64,
    /// In [0, 1).
    angle_draw: f64,
}

impl NormalDeviate {
    /// Maximum error of [`approximate`](Self::approximate).
    pub const MAX_ERROR: f64 = 2e-3;

    /// The exact value.
    pub fn exact(self) -> f64 {
        let radius = (-2.0 * libm::log(self.radius_draw)).sqrt();
        radius * libm::cos(core::f64::consts::TAU * self.angle_draw)
    }

    /// The value within [`MAX_ERROR`](Self::MAX_ERROR), by polynomials instead of logarithm and
    /// cosine.
    #[inline]
    pub fn approximate(self) -> f64 {
        let squared = -2.0 * approximate_ln(self.radius_draw);
        squared.max(0.0).sqrt() * approximate_cos(self.angle_draw)
    }
}

/// ln `x` within 2e-6, for a normal `x` > 0: interpolates at the Chebyshev nodes of one octave.
#[inline]
fn approximate_ln(x: f64) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    let bits = x.to_bits();
    let octaves = (bits >> 52) as i64 - 1023;
    let t = f64::from_bits(bits & MANTISSA | 1.0_f64.to_bits()) - 1.5;
    let coefficients = [
        0.405_465_108,
        0.666_683_390,
        -0.222_232_022,
        0.098_236_101,
        -0.049_072_644,
        0.030_434_346,
        -0.017_029_611,
    ];
    octaves as f64 * core::f64::consts::LN_2 + polynomial(&coefficients, t)
}

/// Cosine of an angle in turns, from 0 to 1, within 1e-6, by the same method.
#[inline]
fn approximate_cos(turns: f64) -> f64 {
    let x = turns - 0.5;
    let coefficients = [
        0.605_699_089,
        7.070_343_672,
        -38.051_863_008,
        59.168_846_590,
        -45.621_047_383,
        21.065_429_408,
    ];
    polynomial(&coefficients, x * x - 0.125)
}

/// The sum of `coefficients[i]`·tⁱ, by Horner's method.
#[inline]
fn polynomial(coefficients: &[f64], t: f64) -> f64 {
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * t + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seed_determines_every_draw() {
        let draw = |seed| {
            let mut noise = Noise::new(seed);
            (noise.uniform(), noise.normal(), noise.index(16))
        };
        assert_eq!(draw(7), draw(7));
        assert_ne!(draw(7), draw(8));
    }

    #[test]
    fn draws_have_the_expected_moments() {
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
    fn approximate_is_within_its_error() {
        let mut noise = Noise::new(2);
        let mut draws: Vec<_> = (0..200_000).map(|_| noise.normal_deviate()).collect();
        for radius_draw in [
            1.0,
            1.0 - 1.0 / (1u64 << 53) as f64,
            1.0 / (1u64 << 53) as f64,
            0.5,
        ] {
            let angle_draws = (0..=1_000).map(|step| f64::from(step) / 1_001.0);
            draws.extend(angle_draws.map(|angle_draw| NormalDeviate {
                radius_draw,
                angle_draw,
            }));
        }
        let error = |draw: &NormalDeviate| (draw.approximate() - draw.exact()).abs();
        let max_error = draws.iter().map(error).fold(0.0, f64::max);
        // The lower limit checks that the approximation is in use.
        assert!(
            (1e-7..NormalDeviate::MAX_ERROR).contains(&max_error),
            "{max_error}"
        );
        for draw in draws {
            assert!((approximate_ln(draw.radius_draw) - draw.radius_draw.ln()).abs() < 2e-6);
            let cos = (core::f64::consts::TAU * draw.angle_draw).cos();
            assert!((approximate_cos(draw.angle_draw) - cos).abs() < 1e-6);
        }
    }
}
