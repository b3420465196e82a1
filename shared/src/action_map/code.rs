//! Encoding of actions in the action map.

use crate::fixed::{ONE_BITS, Weight, unit_weight};
use crate::units::{Bearing, Displacement, div_round};
use serde::{Deserialize, Serialize};

/// An action as two components in [−1, 1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ActionCode {
    /// Displacement in the ring's frame, divided by the longest step. Codes can be averaged.
    Displacement,
    /// (turn / half a turn, length / longest step): the literal reading of a wheeled robot's move.
    /// Averages of turns near ±180° are wrong.
    TurnStep,
}

impl ActionCode {
    /// The code of a displacement; components above `step_mm` are clamped.
    #[must_use]
    #[inline(never)]
    pub fn encode(self, move_mm: Displacement, step_mm: u16) -> [Weight; 2] {
        let scaled_length = |mm: i32| {
            let scaled = mm.clamp(-65_535, 65_535).wrapping_mul(i32::from(ONE_BITS));
            unit_weight(div_round(scaled, i32::from(step_mm.max(1))))
        };
        match self {
            Self::Displacement => [
                scaled_length(i32::from(move_mm.dx_mm)),
                scaled_length(i32::from(move_mm.dy_mm)),
            ],
            Self::TurnStep => [
                unit_weight(i32::from(move_mm.bearing().as_signed_turns()) >> 2),
                scaled_length(i32::from(move_mm.length_mm())),
            ],
        }
    }

    /// The displacement of a code.
    #[must_use]
    #[inline(never)]
    pub fn decode(self, code: [Weight; 2], step_mm: u16) -> Displacement {
        let [first, second] = code.map(|w| i32::from(w.to_bits()));
        let length =
            |bits: i32| (bits.wrapping_mul(i32::from(step_mm)).wrapping_add(1 << 12)) >> 13;
        match self {
            Self::Displacement => Displacement::saturating(length(first), length(second)),
            Self::TurnStep => {
                let turn = Bearing::from_turns((first << 2) as u16);
                Displacement::along(turn, length(second).max(0))
            }
        }
    }
}
