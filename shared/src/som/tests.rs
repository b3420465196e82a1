use super::*;
use crate::fixed::{ONE_BITS, squared_distance};
use metrics::{MapView, Quality};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::vec;
use std::vec::Vec;

const SQUARE: Grid = Grid::rectangle(4, 4);

fn to_weight32(bits: impl IntoIterator<Item = i16>) -> Vec<Weight32> {
    weights(bits).into_iter().map(|w| w.to_weight32()).collect()
}

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

proptest! {
    #[test]
    fn a_code_vector_is_its_own_winner(code in components(-8192..=8192, 64), k in 0_usize..16) {
        let map: Som<16, 4> = map_of(SQUARE, &code);
        let probe = map.code_vector(k);
        let score = map.scores(&probe)[k];
        prop_assert_eq!(score + squared_norm(&probe), 0);
        prop_assert_eq!(map.code_vector(map.winner(&probe, Mask::ALL)), probe);
    }

    #[test]
    fn the_winner_is_nearest_and_first(
        code in components(-3..=3, 48), probe in components(-3..=3, 3), mask in 0_u32..8,
    ) {
        // Few different values make many ties.
        let map: Som<16, 3> = map_of(SQUARE, &code);
        let probe: [Weight; 3] = probe.try_into().unwrap();
        let mask = Mask::from_bits(mask);
        let distances: Vec<_> = map.code().iter().map(|row| squared_distance(row, &probe, mask)).collect();
        let least = distances.iter().min().unwrap();
        let first = distances.iter().position(|d| d == least).unwrap();
        prop_assert_eq!(map.winner(&probe, mask), first);
        let (best, second) = kernels::two_least(&map.scores_masked(&probe, mask));
        prop_assert_eq!(best, first);
        let others = distances.iter().enumerate().filter(|(k, _)| *k != first);
        prop_assert_eq!(Some(second), others.min_by_key(|(_, d)| **d).map(|(k, _)| k));
    }

    #[test]
    fn a_row_moves_as_its_components_do(
        pairs in prop::collection::vec((-1_i32 << 29..=1 << 29, -8192_i16..=8192), 9),
        gain in prop_oneof![Just(0_u32), Just(1), Just((1 << 30) - 1), Just(1 << 30), 0_u32..=1 << 30],
        bits in any::<u32>(),
        all in any::<bool>(),
    ) {
        let mut map: Som<16, 9> = Som::zeroed(SQUARE);
        let row: [Weight32; 9] = std::array::from_fn(|i| Weight32::from_bits(pairs[i].0));
        let probe: [Weight; 9] = std::array::from_fn(|i| Weight::from_bits(pairs[i].1));
        let gain = Gain::from_bits(gain);
        let mask = if all { Mask::ALL } else { Mask::from_bits(bits) };
        map.code[7] = row;
        map.pull(7, &probe, mask, gain);
        for (i, &w) in map.code[7].iter().enumerate() {
            let expected = if mask.contains(i) { crate::fixed::approach(row[i], probe[i].to_weight32(), gain) } else { row[i] };
            prop_assert_eq!(w, expected);
        }
        prop_assert_eq!(map.norms[7], kernels::length_squared(&map.code[7]));
    }

    /// Code vectors a few units of the last place apart, far below what the search by 16 bits can see.
    #[test]
    fn the_winner_is_nearest_in_full_precision(
        middle in components(-8000..=8000, 4), shifts in prop::collection::vec(-40_i32..=40, 64), probe in components(-8192..=8192, 4),
        rate in 0_u32..=65_536, mask in 1_u32..16,
    ) {
        let mut map: Som<16, 4> = Som::zeroed(SQUARE);
        for (k, shift) in shifts.chunks_exact(4).enumerate() {
            for (i, shift) in shift.iter().enumerate() {
                map.code[k][i] = Weight32::from_bits(middle[i].to_weight32().to_bits() + shift * 3_001);
            }
            map.norms[k] = squared_norm(&map.code[k]) as i32;
        }
        let probe: [Weight; 4] = probe.try_into().unwrap();
        let mask = Mask::from_bits(mask);
        map.learn(5, &probe, mask, &Update::new(Neighborhood::Direct, rate / 100, 30_000));
        let distances: Vec<_> = (0..16).map(|k| map.distance(k, &probe, mask)).collect();
        let least = distances.iter().min().unwrap();
        prop_assert_eq!(map.winner(&probe, mask), distances.iter().position(|d| d == least).unwrap());
    }

    #[test]
    fn a_masked_component_does_not_count(
        code in components(-8192..=8192, 80), probe in components(-8192..=8192, 5), off in 0_usize..5, junk in -8192_i16..=8192,
    ) {
        let map: Som<16, 5> = map_of(SQUARE, &code);
        let mask = Mask::ALL.without(off);
        let probe: [Weight; 5] = probe.try_into().unwrap();
        let mut other = probe;
        other[off] = Weight::from_bits(junk);
        prop_assert_eq!(map.scores_masked(&probe, mask), map.scores_masked(&other, mask));
        prop_assert_eq!(map.projections(&probe, mask), map.projections(&other, mask));
        prop_assert_eq!(map.alignments(&probe, mask), map.alignments(&other, mask));
        let (mut learned, winner) = (map.clone(), map.winner(&probe, mask));
        learned.learn(winner, &probe, mask, &Update::new(Neighborhood::Gaussian, 1 << 15, 1 << 16));
        for (before, after) in map.code().iter().zip(learned.code()) {
            prop_assert_eq!(before[off], after[off]);
        }
    }

    #[test]
    fn the_direct_neighborhood_moves_nobody_else(
        code in components(-8192..=0, 64), winner in 0_usize..16, rate in 1_u32..=65_536, share in 1_u32..=65_536, torus in any::<bool>(),
    ) {
        let edges = if torus { Edges::Wrapped } else { Edges::Open };
        let map: Som<16, 4> = map_of(SQUARE.with_edges(edges), &code);
        let probe = [Weight::ONE; 4];
        let mut learned = map.clone();
        learned.learn(winner, &probe, Mask::ALL, &Update::new(Neighborhood::Direct, rate, share));
        let gain = Gain::from_q16(rate);
        for k in 0..16 {
            let gain = match map.grid().hops(winner, k) {
                0 => gain,
                1 => gain.times(Gain::from_q16(share)),
                _ => Gain::ZERO,
            };
            let expected = map.code()[k].map(|w| crate::fixed::approach(w, Weight::ONE.to_weight32(), gain));
            prop_assert_eq!(learned.code()[k], expected);
        }
    }

    #[test]
    fn flat_slices_are_searched_the_same(
        code in components(-8192..=8192, 12 * 19), probes in components(0..=8192, 8 * 19), gaussian in any::<bool>(), radius in 0_u32..200_000,
    ) {
        let grid = Grid::rectangle(4, 3);
        let shape = if gaussian { Neighborhood::Gaussian } else { Neighborhood::Direct };
        let mut map: Som<12, 19> = map_of(grid, &code);
        let mut scores = vec![0; 12];
        for probe in probes.as_chunks::<19>().0 {
            let winner = map.winner(probe, Mask::ALL);
            let flat = map.code().as_flattened();
            kernels::scores(flat, flat.chunks_exact(19).map(squared_norm), 19, probe, &mut scores);
            let distance = |k| kernels::distance(flat, 19, k, probe, Mask::ALL);
            prop_assert_eq!(kernels::nearest(&scores, 19, 1, distance), winner);
            map.learn(winner, probe, Mask::ALL, &Update::new(shape, 20_000, radius));
        }
        prop_assert_eq!(map.norms, map.code().each_ref().map(|row| kernels::length_squared(row)));
    }

    #[test]
    fn hits_and_u_matrix_add_up(code in components(-8192..=8192, 64), samples in components(-8192..=8192, 4 * 50)) {
        let map: Som<16, 4> = map_of(SQUARE, &code);
        let (_, hits) = map.quality(samples.as_chunks().0);
        prop_assert_eq!(hits.iter().sum::<u32>(), 50);
        // Each of the 24 edges counts once on either side.
        let edge = |a: usize, b: usize| {
            libm::sqrt(squared_distance(&map.code()[a], &map.code()[b], Mask::ALL) as f64) / 4096.0
        };
        let sides = (0..16).flat_map(|a| SQUARE.neighbors(a).map(move |b| (a, b)));
        let sum: f64 = sides.map(|(a, b)| edge(a, b)).sum();
        let values = map.u_matrix();
        let counted: f64 = (0..16).map(|k| f64::from(values[k]) * SQUARE.neighbors(k).count() as f64).sum();
        prop_assert!((sum - counted).abs() <= 48.0 * 2.0, "{} {}", sum, counted);
    }
}

