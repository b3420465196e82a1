//! Fault detection: disables transducers that misbehave, by echoes and odometry alone.
//!
//! Each fault has a rule that a sound transducer breaks now and then, and a faulty one nearly
//! always:
//!
//! | fault | evidence for it | evidence against it |
//! |---|---|---|
//! | *dead* | silence while both neighbors hear something near, or where the robot touches something | any echo |
//! | *stuck* | the same range after the robot has moved, while both neighbors' ranges change | any change |
//! | *jumping* | a range changes by more than the robot has moved | a change that fits |
//! | *short* | a range far below those of both neighbors | a range that is not |
//!
//! Each rule has a score per transducer, a one-sided cumulative sum (E. S. Page, "Continuous
//! Inspection Schemes", Biometrika 41, 1954). Evidence for the fault adds to it; evidence against
//! it subtracts, or clears it where a faulty transducer could not have produced it. At [`LIMIT`]
//! the transducer is disabled ([`Detector::enabled`]); when all its scores are zero it is enabled
//! again.
//!
//! Such a sum needs independent looks, and a robot that moves back and forth sees the same again. A
//! look therefore counts *for* a fault only in a cell of a quarter of a meter that is new to the
//! robot. Evidence *against* a fault counts everywhere while the transducer is enabled. Neighbors
//! count only below half of it.
//!
//! A transducer that was never heard may be dead from the start, and its silence does not prove
//! free space: one look between near surfaces disables it ([`SensorFault::Unheard`]), and its first
//! echo enables it.
//!
//! The detector cannot see: a dead transducer with nothing before it, until the neighbors or a
//! touch contradict it; ranges wrong by less than 0.3 m or a fifth; two faulty neighbors; and,
//! while the ring turns with the heading, *stuck* and *jumping*. Error rates and delays are
//! measured in the project's documentation; it is on by default.

use crate::config::Config;
use crate::fixed::{Mask, isqrt};
use crate::units::{Bearing, Displacement, Range};
use record::{Look, RangeReading, SensorRecord, add};
use visited_cells::VisitedCells;

mod record;
mod verdict;
mod visited_cells;

pub use verdict::{SensorFault, SensorVerdict};

/// Distance between two looks, millimeters.
const LOOK_MM: i32 = 200;
/// A change of range may exceed the distance moved by this much, and by a 16th of the range,
/// millimeters.
const LOOSE_MM: i32 = 50;
/// A range that changes by at most this is the same, millimeters: half an inch.
const STILL_MM: u16 = 13;
/// A neighbor's range that changes by this much has changed, millimeters: half of [`LOOK_MM`].
const OTHER_MM: u16 = 100;
/// Silence between surfaces nearer than this weighs [`NEAR_WEIGHT`], nearer than [`MIDDLE_MM`] 1;
/// millimeters.
const NEAR_MM: u16 = 1_000;
/// As above.
const MIDDLE_MM: u16 = 3_000;
/// As above.
const NEAR_WEIGHT: u8 = 4;
/// Weight of an echo of a disabled transducer.
const ECHO_WEIGHT: u8 = 20;
/// Weight of a touch in front of a silent transducer.
const TOUCH_WEIGHT: u8 = 30;
/// Weight of a look with the same range.
const STILL_WEIGHT: u8 = 8;
/// Weights of a change of range that the distance moved does not explain, and of one that it
/// explains.
const JUMP_WEIGHTS: [u8; 2] = [5, 8];
/// A range is short when it is at least this much below the nearer neighbor's, millimeters, and
/// below four fifths of it.
const SHORT_MM: u16 = 300;
/// Weights of a range that is short, and of one that is not.
const SHORT_WEIGHTS: [u8; 2] = [4, 4];
/// Score at which a transducer is disabled.
pub const LIMIT: u8 = 60;
/// The same for the silence of a transducer that was never heard.
const UNHEARD_LIMIT: u8 = 1;
/// Score from which on a transducer's readings do not count against its neighbors.
const DOUBT: u8 = LIMIT / 2;

/// The scores of a transducer; one at [`LIMIT`] disables it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Scores {
    /// Silence between near surfaces.
    pub silent: u8,
    /// The same range though the neighbors' changed.
    pub still: u8,
    /// Changes of range that the distance moved does not explain.
    pub jumps: u8,
    /// Ranges far below the neighbors'.
    pub short: u8,
}

