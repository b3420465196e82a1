//! The longest sequence that is recalled without an error from its first element.

use super::method::{Flips, Learned};
use super::{Draw, Found, Measure, Method, SequenceTrial};
use amp::sequence::Pattern;

/// Numbers of bits that are measured.
pub const SIZES: [usize; 4] = [64, 128, 256, 512];

/// Methods whose capacity depends on the number of bits; a table holds what it has room for.
const METHODS: [Method; 5] = [
    Method::Pair,
    Method::PairCorrected,
    Method::OneCleanUp,
    Method::Hetero,
    Method::HeteroCorrected,
];

/// Measures all sizes and methods for one seed.
pub(super) fn measure(trial: &SequenceTrial, draw: &Draw<'_>, found: &mut Vec<Found>) {
    of_size::<64>(trial, draw, found);
    of_size::<128>(trial, draw, found);
    of_size::<256>(trial, draw, found);
    of_size::<512>(trial, draw, found);
}

fn of_size<const N: usize>(trial: &SequenceTrial, draw: &Draw<'_>, found: &mut Vec<Found>) {
    let elements = draw.elements::<N>(2 * N);
    for method in METHODS {
        if method.is_corrected() && N > trial.corrected_bits {
            continue;
        }
        found.push(Found {
            elements: draw.elements,
            measure: Measure::Longest,
            method,
            at: N as u32,
            value: longest(method, &elements) as f64,
        });
    }
}

/// A length that is recalled where one more is not, by doubling and bisection; all if all are.
fn longest<const N: usize>(method: Method, elements: &[Pattern<N>]) -> usize {
    let is_recalled = |length: usize| {
        let sequence = &elements[..length];
        let learned = Learned::of(&[sequence], method.is_corrected());
        // No method of these draws from the noise.
        let mut noise = arena::noise::Noise::new(0);
        learned.recalls(method, sequence, Flips::default(), &mut noise)
    };
    let (mut known, mut limit) = (1, 2);
    while limit <= elements.len() && is_recalled(limit) {
        (known, limit) = (limit, 2 * limit);
    }
    limit = limit.min(elements.len() + 1);
    while known + 1 < limit {
        let middle = (known + limit) / 2;
        if is_recalled(middle) {
            known = middle;
        } else {
            limit = middle;
        }
    }
    known
}
