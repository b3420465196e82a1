//! Where the search begins: what the demonstrated situations have in common.
//!
//! In the frame of travel each situation is turned so that component 0 looks where the robot went.
//! Where it did not go straight to what it pursued, what it perceived is a better guide: the
//! situations are turned so that the nearest thing is at one place, or so that each is most like
//! the mean of all, and all together so that the robot mostly went along component 0.
//!
//! A goal at which the robot stands is also sought in those situations alone in which it stood.

use super::examples::{Example, Examples};
use super::family::Family;
use super::parameters::Parameters;
use amp::goal::GoalFrame;

/// Variance of a value that does not vary at all: noise of 2 % of the scale.
pub const LEAST_VARIANCE: f64 = 4e-4;
/// Shares of the values left out at either end.
const LEFT_OUT: [f64; 2] = [0.05, 0.25];
/// A shorter move is standing, as a share of the step.
const RESTING: f64 = 0.5;
/// Fewest situations in which the robot stood.
const MIN_RESTING: usize = 5;
/// Which situations are patterns at first: the last, the middle and the one at a quarter.
const PATTERNS_AT: [usize; 3] = [4, 2, 1];
/// Rounds of finding a pattern.
const PATTERN_ROUNDS: usize = 4;
/// Mean cost of a demonstrated situation seen in any direction, in units of the choice model.
const FIRST_COST: f64 = 3.0;

/// What some values have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// 1 / variance, at most 1 / [`LEAST_VARIANCE`].
    pub precision: f64,
}

/// The spread of values without the share `left_out` at either end; `None` for no values.
pub fn spread(values: impl Iterator<Item = f64>, left_out: f64) -> Option<Spread> {
    let mut sorted: Vec<_> = values.collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let skip = (sorted.len() as f64 * left_out) as usize;
    let middle = &sorted[skip..sorted.len() - skip];
    let (low, high) = (*middle.first()?, *middle.last()?);
    let mean = middle.iter().sum::<f64>() / middle.len() as f64;
    let squares: f64 = middle
        .iter()
        .map(|value| (value - mean) * (value - mean))
        .sum();
    Some(Spread {
        low,
        high,
        precision: 1.0 / (squares / middle.len() as f64 + LEAST_VARIANCE),
    })
}

/// A situation, and the place of the ring to which it is turned.
type Aligned<'a> = (&'a Example, usize);

/// The starts of one family.
pub fn starts(examples: &Examples, family: Family) -> Vec<Parameters> {
    let all: Vec<&Example> = examples.iter().collect();
    let mut alignments = alignments(&all, family);
    if family.stands {
        let resting = all.into_iter().filter(|example| example.length < RESTING);
        let resting: Vec<_> = resting.collect();
        if resting.len() >= MIN_RESTING {
            alignments.extend(self::alignments(&resting, family));
        }
    }
    let starts = alignments
        .iter()
        .flat_map(|aligned| LEFT_OUT.map(|left_out| start(examples, family, aligned, left_out)));
    starts.collect()
}

/// Some situations turned in all ways.
fn alignments<'a>(group: &[&'a Example], family: Family) -> Vec<Vec<Aligned<'a>>> {
    let turned = |places: Vec<usize>| group.iter().copied().zip(places).collect();
    if family.frame == GoalFrame::Ring {
        return vec![turned(vec![0; group.len()])];
    }
    let nearest = group.iter().map(|example| nearest(&example.values));
    let mut places = vec![
        group.iter().map(|example| example.went).collect(),
        along_the_motion(group, nearest.collect()),
    ];
    for quarter in PATTERNS_AT {
        let first = group.len().saturating_sub(1) * quarter / 4;
        let pattern = group
            .get(first)
            .map(|example| by_pattern(group, example.values));
        places.extend(pattern.map(|places| along_the_motion(group, places)));
    }
    places.into_iter().map(turned).collect()
}

/// Places turned by the commonest angle from there to the motion.
fn along_the_motion(group: &[&Example], places: Vec<usize>) -> Vec<usize> {
    let mut votes = [0_u32; 16];
    for (example, place) in group.iter().zip(&places) {
        let angle = example.went + 16 - place;
        for (beside, vote) in [(15, 1), (0, 2), (1, 1)] {
            votes[(angle + beside) % 16] += vote;
        }
    }
    // The first of the most frequent angles.
    let commonest = (0..16).rev().max_by_key(|angle| votes[*angle]).unwrap_or(0);
    let turned = places.into_iter().map(|place| (place + commonest) % 16);
    turned.collect()
}

/// The places to which situations are turned so that each is most like the mean of all; at first
/// like this pattern.
fn by_pattern(group: &[&Example], mut pattern: [f64; 16]) -> Vec<usize> {
    let mut places = Vec::new();
    for _ in 0..PATTERN_ROUNDS {
        let best = group
            .iter()
            .map(|example| likest(&example.values, &pattern));
        places = best.collect();
        pattern = std::array::from_fn(|component| {
            let values = group
                .iter()
                .zip(&places)
                .map(|(example, place)| example.values[(component + place) % 16])
                .filter(|value| !value.is_nan());
            let (sum, count) =
                values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
            // NaN where nothing is known.
            sum / count
        });
    }
    places
}

/// The first place that turns a situation nearest to a pattern.
fn likest(values: &[f64; 16], pattern: &[f64; 16]) -> usize {
    let off = |place: usize| -> f64 {
        let gaps = (0..16).map(|component| values[(component + place) % 16] - pattern[component]);
        let known = gaps.filter(|gap| !gap.is_nan());
        known.map(|gap| gap * gap).sum()
    };
    let offs: [f64; 16] = std::array::from_fn(off);
    let better = |a: usize, b: usize| if offs[b] < offs[a] { b } else { a };
    (0..16).reduce(better).unwrap_or(0)
}

/// The first place of the greatest value.
fn nearest(values: &[f64; 16]) -> usize {
    let known = (0..16).rev().filter(|place| !values[*place].is_nan());
    known
        .max_by(|a, b| values[*a].total_cmp(&values[*b]))
        .unwrap_or(0)
}

/// Intervals and weights by the spread of the values when each situation is turned to its place.
fn start(
    examples: &Examples,
    family: Family,
    aligned: &[Aligned<'_>],
    left_out: f64,
) -> Parameters {
    let mut parameters = Parameters {
        weights: [1e-3; 16],
        low: [0.0; 16],
        high: [1.0; 16],
        progress: 1.0,
        heading_hold: 1.0,
    };
    for component in 0..16 {
        let values = aligned
            .iter()
            .map(|(example, place)| example.values[(component + place) % 16]);
        if let Some(spread) = spread(values.filter(|value| !value.is_nan()), left_out) {
            parameters.weights[component] = spread.precision;
            parameters.low[component] = spread.low;
            parameters.high[component] = spread.high;
        }
    }
    let scale = FIRST_COST / mean_cost(examples, family, &parameters).max(1e-6);
    for weight in &mut parameters.weights {
        *weight = (*weight * scale).max(1e-3);
    }
    parameters
}

/// Mean cost of the situations over all directions in which they may be seen.
fn mean_cost(examples: &Examples, family: Family, parameters: &Parameters) -> f64 {
    let bounds = parameters.towards_all(family);
    let costs = examples.iter().map(|example| {
        let costs = bounds.iter().map(|bounds| bounds.cost(&example.values));
        costs.sum::<f64>() / bounds.len() as f64
    });
    costs.sum::<f64>() / examples.len().max(1) as f64
}
