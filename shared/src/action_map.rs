//! The second map of the paper: which action brings which change of situation.
//!
//! A neuron holds a change of situation Δ and an action side by side: two codebooks over one grid. Learning finds the
//! winner by both parts, |Δ − Δ_k|² + λ |a − a_k|²; recall probes with the change alone.

use crate::fixed::{
    Mask, ONE_BITS, Weight, Weight32, isqrt, quotient, squared_norm, to_weight16, unit_weight,
};
use crate::som::kernels::{Found, Kernels};
use crate::som::neighborhood::Update;
use crate::som::{Grid, Som, kernels};
use crate::units::{Bearing, Displacement};
use serde::{Deserialize, Serialize};

/// How an action stands in the map, as two components in [−1, 1].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
    #[inline(never)]
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

/// How the map is probed with a change of situation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Recall {
    /// The neuron whose change is nearest (squared distance): the literal reading of the paper.
    Distance,
    /// The neuron whose change points the same way: dot product over its length plus the map's mean length, so that a
    /// change too short to have a direction does not answer.
    Direction,
    /// The neuron whose change goes farthest that way (dot product).
    Projection,
}

/// From this weight on, in 1/256, a squared length with the weighted score of an action might not fit 32 bits.
const MAX_BASE_WEIGHT_Q8: u16 = 512;

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
#[derive(Debug, Clone)]
pub struct ActionMap<const NEURONS: usize, const SENSORS: usize> {
    changes: Som<NEURONS, SENSORS>,
    actions: Som<NEURONS, 2>,
    /// Of the code vectors as they are; `None` = to be summed again.
    products: Option<Products<SENSORS>>,
}

/// The code vectors alone: the products follow from them.
impl<const NEURONS: usize, const SENSORS: usize> PartialEq for ActionMap<NEURONS, SENSORS> {
    fn eq(&self, other: &Self) -> bool {
        self.changes == other.changes && self.actions == other.actions
    }
}

impl<const NEURONS: usize, const SENSORS: usize> Eq for ActionMap<NEURONS, SENSORS> {}

/// Sums over all neurons of a map, at most 31, in units of 2⁻²⁶. A decision needs all of them, and what is learned from a
/// move changes one neuron's part: kept, they are worth 6 000 instructions of a decision on the chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Products<const SENSORS: usize> {
    /// Of the actions' components: x x, x y, y y.
    pub(crate) plane: [i32; 3],
    /// Of each transducer's change with x and with y.
    pub(crate) changes: [[i32; 2]; SENSORS],
}

impl<const SENSORS: usize> Products<SENSORS> {
    const NONE: Self = Self {
        plane: [0; 3],
        changes: [[0; 2]; SENSORS],
    };

