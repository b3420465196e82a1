//! The second map of the paper: which action brings which change of situation.
//!
//! A neuron holds a change of situation Δ and an action side by side: two codebooks over one grid. Learning finds the
//! winner by both parts, |Δ − Δ_k|² + λ |a − a_k|²; recall probes with the change alone.

use crate::fixed::{Dither, Mask, ONE_BITS, Weight, isqrt, squared_norm, unit_weight};
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
    /// The neuron whose change points the same way: dot product over its length plus the map's mean length, so that a
    /// change too short to have a direction does not answer.
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
    pub fn learn(
        &mut self,
        winner: usize,
        effect: &Effect<SENSORS>,
        pull: &Pull<NEURONS>,
        dither: Dither,
    ) {
        self.changes
            .learn(winner, &effect.change, effect.mask, pull, dither);
        self.actions
            .learn(winner, &effect.action, Mask::ALL, pull, dither);
    }

    /// The neuron that answers a wanted change, among those `allowed` counts (all of them where it counts
    /// none).
    #[must_use]
    pub fn recall(
        &self,
        wanted: &[Weight; SENSORS],
        mask: Mask,
        recall: Recall,
        preference: Preference,
        allowed: Mask,
    ) -> usize {
        let scores = match recall {
            Recall::Distance => self
                .changes
                .scores_masked(wanted, mask)
                .map(i64::saturating_neg),
            Recall::Direction => self.by_direction(&stretched(wanted), mask, preference),
            Recall::Projection => self.changes.projections(wanted, mask),
        };
        kernels::greatest(&scores, allowed)
    }

    /// The action the map's neurons answer with together: the mean of their actions, weighted with
    /// the fourth power of the cosine between their change and the wanted one; neurons whose change
    /// points away, or that `allowed` does not count, have no part in it. Zero where none has.
    #[must_use]
    pub fn together(&self, wanted: &[Weight; SENSORS], mask: Mask, allowed: Mask) -> [Weight; 2] {
        let alignments =
            self.changes
                .alignments(&stretched(wanted), mask, self.changes.mean_length());
        let counted = |k: usize, alignment: i64| {
            if allowed.contains(k) {
                alignment.max(0)
            } else {
                0
            }
        };
        let values = alignments.iter().enumerate().map(|(k, a)| counted(k, *a));
        let best = values.max().unwrap_or(0).max(1);
        let (mut sum, mut total) = ([0_i64; 2], 0_i64);
        for (k, (alignment, action)) in alignments.iter().zip(self.actions.code()).enumerate() {
            // The cosine over the best one's, Q10: its fourth power is at most 2^40 before the shift.
            let share = counted(k, *alignment)
                .saturating_mul(1 << 10)
                .wrapping_div(best);
            let squared = share.wrapping_mul(share) >> 10;
            let weight = squared.wrapping_mul(squared) >> 10;
            total = total.wrapping_add(weight);
            for (sum, part) in sum.iter_mut().zip(action) {
                *sum = sum.wrapping_add(weight.wrapping_mul(i64::from(part.to_bits())));
            }
        }
        sum.map(|sum| unit_weight(sum.checked_div(total).unwrap_or(0) as i32))
    }

    /// Cosine of the changes with the wanted one plus the weighted cosine of the actions with the
    /// preferred one, times 256 and the length of `wanted`.
    fn by_direction(
        &self,
        wanted: &[Weight; SENSORS],
        mask: Mask,
        preference: Preference,
    ) -> [i64; NEURONS] {
        let mut scores = self
            .changes
            .alignments(wanted, mask, self.changes.mean_length())
            .map(|score| score.wrapping_mul(256));
        let preferred = i64::from(isqrt(squared_norm(&preference.code).unsigned_abs()));
        if preference.weight_q8 == 0 || preferred == 0 {
            return scores;
        }
        let length = i64::from(isqrt(squared_norm(wanted).unsigned_abs()));
        let factor = length.wrapping_mul(i64::from(preference.weight_q8));
        let along = self.actions.alignments(&preference.code, Mask::ALL, 0);
        for (score, along) in scores.iter_mut().zip(along) {
            *score = score.wrapping_add(
                factor
                    .wrapping_mul(along)
                    .checked_div(preferred)
                    .unwrap_or(0),
            );
        }
        scores
    }
}