/// Four neurons in a row at 0, 1/4, 1 and 1/2: the last two are out of order.
#[test]
fn errors_of_a_map_worked_simd() {
    let code = to_weight32([0, 2048, 8192, 4096]);
    let map = MapView {
        grid: Grid::chain(4),
        code: &code,
        dims: 1,
    };
    let mut scores = [0; 4];
    let mut quality = Quality::default();
    // Sample, its winner, distance: the runners-up are 2, 4 (two steps off), 2 (two steps off), 4 and 2.
    for (sample, winner) in [(819, 0), (2867, 1), (4000, 3), (8192, 2), (819, 0)] {
        assert_eq!(quality.add(map, &weights([sample]), &mut scores), winner);
    }
    let mean = f64::from(819 + 819 + 96 + 819) / 8192.0 / 5.0;
    let error = quality.quantization_error_q21() as f64 / f64::from(1 << 21);
    assert!((error - mean).abs() < 1e-6, "{error} {mean}");
    assert_eq!(quality.topographic_error_q16(), 2 * 65_536 / 5);
    assert_eq!((quality.samples(), quality.apart()), (5, 2));
    assert_eq!(Quality::default().quantization_error_q21(), 0);
    assert_eq!(Quality::default().topographic_error_q16(), 0);
}

/// The same map in 64-bit floats: what the fixed-point one is compared with.
struct Twin {
    code: Vec<[f64; 16]>,
}

