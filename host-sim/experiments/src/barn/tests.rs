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
        BarnMethod::Maps,
        BarnMethod::VfhPlus,
        BarnMethod::PotentialField,
        BarnMethod::Straight,
    ] {
        let run = run(&world, method, &rules(true), 0).unwrap();
        assert_eq!(run.end, RunEnd::Reached, "{method:?}");
        assert!(run.places.last().unwrap().distance(Point::new(-2.0, 13.0)) <= REACHED_M);
        assert!(
            (40.0..70.0).contains(&run.time_s),
            "{method:?} {}",
            run.time_s
        );
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
    let [a, b] = [(); 2].map(|()| run(&world, BarnMethod::Maps, &rules(true), 3).unwrap());
    assert_eq!(a.end, RunEnd::TimedOut);
    assert_eq!(a, b);
}
