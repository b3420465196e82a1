//! Which transducers to believe: a detector that looks at nothing but echoes and odometry.
//!
//! Each kind of fault has a rule that a transducer in good order breaks now and then, and one out of order nearly always:
//!
//! | fault | what speaks for it | what speaks against it |
//! |---|---|---|
//! | *dead* | it hears nothing while both its neighbors hear something near, or where the robot touches something | any echo |
//! | *stuck* | it says the same as before though the robot has moved and both its neighbors say something else | any change |
//! | *jumping* | its range changes by more than the robot has moved, which only a thing that comes into its lobe or leaves it can bring about | a change that fits |
//! | *short* | what it hears is far nearer than what both its neighbors hear | it is not |
//!
//! Each rule has a score per transducer, a one-sided cumulative sum (E. S. Page, "Continuous Inspection Schemes",
//! Biometrika 41, 1954): what speaks for the fault adds to it, what speaks against it takes away or, where a faulty one
//! could not have done it, brings it back to zero. At its limit the transducer is no longer believed
//! ([`Detector::enabled`]); when all its scores have come back to zero it is believed again.
//!
//! Such a sum counts on looks that are independent. A robot that goes to and fro sees the same again and again, so a look
//! speaks *for* a fault only where the robot has not been before: in a cell of a quarter of a meter that is new to it. What
//! speaks against it counts everywhere as long as the transducer is believed.
//! Neighbors bear witness only while they are beyond doubt themselves.
//!
//! A transducer that has never been heard may be dead from the beginning, and its silence is no proof of free room:
//! a single look between near things is enough not to believe it ([`Fault::Unheard`]), and its first echo to believe it.
//!
//! What the detector cannot tell: a dead transducer from one before which there is nothing, until the neighbors or a touch
//! disagree; ranges that are wrong by less than [`SHORT_MM`] or a fifth; two faulty neighbors; and while the ring turns
//! with the heading, *stuck* and *jumping*. How often it is wrong and how long it takes is measured in the project's
//! documentation; it is on by default.

use crate::config::Config;
use crate::fixed::{Mask, isqrt};
use crate::units::{Bearing, Displacement, Range};
use serde::{Deserialize, Serialize};

/// A look is taken after this way, millimeters.
pub const LOOK_MM: i32 = 200;
/// A change of range may exceed the way by this much, and by a 16th of the range, millimeters.
pub const LOOSE_MM: i32 = 50;
/// A range that changes by no more than this stands still, millimeters: half an inch.
pub const STILL_MM: u16 = 13;
/// A neighbor whose range changes by this much says something else, millimeters: half of [`LOOK_MM`].
pub const OTHER_MM: u16 = 100;
/// Things nearer than this weigh [`NEAR_WEIGHT`], nearer than [`MIDDLE_MM`] 1, where a transducer between them hears
/// nothing; millimeters.
pub const NEAR_MM: u16 = 1_000;
/// As above.
pub const MIDDLE_MM: u16 = 3_000;
/// As above.
pub const NEAR_WEIGHT: u8 = 4;
/// Weight of an echo of one that is not believed.
pub const ECHO_WEIGHT: u8 = 20;
/// Weight of a touch where a transducer hears nothing.
pub const TOUCH_WEIGHT: u8 = 30;
/// Weight of a look at which a range stands still.
pub const STILL_WEIGHT: u8 = 8;
/// Weights of a change of range that the way does not explain, and of one it does.
pub const JUMP_WEIGHTS: [u8; 2] = [5, 8];
/// A range is short when it is at least this much below the nearer neighbor's, millimeters, and below four fifths of it.
pub const SHORT_MM: u16 = 300;
/// Weights of a range that is short, and of one that is not.
pub const SHORT_WEIGHTS: [u8; 2] = [4, 4];
/// Score at which a transducer is no longer believed.
pub const LIMIT: u8 = 60;
/// The same for the silence of one that was never heard.
pub const UNHEARD_LIMIT: u8 = 1;
/// Score from which on a transducer does not bear witness against its neighbors.
pub const DOUBT: u8 = LIMIT / 2;

/// What is wrong with a transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// It no longer hears anything.
    Dead,
    /// It always says the same.
    Stuck,
    /// It hears things far nearer than its neighbors do.
    Short,
    /// What it says changes by more than the robot has moved.
    Jumping,
    /// It has never been heard yet: perhaps it is dead, perhaps there was nothing to be heard.
    Unheard,
}

/// What the detector has decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verdict {
    /// Transducer.
    pub sensor: u8,
    /// Why it is not believed any more; `None` = it is believed again.
    pub fault: Option<Fault>,
}

