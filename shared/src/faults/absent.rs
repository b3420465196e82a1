//! No fault detection (without the feature `faults`): every configured transducer stays enabled.

use crate::config::Config;
use crate::fixed::Mask;
use crate::units::{Bearing, Displacement, Range};

mod verdict;

pub use verdict::{SensorFault, SensorVerdict};

/// A detector that detects nothing, whatever [`Config::fault_detection`] says.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Detector<const SENSORS: usize>;

impl<const SENSORS: usize> Detector<SENSORS> {
    /// The detector.
    #[must_use]
    pub const fn new() -> Self {
        Self
    }

    /// Transducers in use: those configured.
    #[must_use]
    pub const fn enabled(&self, config: &Config<SENSORS>) -> Mask {
        config.enabled
    }

    pub(crate) const fn trust(&mut self, _: Mask) {}

    pub(crate) const fn moved(&mut self, _: &Config<SENSORS>, _: Displacement, _: Bearing) {}

    pub(crate) const fn touched(&mut self, _: &Config<SENSORS>, _: Displacement) {}

    pub(crate) const fn update(
        &mut self,
        _: &Config<SENSORS>,
        _: u8,
        _: Option<Range>,
    ) -> Option<SensorVerdict> {
        None
    }
}
