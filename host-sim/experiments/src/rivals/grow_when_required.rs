//! Rival in the action map's slot: a network that grows when required.
//!
//! S. Marsland, J. Shapiro, U. Nehmzow, *A self-organising network that grows when required*,
//! Neural Networks 15, 2002. A unit is inserted where the nearest one is habituated and yet far
//! from the sample. At most 16 units.

use super::codebook::{CodeVector, UNITS, nearest_two, present};
use super::graph::Graph;
use super::transition::Transition;
use arena::noise::Noise;

/// Below this activity e^(−distance) a habituated unit is not enough, a_T.
const LEAST_ACTIVITY: f64 = 0.8;
/// Below this counter a unit is habituated, h_T.
const HABITUATED: f64 = 0.1;
/// Share of the way that the nearest unit moves, ε_b, and that its neighbors move, ε_n; both times
/// the unit's counter.
const RATES: [f64; 2] = [0.2, 0.006];
/// Time constants of the counters of the nearest unit, τ_b, and of its neighbors, τ_n.
const TIMES: [f64; 2] = [3.33, 14.33];
/// Recovery of the counters, α.
const RECOVERY: f64 = 1.05;
/// Oldest edge.
const OLDEST: u32 = 50;

/// Trains the network; returns its code vectors.
#[must_use]
pub fn train(transitions: &[Transition], symmetric: bool, seed: u64) -> Vec<CodeVector> {
    let [first, .., last] = transitions else {
        return transitions.iter().map(CodeVector::of).collect();
    };
    let mut noise = Noise::new(seed);
    let mut graph = Graph::of([first, last], 1.0);
    present(transitions, symmetric, &mut noise, |sample| {
        learn(&mut graph, sample);
    });
    graph.codes()
}

fn learn(graph: &mut Graph, sample: &Transition) {
    let codes = graph.units.iter().map(|unit| &unit.code);
    let [nearest, second] = nearest_two(codes, sample);
    graph.connect(nearest, second);
    let unit = &graph.units[nearest];
    let activity = libm::exp(-unit.code.squared_distance(sample).sqrt());
    let is_required = activity < LEAST_ACTIVITY && unit.counter < HABITUATED;
    if is_required && graph.units.len() < UNITS {
        let code = unit.code.middle(&CodeVector::of(sample));
        let new = graph.insert(code, 1.0);
        graph.disconnect(nearest, second);
        graph.connect(new, nearest);
        graph.connect(new, second);
    } else {
        adapt(graph, nearest, sample, 0);
        for neighbor in graph.neighbors(nearest) {
            adapt(graph, neighbor, sample, 1);
        }
    }
    graph.age(nearest);
    graph.prune(OLDEST);
}

/// Moves a unit (`role` 0: the nearest, 1: a neighbor) and habituates it.
fn adapt(graph: &mut Graph, unit: usize, sample: &Transition, role: usize) {
    let unit = &mut graph.units[unit];
    unit.code.approach(sample, RATES[role] * unit.counter);
    unit.counter += (RECOVERY * (1.0 - unit.counter) - 1.0) / TIMES[role];
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::{cosines, two_clusters};
    use super::*;

    #[test]
    fn it_grows_where_that_is_required_only() {
        let wide = train(&cosines(200, 1), true, 1);
        assert_eq!(wide.len(), UNITS);
        // Moves within 0.05 of two points: no sample is far from a unit there.
        let narrow = train(&two_clusters(200), false, 1);
        assert!((2..=4).contains(&narrow.len()), "{}", narrow.len());
        for side in [-1.0, 1.0] {
            let near = |code: &&CodeVector| (code.moved.x - side).abs() < 0.1;
            assert!(narrow.iter().any(|code| near(&code)), "{side}");
        }
    }

    #[test]
    fn a_few_moves_are_enough_and_a_seed_gives_one_network() {
        for count in [0, 1, 2, 10] {
            let codes = train(&cosines(count, 1), true, 3);
            assert!(codes.len() >= count.min(2) && codes.len() <= UNITS);
            assert_eq!(codes, train(&cosines(count, 1), true, 3));
        }
        assert_ne!(
            train(&cosines(10, 1), true, 3),
            train(&cosines(10, 1), true, 4)
        );
    }
}
