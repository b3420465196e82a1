//! Learns the bearings of a body's sensors from its own moves, whatever the order of their wires.
//!
//! *Rotation matching*: when the body has turned by φ on the spot, a sensor of bearing b reads what
//! the sensor of bearing b + φ read before. The dissimilarity of such readings is averaged for each
//! pair of sensors and each turn. The bearings minimize the sum over all pairs. They are known up
//! to a common turn, which straight moves give: a range shrinks when its sensor looks ahead.
//!
//! Learning of sensors' places from motor babbling: Pierce & Kuipers 1997, *Map learning with
//! uninterpreted sensors and effectors*; Stober, Fishgold & Kuipers 2009, *Sensor map discovery for
//! developing robots*. Needs a body that turns on the spot, and odometry.

use crate::fixed::Mask;
use crate::units::{Bearing, Displacement, Range};
use heapless::Vec;
use micromath::F32Ext;

mod babble;
mod solve;

pub use babble::{Babble, BabbleLimits};

/// Turns are told apart in so many steps of 5.6°.
const BINS: usize = 64;
/// The second half of the turns is the first half of the pair the other way round.
const HALF_BINS: usize = BINS / 2;
/// Readings at this place that are compared with a new one: twelve rings of 16.
const READINGS: usize = 192;
/// Changes of range along straight moves that are kept.
const SLOPES: usize = 512;
/// The place is left after so much travel, millimeters.
const LEFT_MM: u32 = 20;
/// A range's change over less or more travel than this tells nothing, millimeters.
const SLOPE_MM: core::ops::RangeInclusive<i32> = 30..=2_000;
/// Bearings within 1° are the same heading.
const SAME_HEADING: u16 = (65_536_u32 / 360) as u16;
/// Ranges count as at most this, millimeters.
const FARTHEST_MM: u16 = 5_000;
/// More than this counts as this: half of a logarithm.
const MAX_DISSIMILARITY: i16 = 511;
/// A sensor whose readings vary by less than this on average is dead: 0.02 of a logarithm.
const LEAST_SPREAD: i32 = 20;

/// A reading at the present place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Reading {
    sensor: u8,
    heading: Bearing,
    value: i16,
}

/// The latest range of one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Latest {
    range: Range,
    heading: Bearing,
    traveled_mm: i32,
}

/// How a sensor's range changed along a straight move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Slope {
    sensor: u8,
    /// Travel ahead, millimeters; negative backwards.
    ahead_mm: i16,
    /// Change of the range, millimeters.
    change_mm: i16,
}

/// How dissimilar the readings of two sensors are after a turn. Low 12 bits: a running average,
/// 8 = one unit of a reading. High 4 bits: the number of comparisons.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Dissimilarity(u16);

impl Dissimilarity {
    const NONE: Self = Self(0);
    /// The average forgets with this time constant.
    const MEMORY: u16 = 15;

    const fn mean(self) -> u16 {
        self.0 & 0xFFF
    }

    const fn count(self) -> u16 {
        self.0 >> 12
    }

    fn learn(&mut self, difference: i16) {
        let count = (self.count() + 1).min(Self::MEMORY);
        let (old, new) = (
            i32::from(self.mean()),
            i32::from(difference.min(MAX_DISSIMILARITY)) * 8,
        );
        let step = crate::units::div_round(new - old, count.into());
        self.0 = count << 12 | (old + step) as u16 & 0xFFF;
    }
}

/// What has been learned of a body's sensors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Calibration<const BEAMS: usize> {
    /// Of sensor i before and sensor j after a turn of bin k: `[i][j][k]`.
    dissimilarity: [[[Dissimilarity; HALF_BINS]; BEAMS]; BEAMS],
    readings: Vec<Reading, READINGS>,
    latest: [Option<Latest>; BEAMS],
    slopes: Vec<Slope, SLOPES>,
    /// Of each sensor: mean of its readings, and mean deviation from that in sixteenths.
    means: [Option<(i32, i32)>; BEAMS],
    heading: Bearing,
    traveled_mm: i32,
    /// Travel since the present place began.
    away_mm: u32,
}

