//! Which way the robot faces: walls keep their directions.

use crate::points::{PART, PARTS, WallDirections, shares};
use crate::units::Bearing;

/// Headings are compared up to so many parts of a right angle to each side: 11°.
const PARTS_ASIDE: usize = 4;
const HEADINGS: usize = 2 * PARTS_ASIDE + 1;
/// Half of a right angle, in parts.
const HALF: usize = PARTS / 2;
/// A heading of which nothing was known is known when so much of all probability is around it.
const KNOWN: u32 = TOTAL / 16 * 15;
/// The sum of all probabilities.
const TOTAL: u32 = 1 << 15;
/// For each millimeter so many 65 536ths of a probability go to each of its neighbors: a heading
/// drifts by 1.1° in the first meter, by 3.5° in ten.
const SPREAD_PER_MM: u32 = 5;
/// All weights of walls are halved when one is larger: what was heard long ago counts less.
const MAX_WEIGHT: u32 = 1 << 24;
/// Scores are counted in units of this.
const SCORE: u32 = 256;

/// The walls that the robot knows, and what it believes of its heading. It hears walls in a frame
/// that is turned with the odometry and follows its drift by whole parts only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Compass {
    /// Weights of walls, in the frame of the start.
    known: [u32; PARTS],
    /// Probabilities of errors of the odometry's heading, from [`PARTS_ASIDE`] parts to the right
    /// on; all zeros at first, when it is right. Only the first [`HEADINGS`] count, unless it may
    /// be any.
    belief: [u16; PARTS],
    /// Nothing is known of the heading.
    is_unknown: bool,
    /// The error that is expected, turns to the left: by so much it has been corrected.
    error: i16,
}

impl Compass {
    /// No wall is known.
    pub(super) const NEW: Self = Self {
        known: [0; PARTS],
        belief: [0; PARTS],
        is_unknown: false,
        error: 0,
    };

    /// The robot may face anywhere; the walls are where they were.
    pub(super) const fn forget_heading(&mut self) {
        self.belief = [(TOTAL / PARTS as u32) as u16; PARTS];
        self.is_unknown = true;
    }

    /// The walls as bytes: the weights of their directions, each times 2 to the power of the first.
    #[cfg(feature = "store")]
    pub(super) fn saved_walls(&self) -> (u8, [u8; PARTS]) {
        let most = self.known.iter().copied().max().unwrap_or(0);
        let shift = (u32::BITS - most.leading_zeros()).saturating_sub(u8::BITS);
        (
            shift as u8,
            self.known.map(|weight| (weight >> shift) as u8),
        )
    }

    /// Knows walls that were saved.
    #[cfg(feature = "store")]
    pub(super) fn restore_walls(&mut self, shift: u8, weights: [u8; PARTS]) {
        // No weight has more bits.
        let shift = u32::from(shift).min(MAX_WEIGHT.ilog2() + 1 - u8::BITS);
        self.known = weights.map(|weight| u32::from(weight) << shift);
    }

    /// Whether the heading is known, but for right angles.
    pub(super) const fn is_aligned(&self) -> bool {
        !self.is_unknown
    }

    /// Turns from the frame of the start to that of [`update`](Self::update).
    pub(super) const fn frame(&self) -> Bearing {
        Bearing::from_turns(self.error.wrapping_neg().cast_unsigned())
    }

    /// If the robot may face anywhere, a heading around which nearly all probability is becomes the
    /// one that is expected. Returns by how much the robot faces farther to the left than it
    /// thought, at most half of a right angle to either side.
    pub(super) fn align(&mut self) -> Option<Bearing> {
        let around = |heading: usize| -> u32 {
            let first = heading + PARTS - PARTS_ASIDE;
            let headings = (first..first + HEADINGS).map(|heading| self.belief[heading % PARTS]);
            headings.map(u32::from).sum()
        };
        let most = (0..PARTS).max_by_key(|heading| self.belief[*heading])?;
        if !self.is_unknown || around(most) < KNOWN {
            return None;
        }
        let parts = (most + PARTS - PARTS_ASIDE) % PARTS;
        self.belief.rotate_left(parts);
        self.is_unknown = false;
        self.narrow();
        // From half of them on it is to the right.
        let left = (parts + HALF) % PARTS;
        let turns = (left as u16 * PART).wrapping_sub(HALF as u16 * PART);
        Some(Bearing::from_turns(turns))
    }

