//! How far places stand apart when there is no room for more.

use super::*;

/// Places that were close for a goal are not thinned out more than there is need to.
#[test]
fn close_places_are_thinned_out_step_by_step() {
    let close = PlaceLimits {
        spacing_mm: 250,
        ..LIMITS
    };
    let mut graph = Graph::<16, 40>::NEW;
    for index in 0..41 {
        while graph.thin_out().is_some() {}
        graph.place_at(&close, to(260 * index, 0), &[255; 16]);
    }
    while graph.thin_out().is_some() {}
    // Every other one of them: 520 mm apart.
    assert_eq!(graph.spacing_mm(&close), 312);
    assert_eq!(graph.records().len(), 20);
    assert_eq!(graph.spacing_mm(&LIMITS), 350);
    // Nor by another purpose: 320 mm apart.
    for index in 0..20 {
        graph.place_at(&close, to(320 * index, 9_000), &[255; 16]);
    }
    graph.place_at(&LIMITS, to(0, 20_000), &[255; 16]);
    assert_eq!(graph.records().len(), 40);
    assert_eq!(graph.thin_out(), None);
}

/// A guard of a large margin, and room for few places: it goes on to look for ways.
#[test]
fn a_wide_spacing_leaves_open_ways() {
    let limits = PlaceLimits {
        radius_mm: u16::MAX,
        ..LIMITS
    };
    let mut graph = Graph::<16, 2>::NEW;
    for x_mm in [0, 600, 1_200, 1_800, 2_400, 3_000] {
        graph.place_at(&limits, to(x_mm, 0), &[255; 16]);
        while graph.thin_out().is_some() {}
    }
    assert_eq!(graph.spacing_mm(&limits), 550);
}

/// Where something was sought in vain it was, whatever number the place has.
#[test]
fn a_place_that_takes_another_number_was_sought_as_before() {
    let mut graph = Graph::<16, 8>::NEW;
    for x_mm in [0, 500, 2_000] {
        let _ = graph.place_at(&LIMITS, to(x_mm, 0), &[0; 16]);
    }
    graph.searched(2, false);
    graph.keep_apart(800);
    assert!(graph.thin_out().is_some(), "the second one is too near");
    let of = |graph: &Graph<16, 8>| [0, 1, 2].map(|index| graph.is_searched(index));
    assert_eq!(of(&graph), [false, true, true]);
    let _ = graph.place_at(&LIMITS, to(4_000, 0), &[0; 16]);
    assert_eq!(of(&graph), [false, true, false], "a new one was not");
    graph.search_anew();
    assert_eq!(of(&graph), [false; 3]);
}