impl<const BEAMS: usize> Default for Calibration<BEAMS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const BEAMS: usize> Calibration<BEAMS> {
    /// Nothing learned.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            dissimilarity: [[[Dissimilarity::NONE; HALF_BINS]; BEAMS]; BEAMS],
            readings: Vec::new(),
            latest: [None; BEAMS],
            slopes: Vec::new(),
            means: [None; BEAMS],
            heading: Bearing::ZERO,
            traveled_mm: 0,
            away_mm: 0,
        }
    }

    /// The body has moved, x ahead, and then turned.
    pub fn moved(&mut self, moved: Displacement, turned: Bearing) {
        self.heading = self.heading.plus(turned);
        self.traveled_mm = self.traveled_mm.wrapping_add(moved.dx_mm.into());
        self.away_mm = self.away_mm.saturating_add(moved.length_mm().into());
        if self.away_mm >= LEFT_MM {
            self.readings.clear();
            self.away_mm = 0;
        }
    }

    /// A sensor was heard, less than `BEAMS`; `None` = no echo.
    pub fn hear(&mut self, sensor: usize, range: Option<Range>) {
        if sensor >= BEAMS {
            return;
        }
        let seen = Reading {
            sensor: sensor as u8,
            heading: self.heading,
            value: logarithm(range),
        };
        self.note_spread(sensor, seen.value.into());
        self.compare(seen);
        self.note_slope(sensor, range);
    }

    fn note_spread(&mut self, sensor: usize, value: i32) {
        let Some(known) = self.means.get_mut(sensor) else {
            return;
        };
        let (mean, spread) = known.unwrap_or((value, 0));
        let off = value.wrapping_sub(mean);
        // A step is at least 1, so that the mean reaches a constant reading.
        let mean = mean + off / 16 + off.signum();
        let spread = spread + (off.abs() * 16 - spread) / 16;
        *known = Some((mean, spread));
    }

    /// Compares a reading with those of other sensors at this place, and keeps it.
    fn compare(&mut self, seen: Reading) {
        for before in &self.readings {
            if before.sensor != seen.sensor {
                let turn = seen.heading.minus(before.heading);
                let pair = (before.sensor.into(), seen.sensor.into());
                if let Some(dissimilarity) = cell(&mut self.dissimilarity, pair, turn) {
                    dissimilarity.learn(seen.value.abs_diff(before.value) as i16);
                }
            }
        }
        if self.readings.is_full() {
            self.readings.remove(0);
        }
        // There is room.
        let _ = self.readings.push(seen);
    }

    fn note_slope(&mut self, sensor: usize, range: Option<Range>) {
        let now = range.map(|range| Latest {
            range,
            heading: self.heading,
            traveled_mm: self.traveled_mm,
        });
        let Some(latest) = self.latest.get_mut(sensor) else {
            return;
        };
        let (Some(before), Some(after)) = (core::mem::replace(latest, now), now) else {
            return;
        };
        let turned = after.heading.minus(before.heading).as_signed_turns();
        let ahead_mm = after.traveled_mm.wrapping_sub(before.traveled_mm);
        if turned.unsigned_abs() > SAME_HEADING || !SLOPE_MM.contains(&ahead_mm.abs()) {
            return;
        }
        let change_mm = i32::from(after.range.as_mm()) - i32::from(before.range.as_mm());
        // A range cannot change by more than the travel; what does belongs to another surface.
        if change_mm.abs() > ahead_mm.abs() * 13 / 10 + 20 {
            return;
        }
        if self.slopes.is_full() {
            self.slopes.remove(0);
        }
        let _ = self.slopes.push(Slope {
            sensor: sensor as u8,
            ahead_mm: ahead_mm as i16,
            change_mm: change_mm as i16,
        });
    }

    /// Sensors whose readings vary: the others are dead or missing.
    #[must_use]
    pub fn alive(&self) -> Mask {
        let sensors = self.means.iter().enumerate();
        let alive = sensors.filter(|(_, known)| {
            known.is_some_and(|(_, spread_sixteenths)| spread_sixteenths / 16 > LEAST_SPREAD)
        });
        alive.fold(Mask::NONE, |mask, (sensor, _)| mask.with(sensor))
    }
}

/// The average of two sensors, before and after a turn.
fn cell<const BEAMS: usize>(
    dissimilarity: &mut [[[Dissimilarity; HALF_BINS]; BEAMS]; BEAMS],
    pair: (usize, usize),
    turn: Bearing,
) -> Option<&mut Dissimilarity> {
    let (before, after, bin) = place(pair, usize::from(turn.as_turns() >> 10));
    dissimilarity.get_mut(before)?.get_mut(after)?.get_mut(bin)
}

/// Where a bin of a turn is kept: a turn back is a turn on with the sensors exchanged.
const fn place((before, after): (usize, usize), bin: usize) -> (usize, usize, usize) {
    if bin < HALF_BINS {
        (before, after, bin)
    } else {
        (after, before, BINS - 1 - bin)
    }
}

/// Natural logarithm of a range and 0.3 m, 1 024 = 1. No echo is as far as can be.
fn logarithm(range: Option<Range>) -> i16 {
    let mm = range.map_or(FARTHEST_MM, |range| range.as_mm().min(FARTHEST_MM));
    (F32Ext::ln(f32::from(mm) + 300.0) * 1_024.0) as i16
}

#[cfg(test)]
mod tests;
