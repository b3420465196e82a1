//! What is kept of echoes, and what frees it.

use super::*;

/// Hears an echo of one transducer; `None` = nothing answers.
fn hear(shield: &mut Shield<16>, sensor: usize, range_mm: Option<u16>, time: u32) {
    let config = Config::recommended();
    shield.hear(&config, sensor, echo(range_mm.map(Range::from_mm), time));
}

/// How far the robot may go ahead, of 400 mm.
fn ahead(shield: &Shield<16>, time: u32) -> u16 {
    way(shield, &Config::recommended(), mm(400, 0), time).0
}

#[test]
fn two_echoes_from_beyond_free_a_place_and_one_does_not() {
    let mut shield = heard(&Config::recommended(), &[(0, 400)]);
    assert_eq!(ahead(&shield, 6), 258);
    // Neither silence nor an echo of nearly the same range.
    for _ in 0..5 {
        hear(&mut shield, 0, None, 6);
    }
    assert_eq!(ahead(&shield, 6), 258);
    // The lobe is wider than what an echo frees: its edges are freed from beside it.
    let mut beside = shield.clone();
    hear(&mut shield, 0, Some(2_000), 7);
    assert_eq!(ahead(&shield, 7), 258);
    hear(&mut shield, 0, Some(2_000), 8);
    assert!(
        (259..400).contains(&ahead(&shield, 8)),
        "{}",
        ahead(&shield, 8)
    );
    for (aside, time) in [(100, 7), (-200, 8)] {
        beside.moved(mm(0, aside), Bearing::ZERO);
        hear(&mut beside, 0, Some(2_000), time);
        hear(&mut beside, 0, Some(2_000), time);
    }
    beside.moved(mm(0, 100), Bearing::ZERO);
    hear(&mut beside, 0, Some(2_000), 9);
    assert_eq!(ahead(&beside, 9), 400);
}

/// The ring has turned by 6.5°: what lies on one side of the first echo's axis is outside the cone.
#[test]
fn a_place_is_free_if_half_the_way_to_its_neighbors_is() {
    let mut shield = heard(&Config::recommended(), &[(0, 400)]);
    let turn = Bearing::from_turns(1_183);
    shield.moved(Displacement::ZERO, turn);
    for time in 6..20 {
        hear(&mut shield, 0, Some(2_000), time);
    }
    shield.moved(Displacement::ZERO, Bearing::ZERO.minus(turn));
    assert_eq!(ahead(&shield, 20), 258);
}

#[test]
fn time_alone_frees_nothing() {
    let mut shield = heard(&Config::recommended(), &[(0, 400)]);
    for time in (0..500_000).step_by(1_000) {
        for sensor in 0..16 {
            hear(&mut shield, sensor, None, time + 6);
        }
    }
    assert_eq!(ahead(&shield, 499_500), 258);
}

/// All were silent for eleven minutes. What the first one then hears is known to the end.
#[test]
fn a_ring_that_was_silent_for_long_begins_anew_once() {
    let mut shield = heard(&Config::recommended(), &[(0, 300), (8, 300)]);
    let later = 5 + 660_000;
    hear(&mut shield, 0, Some(500), later);
    for sensor in 1..16 {
        hear(&mut shield, sensor, None, later + 1);
    }
    assert_eq!(ahead(&shield, later + 2), 355);
    let config = Config::recommended();
    assert_eq!(way(&shield, &config, mm(-400, 0), later + 2).0, 400);
    // Ten minutes are not long enough.
    hear(&mut shield, 0, None, later + 600_000);
    hear(&mut shield, 1, None, later + 600_000);
    assert_eq!(shield.points.len(), 1);
}

/// Echoes of one frame may come out of order.
#[test]
fn a_time_that_goes_back_is_no_silence() {
    let mut shield = heard(&Config::recommended(), &[(0, 400)]);
    hear(&mut shield, 1, None, 4);
    assert_eq!(ahead(&shield, 6), 258);
}

/// A post stands at 30° to the left, 0.45 m from the middle, in the lobe of transducer 1. Then the
/// robot goes so that it comes to stand between the lobes of two transducers, and both hear the wall
/// behind it.
#[test]
fn what_has_come_to_stand_between_two_lobes_is_still_known() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(1, 230)]);
    let towards = Displacement::along(Bearing::of_place(1, 16), 400);
    let before = way(&shield, &config, towards, 6).0;
    for time in 7..40 {
        shield.moved(mm(0, 2), Bearing::ZERO);
        for sensor in [0, 1, 2] {
            let sees = sensor == 1 && time < 12;
            hear(
                &mut shield,
                sensor,
                Some(if sees { 230 } else { 2_000 }),
                time,
            );
        }
    }
    assert!(before < 120, "{before}");
    assert!(way(&shield, &config, towards, 41).0 < 400);
}

#[test]
fn what_is_far_is_not_kept_and_the_farthest_makes_room() {
    let mut shield = heard(&Config::recommended(), &[]);
    hear(&mut shield, 0, Some(1_400), 6);
    assert_eq!(shield.points.len(), 0);
    // A corner on the left; then 200 different echoes from the right.
    hear(&mut shield, 4, Some(300), 6);
    for step in 0..200 {
        shield.moved(mm(if step % 2 == 0 { 30 } else { -30 }, 0), Bearing::ZERO);
        let range_mm = 350 + 7 * (step * 37 % 100);
        hear(&mut shield, 9 + step % 7, Some(range_mm as u16), 7);
    }
    assert_eq!(shield.points.len(), 64);
    // What is farther than all of these is not kept, what is nearer is.
    let before = shield.points.clone();
    hear(&mut shield, 6, Some(820), 8);
    assert_eq!(shield.points, before);
    hear(&mut shield, 8, Some(250), 8);
    assert_eq!(shield.points.len(), 64);
    let config = Config::recommended();
    assert_eq!(way(&shield, &config, mm(0, 400), 8).0, 162);
    assert_eq!(way(&shield, &config, mm(-400, 0), 8).0, 114);
}

/// A wall ahead, and what the ring hears of it while it turns: the first echo's place stays.
#[test]
fn an_echo_like_a_kept_one_confirms_it_where_it_is() {
    let mut shield = heard(&Config::recommended(), &[(0, 400)]);
    let whole = shield.clone();
    // One beam from beyond, and once more the wall, a little farther away and 3° aside.
    hear(&mut shield, 0, Some(2_000), 6);
    assert_ne!(shield.points, whole.points);
    shield.moved(Displacement::ZERO, Bearing::from_turns(546));
    hear(&mut shield, 0, Some(430), 7);
    shield.moved(
        Displacement::ZERO,
        Bearing::ZERO.minus(Bearing::from_turns(546)),
    );
    assert_eq!(shield.points, whole.points);
    // One that is nearer, or turned by more, is another.
    hear(&mut shield, 0, Some(380), 8);
    assert_eq!((ahead(&shield, 9), shield.points.len()), (239, 2));
    shield.moved(Displacement::ZERO, Bearing::of_place(1, 16));
    hear(&mut shield, 15, Some(400), 10);
    assert_eq!(shield.points.len(), 2);
    hear(&mut shield, 0, Some(400), 10);
    assert_eq!(shield.points.len(), 3);
}

#[test]
fn a_robot_that_stands_keeps_each_echo_once() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 500), (4, 400), (9, 700)]);
    for time in 6..100 {
        for (sensor, range_mm) in [(0, 500), (4, 400), (9, 700)] {
            hear(&mut shield, sensor, Some(range_mm), time);
        }
    }
    assert_eq!(shield.points.len(), 3);
}
