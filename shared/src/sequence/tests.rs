use super::*;
use crate::fixed::Weight;
use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::SplitMix64;
use std::boxed::Box;
use std::vec::Vec;

fn random<const N: usize>(seed: u64, count: usize) -> Vec<Pattern<N>> {
    let mut generator = SplitMix64::seed_from_u64(seed);
    let mut draw = || Pattern::from_bits(core::array::from_fn(|_| generator.next_u64() >> 63 == 1));
    (0..count).map(|_| draw()).collect()
}

/// Every fifth bit is turned around, beginning with `first`.
fn damaged<const N: usize>(pattern: &Pattern<N>, first: usize) -> Pattern<N> {
    let mut damaged = *pattern;
    (first..N).step_by(5).for_each(|bit| damaged.flip(bit));
    damaged
}

/// Hebb's rule in `f64`, from its formula: `w = Σ to·fromᵀ`; what follows is `shift` elements on.
fn reference_weights(sequence: &[Vec<f64>], shift: usize) -> Vec<Vec<f64>> {
    let last = sequence.len() - 1;
    let weight = |i: usize, j: usize| -> f64 {
        let pairs = (0..=last).map(|at| sequence[(at + shift).min(last)][i] * sequence[at][j]);
        pairs.sum()
    };
    let row = |i: usize| (0..64).map(|j| weight(i, j)).collect();
    (0..64).map(row).collect()
}

/// A step of recall in `f64`.
fn reference_step(weights: &[Vec<Vec<f64>>; 2], cue: &Pattern<64>) -> Pattern<64> {
    let mut state = reference_signs(cue);
    let field = |row: &[f64], state: &[f64], without: usize| -> f64 {
        let terms = row.iter().zip(state).enumerate();
        let others = terms.filter(|(j, _)| *j != without);
        others.map(|(_, (weight, bit))| weight * bit).sum()
    };
    let sign = |field: f64, bit: f64| if field == 0.0 { bit } else { field.signum() };
    let complete = |state: &mut Vec<f64>| {
        for _ in 0..MAX_ROUNDS {
            for i in 0..64 {
                state[i] = sign(field(&weights[0][i], state, i), state[i]);
            }
        }
    };
    complete(&mut state);
    let next = (0..64).map(|i| sign(field(&weights[1][i], &state, 64), state[i]));
    let mut next: Vec<f64> = next.collect();
    complete(&mut next);
    Pattern::from_bits(core::array::from_fn(|i| next[i] > 0.0))
}

fn reference_signs(pattern: &Pattern<64>) -> Vec<f64> {
    let bits = pattern.bits();
    bits.iter()
        .map(|bit| if *bit { 1.0 } else { -1.0 })
        .collect()
}

#[test]
fn a_step_is_that_of_the_formulas_to_the_bit() {
    // The last has more elements than can be held: mixtures are the same as well.
    for (seed, count) in [(1, 3), (2, 5), (3, 14)] {
        let sequence = random::<64>(seed, count);
        let mut memory = SequenceMemory::<64>::new();
        memory.learn(&sequence, End::Stays);
        let signs: Vec<_> = sequence.iter().map(reference_signs).collect();
        let weights = [0, 1].map(|shift| reference_weights(&signs, shift));
        for (first, cue) in sequence.iter().enumerate() {
            let cue = damaged(cue, first % 5);
            assert_eq!(memory.step(&cue), reference_step(&weights, &cue), "{seed}");
        }
    }
}

#[test]
fn the_rest_of_a_sequence_follows_a_damaged_cue() {
    let sequence = random::<128>(1, 6);
    let mut memory = Box::new(SequenceMemory::<128>::new());
    memory.learn(&sequence, End::Stays);
    for from in 0..6 {
        let recalled: Vec<_> = memory
            .recall(&damaged(&sequence[from], 0))
            .take(99)
            .collect();
        assert_eq!(recalled, sequence[from..]);
    }
}

#[test]
fn a_patrol_returns_to_its_first_element() {
    let sequence = random::<128>(2, 4);
    let mut memory = Box::new(SequenceMemory::<128>::new());
    memory.learn(&sequence, End::Returns);
    let recalled: Vec<_> = memory.recall(&sequence[2]).take(9).collect();
    let expected: Vec<_> = sequence.iter().cycle().skip(2).take(9).copied().collect();
    assert_eq!(recalled, expected);
}

