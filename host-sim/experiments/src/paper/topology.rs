//! Topology of a map: do neighboring neurons code similar situations?

use amp::fixed::{Weight, Weight32};
use amp::som::{Grid, Som};
use arena::noise::Noise;
use sim::statistics::pearson;

/// Number of random permutations of the code vectors with which a map is compared.
pub const SHUFFLINGS: usize = 999;

/// Topology measures of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapTopology {
    /// Mean distance between the code vectors of direct neighbors (1 = the whole scale of a
    /// sensor).
    pub neighbors: f64,
    /// The same for neurons that are not direct neighbors.
    pub others: f64,
    /// Share of samples whose two best neurons are not direct neighbors.
    pub topographic_error: f64,
    /// Pearson correlation of grid distance and code vector distance, over all pairs of neurons.
    pub correlation: f64,
    /// Permutations, of [`SHUFFLINGS`], whose neighbors are as near or nearer.
    pub as_good_by_chance: usize,
    /// Standard deviation of the samples per neuron, divided by their mean.
    pub hit_spread: f64,
    /// Neurons that win no sample.
    pub idle: usize,
}

/// Measures `map` with `samples`; `seed` draws the permutations.
#[must_use]
pub fn topology_of<const NEURONS: usize, const DIMS: usize>(
    map: &Som<NEURONS, DIMS>,
    samples: &[[Weight; DIMS]],
    seed: u64,
) -> MapTopology {
    let grid = map.grid();
    let distance = |a: usize, b: usize| match (map.code().get(a), map.code().get(b)) {
        (Some(a), Some(b)) => difference(a, b),
        _ => 0.0,
    };
    let mut places: Vec<usize> = (0..NEURONS).collect();
    let (neighbors, others) = means(grid, NEURONS, &places, distance);
    let mut noise = Noise::new(seed);
    let as_good_by_chance = (0..SHUFFLINGS)
        .filter(|_| {
            for last in (1..NEURONS).rev() {
                places.swap(last, noise.index(last + 1));
            }
            means(grid, NEURONS, &places, distance).0 <= neighbors
        })
        .count();
    let pairs = (0..NEURONS).flat_map(|a| (0..a).map(move |b| (a, b)));
    let pairs: Vec<_> = pairs
        .map(|(a, b)| [grid.hops(a, b) as f64, distance(a, b)])
        .collect();
    let (quality, hits) = map.quality(samples);
    MapTopology {
        neighbors,
        others,
        topographic_error: f64::from(quality.apart()) / f64::from(quality.samples().max(1)),
        correlation: pearson(&pairs),
        as_good_by_chance,
        hit_spread: hit_spread(&hits, samples.len()),
        idle: hits.iter().filter(|&&hit| hit == 0).count(),
    }
}

/// Standard deviation of the samples per neuron, divided by their mean.
fn hit_spread(hits: &[u32], samples: usize) -> f64 {
    let neurons = hits.len() as f64;
    let mean = samples as f64 / neurons;
    let squares = hits
        .iter()
        .map(|&hit| (f64::from(hit) - mean) * (f64::from(hit) - mean))
        .sum::<f64>();
    (squares / neurons).sqrt() / mean.max(f64::MIN_POSITIVE)
}

/// Mean distances of neighbors and of other pairs when neuron `k` has the code vector of
/// `places[k]`.
fn means(
    grid: Grid,
    neurons: usize,
    places: &[usize],
    distance: impl Fn(usize, usize) -> f64,
) -> (f64, f64) {
    let mut sums = [(0.0, 0_u32); 2];
    for a in 0..neurons {
        for b in 0..a {
            let (sum, count) = &mut sums[usize::from(grid.hops(a, b) > 1)];
            *sum += distance(places[a], places[b]);
            *count += 1;
        }
    }
    let mean = |(sum, count): (f64, u32)| sum / f64::from(count.max(1));
    (mean(sums[0]), mean(sums[1]))
}

fn difference(a: &[Weight32], b: &[Weight32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| {
        let gap: f64 = a.to_num::<f64>() - b.to_num::<f64>();
        gap * gap
    });
    squares.sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chain(values: [f64; 8]) -> Som<8, 1> {
        Som::new(Grid::chain(8), values.map(|v| [Weight::from_num(v)]))
    }

    #[test]
    fn a_sorted_chain_is_orderly_and_a_mixed_one_is_not() {
        let samples: Vec<_> = (0..8)
            .map(|i| [Weight::from_num(f64::from(i) / 8.0)])
            .collect();
        let sorted = std::array::from_fn(|i| i as f64 / 8.0);
        let good = topology_of(&chain(sorted), &samples, 1);
        assert!((good.neighbors - 0.125).abs() < 1e-3);
        assert!((good.correlation - 1.0).abs() < 1e-6);
        assert_eq!((good.topographic_error, good.idle), (0.0, 0));
        assert_eq!(good.hit_spread, 0.0);
        assert!(good.as_good_by_chance <= 2);
        let mixed = [0.0, 0.5, 0.125, 0.625, 0.25, 0.75, 0.375, 0.875];
        let bad = topology_of(&chain(mixed), &samples, 1);
        assert!(bad.neighbors > 3.0 * good.neighbors);
        assert!(bad.as_good_by_chance > 200 && bad.topographic_error > 0.5);
    }
}
