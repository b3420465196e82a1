//! Learns the bearings of a body's sensors from its own moves, whatever the order of their wires.
//!
//! *Rotation matching*: when the body has turned by φ on the spot, a sensor of bearing b reads what
//! the sensor of bearing b + φ read before. The dissimilarity of such readings is averaged for each
//! pair of sensors and each turn. The bearings minimize the sum over all pairs. They are known up
//! to a common turn, which straight moves give: a range shrinks when its sensor looks ahead.
//!
//! Learning of sensors' places from motor babbling: Pierce & Kuipers 1997, *Map learning with
//! uninterpreted sensors and effectors*; Stober, Fishgold & Kuipers 2009, *Sensor map discovery for
//! developing robots*. Needs a body that turns on the spot, and odometry. That may be wrong: how
//! far the base goes and turns, and which way is ahead, is learned as well where a [`Solver`] is
//! asked for that.

use crate::fixed::Mask;
use crate::units::{Bearing, Displacement, Range};
use heapless::Vec;
use micromath::F32Ext;

mod babble;
mod costs;
mod fit;
mod front;
mod full_turn;
mod slopes;
mod solver;

pub use babble::{Babble, BabbleLimits};
use fit::Fits;
pub use fit::{Geometry, KnownBearings};
use full_turn::FullTurn;
use slopes::Slopes;
pub use solver::{LearnedBody, Solver};

/// Turns are told apart in so many steps of 5.6°.
const BINS: usize = 64;
/// The second half of the turns is the first half of the pair the other way round.
const HALF_BINS: usize = BINS / 2;
/// Readings at this place that are compared with a new one: twelve rings of 16.
const READINGS: usize = 192;
/// The place is left after so much travel, millimeters.
const LEFT_MM: u32 = 20;
/// Half a turn in 1/1 024 turn.
const HALF_TURN: u16 = 512;
/// Bearings within 1° are the same heading.
const SAME_HEADING: u16 = (65_536_u32 / 360) as u16;
/// Added to a range before its logarithm is taken, millimeters: what is near differs by less.
const NEAR_MM: i32 = 300;
/// Ranges count as at most this, millimeters.
const FARTHEST_MM: u16 = 5_000;
/// A sensor whose readings vary by less than this on average is dead: 0.02 of a logarithm.
const LEAST_SPREAD: i32 = 20;

/// A reading at the present place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Reading {
    sensor: u8,
    /// Turn since the place began, 1/1 024 turn.
    turned: i16,
    value: i16,
}

impl Reading {
    fn is_silence(&self) -> bool {
        self.value >= logarithm(None)
    }
}

/// The latest range of one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Latest {
    range: Range,
    heading: Bearing,
    traveled_mm: i32,
}

/// How dissimilar the readings of two sensors are after a turn: 1 more than a running average, 1 =
/// two units of a reading. More than half of a logarithm counts as that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Dissimilarity(u8);

impl Dissimilarity {
    const NONE: Self = Self(0);
    const MOST: i32 = 254;
    /// The average takes this part of the difference to a new value.
    const PART: i32 = 15;

    /// The average; `None` before the first comparison.
    fn mean(self) -> Option<u8> {
        self.0.checked_sub(1)
    }

    fn learn(&mut self, difference: u16) {
        let new = (i32::from(difference) / 2).min(Self::MOST);
        let old = self.mean().map_or(new, i32::from);
        self.0 = (1 + old + crate::units::div_round(new - old, Self::PART)) as u8;
    }
}

