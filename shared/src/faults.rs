//! Which transducers to believe: a detector that looks at nothing but echoes and odometry.
//!
//! A transducer in good order obeys three rules, each often enough to be told from one that does not:
//!
//! * it hears something now and then while both its neighbours do (a *dead* one never does);
//! * a move along its axis changes its range by that much, unless something else has come into its lobe, and a move across
//!   it that brings its neighbours before other things does so with it, too (the range of a *stuck* one never changes, that
//!   of a *jumping* one or one on a wrong scale by something else);
//! * it does not go on hearing things far nearer than both its neighbours (a *short* one does).
//!
//! Each rule has a score per transducer, a one-sided cumulative sum (E. S. Page, "Continuous Inspection Schemes",
//! Biometrika 41, 1954): what breaks the rule adds to it, what keeps it takes away, never below zero. At its limit the
//! transducer is no longer believed ([`Config::believed`]); when all its scores have come back to zero it is believed again.
//! A look is taken only after the robot has moved, so standing anywhere proves nothing.
//!
//! The second rule is that of sound, which a smooth wall answers near its normal only. It does not hold for a sensor that
//! sees walls at a grazing angle: along such a wall the range at the cone's edge hardly changes. How often the detector is
//! wrong is measured in the project's documentation; it is off unless asked for.
//!
//! What it cannot tell: ranges that are wrong by less than [`LOOSE_MM`] or a fifth; two faulty neighbours from a strange
//! place; and while the ring turns with the heading, what breaks the second rule.

use crate::config::Config;
use crate::controller::Event;
use crate::fixed::Mask;
use crate::units::{Bearing, Displacement, Range};
use serde::{Deserialize, Serialize};

/// A look is taken after this way along the axis or across it, millimetres.
pub const LOOK_MM: i32 = 200;
/// A change of range may miss the way by this much, and by a 32nd of the range, millimetres.
pub const LOOSE_MM: i32 = 50;
/// A range that changes by no more than this stands still, millimetres: half an inch.
pub const STILL_MM: i32 = 13;
/// Things nearer than this weigh [`NEAR_WEIGHT`], nearer than [`MIDDLE_MM`] 1, where a transducer between them hears
/// nothing; millimetres.
pub const NEAR_MM: i32 = 1_000;
/// As above.
pub const MIDDLE_MM: i32 = 3_000;
/// As above.
pub const NEAR_WEIGHT: u8 = 4;
/// Weight of a change of range that fits the way, or does not.
pub const FIT_WEIGHT: u8 = 3;
/// Sum of the neighbours' changes from which on they have something else before them, millimetres.
pub const OTHER_MM: i32 = 150;
/// A range is short when it is at least this much below the nearer neighbour's, millimetres, and below four fifths of it.
pub const SHORT_MM: i32 = 300;
/// Score at which a transducer counts as dead.
pub const SILENT_LIMIT: u8 = 60;
/// Score at which changes of range are no longer believed.
pub const MISFIT_LIMIT: u8 = 54;
/// Score at which short ranges are no longer believed.
pub const SHORT_LIMIT: u8 = 60;

/// What is wrong with a transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Fault {
    /// It never hears anything.
    Dead,
    /// It always says the same.
    Stuck,
    /// It hears things far nearer than its neighbours do.
    Short,
    /// What it says does not change as the robot moves.
    Jumping,
}

/// What the detector has decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verdict {
    /// Transducer.
    pub sensor: u8,
    /// Why it is not believed any more; `None` = it is believed again.
    pub fault: Option<Fault>,
}

/// How near a transducer is to being disbelieved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Scores {
    /// Looks without an echo between near things; limit [`SILENT_LIMIT`].
    pub silent: u8,
    /// Changes of range that do not fit the way; limit [`MISFIT_LIMIT`].
    pub misfit: u8,
    /// Ranges far below the neighbours'; limit [`SHORT_LIMIT`].
    pub short: u8,
    /// Of the misfits, how many were no change at all (as a running score).
    same: u8,
}

/// What is known of one transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Record {
    /// The latest range.
    latest: Option<Range>,
    /// The range at the last look, and the odometer there.
    looked: Option<Range>,
    x_mm: i16,
    y_mm: i16,
    /// Sum of what both neighbours heard at the last look, millimetres; 0 = not known.
    sides_mm: u16,
    scores: Scores,
}

const _: () = assert!(size_of::<Record>() <= 16);

/// The detector. All zeros when new.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Detector<const SENSORS: usize> {
    records: [Record; SENSORS],
    /// Way since the start in the ring's frame, millimetres, wrapping.
    x_mm: i16,
    y_mm: i16,
    /// Whom this detector has made the configuration disbelieve.
    disbelieved: u32,
}

