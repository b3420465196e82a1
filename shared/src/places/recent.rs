//! Whether the robot gets anywhere.

use crate::units::Displacement;

/// Decisions that are looked back at.
const DECISIONS: usize = 8;
/// A robot that has not been farther from here than this in all of them is stuck, millimeters.
const STUCK_MM: u32 = 300;

/// Where the robot stood at its latest decisions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Recent {
    positions: [Displacement; DECISIONS],
    len: u8,
}

impl Recent {
    pub(super) const NEW: Self = Self {
        positions: [Displacement::ZERO; DECISIONS],
        len: 0,
    };

    /// Takes the position at a decision. A robot that is stuck is given eight more before it is
    /// again.
    pub(super) fn is_stuck(&mut self, here: Displacement) -> bool {
        self.positions.rotate_right(1);
        if let Some(newest) = self.positions.first_mut() {
            *newest = here;
        }
        self.len = self.len.saturating_add(1);
        let stays = |position: &Displacement| position.minus(here).is_shorter_than(STUCK_MM);
        let is_stuck = usize::from(self.len) > DECISIONS && self.positions.iter().all(stays);
        if is_stuck {
            self.len = 0;
        }
        is_stuck
    }
}