/// Patterns that share most of their bits: Hebb's rule holds their mean.
#[test]
fn corrected_weights_tell_apart_what_is_alike() {
    let draws = random::<64>(3, 25);
    let alike: Vec<_> = draws
        .chunks(5)
        .map(|five| {
            // A bit is set where all of five are: one in 32.
            Pattern::<64>::from_bits(core::array::from_fn(|i| {
                five.iter().take(3).all(|pattern| pattern.bits()[i])
            }))
        })
        .collect();
    let mut memory = SequenceMemory::<64>::new();
    memory.learn(&alike, End::Returns);
    let is_right = |memory: &SequenceMemory<64>| {
        let recalled: Vec<_> = memory.recall(&alike[0]).take(5).collect();
        recalled == alike
    };
    assert!(!is_right(&memory));
    let presentations = (0..50).find(|_| memory.correct(&alike, End::Returns) == 0);
    assert!(
        presentations.is_some_and(|count| count > 0),
        "{presentations:?}"
    );
    assert!(is_right(&memory));
}

/// C and G follow X: their sum is 0 where they differ, and says nothing there.
#[test]
fn what_follows_an_element_of_two_sequences_is_not_known() {
    let all = random::<128>(4, 7);
    let (first, second) = ([all[0], all[1], all[2]], [all[3], all[1], all[4]]);
    let mut memory = Box::new(SequenceMemory::<128>::new());
    for sequence in [first, second] {
        memory.learn(&sequence, End::Stays);
    }
    let after = memory.successor(&all[1]);
    let [one, other] = [2, 4].map(|i| after.distance(&all[i]));
    let apart = all[2].distance(&all[4]);
    // It differs from each in about half of the bits in which they differ.
    assert!(
        one > apart / 4 && other > apart / 4,
        "{one} {other} {apart}"
    );
}

#[test]
fn weights_saturate_alike_in_both_directions() {
    let pattern = random::<8>(5, 1)[0];
    let mut memory = SequenceMemory::<8>::new();
    (0..300).for_each(|_| memory.learn(&[pattern], End::Stays));
    assert_eq!(memory.complete(&damaged(&pattern, 0)).pattern, pattern);
    // As far back as 127 steps go: 300 of them are no more.
    let mut other = pattern;
    other.flip(0);
    (0..128).for_each(|_| memory.link(&pattern, &other));
    assert_eq!(memory.successor(&pattern), other);
    assert_eq!(size_of::<SequenceMemory<128>>(), 32_768);
}

#[test]
fn a_completion_counts_its_rounds() {
    let sequence = random::<128>(6, 3);
    let mut memory = Box::new(SequenceMemory::<128>::new());
    let nothing = memory.complete(&sequence[0]);
    assert_eq!((nothing.pattern, nothing.rounds), (sequence[0], 0));
    memory.learn(&sequence, End::Stays);
    let done = memory.complete(&damaged(&sequence[1], 2));
    assert!(
        done.has_converged && (1..=3).contains(&done.rounds),
        "{done:?}"
    );
    assert_eq!(memory.complete(&sequence[1]).rounds, 0);
}

#[test]
fn a_situation_comes_back_to_the_nearest_step() {
    let situation: [Weight; 16] = core::array::from_fn(|i| Weight::from_num(i as f64 / 15.0));
    let pattern = Pattern::<128>::of_situation(&situation);
    for (value, back) in situation.iter().zip(pattern.situation::<16>()) {
        let error = value.to_num::<f64>() - back.to_num::<f64>();
        assert!(error.abs() <= 1.0 / 16.0 + 1e-3, "{value} {back}");
    }
    assert_eq!(Pattern::of_situation(&pattern.situation::<16>()), pattern);
    // Three bits are left over, and more values than bits have none.
    let odd = Pattern::<19>::of_situation(&situation);
    assert_eq!(odd.bits()[16..], [false; 3]);
    assert_eq!(Pattern::<8>::of_situation(&situation).bits(), [false; 8]);
}
