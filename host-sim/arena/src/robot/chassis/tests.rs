//! Tests that skipped queries find no contact and no gap to report, by the reference model.

use super::*;
use crate::nomad::COLLISION_RADIUS_M;
use crate::reference::Reference;
use crate::reference::worlds::test_world;

/// Calls `step` for short steps of random walks in all kinds of worlds.
fn random_walks(mut step: impl FnMut(&mut Chassis, &World, Sweep, Point)) {
    let mut chassis = Chassis::new(Pose::default(), COLLISION_RADIUS_M);
    for seed in 0..16 {
        let (world, places) = test_world(seed);
        let (reference, mut noise) = (Reference::new(&world), Noise::new(seed));
        for place in places {
            let (mut at, mut angle) = (place, noise.uniform_in(0.0, TAU));
            chassis.limit_reported_gaps(noise.uniform_in(0.0, 0.2));
            for _ in 0..100 {
                angle += noise.uniform_in(-0.3, 0.3);
                let to = at + Point::unit(angle) * 0.02;
                chassis.position = at;
                let expected = reference.sweep(at, to, COLLISION_RADIUS_M);
                step(&mut chassis, &world, expected, to);
                at = to;
            }
        }
    }
}

#[test]
fn free_moves_have_no_contact_and_no_gap_to_report() {
    let (mut free, mut all) = (0, 0);
    random_walks(|chassis, world, expected, to| {
        all += 1;
        let from = chassis.position;
        if chassis.passes_freely(world, [from, to]) {
            free += 1;
            assert_eq!(expected.contact, None, "{from:?}");
            assert!(expected.min_clearance_m > chassis.max_reported_gap_m.unwrap_or(0.0));
        }
        // As in a drive, some steps are swept.
        if all % 3 == 0 {
            assert_eq!(chassis.sweep(to - from, world), {
                let to = from + (to - from);
                world.sweep(from, to, COLLISION_RADIUS_M)
            });
        }
    });
    assert!(free > all / 5 && free < all, "{free} of {all}");
}

#[test]
fn a_new_world_discards_the_free_disc() {
    let wall = |x: f64| {
        let points = vec![Point::new(x, -1.0), Point::new(x, 1.0)];
        let shapes = vec![crate::world::Shape::Wall { points }];
        World::new("wall", Pose::default(), shapes).expect("a sound world")
    };
    let (far, near) = (wall(3.0), wall(0.5));
    let mut chassis = Chassis::new(Pose::default(), COLLISION_RADIUS_M);
    chassis.limit_reported_gaps(0.3);
    let here = [Point::default(); 2];
    assert!(chassis.passes_freely(&far, here));
    assert!(!chassis.passes_freely(&near, here));
    assert!(chassis.passes_freely(&far, here));
}