    /// The robot has gone so far since it heard walls, and hears these. Returns by how much it
    /// faces farther to the left than it thought; nothing as long as it may face anywhere.
    pub(super) fn update(&mut self, traveled_mm: u16, walls: &WallDirections) -> Bearing {
        self.predict(traveled_mm);
        self.weigh(walls);
        if self.is_unknown {
            return Bearing::ZERO;
        }
        let before = self.error;
        self.error = self.expected_error();
        let turn = Bearing::from_turns(self.error.wrapping_sub(before).cast_unsigned());
        self.learn(walls);
        self.recenter();
        turn
    }

    /// The farther the robot has gone the less is known.
    fn predict(&mut self, traveled_mm: u16) {
        if self.belief == [0; PARTS] {
            self.belief[PARTS_ASIDE] = TOTAL as u16;
        }
        let share = (u32::from(traveled_mm) * SPREAD_PER_MM).min(1 << 14);
        let given = self.belief.map(|belief| (u32::from(belief) * share) >> 16);
        for (index, belief) in self.belief.iter_mut().enumerate() {
            let gets = given[(index + PARTS - 1) % PARTS] + given[(index + 1) % PARTS];
            *belief = (u32::from(*belief) - 2 * given[index] + gets) as u16;
        }
        self.narrow();
    }

    /// What is too far aside of what is expected counts no more.
    fn narrow(&mut self) {
        if !self.is_unknown {
            self.belief[HEADINGS..].fill(0);
        }
    }

    /// A heading is the more probable the more of the walls it puts where walls are known: chance
    /// gives a score of 1.
    fn weigh(&mut self, walls: &WallDirections) {
        let known: u64 = self.known.iter().map(|weight| u64::from(*weight)).sum();
        let heard: u64 = walls
            .weights()
            .iter()
            .map(|weight| u64::from(*weight))
            .sum();
        let by_chance = known * heard / PARTS as u64;
        if by_chance == 0 {
            return;
        }
        let score = |heading: usize| {
            let parts = walls.weights().iter().enumerate();
            let matches = parts.map(|(part, weight)| {
                // The farther to the left it faces, the farther to the right it sees them.
                let known = self.known[(part + heading + PARTS - PARTS_ASIDE) % PARTS];
                u64::from(*weight) * u64::from(known)
            });
            // At most 32.
            (matches.sum::<u64>() * u64::from(SCORE) / by_chance) as u32
        };
        // Walls are heard again and again: of a heading that may be any they count less.
        let prior = if self.is_unknown { 4 * SCORE } else { SCORE };
        let mut weighed = [0; PARTS];
        for (heading, (weighed, belief)) in weighed.iter_mut().zip(self.belief).enumerate() {
            if belief > 0 {
                *weighed = u32::from(belief) * (prior + score(heading)) / prior;
            }
        }
        let sum: u32 = weighed.iter().sum();
        self.belief = weighed.map(|weighed| {
            let probability = u64::from(weighed) * u64::from(TOTAL);
            probability.checked_div(sum.into()).unwrap_or(0) as u16
        });
    }

    fn expected_error(&self) -> i16 {
        let headings = self.belief.iter().enumerate();
        let (sum, moment) = headings.fold((0, 0), |(sum, moment), (heading, belief)| {
            let belief = i32::from(*belief);
            let parts = heading as i32 - PARTS_ASIDE as i32;
            (sum + belief, moment + belief * parts)
        });
        // At most 2¹⁵ of 4 parts of 2⁹ turns.
        (moment * i32::from(PART)).checked_div(sum).unwrap_or(0) as i16
    }

    fn learn(&mut self, walls: &WallDirections) {
        for (part, weight) in walls.weights().iter().enumerate() {
            let heard = Bearing::from_turns(part as u16 * PART);
            for (part, share) in shares(heard.minus(self.frame()), *weight) {
                self.known[part % PARTS] += u32::from(share);
            }
        }
        if self.known.iter().any(|weight| *weight > MAX_WEIGHT) {
            self.known = self.known.map(|weight| weight / 2);
        }
    }

    /// Headings are compared to both sides of about the one that is expected.
    fn recenter(&mut self) {
        if self.error > PART.cast_signed() {
            self.belief.rotate_left(1);
            self.error -= PART.cast_signed();
        } else if self.error < -PART.cast_signed() {
            self.belief.rotate_right(1);
            self.error += PART.cast_signed();
        }
        self.narrow();
    }
}

#[cfg(test)]
mod tests;