impl Twin {
    fn of(map: &Som<16, 16>) -> Self {
        let code = map
            .code()
            .iter()
            .map(|row| row.map(|w| w.to_num::<f64>()))
            .collect();
        Self { code }
    }

    fn nearest(&self, probe: &[f64; 16]) -> (usize, f64) {
        let squared = |row: &[f64; 16]| {
            row.iter()
                .zip(probe)
                .map(|(w, x)| (w - x) * (w - x))
                .sum::<f64>()
        };
        let distances = self.code.iter().map(squared).enumerate();
        let (k, least) = distances.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        (k, libm::sqrt(least))
    }

    fn learn(&mut self, winner: usize, probe: &[f64; 16], rate: f64, radius: f64) {
        for (k, row) in self.code.iter_mut().enumerate() {
            let (dx, dy) = SQUARE.offsets(winner, k);
            let gain = rate * libm::exp(-((dx * dx + dy * dy) as f64) / (2.0 * radius * radius));
            for (w, x) in row.iter_mut().zip(probe) {
                *w += gain * (x - *w);
            }
        }
    }
}

/// A ring in a rectangular room: smooth values in [0, 1] with a little noise, as a situation has them.
fn sonar_like(generator: &mut Xoshiro256PlusPlus) -> [Weight; 16] {
    let mut uniform = || f64::from(generator.next_u32() >> 8) / f64::from(1 << 24);
    let sides = [3.0 + 5.0 * uniform(), 3.0 + 5.0 * uniform()];
    let place = sides.map(|side| 0.4 + (side - 0.8) * uniform());
    let heading = uniform();
    core::array::from_fn(|sensor| {
        let angle = core::f64::consts::TAU * (heading + sensor as f64 / 16.0);
        let ahead = |along: f64, place: f64, side: f64| {
            let gap = if along > 0.0 { side - place } else { place };
            gap / along.abs().max(1e-9)
        };
        let (x, y) = (
            ahead(libm::cos(angle), place[0], sides[0]),
            ahead(libm::sin(angle), place[1], sides[1]),
        );
        let range = x.min(y) * (0.98 + 0.04 * uniform());
        let value = ((3.0 - range) / 2.75).clamp(0.0, 1.0);
        crate::fixed::unit_weight((value * f64::from(ONE_BITS)) as i32)
    })
}

