//! The fast ways against the oracle, to the bit.

use super::*;
use crate::noise::Noise;
use crate::world::{Clearing, Lobe, LobeView, Rays, Surface, View};
use core::f64::consts::TAU;

const REACH_M: f64 = 6.477;

#[test]
fn moves_have_the_oracles_bits() {
    let (mut clearing, mut touched) = (Clearing::default(), 0);
    for seed in 0..24 {
        let (world, places) = worlds(seed);
        let world = if seed % 5 == 0 {
            world.with_post(places[0], 0.269)
        } else {
            world
        };
        let (naive, mut noise) = (Naive::of(&world), Noise::new(seed));
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
                let expected = naive.sweep(at, to, 0.269);
                assert_eq!(
                    clearing.sweep(&world, at, to, 0.269),
                    expected,
                    "{seed} {at:?}"
                );
                assert_eq!(world.sweep(at, to, 0.269), expected);
                let clearance = naive.clearance(to);
                assert_eq!(clearing.clearance(&world, to), clearance, "{seed} {to:?}");
                assert_eq!(world.clearance(to), clearance);
                touched += u32::from(expected.touched());
                at = if expected.touched() { place } else { to };
            }
        }
    }
    assert!(touched > 300, "{touched}");
}

/// Short strides one after another: what is kept from stride to stride is used up to its very edge.
#[test]
fn walks_have_the_oracles_bits() {
    let mut clearing = Clearing::default();
    for seed in 0..16 {
        let (world, places) = worlds(seed);
        let (naive, mut noise) = (Naive::of(&world), Noise::new(seed));
        for place in places {
            let (mut at, mut angle) = (place, noise.uniform_in(0.0, TAU));
            for _ in 0..200 {
                angle += noise.uniform_in(-0.1, 0.1);
                let to = at + Point::unit(angle) * 0.005;
                let expected = naive.sweep(at, to, 0.269);
                assert_eq!(
                    clearing.sweep(&world, at, to, 0.269),
                    expected,
                    "{seed} {at:?}"
                );
                at = to;
            }
        }
    }
}

/// Who looks for the least gap only finds the oracle's, though most gaps are not told.
#[test]
fn the_least_gap_has_the_oracles_bits() {
    let (mut clearing, mut told, mut all) = (Clearing::default(), 0, 0);
    for seed in 0..16 {
        let (world, places) = worlds(seed);
        let (naive, mut noise) = (Naive::of(&world), Noise::new(seed));
        for place in places {
            let (mut at, mut angle) = (place, noise.uniform_in(0.0, TAU));
            let mut least = f64::INFINITY;
            for _ in 0..100 {
                angle += noise.uniform_in(-0.3, 0.3);
                let to = at + Point::unit(angle) * 0.02;
                let expected = naive.sweep(at, to, 0.1);
                clearing.tell_below(least);
                let found = clearing.sweep(&world, at, to, 0.1);
                least = least.min(expected.min_clearance_m);
                all += 1;
                if found.min_clearance_m == f64::INFINITY {
                    assert!(expected.min_clearance_m > least, "{seed} {at:?}");
                    assert_eq!(
                        (found.traveled_m, found.contact),
                        (expected.traveled_m, expected.contact)
                    );
                } else {
                    told += 1;
                    assert_eq!(found, expected, "{seed} {at:?}");
                }
                at = to;
            }
        }
    }
    assert!(told > 1_000 && told < 2 * all / 3, "{told} of {all}");
}

