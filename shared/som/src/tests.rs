use super::*;
use crate::fixed::{
    FINE_ONE_BITS, ONE_BITS, Scalar as _, approach, squared_distance, squared_norm, unit_weight,
};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::vec::Vec;

mod accelerated;
#[cfg(feature = "alloc")]
mod dynamic;
mod float_reference;

const SQUARE: Grid = Grid::rectangle(4, 4);

fn weights(bits: impl IntoIterator<Item = i16>) -> Vec<Weight> {
    bits.into_iter().map(Weight::from_bits).collect()
}

fn components(
    range: core::ops::RangeInclusive<i16>,
    count: usize,
) -> impl Strategy<Value = Vec<Weight>> {
    prop::collection::vec(range, count).prop_map(weights)
}

fn map_of<const NEURONS: usize, const DIMS: usize>(
    grid: Grid,
    code: &[Weight],
) -> Som<NEURONS, DIMS> {
    let rows = code.as_chunks().0;
    Som::new(grid, core::array::from_fn(|k| rows[k]))
}

/// Index of the smallest value, the first on ties.
fn first_minimum(values: &[u64]) -> usize {
    let least = values.iter().min().unwrap();
    values.iter().position(|value| value == least).unwrap()
}

proptest! {
    #[test]
    fn a_code_vector_is_its_own_bmu(code in components(-8192..=8192, 64), k in 0_usize..16) {
        let map: Som<16, 4> = map_of(SQUARE, &code);
        let probe = map.code_vector(k);
        prop_assert_eq!(map.scores(&probe, Mask::ALL)[k] + squared_norm(&probe), 0);
        prop_assert_eq!(map.code_vector(map.bmu(&probe, Mask::ALL)), probe);
    }

    /// Uses few different values, so that ties are frequent.
    #[test]
    fn the_bmu_is_nearest_and_first(
        code in components(-3..=3, 48),
        probe in components(-3..=3, 3),
        mask in 0_u32..8,
        other in components(-3..=3, 16),
        weight in any::<u16>(),
    ) {
        let map: Som<16, 3> = map_of(SQUARE, &code);
        let probe: [Weight; 3] = probe.try_into().unwrap();
        let mask = Mask::from_bits(mask);
        let rows = map.code().iter();
        let mut distances: Vec<_> = rows.map(|row| squared_distance(row, &probe, mask)).collect();
        prop_assert_eq!(map.bmu(&probe, mask), first_minimum(&distances));
        let other: Som<16, 1> = map_of(SQUARE, &other);
        for (k, distance) in distances.iter_mut().enumerate() {
            let squared = other.distance(k, &[Weight::ZERO], Mask::ALL);
            *distance += (squared >> 8) * u64::from(weight);
        }
        let bmu = map.joint_bmu(&probe, mask, &other, &[Weight::ZERO], weight);
        prop_assert_eq!(bmu, first_minimum(&distances));
    }

    #[test]
    fn masked_out_components_have_no_effect(
        code in components(-8192..=8192, 80),
        probe in components(-8192..=8192, 5),
        masked_out in 0_usize..5,
        value in -8192_i16..=8192,
    ) {
        let map: Som<16, 5> = map_of(SQUARE, &code);
        let mask = Mask::ALL.without(masked_out);
        let probe: [Weight; 5] = probe.try_into().unwrap();
        let mut other = probe;
        other[masked_out] = Weight::from_bits(value);
        prop_assert_eq!(map.scores(&probe, mask), map.scores(&other, mask));
        prop_assert_eq!(map.projections(&probe, mask), map.projections(&other, mask));
        prop_assert_eq!(map.alignments(&probe, mask), map.alignments(&other, mask));
        let mut learned = map.clone();
        learned.train_step(&probe, mask, &Update::new(Neighborhood::Gaussian, 0.5, 1.0));
        for (before, after) in map.code().iter().zip(learned.code()) {
            prop_assert_eq!(before[masked_out], after[masked_out]);
        }
    }

    /// Each neuron moves by `approach` with the gain of its grid distance; all others stay.
    #[test]
    fn an_update_moves_the_bmu_and_its_neighbors(
        code in components(-8192..=8192, 64),
        bmu in 0_usize..16,
        rate in 1_u32..=65_536,
        share in 0_u32..=65_536,
        torus in any::<bool>(),
        mask in any::<u32>(),
    ) {
        let edges = if torus { Edges::Wrapped } else { Edges::Open };
        let map: Som<16, 4> = map_of(SQUARE.with_edges(edges), &code);
        let mut learned = map.clone();
        let (probe, mask) = ([Weight::ONE; 4], Mask::from_bits(mask));
        let update = Update::from_q16(Neighborhood::Direct, rate, share);
        learned.update(bmu, &probe, mask, &update);
        let rate = Gain::from_q16(rate);
        for k in 0..16 {
            let gain = match map.grid().hops(bmu, k) {
                0 => rate,
                1 => rate.times(Gain::from_q16(share)),
                _ => Gain::ZERO,
            };
            for i in 0..4 {
                let before = map.code()[k][i];
                let moved = approach(before, Weight::ONE.to_weight32(), gain);
                let expected = if mask.contains(i) { moved } else { before };
                prop_assert_eq!(learned.code()[k][i], expected);
            }
        }
    }

    /// Compares with a computation in floats, for another size of map.
    #[test]
    fn projections_and_alignments_follow_their_formulas(
        code in components(-8192..=8192, 7 * 40), probe in components(-8192..=8192, 40),
    ) {
        let map: Som<7, 40> = map_of(Grid::chain(7), &code);
        let probe: [Weight; 40] = probe.try_into().unwrap();
        let real = |row: &[Weight]| row.iter().map(|w| w.to_num::<f64>()).collect::<Vec<_>>();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let rows: Vec<_> = (0..7).map(|k| real(&map.code_vector(k))).collect();
        let length = |row: &[f64]| libm::sqrt(dot(row, row));
        let mean = rows.iter().map(|row| length(row)).sum::<f64>() / 7.0;
        let (projections, alignments) = (map.projections(&probe, Mask::ALL), map.alignments(&probe, Mask::ALL));
        for (k, row) in rows.iter().enumerate() {
            let product = dot(row, &real(&probe));
            prop_assert!((projections[k] as f64 / f64::from(1 << 26) - product).abs() < 1e-9);
            let exact = product / (length(row) + mean);
            let found = alignments[k] as f64 / f64::from(ONE_BITS);
            prop_assert!((found - exact).abs() < 1e-3 + exact.abs() * 1e-3, "{found} {exact}");
        }
    }

    #[test]
    fn hits_and_u_matrix_add_up(
        code in components(-8192..=8192, 64), samples in components(-8192..=8192, 4 * 50),
    ) {
        let map: Som<16, 4> = map_of(SQUARE, &code);
        let (_, hits) = map.quality(samples.as_chunks().0);
        prop_assert_eq!(hits.iter().sum::<u32>(), 50);
        // Each of the 24 edges counts twice, once per neuron.
        let edge = |a: usize, b: usize| {
            let squared = squared_distance(&map.code()[a], &map.code()[b], Mask::ALL);
            libm::sqrt(squared as f64) / 4096.0
        };
        let sides = (0..16).flat_map(|a| SQUARE.neighbors(a).map(move |b| (a, b)));
        let sum: f64 = sides.map(|(a, b)| edge(a, b)).sum();
        let values = map.u_matrix();
        let counted = (0..16).map(|k| f64::from(values[k]) * SQUARE.neighbors(k).count() as f64);
        prop_assert!((sum - counted.sum::<f64>()).abs() <= 48.0 * 2.0);
    }
}

