//! Whether the sensors still look where they are known to look: when two look at the same thing,
//! one before and one after a turn, they read the same.

use super::{NEAR_MM, Reading};
use crate::actuation::ONE_Q12;
use crate::fixed::Mask;
use crate::units::{Bearing, Range};
use micromath::F32Ext;

/// Sensors look at the same thing within this angle: 3°.
const SAME_THING: u16 = (65_536_u32 * 3 / 360) as u16;
/// The average takes one part of so many of a new dissimilarity.
const PART: u16 = 32;
/// Comparisons after which a sensor is judged.
const ENOUGH: u8 = 64;
/// Of one place a sensor learns from so many: there is more to see in other places.
const PER_PLACE: u8 = 4;
/// The average is clearly greater than another one if it is more than twice that and this.
const CLEARLY: u16 = 100;
/// A dissimilarity counts as at most this: half of a logarithm.
const MOST: u16 = 512;
/// A gain's units per unit of a reading's logarithm.
const GAIN_UNITS: i16 = 16;
/// A gain takes one part of so many of a new excess.
const GAIN_PART: i16 = 64;
/// Largest gain: sensors differ by a third at most.
const MOST_GAIN: i16 = 4_915;
/// A gain of less than 10 % may be chance.
const LEAST_GAIN: i16 = 1_638;

/// Where the sensors are known to look, and what the base takes for a turn.
#[derive(Debug, Clone, Copy)]
pub struct KnownBearings<const BEAMS: usize> {
    /// From the body's front; `None` = not known.
    pub bearings: [Option<Bearing>; BEAMS],
    /// True turn of what the base takes for 4 096.
    pub turn_q12: u16,
}

impl<const BEAMS: usize> KnownBearings<BEAMS> {
    /// The turns at which each sensor looks where one looks now; `None` where it is not known.
    pub(super) fn same_view(&self, seen: &Reading) -> SameView<BEAMS> {
        let own = self.bearings.get(usize::from(seen.sensor));
        let own = own.copied().flatten();
        SameView {
            turns: self.bearings.map(|bearing| {
                let ahead = own?.minus(bearing?);
                Some(true_turn(seen, self.turn_q12).plus(ahead))
            }),
            turn_q12: self.turn_q12,
        }
    }
}

/// What is known of where the sensors look.
#[derive(Debug, Clone, Copy)]
pub enum Geometry<'a, const BEAMS: usize> {
    /// Nothing.
    Unknown,
    /// As far as the first moves have told: readings go on telling it, and how much more one sensor
    /// reads than another.
    Rough(&'a KnownBearings<BEAMS>),
    /// All of it: a sensor whose readings do not fit was moved, or has failed.
    Known(&'a KnownBearings<BEAMS>),
}

impl<'a, const BEAMS: usize> Geometry<'a, BEAMS> {
    /// Whether all of it is known.
    pub(super) const fn is_known(self) -> bool {
        matches!(self, Self::Known(_))
    }

    /// The bearings, as far as they are known.
    pub(super) const fn bearings(self) -> Option<&'a KnownBearings<BEAMS>> {
        match self {
            Self::Unknown => None,
            Self::Rough(bearings) | Self::Known(bearings) => Some(bearings),
        }
    }
}

/// Turn since the place began, as it was; the base tells it.
fn true_turn(reading: &Reading, turn_q12: u16) -> Bearing {
    let told = i32::from(reading.turned) << 6;
    Bearing::from_turns((told.wrapping_mul(turn_q12.into()) / i32::from(ONE_Q12)) as u16)
}

/// Who looked at a thing when.
pub(super) struct SameView<const BEAMS: usize> {
    turns: [Option<Bearing>; BEAMS],
    turn_q12: u16,
}

impl<const BEAMS: usize> SameView<BEAMS> {
    /// Whether an earlier reading is of the same thing; `None` where that is not known.
    pub(super) fn has(&self, before: &Reading) -> Option<bool> {
        let turn = self.turns.get(usize::from(before.sensor)).copied()??;
        let off = true_turn(before, self.turn_q12).minus(turn);
        Some(off.as_signed_turns().unsigned_abs() <= SAME_THING)
    }
}

/// How dissimilar the readings of one sensor and others are that see the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Fit {
    /// Average dissimilarity times [`PART`], 1 024 = 1.
    sum: u16,
    /// Comparisons so far, at most [`ENOUGH`].
    compared: u8,
    /// Of them at this place, at most [`PER_PLACE`].
    here: u8,
    /// How much more it reads than the others, as a logarithm: 16 384 = 1.
    gain: i16,
}

impl Fit {
    pub(super) const NEW: Self = Self {
        sum: 0,
        compared: 0,
        here: 0,
        gain: 0,
    };

    /// It reads more or less by `excess` than another sensor, beside what is known of both.
    fn learn(&mut self, excess: i16) {
        if self.here >= PER_PLACE {
            return;
        }
        self.here += 1;
        self.sum = self.sum - self.sum / PART + excess.unsigned_abs().min(MOST);
        self.compared = (self.compared + 1).min(ENOUGH);
    }

    fn learn_gain(&mut self, excess: i16) {
        // A larger one is of something else: an edge, a missed echo, a sensor that was moved.
        if excess.abs() <= MOST_GAIN / GAIN_UNITS {
            let gain = self.gain.saturating_add(excess * GAIN_UNITS / GAIN_PART);
            self.gain = gain.clamp(-MOST_GAIN, MOST_GAIN);
        }
    }

