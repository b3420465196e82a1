//! Where the robot is, by what it perceives.

use super::*;

impl Walker<'_> {
    /// Odometry tells that it went there, and it did not.
    fn slip(&mut self, way: Displacement) {
        self.start.0 -= f64::from(way.dx_mm);
        self.start.1 -= f64::from(way.dy_mm);
        self.places.moved(way);
    }

    fn locate(&mut self, view: &[u8; 16]) -> Displacement {
        let (x, y) = self.position();
        self.places.locate(ENCODING, view);
        // The walls stay where they are.
        let moved = (self.position().0 - x, self.position().1 - y);
        (self.start.0, self.start.1) = (self.start.0 - moved.0, self.start.1 - moved.1);
        self.places.here()
    }
}

#[test]
fn at_a_known_place_it_perceives_that_odometry_was_wrong() {
    for slip in [to(60, -40), to(-50, -50), to(0, 80)] {
        let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_100.0, -300.0));
        walker.look();
        walker.slip(slip);
        for _ in 0..20 {
            walker.look();
            let view = walker.view();
            travel(&mut walker.places, 400);
            walker.locate(&view);
        }
        let here = walker.places.here();
        assert!(here.is_shorter_than(25), "{slip:?}: {here:?}");
    }
}

/// There and back.
fn travel<const RECORDS: usize>(places: &mut Places<16, RECORDS>, mm: i16) {
    places.moved(to(mm / 2, 0));
    places.moved(to(-mm / 2, 0));
}

/// What else a robot that stands perceives tells nothing new.
#[test]
fn the_position_is_corrected_by_little_more_than_wheels_slip() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_100.0, -300.0));
    walker.look();
    walker.slip(to(0, 80));
    let view = walker.view();
    travel(&mut walker.places, 160);
    walker.locate(&view);
    // Of 240 mm, an eighth.
    let before = walker.places.here();
    assert_eq!(before, to(0, 50));
    for _ in 0..20 {
        walker.locate(&view);
    }
    assert_eq!(walker.places.here(), before);
}

#[test]
fn one_that_was_set_down_is_corrected_by_what_it_perceives_at_once() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_000.0, -1_400.0));
    while walker.step(Aim::Frontier).is_some() {}
    walker.places.set_down();
    let before = walker.places.here();
    walker.start.0 -= f64::from(before.dx_mm) + 1_000.0;
    walker.start.1 -= f64::from(before.dy_mm);
    walker.look();
    let view = walker.view();
    let there = walker.locate(&view);
    walker.slip(to(0, 80));
    let view = walker.view();
    walker.locate(&view);
    let off_mm = walker.places.here().minus(there).length_mm();
    assert!((20..60).contains(&off_mm), "{off_mm}");
}

#[test]
fn what_does_not_tell_that_it_is_elsewhere_leaves_it_where_it_is() {
    let mut walker = Walker::<256>::new(&TWO_ROOMS, (-1_100.0, -300.0));
    let view = walker.view();
    assert_eq!(walker.locate(&view), Displacement::ZERO);
    walker.look();
    // 53 mm of noise, a little more of it on one side.
    let is_farther = |sector| [4, 6, 8, 10, 12, 14].contains(&sector);
    let noise = |sector| if is_farther(sector) { -3 } else { 3 };
    let noisy = core::array::from_fn(|sector| view[sector].saturating_add_signed(noise(sector)));
    assert_eq!(walker.locate(&noisy), Displacement::ZERO);
    // Things all around have gone, or nothing has been seen of them.
    assert_eq!(walker.locate(&[40; 16]), Displacement::ZERO);
    assert_eq!(walker.locate(&[0; 16]), Displacement::ZERO);
    assert_eq!(walker.locate(&[255; 16]), Displacement::ZERO);
    // Far from all places.
    walker.slip(to(300, 0));
    assert_eq!(walker.locate(&view), to(300, 0));
}

#[test]
fn a_place_keeps_what_it_showed_at_first_and_adds_what_it_did_not() {
    let mut record = record::Record::<4>::new(Displacement::ZERO, &[10, 255, 30, 255]);
    record.complete(&[99, 20, 255, 255]);
    assert_eq!(record.view, [10, 20, 30, 255]);
}

#[test]
fn only_what_shows_the_same_things_tells_where_it_is() {
    let walls = [100; 16];
    let only = |seen: u8, sectors: &[usize]| {
        core::array::from_fn(|sector| if sectors.contains(&sector) { 100 } else { seen })
    };
    // As seen from farther ahead, in units of 18 mm.
    let ahead = |view: [u8; 16], units: f64| {
        core::array::from_fn(|sector| {
            let nearer = units * libm::cos(sector as f64 * core::f64::consts::TAU / 16.0);
            match view[sector] {
                seen @ (0 | 255) => seen,
                seen => seen.saturating_add_signed(libm::round(nearer) as i8),
            }
        })
    };
    // Where it thinks that it is after this view, if it thought that it had gone so far.
    let located = |before: [u8; 16], thought_mm: i16, now: [u8; 16]| {
        let mut places = Places::<16, 4>::new();
        let (points, goal) = (PointMemory::<64>::new(), perceived(&before));
        think(&mut places, &points, before, Purpose::Perceive, &goal, 1);
        places.moved(to(thought_mm, 0));
        travel(&mut places, 1_000);
        places.locate(ENCODING, &now);
        places.here().dx_mm
    };
    assert!((20..40).contains(&located(walls, 50, walls)));
    // Five sectors are too few.
    let five = only(255, &[14, 15, 0, 1, 2]);
    assert_eq!(located(walls, 50, five), 50);
    assert_eq!(located(five, 50, walls), 50);
    // Nothing is in range behind it: that does not say that it stands still.
    let front = only(0, &[12, 13, 14, 15, 0, 1, 2, 3, 4]);
    assert!((10..40).contains(&located(front, 0, ahead(front, 3.0))));
    // Other things, 0.3 m nearer and farther.
    assert_eq!(located(walls, 0, ahead(walls, 17.0)), 0);
    // It is not at that place.
    assert_eq!(located(walls, 300, ahead(walls, 14.0)), 300);
}
