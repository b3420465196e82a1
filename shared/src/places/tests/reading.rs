//! What can be read of places: links, frontiers, the plan.

use super::*;

#[test]
fn links_tell_between_which_places_it_went() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    assert_eq!(walker.places.links().count(), 0);
    walker.go_to(to(0, 1_500));
    let count = walker.places.positions().len() as u16;
    // It went from each place to the next one, and never back.
    let links = std::vec::Vec::from_iter(walker.places.links());
    let in_a_row = std::vec::Vec::from_iter((1..count).map(|place| (place - 1, place)));
    assert_eq!(links, in_a_row);
}

/// From the middle place it went to more others than it remembers links.
#[test]
fn a_link_that_one_end_forgot_is_told_by_the_other() {
    let mut graph = Graph::<16, 16>::NEW;
    for x in 0..10 {
        graph.place_at(&LIMITS, to(1_000 * x, 0), &[255; 16]);
    }
    for other in 1..10 {
        graph.went(0, other);
    }
    let places = Places::<16, 16> {
        graph,
        ..Places::new()
    };
    let mut links = std::vec::Vec::from_iter(places.links());
    links.iter_mut().for_each(|(one, other)| {
        (*one, *other) = ((*one).min(*other), (*one).max(*other));
    });
    links.sort_unstable();
    let all = std::vec::Vec::from_iter((1..10).map(|other| (0, other)));
    assert_eq!(links, all);
}

#[test]
fn a_way_that_does_not_go_is_blocked_once() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(2_000, 0));
    let count = walker.places.links().count();
    walker.places.graph.block(3, 2, 9);
    assert!(walker.places.blocked().eq([(2, 3)]));
    assert_eq!(walker.places.links().count(), count - 1);
}

#[test]
fn frontiers_lead_to_where_it_has_not_been() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.look();
    let frontiers = std::vec::Vec::from_iter(walker.places.frontiers());
    assert!(!frontiers.is_empty());
    for (from, end) in frontiers {
        assert_eq!(from, 0);
        assert!((350..=600).contains(&end.length_mm()), "{end:?}");
    }
    while walker.step(Aim::Frontier).is_some() {}
    assert_eq!(walker.places.frontiers().count(), 0);
}

#[test]
fn the_plan_goes_from_the_next_sub_goal_to_the_end() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    let plan = |walker: &Walker<'_>, aim: Aim| std::vec::Vec::from_iter(walker.places.plan(aim));
    assert_eq!(plan(&walker, Aim::Frontier), []);
    // To where it has not been: the end of an open way.
    let leg = walker.step(Aim::Frontier).expect("a way");
    assert_eq!(plan(&walker, Aim::Frontier), [leg.way]);
    walker.go_to(to(2_000, 0));
    // A goal in sight is all of the way.
    let near = Aim::Position(to(2_000, 300));
    walker.step(near);
    assert_eq!(plan(&walker, near), [to(2_000, 300)]);
    // Back around the end of the wall.
    let home = Aim::Position(Displacement::ZERO);
    let before = walker.places.here();
    let leg = walker.step(home).expect("a way");
    let way = plan(&walker, home);
    assert_eq!(way.first(), Some(&before.plus(leg.way)));
    assert_eq!(way.last(), Some(&Displacement::ZERO));
    assert!(way.len() > 3, "{way:?}");
    for pair in way.windows(2) {
        assert!(pair[1].minus(pair[0]).length_mm() <= 1_500, "{way:?}");
    }
}

#[test]
fn a_plan_that_ends_with_an_open_way_goes_to_its_end() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    let (mut plans, mut open) = (0, 0);
    while walker.step(Aim::Frontier).is_some() {
        let plan = std::vec::Vec::from_iter(walker.places.plan(Aim::Frontier));
        let mut ends = walker.places.frontiers().map(|(_, end)| end);
        // Over a place at least.
        if plan.len() > 1 {
            plans += 1;
            open += usize::from(ends.any(|end| plan.last() == Some(&end)));
        }
    }
    // A new place may close an open way that the robot still goes along.
    assert!(plans > 5 && 10 * open > 8 * plans, "{open} of {plans}");
}
