//! Which places a situation recalls.

use super::Places;
use crate::fixed::{ONE_BITS, Weight, isqrt_u32};
use crate::goal::Goal;
use crate::memory::{self, SituationBytes};
use crate::units::Displacement;

/// A place recalls a situation if what was perceived there deviates by at most this on average
/// (root of the mean square), in units of 2⁻¹³: 0.4 m of 4.5 m.
const ALIKE: u32 = 750;
/// Greatest deviation that counts for one sector: an eighth of the scale.
const CAP: Weight = Weight::from_bits(ONE_BITS / 8);
/// A robot that has not gone farther stays where it was, millimeters.
const STAYS_MM: u32 = 60;
/// A place costs so many millimeters more for each unit of deviation.
const COST: u16 = 2;

/// What the robot is led to.
#[derive(Debug, Clone, Copy)]
pub(super) enum Sought<'g, const SECTORS: usize> {
    Position(Displacement),
    Situation(&'g Goal<SECTORS>),
    /// Where it has not been.
    Nothing,
}

impl<const SECTORS: usize> Sought<'_, SECTORS> {
    pub(super) const fn is_situation(&self) -> bool {
        matches!(self, Self::Situation(_))
    }

    pub(super) const fn position(&self) -> Option<Displacement> {
        match self {
            Self::Position(position) => Some(*position),
            _ => None,
        }
    }

    /// What a place costs for what was perceived there, millimeters, if it recalls the situation.
    pub(super) fn cost_mm(&self, view: &SituationBytes<SECTORS>) -> Option<u16> {
        let Self::Situation(goal) = self else {
            return None;
        };
        let deviation = deviation(goal, view)?;
        (deviation <= ALIKE).then_some(deviation as u16 * COST)
    }
}

/// The goal as views are compared with it: one sector that something else is seen in does not
/// outweigh the others.
pub(super) fn compared<const SECTORS: usize>(goal: &Goal<SECTORS>) -> Goal<SECTORS> {
    Goal {
        cap: goal.cap.min(CAP),
        ..*goal
    }
}

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// Whether the robot is where the situation was perceived; where it was once, a noisy view does
    /// not send it away.
    pub fn is_found(&mut self, goal: &Goal<SECTORS>, view: &SituationBytes<SECTORS>) -> bool {
        let deviation = deviation(&compared(goal), view);
        let deviates_by_most = |most: u32| deviation.is_some_and(|by| by <= most);
        let stays = |found: Displacement| found.minus(self.here).is_shorter_than(STAYS_MM);
        if self.found.is_some_and(stays) {
            return deviates_by_most(ALIKE);
        }
        let is_here = deviates_by_most(u32::from(goal.tolerance.to_bits().max(0).unsigned_abs()));
        if is_here {
            self.found = Some(self.here);
        }
        is_here
    }
}

/// Root of the mean squared deviation of a view from the goal, in units of 2⁻¹³; `None` for a goal
/// that asks nothing of what was seen.
fn deviation<const SECTORS: usize>(
    goal: &Goal<SECTORS>,
    view: &SituationBytes<SECTORS>,
) -> Option<u32> {
    let (situation, seen) = memory::from_bytes(view);
    let weights: i32 = goal.asked(0, seen).map(|asked| asked.weight()).sum();
    let squared = goal.cost(0, seen, &situation, i64::MAX);
    let mean = squared.checked_div(weights.into())?;
    // Of 2²⁶ at most.
    Some(isqrt_u32(mean as u32))
}
