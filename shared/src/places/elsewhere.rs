//! Where a robot may be instead of where it thinks it is.

use crate::units::Displacement;

/// Positions nearer to each other are the same, millimeters.
pub(super) const SAME_MM: u32 = 300;
/// Right angles of a full turn.
pub(super) const QUARTERS: u8 = 4;

/// Where the robot may be instead of where it thinks it is: all is turned around the start, and
/// then shifted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Elsewhere {
    /// It faces so many right angles farther to the left.
    pub(super) quarters: u8,
    pub(super) shift: Displacement,
}

impl Elsewhere {
    /// Where it thinks it is.
    pub(super) const HERE: Self = Self {
        quarters: 0,
        shift: Displacement::ZERO,
    };

    /// The one that puts what is here there.
    pub(super) fn between(here: Displacement, there: Displacement, quarters: u8) -> Self {
        Self {
            quarters,
            shift: there.minus(here.turned_left(quarters)),
        }
    }

    /// Where it is that seems to be at this position.
    pub(super) fn of(&self, position: Displacement) -> Displacement {
        position.turned_left(self.quarters).plus(self.shift)
    }

    /// The same once the robot is where another guess has it.
    pub(super) fn seen_from(&self, other: &Self) -> Self {
        let quarters = self.quarters.wrapping_sub(other.quarters) % QUARTERS;
        Self {
            quarters,
            shift: self.shift.minus(other.shift.turned_left(quarters)),
        }
    }

    /// Whether both put the robot, which thinks that it is here, to about the same place.
    pub(super) fn is_near(&self, other: &Self, here: Displacement, most_mm: u32) -> bool {
        let apart = self.of(here).minus(other.of(here));
        self.quarters == other.quarters && apart.is_shorter_than(most_mm)
    }
}

/// Somewhere among the places before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Guess {
    pub(super) at: Elsewhere,
    pub(super) score: i16,
}

impl Guess {
    /// Whether it is about where the robot thinks it is.
    pub(super) fn is_here(&self, here: Displacement) -> bool {
        self.at.is_near(&Elsewhere::HERE, here, 2 * SAME_MM)
    }
}
