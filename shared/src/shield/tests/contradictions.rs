//! What an echo says of what was heard before it.

use super::*;
use crate::shield::arc::POINTS;

/// A ring from `time`, of which one transducer alone hears something.
fn ring(shield: &mut Shield<16>, config: &Config<16>, thing: Option<(usize, u16)>, time: u32) {
    for sensor in 0..16 {
        let range = thing.filter(|(place, _)| *place == sensor);
        let range = range.map(|(_, mm)| Range::from_mm(mm));
        shield.hear(config, sensor, echo(range, time));
    }
}

/// Nearer to a bound than this either answer is right, mm: sines and roundings.
const SLACK: f64 = 8.0;

/// What a cone along x from the origin, by an echo of this range, makes of a point; `None` where
/// some millimeters decide.
fn is_contradicted((along, aside): (f64, f64), range: f64, arc_range: f64) -> Option<bool> {
    let inside_by = |slack: f64| {
        let distance = along + aside.abs() / 4.0;
        let is_beyond = range > distance + 60.0 + distance / 32.0 + slack;
        let gap = if along - slack < 650.0 {
            20.0 + arc_range / 32.0
        } else {
            0.0
        };
        let edge = libm::tan(15_f64.to_radians()) * along;
        along > slack && is_beyond && aside.abs() + gap + slack <= edge
    };
    let (surely, perhaps) = (inside_by(SLACK), inside_by(-SLACK));
    (surely == perhaps).then_some(surely)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 2_000 }))]
    /// Against the same in floats, point by point: arcs that are passed over change nothing.
    #[test]
    fn an_echo_contradicts_the_points_inside_its_cone(
        face in (-250_i16..250, -250_i16..250), turn in -10_000_i16..10_000,
        range in 154_u16..1_400, heard in 154_u16..2_000,
    ) {
        let shielding = ShieldConfig::nomad200();
        let lobe = LobeShape::of(shielding.half_lobe);
        let ahead = Bearing::ZERO.direction();
        let cone = Cone::new(mm(0, 0), ahead, echo(Some(Range::from_mm(heard)), 1));
        let now = Millis::from_ms(0);
        let face = mm(face.0, face.1);
        let mut arc = arc((face.dx_mm, face.dy_mm, turn as u16, Some(range), 0), now);
        for _ in 0..2 {
            cone.look_at(&shielding, &lobe, &mut arc, range.into());
        }
        let axis = f64::from(turn) / 65_536.0 * core::f64::consts::TAU;
        let place = |towards: f64| {
            let along = f64::from(face.dx_mm) + f64::from(range) * libm::cos(towards);
            let aside = f64::from(face.dy_mm) + f64::from(range) * libm::sin(towards);
            (along, aside)
        };
        // No motion reaches what is farther away.
        let (along, aside) = place(axis);
        let nearest = f64::from(range) - f64::from(face.dx_mm.abs() + face.dy_mm.abs());
        let nearer_by = 1_200.0 - along.abs().max(aside.abs()).max(nearest);
        for point in 0..POINTS {
            let (along, aside) = place(axis + (5.0 * (point as f64 - 3.0)).to_radians());
            let expected = is_contradicted((along, aside), heard.into(), range.into());
            let expected = expected.filter(|_| nearer_by.abs() > SLACK);
            if let Some(expected) = expected.map(|expected| expected && nearer_by > 0.0) {
                let found = arc.range.is_none() || !arc.stands(point);
                prop_assert_eq!(found, expected, "{} {} {}", point, along, aside);
            }
        }
    }
}

#[test]
fn two_farther_echoes_through_the_same_cone_contradict_an_arc() {
    let config = Config::recommended();
    let after = |ranges: &[Option<u16>]| {
        let mut shield = heard(&config, &[(0, 300)]);
        for (time, range) in (6..).zip(ranges) {
            ring(&mut shield, &config, range.map(|mm| (0, mm)), time);
        }
        way(&shield, &config, mm(300, 0), 20).0
    };
    assert_eq!(after(&[]), 171);
    assert_eq!(after(&[None]), 171);
    assert_eq!(after(&[None, None]), 300);
    assert_eq!(after(&[Some(900), Some(900)]), 300);
    // An echo from there begins anew.
    assert_eq!(after(&[None, Some(300), None]), 171);
    // Not farther than the readings scatter: the newer counts.
    assert_eq!(after(&[Some(350)]), 222);
    assert_eq!(after(&[Some(350), None]), 222);
}

