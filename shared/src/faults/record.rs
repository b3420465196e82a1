//! What the detector knows of one transducer, and how a look changes its scores.

use super::*;

/// A range with [`RangeReading::LEAST`] added, or silence, or nothing yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RangeReading(pub(super) u16);

impl RangeReading {
    pub(super) const UNKNOWN: Self = Self(0);
    pub(super) const SILENCE: Self = Self(1);
    pub(super) const LEAST: u16 = 2;

    pub(super) fn new(range: Option<Range>) -> Self {
        range.map_or(Self::SILENCE, |range| {
            Self(range.as_mm().saturating_add(Self::LEAST))
        })
    }

    pub(super) fn range_mm(self) -> Option<u16> {
        self.0.checked_sub(Self::LEAST)
    }

    pub(super) fn is_known(self) -> bool {
        self != Self::UNKNOWN
    }

    /// Whether the two cannot be readings of the same surface at the same distance.
    pub(super) fn is_other_than(self, other: Self) -> bool {
        match (self.range_mm(), other.range_mm()) {
            (Some(a), Some(b)) => a.abs_diff(b) >= OTHER_MM,
            _ => self != other && self.is_known() && other.is_known(),
        }
    }
}

/// What is known of one transducer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SensorRecord {
    /// The latest reading.
    pub(super) latest: RangeReading,
    /// The reading at the last look, those of the neighbors, and the odometer there.
    pub(super) looked: RangeReading,
    pub(super) sides: [RangeReading; 2],
    pub(super) x_mm: i16,
    pub(super) y_mm: i16,
    pub(super) scores: Scores,
}

const _: () = assert!(size_of::<SensorRecord>() <= 16);

impl SensorRecord {
    pub(super) const NEW: Self = Self {
        latest: RangeReading::UNKNOWN,
        looked: RangeReading::UNKNOWN,
        sides: [RangeReading::UNKNOWN; 2],
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

/// How a transducer is looked at.
pub(super) struct Look {
    /// The neighbors' latest readings, where they are not in doubt.
    pub(super) sides: [RangeReading; 2],
    /// Way since the look before, millimeters.
    pub(super) way: i32,
    /// The robot has not been here before.
    pub(super) is_new: bool,
    /// The transducer is disabled: enabling it again takes more evidence than keeping it enabled.
    pub(super) doubted: bool,
}

impl Look {
    /// Evidence for a fault counts at new places only; so does evidence against it while the
    /// transducer is disabled.
    pub(super) fn weigh(&self, score: &mut u8, speaks_for: bool, [more, less]: [u8; 2]) {
        match (speaks_for, self.is_new) {
            (true, true) => add(score, more),
            (false, is_new) if is_new || !self.doubted => take(score, less),
            _ => {}
        }
    }
}

impl SensorRecord {
    pub(super) fn look(&mut self, look: &Look) {
        let now = self.latest;
        let before = core::mem::replace(&mut self.looked, now);
        let sides_before = core::mem::replace(&mut self.sides, look.sides);
        let others = core::iter::zip(look.sides, sides_before);
        let all_other = others.fold(true, |all, (now, then)| all && now.is_other_than(then));
        let [left, right] = look.sides.map(RangeReading::range_mm);
        self.listen(look, left.zip(right).map(|(left, right)| left.max(right)));
        let Some(now) = now.range_mm() else {
            // A transducer stuck at a range is never silent.
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
        if self.latest != RangeReading::SILENCE {
            // A dead transducer never hears anything.
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

/// Adds to a score, up to its limit.
pub(super) fn add(score: &mut u8, weight: u8) {
    *score = score.saturating_add(weight).min(LIMIT);
}

/// Takes away from a score, down to zero.
const fn take(score: &mut u8, weight: u8) {
    *score = score.saturating_sub(weight);
}
