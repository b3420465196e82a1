//! A robot that is elsewhere than it thinks, farther than a place reaches.

use super::*;

/// Knows the ground around it, and stands at its start.
fn among_places() -> Walker<'static, 256> {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_100.0, -600.0));
    let corners = [
        (0, 0),
        (400, 0),
        (400, 400),
        (0, 400),
        (-400, 400),
        (-400, 0),
    ];
    let ways = [(-400, -400), (0, -400), (400, -400), (0, 0)];
    for (x_mm, y_mm) in corners.into_iter().chain(ways) {
        let way = to(x_mm, y_mm).minus(walker.places.here());
        walker.points.moved(&PointLimits::NOMAD, way, Bearing::ZERO);
        walker.places.moved(way);
        walker.look();
    }
    assert!(walker.places.positions().len() > 5);
    walker
}

/// What it thinks of its position after some decisions, if its odometry tells that it went, and it
/// did not; and how far off it is.
fn slipped(mut walker: Walker<'_, 256>, way: Displacement) -> (Displacement, u16) {
    let before = walker.places.here();
    walker.places.moved(way);
    for _ in 0..12 {
        // It stands where it stood.
        let thought = walker.places.here().minus(before);
        let start = walker.start;
        walker.start.0 -= f64::from(thought.dx_mm);
        walker.start.1 -= f64::from(thought.dy_mm);
        walker.look();
        walker.start = start;
    }
    let here = walker.places.here();
    (here, here.minus(before).length_mm())
}

#[test]
fn it_perceives_that_it_is_elsewhere() {
    for way in [to(400, 0), to(-300, 300), to(0, -500)] {
        let (here, off_mm) = slipped(among_places(), way);
        assert!(off_mm <= 150, "{way:?}: {here:?}");
    }
}

#[test]
fn with_a_compass_or_few_places_it_goes_by_its_odometry() {
    let mut trusting = among_places();
    trusting.places.trust_heading(true);
    assert_eq!(slipped(trusting, to(400, 0)), (to(400, 0), 400));
    let mut new = Walker::<256>::new(&TWO_ROOMS, (-1_100.0, -600.0));
    new.look();
    assert_eq!(slipped(new, to(400, 0)), (to(400, 0), 400));
}

#[test]
fn where_nothing_contradicts_it_stays() {
    assert_eq!(slipped(among_places(), to(0, 0)), (to(0, 0), 0));
}
