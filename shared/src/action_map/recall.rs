//! Probing the action map with a change of situation.

use super::ActionMap;
use crate::fixed::{
    Mask, ONE_BITS, Weight, isqrt, quotient, squared_norm, to_weight16, unit_weight,
};
use serde::{Deserialize, Serialize};

/// How the map is probed with a change of situation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Recall {
    /// The neuron whose change is nearest (squared distance): the literal reading of the paper.
    Distance,
    /// The neuron whose change points the same way: dot product over its length plus the map's mean
    /// length, so that a change too short to have a direction does not answer.
    Direction,
    /// The neuron whose change goes farthest that way (dot product).
    Projection,
}

impl<const NEURONS: usize, const SENSORS: usize> ActionMap<NEURONS, SENSORS> {
    /// What the map answers to a wanted change: the best neuron among those `allowed` counts (among
    /// all where it counts none), and the action of it and of all of them together.
    #[must_use]
    pub fn recall(
        &self,
        wanted: &[Weight; SENSORS],
        mask: Mask,
        probe: Probe,
        allowed: Mask,
    ) -> Answer {
        let mut found = Match::none();
        self.matches(wanted, mask, probe, allowed, &mut found);
        Answer {
            neuron: found.neuron,
            alone: self.actions.code_vector(found.neuron),
            together: self.together(&found, allowed),
        }
    }

    /// The best neuron for a wanted change among those `allowed` counts, and how well each neuron
    /// matches; into room lent for it, as the scores are many to copy.
    #[inline(never)]
    pub(crate) fn matches(
        &self,
        wanted: &[Weight; SENSORS],
        mask: Mask,
        probe: Probe,
        allowed: Mask,
        found: &mut Match<NEURONS>,
    ) {
        found.scores = None;
        match probe.recall {
            Recall::Distance => {
                let scores = self.changes.scores(wanted, mask);
                found.scores = Some(scores.map(i64::saturating_neg));
            }
            // Nothing wanted: no neuron points that way more than another.
            Recall::Direction if is_zero(wanted) => {}
            Recall::Direction => {
                found.scores = Some(self.changes.alignments(&stretched(wanted), mask));
            }
            Recall::Projection => found.scores = Some(self.changes.projections(wanted, mask)),
        }
        found.neuron = match (probe.preference, &found.scores) {
            (Some(preference), scores) => {
                let scores = scores.as_ref().unwrap_or(&[0; NEURONS]);
                greatest(&self.preferring(scores, wanted, preference), allowed)
            }
            (None, Some(scores)) => greatest(scores, allowed),
            (None, None) => (0..NEURONS).find(|k| allowed.contains(*k)).unwrap_or(0),
        };
    }

    /// The scores plus the weighted cosine of the neurons' actions with the preferred one.
    #[inline(never)]
    fn preferring(
        &self,
        scores: &[i64; NEURONS],
        wanted: &[Weight; SENSORS],
        preference: Preference,
    ) -> [i64; NEURONS] {
        let length = |vector: &[Weight]| i64::from(isqrt(squared_norm(vector).unsigned_abs()));
        let preferred = length(&preference.code);
        let factor = length(&stretched(wanted)).wrapping_mul(i64::from(preference.weight_q8));
        let along = self.actions.alignments(&preference.code, Mask::ALL);
        let mut sums = *scores;
        for (sum, along) in sums.iter_mut().zip(along) {
            let bonus = factor
                .wrapping_mul(along)
                .checked_div(preferred)
                .unwrap_or(0);
            *sum = sum.wrapping_mul(256).wrapping_add(bonus);
        }
        sums
    }

    /// The mean of the neurons' actions, weighted with the fourth power of their scores; neurons
    /// with a score below 0, or that `allowed` does not count, have no part in it. Zero where none
    /// has.
    #[inline(never)]
    pub(crate) fn together(&self, found: &Match<NEURONS>, allowed: Mask) -> [Weight; 2] {
        let Some(scores) = &found.scores else {
            return [Weight::ZERO; 2];
        };
        // What is not counted is 0; a score above 0 is a sum of at most 31 products and fits.
        let (mut counted, mut best) = ([0_u32; NEURONS], 1_u32);
        for (k, (counted, score)) in counted.iter_mut().zip(scores).enumerate() {
            if *score > 0 && allowed.contains(k) {
                *counted = *score as u32;
                best = best.max(*counted);
            }
        }
        // At most 2¹⁰ times 2¹³ per neuron.
        let (mut sum, mut total) = ([0_i32; 2], 0_i32);
        for (counted, action) in counted.iter().zip(self.actions.code()) {
            if *counted == 0 {
                continue;
            }
            // The score over the best one's, Q10: its fourth power takes 20 bits before the last
            // shift.
            let share = match counted.checked_mul(1 << 10) {
                Some(scaled) => scaled.checked_div(best).unwrap_or(0),
                None => quotient(i64::from(*counted) << 10, i64::from(best)) as u32,
            } as i32;
            let squared = (share * share) >> 10;
            let weight = (squared * squared) >> 10;
            total = total.wrapping_add(weight);
            for (sum, part) in sum.iter_mut().zip(action) {
                let part = i32::from(to_weight16(*part).to_bits());
                *sum = sum.wrapping_add(weight * part);
            }
        }
        sum.map(|sum| unit_weight(sum.checked_div(total).unwrap_or(0)))
    }
}

/// How well the neurons match a wanted change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Match<const NEURONS: usize> {
    /// The best neuron.
    pub(crate) neuron: usize,
    /// The greater, the better; `None` = nothing is wanted.
    scores: Option<[i64; NEURONS]>,
}

impl<const NEURONS: usize> Match<NEURONS> {
    /// Nothing has been asked yet. Made on the spot: a constant would be copied with all its room.
    pub(crate) const fn none() -> Self {
        Self {
            neuron: 0,
            scores: None,
        }
    }
}

/// How to probe the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Probe {
    /// What a good match is.
    pub recall: Recall,
    /// An action to prefer among good matches.
    pub preference: Option<Preference>,
}

/// What the map answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer {
    /// The best neuron.
    pub neuron: usize,
    /// Code of its action.
    pub alone: [Weight; 2],
    /// Code of the action of all neurons, weighted by how well they match; zero where none does.
    pub together: [Weight; 2],
}

/// An action that is preferred where several would do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preference {
    /// Code of the action.
    pub code: [Weight; 2],
    /// Weight of its match beside that of the change, in 1/256.
    pub weight_q8: u16,
}

/// Whether all components are 0, without a branch for each.
fn is_zero<const SENSORS: usize>(vector: &[Weight; SENSORS]) -> bool {
    let none = |few: &[Weight]| few.iter().fold(0, |bits, w| bits | w.to_bits()) == 0;
    let (fours, rest) = vector.as_chunks::<4>();
    fours.iter().all(|four| none(four)) && none(rest)
}

/// The vector scaled so that its largest component is about 1: short probes keep their direction's
/// precision.
pub(super) fn stretched<const SENSORS: usize>(vector: &[Weight; SENSORS]) -> [Weight; SENSORS] {
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

/// Index of the greatest score among the neurons in `allowed`, the lowest on ties; among all where
/// it holds none.
fn greatest(scores: &[i64], allowed: Mask) -> usize {
    let mut best: Option<(usize, i64)> = None;
    for (index, &score) in scores.iter().enumerate() {
        if allowed.contains(index) && best.is_none_or(|(_, least)| score > least) {
            best = Some((index, score));
        }
    }
    match best {
        Some((index, _)) => index,
        None if allowed == Mask::ALL => 0,
        None => greatest(scores, Mask::ALL),
    }
}
