//! Readings of infrared sensors and lasers. Any face returns light, so no echo goes astray.

use super::SonarConfig;
use crate::noise::Noise;

/// Standard deviation of a reading: the greater of a length and a share of the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Light {
    least_m: f64,
    share: f64,
}

impl Light {
    /// The noise in Webots' tables of the proximity sensors of e-puck2 and Thymio II is that of 0.2
    /// to 1.9 mm of distance.
    pub(super) const INFRARED: Self = Self {
        least_m: 0.001,
        share: 0.03,
    };

    /// Data sheet of the LDS-01: ±10 mm below 0.5 m and ±3.5 % beyond, as two standard deviations.
    pub(super) const LASER: Self = Self {
        least_m: 0.005,
        share: 0.0175,
    };

    /// The reading for an exact range, m.
    pub(super) fn reading(
        self,
        exact: Option<f64>,
        config: &SonarConfig,
        noise: &mut Noise,
    ) -> Option<f64> {
        let exact_m = exact?;
        let sigma_m = self.least_m.max(self.share * exact_m);
        let range_m = (exact_m + sigma_m * noise.normal()).max(config.min_range_m);
        (range_m <= config.max_range_m).then_some(range_m)
    }
}
