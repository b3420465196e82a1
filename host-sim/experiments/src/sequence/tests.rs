use super::method::{Flips, Learned, flip};
use super::*;

const TRIAL: SequenceTrial = SequenceTrial {
    seed: 1,
    seeds: 2,
    cues: 3,
    corrected_bits: 0,
};

#[test]
fn the_figures_are_the_same_on_any_number_of_threads() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads");
        pool.install(|| measure(&TRIAL, &|| {})).expect("drives")
    };
    let rows = with(1);
    assert_eq!(rows, with(2));
    // Three methods in four sizes, and the table is right without noise.
    let count = |measure: Measure| rows.iter().filter(|row| row.measure == measure).count();
    assert_eq!(count(Measure::Longest), 2 * 3 * 4);
    assert_eq!(count(Measure::Cue), 2 * 7 * 9);
    let exact = rows
        .iter()
        .filter(|row| (row.measure, row.method, row.at) == (Measure::Cue, Method::Table, 0));
    assert!(exact.clone().count() == 2 && exact.clone().all(|row| row.mean == 1.0));
}

#[test]
fn so_many_bits_are_turned_around_each_once() {
    let mut noise = Noise::new(1);
    let pattern = random::<128>(&mut noise);
    for (percent, bits) in [(0, 0), (5, 6), (40, 51), (100, 128)] {
        let mut damaged = pattern;
        flip(&mut damaged, percent, &mut noise);
        assert_eq!(damaged.distance(&pattern), bits);
    }
}

/// With an element of two sequences the table recalls the first; the network alone cannot recall
/// both.
#[test]
fn a_table_takes_the_first_of_two_successors() {
    let mut noise = Noise::new(2);
    let all: Vec<_> = (0..5).map(|_| random::<128>(&mut noise)).collect();
    let [first, second] = [[all[0], all[1], all[2]], [all[3], all[1], all[4]]];
    let learned = Learned::of(&[&first, &second], false);
    let recalls = |method, sequence: &[_]| {
        learned.recalls(method, sequence, Flips::default(), &mut Noise::new(3))
    };
    assert!(recalls(Method::Table, &first) && !recalls(Method::Table, &second));
    assert!(!(recalls(Method::Hetero, &first) && recalls(Method::Hetero, &second)));
    assert!(recalls(Method::Pair, &first[..2]) && recalls(Method::Hetero, &second[..2]));
}