/// The transducers go on being heard, but none looks through the place of the arc.
#[test]
fn time_alone_opens_no_way() {
    let config = Config::recommended();
    for later in [1_001, 600_001, 86_400_000, 4_294_000_000_u32] {
        let mut shield = heard(&config, &[(0, 300)]);
        shield.heard_at = [Millis::from_ms(later); 16];
        assert_eq!(way(&shield, &config, mm(300, 0), later).0, 171, "{later}");
    }
}

/// Echoes may come late: what was heard after them is not contradicted, and a time that goes back
/// is no long silence.
#[test]
fn an_echo_contradicts_nothing_newer() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[]);
    shield.hear(&config, 0, echo(Some(Range::from_mm(300)), 100));
    for time in [99, 98, 97] {
        shield.hear(&config, 0, echo(None, time));
    }
    assert_eq!(way(&shield, &config, mm(300, 0), 101).0, 171);
    for time in [101, 102] {
        shield.hear(&config, 0, echo(None, time));
    }
    assert_eq!(way(&shield, &config, mm(300, 0), 103).0, 300);
}

/// A ring that was off may have been carried.
#[test]
fn a_transducer_that_was_silent_for_long_begins_anew() {
    let config = Config::recommended();
    let after = |silence: u32| {
        let mut shield = heard(&config, &[(0, 300)]);
        ring(&mut shield, &config, None, 5 + silence);
        way(&shield, &config, mm(300, 0), 6 + silence).0
    };
    assert_eq!((after(600_000), after(600_001)), (171, 300));
    // What others have heard stays.
    let mut shield = heard(&config, &[(0, 300), (8, 300)]);
    shield.hear(&config, 0, echo(None, 5 + 600_001));
    let kept = shield
        .arcs
        .map(|arcs| arcs.iter().any(|arc| arc.range.is_some()));
    assert_eq!(kept, core::array::from_fn(|place| place == 8));
}

/// 57 units of an axis are 0.2°, and the shield's spacing is 2 mm.
#[test]
fn a_cone_is_the_same_by_its_axis_and_by_its_face() {
    let heard_from = |face, x_q14: i16, y_q14: i16| {
        let axis = Direction { x_q14, y_q14 };
        Arc::heard(face, axis, echo(None, 0))
    };
    let ahead = Bearing::ZERO.direction();
    let cone = Cone::new(mm(231, 0), ahead, echo(None, 5));
    let is_same = |arc: &Arc| cone.is_same(arc, 2);
    assert!(is_same(&heard_from(mm(231, 0), ahead.x_q14, 56)));
    assert!(!is_same(&heard_from(mm(231, 0), ahead.x_q14, 57)));
    assert!(!is_same(&heard_from(mm(231, 0), ahead.x_q14 - 57, 0)));
    assert!(is_same(&heard_from(mm(231, -1), ahead.x_q14, 0)));
    assert!(!is_same(&heard_from(mm(231, 2), ahead.x_q14, 0)));
}

/// A corner 19° beside the axis of transducer 0, 0.17 m from its face, stands in no lobe. It was
/// heard before the ring turned.
#[test]
fn a_turn_of_the_ring_contradicts_nothing_that_left_its_lobe() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 170)]);
    // 6° to the left; what was on the axis is still in the lobe, the right end is not.
    shield.moved(Displacement::ZERO, Bearing::from_turns(1_092));
    for time in 6..16 {
        ring(&mut shield, &config, None, time);
    }
    let to_the_corner = Displacement::along(Bearing::from_turns(61_260), 250);
    assert!(way(&shield, &config, to_the_corner, 20).0 < 60);
}

/// Standing in the gap between the lobes of 0 and 1, it was heard from farther away.
#[test]
fn a_way_into_the_gap_between_two_lobes_contradicts_nothing_there() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 400)]);
    // Towards the left end of the arc, 15° aside.
    for time in 6..9 {
        shield.moved(mm(80, 10), Bearing::ZERO);
        ring(&mut shield, &config, None, time);
        ring(&mut shield, &config, None, time);
    }
    assert!(way(&shield, &config, mm(240, 70), 20).0 < 50);
}

