use super::reach::reached_cells;
use super::*;

/// Forty worlds of every kind.
const SEEDS: core::ops::Range<u64> = 0..480;

#[test]
fn the_seed_determines_the_world_on_every_machine() {
    let mut digest = 0;
    for seed in 0..120 {
        let world = World::random2(seed);
        assert_eq!(world, World::random2(seed));
        assert_eq!(world.name(), format!("random2:{seed}"));
        digest = fold(digest, world.start().position);
        for shape in world.shapes() {
            shape.for_each_segment(|from, to| digest = fold(fold(digest, from), to));
            if let Shape::Circle { center, radius } = shape {
                digest = fold(fold(digest, *center), Point::new(*radius, 0.0));
            }
        }
    }
    // A change here changes every table that names these worlds.
    assert_eq!(digest, 0xb527_9cb9_1ae3_3ac4, "{digest:#x}");
    assert_ne!(World::random2(1).shapes(), World::random2(13).shapes());
}

/// Adds the bits of a point to a digest.
fn fold(digest: u64, Point { x, y }: Point) -> u64 {
    let add = |digest: u64, bits: u64| {
        (digest ^ bits)
            .wrapping_mul(0x100_0000_01b3)
            .rotate_left(29)
    };
    add(add(digest, x.to_bits()), y.to_bits())
}

#[test]
fn any_range_of_seeds_holds_all_kinds_alike() {
    let names = WorldKind::ALL.map(WorldKind::name);
    for (place, kind) in WorldKind::ALL.into_iter().enumerate() {
        let of_kind = SEEDS.filter(|&seed| WorldKind::of_seed(seed) == kind);
        assert_eq!(of_kind.count(), 40, "{kind:?}");
        assert!(!names[..place].contains(&kind.name()), "{kind:?}");
    }
    assert_eq!(WorldKind::of_seed(10_000).name(), "posts");
    assert_eq!(WorldKind::of_seed(u64::MAX).name(), "traps");
}

#[test]
fn every_world_keeps_its_promises() {
    for seed in SEEDS {
        let world = World::random2(seed);
        let case = format!("{} {:?}", world.name(), WorldKind::of_seed(seed));
        let start = world.start();
        assert!(
            start.heading == 0.0 && !world.is_inside(start.position),
            "{case}"
        );
        assert!(world.clearance(start.position) >= 0.6, "{case}");
        let (low, high) = world.bounds();
        let (wide, high) = (high.x - low.x, high.y - low.y);
        assert!(
            (6.0..=20.0).contains(&wide.max(high)),
            "{case}: {wide} × {high}"
        );
        assert!(wide.min(high) >= 2.5, "{case}: {wide} × {high}");
        let shapes = world.shapes();
        assert!(
            shapes.iter().all(|shape| shape.defect(20.0).is_none()),
            "{case}"
        );
        let Shape::Wall { points } = &shapes[0] else {
            panic!("{case}: no outer wall");
        };
        assert_eq!(points.first(), points.last(), "{case}");
        let outer = World::unchecked(String::new(), start, shapes[..1].to_vec());
        assert_eq!(outer.bounds(), world.bounds(), "{case}");
        let cells = reached_cells(&world, start.position, 0.35, usize::MAX);
        assert!(
            cells.is_some_and(|cells| cells >= 800),
            "{case}: {cells:?} cells"
        );
    }
}

#[test]
fn passages_are_0_9_m_wide_and_lead_everywhere() {
    use WorldKind::*;
    for seed in SEEDS {
        let kind = WorldKind::of_seed(seed);
        if !matches!(
            kind,
            Corridor | Rooms | Hall | Maze | Slalom | Loops | Wedges
        ) {
            continue;
        }
        let world = World::random2(seed);
        // As wide as 0.9 m less the cell that the flood needs.
        let cells = reached_cells(&world, world.start().position, 0.39, usize::MAX);
        let share = cells.unwrap_or(0) as f64 * 0.01 / free_area(&world);
        assert!((0.75..1.05).contains(&share), "{seed} {kind:?}: {share}");
    }
}

/// Area within the outer wall less that of the solids, m².
fn free_area(world: &World) -> f64 {
    let area = |shape: &Shape| match shape {
        Shape::Box { size, .. } => -size.x * size.y,
        Shape::Circle { radius, .. } => -core::f64::consts::PI * radius * radius,
        Shape::Outline { from, to } => from.cross(*to) / 2.0,
        Shape::Wall { points } if points.first() == points.last() => points
            .windows(2)
            .map(|side| side[0].cross(side[1]) / 2.0)
            .sum(),
        Shape::Wall { .. } => 0.0,
    };
    world.shapes().iter().map(area).sum()
}

#[test]
fn kinds_hold_what_their_names_say() {
    for seed in SEEDS {
        let world = World::random2(seed);
        let inner = &world.shapes()[1..];
        let circles = inner
            .iter()
            .filter(|s| matches!(s, Shape::Circle { .. }))
            .count();
        let walls = inner
            .iter()
            .filter(|s| matches!(s, Shape::Wall { .. }))
            .count();
        let kind = WorldKind::of_seed(seed);
        let (least, most, count) = match kind {
            WorldKind::Corridor | WorldKind::Wedges => (0, 0, inner.len()),
            WorldKind::Rooms => (2, 20, walls),
            WorldKind::Hall => (8, 16, inner.len()),
            WorldKind::Traps => (3, 9, walls),
            WorldKind::Posts => (5, 20, circles),
            WorldKind::Polygons => (12, 120, inner.len()),
            WorldKind::Maze => (8, 60, walls),
            WorldKind::Slalom => (3, 7, walls),
            WorldKind::Clutter => (20, 300, inner.len()),
            WorldKind::Loops => (1, 8, inner.len()),
            WorldKind::Furniture => (12, 120, circles),
        };
        assert!((least..=most).contains(&count), "{seed} {kind:?}: {count}");
    }
}

#[test]
fn the_flood_covers_a_room_and_finds_a_leak() {
    let room = |shape| World::unchecked(String::new(), Pose::default(), vec![shape]);
    let closed = Shape::room(Point::new(2.0, 2.0));
    // 16 m² without the corners, which a disc does not reach.
    let cells = reached_cells(&room(closed.clone()), Point::default(), 0.35, usize::MAX);
    assert!(
        cells.is_some_and(|cells| (1_450..=1_600).contains(&cells)),
        "{cells:?}"
    );
    let Shape::Wall { points } = closed else {
        unreachable!("a room is a wall")
    };
    let open = Shape::Wall {
        points: points[..4].to_vec(),
    };
    assert_eq!(
        reached_cells(&room(open), Point::default(), 0.35, usize::MAX),
        None
    );
}
