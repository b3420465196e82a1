//! Recall from damaged cues, under noise in every step, of several sequences, and of sequences that
//! share an element.

use super::SequenceTrial;
use super::method::{Flips, Learned};
use super::{BITS, Draw, ELEMENTS, Found, Measure, Method, SEQUENCES, SHORT};
use amp::sequence::Pattern;

type Element = Pattern<BITS>;

/// One sequence, from damaged cues, and with damage in every step.
pub(super) fn under_noise(
    trial: &SequenceTrial,
    draw: &Draw<'_>,
    flipped: &[u32],
    found: &mut Vec<Found>,
) {
    let sequence = draw.elements::<BITS>(ELEMENTS);
    let learned = Learned::of(&[&sequence], true);
    for (measure, purpose) in [(Measure::Cue, 1), (Measure::Steps, 2)] {
        for method in Method::ALL {
            for &percent in flipped {
                let mut noise = draw.noise(purpose);
                let flips = Flips {
                    in_cue: percent,
                    in_steps: if measure == Measure::Steps {
                        percent
                    } else {
                        0
                    },
                };
                let cues = 0..trial.cues;
                let right = cues.filter(|_| learned.recalls(method, &sequence, flips, &mut noise));
                found.push(Found {
                    elements: draw.elements,
                    measure,
                    method,
                    at: percent,
                    value: right.count() as f64 / f64::from(trial.cues.max(1)),
                });
            }
        }
    }
}

/// Several sequences in one memory, each recalled from its first element.
pub(super) fn several(draw: &Draw<'_>, found: &mut Vec<Found>) {
    for count in SEQUENCES {
        let elements = draw.elements::<BITS>(SHORT * count as usize);
        let sequences: Vec<_> = elements.chunks_exact(SHORT).collect();
        shares(draw, Measure::Sequences, count, &sequences, found);
    }
}

/// Two sequences with and without an element in common, in their middle.
pub(super) fn shared(draw: &Draw<'_>, found: &mut Vec<Found>) {
    const MIDDLE: usize = SHORT / 2;
    let elements = draw.elements::<BITS>(2 * SHORT);
    let (first, second) = elements.split_at(SHORT.min(elements.len()));
    let mut crossing = second.to_vec();
    for (element, other) in crossing.iter_mut().zip(first).skip(MIDDLE - 1).take(1) {
        *element = *other;
    }
    for (at, other) in [(0, second), (1, crossing.as_slice())] {
        shares(draw, Measure::Shared, at, &[first, other], found);
    }
}

/// The share of sequences in one memory that are recalled wholly, by method.
fn shares(
    draw: &Draw<'_>,
    measure: Measure,
    at: u32,
    sequences: &[&[Element]],
    found: &mut Vec<Found>,
) {
    let learned = Learned::of(sequences, true);
    for method in Method::ALL {
        let mut noise = draw.noise(3);
        let all = sequences.iter();
        let right = all.filter(|one| learned.recalls(method, one, Flips::default(), &mut noise));
        found.push(Found {
            elements: draw.elements,
            measure,
            method,
            at,
            value: right.count() as f64 / sequences.len().max(1) as f64,
        });
    }
}
