//! The second map of the paper: which action brings which change of situation.
//!
//! A neuron holds a change of situation Δ and an action side by side: two codebooks over one grid. Learning finds the
//! winner by both parts, |Δ − Δ_k|² + λ |a − a_k|²; recall probes with the change alone.

use crate::fixed::{Mask, ONE_BITS, Weight, unit_weight};
use crate::som::neighbourhood::Pull;
use crate::som::{Grid, Som, kernels};
use crate::units::{Bearing, Displacement};

/// How an action stands in the map, as two components in [−1, 1].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionCode {
    /// The displacement in the ring's frame over the longest step. Vectors may be averaged.
    Displacement,
    /// (turn over half a turn, length over the longest step): the literal reading of a move of a wheeled robot. Averages
    /// of turns are wrong across the half turn.
    TurnStep,
}

impl ActionCode {
    /// The code of a displacement; one longer than `step_mm` is clamped.
    #[must_use]
    pub fn encode(self, move_mm: Displacement, step_mm: u16) -> [Weight; 2] {
        let part = |mm: i32| {
            let scaled = mm.clamp(-65_535, 65_535).wrapping_mul(i32::from(ONE_BITS));
            unit_weight(crate::fixed::div_round(scaled, i32::from(step_mm.max(1))))
        };
        match self {
            Self::Displacement => [
                part(i32::from(move_mm.dx_mm)),
                part(i32::from(move_mm.dy_mm)),
            ],
            Self::TurnStep => [
                unit_weight(i32::from(move_mm.bearing().as_signed_turns()) >> 2),
                part(i32::from(move_mm.length_mm())),
            ],
        }
    }

    /// The displacement of a code.
    #[must_use]
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

/// How the map is probed with a change of situation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recall {
    /// The neuron whose change is nearest (squared distance): the literal reading of the paper.
    Distance,
    /// The neuron whose change points the same way (dot product over its length).
    Direction,
    /// The neuron whose change goes farthest that way (dot product).
    Projection,
}

/// One thing to learn: this action brought this change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effect<const SENSORS: usize> {
    /// Situation after less situation before.
    pub change: [Weight; SENSORS],
    /// Code of the action.
    pub action: [Weight; 2],
    /// Transducers believed before and after.
    pub mask: Mask,
}

/// A map of (change of situation, action).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ActionMap<const NEURONS: usize, const SENSORS: usize> {
    changes: Som<NEURONS, SENSORS>,
    actions: Som<NEURONS, 2>,
}

impl<const NEURONS: usize, const SENSORS: usize> ActionMap<NEURONS, SENSORS> {
    /// A map with these code vectors.
    #[must_use]
    pub fn new(
        grid: Grid,
        changes: [[Weight; SENSORS]; NEURONS],
        actions: [[Weight; 2]; NEURONS],
    ) -> Self {
        Self {
            changes: Som::new(grid, changes),
            actions: Som::new(grid, actions),
        }
    }

    /// The changes of situation, as a map.
    #[must_use]
    pub const fn changes(&self) -> &Som<NEURONS, SENSORS> {
        &self.changes
    }

    /// The actions, as a map.
    #[must_use]
    pub const fn actions(&self) -> &Som<NEURONS, 2> {
        &self.actions
    }

    /// The best-matching unit of an effect; `action_weight_q8` is λ in 1/256.
    #[inline]
    #[must_use]
    pub fn winner(&self, effect: &Effect<SENSORS>, action_weight_q8: u16) -> usize {
        let mut scores = self.changes.scores_masked(&effect.change, effect.mask);
        let by_action = self.actions.scores(&effect.action);
        for (score, action) in scores.iter_mut().zip(by_action) {
            let weighted = action.wrapping_mul(i64::from(action_weight_q8));
            *score = score.wrapping_mul(256).wrapping_add(weighted);
        }
        kernels::least(&scores)
    }

    /// One step of learning around `winner`.
    #[inline]
    pub fn learn(&mut self, winner: usize, effect: &Effect<SENSORS>, pull: &Pull<NEURONS>) {
        self.changes
            .learn(winner, &effect.change, effect.mask, pull);
        self.actions.learn(winner, &effect.action, Mask::ALL, pull);
    }

