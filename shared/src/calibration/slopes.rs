//! How the sensors' ranges change along straight moves.

/// Slopes are told apart in so many steps, from −1.6 to 1.6: a range cannot change by more than the
/// travel, but a base may go farther than it thinks. What changes more belongs to another surface.
const BINS: usize = 64;
const BINS_PER_ONE: i32 = 20;
/// A range's change over less or more travel than this tells nothing, millimeters.
const TRAVEL_MM: core::ops::RangeInclusive<i32> = 30..=500;

/// For each sensor the weights of all slopes seen: change of range per travel ahead.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Slopes<const BEAMS: usize> {
    /// Sums of travel in units of 16 mm: over a longer way a range's noise matters less.
    weights: [[u16; BINS]; BEAMS],
}

impl<const BEAMS: usize> Slopes<BEAMS> {
    pub(super) const NEW: Self = Self {
        weights: [[0; BINS]; BEAMS],
    };

    /// A sensor's range changed along a straight move; negative travel is backwards.
    pub(super) fn note(&mut self, sensor: usize, ahead_mm: i32, change_mm: i32) {
        if !TRAVEL_MM.contains(&ahead_mm.abs()) {
            return;
        }
        let change_mm = change_mm.saturating_mul(ahead_mm.signum());
        let steps = change_mm
            .saturating_mul(BINS_PER_ONE)
            .div_euclid(ahead_mm.abs());
        let bin = usize::try_from(steps + BINS as i32 / 2);
        let (Some(weights), Ok(bin)) = (self.weights.get_mut(sensor), bin) else {
            return;
        };
        let Some(weight) = weights.get(bin) else {
            return;
        };
        // At most 31.
        let more = (ahead_mm.unsigned_abs() / 16) as u16;
        // What was seen long ago counts less and less, but it counts.
        if weight.checked_add(more).is_none() {
            for weight in weights.iter_mut() {
                *weight /= 2;
            }
        }
        if let Some(weight) = weights.get_mut(bin) {
            *weight += more;
        }
    }

    /// Forgets what is known of a sensor.
    pub(super) fn forget(&mut self, sensor: usize) {
        if let Some(weights) = self.weights.get_mut(sensor) {
            *weights = [0; BINS];
        }
    }

    /// Forgets everything, in place.
    pub(super) fn clear(&mut self) {
        for sensor in 0..BEAMS {
            self.forget(sensor);
        }
    }

    /// Slopes of one sensor and their weights.
    pub(super) fn of(&self, sensor: usize) -> impl Iterator<Item = (f32, f32)> {
        let weights = self.weights.get(sensor).into_iter().flatten();
        let slopes = weights.enumerate().filter(|(_, weight)| **weight > 0);
        slopes.map(|(bin, weight)| {
            let middle = bin as f32 + 0.5 - BINS as f32 / 2.0;
            (middle / BINS_PER_ONE as f32, f32::from(*weight))
        })
    }
}
