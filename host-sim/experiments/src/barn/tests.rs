//! The benchmark's rules, and runs in simple fields.

use super::*;
use arena::route;
use arena::world::{Pose, Shape};
use std::f64::consts::FRAC_PI_2;

fn rules(shield: bool) -> RunConditions {
    let mut config = Config::recommended();
    if !shield {
        config.shield = None;
    }
    RunConditions {
        config,
        sonar: SonarModel::Ideal,
        explore_moves: 100,
        seed: 1,
        tuning: SeekerTuning::default(),
    }
}

/// Side walls of posts as in the benchmark, and other posts.
fn field(posts: &[(f64, f64)]) -> World {
    let wall = (0..64).flat_map(|i| [-0.075, -4.425].map(|x| (x, 0.075 + 0.15 * f64::from(i))));
    let post = |(x, y)| Shape::Circle {
        center: Point::new(x, y),
        radius: 0.075,
    };
    let shapes = wall.chain(posts.iter().copied()).map(post).collect();
    let start = Pose::new(Point::new(-2.0, 3.0), FRAC_PI_2);
    World::new("field", start, shapes)
        .unwrap()
        .with_goal(Point::new(-2.0, 13.0))
}

#[test]
fn scores_are_those_of_the_challenge() {
    // 12 m at 2 m/s are 6 s: 24 s and less score a quarter, 48 s and more an eighth, 30 s are five
    // times 6 s.
    for (time_s, expected) in [
        (10.0, 0.25),
        (24.0, 0.25),
        (30.0, 0.2),
        (48.0, 0.125),
        (99.0, 0.125),
    ] {
        assert!(
            (score(Some(time_s), 12.0, CHALLENGE_M_S) - expected).abs() < 1e-12,
            "{time_s}"
        );
    }
    assert_eq!(score(None, 12.0, CHALLENGE_M_S), 0.0);
    // At 0.508 m/s 12 m take 23.6 s.
    assert_eq!(score(Some(60.0), 12.0, 0.508), 0.25);
}

#[test]
fn an_empty_field_is_crossed_by_all_that_are_told() {
    let world = field(&[]);
    assert!((route::length(&shortest(&world, 0.0).unwrap().unwrap()) - 10.0).abs() < 1e-9);
    for method in [
        BarnMethod::Places,
        BarnMethod::Maps,
        BarnMethod::VfhPlus,
        BarnMethod::PotentialField,
        BarnMethod::Straight,
        BarnMethod::KnownWay,
    ] {
        let run = run(&world, method, &rules(true), 0).unwrap();
        assert_eq!(run.end, RunEnd::Reached, "{method:?}");
        assert!(run.places.last().unwrap().distance(Point::new(-2.0, 13.0)) <= REACHED_M);
        assert!(
            (25.0..70.0).contains(&run.time_s),
            "{method:?} {}",
            run.time_s
        );
        // Two and a half steps at once.
        assert_eq!(run.time_s < 35.0, method == BarnMethod::Places);
    }
}

#[test]
fn a_post_in_the_way_is_passed_by_the_maps_and_touched_by_who_does_not_listen() {
    let world = field(&[(-2.0, 6.0), (-1.85, 6.0), (-2.15, 6.0)]);
    let maps = run(&world, BarnMethod::Maps, &rules(false), 0).unwrap();
    assert_eq!(maps.end, RunEnd::Reached);
    let straight = |shield| run(&world, BarnMethod::Straight, &rules(shield), 0).unwrap();
    assert_eq!(straight(false).end, RunEnd::Touched);
    // The shield's detours lead around it.
    assert_eq!(straight(true).end, RunEnd::Reached);
}

