use super::*;
use crate::points::{Beam, PointLimits};
use crate::units::Range;

const LIMITS: PointLimits = PointLimits::NOMAD;
const FACE_MM: i32 = 230;

fn degrees(angle: f64) -> Bearing {
    Bearing::from_turns((angle / 360.0 * 65_536.0).round() as i32 as u16)
}

/// A beam of a round body.
fn beam(axis_deg: f64, range_mm: u16) -> Beam {
    Beam {
        mount: Displacement::along(degrees(axis_deg), FACE_MM),
        axis: degrees(axis_deg),
        range: Range::from_mm(range_mm),
        is_echo: true,
    }
}

/// Heard of a wall 1 m away by a cone whose axis is so far from its normal, after the robot has
/// come nearer by so much.
fn of_wall(axis_deg: f64, normal_deg: f64, nearer_mm: f64) -> Beam {
    let off_axis = (axis_deg - normal_deg).to_radians();
    // The face is nearer to the wall than the center.
    let range_mm = 1_000.0 - nearer_mm - f64::from(FACE_MM) * libm::cos(off_axis);
    beam(axis_deg, range_mm as u16)
}

/// Hears one beam, goes, hears another; what the latest points tell of walls.
fn heard(one: &Beam, way: (f64, i32), other: &Beam, frame: Bearing) -> [u16; PARTS] {
    let mut memory = PointMemory::<64>::new();
    memory.hear(&LIMITS, one);
    let (angle, length_mm) = way;
    let way = Displacement::along(degrees(angle), length_mm);
    memory.moved(&LIMITS, way, Bearing::ZERO);
    memory.hear(&LIMITS, other);
    let mut walls = WallDirections::NONE;
    for latest in 0..LATEST {
        memory.add_walls(latest, frame, &mut walls);
    }
    *walls.weights()
}

/// Mean direction, degrees from 0 to 90, and the sum of the weights.
fn mean_deg(weights: &[u16; PARTS]) -> (f64, u32) {
    let parts = weights.iter().enumerate();
    let sum = |moment: fn(f64) -> f64| -> f64 {
        let turned = parts.clone().map(|(part, weight)| {
            let angle = part as f64 / PARTS as f64 * core::f64::consts::TAU;
            moment(angle) * f64::from(*weight)
        });
        turned.sum()
    };
    let angle = libm::atan2(sum(libm::sin), sum(libm::cos)).to_degrees() / 4.0;
    let all = weights.iter().map(|weight| u32::from(*weight)).sum();
    (angle.rem_euclid(90.0), all)
}

#[test]
fn two_echoes_of_a_wall_tell_its_direction() {
    for normal in [90.0, 85.0, 99.0, -90.0, 3.0, 178.0, 45.0] {
        // Past the wall, on either side of it, and nearer by 0.1 m.
        for side in [-90.0, 90.0] {
            let way = (normal + side, 400);
            let (one, other) = (normal - 6.0, normal + 5.0);
            let first = of_wall(one, normal, 0.0);
            let (mean, weight) = mean_deg(&heard(
                &first,
                way,
                &of_wall(other, normal, 0.0),
                Bearing::ZERO,
            ));
            let error = (mean - normal + 45.0).rem_euclid(90.0) - 45.0;
            assert!(error.abs() < 1.5, "{normal} {side}: {mean}");
            assert!((38..=39).contains(&weight), "{weight}");
        }
        let askew = (normal - 60.0, 400);
        let nearer = of_wall(normal + 5.0, normal, 200.0);
        let first = of_wall(normal - 6.0, normal, 0.0);
        let (mean, weight) = mean_deg(&heard(&first, askew, &nearer, degrees(10.0)));
        let error = (mean - 10.0 - normal + 45.0).rem_euclid(90.0) - 45.0;
        assert!(error.abs() < 2.0, "{normal}: {mean}");
        assert!((28..=30).contains(&weight), "{weight}");
    }
}

#[test]
fn what_is_no_wall_or_was_heard_too_near_or_too_far_off_tells_nothing() {
    let weight = |length_mm, other: &Beam| {
        let first = of_wall(90.0, 90.0, 0.0);
        mean_deg(&heard(&first, (0.0, length_mm), other, Bearing::ZERO)).1
    };
    let wall = of_wall(90.0, 90.0, 0.0);
    assert_eq!(weight(190, &wall), 0);
    assert!(weight(210, &wall) > 0);
    assert!(weight(790, &wall) > 0);
    assert_eq!(weight(810, &wall), 0);
    // A tangent of 14°, outside of the cones.
    assert!(weight(400, &of_wall(90.0, 90.0, 80.0)) > 0);
    assert_eq!(weight(400, &of_wall(90.0, 90.0, 100.0)), 0);
    // A step between them longer than the way, and what is on the other side.
    assert_eq!(weight(400, &beam(90.0, 100)), 0);
    assert_eq!(weight(400, &of_wall(-90.0, -90.0, 0.0)), 0);
    let silent = Beam {
        is_echo: false,
        ..wall
    };
    assert_eq!(weight(400, &silent), 0);
}

#[test]
fn only_what_is_heard_here_counts_as_new() {
    let mut memory = PointMemory::<64>::new();
    memory.hear(&LIMITS, &of_wall(90.0, 90.0, 0.0));
    let along = |mm| Displacement {
        dx_mm: mm,
        dy_mm: 0,
    };
    memory.moved(&LIMITS, along(400), Bearing::ZERO);
    memory.hear(&LIMITS, &of_wall(90.0, 90.0, 0.0));
    let mut walls = WallDirections::NONE;
    memory.add_walls(0, Bearing::ZERO, &mut walls);
    assert_ne!(walls, WallDirections::NONE);
    memory.moved(&LIMITS, along(30), Bearing::ZERO);
    let mut later = WallDirections::NONE;
    for latest in 0..LATEST {
        memory.add_walls(latest, Bearing::ZERO, &mut later);
    }
    assert_eq!(later, WallDirections::NONE);
}

#[test]
fn extreme_ranges_and_ways_do_no_harm() {
    for range_mm in [0, 1, 32_767, 65_534] {
        for length_mm in [200, 799] {
            let (one, other) = (beam(45.0, range_mm), beam(225.0, 65_534));
            heard(&one, (45.0, length_mm), &other, Bearing::ZERO);
            heard(&other, (45.0, length_mm), &one, Bearing::ZERO);
        }
    }
}