/// How near a transducer is to being disbelieved: at [`LIMIT`] it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Scores {
    /// Looks without an echo between near things.
    pub silent: u8,
    /// Looks at which its range stood still.
    pub still: u8,
    /// Changes of range that the way does not explain.
    pub jumps: u8,
    /// Ranges far below the neighbors'.
    pub short: u8,
}

/// A range with [`Said::LEAST`] added, or what is known instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Said(u16);

impl Said {
    const NOTHING_YET: Self = Self(0);
    const SILENCE: Self = Self(1);
    const LEAST: u16 = 2;

    fn new(range: Option<Range>) -> Self {
        range.map_or(Self::SILENCE, |range| {
            Self(range.as_mm().saturating_add(Self::LEAST))
        })
    }

    fn range_mm(self) -> Option<u16> {
        self.0.checked_sub(Self::LEAST)
    }

    fn is_known(self) -> bool {
        self != Self::NOTHING_YET
    }

    /// Whether the two cannot be what the same thing at the same distance is heard as.
    fn is_other_than(self, other: Self) -> bool {
        match (self.range_mm(), other.range_mm()) {
            (Some(a), Some(b)) => a.abs_diff(b) >= OTHER_MM,
            _ => self != other && self.is_known() && other.is_known(),
        }
    }
}

/// What is known of one transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Record {
    /// The latest word.
    latest: Said,
    /// The word at the last look, those of the neighbors, and the odometer there.
    looked: Said,
    sides: [Said; 2],
    x_mm: i16,
    y_mm: i16,
    scores: Scores,
}

const _: () = assert!(size_of::<Record>() <= 16);

impl Record {
    const NEW: Self = Self {
        latest: Said::NOTHING_YET,
        looked: Said::NOTHING_YET,
        sides: [Said::NOTHING_YET; 2],
        x_mm: 0,
        y_mm: 0,
        scores: Scores {
            silent: 0,
            still: 0,
            jumps: 0,
            short: 0,
        },
    };
}

/// Cells of a quarter of a meter on a torus of 4 m: where the robot has been.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Places {
    visited: [u16; 16],
    cell: (u8, u8),
    /// The robot has been in this cell before.
    is_known: bool,
}

impl Places {
    const CELL_LOG2: u32 = 8;
    /// Half of them: then all is forgotten, for the next cell may be another one 4 m away.
    const MOST: u32 = 128;

    const NEW: Self = Self {
        visited: [0; 16],
        cell: (0, 0),
        is_known: false,
    };

    fn enter(&mut self, x_mm: i16, y_mm: i16) {
        let index = |mm: i16| (mm >> Self::CELL_LOG2) as u8 & 15;
        let cell = (index(x_mm), index(y_mm));
        if cell == self.cell {
            return;
        }
        let row = |y: u8| usize::from(y & 15);
        if let Some(bits) = self.visited.get_mut(row(self.cell.1)) {
            *bits |= 1 << self.cell.0;
        }
        let count: u32 = self.visited.iter().map(|row| row.count_ones()).sum();
        if count > Self::MOST {
            self.visited = [0; 16];
        }
        let bits = self.visited.get(row(cell.1)).copied().unwrap_or(0);
        (self.cell, self.is_known) = (cell, bits >> cell.0 & 1 != 0);
    }
}