impl<const SENSORS: usize> Default for Detector<SENSORS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const SENSORS: usize> Detector<SENSORS> {
    /// Nothing heard yet, nobody under suspicion.
    #[must_use]
    pub const fn new() -> Self {
        const UNKNOWN: Record = Record {
            latest: None,
            looked: None,
            x_mm: 0,
            y_mm: 0,
            sides_mm: 0,
            scores: Scores {
                silent: 0,
                misfit: 0,
                short: 0,
                same: 0,
            },
        };
        Self {
            records: [UNKNOWN; SENSORS],
            x_mm: 0,
            y_mm: 0,
            disbelieved: 0,
        }
    }

    /// How near a transducer is to being disbelieved; all zeros for one that does not exist.
    #[must_use]
    pub fn scores(&self, sensor: usize) -> Scores {
        self.records
            .get(sensor)
            .map_or(Scores::default(), |record| record.scores)
    }

    /// Takes an event before the controller does, and changes whom the configuration believes. Does nothing unless
    /// [`Config::fault_detection`] is set. A transducer that somebody else believes again starts anew; one that somebody
    /// else disbelieves stays so.
    pub fn heed(
        &mut self,
        config: &mut Config<SENSORS>,
        event: &Event<SENSORS>,
    ) -> Option<Verdict> {
        if !config.fault_detection {
            return None;
        }
        match *event {
            Event::Odometry { moved, turned, .. } => {
                self.moved(moved, turned);
                None
            }
            Event::Echo { sensor, range } => self.heard(config, sensor, range),
            Event::Command(_) | Event::Tick | Event::Alarm(_) => None,
        }
    }

    fn moved(&mut self, moved: Displacement, turned: Bearing) {
        self.x_mm = self.x_mm.wrapping_add(moved.dx_mm);
        self.y_mm = self.y_mm.wrapping_add(moved.dy_mm);
        if turned != Bearing::ZERO {
            // The axes have turned: what was heard before is no measure of what is heard now.
            for record in &mut self.records {
                record.looked = None;
            }
        }
    }

    fn heard(
        &mut self,
        config: &mut Config<SENSORS>,
        sensor: u8,
        range: Option<Range>,
    ) -> Option<Verdict> {
        let index = usize::from(sensor);
        let bit = 1_u32.wrapping_shl(sensor.into());
        if index >= SENSORS.min(32) {
            return None;
        }
        if config.believed.contains(index) && self.disbelieved & bit != 0 {
            self.disbelieved &= !bit;
            *self.records.get_mut(index)? = Record::default();
        }
        let neighbours = self.neighbours(config.believed, index);
        let axis = *config.robot.directions.get(index)?;
        let (x_mm, y_mm) = (self.x_mm, self.y_mm);
        let record = self.records.get_mut(index)?;
        record.latest = range;
        let dx = i32::from(x_mm.wrapping_sub(record.x_mm));
        let dy = i32::from(y_mm.wrapping_sub(record.y_mm));
        let along = axis.along(dx, dy);
        let across = axis.along(dy, dx.wrapping_neg());
        if along.abs().max(across.abs()) < LOOK_MM {
            return None;
        }
        let doubted = self.disbelieved & bit != 0;
        record.look(range, along, across, neighbours, doubted);
        (record.x_mm, record.y_mm) = (x_mm, y_mm);
        let scores = record.scores;
        self.judge(config, sensor, scores)
    }

    /// The latest ranges of the transducers on both sides, if both are believed.
    fn neighbours(&self, believed: Mask, index: usize) -> Option<[Option<Range>; 2]> {
        let next = index.wrapping_add(1);
        let left = if next >= SENSORS { 0 } else { next };
        let right = index
            .checked_sub(1)
            .unwrap_or_else(|| SENSORS.wrapping_sub(1));
        let latest = |side: usize| {
            let record = self.records.get(side)?;
            believed.contains(side).then_some(record.latest)
        };
        Some([latest(left)?, latest(right)?])
    }

    /// Believes or disbelieves by the scores. At most a quarter of the ring is disbelieved: with more the robot had better
    /// be looked after.
    fn judge(
        &mut self,
        config: &mut Config<SENSORS>,
        sensor: u8,
        scores: Scores,
    ) -> Option<Verdict> {
        let bit = 1_u32.wrapping_shl(sensor.into());
        let doubted = self.disbelieved & bit != 0;
        if doubted {
            if !scores.is_clean() {
                return None;
            }
            self.disbelieved &= !bit;
            config.believed = config.believed.with(sensor.into());
            return Some(Verdict {
                sensor,
                fault: None,
            });
        }
        let fault = scores.fault()?;
        let room = (self.disbelieved.count_ones() as usize) < SENSORS / 4;
        if !room || !config.believed.contains(sensor.into()) {
            return None;
        }
        self.disbelieved |= bit;
        config.believed = config.believed.without(sensor.into());
        Some(Verdict {
            sensor,
            fault: Some(fault),
        })
    }
}