/// 64 neurons with 300 components, and one neuron with one.
#[test]
fn maps_have_any_size() {
    let value = |seed: usize| Weight::from_bits((seed * 7919 % 8192) as i16);
    let code: [[Weight; 300]; 64] =
        core::array::from_fn(|k| core::array::from_fn(|i| value(k * 300 + i)));
    let mut map = Som::<64, 300>::new(Grid::rectangle(8, 8), code);
    for (k, row) in code.iter().enumerate() {
        assert_eq!(map.bmu(row, Mask::ALL), k);
        assert_eq!(map.distance(k, row, Mask::ALL), 0);
    }
    let far = [Weight::ONE; 300];
    let update = Update::new(Neighborhood::Gaussian, 1.0, 0.0);
    let bmu = map.train_step(&far, Mask::ALL, &update);
    assert_eq!(map.code_vector(bmu), far);
    let mut one = Som::<1, 1>::zeroed(Grid::chain(1));
    assert_eq!(one.train_step(&[Weight::ONE], Mask::ALL, &update), 0);
    assert_eq!(one.code_vector(0), [Weight::ONE]);
    assert_eq!((one.u_matrix(), one.code_vector(1)), ([0], [Weight::ZERO]));
}

/// Code vectors with the most components at the ends of their range.
#[test]
fn the_largest_distance_fits() {
    let rows = [[Weight::ONE; MAX_DIMS], [-Weight::ONE; MAX_DIMS]];
    let map = Som::<2, MAX_DIMS>::new(Grid::chain(2), rows);
    assert_eq!(map.distance(1, &rows[0], Mask::ALL), 4095 << 52);
    assert_eq!(map.bmu(&rows[1], Mask::ALL), 1);
}

