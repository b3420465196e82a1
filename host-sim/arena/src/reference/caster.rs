//! The caster compared with the reference model, bit by bit.

use super::Reference;
use super::worlds::{test_world, test_world_with_post};
use crate::caster::{ConeShape, LobeView, SonarLobe, Surface};
use crate::geometry::Point;
use crate::noise::Noise;
use core::f64::consts::TAU;

const REACH_M: f64 = 6.477;

#[test]
fn sweeps_equal_the_reference() {
    let mut touched = 0;
    for seed in 0..24 {
        let (world, places) = test_world_with_post(seed);
        let (reference, mut noise) = (Reference::new(&world), Noise::new(seed));
        for place in places {
            let mut at = place;
            for step in 0..12 {
                let angle = f64::from(step % 4) * if seed % 2 == 0 { 1.0 } else { 0.1 };
                let length = if step % 5 == 4 {
                    0.9
                } else {
                    noise.uniform_in(0.0, 0.12)
                };
                let to = at + Point::unit(angle) * length;
                let expected = reference.sweep(at, to, 0.269);
                assert_eq!(world.sweep(at, to, 0.269), expected, "{seed} {at:?}");
                let clearance = reference.clearance(to);
                assert_eq!(world.clearance(to), clearance, "{seed} {to:?}");
                touched += u32::from(expected.touched());
                at = if expected.touched() { place } else { to };
            }
        }
    }
    assert!(touched > 300, "{touched}");
}

/// Random walks of short steps.
#[test]
fn walks_equal_the_reference() {
    for seed in 0..16 {
        let (world, places) = test_world(seed);
        let (reference, mut noise) = (Reference::new(&world), Noise::new(seed));
        for place in places {
            let (mut at, mut angle) = (place, noise.uniform_in(0.0, TAU));
            for _ in 0..200 {
                angle += noise.uniform_in(-0.1, 0.1);
                let to = at + Point::unit(angle) * 0.005;
                let expected = reference.sweep(at, to, 0.269);
                assert_eq!(world.sweep(at, to, 0.269), expected, "{seed} {at:?}");
                at = to;
            }
        }
    }
}

#[test]
fn cones_equal_the_reference() {
    let mut near = 0;
    let cone = ConeShape::new(0.21);
    for seed in 0..24 {
        let (world, places) = test_world_with_post(seed);
        let reference = Reference::new(&world);
        for (i, place) in places.into_iter().enumerate() {
            for step in 0..4 {
                let middle = place + Point::new(0.2, 0.1) * f64::from(step);
                let view = world.view(middle, 0.2305, REACH_M);
                for sensor in 0..16 {
                    let axis = Point::unit(TAU * f64::from(sensor) / 16.0 + (i % 2) as f64 * 0.3);
                    let range = view.nearest_in_cone(axis, cone);
                    let expected = reference.nearest_in_cone(middle, 0.2305, REACH_M, axis, cone);
                    assert_eq!(range, expected, "{seed} {middle:?} {sensor}");
                    near += u32::from(range < REACH_M);
                }
            }
        }
    }
    assert!(near > 10_000, "{near}");
}

#[test]
fn rays_equal_the_reference() {
    let (mut lobe, mut met) = (LobeView::default(), 0);
    let cone = ConeShape::new(0.26);
    for seed in 0..24 {
        let (world, places) = test_world_with_post(seed);
        let reference = Reference::new(&world);
        for (i, place) in places.into_iter().enumerate() {
            let bearing = std::f64::consts::FRAC_PI_8 * i as f64;
            let axis = Point::unit(bearing);
            let aimed = SonarLobe {
                tip: place + axis * 0.2305,
                axis,
                cone,
                reach_m: REACH_M,
            };
            world.aim(&mut lobe, &aimed);
            let expected = reference.lobe(aimed.tip, axis, cone, REACH_M);
            let mut directions = expected.promising();
            directions.retain(|direction| direction.dot(axis) >= libm::cos(0.26));
            let turns = (-10..=10).map(|ray| Point::unit(bearing + 0.025 * f64::from(ray)));
            directions.extend(turns);
            for &direction in &directions {
                let found = lobe
                    .cast(direction)
                    .map(|hit| (hit.distance_m, hit.number, hit.cos_incidence));
                let hit = expected.cast(direction);
                let hit = hit.map(|hit| (hit.distance_m, hit.number, hit.cos_incidence));
                met += u32::from(hit.is_some());
                assert_eq!(found, hit, "{seed} {place:?} {direction:?}");
                let world_hit = world.cast(place, direction);
                let number = world_hit.map(|hit| match hit.surface {
                    Surface::Face(index) => index as f64,
                    Surface::Circle(index) => 1e9 + index as f64,
                });
                let expected = reference.cast(place, direction);
                assert_eq!(number, expected.map(|hit| hit.number), "{seed} {place:?}");
                assert_eq!(
                    world_hit.map(|hit| hit.distance_m),
                    expected.map(|hit| hit.distance_m)
                );
                assert_eq!(
                    world_hit.map(|hit| hit.normal),
                    expected.map(|hit| hit.normal)
                );
            }
            let mut corners: Vec<_> = lobe
                .corners(0.0, REACH_M)
                .iter()
                .map(|(corner, _)| *corner)
                .collect();
            let mut all = expected.corners;
            for corners in [&mut corners, &mut all] {
                corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
            }
            assert_eq!(corners, all);
        }
    }
    assert!(met > 3_000, "{met}");
}