/// An action that is preferred where several would do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preference {
    /// Code of the action.
    pub code: [Weight; 2],
    /// Weight of its cosine beside that of the change, in 1/256.
    pub weight_q8: u16,
}

impl Preference {
    /// No action is preferred.
    pub const NONE: Self = Self {
        code: [Weight::ZERO; 2],
        weight_q8: 0,
    };
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

    const CHANGES: [[i16; 3]; 4] = [[800, 0, 0], [0, 8_192, 0], [6_000, 0, 0], [7_000, 8_000, 0]];
    const ACTIONS: [[i16; 2]; 4] = [[8_192, 0], [0, 8_192], [-8_192, 0], [0, -8_192]];

    fn map() -> ActionMap<4, 3> {
        ActionMap::new(
            Grid::chain(4),
            CHANGES.map(|row| row.map(Weight::from_bits)),
            ACTIONS.map(|row| row.map(Weight::from_bits)),
        )
    }

    #[test]
    fn the_three_recalls_differ_as_described() {
        let wanted = [1_000, 0, 0].map(Weight::from_bits);
        let recall = |recall| map().recall(&wanted, Mask::ALL, recall, Preference::NONE, Mask::ALL);
        assert_eq!(recall(Recall::Distance), 0);
        assert_eq!(recall(Recall::Direction), 2);
        assert_eq!(recall(Recall::Projection), 3);
    }

    #[test]
    fn inhibited_neurons_do_not_answer_unless_all_are() {
        let wanted = [1_000, 0, 0].map(Weight::from_bits);
        let without = |mask| {
            map().recall(
                &wanted,
                Mask::ALL,
                Recall::Direction,
                Preference::NONE,
                mask,
            )
        };
        assert_eq!(without(Mask::ALL.without(2)), 3);
        assert_eq!(without(Mask::from_bits(0)), 2);
    }

    #[test]
    fn together_the_better_matches_count_more() {
        let wanted = [1_000, 1_000, 0].map(Weight::from_bits);
        let [x, y] = map()
            .together(&wanted, Mask::ALL, Mask::ALL)
            .map(|w| w.to_num::<f64>());
        // N3 matches best, N1 and N2 in part.
        assert!(y < -0.5 && x.abs() < 0.2, "{x} {y}");
        let [x, y] = map()
            .together(&wanted, Mask::ALL, Mask::ALL.without(3))
            .map(|w| w.to_num::<f64>());
        assert!(x < -0.1 && y > 0.1, "{x} {y}");
        let opposite = wanted.map(|w| -w);
        assert_eq!(
            map().together(&opposite, Mask::ALL, Mask::ALL),
            [Weight::ZERO; 2]
        );
    }

    #[test]
    fn a_preferred_action_breaks_a_tie() {
        let changes = [[4_000, 0, 0], [4_000, 0, 0], [4_000, 0, 0], [0, 0, 0]];
        let map = ActionMap::new(
            Grid::chain(4),
            changes.map(|row| row.map(Weight::from_bits)),
            ACTIONS.map(|row| row.map(Weight::from_bits)),
        );
        let wanted = [1_000, 0, 0].map(Weight::from_bits);
        let prefer = |k: usize| Preference {
            code: ACTIONS[k].map(Weight::from_bits),
            weight_q8: 26,
        };
        let recall = |p| map.recall(&wanted, Mask::ALL, Recall::Direction, p, Mask::ALL);
        assert_eq!(
            (
                recall(Preference::NONE),
                recall(prefer(1)),
                recall(prefer(2))
            ),
            (0, 1, 2)
        );
        // A preference is no match: the neuron without the wanted change does not answer.
        assert_ne!(recall(prefer(3)), 3);
    }

    #[test]
    fn a_masked_component_does_not_count() {
        let wanted = [100, 8_192, 0].map(Weight::from_bits);
        assert_eq!(
            map().recall(
                &wanted,
                Mask::ALL,
                Recall::Direction,
                Preference::NONE,
                Mask::ALL
            ),
            1
        );
        assert_ne!(
            map().recall(
                &wanted,
                Mask::ALL.without(1),
                Recall::Direction,
                Preference::NONE,
                Mask::ALL
            ),
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