    /// Adds a neuron's part, or takes it away.
    #[inline(never)]
    fn count(&mut self, action: &[Weight32; 2], change: &[Weight32; SENSORS], sign: i32) {
        let bits = |part: &Weight32| i32::from(to_weight16(*part).to_bits());
        let [x, y] = action;
        let (x, y) = (bits(x), bits(y));
        let (signed_x, signed_y) = (x.wrapping_mul(sign), y.wrapping_mul(sign));
        let [xx, xy, yy] = &mut self.plane;
        *xx = xx.wrapping_add(signed_x.wrapping_mul(x));
        *xy = xy.wrapping_add(signed_x.wrapping_mul(y));
        *yy = yy.wrapping_add(signed_y.wrapping_mul(y));
        for ([along_x, along_y], change) in self.changes.iter_mut().zip(change) {
            let change = i32::from(to_weight16(*change).to_bits());
            *along_x = along_x.wrapping_add(signed_x.wrapping_mul(change));
            *along_y = along_y.wrapping_add(signed_y.wrapping_mul(change));
        }
    }
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
            products: None,
        }
    }

    /// A map whose code vectors are all zero.
    #[must_use]
    pub const fn zeroed(grid: Grid) -> Self {
        Self {
            changes: Som::zeroed(grid),
            actions: Som::zeroed(grid),
            products: None,
        }
    }

    /// The changes of situation, to be written.
    pub(crate) const fn changes_mut(&mut self) -> &mut Som<NEURONS, SENSORS> {
        self.products = None;
        &mut self.changes
    }

    /// The actions, to be written.
    pub(crate) const fn actions_mut(&mut self) -> &mut Som<NEURONS, 2> {
        self.products = None;
        &mut self.actions
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

    /// Has the processor's own kernels do what they can: see [`Som::use_kernels`].
    pub const fn use_kernels(&mut self, kernels: &'static Kernels) {
        self.changes.use_kernels(kernels);
    }

    /// The best-matching unit of an effect; `action_weight_q8` is λ in 1/256.
    #[inline(never)]
    #[must_use]
    pub fn winner(&self, effect: &Effect<SENSORS>, action_weight_q8: u16) -> usize {
        self.search(effect, action_weight_q8)
    }

    fn search(&self, effect: &Effect<SENSORS>, action_weight_q8: u16) -> usize {
        let own = kernels::rank_margin::<2>(action_weight_q8);
        let margin = Som::<NEURONS, SENSORS>::MARGIN.wrapping_add(own);
        let by_hand = self.candidates_simd(effect, action_weight_q8, margin);
        let portably = || Found::among(self.candidates(effect, action_weight_q8, margin));
        match by_hand.unwrap_or_else(portably) {
            Found::One(neuron) => neuron,
            Found::Rivals(candidates) => self.nearest_of(candidates, effect, action_weight_q8),
        }
    }

    /// By the processor's kernels, if there are any for this size, the neurons that may be nearest.
    fn candidates_simd(
        &self,
        effect: &Effect<SENSORS>,
        weight_q8: u16,
        margin: i32,
    ) -> Option<Found> {
        if !effect.mask.covers(SENSORS) || weight_q8 >= MAX_BASE_WEIGHT_Q8 {
            return None;
        }
        let kernels = self.changes.kernels()?;
        let mut bases = *self.changes.norms();
        self.actions
            .weigh_simd(kernels, effect.action, weight_q8, &mut bases)?;
        self.changes.candidates_simd(&bases, &effect.change, margin)
    }

    #[inline(never)]
    fn candidates(&self, effect: &Effect<SENSORS>, weight_q8: u16, margin: i32) -> Mask {
        let mut ranks = self.changes.ranks(&effect.change, effect.mask);
        if effect.mask.covers(SENSORS) {
            self.actions
                .rank_weighted(&effect.action, weight_q8, &mut ranks);
        }
        let halves = Som::<NEURONS, SENSORS>::HALVES_MARGIN;
        kernels::candidates(&ranks, margin.wrapping_add(halves))
    }

    #[inline(never)]
    fn nearest_of(&self, candidates: Mask, effect: &Effect<SENSORS>, weight_q8: u16) -> usize {
        kernels::nearest_of(candidates, |k| {
            let change = self.changes.distance(k, &effect.change, effect.mask);
            let action = self.actions.distance(k, &effect.action, Mask::ALL);
            // Rounded before it is weighted: at most 2^45 times 2^16.
            change.saturating_add((action >> 8).saturating_mul(u64::from(weight_q8)))
        })
    }

    /// Sums the products unless they are known; maps of more than 31 neurons do without.
    pub(crate) fn keep_products(&mut self) {
        if self.products.is_none() && NEURONS <= 31 {
            let products = self.products.insert(Products::NONE);
            for (action, change) in self.actions.code().iter().zip(self.changes.code()) {
                products.count(action, change, 1);
            }
        }
    }

    /// The products, if they are known.
    pub(crate) const fn products(&self) -> Option<&Products<SENSORS>> {
        self.products.as_ref()
    }

    fn count_products(&mut self, neuron: usize, sign: i32) {
        let code = (
            self.actions.code().get(neuron),
            self.changes.code().get(neuron),
        );
        if let (Some(products), (Some(action), Some(change))) = (&mut self.products, code) {
            products.count(action, change, sign);
        }
    }

    /// As [`learn`](Self::learn), the products kept where the winner learns alone.
    pub(crate) fn learn_on(
        &mut self,
        winner: usize,
        effect: &Effect<SENSORS>,
        pull: &Update<NEURONS>,
    ) {
        if !pull.is_alone() {
            return self.learn(winner, effect, pull);
        }
        self.count_products(winner, -1);
        self.pull(winner, effect, pull);
        self.count_products(winner, 1);
    }

    /// One step of learning around `winner`.
    pub fn learn(&mut self, winner: usize, effect: &Effect<SENSORS>, pull: &Update<NEURONS>) {
        self.forget_products();
        self.pull(winner, effect, pull);
    }

    /// Does without the products until they are summed again.
    pub(crate) const fn forget_products(&mut self) {
        self.products = None;
    }

    /// As [`learn`](Self::learn), the products left as they are.
    #[inline(never)]
    pub(crate) fn pull(&mut self, winner: usize, effect: &Effect<SENSORS>, pull: &Update<NEURONS>) {
        self.step(winner, effect, pull);
    }

    /// One step of learning around the best-matching unit, the products left as they are.
    #[inline(never)]
    pub(crate) fn teach(
        &mut self,
        effect: &Effect<SENSORS>,
        action_weight_q8: u16,
        pull: &Update<NEURONS>,
    ) {
        let winner = self.search(effect, action_weight_q8);
        self.step(winner, effect, pull);
    }

    fn step(&mut self, winner: usize, effect: &Effect<SENSORS>, pull: &Update<NEURONS>) {
        // Both codebooks stand on one grid.
        if let Some(groups) = self.changes.groups(winner, effect.mask, pull)
            && self.changes.pull_groups(&effect.change, &groups)
        {
            self.actions.pull_each(&effect.action, &groups);
        } else {
            self.pull_portably(winner, effect, pull);
        }
    }

    #[inline(never)]
    fn pull_portably(&mut self, winner: usize, effect: &Effect<SENSORS>, pull: &Update<NEURONS>) {
        let grid = self.changes.grid();
        pull.view().each(grid, winner, |k, gain| {
            self.changes.pull(k, &effect.change, effect.mask, gain);
            self.actions.pull(k, &effect.action, Mask::ALL, gain);
        });
    }

    /// What the map answers to a wanted change: the best neuron among those `allowed` counts (among all
    /// where it counts none), and the action of it and of all of them together.
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

    /// The best neuron for a wanted change among those `allowed` counts, and how well each neuron matches; into room lent
    /// for it, as the scores are many to copy.
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
                let scores = self.changes.scores_masked(wanted, mask);
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
                kernels::greatest(&self.preferring(scores, wanted, preference), allowed)
            }
            (None, Some(scores)) => kernels::greatest(scores, allowed),
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

    /// The mean of the neurons' actions, weighted with the fourth power of their scores; neurons with a
    /// score below 0, or that `allowed` does not count, have no part in it. Zero where none has.
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
            // The score over the best one's, Q10: its fourth power takes 20 bits before the last shift.
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
    use crate::som::Neighborhood;
    use proptest::prelude::*;

    const CHANGES: [[i16; 3]; 4] = [[800, 0, 0], [0, 8_192, 0], [6_000, 0, 0], [7_000, 8_000, 0]];
    const ACTIONS: [[i16; 2]; 4] = [[8_192, 0], [0, 8_192], [-8_192, 0], [0, -8_192]];

    fn map() -> ActionMap<4, 3> {
        ActionMap::new(
            Grid::chain(4),
            CHANGES.map(|row| row.map(Weight::from_bits)),
            ACTIONS.map(|row| row.map(Weight::from_bits)),
        )
    }

    fn answer(wanted: [i16; 3], recall: Recall, mask: Mask, allowed: Mask) -> Answer {
        let probe = Probe {
            recall,
            preference: None,
        };
        map().recall(&wanted.map(Weight::from_bits), mask, probe, allowed)
    }

    #[test]
    fn maps_differ_by_either_half_of_a_code_vector() {
        let with = |change, action| {
            let (mut changes, mut actions) = (CHANGES, ACTIONS);
            (changes[3][2], actions[3][0]) = (change, action);
            let weights = |row: [i16; 2]| row.map(Weight::from_bits);
            let changes = changes.map(|row| row.map(Weight::from_bits));
            ActionMap::new(Grid::chain(4), changes, actions.map(weights))
        };
        assert_eq!(with(0, 0), map());
        assert_ne!(with(1, 0), map());
        assert_ne!(with(0, 1), map());
    }

    #[test]
    fn the_three_recalls_differ_as_described() {
        let recall = |recall| answer([1_000, 0, 0], recall, Mask::ALL, Mask::ALL).neuron;
        assert_eq!(recall(Recall::Distance), 0);
        assert_eq!(recall(Recall::Direction), 2);
        assert_eq!(recall(Recall::Projection), 3);
    }

    #[test]
    fn inhibited_neurons_do_not_answer_unless_all_are() {
        let without = |allowed| answer([1_000, 0, 0], Recall::Direction, Mask::ALL, allowed).neuron;
        assert_eq!(without(Mask::ALL.without(2)), 3);
        assert_eq!(without(Mask::NONE), 2);
    }

    #[test]
    fn a_masked_component_does_not_count() {
        let masked = |mask| answer([100, 8_192, 0], Recall::Direction, mask, Mask::ALL).neuron;
        assert_eq!(masked(Mask::ALL), 1);
        assert_ne!(masked(Mask::ALL.without(1)), 1);
    }

    #[test]
    fn together_the_better_matches_count_more() {
        let together = |wanted, allowed| {
            answer(wanted, Recall::Direction, Mask::ALL, allowed)
                .together
                .map(|w| w.to_num::<f64>())
        };
        // N3 matches best, N1 and N2 in part.
        let [x, y] = together([1_000, 1_000, 0], Mask::ALL);
        assert!(y < -0.5 && x.abs() < 0.2, "{x} {y}");
        let [x, y] = together([1_000, 1_000, 0], Mask::ALL.without(3));
        assert!(x < -0.1 && y > 0.1, "{x} {y}");
        assert_eq!(together([-1_000, -1_000, 0], Mask::ALL), [0.0; 2]);
        assert_eq!(together([0; 3], Mask::ALL), [0.0; 2]);
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
        let recall = |preferred: Option<usize>| {
            let preference = preferred.map(|k| Preference {
                code: ACTIONS[k].map(Weight::from_bits),
                weight_q8: 26,
            });
            let probe = Probe {
                recall: Recall::Direction,
                preference,
            };
            map.recall(&wanted, Mask::ALL, probe, Mask::ALL).neuron
        };
        assert_eq!((recall(None), recall(Some(1)), recall(Some(2))), (0, 1, 2));
        // A preference is no match: the neuron without the wanted change does not answer.
        assert_ne!(recall(Some(3)), 3);
    }

    #[test]
    fn products_kept_while_learning_are_those_summed_anew() {
        let mut map = map();
        map.keep_products();
        let alone = Update::new(Neighborhood::Direct, 20_000, 0);
        for (winner, (change, action)) in CHANGES.iter().zip(ACTIONS).enumerate() {
            let effect = Effect {
                change: change.map(|bits| Weight::from_bits(bits / 3 - 500)),
                action: action.map(Weight::from_bits),
                mask: Mask::ALL.without(winner),
            };
            map.learn_on((winner + 1) % 4, &effect, &alone);
            let kept = *map.products().unwrap();
            map.forget_products();
            map.keep_products();
            assert_eq!(map.products(), Some(&kept));
            assert_eq!(map.clone(), map);
        }
        // Neighbors that learn too, and whatever is written, make them unknown.
        let together = Update::new(Neighborhood::Direct, 20_000, 20_000);
        let effect = Effect {
            change: CHANGES[0].map(Weight::from_bits),
            action: ACTIONS[0].map(Weight::from_bits),
            mask: Mask::ALL,
        };
        map.learn_on(0, &effect, &together);
        assert_eq!(map.products(), None);
        map.keep_products();
        map.actions_mut().set_component(0, Weight32::from_bits(5));
        assert_eq!(map.products(), None);
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

    proptest! {
        /// Neurons a few units apart, weights of any size: ranks alone cannot tell.
        #[test]
        fn the_winner_is_nearest_in_full_precision(
            middle in prop::collection::vec(-8_100_i16..=8_100, 18), shifts in prop::collection::vec(-40_i32..=40, 16 * 18),
            probe in prop::collection::vec(-8_192_i16..=8_192, 18), weight in prop_oneof![0_u16..600, any::<u16>()],
        ) {
            let mut map = ActionMap::<16, 16>::zeroed(Grid::rectangle(4, 4));
            for (k, shifts) in shifts.chunks_exact(18).enumerate() {
                for (i, shift) in shifts.iter().enumerate() {
                    let value = Weight32::from_bits((i32::from(middle[i]) << 16) + shift * 30_001);
                    match i.checked_sub(16) {
                        None => map.changes_mut().set_component(k * 16 + i, value),
                        Some(i) => map.actions_mut().set_component(k * 2 + i, value),
                    }
                }
            }
            let part = |i: usize| Weight::from_bits(probe[i]);
            let effect = Effect {
                change: core::array::from_fn(part),
                action: [part(16), part(17)],
                mask: Mask::ALL,
            };
            let distance = |k: usize| {
                let action = map.actions().distance(k, &effect.action, Mask::ALL) >> 8;
                map.changes().distance(k, &effect.change, Mask::ALL) + action * u64::from(weight)
            };
            let nearest = (0..16).min_by_key(|&k| (distance(k), k));
            prop_assert_eq!(Some(map.winner(&effect, weight)), nearest);
        }
    }

    proptest! {
        /// Kernels are asked where the weight leaves them room and the whole ring is believed; answers and lessons are the same.
        #[test]
        fn kernels_for_the_processor_change_nothing(
            middle in prop::collection::vec(-8_000_i16..=8_000, 18), shifts in prop::collection::vec(-190_i32..=190, 16 * 18),
            probes in prop::collection::vec(-8_192_i16..=8_192, 3 * 18), weight in prop_oneof![Just(511_u16), Just(512), 0_u16..600],
            rate in 0_u32..=65_536, share in prop_oneof![Just(0_u32), 0_u32..=65_536], gaussian in any::<bool>(),
            mask in prop_oneof![Just(Mask::ALL), any::<u32>().prop_map(Mask::from_bits)],
        ) {
            let mut portable = ActionMap::<16, 16>::zeroed(Grid::rectangle(4, 4));
            for (k, shifts) in shifts.chunks_exact(18).enumerate() {
                for (i, shift) in shifts.iter().enumerate() {
                    let value = Weight32::from_bits((i32::from(middle[i]) + shift) << 16);
                    match i.checked_sub(16) {
                        None => portable.changes_mut().set_component(k * 16 + i, value),
                        Some(i) => portable.actions_mut().set_component(k * 2 + i, value),
                    }
                }
            }
            let mut map = portable.clone();
            map.use_kernels(&crate::som::tests::by_hand::KERNELS);
            let shape = if gaussian { Neighborhood::Gaussian } else { Neighborhood::Direct };
            let pull = Update::new(shape, rate, share);
            for probe in probes.as_chunks::<18>().0 {
                let part = |i: usize| Weight::from_bits(probe[i]);
                let effect = Effect { change: core::array::from_fn(part), action: [part(16), part(17)], mask };
                let winner = portable.winner(&effect, weight);
                prop_assert_eq!(map.winner(&effect, weight), winner);
                portable.learn(winner, &effect, &pull);
                map.learn(winner, &effect, &pull);
                prop_assert_eq!(&map, &portable);
            }
        }
    }

    #[test]
    fn kernels_are_asked_for_whole_rings_while_the_action_weighs_little() {
        use crate::som::tests::by_hand::{KERNELS, asked};
        let mut map = ActionMap::<16, 16>::zeroed(Grid::rectangle(4, 4));
        map.use_kernels(&KERNELS);
        let effect = |mask| Effect {
            change: [Weight::ONE; 16],
            action: [Weight::ONE; 2],
            mask,
        };
        asked();
        for (mask, weight, times) in [
            (Mask::ALL, 511, 1),
            (Mask::ALL, 512, 0),
            (Mask::ALL.without(2), 256, 0),
        ] {
            let _ = map.winner(&effect(mask), weight);
            assert_eq!(asked(), [times, times, 0, 0], "{weight}");
        }
        let pull = Update::new(Neighborhood::Direct, 20_000, 0);
        map.learn(0, &effect(Mask::ALL), &pull);
        assert_eq!(asked(), [0, 0, 1, 0]);
    }

    #[test]
    fn a_short_probe_is_stretched_to_its_direction() {
        let stretch = |bits: [i16; 3]| stretched(&bits.map(Weight::from_bits)).map(Weight::to_bits);
        assert_eq!(stretch([0; 3]), [0; 3]);
        assert_eq!(stretch([2, -1, 0]), [8_192, -4_096, 0]);
        assert_eq!(stretch([-4_096, 1_024, 8]), [-8_192, 2_048, 16]);
    }

    #[test]
    fn codes_are_shares_of_the_longest_step_or_turn_and_share() {
        let bits = |code: ActionCode, dx_mm, dy_mm| {
            code.encode(Displacement { dx_mm, dy_mm }, 200)
                .map(Weight::to_bits)
        };
        assert_eq!(bits(ActionCode::Displacement, 100, -50), [4_096, -2_048]);
        assert_eq!(
            bits(ActionCode::Displacement, 201, -32_000),
            [8_192, -8_192]
        );
        // Half a turn is one.
        assert_eq!(bits(ActionCode::TurnStep, 100, 0), [0, 4_096]);
        let [turn, length] = bits(ActionCode::TurnStep, 0, 200);
        assert!((turn - 4_096).abs() < 8 && length == 8_192, "{turn}");
        let back = |code: ActionCode, bits: [i16; 2]| code.decode(bits.map(Weight::from_bits), 200);
        assert_eq!(
            back(ActionCode::Displacement, [4_096, -21]),
            Displacement {
                dx_mm: 100,
                dy_mm: -1
            }
        );
        // To the nearest: 21 shares of 200 mm are 0.51 mm, 20 are 0.49 mm.
        for (share, mm) in [(21, 1), (20, 0), (-20, 0), (-21, -1)] {
            assert_eq!(back(ActionCode::Displacement, [share, 0]).dx_mm, mm);
        }
        // A length below nothing is none.
        assert_eq!(
            back(ActionCode::TurnStep, [4_096, -100]),
            Displacement::ZERO
        );
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
