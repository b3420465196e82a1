use super::*;
use amp::units::Displacement;

/// Codes that are told apart by eight values that are near.
fn stations() -> Stations {
    let record = |number: usize| {
        let near = |sensor: usize| sensor / 2 % 4 == number || sensor == number;
        let value = |sensor| Weight::from_num(if near(sensor) { 0.8 } else { 0.1 });
        let situation: Situation<16> = std::array::from_fn(value);
        Record {
            code: Pattern::of_situation(&situation),
            position: Displacement::saturating(1_000 * number as i32, 0),
        }
    };
    Stations::of((0..4).map(record).collect())
}

#[test]
fn all_name_the_next_station_and_after_the_last_the_first() {
    let stations = stations();
    for station in 0..4 {
        let Record { code, position } = stations.records[station];
        let next = (station + 1) % 4;
        for namer in [Namer::Pair, Namer::Table, Namer::Position, Namer::List] {
            let named = stations.name(namer, &code, position, next);
            assert_eq!(named, next, "{namer:?}");
        }
    }
}

#[test]
fn the_pointer_alone_leads_a_list() {
    let stations = stations();
    let Record { code, position } = stations.records[2];
    assert_eq!(stations.name(Namer::List, &code, position, 1), 1);
    assert_eq!(
        stations.name(Namer::Position, &code, Displacement::default(), 1),
        1
    );
}

#[test]
fn so_many_values_are_missing() {
    let situation = [Weight::ONE; 16];
    for missing in MISSING {
        let rest = without(&situation, missing, &mut Noise::new(3));
        assert_eq!(
            rest.iter().filter(|value| **value == Weight::ZERO).count(),
            missing
        );
    }
}

fn round(namer: Namer, reached: usize) -> Round {
    Round {
        world: "a".to_owned(),
        seed: 1,
        namer,
        from: 0,
        reached,
        stations: 4,
        error_m: if reached > 0 { 0.1 } else { 0.0 },
        contacts: 1,
    }
}

#[test]
fn a_summary_counts_whole_rounds_and_stations() {
    let patrols = |reached: usize, is_right: bool| Patrols {
        rounds: vec![round(Namer::Pair, reached), round(Namer::List, 4)],
        namings: vec![Naming {
            world: "a".to_owned(),
            seed: 1,
            namer: Namer::Pair,
            missing: 4,
            is_right,
        }],
        stopped: None,
    };
    let all = summarize(&[patrols(4, true), patrols(0, false)], 1);
    let of = |namer| {
        all.iter()
            .find(|one| one.namer == namer)
            .expect("a summary")
    };
    let pair = of(Namer::Pair);
    assert_eq!(
        (pair.rounds, pair.completed.mean, pair.reached.mean),
        (2, 0.5, 0.5)
    );
    assert!((pair.error_m - 0.1).abs() < 1e-12);
    assert_eq!(pair.right[1].map(|right| right.mean), Some(0.5));
    assert_eq!((pair.right[0], pair.contacts), (None, 2));
    assert_eq!(
        (of(Namer::List).completed.mean, of(Namer::Table).rounds),
        (1.0, 0)
    );
}
