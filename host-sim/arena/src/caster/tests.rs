//! The queries compared with slow and simple computations of the same results.

use super::*;
use crate::geometry::{Pose, wrap_angle};
use crate::noise::Noise;
use crate::nomad::COLLISION_RADIUS_M;
use crate::world::World;
use core::f64::consts::{PI, TAU};

const RADIUS: f64 = COLLISION_RADIUS_M;
const FACE_M: f64 = 0.2305;
const REACH_M: f64 = 6.477;

fn world(shapes: Vec<Shape>) -> World {
    World::unchecked("test".into(), Pose::default(), shapes)
}

fn wall(points: &[(f64, f64)]) -> Shape {
    Shape::Wall {
        points: points.iter().map(|&(x, y)| Point::new(x, y)).collect(),
    }
}

fn square(x: f64, y: f64, side: f64, angle: f64) -> Shape {
    Shape::Box {
        center: Point::new(x, y),
        size: Point::new(side, side),
        angle,
    }
}

fn post(x: f64, y: f64, radius: f64) -> Shape {
    Shape::Circle {
        center: Point::new(x, y),
        radius,
    }
}

/// A random room with some turned boxes, posts and thin walls added, and places where the robot
/// fits.
fn cluttered(seed: u64) -> (World, Vec<Point>) {
    let mut noise = Noise::new(1000 + seed);
    let mut shapes = World::random(seed).shapes().to_vec();
    for _ in 0..3 {
        let mut at = || noise.uniform_in(-3.5, 3.5);
        let (x, y, x2, y2) = (at(), at(), at(), at());
        shapes.push(square(x, y, 0.5, x2));
        shapes.push(post(x2, y2, 0.05 + 0.05 * (y + 3.5)));
        shapes.push(wall(&[(x2, y), (x2 + 0.6, y + 0.3), (x2 + 0.6, y - 0.5)]));
    }
    let world = world(shapes);
    let mut places = Vec::new();
    while places.len() < 12 {
        let place = Point::new(noise.uniform_in(-3.7, 3.7), noise.uniform_in(-3.7, 3.7));
        if !world.is_inside(place) && world.clearance(place) > RADIUS {
            places.push(place);
        }
    }
    (world, places)
}

/// The first hit of a ray, from either side, by testing every segment.
fn ray(world: &World, from: Point, direction: Point) -> f64 {
    let mut nearest = f64::INFINITY;
    for (a, b) in world.segments() {
        let (side, offset) = (b - a, a - from);
        let parallel = direction.cross(side);
        let (way, share) = (
            offset.cross(side) / parallel,
            offset.cross(direction) / parallel,
        );
        if way >= 0.0 && (0.0..=1.0).contains(&share) {
            nearest = nearest.min(way);
        }
    }
    for shape in world.shapes() {
        if let Shape::Circle { center, radius } = shape {
            let offset = *center - from;
            let depth = radius * radius - offset.cross(direction).powi(2);
            let way = offset.dot(direction) - depth.max(0.0).sqrt();
            if depth >= 0.0 && way >= 0.0 {
                nearest = nearest.min(way);
            }
        }
    }
    nearest
}

/// Nearest surface in a cone by brute force: rays 0.025° apart, two rays past each corner and one
/// to the center of each circle. Without the additional rays the error would be a millimeter.
fn dense_cone(world: &World, tip: Point, bearing: f64, half: f64) -> f64 {
    let fan = (0..=1000).map(|ray| bearing + half * (f64::from(ray) / 500.0 - 1.0));
    let (mut corners, mut middles) = (Vec::new(), Vec::new());
    for shape in world.shapes() {
        shape.for_each_corner(|corner| {
            let towards = (corner - tip).angle();
            corners.extend([towards - 1e-9, towards + 1e-9]);
        });
        if let Shape::Circle { center, .. } = shape {
            middles.push((*center - tip).angle());
        }
    }
    let special = corners.into_iter().chain(middles);
    let inside = special.filter(|&b| wrap_angle(b - bearing).abs() <= half);
    let ranges = fan.chain(inside).map(|b| ray(world, tip, Point::unit(b)));
    ranges.fold(f64::INFINITY, f64::min)
}

