//! Sequences of patterns, recalled by a pair of associative memories: how many elements it holds
//! and what noise it bears, beside simpler methods.
//!
//! Patterns are random bits, or situations of a simulated robot's drive in a thermometer code.

mod longest;
mod method;
pub mod picture;
mod recall;
mod situations;

pub use longest::SIZES;
pub use method::Method;

use arena::noise::Noise;
use files::error::BadInput;
use rayon::prelude::*;
use serde::Serialize;
use sim::statistics::{Mean, bootstrap};
use situations::Drive;

/// Bits of the patterns in the measurements under noise.
pub const BITS: usize = 128;
/// Elements of a sequence there.
pub const ELEMENTS: usize = 6;
/// Share of the bits that are turned around, percent.
pub const FLIPPED: [u32; 9] = [0, 5, 10, 15, 20, 25, 30, 35, 40];
/// Sequences in one memory.
pub const SEQUENCES: [u32; 6] = [1, 2, 3, 4, 6, 8];
/// Elements of each of them.
pub const SHORT: usize = 4;

/// What the elements are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Elements {
    /// Bits that are drawn at random.
    Random,
    /// Situations of a robot that drives around.
    Situations,
}

impl Elements {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Random, Self::Situations];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Situations => "situations",
        }
    }
}

/// What is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// Elements of the longest sequence that is recalled without an error; `at` is the number of
    /// bits.
    Longest,
    /// Share of sequences that are recalled wholly from a damaged cue; `at` is the share of its
    /// bits that are turned around, percent.
    Cue,
    /// The same if each element is damaged before the step to the next.
    Steps,
    /// Share of sequences that are recalled wholly if so many are in one memory; `at` is their
    /// number.
    Sequences,
    /// The same of two sequences that have an element in common; `at` is 1 if they have, else 0.
    Shared,
}

/// One figure of one method.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Row {
    /// What the elements are.
    pub elements: Elements,
    /// What is measured.
    pub measure: Measure,
    /// How it is recalled.
    pub method: Method,
    /// The measure's condition.
    pub at: u32,
    /// The mean over the seeds.
    pub mean: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
}

impl Row {
    /// The figure with its interval.
    #[must_use]
    pub const fn figure(&self) -> Mean {
        Mean {
            mean: self.mean,
            interval: self.interval,
        }
    }
}

/// Size of the measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SequenceTrial {
    /// Seed of the first draw; each further one has the next.
    pub seed: u64,
    /// Draws of elements.
    pub seeds: u32,
    /// Damaged cues of each.
    pub cues: u32,
    /// The corrected rule is measured up to so many bits: it takes long.
    pub corrected_bits: usize,
}

/// Measures everything, on all cores. `done` is called after each seed.
///
/// # Errors
/// When a robot cannot be driven around.
pub fn measure(trial: &SequenceTrial, done: &(impl Fn() + Sync)) -> Result<Vec<Row>, BadInput> {
    over_seeds(trial, done, |draw, found| {
        longest::measure(trial, draw, found);
        recall::under_noise(trial, draw, &FLIPPED, found);
        recall::several(draw, found);
        recall::shared(draw, found);
    })
}

/// Measures recall under noise alone, with such shares of bits turned around, percent.
///
/// # Errors
/// As [`measure`].
pub fn measure_noise(
    trial: &SequenceTrial,
    flipped: &[u32],
    done: &(impl Fn() + Sync),
) -> Result<Vec<Row>, BadInput> {
    over_seeds(trial, done, |draw, found| {
        recall::under_noise(trial, draw, flipped, found);
    })
}

/// Measures all kinds of elements with every seed; the mean of each figure over the seeds.
fn over_seeds(
    trial: &SequenceTrial,
    done: &(impl Fn() + Sync),
    one: impl Fn(&Draw<'_>, &mut Vec<Found>) + Sync,
) -> Result<Vec<Row>, BadInput> {
    let of_seed = |number: u32| {
        let seed = trial.seed.wrapping_add(u64::from(number));
        let drive = Drive::of_seed(seed)?;
        let mut found = Vec::new();
        for elements in Elements::ALL {
            let draw = Draw {
                elements,
                drive: &drive,
                seed,
            };
            one(&draw, &mut found);
        }
        done();
        Ok(found)
    };
    let seeds: Result<Vec<Vec<Found>>, BadInput> =
        (0..trial.seeds).into_par_iter().map(of_seed).collect();
    Ok(rows(&seeds?))
}

fn rows(seeds: &[Vec<Found>]) -> Vec<Row> {
    let first = seeds.first().map_or(&[][..], Vec::as_slice);
    let row = |(index, found): (usize, &Found)| {
        let values = seeds.iter().filter_map(|all| all.get(index));
        let figure = bootstrap(&values.map(|found| vec![found.value]).collect::<Vec<_>>());
        Row {
            elements: found.elements,
            measure: found.measure,
            method: found.method,
            at: found.at,
            mean: figure.mean,
            interval: figure.interval,
        }
    };
    first.iter().enumerate().map(row).collect()
}

/// A figure of one seed.
struct Found {
    elements: Elements,
    measure: Measure,
    method: Method,
    at: u32,
    value: f64,
}

/// Where the elements of one seed come from.
struct Draw<'d> {
    elements: Elements,
    drive: &'d Drive,
    seed: u64,
}

impl Draw<'_> {
    /// At most so many elements, all different; those of a drive in its order.
    fn elements<const N: usize>(&self, count: usize) -> Vec<amp::sequence::Pattern<N>> {
        match self.elements {
            Elements::Random => {
                let mut noise = self.noise(N as u64);
                (0..count).map(|_| random(&mut noise)).collect()
            }
            Elements::Situations => self.drive.elements(count),
        }
    }

    /// A generator for one purpose.
    fn noise(&self, purpose: u64) -> Noise {
        Noise::new(self.seed.wrapping_mul(1 << 16).wrapping_add(purpose))
    }
}

/// Random bits.
fn random<const N: usize>(noise: &mut Noise) -> amp::sequence::Pattern<N> {
    amp::sequence::Pattern::from_bits(std::array::from_fn(|_| noise.chance(0.5)))
}

#[cfg(test)]
mod tests;