// Miri takes some thousand times as long.
const SEEDS: u64 = if cfg!(miri) { 1 } else { 10 };
const STEPS: u32 = if cfg!(miri) { 40 } else { 20_000 };
const PROBES: usize = if cfg!(miri) { 40 } else { 10_000 };

/// 20 000 presentations in fixed point and, from the same start and on the same sequence, in 64-bit floats, each map
/// learning at its own winners: the winner is the same for at least 99.5 % of 10 000 probes afterwards (and of the
/// presentations), the quantization error within 0.5 %.
///
/// Where two neurons are equally near the last bit decides, and two maps that once learned at different neurons may part
/// for good. That the two stay together needs all of it: 32-bit code vectors, winners in full precision, fine gains.
#[test]
fn the_fixed_point_map_is_its_twin_in_floats() {
    let rate = Schedule::new(32_768, 655, Decay::Exponential);
    let radius = Schedule::new(2 << 16, 19_661, Decay::Exponential);
    let q16 = |value: u32| f64::from(value) / 65_536.0;
    for seed in 1..=SEEDS {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
        let start = core::array::from_fn(|_| sonar_like(&mut generator));
        let mut map = Som::<16, 16>::new(SQUARE, start);
        let mut twin = Twin::of(&map);
        let mut agreed = 0;
        for step in 0..STEPS {
            let probe = sonar_like(&mut generator);
            let exact = probe.map(|w| w.to_num());
            let (rate, radius) = (rate.at(step, STEPS), radius.at(step, STEPS));
            let winner = map.winner(&probe, Mask::ALL);
            let twins = twin.nearest(&exact).0;
            agreed += u32::from(twins == winner);
            let pull = Update::new(Neighborhood::Gaussian, rate, radius);
            map.learn(winner, &probe, Mask::ALL, &pull);
            twin.learn(twins, &exact, q16(rate), q16(radius));
        }
        let probes: Vec<_> = (0..PROBES).map(|_| sonar_like(&mut generator)).collect();
        let found = probes.iter().map(|p| twin.nearest(&p.map(|w| w.to_num())));
        let (winners, distances): (Vec<_>, Vec<_>) = found.unzip();
        let exact = distances.iter().sum::<f64>() / PROBES as f64;
        let error = map.quality(&probes).0.quantization_error_q21() as f64 / f64::from(1 << 21);
        let same = probes.iter().zip(&winners);
        let same = same
            .filter(|(p, w)| map.winner(p, Mask::ALL) == **w)
            .count();
        let share = f64::from(agreed) / f64::from(STEPS);
        assert!(share >= 0.995, "seed {seed}: {share}");
        assert!(same as f64 >= 0.995 * PROBES as f64, "seed {seed}: {same}");
        assert!(
            (error / exact - 1.0).abs() <= 0.005,
            "seed {seed}: {error} {exact}"
        );
    }
}

/// [`Kernels`](kernels::Kernels) in plain words.
pub(crate) mod by_hand {
    use super::*;
    use kernels::{Group, Kernels};

    pub static KERNELS: Kernels = Kernels {
        candidates,
        weigh,
        pull,
        measure,
    };

    std::thread_local! {
        /// How often each of them was asked by this test: `candidates`, `weigh`, `pull`, `measure`.
        static ASKED: core::cell::Cell<[u32; 4]> = const { core::cell::Cell::new([0; 4]) };
    }

    fn count(kernel: usize) {
        let mut asked = ASKED.get();
        asked[kernel] += 1;
        ASKED.set(asked);
    }

