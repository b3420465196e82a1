//! What is sought may be anywhere: a robot for which nothing is left looks more closely.

use super::*;
use crate::modality::{Modality, Search, Sought};
use crate::units::Millis;
use std::vec::Vec;

/// Steps that it is led until nothing is left, and for 60 decisions after that.
fn led<const RECORDS: usize>(walker: &mut Walker<'_, RECORDS>, aim: Aim) -> usize {
    let mut idle = 0;
    let mut steps = 0;
    while idle < 60 && steps < 400 {
        match walker.step(aim) {
            Some(_) => (steps, idle) = (steps + 1, 0),
            None => idle += 1,
        }
    }
    steps
}

#[test]
fn where_nothing_is_left_it_goes_on_only_if_something_is_sought() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    assert!(led(&mut walker, Aim::Frontier) > 20);
    assert_eq!(led(&mut walker, Aim::Frontier), 0);
    let known = walker.places.positions().len();
    assert!(led(&mut walker, Aim::Everywhere) > 3);
    // 49 and 107; 76 where it only looks closely around itself.
    let more = walker.places.positions().len();
    assert!(known < 55 && more > 95, "{known} {more}");
    // That ends as well.
    assert_eq!(led(&mut walker, Aim::Everywhere), 0);
    walker.places.forget();
    assert!(!walker.places.looks_closely && walker.places.reopened == 0);
}

/// A robot that smells this, from its start, drives until it is where it thinks that it is
/// strongest; returns how many decisions that took.
fn seek(walker: &mut Walker<'_>, strength: impl Fn(Displacement) -> f64) -> u32 {
    let mut scent = Modality::<1, 256>::new();
    let mut search = Search::default();
    for decision in 0..400 {
        let here = walker.places.here();
        let now = Millis::from_ms(1_000 * decision);
        scent.perceive(&[(254.0 * strength(here)) as u8], here, now);
        let aim = search.aim(&scent, &Sought::Most(0), &walker.places, now);
        match walker.step(aim) {
            Some(leg) if leg.is_last && leg.way.is_shorter_than(100) => return decision,
            _ => {}
        }
    }
    panic!("it found nothing");
}

#[test]
fn a_scent_is_followed_to_its_source_around_a_wall() {
    let source = to(2_200, 800);
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    let door = to(1_000, 2_700);
    // The way of the scent goes by the door.
    let strength = |here: Displacement| {
        let straight = f64::from(here.minus(source).length_mm());
        let around = f64::from(here.minus(door).length_mm() + source.minus(door).length_mm());
        let way_mm = if here.dx_mm > 1_000 { straight } else { around };
        libm::exp(-way_mm / 2_000.0)
    };
    let decisions = seek(&mut walker, strength);
    let off_mm = walker.places.here().minus(source).length_mm();
    assert!(off_mm < 400, "{off_mm}");
    assert!(decisions < 200, "{decisions}");
}

/// Every position where it smells stronger lies behind a wall.
#[test]
fn what_cannot_be_reached_is_given_up() {
    let source = to(2_200, 800);
    let closed: Vec<_> = TWO_ROOMS
        .into_iter()
        .chain([[0.0, 800.0, 0.0, 2_000.0]])
        .collect();
    let mut walker = Walker::<256>::new(&closed, (-1_000.0, -1_400.0));
    let strength = |here: Displacement| libm::exp(-f64::from(here.minus(source).length_mm()) / 2e3);
    seek(&mut walker, strength);
    let here = walker.places.here();
    assert!(here.minus(to(700, 800)).length_mm() < 450, "{here:?}");
}
