//! `DynSom` compared with `Som`.

use super::*;
use crate::fixed::to_weight16;

fn to_weights32(weights: &[Weight]) -> Vec<Weight32> {
    weights.iter().map(|w| w.to_weight32()).collect()
}

proptest! {
    #[test]
    fn dyn_som_equals_som(
        code in components(-8192..=8192, 12 * 19),
        samples in components(-8192..=8192, 8 * 19),
        gaussian in any::<bool>(),
        radius in 0.0_f32..3.0,
        seed in any::<u64>(),
    ) {
        let grid = Grid::rectangle(4, 3);
        let mut map: Som<12, 19> = map_of(grid, &code);
        let mut dynamic = DynSom::new(grid, 19, to_weights32(&code)).unwrap();
        let config = TrainConfig {
            neighborhood: if gaussian { Neighborhood::Gaussian } else { Neighborhood::Direct },
            rate: Schedule::new(0.4, 0.05, Decay::Linear),
            radius: Schedule::new(radius, radius / 4.0, Decay::Linear),
            epochs: 2,
            order: SampleOrder::Shuffled,
        };
        let random = || {
            let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
            move |below: usize| generator.next_u32() as usize % below
        };
        let mut rows = samples.as_chunks::<19>().0.to_vec();
        let mut flat = to_weights32(&samples);
        map.train(&mut rows, &config, random());
        dynamic.train(&mut flat, &config, random());
        prop_assert_eq!(&to_weights32(rows.as_flattened()), &flat);
        prop_assert_eq!(map.code().as_flattened(), dynamic.code_vectors().flatten().copied().collect::<Vec<_>>());
        let (quality, hits) = map.quality(&rows);
        prop_assert_eq!((quality, hits.to_vec()), dynamic.quality(&flat));
        prop_assert_eq!(map.u_matrix().to_vec(), dynamic.u_matrix());
        for (row, sample) in rows.iter().zip(flat.chunks_exact(19)) {
            prop_assert_eq!(map.bmu(row, Mask::ALL), dynamic.bmu(sample, Mask::ALL));
            prop_assert_eq!(map.novelty(row, &quality), dynamic.novelty(sample, &quality));
        }
    }
}

#[test]
fn invalid_sizes_and_values_are_clamped_or_rejected() {
    let far = [Weight32::MAX, Weight32::MIN];
    let map = DynSom::new(Grid::chain(3), 2, far.to_vec()).unwrap();
    let rows: Vec<_> = map
        .code_vectors()
        .map(|row| [row[0], row[1]].map(to_weight16))
        .collect();
    assert_eq!(
        rows,
        [
            [Weight::ONE, -Weight::ONE],
            [Weight::ZERO; 2],
            [Weight::ZERO; 2]
        ]
    );
    assert_eq!((map.grid(), map.dims()), (Grid::chain(3), 2));
    assert_eq!(
        DynSom::new(Grid::chain(3), 0, Vec::new()).unwrap().dims(),
        1
    );
    let error = DynSom::new(Grid::chain(1), 4096, Vec::new()).unwrap_err();
    assert_eq!(
        std::format!("{error}"),
        "4096 components are more than 4095"
    );
}

#[cfg(feature = "serde")]
#[test]
fn som_and_dyn_som_have_the_same_format() {
    let code = weights([1, -2, 3, 8192, -8192, 6]);
    let map: Som<3, 2> = map_of(Grid::chain(3).with_edges(Edges::Wrapped), &code);
    let mut buffer = [0; 64];
    let bytes = postcard::to_slice(&map, &mut buffer).unwrap().to_vec();
    assert_eq!(postcard::from_bytes::<Som<3, 2>>(&bytes), Ok(map));
    let dynamic: DynSom = postcard::from_bytes(&bytes).unwrap();
    assert_eq!(dynamic.code_vectors().flatten().count(), 6);
    assert_eq!(postcard::to_slice(&dynamic, &mut buffer).unwrap(), bytes);
    // Sizes that do not match.
    assert!(postcard::from_bytes::<Som<2, 3>>(&bytes).is_err());
    assert!(postcard::from_bytes::<Som<2, 2>>(&bytes).is_err());
    assert!(postcard::from_bytes::<Som<4, 2>>(&bytes).is_err());
    let mut short = bytes.clone();
    short[3] = 1;
    assert!(postcard::from_bytes::<DynSom>(&short).is_err());
}
