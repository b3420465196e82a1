//! What disturbs a sonar's echo: reverberation, misses, random readings, noise, whole inches.

use super::inches::{INCHES_PER_M, whole_inches};
use super::{M_PER_INCH, MAX_READING_IN, Ring, SOUND_M_S};
use crate::noise::{Noise, NormalDeviate};

impl Ring {
    /// The echo, or a reverberation of the previous ping if that arrives earlier. Sound that is
    /// reflected between robot and surface arrives repeatedly, at multiples of the echo's time.
    pub(super) fn with_crosstalk(
        &self,
        echo: Option<f64>,
        time_s: f64,
        noise: &mut Noise,
    ) -> Option<f64> {
        let is_loud = noise.chance(self.config.crosstalk);
        let Some(earlier) = self.earlier.filter(|_| is_loud) else {
            return echo;
        };
        let elapsed_m = (time_s - earlier.time_s) * SOUND_M_S / 2.0;
        let min_range = self.config.blanking_m.max(self.config.min_range_m);
        let mut arrivals = (2..=self.config.reverberations)
            .map(|times| f64::from(times) * earlier.echo_m - elapsed_m);
        let first = arrivals.find(|&range| range >= min_range);
        match (first, echo) {
            (Some(false_echo), Some(echo)) => Some(false_echo.min(echo)),
            (Some(false_echo), None) => Some(false_echo),
            (None, echo) => echo,
        }
    }

    /// The reading for an echo: misses, random readings, noise, whole inches.
    pub(super) fn with_noise(&self, echo: Option<f64>, noise: &mut Noise) -> Option<f64> {
        let config = &self.config;
        if noise.chance(config.missed) {
            return None;
        }
        let inches = if noise.chance(config.random) {
            whole_inches(noise.uniform_in(config.min_range_m, config.max_range_m))
        } else {
            let range = echo?;
            let sigma_m = config.sigma_m.max(config.sigma_share * range);
            noisy_inches(range, sigma_m, noise.normal_deviate())
        };
        let inches = inches.max(self.min_in);
        (inches < f64::from(MAX_READING_IN)).then_some(inches * M_PER_INCH)
    }
}

/// A range plus a deviate times the standard deviation, in whole inches. Evaluates the deviate
/// exactly only if its approximation does not determine the result.
#[inline]
pub(super) fn noisy_inches(range_m: f64, sigma_m: f64, deviate: NormalDeviate) -> f64 {
    /// Margin for rounding.
    const SLACK_IN: f64 = 1e-6;
    /// An `f64` of this magnitude has no fraction, so adding it rounds to an integer.
    const ROUNDING_OFFSET: f64 = (3_u64 << 51) as f64;
    let (range_in, sigma_in) = (range_m * INCHES_PER_M, sigma_m * INCHES_PER_M);
    let approximate = range_in + deviate.approximate() * sigma_in;
    let whole = (approximate + ROUNDING_OFFSET) - ROUNDING_OFFSET;
    if (approximate - whole).abs() + NormalDeviate::MAX_ERROR * sigma_in < 0.5 - SLACK_IN {
        whole
    } else {
        whole_inches(range_m + deviate.exact() * sigma_m)
    }
}