    /// The neuron that answers a wanted change, among those `allowed` counts (all of them where it counts none).
    #[must_use]
    pub fn recall(
        &self,
        wanted: &[Weight; SENSORS],
        mask: Mask,
        recall: Recall,
        allowed: Mask,
    ) -> usize {
        let scores = match recall {
            Recall::Distance => self
                .changes
                .scores_masked(wanted, mask)
                .map(|score| score.saturating_neg()),
            Recall::Direction => self.changes.alignments(&stretched(wanted), mask),
            Recall::Projection => self.changes.projections(wanted, mask),
        };
        kernels::greatest(&scores, allowed)
    }
}

/// The vector scaled so that its largest component is about 1: short probes keep their direction's precision.
fn stretched<const SENSORS: usize>(vector: &[Weight; SENSORS]) -> [Weight; SENSORS] {
    let largest = vector
        .iter()
        .map(|w| i32::from(w.to_bits()).abs())
        .max()
        .unwrap_or(0);
    if largest == 0 {
        return *vector;
    }
    let factor = (i32::from(ONE_BITS) << 13) / largest;
    vector.map(|w| {
        let scaled = (i64::from(w.to_bits()) * i64::from(factor)) >> 13;
        unit_weight(scaled as i32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHANGES: [[i16; 3]; 3] = [[800, 0, 0], [0, 8_192, 0], [4_000, 100, 0]];
    const ACTIONS: [[i16; 2]; 3] = [[8_192, 0], [0, 8_192], [-8_192, 0]];

    fn map() -> ActionMap<3, 3> {
        ActionMap::new(
            Grid::chain(3),
            CHANGES.map(|row| row.map(Weight::from_bits)),
            ACTIONS.map(|row| row.map(Weight::from_bits)),
        )
    }

    #[test]
    fn the_three_recalls_differ_as_described() {
        let wanted = [1_000, 0, 0].map(Weight::from_bits);
        let recall = |recall| map().recall(&wanted, Mask::ALL, recall, Mask::ALL);
        assert_eq!(
            (recall(Recall::Distance), recall(Recall::Direction)),
            (0, 0)
        );
        assert_eq!(recall(Recall::Projection), 2);
    }

    #[test]
    fn inhibited_neurons_do_not_answer_unless_all_are() {
        let wanted = [1_000, 0, 0].map(Weight::from_bits);
        let without = |mask| map().recall(&wanted, Mask::ALL, Recall::Direction, mask);
        assert_eq!(without(Mask::ALL.without(0)), 2);
        assert_eq!(without(Mask::from_bits(0)), 0);
    }

    #[test]
    fn a_masked_component_does_not_count() {
        let wanted = [1_000, 8_192, 0].map(Weight::from_bits);
        assert_eq!(
            map().recall(&wanted, Mask::ALL, Recall::Direction, Mask::ALL),
            1
        );
        assert_ne!(
            map().recall(&wanted, Mask::ALL.without(1), Recall::Direction, Mask::ALL),
            1
        );
    }

    #[test]
    fn the_action_decides_when_its_weight_is_high() {
        let effect = Effect {
            change: CHANGES[0].map(Weight::from_bits),
            action: ACTIONS[2].map(Weight::from_bits),
            mask: Mask::ALL,
        };
        assert_eq!(map().winner(&effect, 0), 0);
        assert_eq!(map().winner(&effect, 2_560), 2);
    }

    #[test]
    fn actions_come_back_from_their_code() {
        for code in [ActionCode::Displacement, ActionCode::TurnStep] {
            for (dx_mm, dy_mm) in [(250, 0), (-100, 90), (0, -250), (-170, -170), (3, 1)] {
                let original = Displacement { dx_mm, dy_mm };
                let back = code.decode(code.encode(original, 250), 250);
                assert!(
                    back.minus(original).length_mm() <= 2,
                    "{code:?} {original:?} {back:?}"
                );
            }
        }
    }
}