/// The detector; all zeros when new.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Detector<const SENSORS: usize> {
    records: [SensorRecord; SENSORS],
    visited_cells: VisitedCells,
    /// Displacement since the start in the ring's first frame, millimeters, wrapping; and how far
    /// the ring has turned.
    x_mm: i16,
    y_mm: i16,
    turned: Bearing,
    /// Transducers disabled here.
    disabled: u32,
    /// Transducers that have heard something.
    heard: u32,
}

impl<const SENSORS: usize> Default for Detector<SENSORS> {
    fn default() -> Self {
        Self::new()
    }
}

const fn bit(sensor: usize) -> u32 {
    if sensor < 32 { 1 << sensor } else { 0 }
}

impl<const SENSORS: usize> Detector<SENSORS> {
    /// Nothing heard yet, all scores zero.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            records: [SensorRecord::NEW; SENSORS],
            visited_cells: VisitedCells::NEW,
            x_mm: 0,
            y_mm: 0,
            turned: Bearing::ZERO,
            disabled: 0,
            heard: 0,
        }
    }

    /// The scores of a transducer; all zeros for one that does not exist.
    #[must_use]
    pub fn scores(&self, sensor: usize) -> Scores {
        self.records
            .get(sensor)
            .map_or(Scores::default(), |record| record.scores)
    }

    /// Transducers in use: those configured, less those disabled here.
    #[must_use]
    pub fn enabled(&self, config: &Config<SENSORS>) -> Mask {
        let disabled = if config.fault_detection {
            self.disabled
        } else {
            0
        };
        Mask::from_bits(config.enabled.to_bits() & !disabled)
    }

    /// Enables transducers again and resets their scores.
    pub fn trust(&mut self, sensors: Mask) {
        for (sensor, record) in self.records.iter_mut().enumerate() {
            if sensors.contains(sensor) && self.disabled & bit(sensor) != 0 {
                self.disabled &= !bit(sensor);
                self.heard &= !bit(sensor);
                *record = SensorRecord::NEW;
            }
        }
    }

    /// Takes a report of the base. Does nothing unless [`Config::fault_detection`] is set.
    pub fn moved(&mut self, config: &Config<SENSORS>, moved: Displacement, turned: Bearing) {
        if config.fault_detection {
            self.follow(moved, turned);
        }
    }

    /// Takes an echo; returns a change of what is enabled. Does nothing unless
    /// [`Config::fault_detection`] is set.
    // Apart, so that it adds nothing to the stack of every echo.
    #[inline(never)]
    pub fn update(
        &mut self,
        config: &Config<SENSORS>,
        sensor: u8,
        range: Option<Range>,
    ) -> Option<SensorVerdict> {
        if config.fault_detection {
            self.judge_echo(config, sensor, range)
        } else {
            None
        }
    }

    fn follow(&mut self, moved: Displacement, turned: Bearing) {
        let moved = match self.turned {
            Bearing::ZERO => moved,
            turned => moved.rotated(turned.direction()),
        };
        self.x_mm = self.x_mm.wrapping_add(moved.dx_mm);
        self.y_mm = self.y_mm.wrapping_add(moved.dy_mm);
        self.visited_cells.enter(self.x_mm, self.y_mm);
        if turned != Bearing::ZERO {
            self.turned = self.turned.plus(turned);
            // The axes have turned: earlier readings are no reference any more.
            for record in &mut self.records {
                record.looked = RangeReading::UNKNOWN;
            }
        }
    }

    /// Counts a touch against the silent transducers that look there. `moved` points towards the
    /// touch. Does nothing unless [`Config::fault_detection`] is set.
    pub fn touched(&mut self, config: &Config<SENSORS>, moved: Displacement) {
        if !config.fault_detection {
            return;
        }
        const COS_34_Q14: i32 = 13_583;
        let (dx, dy) = (i32::from(moved.dx_mm), i32::from(moved.dy_mm));
        let least = i32::from(moved.length_mm()).wrapping_mul(COS_34_Q14) >> 14;
        for (record, axis) in self.records.iter_mut().zip(&config.robot.directions) {
            if record.latest == RangeReading::SILENCE && least > 0 && axis.along(dx, dy) >= least {
                add(&mut record.scores.silent, TOUCH_WEIGHT);
            }
        }
    }

    fn judge_echo(
        &mut self,
        config: &Config<SENSORS>,
        sensor: u8,
        range: Option<Range>,
    ) -> Option<SensorVerdict> {
        let index = usize::from(sensor);
        if index >= SENSORS.min(32) {
            return None;
        }
        let is_first = range.is_some() && self.heard & bit(index) == 0;
        let sides = self.sides(self.enabled(config), index);
        let (x_mm, y_mm, is_new) = (self.x_mm, self.y_mm, !self.visited_cells.is_known);
        let doubted = self.disabled & bit(index) != 0;
        let record = self.records.get_mut(index)?;
        record.latest = RangeReading::new(range);
        let dx = i32::from(x_mm.wrapping_sub(record.x_mm));
        let dy = i32::from(y_mm.wrapping_sub(record.y_mm));
        let way =
            isqrt((i64::from(dx) * i64::from(dx) + i64::from(dy) * i64::from(dy)).unsigned_abs())
                as i32;
        let before = record.scores;
        if is_first {
            self.heard |= bit(index);
            record.scores.silent = 0;
        }
        if way >= LOOK_MM || !record.looked.is_known() {
            let look = Look {
                sides,
                way,
                is_new,
                doubted,
            };
            record.look(&look);
            (record.x_mm, record.y_mm) = (x_mm, y_mm);
        }
        let now = record.scores;
        self.judge(config, sensor, before, now)
    }

    /// The latest readings of the transducers on both sides, where these are not in doubt.
    fn sides(&self, enabled: Mask, index: usize) -> [RangeReading; 2] {
        let next = index.wrapping_add(1);
        let left = if next >= SENSORS { 0 } else { next };
        let right = index
            .checked_sub(1)
            .unwrap_or_else(|| SENSORS.wrapping_sub(1));
        [left, right].map(|side| match self.records.get(side) {
            Some(record) if enabled.contains(side) && record.scores.worst() < DOUBT => {
                record.latest
            }
            _ => RangeReading::UNKNOWN,
        })
    }

    /// Enables or disables a transducer by its scores. Disabled are at most a quarter of the ring
    /// of those that were heard, and half of the ring in all: beyond that a person has to look at
    /// the robot.
    fn judge(
        &mut self,
        config: &Config<SENSORS>,
        sensor: u8,
        before: Scores,
        now: Scores,
    ) -> Option<SensorVerdict> {
        let index = usize::from(sensor);
        let heard = self.heard & bit(index) != 0;
        if self.disabled & bit(index) != 0 {
            return if now.worst() == 0 {
                self.disabled &= !bit(index);
                Some(SensorVerdict {
                    sensor,
                    fault: None,
                })
            } else if !heard && before.silent < LIMIT && now.silent >= LIMIT {
                Some(SensorVerdict {
                    sensor,
                    fault: Some(SensorFault::Dead),
                })
            } else {
                None
            };
        }
        let fault = now.fault(heard)?;
        let of_heard = (self.disabled & self.heard).count_ones() as usize;
        let of_all = self.disabled.count_ones() as usize;
        let room = of_all < SENSORS / 2 && (!heard || of_heard < SENSORS / 4);
        if !room || !config.enabled.contains(index) {
            return None;
        }
        self.disabled |= bit(index);
        Some(SensorVerdict {
            sensor,
            fault: Some(fault),
        })
    }
}

impl Scores {
    fn worst(self) -> u8 {
        self.silent.max(self.still).max(self.jumps).max(self.short)
    }

    const fn fault(self, heard: bool) -> Option<SensorFault> {
        if self.silent >= LIMIT {
            Some(SensorFault::Dead)
        } else if !heard && self.silent >= UNHEARD_LIMIT {
            Some(SensorFault::Unheard)
        } else if self.still >= LIMIT {
            Some(SensorFault::Stuck)
        } else if self.jumps >= LIMIT {
            Some(SensorFault::Jumping)
        } else if self.short >= LIMIT {
            Some(SensorFault::Short)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests;