/// The detector; all zeros when new.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Detector<const SENSORS: usize> {
    records: [Record; SENSORS],
    places: Places,
    /// Way since the start in the ring's first frame, millimeters, wrapping; and how far the ring has turned.
    x_mm: i16,
    y_mm: i16,
    turned: Bearing,
    /// Transducers disabled here.
    disbelieved: u32,
    /// Who has been heard.
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
    /// Nothing heard yet, nobody under suspicion.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            records: [Record::NEW; SENSORS],
            places: Places::NEW,
            x_mm: 0,
            y_mm: 0,
            turned: Bearing::ZERO,
            disbelieved: 0,
            heard: 0,
        }
    }

    /// How near a transducer is to being disbelieved; all zeros for one that does not exist.
    #[must_use]
    pub fn scores(&self, sensor: usize) -> Scores {
        self.records
            .get(sensor)
            .map_or(Scores::default(), |record| record.scores)
    }

    /// Transducers that are used: those configured, less those disabled here.
    #[must_use]
    pub fn enabled(&self, config: &Config<SENSORS>) -> Mask {
        let disabled = if config.fault_detection {
            self.disbelieved
        } else {
            0
        };
        Mask::from_bits(config.believed.to_bits() & !disabled)
    }

    /// Enables transducers again and starts anew with them.
    pub fn trust(&mut self, sensors: Mask) {
        for (sensor, record) in self.records.iter_mut().enumerate() {
            if sensors.contains(sensor) && self.disbelieved & bit(sensor) != 0 {
                self.disbelieved &= !bit(sensor);
                self.heard &= !bit(sensor);
                *record = Record::NEW;
            }
        }
    }

    /// Takes a report of the base. Does nothing unless [`Config::fault_detection`] is set.
    pub fn moved(&mut self, config: &Config<SENSORS>, moved: Displacement, turned: Bearing) {
        if config.fault_detection {
            self.follow(moved, turned);
        }
    }

    /// Takes an echo; returns a change of what is enabled. Does nothing unless [`Config::fault_detection`] is set.
    // Not a part of every echo's stack.
    #[inline(never)]
    pub fn hear(
        &mut self,
        config: &Config<SENSORS>,
        sensor: u8,
        range: Option<Range>,
    ) -> Option<Verdict> {
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
        self.places.enter(self.x_mm, self.y_mm);
        if turned != Bearing::ZERO {
            self.turned = self.turned.plus(turned);
            // The axes have turned: what was heard before is no measure of what is heard now.
            for record in &mut self.records {
                record.looked = Said::NOTHING_YET;
            }
        }
    }

    /// A transducer that hears nothing where the robot touches something is under suspicion. `moved` is the way towards the
    /// touch. Does nothing unless [`Config::fault_detection`] is set.
    pub fn touched(&mut self, config: &Config<SENSORS>, moved: Displacement) {
        if !config.fault_detection {
            return;
        }
        const COS_34_Q14: i32 = 13_583;
        let (dx, dy) = (i32::from(moved.dx_mm), i32::from(moved.dy_mm));
        let least = i32::from(moved.length_mm()).wrapping_mul(COS_34_Q14) >> 14;
        for (record, axis) in self.records.iter_mut().zip(&config.robot.directions) {
            if record.latest == Said::SILENCE && least > 0 && axis.along(dx, dy) >= least {
                add(&mut record.scores.silent, TOUCH_WEIGHT);
            }
        }
    }

    fn judge_echo(
        &mut self,
        config: &Config<SENSORS>,
        sensor: u8,
        range: Option<Range>,
    ) -> Option<Verdict> {
        let index = usize::from(sensor);
        if index >= SENSORS.min(32) {
            return None;
        }
        let is_first = range.is_some() && self.heard & bit(index) == 0;
        let sides = self.sides(self.enabled(config), index);
        let (x_mm, y_mm, is_new) = (self.x_mm, self.y_mm, !self.places.is_known);
        let doubted = self.disbelieved & bit(index) != 0;
        let record = self.records.get_mut(index)?;
        record.latest = Said::new(range);
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

    /// The latest words of the transducers on both sides, where these are beyond doubt.
    fn sides(&self, believed: Mask, index: usize) -> [Said; 2] {
        let next = index.wrapping_add(1);
        let left = if next >= SENSORS { 0 } else { next };
        let right = index
            .checked_sub(1)
            .unwrap_or_else(|| SENSORS.wrapping_sub(1));
        [left, right].map(|side| match self.records.get(side) {
            Some(record) if believed.contains(side) && record.scores.worst() < DOUBT => {
                record.latest
            }
            _ => Said::NOTHING_YET,
        })
    }

    /// Believes or disbelieves by the scores. At most a quarter of the ring is disbelieved of those that were heard once,
    /// and half of all: with more the robot had better be looked after.
    fn judge(
        &mut self,
        config: &Config<SENSORS>,
        sensor: u8,
        before: Scores,
        now: Scores,
    ) -> Option<Verdict> {
        let index = usize::from(sensor);
        let heard = self.heard & bit(index) != 0;
        if self.disbelieved & bit(index) != 0 {
            return if now.worst() == 0 {
                self.disbelieved &= !bit(index);
                Some(Verdict {
                    sensor,
                    fault: None,
                })
            } else if !heard && before.silent < LIMIT && now.silent >= LIMIT {
                Some(Verdict {
                    sensor,
                    fault: Some(Fault::Dead),
                })
            } else {
                None
            };
        }
        let fault = now.fault(heard)?;
        let of_heard = (self.disbelieved & self.heard).count_ones() as usize;
        let of_all = self.disbelieved.count_ones() as usize;
        let room = of_all < SENSORS / 2 && (!heard || of_heard < SENSORS / 4);
        if !room || !config.believed.contains(index) {
            return None;
        }
        self.disbelieved |= bit(index);
        Some(Verdict {
            sensor,
            fault: Some(fault),
        })
    }
}