/// The leader drove on: the cones of the next rings look through where it was.
#[test]
fn what_has_gone_is_forgotten_as_soon_as_its_place_was_looked_through() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 900)]);
    let ahead = mm(1_100, 0);
    assert_eq!(way(&shield, &config, ahead, 6).0, 772);
    shield.moved(mm(50, 0), Bearing::ZERO);
    ring(&mut shield, &config, Some((0, 1_200)), 7);
    assert_eq!(way(&shield, &config, ahead, 8).0, 722);
    shield.moved(mm(50, 0), Bearing::ZERO);
    ring(&mut shield, &config, Some((0, 1_200)), 9);
    // What the ring before says of what is farther.
    assert_eq!(way(&shield, &config, ahead, 10).0, 1_022);
}

/// The same cone, whoever looks through it.
#[test]
fn another_transducer_through_the_same_cone_replaces_what_was_heard() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 500)]);
    shield.moved(Displacement::ZERO, Bearing::from_turns(1 << 12));
    shield.hear(&config, 15, echo(Some(Range::from_mm(490)), 6));
    let kept = shield.arcs.as_flattened().iter();
    assert_eq!(kept.filter(|arc| arc.range.is_some()).count(), 1);
    // By the one that heard it last.
    let asked = |sensor: usize| {
        let among = Mask::NONE.with(sensor);
        let (now, ahead) = (
            Millis::from_ms(7),
            Displacement::along(Bearing::from_turns(61_440), 400),
        );
        shield
            .allow_by(&config, Mask::ALL, ahead, now, among)
            .distance_mm
    };
    assert!(
        asked(0) >= 399 && asked(15).abs_diff(362) <= 2,
        "{} {}",
        asked(0),
        asked(15)
    );
}

/// A board that stands between the robot and its other side: from across nothing is contradicted.
#[test]
fn who_looks_from_another_side_contradicts_nothing() {
    let config = Config::recommended();
    let wanted = mm(0, 400);
    let after = |place: usize| {
        let mut shield = heard(&config, &[(4, 400)]);
        // Beside the thing, and the ring in the open.
        let beside = Displacement::along(Bearing::from_turns((place as u16) << 12), -600);
        let at = mm(0, 631);
        shield.moved(at.plus(beside), Bearing::ZERO);
        for time in 6..12 {
            shield.hear(&config, place, echo(None, time));
        }
        shield.moved(Displacement::ZERO.minus(at.plus(beside)), Bearing::ZERO);
        for sensor in 0..16 {
            shield.heard_at[sensor] = Millis::from_ms(12);
        }
        way(&shield, &config, wanted, 13).0
    };
    assert_eq!(after(8), 272);
    assert_eq!(after(0), 272);
    assert!(after(5) > 272);
}

/// Transducer 4 heard its shortest range. From elsewhere 5 looks past its face, and what it hears
/// may be where the arc is. So the arc stays: the way along it is free, and the one towards it
/// ends.
#[test]
fn the_place_before_an_arc_is_looked_through_on_its_own() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(4, 152)]);
    shield.moved(mm(141, -20), Bearing::ZERO);
    let mut free_after = |time| {
        ring(&mut shield, &config, Some((5, 279)), time);
        [mm(-250, 0), mm(-70, 240)].map(|wanted| way(&shield, &config, wanted, time).0)
    };
    assert_eq!(free_after(6)[0], 0);
    let [along, towards] = free_after(7);
    assert_eq!(along, 250);
    assert!(towards < 100, "{towards}");
}

/// A reading below the shortest range keeps its arc there. An echo from little beyond contradicts
/// nothing, though it comes from far beyond the reading.
#[test]
fn a_reading_below_the_shortest_range_counts_as_that() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(4, 40)]);
    shield.moved(mm(0, -80), Bearing::ZERO);
    for time in [6, 7] {
        ring(&mut shield, &config, Some((4, 250)), time);
    }
    // The face is at 311, the arc 153 farther, the robot's body and margin reach 359: 105, less
    // roundings.
    let (free, _) = way(&shield, &config, mm(0, 240), 8);
    assert!((101..=105).contains(&free), "{free}");
}
