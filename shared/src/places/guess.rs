//! Where a robot that was set down elsewhere may be.

use crate::units::Displacement;

/// Positions nearer to each other are the same, millimeters.
pub(super) const SAME_MM: u32 = 300;
/// Right angles of a full turn.
pub(super) const QUARTERS: u8 = 4;

/// From where things seem to be to where they are: a turn around the start, and then a shift.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Transform {
    /// Right angles to the left.
    pub(super) quarters: u8,
    pub(super) shift: Displacement,
}

impl Transform {
    /// All is where it seems to be.
    pub(super) const IDENTITY: Self = Self {
        quarters: 0,
        shift: Displacement::ZERO,
    };

    /// The one with this turn by which a position becomes another one.
    pub(super) fn taking(from: Displacement, to: Displacement, quarters: u8) -> Self {
        Self {
            quarters,
            shift: to.minus(from.turned_left(quarters)),
        }
    }

    pub(super) fn apply(&self, position: Displacement) -> Displacement {
        position.turned_left(self.quarters).plus(self.shift)
    }

    /// What is left of it when another one has been applied.
    pub(super) fn after(&self, applied: &Self) -> Self {
        let quarters = self.quarters.wrapping_sub(applied.quarters) % QUARTERS;
        Self {
            quarters,
            shift: self.shift.minus(applied.shift.turned_left(quarters)),
        }
    }

    /// Whether both turn alike and put what seems to be here within `most_mm` of each other.
    pub(super) fn is_near(&self, other: &Self, here: Displacement, most_mm: u32) -> bool {
        let apart = self.apply(here).minus(other.apply(here));
        self.quarters == other.quarters && apart.is_shorter_than(most_mm)
    }
}

/// The robot is somewhere else among its places than it thinks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Guess {
    pub(super) transform: Transform,
    pub(super) score: i16,
}

impl Guess {
    /// Whether it is about where the robot thinks it is.
    pub(super) fn is_here(&self, here: Displacement) -> bool {
        let identity = &Transform::IDENTITY;
        self.transform.is_near(identity, here, 2 * SAME_MM)
    }
}