    /// How often since the last time.
    pub fn asked() -> [u32; 4] {
        ASKED.replace([0; 4])
    }

    extern "C" fn candidates(
        code: &[[Weight32; 16]; 16],
        bases: &[i32; 16],
        probe: &[Weight; 16],
        margin: i32,
    ) -> u32 {
        count(0);
        let product = |(w, x): (&Weight32, &Weight)| {
            ((i64::from(w.to_bits()) * i64::from(x.to_bits())) >> 16) as i32
        };
        let ranks = std::array::from_fn::<i32, 16, _>(|k| {
            (bases[k] >> 1) - code[k].iter().zip(probe).map(product).sum::<i32>()
        });
        let least = ranks.into_iter().min().unwrap();
        let close = (0..16).filter(|k| ranks[*k] <= least.saturating_add(margin));
        let close: Vec<u32> = close.map(|k| k as u32).collect();
        match close[..] {
            [only] => only,
            _ => close.iter().map(|k| 1 << (16 + k)).sum(),
        }
    }

    extern "C" fn weigh(
        bases: &mut [i32; 16],
        code: &[[Weight32; 2]; 16],
        norms: &[i32; 16],
        factors: &[i32; 3],
    ) {
        count(1);
        let part = |value: i32, factor: i32| ((i64::from(value) * i64::from(factor)) >> 32) as i32;
        for ((base, [x, y]), norm) in bases.iter_mut().zip(code).zip(norms) {
            let values = [*norm, x.to_bits(), y.to_bits()];
            let parts = values.into_iter().zip(*factors).map(|(v, f)| part(v, f));
            *base += parts.sum::<i32>() << 9;
        }
    }

    extern "C" fn measure(
        code: &[[Weight32; 16]; 16],
        probe: &[Weight; 16],
        measures: &mut [[i32; 2]; 16],
    ) {
        count(3);
        for (measure, row) in measures.iter_mut().zip(code) {
            *measure = [squared_norm(row), crate::fixed::dot(row, probe)].map(|sum| sum as i32);
        }
    }

    extern "C" fn pull(
        code: &mut [[Weight32; 16]; 16],
        norms: &mut [i32; 16],
        probe: &[Weight; 16],
        groups: &[Group; 2],
    ) {
        count(2);
        for group in groups {
            let gain = Gain::from_q32(group.gain_q32);
            for k in (0..16).filter(|k| group.neurons & (1 << k) != 0) {
                for (w, x) in code[k].iter_mut().zip(probe) {
                    *w = crate::fixed::approach(*w, x.to_weight32(), gain);
                }
                let square = |w: &Weight32| (i64::from(w.to_bits()).pow(2) >> 32) as i32;
                norms[k] = code[k].iter().map(square).sum();
            }
        }
    }
}

proptest! {
    /// Neurons a few units apart, or anywhere: the same answers and the same lessons with kernels and without.
    #[test]
    fn kernels_for_the_processor_change_nothing(
        middle in components(-8_192..=8_192, 16), shifts in prop::collection::vec(-8_192_i32..=8_192, 16 * 16),
        far in any::<bool>(), probes in components(-8_192..=8_192, 4 * 16), wrapped in any::<bool>(),
        rate in 0_u32..=65_536, share in prop_oneof![Just(0_u32), 0_u32..=65_536], mask in prop_oneof![Just(Mask::ALL), any::<u32>().prop_map(Mask::from_bits)],
    ) {
        let edges = if wrapped { Edges::Wrapped } else { Edges::Open };
        let mut portable = Som::<16, 16>::zeroed(Grid::rectangle(4, 4).with_edges(edges));
        for (index, shift) in shifts.iter().enumerate() {
            let shift = if far { shift << 17 } else { shift * 200 };
            let value = (i32::from(middle[index % 16].to_bits()) << 15).saturating_add(shift);
            portable.set_component(index, Weight32::from_bits(value));
        }
        let mut map = portable.clone();
        map.use_kernels(&by_hand::KERNELS);
        let pull = Update::new(Neighborhood::Direct, rate, share);
        for probe in probes.as_chunks::<16>().0 {
            let winner = portable.winner(probe, mask);
            prop_assert_eq!(map.winner(probe, mask), winner);
            prop_assert_eq!(map.alignments(probe, mask), portable.alignments(probe, mask));
            portable.learn(winner, probe, mask, &pull);
            map.learn(winner, probe, mask, &pull);
            prop_assert_eq!(&map, &portable);
        }
    }
}

