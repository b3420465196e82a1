//! The three sonar models and their parameters.

use core::f64::consts::PI;
use core::str::FromStr;

use super::inches::{M_PER_INCH, MAX_READING_IN};
use files::error::BadInput;

/// A predefined sonar model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SonarModel {
    /// Exact ranges of all transducers at once.
    #[default]
    Ideal,
    /// Readings of a Nomad 200 without faults.
    Nomad,
    /// Readings with every disturbance at once.
    Harsh,
}

impl SonarModel {
    /// The names, in the order of the variants.
    pub const NAMES: [&'static str; 3] = ["ideal", "nomad", "harsh"];

    /// Name of the model.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ideal => "ideal",
            Self::Nomad => "nomad",
            Self::Harsh => "harsh",
        }
    }

    /// Parameters of the model.
    #[must_use]
    pub fn config(self) -> SonarConfig {
        match self {
            Self::Ideal => SonarConfig::ideal(),
            Self::Nomad => SonarConfig::nomad(),
            Self::Harsh => SonarConfig::harsh(),
        }
    }
}

impl FromStr for SonarModel {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "ideal" => Ok(Self::Ideal),
            "nomad" => Ok(Self::Nomad),
            "harsh" => Ok(Self::Harsh),
            _ => Err(BadInput::unknown("sonar model", text, &Self::NAMES)),
        }
    }
}

/// Parameters of a sonar model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SonarConfig {
    /// Half the opening of cone or lobe, rad. Polaroid transducers are usually given ±15°; ±12.5°
    /// leaves no gap between 16 of them.
    pub half_angle_rad: f64,
    /// Maximum range, m: 255 in.
    pub max_range_m: f64,
    /// Largest angle of incidence at which a flat face returns an echo, rad. Smooth walls are
    /// mirrors beyond 22.5° (Webots) to 28° (ThinkingCap's Nomad).
    pub max_incidence_rad: f64,
    /// Rays in the fan over the lobe, at least 2; 31 are 1° apart.
    pub fan_rays: usize,
    /// Smallest standard deviation of a reading, m: half an inch.
    pub sigma_m: f64,
    /// Standard deviation as a share of the range: ±1 % in the Polaroid 6500 data sheet.
    pub sigma_share: f64,
    /// Probability that an echo is missed.
    pub missed: f64,
    /// Probability of a random reading, uniform from 6 to 255 in; 0.5 % in the simulator of
    /// CARMEN.
    pub random: f64,
    /// Smallest reading, m: 6 in according to the data sheet.
    pub min_range_m: f64,
    /// Blanking distance: nearer echoes are lost, m. The module's internal blanking of 2.38 ms
    /// gives 17 in.
    pub blanking_m: f64,
    /// Maximum number of reflections per ray.
    pub bounces: usize,
    /// Probability that the reverberation of an earlier ping is loud enough to be detected as an
    /// echo.
    pub crosstalk: f64,
    /// Number of round trips after which sound is too weak to be detected.
    pub reverberations: u32,
    /// Whether one random transducer is dead.
    pub one_dead: bool,
}

impl Default for SonarConfig {
    fn default() -> Self {
        Self::nomad()
    }
}

impl SonarConfig {
    /// Exact distances within ±12.5°.
    #[must_use]
    pub fn ideal() -> Self {
        Self {
            half_angle_rad: 12.5 * PI / 180.0,
            sigma_m: 0.0,
            sigma_share: 0.0,
            missed: 0.0,
            random: 0.0,
            min_range_m: 0.0,
            ..Self::nomad()
        }
    }

    /// A Nomad 200 in good order.
    #[must_use]
    pub fn nomad() -> Self {
        Self {
            half_angle_rad: 15.0 * PI / 180.0,
            max_range_m: f64::from(MAX_READING_IN) * M_PER_INCH,
            max_incidence_rad: 25.0 * PI / 180.0,
            fan_rays: 31,
            sigma_m: 0.5 * M_PER_INCH,
            sigma_share: 0.01,
            missed: 0.01,
            random: 0.005,
            min_range_m: 6.0 * M_PER_INCH,
            blanking_m: 0.0,
            bounces: 0,
            crosstalk: 0.0,
            reverberations: 6,
            one_dead: false,
        }
    }

    /// Everything that can go wrong does.
    #[must_use]
    pub fn harsh() -> Self {
        Self {
            missed: 0.05,
            blanking_m: 17.0 * M_PER_INCH,
            bounces: 1,
            crosstalk: 0.02,
            one_dead: true,
            ..Self::nomad()
        }
    }
}
