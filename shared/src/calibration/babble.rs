//! Random moves of a body that does not know where its sensors look.

use super::Calibration;
use crate::controller::{Event, Motion, Progress};
use crate::fixed::Mask;
use crate::units::{Bearing, Displacement, Range};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// How the body may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BabbleLimits {
    /// Sensors that exist.
    pub enabled: Mask,
    /// Longest move, millimeters.
    pub longest_mm: u16,
    /// Distance that a move leaves to the nearest thing heard, wherever that is, millimeters.
    pub margin_mm: u16,
    /// Speed, mm/s.
    pub speed_mm_s: u16,
    /// The body learns what its base does as well: after the first move it turns once around, and
    /// it leaves more room, because the base may go farther than it thinks.
    pub learns_actuation: bool,
}

/// Parts of a turn that is once around even for a base that turns less far than it thinks: 581°.
/// Equal parts would have the body listen at the same headings again and again.
const PARTS: [u16; 7] = [9_102, 11_105, 13_107, 15_110, 17_112, 19_115, 21_117];
/// A base turns only to where it goes: as far as it has to go for that, millimeters.
const TURNING_MM: i32 = 2;
/// Shortest move, millimeters: enough to make the base turn.
const SHORTEST_MM: u16 = 5;

/// Moves at random and learns where the sensors look.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Babble<const BEAMS: usize> {
    calibration: Calibration<BEAMS>,
    rng: Xoshiro128PlusPlus,
    moves_left: u16,
    moves_made: u16,
    motion_id: u16,
    is_moving: bool,
    /// Sensors heard since the last move ended.
    fresh: Mask,
    ranges: [Option<Range>; BEAMS],
}

impl<const BEAMS: usize> Babble<BEAMS> {
    /// So many random moves, drawn from a seed.
    #[must_use]
    pub fn new(moves: u16, seed: u64) -> Self {
        Self {
            calibration: Calibration::new(),
            rng: Xoshiro128PlusPlus::seed_from_u64(seed),
            moves_left: moves,
            moves_made: 0,
            motion_id: 0,
            is_moving: false,
            fresh: Mask::NONE,
            ranges: [None; BEAMS],
        }
    }

    /// What has been learned.
    #[must_use]
    pub const fn calibration(&self) -> &Calibration<BEAMS> {
        &self.calibration
    }

    /// Moves still to make.
    #[must_use]
    pub const fn moves_left(&self) -> u16 {
        self.moves_left
    }

    /// Whether all moves are made.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.moves_left == 0 && !self.is_moving
    }

    /// Handles an event: echoes by the body's sensors, odometry in the body's frame. Returns a
    /// motion in the body's frame.
    pub fn handle<const SECTORS: usize>(
        &mut self,
        limits: &BabbleLimits,
        event: &Event<SECTORS>,
    ) -> Option<Motion> {
        match *event {
            Event::Echo { sensor, range } => self.hear(limits, sensor.into(), range),
            Event::Odometry {
                motion,
                moved,
                turned,
                progress,
            } => {
                self.calibration.moved(moved, turned);
                let has_ended = matches!(progress, Progress::Ended | Progress::Touched);
                if has_ended && self.is_moving && motion == self.motion_id {
                    self.is_moving = false;
                    self.fresh = Mask::NONE;
                }
                None
            }
            Event::Command(_) | Event::Tick | Event::Alarm(_) | Event::Touched => None,
        }
    }

    fn hear(
        &mut self,
        limits: &BabbleLimits,
        sensor: usize,
        range: Option<Range>,
    ) -> Option<Motion> {
        if !limits.enabled.contains(sensor) {
            return None;
        }
        self.calibration.hear(sensor, range);
        *self.ranges.get_mut(sensor)? = range;
        self.fresh = self.fresh.with(sensor);
        let is_complete = limits
            .enabled
            .indices(BEAMS)
            .all(|s| self.fresh.contains(s));
        if self.is_moving || !is_complete || self.moves_left == 0 {
            return None;
        }
        self.moves_left -= 1;
        self.moves_made = self.moves_made.wrapping_add(1);
        self.motion_id = self.motion_id.wrapping_add(1);
        self.is_moving = true;
        Some(Motion {
            id: self.motion_id,
            displacement: self.next_move(limits),
            speed_mm_s: limits.speed_mm_s,
        })
    }

    fn next_move(&mut self, limits: &BabbleLimits) -> Displacement {
        let part = usize::from(self.moves_made).checked_sub(2);
        let part = part.and_then(|part| PARTS.get(part));
        let Some(part) = part.filter(|_| limits.learns_actuation) else {
            return self.random_move(limits);
        };
        if self.moves_made == 2 {
            self.calibration.begin_place();
        }
        let left = self.calibration.front().plus(Bearing::from_turns(*part));
        Displacement::along(left, TURNING_MM)
    }

    /// Any bearing; no farther than the nearest thing heard, less the margin.
    fn random_move(&mut self, limits: &BabbleLimits) -> Displacement {
        let nearest = self.ranges.iter().flatten().min();
        let free_mm = nearest.map_or(limits.longest_mm, |nearest| {
            nearest.as_mm().saturating_sub(limits.margin_mm)
        });
        let free_mm = if limits.learns_actuation {
            free_mm / 3 * 2
        } else {
            free_mm
        };
        let longest = u64::from(free_mm.min(limits.longest_mm).max(SHORTEST_MM));
        let bearing = Bearing::from_turns(self.rng.next_u32() as u16);
        let length = (u64::from(self.rng.next_u32()) * longest) >> 32;
        Displacement::along(bearing, (length as i32).max(SHORTEST_MM.into()))
    }
}
