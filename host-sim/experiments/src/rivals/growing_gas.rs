//! Rival in the action map's slot: growing neural gas.
//!
//! B. Fritzke, *A growing neural gas network learns topologies*, Advances in Neural Information
//! Processing Systems 7, 1995, with the constants of its simulations. At most 16 units.

use super::codebook::{CodeVector, UNITS, nearest_two, present};
use super::graph::Graph;
use super::transition::Transition;
use arena::noise::Noise;

/// Share of the way that the nearest unit moves, ε_b, and that its neighbors move, ε_n.
const RATES: [f64; 2] = [0.2, 0.006];
/// Presentations between two insertions, λ.
const INTERVAL: usize = 100;
/// Oldest edge, a_max.
const OLDEST: u32 = 50;
/// Factor of the errors of split units, α, and of all errors after each presentation, d.
const SPLIT: f64 = 0.5;
const DECAY: f64 = 0.995;

/// Trains the network; returns its code vectors.
#[must_use]
pub fn train(transitions: &[Transition], symmetric: bool, seed: u64) -> Vec<CodeVector> {
    let [first, .., last] = transitions else {
        return transitions.iter().map(CodeVector::of).collect();
    };
    let mut noise = Noise::new(seed);
    let mut graph = Graph::of([first, last], 0.0);
    let mut presented = 0;
    present(transitions, symmetric, &mut noise, |sample| {
        learn(&mut graph, sample);
        presented += 1;
        if presented % INTERVAL == 0 && graph.units.len() < UNITS {
            insert(&mut graph);
        }
        for unit in &mut graph.units {
            unit.counter *= DECAY;
        }
    });
    graph.codes()
}

fn learn(graph: &mut Graph, sample: &Transition) {
    let codes = graph.units.iter().map(|unit| &unit.code);
    let [nearest, second] = nearest_two(codes, sample);
    graph.age(nearest);
    let unit = &mut graph.units[nearest];
    unit.counter += unit.code.squared_distance(sample);
    unit.code.approach(sample, RATES[0]);
    for neighbor in graph.neighbors(nearest) {
        graph.units[neighbor].code.approach(sample, RATES[1]);
    }
    graph.connect(nearest, second);
    graph.prune(OLDEST);
}

/// A unit between the one with the greatest error and its neighbor with the greatest.
fn insert(graph: &mut Graph) {
    let error = |graph: &Graph, unit: usize| graph.units[unit].counter;
    let worst = |graph: &Graph, units: Vec<usize>| {
        let units = units.into_iter();
        units.max_by(|a, b| error(graph, *a).total_cmp(&error(graph, *b)))
    };
    let Some(first) = worst(graph, (0..graph.units.len()).collect()) else {
        return;
    };
    let Some(second) = worst(graph, graph.neighbors(first)) else {
        return;
    };
    for unit in [first, second] {
        graph.units[unit].counter *= SPLIT;
    }
    let [a, b] = [first, second].map(|unit| graph.units[unit].clone());
    let new = graph.insert(a.code.middle(&b.code), a.counter);
    graph.disconnect(first, second);
    graph.connect(first, new);
    graph.connect(second, new);
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::{cosines, two_clusters};
    use super::*;

    #[test]
    fn it_covers_two_clusters_and_nothing_between() {
        let codes = train(&two_clusters(200), false, 1);
        assert_eq!(codes.len(), UNITS);
        let ahead = codes.iter().filter(|code| code.moved.x > 0.6).count();
        let behind = codes.iter().filter(|code| code.moved.x < -0.6).count();
        assert!(
            ahead >= 5 && behind >= 5 && ahead + behind >= 15,
            "{ahead} {behind}"
        );
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
