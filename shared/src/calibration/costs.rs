//! What bearings cost: how dissimilar readings are that they say are of the same place.

use super::{BINS, Calibration, place};
use crate::actuation::ONE_Q12;
use crate::units::Bearing;

/// Weights of a bin and its neighbors, tenths.
const SMOOTH: [u32; 5] = [2, 7, 10, 7, 2];

/// Dissimilarity of each pair of sensors, averaged over all turns.
pub(super) type Means<const BEAMS: usize> = [[u16; BEAMS]; BEAMS];

impl<const BEAMS: usize> Calibration<BEAMS> {
    /// Of one sensor and each other, averaged over all turns.
    pub(super) fn means_of(&self, before: usize) -> [u16; BEAMS] {
        let bins = || (0..BINS).map(|bin| (bin, 1));
        core::array::from_fn(|after| self.weighted((before, after), bins(), (0, 0)))
    }

    /// Mean of the bins that were compared, with weights; `start` is a sum and a weight to begin
    /// with. 16 = 1 of a dissimilarity.
    fn weighted(
        &self,
        pair: (usize, usize),
        bins: impl Iterator<Item = (usize, u32)>,
        start: (u32, u32),
    ) -> u16 {
        let (sum, weight) = bins.fold(start, |(sum, weight), (bin, share)| {
            let (before, after, bin) = place(pair, bin % BINS);
            let row = self.dissimilarity.get(before);
            let cell = row.and_then(|row| row.get(after)?.get(bin));
            cell.and_then(|cell| cell.mean())
                .map_or((sum, weight), |mean| {
                    let part = u32::from(mean).wrapping_mul(16).wrapping_mul(share);
                    (sum.wrapping_add(part), weight.wrapping_add(share))
                })
        });
        sum.checked_div(weight).unwrap_or(0) as u16
    }
}

/// Dissimilarity of two sensors' readings, less its average over all turns.
pub(super) struct Costs<'a, const BEAMS: usize> {
    pub(super) calibration: &'a Calibration<BEAMS>,
    pub(super) means: &'a Means<BEAMS>,
    /// True turn of what the base takes for 4 096.
    pub(super) turn_q12: u16,
}

impl<const BEAMS: usize> Costs<'_, BEAMS> {
    /// Of a bin, smoothed over its neighbors; a bin without comparisons costs the average.
    fn smoothed(&self, (before, after): (usize, usize), bin: usize) -> i32 {
        let mean = self.means.get(before).and_then(|row| row.get(after));
        let mean = mean.copied().unwrap_or(0);
        let bins = SMOOTH
            .into_iter()
            .enumerate()
            .map(|(offset, share)| ((bin + BINS + offset - 2) % BINS, share));
        let start = (u32::from(mean), 1);
        i32::from(self.calibration.weighted((before, after), bins, start)) - i32::from(mean)
    }

    /// Of two sensors whose bearings differ by a turn; `None` for one that the base does not reach
    /// with half a turn of its own.
    fn between(&self, pair: (usize, usize), turn: Bearing) -> Option<i32> {
        let told = i32::from(turn.as_signed_turns()) * i32::from(ONE_Q12)
            / i32::from(self.turn_q12.max(1));
        let told = i16::try_from(told).ok()?;
        // Bins have their values in their middles.
        let position = (told as u16).wrapping_sub(1 << 9);
        let (bin, within) = (usize::from(position >> 10), i32::from(position & 1_023));
        let (low, high) = (self.smoothed(pair, bin), self.smoothed(pair, bin + 1));
        Some(low + (((high - low) * within) >> 10))
    }

    /// Of a sensor with this bearing and all others that have one.
    pub(super) fn at(
        &self,
        bearings: &[Option<Bearing>; BEAMS],
        sensor: usize,
        bearing: Bearing,
    ) -> i32 {
        let others = bearings.iter().enumerate();
        let others = others.filter(|(other, _)| *other != sensor);
        others.fold(0, |sum, (other, known)| {
            // At a heading h sensor i looks along h + b_i; after a turn φ sensor j looks there if
            // b_i = b_j + φ.
            let cost = known.and_then(|known| self.between((sensor, other), bearing.minus(known)));
            sum.saturating_add(cost.unwrap_or(0))
        })
    }

    /// The cheapest of some bearings of a sensor, and its cost.
    pub(super) fn best(
        &self,
        bearings: &[Option<Bearing>; BEAMS],
        sensor: usize,
        candidates: impl Iterator<Item = Bearing>,
    ) -> (i32, Bearing) {
        let costs = candidates.map(|bearing| (self.at(bearings, sensor, bearing), bearing));
        let first = (i32::MAX, Bearing::ZERO);
        costs.fold(first, |best, one| if one.0 < best.0 { one } else { best })
    }
}
