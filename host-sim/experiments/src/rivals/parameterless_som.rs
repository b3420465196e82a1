//! Rival in the action map's slot: the parameterless self-organizing map.
//!
//! E. Berglund, J. Sitte, *The parameterless self-organizing map algorithm*, IEEE Transactions on
//! Neural Networks 17, 2006. No schedule: learning rate and width follow from how badly the map
//! fits the sample, ε = |x − w| / r with the greatest error r so far. 4 × 4 neurons, as the action
//! map; the width is Θ = β ln(1 + ε (e − 1)), and h = e^(−d²/Θ²) with the distance d on the grid.

use super::codebook::{CodeVector, UNITS, nearest_two, present};
use super::transition::Transition;
use arena::noise::Noise;
use std::f64::consts::E;

/// Neurons in a row.
const SIDE: usize = 4;
/// Widest neighborhood β, in grid steps.
const WIDEST: f64 = 2.0;
/// An error below this, as a share of the greatest, is none.
const LEAST_ERROR: f64 = 1e-9;

/// Trains the map; returns its code vectors.
#[must_use]
pub fn train(transitions: &[Transition], symmetric: bool, seed: u64) -> Vec<CodeVector> {
    if transitions.is_empty() {
        return Vec::new();
    }
    let mut noise = Noise::new(seed);
    let start = |_| CodeVector::of(&transitions[noise.index(transitions.len())]);
    let mut codes: Vec<CodeVector> = (0..UNITS).map(start).collect();
    let mut greatest = 0.0;
    present(transitions, symmetric, &mut noise, |sample| {
        learn(&mut codes, sample, &mut greatest);
    });
    codes
}

fn learn(codes: &mut [CodeVector], sample: &Transition, greatest: &mut f64) {
    let [nearest, _] = nearest_two(codes.iter(), sample);
    let error = codes[nearest].squared_distance(sample).sqrt();
    *greatest = f64::max(*greatest, error);
    let share = error / f64::max(*greatest, LEAST_ERROR);
    // A neuron that has come to its sample has nothing to learn, and no width to divide by.
    if share < LEAST_ERROR {
        return;
    }
    let width = WIDEST * libm::log(1.0 + share * (E - 1.0));
    for (neuron, code) in codes.iter_mut().enumerate() {
        let apart = squared_grid_distance(nearest, neuron);
        code.approach(sample, share * libm::exp(-apart / (width * width)));
    }
}

fn squared_grid_distance(a: usize, b: usize) -> f64 {
    let (rows, columns) = ((a / SIDE).abs_diff(b / SIDE), (a % SIDE).abs_diff(b % SIDE));
    (rows * rows + columns * columns) as f64
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::cosines;
    use super::*;

    #[test]
    fn its_code_vectors_spread_in_order() {
        let codes = train(&cosines(300, 1), false, 1);
        let reach = |way: fn(&CodeVector) -> f64| {
            let values = codes.iter().map(way);
            values.fold(f64::NEG_INFINITY, f64::max)
        };
        // Moves reach 1 in all directions; a map that does not spread stays near 0.
        for reach in [
            reach(|code| code.moved.x),
            reach(|code| -code.moved.x),
            reach(|code| code.moved.y),
            reach(|code| -code.moved.y),
        ] {
            assert!((0.25..1.0).contains(&reach), "{reach}");
        }
        let mean_apart = |most: f64| {
            let pairs = (0..UNITS).flat_map(|a| (0..a).map(move |b| (a, b)));
            let pairs = pairs.filter(|(a, b)| squared_grid_distance(*a, *b) <= most);
            let apart = |(a, b): (usize, usize)| codes[a].moved.distance(codes[b].moved);
            sim::statistics::mean(pairs.map(apart))
        };
        assert!(mean_apart(1.0) < 0.7 * mean_apart(99.0));
    }

    #[test]
    fn a_neuron_that_has_come_to_its_sample_stays() {
        let mut sample = cosines(1, 1)[0];
        sample.change = [0.0; 16];
        sample.moved = arena::world::Point::new(1e-18, 0.0);
        let mut codes = vec![CodeVector::default(); UNITS];
        learn(&mut codes, &sample, &mut 1.0);
        assert_eq!(codes, vec![CodeVector::default(); UNITS]);
    }

    #[test]
    fn a_few_moves_are_enough_and_a_seed_gives_one_map() {
        for count in [0, 1, 2, 10] {
            let codes = train(&cosines(count, 1), true, 3);
            assert_eq!(codes.len(), if count == 0 { 0 } else { UNITS });
            assert_eq!(codes, train(&cosines(count, 1), true, 3));
        }
        assert_ne!(
            train(&cosines(10, 1), true, 3),
            train(&cosines(10, 1), true, 4)
        );
    }
}