/// A pocket of posts, 1.5 m deep, open towards the start.
#[test]
fn places_lead_out_of_a_pocket_in_which_the_bearing_alone_stays() {
    let side = |x: f64| (0..10).map(move |i| (x, 6.0 + 0.15 * f64::from(i)));
    let end = (0..13).map(|i| (-2.9 + 0.15 * f64::from(i), 7.5));
    let world = field(
        &[
            side(-2.9).chain(side(-1.1)).collect(),
            end.collect::<Vec<_>>(),
        ]
        .concat(),
    );
    let [places, maps, vfh] = [BarnMethod::Places, BarnMethod::Maps, BarnMethod::VfhPlus]
        .map(|method| run(&world, method, &rules(false), 0).unwrap().end);
    assert_eq!(places, RunEnd::Reached);
    assert_eq!([maps, vfh], [RunEnd::TimedOut; 2]);
    // Who knows of it goes around.
    let known = run(&world, BarnMethod::KnownWay, &rules(true), 0).unwrap();
    assert_eq!(known.end, RunEnd::Reached);
    assert!(
        known
            .places
            .iter()
            .all(|place| (place.x + 2.0).abs() > 0.9 || place.y < 5.8 || place.y > 7.7)
    );
}

/// The way through the wider one of two gaps is longer.
#[test]
fn who_knows_the_field_takes_the_wider_way_and_its_guard_may_close_that() {
    let wall = |gaps: [(f64, f64); 2]| {
        let posts = (0..59).map(|i| (-0.075 - 0.075 * f64::from(i), 8.0));
        let is_open = |x: f64| {
            gaps.iter()
                .any(|(least, most)| (*least..*most).contains(&x))
        };
        field(&Vec::from_iter(posts.filter(|(x, _)| !is_open(*x))))
    };
    let crossed = |world: &World| {
        let run = run(world, BarnMethod::KnownWay, &rules(true), 0).unwrap();
        let place = run.places.iter().find(|place| place.y > 8.0);
        (run.end, place.map(|place| place.x < -2.5))
    };
    let wide = wall([(-2.4, -1.6), (-4.1, -2.7)]);
    assert_eq!(crossed(&wide), (RunEnd::Reached, Some(true)));
    // 0.85 m are wide enough for the body and its margin, 0.72 m, but not as its sonars hear it.
    let narrow = wall([(-3.9, -2.9), (0.0, 0.0)]);
    assert!(shortest(&narrow, 0.09).unwrap().is_some());
    assert_eq!(crossed(&narrow), (RunEnd::TimedOut, None));
}

#[test]
fn a_led_robot_goes_through_a_gap() {
    // A gap of 0.75 m for a body of 0.54 m, and something behind it that returns echoes.
    let across = |y| (0..30).map(move |i| (-0.075 - 0.15 * f64::from(i), y));
    let gap = across(8.0).filter(|(x, _)| !(-2.35..-1.6).contains(x));
    let behind = across(11.0).filter(|(x, _)| (-2.7..-1.3).contains(x));
    let world = field(&gap.chain(behind).collect::<Vec<_>>());
    let run = run(&world, BarnMethod::Places, &rules(false), 0).unwrap();
    assert_eq!(run.end, RunEnd::Reached);
}

#[test]
fn the_guard_of_a_led_robot_keeps_the_margin_of_the_shield() {
    let guard_mm = |shield| {
        let guard = led::robot(shield).unwrap().body().guard?;
        Some(guard.margin_mm.get())
    };
    let shield = rules(true).config.shield.unwrap();
    let narrow = ShieldConfig {
        margin_mm: 30,
        ..shield
    };
    assert_eq!(
        [Some(shield), Some(narrow), None].map(guard_mm),
        [Some(90), Some(30), None]
    );
}

#[test]
fn a_closed_field_has_no_way_and_a_run_repeats_itself() {
    let across: Vec<_> = (0..30)
        .map(|i| (-0.075 - 0.15 * f64::from(i), 8.0))
        .collect();
    let below: Vec<_> = (0..30)
        .map(|i| (-0.075 - 0.15 * f64::from(i), 0.075))
        .collect();
    let world = field(&[across, below].concat());
    assert_eq!(shortest(&world, 0.0).unwrap(), None);
    for method in [BarnMethod::Places, BarnMethod::Maps, BarnMethod::KnownWay] {
        let [a, b] = [(); 2].map(|()| run(&world, method, &rules(true), 3).unwrap());
        assert_eq!(a.end, RunEnd::TimedOut, "{method:?}");
        assert_eq!(a, b);
    }
}
