//! A map with kernels compared with one without; plain Rust kernels replace the CPU-specific ones.

use super::*;
use crate::fixed::high_product;
use crate::kernels::{Group, Kernels};
use core::cell::Cell;

/// Kernels in portable Rust.
static PLAIN: Kernels = Kernels { candidates, update };

std::thread_local! {
    /// Number of calls of `candidates` and of `update` in this thread.
    static CALLS: Cell<[u32; 2]> = const { Cell::new([0; 2]) };
}

/// Returns the numbers of calls and resets them.
fn take_calls() -> [u32; 2] {
    CALLS.replace([0; 2])
}

fn count_call(kernel: usize) {
    let mut calls = CALLS.get();
    calls[kernel] += 1;
    CALLS.set(calls);
}

extern "C" fn candidates(
    code: &[[Weight32; 16]; 16],
    bases: &[i32; 16],
    probe: &[Weight; 16],
    margin: i32,
) -> u32 {
    count_call(0);
    let product = |(w, x): (&Weight32, &Weight)| {
        ((i64::from(w.to_bits()) * i64::from(x.to_bits())) >> 16) as i32
    };
    let ranks: [i32; 16] = core::array::from_fn(|k| {
        (bases[k] >> 1) - code[k].iter().zip(probe).map(product).sum::<i32>()
    });
    let least = *ranks.iter().min().unwrap();
    let candidates = (0..16).filter(|k| ranks[*k] <= least.saturating_add(margin));
    let candidates: Vec<u32> = candidates.map(|k| k as u32).collect();
    match candidates[..] {
        [only] => only,
        _ => candidates.iter().map(|k| 1 << (16 + k)).sum(),
    }
}

extern "C" fn update(
    code: &mut [[Weight32; 16]; 16],
    norms: &mut [i32; 16],
    probe: &[Weight; 16],
    groups: &[Group; 2],
) {
    count_call(1);
    for group in groups {
        let gain = Gain::from_bits((group.gain_q32 >> 2) as u32);
        for k in (0..16).filter(|k| group.neurons & (1 << k) != 0) {
            for (w, x) in code[k].iter_mut().zip(probe) {
                *w = approach(*w, x.to_weight32(), gain);
            }
            norms[k] = code[k]
                .iter()
                .map(|w| high_product(w.to_bits(), w.to_bits()))
                .sum();
        }
    }
}

proptest! {
    /// BMUs and updates are the same, for code vectors that differ by a few units or by much.
    #[test]
    fn kernels_do_not_change_results(
        middle in components(-8_192..=8_192, 16),
        shifts in prop::collection::vec(-8_192_i32..=8_192, 16 * 16),
        spread in prop_oneof![Just(1), Just(200), Just(1 << 17)],
        probes in components(-8_192..=8_192, 4 * 16),
        other in components(-8_192..=8_192, 2 * 16),
        weight in prop_oneof![Just(511_u16), Just(512), 0_u16..600],
        wrapped in any::<bool>(),
        rate in 0_u32..=65_536,
        share in prop_oneof![Just(0_u32), 0_u32..=65_536],
        mask in prop_oneof![Just(Mask::ALL), any::<u32>().prop_map(Mask::from_bits)],
    ) {
        let edges = if wrapped { Edges::Wrapped } else { Edges::Open };
        let mut portable = Som::<16, 16>::zeroed(SQUARE.with_edges(edges));
        for (index, shift) in shifts.iter().enumerate() {
            let value = (i32::from(middle[index % 16].to_bits()) << 16).saturating_add(shift * spread);
            portable.set_component(index, Weight32::from_bits(value));
        }
        let mut map = portable.clone();
        map.use_kernels(&PLAIN);
        let update = Update::from_q16(Neighborhood::Direct, rate, share);
        let actions: Som<16, 2> = map_of(SQUARE, &other);
        // The last probe equals a code vector.
        let own = portable.code_vector(3);
        for probe in probes.as_chunks::<16>().0.iter().chain([&own]) {
            let bmu = portable.bmu(probe, mask);
            prop_assert_eq!(map.bmu(probe, mask), bmu);
            let action = [probe[0], probe[15]];
            let joint = |map: &Som<16, 16>| map.joint_bmu(probe, mask, &actions, &action, weight);
            prop_assert_eq!(joint(&map), joint(&portable));
            portable.update(bmu, probe, mask, &update);
            map.update(bmu, probe, mask, &update);
            prop_assert_eq!(&map, &portable);
        }
        // A code vector set from outside updates the kernels' norm.
        portable.set_code_vector(2, &own);
        map.set_code_vector(2, &own);
        prop_assert_eq!(map.bmu(&own, Mask::ALL), portable.bmu(&own, Mask::ALL));
    }
}

/// Counts calls: results do not show whether the kernels were used.
#[test]
fn kernels_are_used_for_maps_of_their_size() {
    let mut map = Som::<16, 16>::zeroed(SQUARE);
    map.use_kernels(&PLAIN);
    assert!(map.has_kernels() && !Som::<16, 16>::zeroed(SQUARE).has_kernels());
    let (probe, partial) = ([Weight::ONE; 16], Mask::ALL.without(3));
    let actions = Som::<16, 2>::zeroed(SQUARE);
    let update = |rate| Update::from_q16(Neighborhood::Direct, rate, 0);
    take_calls();
    for mask in [Mask::ALL, partial] {
        let _ = map.bmu(&probe, mask);
        assert_eq!(take_calls(), [1, 0]);
        let _ = map.joint_bmu(&probe, mask, &actions, &[Weight::ONE; 2], 511);
        assert_eq!(take_calls(), [1, 0]);
        map.update(0, &probe, mask, &update(32_767));
        assert_eq!(take_calls(), [0, 1]);
    }
    let _ = map.joint_bmu(&probe, Mask::ALL, &actions, &[Weight::ONE; 2], 512);
    let three = Som::<16, 3>::zeroed(SQUARE);
    let _ = map.joint_bmu(&probe, Mask::ALL, &three, &[Weight::ONE; 3], 1);
    map.update(0, &probe, Mask::ALL, &update(32_768));
    map.update(
        0,
        &probe,
        Mask::ALL,
        &Update::new(Neighborhood::Gaussian, 0.1, 0.5),
    );
    assert_eq!(take_calls(), [0; 2]);
    // The same number of components, but another size.
    let mut other = Som::<32, 8>::zeroed(Grid::chain(32));
    other.use_kernels(&PLAIN);
    assert!(!other.has_kernels());
}
