//! What is recorded, recalled and forgotten.

use super::*;
use crate::places::{Aim, Places};

type Scent = Modality<1, 8>;
type Floor = Modality<3, 16>;

const RED: [u8; 3] = [230, 25, 25];
const GRAY: [u8; 3] = [127; 3];

fn at(x_mm: i16, y_mm: i16) -> Displacement {
    Displacement {
        dx_mm: x_mm,
        dy_mm: y_mm,
    }
}

fn s(seconds: u32) -> Millis {
    Millis::from_ms(1_000 * seconds)
}

#[test]
fn one_record_stands_for_positions_that_show_about_the_same() {
    let mut scent = Scent::new();
    scent.perceive(&[100], at(0, 0), s(1));
    scent.perceive(&[131], at(240, 0), s(2));
    assert_eq!(scent.records().len(), 1);
    let [record] = scent.records() else { panic!() };
    assert_eq!((record.values, record.at), ([100], at(0, 0)));
    assert_eq!((record.first, record.last), (s(1), s(2)));
    // Where it was recorded its value follows.
    scent.perceive(&[120], at(90, 0), s(3));
    assert_eq!(scent.records()[0].values, [110]);
    // Farther away it is another one, and what is not the same.
    scent.perceive(&[110], at(260, 0), s(4));
    assert_eq!(scent.records().len(), 2);
    scent.perceive(&[142], at(200, 0), s(5));
    assert_eq!(scent.records().len(), 3);
    assert!(scent.records().iter().all(|record| !record.is_past));
    scent.forget();
    assert!(scent.records().is_empty());
}

#[test]
fn what_is_no_longer_so_is_past_and_what_returns_is_not() {
    let mut scent = Scent::new();
    let light = Sought::Most(0);
    scent.perceive(&[200], at(0, 0), s(1));
    // Beside it something else is perceived: both may be so.
    scent.perceive(&[20], at(120, 0), s(2));
    assert_eq!(scent.recall(&light, at(0, 0)).unwrap().values, [200]);
    // Right there as well.
    scent.perceive(&[20], at(50, 0), s(3));
    assert_eq!(scent.recall(&light, at(0, 0)).unwrap().values, [20]);
    assert_eq!(scent.recall_before(&[20], s(4)).unwrap().last, s(1));
    scent.perceive(&[200], at(0, 0), s(5));
    assert_eq!(scent.recall(&light, at(0, 0)).unwrap().values, [200]);
    assert_eq!(scent.records().len(), 2);
}

#[test]
fn a_goal_recalls_the_strongest_or_the_nearest_that_is_alike() {
    let mut floor = Floor::new();
    floor.perceive(&GRAY, at(0, 0), s(1));
    floor.perceive(&RED, at(3_000, 0), s(2));
    floor.perceive(&[215, 40, 10], at(1_000, 0), s(3));
    let red = Sought::Alike(RED);
    let recalled = |here| floor.recall(&red, here).unwrap().at;
    assert_eq!(recalled(at(0, 0)), at(1_000, 0), "alike enough, and nearer");
    assert_eq!(recalled(at(2_500, 0)), at(3_000, 0));
    let green = floor.recall(&Sought::Most(1), at(0, 0)).unwrap();
    assert_eq!(green.at, at(0, 0));
    assert!(red.is_found_in(&RED) && !red.is_found_in(&GRAY));
    assert!(!Sought::<1>::Most(0).is_found_in(&[15]) && Sought::<1>::Most(0).is_found_in(&[16]));
}

#[test]
fn what_was_before_is_what_differs_and_was_perceived_last() {
    let mut light = Scent::new();
    for (value, x_mm, when) in [(200, 0, 1), (180, 1_000, 2), (10, 2_000, 3), (20, 3_000, 4)] {
        light.perceive(&[value], at(x_mm, 0), s(when));
    }
    assert_eq!(light.recall_before(&[20], s(5)).unwrap().at, at(1_000, 0));
    assert_eq!(light.recall_before(&[190], s(5)).unwrap().at, at(3_000, 0));
    assert_eq!(Scent::new().recall_before(&[190], s(5)), None);
}

