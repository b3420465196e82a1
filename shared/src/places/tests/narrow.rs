//! On the way to a position that it has not been to.

use super::*;

#[test]
fn on_a_new_way_with_room_the_robot_goes_two_and_a_half_steps_at_once() {
    let leg = Leg {
        way: to(900, 0),
        room_mm: 75,
        is_new: true,
        is_straight: false,
        is_last: false,
    };
    let chosen = to(230, 90);
    assert_eq!(leg.stride(chosen, 250), to(625, 0));
    assert_eq!(leg.stride(to(100, 98), 250), to(625, 0));
    let short = Leg {
        way: to(300, 0),
        ..leg
    };
    assert_eq!(short.stride(chosen, 250), to(300, 0));
    // Farther aside than 45°, where it is narrow, or near the end, it goes as the maps chose.
    assert_eq!(leg.stride(to(98, 102), 250), to(98, 102));
    assert_eq!(leg.stride(Displacement::ZERO, 250), Displacement::ZERO);
    let narrow = Leg { room_mm: 0, ..leg };
    assert_eq!(narrow.stride(chosen, 250), chosen);
    let near = Leg {
        is_new: false,
        way: to(100, 0),
        ..leg
    };
    assert_eq!(near.stride(to(250, 0), 250), to(100, 0));
}

#[test]
fn where_the_maps_do_not_lead_on_it_goes_straight() {
    let leg = Leg {
        way: to(900, 0),
        is_straight: true,
        ..Leg::ZERO
    };
    assert_eq!(leg.stride(to(0, 250), 250), to(250, 0));
    let short = Leg {
        way: to(100, 0),
        ..leg
    };
    assert_eq!(short.stride(to(0, 250), 250), to(100, 0));
}

#[test]
fn a_way_to_a_position_is_new_until_the_robot_sees_it_or_knows_it() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    assert!(!walker.step(Aim::Frontier).expect("a way").is_new);
    let behind_wall = Aim::Position(to(2_000, 0));
    walker.step(behind_wall);
    assert!(walker.step(behind_wall).expect("a way").is_new);
    walker.go_to(to(2_000, 0));
    let back = walker.step(Aim::Position(Displacement::ZERO));
    assert!(!back.expect("a way").is_new);
}

#[test]
fn places_stand_closer_where_a_position_is_looked_for() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    walker.go_to(to(2_000, 0));
    let places = || walker.places.positions();
    let nearest_mm = |place: Displacement| {
        let others = places().filter(|other| *other != place);
        others
            .map(|other| other.minus(place).length_mm())
            .min()
            .unwrap_or(0)
    };
    let least_mm = places().map(nearest_mm).min().unwrap_or(0);
    assert!((250..330).contains(&least_mm), "{least_mm}");
}

/// In the open: the way to a position straight ahead does not go by the middle of what is open.
#[test]
fn a_position_out_of_sight_is_approached_straight() {
    let mut walker = Walker::<256>::new(&[], (0.0, 0.0));
    for _ in 0..8 {
        walker.step(Aim::Position(to(6_000, -4_000)));
    }
    let (x, y) = walker.position();
    assert!(x > 1_300.0 && (y + 0.67 * x).abs() < 130.0, "{x} {y}");
}
