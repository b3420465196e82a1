//! What the chassis leaves out is never wanted: against the reference model.

use super::*;
use crate::reference::Reference;
use crate::reference::worlds::worlds;

/// Calls `step` with short strides from place to place on random walks, in worlds of every kind.
fn walk(mut step: impl FnMut(&mut Chassis, &World, Sweep, Point)) {
    let mut chassis = Chassis::new(Pose::default());
    for seed in 0..16 {
        let (world, places) = worlds(seed);
        let (reference, mut noise) = (Reference::of(&world), Noise::new(seed));
        for place in places {
            let (mut at, mut angle) = (place, noise.uniform_in(0.0, TAU));
            chassis.tell_gaps_below(noise.uniform_in(0.0, 0.2));
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
fn what_passes_freely_touches_nothing_and_has_no_wanted_gap() {
    let (mut free, mut all) = (0, 0);
    walk(|chassis, world, expected, to| {
        all += 1;
        let from = chassis.position;
        if chassis.passes_freely(world, [from, to]) {
            free += 1;
            assert_eq!(expected.contact, None, "{from:?}");
            assert!(expected.min_clearance_m > chassis.gaps_below_m.unwrap_or(0.0));
        }
        // As on the way: some strides are swept, some are not.
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
fn another_world_is_looked_at_anew() {
    let wall = |x: f64| {
        let points = vec![Point::new(x, -1.0), Point::new(x, 1.0)];
        let shapes = vec![crate::world::Shape::Wall { points }];
        World::new("wall", Pose::default(), shapes).expect("a sound world")
    };
    let (far, near) = (wall(3.0), wall(0.5));
    let mut chassis = Chassis::new(Pose::default());
    chassis.tell_gaps_below(0.3);
    let here = [Point::default(); 2];
    assert!(chassis.passes_freely(&far, here));
    assert!(!chassis.passes_freely(&near, here));
    assert!(chassis.passes_freely(&far, here));
}