/// What has been learned of a body's sensors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Calibration<const BEAMS: usize> {
    /// Of sensor i before and sensor j after a turn of bin k: `[i][j][k]`.
    dissimilarity: [[[Dissimilarity; HALF_BINS]; BEAMS]; BEAMS],
    readings: Vec<Reading, READINGS>,
    latest: [Option<Latest>; BEAMS],
    slopes: Slopes<BEAMS>,
    /// Of each sensor: mean of its readings, and mean deviation from that in sixteenths.
    means: [Option<(i32, i32)>; BEAMS],
    full_turn: FullTurn,
    fits: Fits<BEAMS>,
    heading: Bearing,
    /// Turn since the present place began, 1/65 536 turn.
    turned: i32,
    /// Sum of all displacements in the frame of the body: a base goes ahead.
    way: (i32, i32),
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
            slopes: Slopes::NEW,
            means: [None; BEAMS],
            full_turn: FullTurn::NEW,
            fits: Fits::NEW,
            heading: Bearing::ZERO,
            turned: 0,
            way: (0, 0),
            traveled_mm: 0,
            away_mm: 0,
        }
    }

    /// Forgets everything, in place: it is too large for the stack of a microcontroller.
    pub fn clear(&mut self) {
        for dissimilarity in self.dissimilarity.as_flattened_mut().as_flattened_mut() {
            *dissimilarity = Dissimilarity::NONE;
        }
        self.readings.clear();
        self.latest = [None; BEAMS];
        self.slopes.clear();
        self.means = [None; BEAMS];
        self.full_turn = FullTurn::NEW;
        self.fits = Fits::NEW;
        self.heading = Bearing::ZERO;
        self.way = (0, 0);
        (self.turned, self.traveled_mm, self.away_mm) = (0, 0, 0);
    }

    /// The body has moved and then turned, by what its base tells.
    pub fn moved(&mut self, moved: Displacement, turned: Bearing) {
        let (x, y) = (moved.dx_mm.into(), moved.dy_mm.into());
        self.heading = self.heading.plus(turned);
        self.turned = self.turned.saturating_add(turned.as_signed_turns().into());
        self.way = (self.way.0.saturating_add(x), self.way.1.saturating_add(y));
        let length_mm = i32::from(moved.length_mm());
        let is_ahead =
            i64::from(x) * i64::from(self.way.0) + i64::from(y) * i64::from(self.way.1) >= 0;
        let ahead_mm = if is_ahead { length_mm } else { -length_mm };
        self.traveled_mm = self.traveled_mm.wrapping_add(ahead_mm);
        self.away_mm = self.away_mm.saturating_add(moved.length_mm().into());
        if self.away_mm >= LEFT_MM {
            self.begin_place();
        }
    }

    /// From now on the body is at another place.
    fn begin_place(&mut self) {
        self.readings.clear();
        self.fits.begin_place();
        (self.away_mm, self.turned) = (0, 0);
    }

    /// Where the base goes ahead, in its own frame.
    fn front(&self) -> Bearing {
        let (x, y) = self.way;
        let bits = (x.unsigned_abs() | y.unsigned_abs())
            .checked_ilog2()
            .unwrap_or(0);
        let shift = bits.saturating_sub(13);
        Displacement::saturating(x >> shift, y >> shift).bearing()
    }

    /// A sensor was heard, less than `BEAMS`; `None` = no echo.
    pub fn hear(&mut self, sensor: usize, range: Option<Range>, geometry: Geometry<'_, BEAMS>) {
        if sensor >= BEAMS {
            return;
        }
        let seen = Reading {
            sensor: sensor as u8,
            turned: (self.turned >> 6) as i16,
            value: logarithm(range),
        };
        if geometry.is_known() || !self.is_silent_again(sensor, range) {
            self.note_spread(sensor, seen.value.into());
        }
        self.compare(seen, geometry);
        self.note_slope(sensor, range);
    }

    /// The used sensor that looks elsewhere than is known, or tells something else than others
    /// that see the same, if there is one; the worst first.
    #[must_use]
    pub fn misfit(&self, used: Mask) -> Option<usize> {
        self.fits.worst(used)
    }

    /// A range as the other sensors would have read it.
    #[must_use]
    pub fn corrected(&self, sensor: usize, range: Range) -> Range {
        self.fits.corrected(sensor, range)
    }

    /// Forgets what is known of a sensor: it was moved, or has failed.
    pub fn forget(&mut self, sensor: usize) {
        for (before, row) in self.dissimilarity.iter_mut().enumerate() {
            for (after, bins) in row.iter_mut().enumerate() {
                if before == sensor || after == sensor {
                    *bins = [Dissimilarity::NONE; HALF_BINS];
                }
            }
        }
        self.slopes.forget(sensor);
        if let (Some(latest), Some(mean)) =
            (self.latest.get_mut(sensor), self.means.get_mut(sensor))
        {
            (*latest, *mean) = (None, None);
        }
        self.readings
            .retain(|reading| usize::from(reading.sensor) != sensor);
        self.fits.forget(sensor);
    }

    /// Silence after silence: where a body finds its sensors it tells nothing, and would make one
    /// that hears little look dead.
    fn is_silent_again(&self, sensor: usize, range: Option<Range>) -> bool {
        range.is_none() && self.latest.get(sensor).is_some_and(Option::is_none)
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
    fn compare(&mut self, seen: Reading, geometry: Geometry<'_, BEAMS>) {
        let is_known = geometry.is_known();
        let view = geometry.bearings().map(|known| known.same_view(&seen));
        for before in &self.readings {
            let is_same = view.as_ref().and_then(|view| view.has(before));
            if is_same == Some(true) {
                self.fits.compare(before, &seen, is_known);
            }
            // Two sensors that hear nothing need not look at the same place.
            let are_silent = seen.is_silence() && before.is_silence();
            if are_silent || (is_known && is_same.is_some()) {
                continue;
            }
            let turned = seen.turned.saturating_sub(before.turned);
            let difference = (self.fits.equalized(&seen)).abs_diff(self.fits.equalized(before));
            if before.sensor == seen.sensor {
                self.full_turn.compare(turned, difference);
            } else if turned.unsigned_abs() <= HALF_TURN {
                let turn = Bearing::from_turns((turned as u16) << 6);
                let pair = (before.sensor.into(), seen.sensor.into());
                if let Some(dissimilarity) = cell(&mut self.dissimilarity, pair, turn) {
                    dissimilarity.learn(difference);
                }
            }
        }
        // A full turn ends with what was read first: that is kept.
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
        if turned.unsigned_abs() <= SAME_HEADING {
            let change_mm = i32::from(after.range.as_mm()) - i32::from(before.range.as_mm());
            self.slopes.note(sensor, ahead_mm, change_mm);
        }
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
    (F32Ext::ln(f32::from(mm) + NEAR_MM as f32) * 1_024.0) as i16
}

#[cfg(test)]
mod tests;
