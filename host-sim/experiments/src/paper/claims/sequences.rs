//! Claims of section 4 about the work of Lawrence, Trappenberg and Fine: sequences of patterns,
//! recalled by a pair of associative memories.

use super::{Claim, ClaimVerdict};
use crate::paper::measure::Measured;
use crate::sequence::{BITS, ELEMENTS, Elements, Measure, Method, Row};

/// Shares of the bits that are turned around, percent: none, and so many that methods differ.
pub const FLIPPED: [u32; 2] = [0, 20];
/// Cues of each draw.
pub const CUES: u32 = 10;

/// The rules and elements that are tried.
const CASES: [(Elements, Method); 4] = [
    (Elements::Random, Method::Pair),
    (Elements::Random, Method::PairCorrected),
    (Elements::Situations, Method::Pair),
    (Elements::Situations, Method::PairCorrected),
];

/// The claims, in order.
pub(super) fn claims(measured: &Measured) -> Vec<Claim> {
    let recalled = "wholly recalled in ≥ 95 % of the draws, for all elements and rules";
    let damaged = format!("with {} % of the bits turned around", FLIPPED[1]);
    vec![
        claim(
            measured,
            "the various elements of a sequence are recalled one after the other",
            (Measure::Cue, FLIPPED[0]),
            format!("from its first element the sequence is {recalled}"),
        ),
        claim(
            measured,
            "one of the associative memories converges towards a learned element",
            (Measure::Cue, FLIPPED[1]),
            format!("from its first element {damaged} the sequence is {recalled}"),
        ),
        claim(
            measured,
            "to force convergence towards the following element, and so on",
            (Measure::Steps, FLIPPED[1]),
            format!("{damaged} in every element the sequence is {recalled}"),
        ),
    ]
}

fn claim(
    measured: &Measured,
    words: &'static str,
    (measure, at): (Measure, u32),
    rule: String,
) -> Claim {
    let share = |elements: Elements, method: Method| {
        let is_it = |row: &&Row| {
            (row.elements, row.measure, row.method, row.at) == (elements, measure, method, at)
        };
        let found = measured.sequences.iter().find(is_it);
        found.map_or(0.0, |row| 100.0 * row.mean)
    };
    let of = |elements: Elements| {
        let figures = Method::ALL
            .into_iter()
            .filter(|method| !matches!(method, Method::OneCleanUp | Method::Guess));
        let figures = figures.map(|m| format!("{} {:.0} %", m.name(), share(elements, m)));
        format!(
            "{}: {}",
            elements.name(),
            figures.collect::<Vec<_>>().join(", ")
        )
    };
    Claim::new("4", words)
        .holds_if(rule)
        .measured(
            Elements::ALL.map(of).join("; "),
            format!(
                "{} draws, {CUES} cues each, of {ELEMENTS} elements of {BITS} bits",
                measured.size.draws
            ),
        )
        .verdict(ClaimVerdict::of(
            &CASES.map(|(elements, method)| share(elements, method) >= 95.0),
        ))
}