impl Scores {
    fn worst(self) -> u8 {
        self.silent.max(self.still).max(self.jumps).max(self.short)
    }

    const fn fault(self, heard: bool) -> Option<Fault> {
        if self.silent >= LIMIT {
            Some(Fault::Dead)
        } else if !heard && self.silent >= UNHEARD_LIMIT {
            Some(Fault::Unheard)
        } else if self.still >= LIMIT {
            Some(Fault::Stuck)
        } else if self.jumps >= LIMIT {
            Some(Fault::Jumping)
        } else if self.short >= LIMIT {
            Some(Fault::Short)
        } else {
            None
        }
    }
}

fn add(score: &mut u8, weight: u8) {
    *score = score.saturating_add(weight).min(LIMIT);
}

const fn take(score: &mut u8, weight: u8) {
    *score = score.saturating_sub(weight);
}

/// How a transducer is looked at.
struct Look {
    /// What the neighbors said last, where they bear witness.
    sides: [Said; 2],
    /// Way since the look before, millimeters.
    way: i32,
    /// The robot has not been here before.
    is_new: bool,
    /// The transducer is not believed at present: it takes more to be believed again than not to be doubted.
    doubted: bool,
}

impl Look {
    /// What speaks for a fault counts at new places only; so does what speaks against it while the transducer is not believed.
    fn weigh(&self, score: &mut u8, speaks_for: bool, [more, less]: [u8; 2]) {
        match (speaks_for, self.is_new) {
            (true, true) => add(score, more),
            (false, is_new) if is_new || !self.doubted => take(score, less),
            _ => {}
        }
    }
}

impl Record {
    fn look(&mut self, look: &Look) {
        let now = self.latest;
        let before = core::mem::replace(&mut self.looked, now);
        let sides_before = core::mem::replace(&mut self.sides, look.sides);
        let others = core::iter::zip(look.sides, sides_before);
        let all_other = others.fold(true, |all, (now, then)| all && now.is_other_than(then));
        let [left, right] = look.sides.map(Said::range_mm);
        self.listen(look, left.zip(right).map(|(left, right)| left.max(right)));
        let Some(now) = now.range_mm() else {
            // One that is stuck at a range is never silent.
            self.scores.still = 0;
            return;
        };
        if let Some(before) = before.range_mm() {
            self.compare(look, now, before, all_other);
        }
        if let Some((left, right)) = left.zip(right) {
            self.measure(look, now, left.min(right));
        }
    }

    /// Dead or not, where the farther of both neighbors hears something at this range.
    fn listen(&mut self, look: &Look, farther: Option<u16>) {
        let silent = &mut self.scores.silent;
        if self.latest != Said::SILENCE {
            // A dead one does not hear anything, ever.
            *silent = if look.doubted {
                silent.saturating_sub(ECHO_WEIGHT)
            } else {
                0
            };
            return;
        }
        match farther {
            Some(mm) if mm < NEAR_MM && look.is_new => add(silent, NEAR_WEIGHT),
            Some(mm) if mm < MIDDLE_MM && look.is_new => add(silent, 1),
            _ => {}
        }
    }

    /// Stuck or jumping.
    fn compare(&mut self, look: &Look, now: u16, before: u16, all_other: bool) {
        let Scores { still, jumps, .. } = &mut self.scores;
        let change = now.abs_diff(before);
        if change > STILL_MM {
            *still = if look.doubted {
                still.saturating_sub(STILL_WEIGHT)
            } else {
                0
            };
        } else if all_other && look.is_new {
            add(still, STILL_WEIGHT);
        }
        let loose = LOOSE_MM.wrapping_add(i32::from(now.max(before)) / 16);
        let fits = i32::from(change) <= look.way.wrapping_add(loose);
        look.weigh(jumps, !fits, JUMP_WEIGHTS);
    }

    /// Short, or as far as the nearer neighbor hears something.
    fn measure(&mut self, look: &Look, now: u16, nearest: u16) {
        let short = &mut self.scores.short;
        let is_below = u32::from(now) * 5 < u32::from(nearest) * 4;
        let is_short = is_below && nearest.saturating_sub(now) > SHORT_MM;
        look.weigh(short, is_short, SHORT_WEIGHTS);
    }
}

#[cfg(test)]
mod tests;
