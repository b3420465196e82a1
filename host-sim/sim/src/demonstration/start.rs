//! Where the search begins: what the demonstrated situations have in common.
//!
//! In the frame of travel each situation is turned so that component 0 looks where the robot went.
//! Where it did not go straight to what it pursued, the nearest thing is a better guide: the
//! situations are turned so that the nearest thing is at one place, and all together so that the
//! robot mostly went along component 0.

use super::examples::Examples;
use super::family::Family;
use super::parameters::Parameters;
use amp::goal::GoalFrame;

/// Variance of a value that does not vary at all: noise of 2 % of the scale.
pub const LEAST_VARIANCE: f64 = 4e-4;
/// Shares of the values left out at either end.
const LEFT_OUT: [f64; 2] = [0.05, 0.25];
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

/// The starts of one family.
pub fn starts(examples: &Examples, family: Family) -> Vec<(Family, Parameters)> {
    let alignments = match family.frame {
        GoalFrame::Ring => vec![vec![0; examples.len()]],
        GoalFrame::Travel => vec![along_the_motion(examples), by_the_nearest(examples)],
    };
    let mut starts = Vec::new();
    for places in &alignments {
        for left_out in LEFT_OUT {
            starts.push((family, start(examples, family, places, left_out)));
        }
    }
    starts
}

/// The place of the ring along which the robot went from each situation.
fn along_the_motion(examples: &Examples) -> Vec<usize> {
    examples.iter().map(|example| example.went).collect()
}

/// The place of the nearest thing, turned by the commonest angle from there to the motion.
fn by_the_nearest(examples: &Examples) -> Vec<usize> {
    let nearest: Vec<_> = examples
        .iter()
        .map(|example| nearest(&example.values))
        .collect();
    let mut votes = [0_u32; 16];
    for (example, nearest) in examples.iter().zip(&nearest) {
        let angle = example.went + 16 - nearest;
        for (beside, vote) in [(15, 1), (0, 2), (1, 1)] {
            votes[(angle + beside) % 16] += vote;
        }
    }
    // The first of the most frequent angles.
    let commonest = (0..16).rev().max_by_key(|angle| votes[*angle]).unwrap_or(0);
    nearest
        .iter()
        .map(|place| (place + commonest) % 16)
        .collect()
}

/// The first place of the greatest value.
fn nearest(values: &[f64; 16]) -> usize {
    let known = (0..16).rev().filter(|place| !values[*place].is_nan());
    known
        .max_by(|a, b| values[*a].total_cmp(&values[*b]))
        .unwrap_or(0)
}

/// Intervals and weights by the spread of the values when each situation is turned to its place.
fn start(examples: &Examples, family: Family, places: &[usize], left_out: f64) -> Parameters {
    let mut parameters = Parameters {
        weights: [1e-3; 16],
        low: [0.0; 16],
        high: [1.0; 16],
        progress: 1.0,
        heading_hold: 1.0,
    };
    for component in 0..16 {
        let turned = examples.iter().zip(places);
        let values = turned.map(|(example, place)| example.values[(component + place) % 16]);
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
    let places = family.directions();
    let costs = examples.iter().map(|example| {
        let costs = (0..places).map(|place| parameters.cost(&example.values, place));
        costs.sum::<f64>() / places as f64
    });
    costs.sum::<f64>() / examples.len().max(1) as f64
}
