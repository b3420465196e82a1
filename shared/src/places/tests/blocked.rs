//! Ways that do not go, for a while.

use super::*;

#[test]
fn a_way_that_was_blocked_goes_again_after_a_while() {
    let mut graph = Graph::<16, 4>::NEW;
    for x_mm in [0, 600, 1_200] {
        graph.place_at(&LIMITS, to(x_mm, 0), &[255; 16]);
    }
    graph.went(0, 1);
    graph.went(1, 2);
    graph.block(1, 0, 3);
    for _ in 0..3 {
        assert!(!graph.is_linked(&LIMITS, 0, 1) && !graph.is_linked(&LIMITS, 1, 0));
        assert!(graph.is_linked(&LIMITS, 1, 2));
        graph.pass_decision();
    }
    assert!(graph.is_linked(&LIMITS, 0, 1));
    assert_eq!(graph.blocked().count(), 0);
    // To go it is as good.
    graph.block(0, 1, 3);
    graph.went(1, 0);
    assert!(graph.is_linked(&LIMITS, 1, 0));
    // Blocked again it counts anew, and the last one to be blocked goes last.
    graph.block(0, 1, 3);
    graph.pass_decision();
    graph.block(1, 2, 2);
    graph.block(1, 0, 3);
    graph.pass_decision();
    graph.pass_decision();
    assert!(graph.blocked().eq([(0, 1)]));
}

#[test]
fn a_blocked_way_follows_its_places_when_they_are_merged() {
    let mut graph = Graph::<16, 4>::NEW;
    for x_mm in [0, 300, 600, 900] {
        let close = PlaceLimits {
            spacing_mm: 250,
            ..LIMITS
        };
        graph.place_at(&close, to(x_mm, 0), &[255; 16]);
    }
    graph.block(0, 3, 9);
    // There is no room for another: the second one is merged with the first, the last takes its
    // number.
    while graph.thin_out().is_some() {}
    graph.place_at(&LIMITS, to(0, 5_000), &[255; 16]);
    assert!(graph.thin_out().is_some());
    assert_eq!(graph.get(1).map(|record| record.at), Some(to(900, 0)));
    assert!(graph.blocked().eq([(0, 1)]));
}

/// A room with a wall in its middle, around which there are two ways.
const AROUND: [[f64; 4]; 5] = [
    [-2_500.0, -2_000.0, 2_500.0, -2_000.0],
    [2_500.0, -2_000.0, 2_500.0, 2_000.0],
    [2_500.0, 2_000.0, -2_500.0, 2_000.0],
    [-2_500.0, 2_000.0, -2_500.0, -2_000.0],
    [0.0, -700.0, 0.0, 800.0],
];

/// What closes the lower one, and what is nowhere.
const BAR: [f64; 4] = [0.0, -2_000.0, 0.0, -700.0];

#[test]
fn a_robot_goes_around_what_was_not_there_before_and_later_straight_again() {
    let mut closed = [[0.0; 4]; 6];
    closed[..5].copy_from_slice(&AROUND);
    closed[5] = BAR;
    let (there, back) = (to(3_000, 0), Displacement::ZERO);
    let mut walker = Walker::<256>::new(&AROUND, (-1_500.0, -1_000.0));
    let length_mm = |walker: &mut Walker<'_>, goal| {
        walker.way_mm = 0.0;
        walker.go_to(goal);
        walker.way_mm
    };
    while walker.step(Aim::Frontier).is_some() {}
    length_mm(&mut walker, back);
    // Below the wall.
    let short_mm = length_mm(&mut walker, there);
    assert!(short_mm < 3_700.0, "{short_mm}");
    length_mm(&mut walker, back);
    (walker.walls, walker.stops) = (&closed, true);
    let around_mm = length_mm(&mut walker, there);
    // It sees the bar; without that it stands before it 14 times.
    assert!(walker.stopped < 10, "{}", walker.stopped);
    assert!((4_500.0..12_000.0).contains(&around_mm), "{around_mm}");
    assert!(walker.places.blocked().count() > 0);
    // It knows better now.
    let again_mm = length_mm(&mut walker, back);
    assert!(again_mm < 6_500.0, "{again_mm}");
    walker.walls = &AROUND;
    for _ in 0..1_000 {
        walker.look();
    }
    assert_eq!(walker.places.blocked().count(), 0);
    let short_mm = length_mm(&mut walker, there);
    assert!(short_mm < 3_700.0, "{short_mm}");
}

/// Nothing that is wide open is left where it is.
#[test]
fn a_robot_that_is_cut_off_from_a_known_goal_tries_narrow_ways_as_well() {
    let mut closed = TWO_ROOMS;
    closed[4][3] = 2_000.0;
    let goal = Aim::Position(to(2_000, 0));
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(2_000, 0));
    walker.go_to(Displacement::ZERO);
    (walker.walls, walker.stops) = (&closed, true);
    let is_new = |leg: Option<Leg>| leg.is_some_and(|leg| leg.is_new);
    let new = (0..150).filter(|_| is_new(walker.step(goal))).count();
    assert!(walker.places.is_cut_off && new > 20, "{new}");
    walker.places.seek_anew();
    assert!(!walker.places.is_cut_off);
}

#[test]
fn where_moves_lead_nowhere_it_goes_straight_before_it_gives_the_way_up() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(2_000, 0));
    let home = Aim::Position(Displacement::ZERO);
    let stand = |walker: &mut Walker<'_>| {
        walker.hear();
        walker.think(Purpose::Lead(home))
    };
    // It is told to go and stands.
    let legs = std::vec::Vec::from_iter((0..20).map(|_| stand(&mut walker)));
    let straight = |leg: &Option<Leg>| leg.is_some_and(|leg| leg.is_straight);
    let first = legs.iter().position(straight).expect("it goes straight");
    assert!((5..10).contains(&first), "{first}");
    let (first_way, last_way) = (legs[0].map(|leg| leg.way), legs[19].map(|leg| leg.way));
    assert!(legs[first..first + 8].iter().all(straight));
    assert!(!straight(&legs[19]) && first_way != last_way);
    assert!(walker.places.blocked().count() > 0);
}

#[test]
fn to_where_it_has_not_been_it_does_not_go_straight() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    for _ in 0..30 {
        walker.hear();
        let leg = walker.think(Purpose::Lead(Aim::Frontier));
        assert!(leg.is_none_or(|leg| !leg.is_straight));
    }
}
