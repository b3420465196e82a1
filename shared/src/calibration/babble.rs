//! Random moves of a body that does not know where its sensors look.

use super::{Calibration, Geometry};
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

/// Moves in which nothing was heard that do not count, at most.
const SILENT_MOVES: u8 = 64;

/// Moves at random and learns where the sensors look.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Babble<const BEAMS: usize> {
    calibration: Calibration<BEAMS>,
    generator: Option<Xoshiro128PlusPlus>,
    moves_left: u16,
    moves_made: u16,
    /// Moves from where nothing was heard.
    silent_moves: u8,
    /// Sensors heard since the last move ended.
    fresh: Mask,
    ranges: [Option<Range>; BEAMS],
}

impl<const BEAMS: usize> Default for Babble<BEAMS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const BEAMS: usize> Babble<BEAMS> {
    /// Nothing to do.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            calibration: Calibration::new(),
            generator: None,
            moves_left: 0,
            moves_made: 0,
            silent_moves: 0,
            fresh: Mask::NONE,
            ranges: [None; BEAMS],
        }
    }

    /// Forgets what was learned; from now on so many random moves, drawn from a seed.
    pub fn begin(&mut self, moves: u16, seed: u64) {
        self.calibration.clear();
        self.generator = Some(Xoshiro128PlusPlus::seed_from_u64(seed));
        (self.moves_left, self.moves_made, self.silent_moves) = (moves, 0, 0);
        self.fresh = Mask::NONE;
        self.ranges = [None; BEAMS];
    }

    /// What has been learned.
    #[must_use]
    pub const fn calibration(&self) -> &Calibration<BEAMS> {
        &self.calibration
    }

    /// A sensor of a body that makes other moves was heard.
    pub fn watch(&mut self, sensor: usize, range: Option<Range>, geometry: Geometry<'_, BEAMS>) {
        self.calibration.hear(sensor, range, geometry);
    }

    /// Forgets what is known of a sensor.
    pub fn forget(&mut self, sensor: usize) {
        self.calibration.forget(sensor);
    }

    /// Moves still to make.
    #[must_use]
    pub const fn moves_left(&self) -> u16 {
        self.moves_left
    }

    /// The base has moved and then turned, in the body's frame.
    pub fn moved(&mut self, moved: Displacement, turned: Bearing) {
        self.calibration.moved(moved, turned);
    }

    /// The last move is over: every sensor is to be heard again before the next.
    pub const fn move_ended(&mut self) {
        self.fresh = Mask::NONE;
    }

    /// Whether no moves are left, and every sensor was heard after the last one.
    #[must_use]
    pub fn is_over(&self, limits: &BabbleLimits) -> bool {
        self.moves_left == 0 && self.has_heard_all(limits)
    }

    fn has_heard_all(&self, limits: &BabbleLimits) -> bool {
        let mut enabled = limits.enabled.indices(BEAMS);
        enabled.all(|sensor| self.fresh.contains(sensor))
    }

    /// A sensor was heard. Returns the next move, in the body's frame, when that makes all of a
    /// body that stands.
    pub fn hear(
        &mut self,
        limits: &BabbleLimits,
        sensor: usize,
        range: Option<Range>,
        is_moving: bool,
    ) -> Option<Displacement> {
        if !limits.enabled.contains(sensor) {
            return None;
        }
        self.calibration.hear(sensor, range, Geometry::Unknown);
        *self.ranges.get_mut(sensor)? = range;
        self.fresh = self.fresh.with(sensor);
        if is_moving || self.moves_left == 0 || !self.has_heard_all(limits) {
            return None;
        }
        // Where nothing is heard there is nothing to learn. A turn once around stays in its place.
        let is_silent = self.ranges.iter().all(Option::is_none) && !self.is_turning_around(limits);
        if is_silent && self.silent_moves < SILENT_MOVES {
            self.silent_moves += 1;
            return Some(self.move_on(limits));
        }
        self.moves_left -= 1;
        self.moves_made = self.moves_made.wrapping_add(1);
        Some(self.next_move(limits))
    }

    /// Whether the turn once around has begun and is not over.
    fn is_turning_around(&self, limits: &BabbleLimits) -> bool {
        limits.learns_actuation && (2..=PARTS.len()).contains(&usize::from(self.moves_made))
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

    /// About where the base goes ahead, as far as it may: random moves would stay in the open.
    fn move_on(&mut self, limits: &BabbleLimits) -> Displacement {
        // Up to 45 degrees to either side.
        let aside = Bearing::from_turns(self.random() as u16 / 4).minus(Bearing::of_place(1, 8));
        let bearing = self.calibration.front().plus(aside);
        Displacement::along(bearing, self.free_mm(limits).into())
    }

    /// How far a move may go whatever its bearing: to the nearest thing heard, less the margin.
    fn free_mm(&self, limits: &BabbleLimits) -> u16 {
        let nearest = self.ranges.iter().flatten().min();
        let free_mm = nearest.map_or(limits.longest_mm, |nearest| {
            nearest.as_mm().saturating_sub(limits.margin_mm)
        });
        let free_mm = if limits.learns_actuation {
            free_mm / 3 * 2
        } else {
            free_mm
        };
        free_mm.min(limits.longest_mm).max(SHORTEST_MM)
    }

    /// Any bearing and length.
    fn random_move(&mut self, limits: &BabbleLimits) -> Displacement {
        let longest = u64::from(self.free_mm(limits));
        let bearing = Bearing::from_turns(self.random() as u16);
        let length = (u64::from(self.random()) * longest) >> 32;
        Displacement::along(bearing, (length as i32).max(SHORTEST_MM.into()))
    }

    fn random(&mut self) -> u32 {
        let generator = self.generator.as_mut();
        generator.map_or(0, Xoshiro128PlusPlus::next_u32)
    }
}
