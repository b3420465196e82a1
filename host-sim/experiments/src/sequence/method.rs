//! Methods that recall a sequence, with and without associative memories.

use amp::sequence::{End, Pattern, SequenceMemory};
use arena::noise::Noise;
use serde::Serialize;

/// Presentations of the corrected rule, at most.
const PRESENTATIONS: u32 = 50;

/// How a sequence is recalled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Two auto-associative networks with the successor between them, learned by Hebb's rule.
    Pair,
    /// The same, corrected.
    PairCorrected,
    /// An auto-associative network and a hetero-associative one, which is not completed.
    OneCleanUp,
    /// The hetero-associative network alone.
    Hetero,
    /// The same, corrected.
    HeteroCorrected,
    /// The nearest of all elements in a table, and what follows it there.
    Table,
    /// Any element.
    Guess,
}

impl Method {
    /// All, in the order of the tables.
    pub const ALL: [Self; 7] = [
        Self::Pair,
        Self::PairCorrected,
        Self::OneCleanUp,
        Self::Hetero,
        Self::HeteroCorrected,
        Self::Table,
        Self::Guess,
    ];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pair => "pair",
            Self::PairCorrected => "pair, corrected",
            Self::OneCleanUp => "one clean-up",
            Self::Hetero => "hetero alone",
            Self::HeteroCorrected => "hetero, corrected",
            Self::Table => "table, nearest",
            Self::Guess => "random guess",
        }
    }

    /// Its weights are corrected after Hebb's rule.
    pub(super) const fn is_corrected(self) -> bool {
        matches!(self, Self::PairCorrected | Self::HeteroCorrected)
    }
}

/// Sequences as all methods know them.
pub(super) struct Learned<const N: usize> {
    hebb: Box<SequenceMemory<N>>,
    corrected: Option<Box<SequenceMemory<N>>>,
    /// Each element and what follows it.
    table: Vec<[Pattern<N>; 2]>,
}

impl<const N: usize> Learned<N> {
    /// Learns sequences whose last elements stay. Without `correct` the corrected methods know
    /// what Hebb's rule knows.
    pub(super) fn of(sequences: &[&[Pattern<N>]], correct: bool) -> Self {
        let mut hebb = Box::new(SequenceMemory::new());
        for sequence in sequences {
            hebb.learn(sequence, End::Stays);
        }
        let corrected = correct.then(|| {
            let mut memory = hebb.clone();
            for _ in 0..PRESENTATIONS {
                let corrected = sequences.iter().map(|one| memory.correct(one, End::Stays));
                if corrected.sum::<u32>() == 0 {
                    break;
                }
            }
            memory
        });
        let table = sequences.iter().flat_map(|sequence| {
            let next = sequence.iter().skip(1).chain(sequence.last());
            sequence.iter().zip(next).map(|(one, next)| [*one, *next])
        });
        Self {
            hebb,
            corrected,
            table: table.collect(),
        }
    }

    /// What follows a cue.
    pub(super) fn step(&self, method: Method, cue: &Pattern<N>, noise: &mut Noise) -> Pattern<N> {
        let memory = match &self.corrected {
            Some(memory) if method.is_corrected() => memory,
            _ => &self.hebb,
        };
        match method {
            Method::Pair | Method::PairCorrected => memory.step(cue),
            Method::OneCleanUp => memory.successor(&memory.complete(cue).pattern),
            Method::Hetero | Method::HeteroCorrected => memory.successor(cue),
            Method::Table => {
                let nearest = self.table.iter().min_by_key(|[one, _]| one.distance(cue));
                nearest.map_or(*cue, |[_, next]| *next)
            }
            Method::Guess => {
                let any = self.table.get(noise.index(self.table.len()));
                any.map_or(*cue, |[one, _]| *one)
            }
        }
    }

    /// Whether the rest of a sequence is recalled without an error from its first element, which
    /// `damage` may change; `each` may change what is recalled before the next step.
    pub(super) fn recalls(
        &self,
        method: Method,
        sequence: &[Pattern<N>],
        flips: Flips,
        noise: &mut Noise,
    ) -> bool {
        let Some((first, rest)) = sequence.split_first() else {
            return true;
        };
        let mut cue = *first;
        flip(&mut cue, flips.in_cue, noise);
        rest.iter().all(|expected| {
            let next = self.step(method, &cue, noise);
            cue = next;
            flip(&mut cue, flips.in_steps, noise);
            next == *expected
        })
    }
}

/// Bits that are turned around, percent of all.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Flips {
    /// In the cue.
    pub in_cue: u32,
    /// In each recalled element, before the next step.
    pub in_steps: u32,
}

/// Turns so many random bits around, each once.
pub(super) fn flip<const N: usize>(pattern: &mut Pattern<N>, percent: u32, noise: &mut Noise) {
    let count = (N * percent as usize + 50) / 100;
    let mut bits: Vec<usize> = (0..N).collect();
    for place in 0..count.min(N) {
        let other = place + noise.index(N - place);
        bits.swap(place, other);
        pattern.flip(bits[place]);
    }
}