/// Four neurons in a chain at 0, 1/4, 1 and 1/2: the last two are in the wrong order.
#[test]
fn errors_match_hand_computed_values() {
    let rows = [[0], [2048], [8192], [4096]].map(|row| row.map(Weight::from_bits));
    let map = Som::<4, 1>::new(Grid::chain(4), rows);
    // The second-best neurons are 1, 3 (not a neighbor), 1 (not a neighbor), 3 and 1.
    let samples = [819, 2867, 4000, 8192, 819].map(|bits| [Weight::from_bits(bits)]);
    let (quality, hits) = map.quality(&samples);
    assert_eq!(hits, [2, 1, 1, 1]);
    let mean = f64::from(819 + 819 + 96 + 819) / 8192.0 / 5.0;
    assert!((quality.quantization_error() - mean).abs() < 1e-6);
    assert!((quality.topographic_error() - 0.4).abs() < 1e-12);
    assert_eq!((quality.samples(), quality.apart()), (5, 2));
    assert!((quality.largest_distance() - 819.0 / 8192.0).abs() < 1e-6);
    assert_eq!(Quality::default().quantization_error(), 0.0);
    assert_eq!(Quality::default().topographic_error(), 0.0);
}

/// The mean distance has novelty 1, the largest one has `largest_novelty`.
#[test]
fn novelty_is_relative_to_the_samples() {
    let map = Som::<2, 1>::new(Grid::chain(2), [[Weight::ZERO], [Weight::ONE]]);
    let sample = |bits: i16| [Weight::from_bits(bits)];
    let (seen, _) = map.quality(&[sample(512), sample(8192 - 1536)]);
    assert!((map.novelty(&sample(1024), &seen) - 1.0).abs() < 1e-6);
    assert!((seen.largest_novelty() - 1.5).abs() < 1e-6);
    assert!((map.novelty(&sample(4096), &seen) - 4.0).abs() < 1e-6);
    assert_eq!(map.novelty(&sample(0), &seen), 0.0);
    // Without samples the quantization error is 0.
    assert_eq!(map.novelty(&sample(9), &Quality::default()), f32::INFINITY);
    assert_eq!(map.novelty(&sample(0), &Quality::default()), 0.0);
    assert_eq!(Quality::default().largest_novelty(), 0.0);
}

#[test]
fn maps_are_equal_by_their_grids_and_code_vectors() {
    let map =
        |rows: [[i16; 2]; 2]| Som::new(Grid::chain(2), rows.map(|row| row.map(Weight::from_bits)));
    let one = map([[300, 400], [0, 5]]);
    assert_eq!(one, map([[300, 400], [0, 5]]));
    assert_ne!(one, map([[400, 300], [5, 0]]), "another order");
    let mut other = one.clone();
    other.set_grid(Grid::rectangle(1, 2));
    assert_ne!(one, other);
    other.set_grid(Grid::chain(2));
    assert_eq!(one, other);
    other.clear();
    assert_eq!(other, Som::zeroed(Grid::chain(2)));
}

#[test]
fn components_are_always_clamped() {
    let ends = [Weight::from_bits(i16::MAX), Weight::from_bits(i16::MIN)];
    let mut map = Som::<2, 2>::new(Grid::chain(2), [ends, [Weight::ZERO; 2]]);
    assert_eq!(map.code_vector(0), [Weight::ONE, -Weight::ONE]);
    map.set_component(3, Weight32::from_bits(i32::MIN));
    map.set_component(4, Weight32::from_bits(9));
    map.set_code_vector(2, &[Weight::ONE; 2]);
    assert_eq!(map.code_vector(1), [Weight::ZERO, -Weight::ONE]);
    assert_eq!(map.component(3), Some(Weight32::from_bits(-FINE_ONE_BITS)));
    assert_eq!(
        (map.component(4), map.code_vector(2)),
        (None, [Weight::ZERO; 2])
    );
}

/// `train` equals single steps in the given order; shuffled, it presents the same samples.
#[test]
fn train_equals_single_steps() {
    let given: [[Weight; 2]; 9] =
        core::array::from_fn(|i| [Weight::from_bits(900 * i as i16), Weight::ZERO]);
    let config = |order| TrainConfig {
        neighborhood: Neighborhood::Gaussian,
        rate: Schedule::new(0.5, 0.01, Decay::Exponential),
        radius: Schedule::new(1.5, 0.3, Decay::Linear),
        epochs: 3,
        order,
    };
    let start = Som::<16, 2>::zeroed(SQUARE);
    let (mut samples, mut map) = (given, start.clone());
    map.train(
        &mut samples,
        &config(SampleOrder::AsGiven),
        |_| unreachable!(),
    );
    let mut stepped = start.clone();
    for step in 0..27 {
        let TrainConfig { rate, radius, .. } = config(SampleOrder::AsGiven);
        let update = Update::from_q16(
            Neighborhood::Gaussian,
            rate.at(step, 27),
            radius.at(step, 27),
        );
        stepped.train_step(&given[step as usize % 9], Mask::ALL, &update);
    }
    assert_eq!((samples, &map), (given, &stepped));

    let mut generator = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut shuffled = start.clone();
    shuffled.train(&mut samples, &config(SampleOrder::Shuffled), |below| {
        assert!((2..=9).contains(&below));
        generator.next_u32() as usize % below
    });
    let mut sorted = samples;
    sorted.sort();
    assert_eq!(sorted, given, "the same samples in another order");
    assert_ne!((shuffled, samples), (map, given));
}
