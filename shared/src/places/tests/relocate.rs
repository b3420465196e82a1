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

/// Where walls stand far away on all sides: the robot is beside the first of five places, thinks
/// that it is so far ahead of it, and hears these sectors. Where it thinks that it is then.
fn corrected(ahead_mm: i16, is_heard: fn(usize) -> bool) -> i16 {
    let view = |position: Displacement| -> [u8; 16] {
        core::array::from_fn(|sector| {
            let axis = Bearing::of_place(sector, 16).direction();
            let nearer_mm = axis.along(position.dx_mm.into(), position.dy_mm.into());
            // In units of 17.7 mm.
            libm::round(127.0 + f64::from(nearer_mm) / 17.7) as u8
        })
    };
    let mut places = Places::<16, 8>::new();
    let (points, goal) = (PointMemory::<64>::new(), perceived(&[255; 16]));
    let perceive = |places: &mut Places<16, 8>, view| {
        think(places, &points, view, Purpose::Perceive, &goal, 1);
    };
    for place in [to(0, 0), to(400, 0), to(0, 400), to(-400, 0), to(0, -400)] {
        places.moved(place.minus(places.here()));
        perceive(&mut places, view(place));
    }
    let thought = to(ahead_mm, 0);
    places.moved(thought.minus(places.here()));
    let seen = view(to(0, 0));
    perceive(
        &mut places,
        core::array::from_fn(|sector| if is_heard(sector) { seen[sector] } else { 255 }),
    );
    places.here().dx_mm
}

#[test]
fn it_takes_a_clear_contradiction_to_move_it() {
    assert_eq!(corrected(300, |_| true), 150);
    // Of the positions that are compared the nearest is 43 mm off.
    assert_eq!(corrected(57, |_| true), 57);
    assert_eq!(corrected(75, |_| true), 25);
    // One 0.5 m away fits a little better than one 0.4 m away.
    assert_eq!(corrected(460, |_| true), 260);
    // Eight sectors, and seven.
    assert_eq!(corrected(300, |sector| sector % 2 == 0), 150);
    assert_eq!(corrected(300, |sector| sector % 2 == 0 && sector > 0), 300);
}

#[test]
fn walls_count_once_at_a_decision() {
    let mut walker = among_places();
    walker.think(Purpose::Perceive);
    let walls = walker.places.walls;
    assert!(walls != WallDirections::NONE);
    walker.think(Purpose::Perceive);
    assert!(walker.places.walls == walls);
}
