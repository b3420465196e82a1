//! Recall: probes the action map with a wanted change of situation.

use super::ActionMap;
use crate::fixed::{
    Mask, ONE_BITS, Selection, Weight, isqrt, quotient, squared_norm, to_weight16, unit_weight,
};
use serde::{Deserialize, Serialize};

/// Similarity measure of the recall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Recall {
    /// Squared distance of the changes: the literal reading of the paper.
    Distance,
    /// Direction of the changes: dot product divided by the neuron's length plus the map's mean
    /// length. The mean excludes changes that are too short to have a direction.
    Direction,
    /// Dot product of the changes.
    Projection,
}

impl<const NEURONS: usize, const SENSORS: usize> ActionMap<NEURONS, SENSORS> {
    /// Recalls the action for a wanted change: the best neuron in `allowed`, its action, and the
    /// weighted mean action. If `allowed` is empty, all neurons are candidates.
    #[must_use]
    pub fn recall(
        &self,
        wanted: &[Weight; SENSORS],
        mask: Mask,
        probe: Probe,
        allowed: impl Selection,
    ) -> Answer {
        let mut found = Match::none();
        self.matches(wanted, mask, probe, allowed, &mut found);
        Answer {
            neuron: found.neuron,
            alone: self.actions.code_vector(found.neuron),
            together: self.together(&found, allowed),
        }
    }

    /// Finds the best neuron in `allowed` for a wanted change and the score of each neuron. Writes
    /// to `found` because returning the scores would copy them.
    #[inline(never)]
    pub(crate) fn matches(
        &self,
        wanted: &[Weight; SENSORS],
        mask: Mask,
        probe: Probe,
        allowed: impl Selection,
        found: &mut Match<NEURONS>,
    ) {
        found.scores = None;
        match probe.recall {
            Recall::Distance => {
                let scores = self.changes.scores(wanted, mask);
                found.scores = Some(scores.map(i64::saturating_neg));
            }
            // A zero change has no direction, so there are no scores.
            Recall::Direction if is_zero(wanted) => {}
            Recall::Direction => {
                found.scores = Some(self.changes.alignments(&scaled_to_unit(wanted), mask));
            }
            Recall::Projection => found.scores = Some(self.changes.projections(wanted, mask)),
        }
        found.neuron = match (probe.preference, &found.scores) {
            (Some(preference), scores) => {
                let scores = scores.as_ref().unwrap_or(&[0; NEURONS]);
                argmax(
                    &self.scores_with_preference(scores, wanted, preference),
                    allowed,
                )
            }
            (None, Some(scores)) => argmax(scores, allowed),
            (None, None) => (0..NEURONS).find(|k| allowed.contains(*k)).unwrap_or(0),
        };
    }

    /// The scores plus the weighted cosine between each neuron's action and the preferred one.
    #[inline(never)]
    fn scores_with_preference(
        &self,
        scores: &[i64; NEURONS],
        wanted: &[Weight; SENSORS],
        preference: Preference,
    ) -> [i64; NEURONS] {
        let length = |vector: &[Weight]| i64::from(isqrt(squared_norm(vector).unsigned_abs()));
        let preferred = length(&preference.code);
        let factor = length(&scaled_to_unit(wanted)).wrapping_mul(i64::from(preference.weight_q8));
        let similarities = self.actions.alignments(&preference.code, Mask::ALL);
        let mut sums = *scores;
        for (sum, similarity) in sums.iter_mut().zip(similarities) {
            let bonus = factor
                .wrapping_mul(similarity)
                .checked_div(preferred)
                .unwrap_or(0);
            *sum = sum.wrapping_mul(256).wrapping_add(bonus);
        }
        sums
    }