    /// The average, once there are enough.
    fn average(self) -> Option<u16> {
        (self.compared >= ENOUGH).then_some(self.sum / PART)
    }
}

/// How well each sensor fits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Fits<const BEAMS: usize>([Fit; BEAMS]);

impl<const BEAMS: usize> Fits<BEAMS> {
    pub(super) const NEW: Self = Self([Fit::NEW; BEAMS]);

    /// Two sensors have read the same thing: their gains, and how well each fits if it is `known`
    /// where they look.
    pub(super) fn compare(&mut self, before: &Reading, seen: &Reading, known: bool) {
        // Two that look the same way at once stand apart for that: things beside it differ.
        if before.sensor == seen.sensor || before.turned == seen.turned {
            return;
        }
        let excess = self.equalized(seen) - self.equalized(before);
        let is_heard = !seen.is_silence() && !before.is_silence();
        for (sensor, excess) in [(before.sensor, -excess), (seen.sensor, excess)] {
            if let Some(fit) = self.0.get_mut(usize::from(sensor)) {
                if known {
                    fit.learn(excess);
                }
                // Each time, also at a place that has told enough: what one gains the other
                // loses, so that chance does not shift all of them over the days.
                if is_heard {
                    fit.learn_gain(excess);
                }
            }
        }
    }

    /// The value of a reading as the other sensors would have read it.
    pub(super) fn equalized(&self, reading: &Reading) -> i16 {
        reading.value - self.of(reading.sensor.into()).gain / GAIN_UNITS
    }

    /// How many times as far a sensor reads as the others.
    pub(super) fn factor(&self, sensor: usize) -> f32 {
        let units = f32::from(1_024 * GAIN_UNITS);
        F32Ext::exp(f32::from(self.of(sensor).gain) / units)
    }

    fn of(&self, sensor: usize) -> Fit {
        self.0.get(sensor).copied().unwrap_or(Fit::NEW)
    }

    /// From now on the body is at another place.
    pub(super) fn begin_place(&mut self) {
        for fit in &mut self.0 {
            fit.here = 0;
        }
    }

    /// A range as the others would have read it; a small difference may be chance.
    pub(super) fn corrected(&self, sensor: usize, range: Range) -> Range {
        let gain = self.of(sensor).gain;
        if gain.abs() < LEAST_GAIN {
            return range;
        }
        let mm = i32::from(range.as_mm());
        let gain = i32::from(gain);
        // As far as the second power of the gain.
        let part = gain - gain * gain / (1 << 15);
        let excess_mm = (mm + NEAR_MM) * part / (1 << 14);
        Range::from_mm((mm - excess_mm).clamp(0, i32::from(u16::MAX - 1)) as u16)
    }

    pub(super) fn forget(&mut self, sensor: usize) {
        if let Some(fit) = self.0.get_mut(sensor) {
            *fit = Fit::NEW;
        }
    }

    /// The used sensor that fits worst, if it clearly fits worse than half of them.
    pub(super) fn worst(&self, used: Mask) -> Option<usize> {
        let judged = || {
            let sensors = self.0.iter().enumerate();
            let used = sensors.filter(move |(sensor, _)| used.contains(*sensor));
            used.filter_map(|(sensor, fit)| Some((fit.average()?, sensor)))
        };
        let (worst, sensor) = judged().max()?;
        let is_worse = |average: u16| worst > average.saturating_mul(2).saturating_add(CLEARLY);
        let better = judged().filter(|(average, _)| is_worse(*average)).count();
        (2 * better >= judged().count()).then_some(sensor)
    }
}

#[cfg(test)]
mod tests {
    use super::super::logarithm;
    use super::*;

    #[test]
    fn what_one_sensor_is_found_to_read_more_the_others_read_less() {
        let mut fits = Fits::<3>::NEW;
        let reading = |sensor, turned, value| Reading {
            sensor,
            turned,
            value,
        };
        for place in 0..200 {
            fits.begin_place();
            for [before, seen] in [[0, 1], [1, 2], [1, 0], [0, 1], [0, 1], [1, 2]] {
                let value = |sensor: u8| {
                    if sensor == 1 {
                        1_200
                    } else {
                        1_000 + place % 7
                    }
                };
                let before = reading(before, 0, value(before));
                fits.compare(&before, &reading(seen, 30, value(seen)), true);
            }
        }
        let gains = fits.0.map(|fit| i32::from(fit.gain));
        assert_eq!(gains.iter().sum::<i32>(), 0, "{gains:?}");
        assert!(gains[1] > 1_638, "{gains:?}");
    }

    #[test]
    fn silence_tells_nothing_of_gains() {
        let gains = |before, seen| {
            let mut fits = Fits::<2>::NEW;
            let reading = |sensor, range: Option<u16>| Reading {
                sensor,
                turned: 30 * i16::from(sensor),
                value: logarithm(range.map(Range::from_mm)),
            };
            for _ in 0..200 {
                fits.compare(&reading(0, before), &reading(1, seen), false);
            }
            fits.0.map(|fit| fit.gain)
        };
        // Nearly as far as can be heard.
        assert_eq!(gains(Some(4_500), None), [0, 0]);
        assert_eq!(gains(None, Some(4_500)), [0, 0]);
        let [less, more] = gains(Some(3_900), Some(4_500));
        assert!(less < -800 && more > 800, "{less} {more}");
    }
}