/// What they answer is the same as without them: who answers is seen here alone.
#[test]
fn kernels_are_asked_for_whole_rings_and_gains_below_half() {
    let mut map = Som::<16, 16>::zeroed(SQUARE);
    map.use_kernels(&by_hand::KERNELS);
    let (probe, some) = ([Weight::ONE; 16], Mask::ALL.without(3));
    let pull = |rate| Update::new(Neighborhood::Direct, rate, 0);
    by_hand::asked();
    for (mask, times) in [(Mask::ALL, 1), (some, 0)] {
        let _ = map.winner(&probe, mask);
        assert_eq!(by_hand::asked(), [times, 0, 0, 0]);
        let _ = map.alignments(&probe, mask);
        assert_eq!(by_hand::asked(), [0, 0, 0, times]);
        map.learn(0, &probe, mask, &pull(32_767));
        assert_eq!(by_hand::asked(), [0, 0, times, 0]);
    }
    map.learn(0, &probe, Mask::ALL, &pull(32_768));
    assert_eq!(by_hand::asked(), [0; 4]);
    let mut small = Som::<4, 16>::zeroed(Grid::chain(4));
    small.use_kernels(&by_hand::KERNELS);
    let _ = small.winner(&probe, Mask::ALL);
    assert_eq!(by_hand::asked(), [0; 4]);
}

#[test]
fn the_least_and_the_greatest_are_the_first_of_those_as_good() {
    assert_eq!(kernels::least(&[5, 3, 3, 9]), 1);
    assert_eq!((kernels::least(&[]), kernels::least(&[i64::MAX])), (0, 0));
    assert_eq!(kernels::two_least(&[5, 3, 4, 3]), (1, 3));
    assert_eq!(kernels::two_least(&[3, 5, 4, 4]), (0, 2));
    assert_eq!(kernels::two_least(&[7]), (0, 0));
    let greatest = |allowed| kernels::greatest(&[5, 9, 9, 2], allowed);
    assert_eq!(
        (
            greatest(Mask::ALL),
            greatest(Mask::NONE),
            greatest(Mask::ALL.without(1))
        ),
        (1, 1, 2)
    );
    assert_eq!(
        (
            greatest(Mask::NONE.with(3)),
            kernels::greatest(&[], Mask::ALL)
        ),
        (3, 0)
    );
}

#[test]
fn rivals_are_asked_in_full_precision_and_nobody_else() {
    let margin = 2 * (4 * 8_192 + 1);
    let asked = core::cell::RefCell::new(Vec::new());
    let nearest = |scores: &[i64], factor: i64| {
        asked.borrow_mut().clear();
        let distance = |k: usize| {
            asked.borrow_mut().push(k);
            9 - k as u64
        };
        (
            kernels::nearest(scores, 2, factor, distance),
            asked.borrow().clone(),
        )
    };
    assert_eq!(
        nearest(&[2 * margin + 8, 7, 2 * margin + 7], 1),
        (2, std::vec![1, 2])
    );
    assert_eq!(
        nearest(&[2 * margin + 8, 7, 2 * margin + 8], 1),
        (1, std::vec![])
    );
    assert_eq!(
        nearest(&[6 * margin, 0, 7 * margin], 3),
        (1, std::vec![0, 1])
    );
}

