use super::*;
use crate::world::Pose;

fn point(x: f64, y: f64) -> Point {
    Point::new(x, y)
}

/// A hall of 8 m × 6 m with a wall from its lower side to 1 m above its middle.
fn hall(sources: Sources) -> World {
    let wall = Shape::Wall {
        points: vec![point(0.0, -3.0), point(0.0, 1.0)],
    };
    let start = Pose::new(point(-2.0, 0.0), 0.0);
    let world = World::new("hall", start, vec![Shape::room(point(4.0, 3.0)), wall]).unwrap();
    world.with_sources(sources).unwrap()
}

fn lamp(brightness: f64, until_s: Option<f64>) -> Light {
    Light {
        position: point(-2.0, -1.0),
        brightness,
        until_s,
    }
}

#[test]
fn light_falls_with_distance_throws_shadows_and_goes_out() {
    let world = hall(Sources {
        lights: vec![lamp(0.8, Some(60.0))],
        ..Sources::default()
    });
    let light = |x, y, time_s| world.sensed(point(x, y), time_s).light;
    assert_eq!(light(-2.0, -1.0, 0.0), 0.8);
    assert!(
        (light(-2.0, 0.0, 0.0) - 0.4).abs() < 1e-12,
        "half, 1 m away"
    );
    assert!(
        (light(-2.0, 2.0, 59.9) - 0.08).abs() < 1e-12,
        "a tenth, 3 m away"
    );
    assert_eq!(light(2.0, -1.0, 0.0), 0.0, "behind the wall");
    assert!(light(1.0, 2.9, 0.0) > 0.0, "past its end");
    assert_eq!(light(-2.0, -1.0, 60.0), 0.0);
    // It adds up to 1 at most.
    let three = hall(Sources {
        lights: vec![lamp(0.4, None), lamp(0.4, None), lamp(0.4, None)],
        ..Sources::default()
    });
    assert_eq!(three.sensed(point(-2.0, -1.0), 1e6).light, 1.0);
}

#[test]
fn a_scent_goes_around_walls() {
    let scent = Scent {
        position: point(-1.0, 0.0),
        reach_m: 2.0,
    };
    let world = hall(Sources {
        scents: vec![scent],
        ..Sources::default()
    });
    let way_m = |x, y| -2.0 * libm::log(world.sensed(point(x, y), 0.0).scent);
    assert!(way_m(-1.0, 0.0).abs() < 1e-9);
    // In steps to eight sides a straight way is up to 8 % longer than it is.
    let straight = way_m(-3.5, -1.3);
    assert!((2.8..3.1).contains(&straight), "{straight}");
    // Around the end of the wall at (0, 1): 1.41 m and 1.41 m.
    let around = way_m(1.0, 0.0);
    assert!((2.8..3.2).contains(&around), "{around}");
    // It ends at five times its reach, and in a closed room.
    assert_eq!(world.sensed(point(30.0, 0.0), 0.0).scent, 0.0);
    assert_eq!(world.sensed(point(4.5, 0.0), 0.0).scent, 0.0);
    // It takes another way when something is moved into it.
    let open = Shape::Wall {
        points: vec![point(0.0, -3.0), point(0.0, -2.0)],
    };
    let moved = world.with_shape(1, open).unwrap();
    let direct = -2.0 * libm::log(moved.sensed(point(1.0, 0.0), 0.0).scent);
    assert!((direct - 2.0).abs() < 0.05, "{direct}");
}

#[test]
fn later_patches_lie_on_earlier_ones() {
    let patch = |x, color| FloorPatch {
        center: point(x, 0.0),
        size: point(2.0, 1.0),
        angle: core::f64::consts::FRAC_PI_2,
        color: named_color(color).unwrap(),
    };
    let world = hall(Sources {
        floor: vec![patch(-2.0, "red"), patch(-2.6, "blue")],
        ..Sources::default()
    });
    let floor = |x, y| world.sensed(point(x, y), 0.0).floor;
    assert_eq!(floor(-1.7, 0.9), [0.9, 0.1, 0.1]);
    assert_eq!(floor(-2.3, 0.0), [0.1, 0.1, 0.9]);
    assert_eq!(floor(-1.0, 0.0), BARE_FLOOR);
    assert_eq!(floor(-2.0, 1.2), BARE_FLOOR, "it is turned");
}

#[test]
fn a_source_that_cannot_be_is_refused() {
    let world = || hall(Sources::default());
    let refused = |sources| world().with_sources(sources).unwrap_err().to_string();
    for brightness in [0.0, -1.0, 1.5, f64::NAN] {
        let why = refused(Sources {
            lights: vec![lamp(brightness, None)],
            ..Sources::default()
        });
        assert!(
            why.contains("a light's brightness must be above 0"),
            "{why}"
        );
    }
    for (x, reach_m, what) in [
        (0.0, 0.05, "a scent's reach must lie in 0.1..=100 m"),
        (0.0, f64::INFINITY, "a scent's reach"),
        (1e6, 1.0, "a coordinate must lie within"),
    ] {
        let position = point(x, 0.0);
        let why = refused(Sources {
            scents: vec![Scent { position, reach_m }],
            ..Sources::default()
        });
        assert!(why.contains(what), "{why}");
    }
    assert!(
        named_color("rde")
            .unwrap_err()
            .to_string()
            .contains("did you mean \"red\"")
    );
    assert!(world().sources().is_empty());
}
