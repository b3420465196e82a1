//! Training: order of the samples, and updates of learning rate and radius.

use crate::neighborhood::{Neighborhood, Update};
use crate::schedule::Schedule;

/// Largest number of updates of learning rate and radius in a training.
const MAX_RENEWALS: u32 = 16_384;

/// The order in which samples are presented.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SampleOrder {
    /// As they are given, epoch by epoch.
    AsGiven,
    /// Shuffled for each epoch (Fisher and Yates).
    Shuffled,
}

/// Training parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TrainConfig {
    /// Neighborhood function.
    pub neighborhood: Neighborhood,
    /// Learning rate, 0 to 1.
    pub rate: Schedule,
    /// Radius of the neighborhood in grid steps, or the direct neighbors' share of the rate.
    pub radius: Schedule,
    /// Presentations of every sample.
    pub epochs: u32,
    /// Order of the samples.
    pub order: SampleOrder,
}

impl TrainConfig {
    pub(crate) fn is_shuffled(&self) -> bool {
        self.order == SampleOrder::Shuffled
    }

    /// The update of each presentation, for `count` samples per epoch.
    pub(crate) fn updates(&self, count: usize) -> Updates<'_> {
        let steps = (count as u64).saturating_mul(u64::from(self.epochs));
        let steps = u32::try_from(steps).unwrap_or(u32::MAX);
        Updates {
            config: self,
            count: count as u64,
            steps,
            slice: u64::from((steps / MAX_RENEWALS).max(1)),
            step: 0,
            update: Update::from_q16(self.neighborhood, 0, 0),
        }
    }
}

/// An endless iterator; see [`TrainConfig::updates`].
pub(crate) struct Updates<'a> {
    config: &'a TrainConfig,
    /// Samples of an epoch.
    count: u64,
    steps: u32,
    /// Presentations between two updates of the rates, within an epoch.
    slice: u64,
    step: u64,
    update: Update,
}

impl Iterator for Updates<'_> {
    type Item = Update;

    #[inline]
    fn next(&mut self) -> Option<Update> {
        let in_epoch = self.step.checked_rem(self.count).unwrap_or(0);
        if in_epoch.is_multiple_of(self.slice) {
            let step = u32::try_from(self.step).unwrap_or(u32::MAX);
            let rate = self.config.rate.at(step, self.steps);
            let radius = self.config.radius.at(step, self.steps);
            self.update = Update::from_q16(self.config.neighborhood, rate, radius);
        }
        self.step = self.step.saturating_add(1);
        Some(self.update)
    }
}

/// Shuffles `count` items by Fisher and Yates: `swap` exchanges two of them.
pub(crate) fn shuffle(
    count: usize,
    mut index: impl FnMut(usize) -> usize,
    mut swap: impl FnMut(usize, usize),
) {
    for last in (1..count).rev() {
        let other = index(last.saturating_add(1));
        if other < last {
            swap(other, last);
        }
    }
}