    /// Mean of the neurons' actions, weighted by the fourth power of their scores. Neurons with a
    /// score of 0 or less, or outside `allowed`, have weight 0. Zero if all have.
    #[inline(never)]
    pub(crate) fn together(&self, found: &Match<NEURONS>, allowed: impl Selection) -> [Weight; 2] {
        let Some(scores) = &found.scores else {
            return [Weight::ZERO; 2];
        };
        // A positive score is a sum of at most 31 products, so it fits 32 bits.
        let (mut positive_scores, mut best) = ([0_u32; NEURONS], 1_u32);
        for (k, (positive, score)) in positive_scores.iter_mut().zip(scores).enumerate() {
            if *score > 0 && allowed.contains(k) {
                *positive = *score as u32;
                best = best.max(*positive);
            }
        }
        // A neuron adds at most 2¹⁰ · 2¹³.
        let (mut sum, mut total) = ([0_i32; 2], 0_i32);
        for (score, action) in positive_scores.iter().zip(self.actions.code()) {
            if *score == 0 {
                continue;
            }
            // Score divided by the best score, Q10; its fourth power has 20 bits before the last
            // shift.
            let share = match score.checked_mul(1 << 10) {
                Some(scaled) => scaled.checked_div(best).unwrap_or(0),
                None => quotient(i64::from(*score) << 10, i64::from(best)) as u32,
            } as i32;
            let squared = (share * share) >> 10;
            let weight = (squared * squared) >> 10;
            total = total.wrapping_add(weight);
            for (sum, component) in sum.iter_mut().zip(action) {
                let component = i32::from(to_weight16(*component).to_bits());
                *sum = sum.wrapping_add(weight * component);
            }
        }
        sum.map(|sum| unit_weight(sum.checked_div(total).unwrap_or(0)))
    }
}

/// Result of a search for a wanted change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Match<const NEURONS: usize> {
    /// The best neuron.
    pub(crate) neuron: usize,
    /// Score of each neuron, higher is better; `None` = the wanted change is zero.
    scores: Option<[i64; NEURONS]>,
}

impl<const NEURONS: usize> Match<NEURONS> {
    /// The value before a search. A function because a constant would be copied in full.
    pub(crate) const fn none() -> Self {
        Self {
            neuron: 0,
            scores: None,
        }
    }
}

/// Parameters of a recall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Probe {
    /// Similarity measure.
    pub recall: Recall,
    /// An action to prefer among good matches.
    pub preference: Option<Preference>,
}

/// Recalled actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    /// The best neuron.
    pub neuron: usize,
    /// Code of its action.
    pub alone: [Weight; 2],
    /// Code of the mean action of all neurons, weighted by their scores; zero if none matches.
    pub together: [Weight; 2],
}

/// An action that is preferred among similar scores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preference {
    /// Code of the action.
    pub code: [Weight; 2],
    /// Weight of the action's similarity relative to that of the change, in 1/256.
    pub weight_q8: u16,
}

/// Whether all components are 0; branches once per four components.
fn is_zero<const SENSORS: usize>(vector: &[Weight; SENSORS]) -> bool {
    let part_is_zero = |part: &[Weight]| part.iter().fold(0, |bits, w| bits | w.to_bits()) == 0;
    let (fours, rest) = vector.as_chunks::<4>();
    fours.iter().all(|four| part_is_zero(four)) && part_is_zero(rest)
}

/// The vector scaled so that its largest component is about ±1. This keeps the precision of short
/// probes.
pub(super) fn scaled_to_unit<const SENSORS: usize>(
    vector: &[Weight; SENSORS],
) -> [Weight; SENSORS] {
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

/// Index of the highest score among the neurons in `allowed`, the lowest on ties. If `allowed` is
/// empty, all neurons are candidates.
fn argmax<S: Selection>(scores: &[i64], allowed: S) -> usize {
    let mut best: Option<(usize, i64)> = None;
    for (index, &score) in scores.iter().enumerate() {
        if allowed.contains(index) && best.is_none_or(|(_, highest)| score > highest) {
            best = Some((index, score));
        }
    }
    match best {
        Some((index, _)) => index,
        None if allowed == S::ALL => 0,
        None => argmax(scores, S::ALL),
    }
}