impl Scores {
    const fn is_clean(self) -> bool {
        self.silent == 0 && self.misfit == 0 && self.short == 0
    }

    const fn fault(self) -> Option<Fault> {
        if self.silent >= SILENT_LIMIT {
            return Some(Fault::Dead);
        }
        if self.misfit >= MISFIT_LIMIT {
            return Some(if self.same >= MISFIT_LIMIT / 2 {
                Fault::Stuck
            } else {
                Fault::Jumping
            });
        }
        if self.short >= SHORT_LIMIT {
            return Some(Fault::Short);
        }
        None
    }
}

const fn add(score: &mut u8, weight: u8) {
    *score = score.saturating_add(weight);
}

const fn take(score: &mut u8, weight: u8) {
    *score = score.saturating_sub(weight);
}

/// What the transducers on both sides heard last, where both are believed.
type Sides = Option<[Option<Range>; 2]>;

impl Record {
    /// Looks at what is heard after a way `along` its axis and `across` it, millimetres.
    fn look(
        &mut self,
        range: Option<Range>,
        along: i32,
        across: i32,
        neighbours: Sides,
        doubted: bool,
    ) {
        let before = core::mem::replace(&mut self.looked, range);
        let sides = match neighbours {
            Some([Some(left), Some(right)]) => left.as_mm().saturating_add(right.as_mm()),
            _ => 0,
        };
        let sides_before = core::mem::replace(&mut self.sides_mm, sides);
        // A robot that drives down a corridor hears nothing ahead for long, with walls on both sides.
        let sideways = across.abs() >= along.abs();
        self.listen(range, neighbours.filter(|_| sideways), doubted);
        if let (Some(before), Some(now)) = (before, range) {
            let change = i32::from(now.as_mm()).wrapping_sub(before.as_mm().into());
            let farther = before.max(now).as_mm();
            let turned_to_others = sides > 0
                && sides_before > 0
                && i32::from(sides.abs_diff(sides_before)) >= OTHER_MM;
            if along.abs() >= LOOK_MM && across.abs() <= along.abs() {
                self.compare(change, farther, along, across);
            } else if change.abs() > STILL_MM {
                take(&mut self.scores.same, FIT_WEIGHT);
            } else if turned_to_others {
                add(&mut self.scores.misfit, FIT_WEIGHT);
                add(&mut self.scores.same, FIT_WEIGHT);
            }
        }
        if let (Some(now), Some([Some(left), Some(right)])) = (range, neighbours) {
            self.measure(now.as_mm().into(), left.min(right).as_mm().into());
        }
    }

    /// The first rule.
    fn listen(&mut self, range: Option<Range>, neighbours: Sides, doubted: bool) {
        let silent = &mut self.scores.silent;
        match (range, neighbours) {
            (Some(_), _) if doubted => take(silent, 1),
            (Some(_), _) => *silent = 0,
            (None, Some([Some(left), Some(right)])) => {
                let farther = i32::from(left.max(right).as_mm());
                if farther < NEAR_MM {
                    add(silent, NEAR_WEIGHT);
                } else if farther < MIDDLE_MM {
                    add(silent, 1);
                }
            }
            (None, _) => {}
        }
    }

    /// The second rule. A thing at the lobe's edge comes nearer by a quarter of the way across as well.
    fn compare(&mut self, change: i32, farther: u16, along: i32, across: i32) {
        let loose = LOOSE_MM
            .wrapping_add(i32::from(farther) / 32)
            .wrapping_add(across.abs() / 4);
        let scores = &mut self.scores;
        // A change of range that would not show.
        if loose >= along.abs().wrapping_sub(LOOK_MM / 8) {
            return;
        }
        if change.wrapping_add(along).abs() <= loose {
            take(&mut scores.misfit, FIT_WEIGHT);
            take(&mut scores.same, FIT_WEIGHT);
            return;
        }
        add(&mut scores.misfit, FIT_WEIGHT);
        if change.abs() <= STILL_MM {
            add(&mut scores.same, FIT_WEIGHT);
        } else {
            take(&mut scores.same, FIT_WEIGHT);
        }
    }

    /// The third rule.
    fn measure(&mut self, now: i32, nearest: i32) {
        let short = &mut self.scores.short;
        if now.wrapping_mul(5) < nearest.wrapping_mul(4) && nearest.wrapping_sub(now) > SHORT_MM {
            add(short, 2);
        } else {
            take(short, 1);
        }
    }
}

#[cfg(test)]
mod tests;