#[test]
fn a_full_memory_keeps_what_is_rare() {
    let mut scent = Modality::<1, 32>::new();
    scent.perceive(&[250], at(-5_000, 0), s(0));
    for step in 0..200 {
        let values = [10 + step as u8 % 5];
        scent.perceive(&values, at(300 * (step % 100), step), s(1 + step as u32));
    }
    assert_eq!(scent.records().len(), 32);
    let strongest = scent.recall(&Sought::Most(0), at(0, 0)).unwrap();
    assert_eq!(strongest.at, at(-5_000, 0), "the oldest of all");
    // The latest is there as well.
    assert!(scent.records().iter().any(|record| record.last == s(200)));
    // What is past as well: time may ask for it.
    scent.perceive(&[10], at(-5_000, 0), s(201));
    for step in 0..100 {
        scent.perceive(&[10], at(300 * step, 9_000), s(202 + step as u32));
    }
    let before = scent.recall_before(&[10], s(400)).unwrap();
    assert_eq!((before.values, before.is_past), ([250], true));
}

#[test]
fn the_map_orders_what_was_perceived() {
    let mut scent = Modality::<1, 64>::new();
    for step in 0..64_u8 {
        let value = step.wrapping_mul(37) % 64 * 4;
        scent.perceive(&[value], at(400 * i16::from(step), 0), s(step.into()));
    }
    let neuron = |value: u8| scent.map.bmu(&memory::from_bytes(&[value]).0, Mask::ALL);
    // Each end has a neuron of its own.
    assert_ne!(neuron(0), neuron(252));
    let worst = (0..=252).map(|value: u8| {
        let code = scent.map.code_vector(neuron(value))[0].to_num::<f64>();
        (code - f64::from(value) / 254.0).abs()
    });
    let worst = worst.fold(0.0, f64::max);
    assert!(worst < 0.12, "{worst}");
}

#[test]
fn restored_records_are_recalled_and_learned_of_as_new_ones() {
    let mut scent = Scent::new();
    for (value, x_mm, when) in [(200, 0, 1), (20, 1_000, 2), (20, 20, 3), (60, 2_000, 4)] {
        scent.perceive(&[value], at(x_mm, 0), s(when));
    }
    let mut restored = Scent::new();
    for record in scent.records() {
        restored.restore(Record {
            neuron: 99,
            ..*record
        });
    }
    assert_eq!(restored, scent);
    // No value is greater than the greatest, and none comes where there is no room.
    let loud = Record {
        values: [255],
        ..scent.records()[0]
    };
    for _ in 0..9 {
        restored.restore(loud);
    }
    assert_eq!(restored.records().len(), 8);
    assert_eq!(restored.records()[4].values, [254]);
}

/// A memory that is stronger the farther to the right, and places without open ways.
fn slope() -> (Scent, Places<16, 8>) {
    let mut scent = Scent::new();
    for step in 0..4 {
        scent.perceive(&[40 * (step as u8 + 1)], at(300 * step, 0), s(step as u32));
    }
    (scent, Places::new())
}

#[test]
fn a_robot_that_knows_nothing_of_it_goes_everywhere() {
    let (scent, places) = slope();
    let mut search = Search::default();
    let nothing = Scent::new();
    let most = Sought::Most(0);
    assert_eq!(search.aim(&nothing, &most, &places, s(9)), Aim::Everywhere);
    let found = search.aim(&scent, &most, &places, s(9));
    assert_eq!(found, Aim::Position(at(900, 0)));
    // Around a position that it has just come to it may be stronger.
    assert_eq!(search.aim(&scent, &most, &places, s(5)), Aim::Everywhere);
    let alike = Sought::Alike([200]);
    assert_eq!(
        search.aim(&scent, &alike, &places, s(5)),
        Aim::Position(at(900, 0))
    );
    assert_eq!(
        search.aim(&scent, &Sought::Alike([254]), &places, s(5)),
        Aim::Everywhere
    );
}