/// By ranks: the same with margins of their own.
#[test]
fn ranks_leave_the_rivals_within_the_margin() {
    // One for a square and 16 for a distance per component, compared, in units of 2⁻¹⁷; one per product and two for the
    // lengths.
    assert_eq!(
        (
            kernels::rank_margin::<16>(1 << 8),
            kernels::rank_margin::<2>(1 << 7)
        ),
        (1 + 18, 4)
    );
    // Upper halves: 2 · 2⁻¹³ per component.
    assert_eq!(kernels::halves_margin::<16>(), 512);
    let candidates = |ranks: [i32; 5]| kernels::candidates(&ranks, 10).to_bits();
    assert_eq!(candidates([20, 9, 19, 21, 10]), 0b1_0110);
    assert_eq!(
        (
            candidates([20, 9, 20, 21, 30]),
            candidates([9, 9, 40, 40, 40])
        ),
        (0b10, 0b11)
    );
    assert_eq!(candidates([i32::MAX; 5]), 0b1_1111);
    let found = |candidates| match Found::among(candidates) {
        Found::One(neuron) => Ok(neuron),
        Found::Rivals(candidates) => Err(candidates),
    };
    let two = Mask::NONE.with(17).with(3);
    assert_eq!((found(Mask::NONE.with(17)), found(two)), (Ok(17), Err(two)));
    let nearest =
        |candidates: u32| kernels::nearest_of(Mask::from_bits(candidates), |k| [4, 7, 3, 3][k]);
    assert_eq!((nearest(0b1111), nearest(0b1010), nearest(0b11)), (2, 3, 0));
}

#[test]
fn maps_are_equal_by_their_grids_and_code_vectors() {
    let map =
        |rows: [[i16; 2]; 2]| Som::new(Grid::chain(2), rows.map(|row| row.map(Weight::from_bits)));
    let one = map([[300, 400], [0, 5]]);
    assert_eq!(one, map([[300, 400], [0, 5]]));
    assert_ne!(one, map([[400, 300], [5, 0]]), "of the same lengths");
    let mut other = one.clone();
    other.set_grid(Grid::rectangle(1, 2));
    assert_ne!(one, other);
    other.set_grid(Grid::chain(2));
    assert_eq!(one, other);
    other.clear();
    assert_eq!(other, Som::zeroed(Grid::chain(2)));
    // Values are clamped however they come.
    assert_eq!(
        map([[i16::MAX, i16::MIN], [0, 0]]).code_vector(0),
        [Weight::ONE, -Weight::ONE]
    );
    other.set_component(3, Weight32::from_bits(i32::MIN));
    other.set_component(4, Weight32::from_bits(9));
    assert_eq!(
        (other.code_vector(1), other.component(4)),
        ([Weight::ZERO, -Weight::ONE], None)
    );
    assert_eq!(
        (other.norms()[1], other.code_vector(2)),
        (1 << 26, [Weight::ZERO; 2])
    );
    assert!(other.kernels().is_none());
}

#[test]
fn kernels_are_told_who_moves_by_how_much() {
    let groups = |rate: u32, share: u32| {
        Update::<16>::new(Neighborhood::Direct, rate, share).groups(SQUARE, 5)
    };
    let [winner, neighbors] = groups(16_384, 32_768).expect("below one half");
    assert_eq!((winner.gain_q32, winner.neurons), (1 << 30, 1 << 5));
    assert_eq!(
        (neighbors.gain_q32, neighbors.neurons),
        (1 << 29, 1 << 1 | 1 << 4 | 1 << 6 | 1 << 9)
    );
    let [_, nobody] = groups(16_384, 0).expect("below one half");
    assert_eq!((nobody.gain_q32, nobody.neurons), (0, 0));
    assert_eq!((groups(32_768, 0), groups(65_536, 65_536)), (None, None));
    assert!(groups(32_767, 65_536).is_some());
    let gaussian = Update::<16>::new(Neighborhood::Gaussian, 100, 100);
    assert_eq!(gaussian.groups(SQUARE, 5), None);
    let alone = |share| Update::<16>::new(Neighborhood::Direct, 100, share).is_alone();
    assert!(alone(0) && !alone(40_000) && !gaussian.is_alone());
}