/// Tolerance for ranges up to 6.5 m: f32 in the query, 0.025° in the brute force.
const CONE_TOLERANCE_M: f64 = 2e-5;

#[test]
fn cone_queries_agree_with_dense_fans_of_rays() {
    let half = 12.5 * PI / 180.0;
    let cone = ConeShape::new(half);
    let (mut compared, mut beyond) = (0, 0);
    for seed in 0..8 {
        let (world, places) = cluttered(seed);
        for (i, &place) in places.iter().enumerate() {
            let view = world.view(place, FACE_M, REACH_M);
            for sensor in 0..16 {
                let bearing = TAU * f64::from(sensor) / 16.0 + 0.37 * i as f64;
                let axis = Point::unit(bearing);
                let expected = dense_cone(&world, place + axis * FACE_M, bearing, half);
                let range = view.nearest_in_cone(axis, cone);
                if expected > REACH_M {
                    assert!(range > REACH_M - CONE_TOLERANCE_M);
                    beyond += 1;
                } else {
                    assert!(
                        (range - expected).abs() < CONE_TOLERANCE_M,
                        "{range} {expected}"
                    );
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 1000 && beyond < compared / 10);
}

#[test]
fn a_cone_sees_exactly_the_nearest_point_of_a_wall() {
    let world = world(vec![wall(&[(2.0, -5.0), (2.0, 5.0)])]);
    let view = world.view(Point::default(), FACE_M, REACH_M);
    let cone = ConeShape::new(12.5 * PI / 180.0);
    for degrees in [0.0, 5.0, -12.0, 20.0, -45.0, 60.0] {
        let bearing: f64 = degrees * PI / 180.0;
        let axis = Point::unit(bearing);
        let nearest_edge = (bearing.abs() - 12.5 * PI / 180.0).max(0.0);
        let expected = (2.0 - FACE_M * axis.x) / libm::cos(nearest_edge);
        let range = view.nearest_in_cone(axis, cone);
        assert!(
            (range - expected).abs() < 1e-5,
            "{degrees}: {range} {expected}"
        );
    }
    for degrees in [110.0, 180.0, -103.0] {
        let range = view.nearest_in_cone(Point::unit(degrees * PI / 180.0), cone);
        assert!(range > 1e8, "{degrees}: {range}");
    }
}

/// A transducer can see a side of a box that is not visible from the robot's center.
#[test]
fn faces_visible_only_from_the_rim_are_kept() {
    // The top of the box is at y = 0.1 m; the face of this sonar is above it.
    let world = world(vec![square(1.3, -0.9, 2.0, 0.0)]);
    let (bearing, half) = (40.0 * PI / 180.0, 60.0 * PI / 180.0);
    let axis = Point::unit(bearing);
    let view = world.view(Point::default(), FACE_M, REACH_M);
    let expected = dense_cone(&world, axis * FACE_M, bearing, half);
    let range = view.nearest_in_cone(axis, ConeShape::new(half));
    assert!(
        (range - expected).abs() < CONE_TOLERANCE_M,
        "{range} {expected}"
    );
}

#[test]
fn a_thin_wall_is_visible_from_both_sides_and_a_solid_only_from_outside() {
    let cone = ConeShape::new(0.2);
    // Inside a box every face has its back to the center.
    let solid = world(vec![square(0.0, 0.0, 2.0, 0.3)]);
    let view = solid.view(Point::default(), 0.0, REACH_M);
    assert!(view.nearest_in_cone(Point::new(1.0, 0.0), cone) > 1e8);
    let thin = world(vec![wall(&[(1.0, -1.0), (1.0, 1.0)])]);
    for (x, axis) in [(0.0, 1.0), (2.0, -1.0)] {
        let view = thin.view(Point::new(x, 0.0), 0.0, REACH_M);
        let range = view.nearest_in_cone(Point::new(axis, 0.0), cone);
        assert!((range - 1.0).abs() < 1e-6);
    }
}

#[test]
fn a_reused_lobe_view_discards_its_surfaces() {
    let near = world(vec![wall(&[(1.0, -1.0), (1.0, 1.0)])]);
    let west = SonarLobe {
        tip: Point::default(),
        axis: Point::new(-1.0, 0.0),
        cone: ConeShape::new(0.2),
        reach_m: REACH_M,
    };
    let mut view = LobeView::default();
    let mut range = |world: &World, lobe: &SonarLobe| {
        world.aim(&mut view, lobe);
        view.cast(lobe.axis)
            .map_or(f64::INFINITY, |hit| hit.distance_m)
    };
    let east = SonarLobe {
        axis: Point::new(1.0, 0.0),
        ..west
    };
    assert!(range(&World::random(3), &west) <= 4.0);
    assert_eq!(range(&near, &west), f64::INFINITY);
    assert_eq!(range(&near, &east), 1.0);
    assert_eq!(range(&near, &west), f64::INFINITY);
}

#[test]
fn clearance_and_inside() {
    let world = world(vec![square(0.0, 0.0, 2.0, 0.0), post(5.0, 0.0, 1.0)]);
    for (x, y, clearance, inside) in [
        (3.0, 0.0, 1.0, false),
        (2.5, 0.0, 1.5, false),
        (4.0 + 1e-9, 3.0, 10f64.sqrt() - 1.0, false),
        (0.5, 0.0, 0.5, true),
        (5.0, 0.25, 0.75, true),
        (1.0 + 3.0, 1.0 + 4.0, 26f64.sqrt() - 1.0, false),
    ] {
        let at = Point::new(x, y);
        assert!((world.clearance(at) - clearance).abs() < 1e-8, "{at:?}");
        assert_eq!(world.is_inside(at), inside, "{at:?}");
    }
}

/// Compares with steps of 0.1 mm: the stop may differ by one step, the smallest gap by its change
/// in one step.
#[test]
fn sweeps_agree_with_fine_steps() {
    let mut noise = Noise::new(5);
    let (mut touched, mut free) = (0, 0);
    for seed in 0..20 {
        let (world, places) = cluttered(seed);
        for &from in &places {
            let way = Point::unit(noise.uniform_in(-PI, PI)) * noise.uniform_in(0.05, 0.8);
            let sweep = world.sweep(from, from + way, RADIUS);
            let steps = (way.length() / 1e-4) as usize;
            let gap = |i: usize| world.clearance(from + way * (i as f64 / steps as f64)) - RADIUS;
            let stop = (0..=steps).find(|&i| gap(i) < 0.0);
            let traveled = stop.unwrap_or(steps) as f64 * 1e-4;
            assert!((sweep.traveled_m - traveled).abs() < 2.5e-4 || grazes(&world, from, way));
            let least = (0..stop.unwrap_or(steps + 1))
                .map(gap)
                .fold(f64::INFINITY, f64::min);
            assert!(
                (sweep.min_clearance_m - least).abs() < 2.5e-4,
                "{sweep:?} {least}"
            );
            if sweep.touched() {
                touched += 1;
                let stopped = from + way * (sweep.traveled_m / way.length());
                assert!((world.clearance(stopped) - RADIUS).abs() < 1e-9);
                assert!((sweep.contact.unwrap().distance(stopped) - RADIUS).abs() < 1e-9);
            } else {
                free += 1;
                assert!((sweep.traveled_m - way.length()).abs() < 1e-12);
            }
        }
    }
    assert!(touched > 30 && free > 30, "{touched} {free}");
}

/// Whether a path nearly touches a surface, so that steps may miss the contact.
fn grazes(world: &World, from: Point, way: Point) -> bool {
    let sweep = world.sweep(from, from + way, RADIUS - 1e-4);
    !sweep.touched() && sweep.min_clearance_m < 2e-4
}

#[test]
fn a_disc_at_rest_against_a_wall_may_leave_and_slide_but_not_push() {
    for shape in [
        wall(&[(1.0, -3.0), (1.0, 3.0)]),
        square(2.0, 0.0, 2.0, 0.0),
        post(1.5, 0.0, 0.5),
    ] {
        let world = world(vec![shape]);
        let first = world.sweep(Point::default(), Point::new(2.0, 0.0), RADIUS);
        assert!(first.touched() && (first.traveled_m - (1.0 - RADIUS)).abs() < 1e-12);
        assert_eq!(first.min_clearance_m, 0.0);
        assert!(first.contact.unwrap().distance(Point::new(1.0, 0.0)) < 1e-9);
        let at = Point::new(first.traveled_m, 0.0);
        let go = |x: f64, y: f64| world.sweep(at, at + Point::new(x, y), RADIUS);
        let push = go(0.1, 0.0);
        assert!(push.touched() && push.traveled_m <= 1e-9, "{push:?}");
        assert!(go(0.1, 0.05).touched());
        let leave = go(-0.1, 0.0);
        assert!(!leave.touched() && (leave.traveled_m - 0.1).abs() < 1e-12);
        // Within the slack there is no contact, and a disc that is too deep may still move out.
        assert!(!go(5e-7, 0.0).touched() && go(5e-6, 0.0).touched());
        let deep = at + Point::new(1e-3, 0.0);
        assert!(
            !world
                .sweep(deep, deep - Point::new(0.1, 0.0), RADIUS)
                .touched()
        );
        let deeper = world.sweep(deep, deep + Point::new(0.1, 0.0), RADIUS);
        assert!(deeper.touched() && deeper.traveled_m == 0.0);
        assert!(!go(-0.1, 0.1).touched() && !go(0.0, 0.1).touched() && !go(0.0, 0.0).touched());
    }
}

#[test]
fn a_disc_slides_along_one_wall_into_the_next() {
    let world = world(vec![wall(&[(1.0, -3.0), (1.0, 1.0), (-3.0, 1.0)])]);
    let at = Point::new(1.0 - RADIUS, 0.0);
    let sweep = world.sweep(at, at + Point::new(1e-9, 1.0), RADIUS);
    assert!(sweep.touched() && (sweep.traveled_m - (1.0 - RADIUS)).abs() < 1e-8);
}

#[test]
fn a_fast_disc_does_not_jump_over_a_thin_wall() {
    let world = world(vec![
        wall(&[(1.0, -0.01), (1.0, 0.01)]),
        wall(&[(5.0, 0.0), (6.0, 0.0)]),
    ]);
    let sweep = world.sweep(Point::default(), Point::new(100.0, 0.0), RADIUS);
    assert!(sweep.touched() && (sweep.traveled_m - (1.0 - RADIUS)).abs() < 1e-4);
    // The path is collinear with a wall but ends before it.
    let short = world.sweep(Point::new(3.0, 0.0), Point::new(4.0, 0.0), RADIUS);
    assert!(!short.touched() && (short.min_clearance_m - (1.0 - RADIUS)).abs() < 1e-12);
    let end_on = world.sweep(Point::new(3.0, 0.0), Point::new(5.5, 0.0), RADIUS);
    assert!((end_on.traveled_m - (2.0 - RADIUS)).abs() < 1e-12);
}

#[test]
fn rays_meet_the_nearest_front() {
    let (cluttered, places) = cluttered(2);
    let mut lobe = LobeView::default();
    let cone = ConeShape::new(0.3);
    for (i, &place) in places.iter().enumerate() {
        let axis = Point::unit(i as f64);
        let aimed = SonarLobe {
            tip: place,
            axis,
            cone,
            reach_m: 20.0,
        };
        cluttered.aim(&mut lobe, &aimed);
        for offset in [-0.29, -0.1, 0.0, 0.2] {
            let direction = Point::unit(i as f64 + offset);
            let expected = ray(&cluttered, place, direction);
            let hit = cluttered.cast(place, direction).unwrap();
            assert!(
                (hit.distance_m - expected).abs() < 1e-9,
                "{hit:?} {expected}"
            );
            assert!((-hit.normal.dot(direction) - hit.cos_incidence).abs() < 1e-12);
            let hit = lobe.cast(direction).unwrap();
            assert!((hit.distance_m - expected).abs() < 1e-9);
        }
    }
}
