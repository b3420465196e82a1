//! Places that were saved, and read by another robot that stands anywhere.

use super::lost::{CLOSET, HOME, goes_home};
use super::*;
use crate::controller::TransferError;
use crate::places::record::Record;
use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::Xoshiro128PlusPlus;
use std::vec::Vec;

/// Bytes of the head and of a place.
const ITEM: usize = 56;

fn saved<const RECORDS: usize>(places: &Places<16, RECORDS>) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut buffer = [0; 160];
    loop {
        match places.read_saved(bytes.len(), &mut buffer) {
            0 => return bytes,
            count => bytes.extend_from_slice(&buffer[..count]),
        }
    }
}

fn restored<const RECORDS: usize>(bytes: &[u8]) -> Places<16, RECORDS> {
    let mut places = Places::new();
    for (index, piece) in bytes.chunks(2 * ITEM).enumerate() {
        assert_eq!(places.write_saved(index * 2 * ITEM, piece), Ok(()));
    }
    places
}

#[test]
fn what_is_read_is_what_was_saved_but_for_where_the_robot_is() {
    let walker = lost::who_knows(&CLOSET);
    let bytes = saved(&walker.places);
    assert_eq!(bytes.len(), ITEM * (walker.places.positions().len() + 1));
    let mut places: Places<16, 256> = restored(&bytes);
    assert!(places.positions().eq(walker.places.positions()));
    assert!(places.links().eq(walker.places.links()));
    assert!(places.frontiers().eq(walker.places.frontiers()));
    assert_eq!(places.here(), Displacement::ZERO);
    places.here = walker.places.here();
    assert_eq!(saved(&places), bytes);
    // From any byte on.
    for (from, count) in [(0, 1), (33, 20), (55, 2), (57, 160), (bytes.len() - 3, 160)] {
        let mut some = [0; 160];
        let count = places.read_saved(from, &mut some[..count]);
        assert_eq!(some[..count], bytes[from..from + count], "{from}");
        assert!(count > 0 && from + count <= bytes.len(), "{from}");
    }
    assert_eq!(places.read_saved(bytes.len(), &mut [0; 160]), 0);
    assert_eq!(places.read_saved(usize::MAX, &mut [0; 160]), 0);
}

#[test]
fn a_robot_that_was_off_finds_out_where_it_is_and_goes_home() {
    for (x, y) in [(1_500.0, 1_500.0), (800.0, -1_000.0), (-1_400.0, 900.0)] {
        let mut walker = lost::who_knows(&CLOSET);
        walker.places = restored(&saved(&walker.places));
        walker.places.trust_heading(true);
        walker.set_down(x, y);
        goes_home(&mut walker);
    }
}

/// Without a compass it needs the directions of the walls.
#[test]
fn a_robot_that_was_off_finds_out_which_way_it_faces() {
    for (x, y, degrees) in [(1_500.0, 1_500.0, 90.0), (1_500.0, 0.0, 30.0)] {
        let mut walker = turned::who_knows();
        walker.places = restored(&saved(&walker.places));
        walker.set_down(x, y);
        walker.turn_by(degrees);
        turned::finds_itself(&mut walker, degrees);
    }
}

/// A robot that does not know where it is saves what it knew before.
#[test]
fn places_of_which_it_does_not_know_where_they_are_are_not_saved() {
    let mut walker = lost::who_knows(&CLOSET);
    let before = saved(&walker.places);
    walker.set_down(800.0, -1_000.0);
    for _ in 0..4 {
        walker.step_lost(HOME);
    }
    assert!(ITEM * (walker.places.positions().len() + 1) > before.len());
    let bytes = saved(&walker.places);
    assert_eq!(bytes.len(), before.len());
    assert_eq!((before[39], bytes[39]), (0, 1), "whether it is lost");
    let places: Places<16, 256> = restored(&bytes);
    assert!(places.links().eq(restored::<256>(&before).links()));
}

#[test]
fn pieces_out_of_order_or_without_room_change_nothing() {
    let walker = lost::who_knows(&CLOSET);
    let bytes = saved(&walker.places);
    let mut places: Places<16, 8> = restored(&bytes[..4 * ITEM]);
    let before = places.clone();
    for (offset, piece) in [
        (2 * ITEM, &bytes[2 * ITEM..4 * ITEM]),
        (6 * ITEM, &bytes[6 * ITEM..8 * ITEM]),
        (4 * ITEM, &bytes[4 * ITEM..4 * ITEM + 1]),
        (4 * ITEM, &bytes[4 * ITEM..10 * ITEM]),
        (0, &bytes[..10 * ITEM]),
        // The head alone.
        (0, &bytes[..ITEM]),
        (1, &bytes[..ITEM]),
        (usize::MAX, &bytes[..ITEM]),
    ] {
        let refused = Err(TransferError::OutOfBounds);
        assert_eq!(places.write_saved(offset, piece), refused, "{offset}");
        assert!(places == before, "{offset}");
    }
    // Nothing follows once it is lost among them.
    let mut lost: Places<16, 256> = restored(&bytes);
    lost.set_down();
    let known = lost.saved_len();
    let refused = lost.write_saved(known, &bytes[ITEM..2 * ITEM]);
    assert_eq!(refused, Err(TransferError::OutOfBounds));
    assert_eq!(places.write_saved(0, &[]), Ok(()));
    assert_eq!((places.positions().len(), saved(&places).len()), (0, 0));
    let mut none = Places::<16, 0>::new();
    let refused = none.write_saved(0, &bytes[..ITEM]);
    assert_eq!(refused, Err(TransferError::OutOfBounds));
    assert_eq!(none.read_saved(0, &mut [0; 160]), 0);
}

/// Places that had to stand farther apart than ever would all become one.
#[test]
fn places_never_have_to_stand_far_apart() {
    let mut bytes = saved(&lost::who_knows(&CLOSET).places);
    bytes[33..35].fill(0xff);
    let places: Places<16, 256> = restored(&bytes);
    assert_eq!(places.graph.least_mm(), 550);
}

#[test]
fn a_robot_that_reads_anything_goes_on() {
    for seed in 0..if cfg!(miri) { 1 } else { 40 } {
        let mut bytes = [0; ITEM * 100];
        Xoshiro128PlusPlus::seed_from_u64(seed).fill_bytes(&mut bytes);
        let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
        walker.stops = true;
        walker.places = restored(&bytes);
        let (links, frontiers) = (walker.places.links(), walker.places.frontiers());
        assert!(links.count() + frontiers.count() > 0);
        walker.places.trust_heading(seed % 2 == 0);
        walker.places.set_down();
        // A place that is found later has none of the links to places that there were not.
        let mut links = walker.places.graph.records().iter().flat_map(Record::links);
        assert!(links.all(|link| link < 99));
        for _ in 0..6 {
            walker.step(Aim::Frontier);
            walker.step(HOME);
        }
    }
}