/// What is said to be far is neither touched nor nearer than any gap to be told, whatever was asked before.
#[test]
fn what_is_far_is_far() {
    let (mut clearing, mut far, mut all) = (Clearing::default(), 0, 0);
    for seed in 0..16 {
        let (world, places) = worlds(seed);
        let (naive, mut noise) = (Naive::of(&world), Noise::new(seed));
        for place in places {
            let (mut at, mut angle) = (place, noise.uniform_in(0.0, TAU));
            let told = noise.uniform_in(-0.1, 0.1);
            clearing.tell_below(told);
            for _ in 0..100 {
                angle += noise.uniform_in(-0.3, 0.3);
                let to = at + Point::unit(angle) * 0.02;
                let expected = naive.sweep(at, to, 0.1);
                all += 1;
                if clearing.is_far_on_look(&world, at, to, 0.1) {
                    far += 1;
                    assert_eq!(expected.contact, None, "{seed} {at:?}");
                    assert!(expected.min_clearance_m > told, "{seed} {at:?}");
                }
                let found = clearing.sweep(&world, at, to, 0.1);
                assert_eq!(found.contact, expected.contact, "{seed} {at:?}");
                at = to;
            }
        }
    }
    assert!(far > all / 3 && far < all, "{far} of {all}");
}

#[test]
fn cones_have_the_oracles_bits() {
    let (mut view, mut near) = (View::default(), 0);
    let cone = ConeShape::new(0.21);
    for seed in 0..24 {
        let (world, places) = worlds(seed);
        let world = if seed % 5 == 0 {
            world.with_post(places[0], 0.269)
        } else {
            world
        };
        let naive = Naive::of(&world);
        for (i, place) in places.into_iter().enumerate() {
            for step in 0..4 {
                let middle = place + Point::new(0.2, 0.1) * f64::from(step);
                view.build(&world, middle, 0.2305, REACH_M);
                for sensor in 0..16 {
                    let axis = Point::unit(TAU * f64::from(sensor) / 16.0 + (i % 2) as f64 * 0.3);
                    let range = view.nearest_in_cone(axis, 0.2305, cone);
                    let expected = naive.nearest_in_cone(middle, 0.2305, REACH_M, axis, cone);
                    assert_eq!(range, expected, "{seed} {middle:?} {sensor}");
                    near += u32::from(range < REACH_M);
                }
            }
        }
    }
    assert!(near > 10_000, "{near}");
}

#[test]
fn rays_have_the_oracles_bits() {
    let (mut lobe, mut rays, mut met) = (LobeView::default(), Rays::default(), 0);
    let cone = ConeShape::new(0.26);
    for seed in 0..24 {
        let (world, places) = worlds(seed);
        let world = if seed % 5 == 0 {
            world.with_post(places[0], 0.269)
        } else {
            world
        };
        let naive = Naive::of(&world);
        for (i, place) in places.into_iter().enumerate() {
            let bearing = std::f64::consts::FRAC_PI_8 * i as f64;
            let axis = Point::unit(bearing);
            let aimed = Lobe {
                middle: place,
                offset_m: 0.2305,
                axis,
                cone,
                reach_m: REACH_M,
            };
            lobe.build(&world, &aimed);
            let expected = naive.lobe(aimed.tip(), axis, cone, REACH_M);
            let mut directions = expected.promising();
            directions.retain(|direction| direction.dot(axis) >= cone.cos);
            let turns = (-10..=10).map(|ray| Point::unit(bearing + 0.025 * f64::from(ray)));
            directions.extend(turns);
            rays.clear();
            directions
                .iter()
                .for_each(|direction| rays.push(*direction));
            lobe.meet(&mut rays, f64::INFINITY);
            for (index, &direction) in directions.iter().enumerate() {
                let found = (
                    rays.ways()[index],
                    rays.numbers()[index],
                    rays.cos_incidences()[index],
                );
                let hit = expected.cast(direction);
                let hit = hit.map_or((f64::INFINITY, -f64::INFINITY, 0.0), |hit| {
                    met += 1;
                    (hit.way, hit.number, hit.cos_incidence)
                });
                assert_eq!(found, hit, "{seed} {place:?} {direction:?}");
                let whole = world.cast(place, direction);
                let number = whole.map(|hit| match hit.surface {
                    Surface::Face(index) => index as f64,
                    Surface::Circle(index) => 1e9 + index as f64,
                });
                let expected = naive.cast(place, direction);
                assert_eq!(number, expected.map(|met| met.number), "{seed} {place:?}");
                assert_eq!(whole.map(|hit| hit.distance_m), expected.map(|met| met.way));
                assert_eq!(whole.map(|hit| hit.normal), expected.map(|met| met.normal));
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
