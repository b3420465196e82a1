//! Arcs and echoes that are passed over change nothing.

use super::*;
use proptest::prelude::*;
use std::vec::Vec;

/// An arc and where its transducer's face was.
fn arc(
    (x, y, turns, range, age): (i16, i16, u16, Option<u16>, u32),
    now: Millis,
) -> (Displacement, Arc) {
    let range = range.map(Range::from_mm);
    let arc = Arc {
        axis: Bearing::from_turns(turns).direction(),
        range,
        contradictions: 0,
        at: Millis::from_ms(now.as_ms().wrapping_sub(age)),
    };
    (mm(x, y), arc)
}

fn a_range() -> impl Strategy<Value = Option<u16>> {
    let ranges = prop_oneof![0_u16..1_500, any::<u16>()];
    prop::option::weighted(0.9, ranges)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 2_000 }))]
    #[test]
    fn the_way_is_as_long_as_by_every_arc_alone(
        arcs in prop::collection::vec((-900_i16..900, -900_i16..900, any::<u16>(), a_range(), 0_u32..900_000), 1..24),
        wanted in (-300_i16..=300, -300_i16..=300), half_lobe in prop_oneof![Just(2_731_u16), any::<u16>()],
        approach_mm_s in prop_oneof![Just(0_u16), 0_u16..200], limit in 0_i32..1_000,
    ) {
        let mut config = Config::recommended();
        config.shield = Some(Shielding {
            half_lobe: Bearing::from_turns(half_lobe),
            approach_mm_s,
            ..Shielding::nomad200()
        });
        let shielding = config.shield.as_ref().unwrap();
        let now = Millis::from_ms(1_000_000);
        let wanted = Displacement { dx_mm: wanted.0, dy_mm: wanted.1 };
        prop_assume!(wanted != Displacement::ZERO);
        let (faces, arcs): (Vec<_>, Vec<_>) = arcs.into_iter().map(|parts| arc(parts, now)).unzip();
        let lobe = Lobe::of(shielding.half_lobe);
        let way = Way::new(&config, shielding, lobe, wanted, i32::from(wanted.length_mm()), now);
        let exact = faces.iter().zip(&arcs).fold(limit, |distance, (face, arc)| {
            arc.range.map_or(distance, |range| way.until(*face, arc, i32::from(range.as_mm()), limit).min(distance))
        });
        prop_assert_eq!(way.until_any(&faces, &arcs, limit), exact);
    }

    /// Axes turned many times are too long by a sixteenth, or longer than any; ways from none to beyond what is glanced at.
    #[test]
    fn at_a_glance_nothing_is_missed(
        arcs in prop::collection::vec((-900_i16..900, -900_i16..900, any::<u16>(), a_range(), 0_u32..900_000), KEPT),
        heard in 0..=KEPT as u8, is_new in any::<bool>(), places in 0..=KEPT as u8, longer in prop_oneof![Just(16_i32), 16_i32..19],
        wanted in prop_oneof![(-300_i16..=300, -300_i16..=300), (-3_i16..=3, -3_i16..=3), (any::<i16>(), any::<i16>())],
        half_lobe in prop_oneof![Just(2_731_u16), any::<u16>()], approach_mm_s in prop_oneof![9 => Just(0_u16), 1 => 0_u16..200],
        speed_mm_s in prop_oneof![Just(508_u16), any::<u16>()], believed in any::<bool>(), turned in prop_oneof![Just(0_u16), any::<u16>()],
    ) {
        let mut config = Config::recommended();
        config.robot.speed_mm_s = speed_mm_s;
        config.believed = if believed { Mask::ALL } else { Mask::ALL.without(3) };
        let half_lobe = Bearing::from_turns(half_lobe);
        config.shield = Some(Shielding { half_lobe, approach_mm_s, places, ..Shielding::nomad200() });
        let now = Millis::from_ms(1_000_000);
        let mut shield = Shield::<16>::new();
        shield.lobe = Some(Lobe::of(half_lobe));
        shield.heard = Mask::NONE.with(3);
        shield.heard_at[3] = Millis::from_ms(if is_new { 1_000_000 } else { 999_000 });
        shield.turned = Bearing::from_turns(turned);
        for (place, parts) in arcs.into_iter().enumerate().take(heard.into()) {
            (shield.faces[3][place], shield.arcs[3][place]) = arc(parts, now);
            let axis = &mut shield.arcs[3][place].axis;
            let grown = |q14: i16| (i32::from(q14) * longer / 16).clamp(-32_768, 32_767) as i16;
            *axis = Direction { x_q14: grown(axis.x_q14), y_q14: grown(axis.y_q14) };
        }
        let wanted = mm(wanted.0, wanted.1);
        let allowed = shield.allow_by(&config, wanted, now, Mask::NONE.with(3));
        let cut = (allowed.distance_mm < wanted.length_mm()).then_some(allowed);
        prop_assert_eq!(shield.shorten(&config, wanted, now, 3), cut);
    }
}

#[test]
fn who_stands_meets_nothing() {
    let config = Config::recommended();
    let mut shield = Shield::<16>::new();
    for sensor in 0..16 {
        let echo = Echo {
            range: Some(Range::from_mm(0)),
            at: Millis::from_ms(5),
        };
        shield.hear(&config, sensor, echo);
    }
    let allowed = |wanted| shield.allow(&config, wanted, Millis::from_ms(6));
    let standing = allowed(Displacement::ZERO);
    assert_eq!((standing.distance_mm, standing.speed_mm_s), (0, 507));
    assert_eq!(
        allowed(Displacement {
            dx_mm: 250,
            dy_mm: 0
        })
        .distance_mm,
        0
    );
}

/// A ring in the open; transducer 4, which looks to the left, is not believed.
#[test]
fn the_ways_along_a_blind_gap_are_closed() {
    let mut config = Config::recommended();
    let mut shield = Shield::<16>::new();
    for sensor in 0..16 {
        let echo = Echo {
            range: None,
            at: Millis::from_ms(5),
        };
        shield.hear(&config, sensor, echo);
    }
    let now = Millis::from_ms(6);
    let to = |degrees: i32| {
        let turns = (degrees * 65_536 / 360).rem_euclid(65_536) as u16;
        Displacement::along(Bearing::from_turns(turns), 250)
    };
    let distance =
        |config: &Config<16>, degrees| shield.allow(config, to(degrees), now).distance_mm;
    let open = [0, 61, 90, 119, 270].map(|degrees| distance(&config, degrees));
    assert!(open.iter().all(|mm| *mm >= 249), "{open:?}");
    config.believed = Mask::ALL.without(4);
    for degrees in [61, 75, 90, 105, 119] {
        assert_eq!(distance(&config, degrees), 0, "{degrees}");
    }
    for degrees in [0, 59, 121, 180, 270] {
        assert!(distance(&config, degrees) >= 249, "{degrees}");
    }
    // A motion that was allowed before is asked about by those who hear something new.
    let guard = shield.allow_by(&config, to(90), now, Mask::NONE.with(3));
    assert!(guard.distance_mm >= 249);
}

/// A ring at time 5 in the open, but for what is said to be heard.
fn heard(config: &Config<16>, things: &[(usize, u16)]) -> Shield<16> {
    let mut shield = Shield::<16>::new();
    for sensor in 0..16 {
        let thing = things.iter().find(|(place, _)| *place == sensor);
        let range = thing.map(|(_, mm)| Range::from_mm(*mm));
        shield.hear(config, sensor, echo(range, 5));
    }
    shield
}

fn echo(range: Option<Range>, at: u32) -> Echo {
    Echo {
        range,
        at: Millis::from_ms(at),
    }
}

fn mm(dx_mm: i16, dy_mm: i16) -> Displacement {
    Displacement { dx_mm, dy_mm }
}

/// How far towards a place, and how fast, at a time.
fn way(shield: &Shield<16>, config: &Config<16>, wanted: Displacement, now: u32) -> (u16, u16) {
    let allowed = shield.allow(config, wanted, Millis::from_ms(now));
    (allowed.distance_mm, allowed.speed_mm_s)
}

/// Body 269, margin 90, faces at 231: the robot may come so far that 128 of the range are left, speed² = 2 · 762 · distance.
#[test]
fn the_way_ends_at_the_margin_and_the_speed_with_it() {
    let config = Config::recommended();
    let wanted = mm(400, 0);
    let ahead = |range: u16| way(&heard(&config, &[(0, range)]), &config, wanted, 6);
    assert_eq!(ahead(500), (372, 508));
    assert_eq!(ahead(700), (400, 508));
    assert_eq!(ahead(200), (69, 324));
    // Nearer than the ring can hear, anything may touch already.
    assert_eq!((ahead(153).0, ahead(154).0), (0, 23));
    assert_eq!(
        way(&heard(&config, &[(8, 0)]), &config, wanted, 6).0,
        400,
        "behind"
    );
    let mut short = config.clone();
    short.shield = Some(Shielding {
        least_mm: 40,
        ..Shielding::nomad200()
    });
    let begun = |wanted, range: u16| way(&heard(&short, &[(0, range)]), &short, wanted, 6).0;
    assert_eq!((begun(wanted, 160), begun(wanted, 200)), (0, 69));
    assert_eq!(
        begun(mm(20, 0), 160),
        20,
        "whoever wants little may have it"
    );
    let mut off = config.clone();
    off.shield = None;
    assert_eq!(way(&heard(&off, &[(0, 0)]), &off, wanted, 6), (400, 508));
}

#[test]
fn a_direction_is_open_while_those_who_look_there_have_been_heard() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[]);
    let ahead = mm(250, 0);
    assert_eq!(way(&shield, &config, ahead, 2_005).0, 250);
    assert_eq!(way(&shield, &config, ahead, 2_006).0, 0);
    // Those within 45° of the way; each of them.
    for sensor in [14, 15, 1, 2] {
        shield.hear(&config, sensor, echo(None, 100));
        assert_eq!(way(&shield, &config, ahead, 2_006).0, 0);
    }
    shield.hear(&config, 0, echo(None, 100));
    assert_eq!(way(&shield, &config, ahead, 2_006).0, 250);
    assert_eq!(way(&shield, &config, mm(-250, 0), 2_006).0, 0);
    shield.forget();
    assert_eq!(way(&shield, &config, ahead, 100).0, 0);
    assert_eq!(Shield::<16>::default(), Shield::new());
    // A ring in which one is not believed closes its ways likewise.
    let mut some = config.clone();
    some.believed = Mask::ALL.without(8);
    let shield = heard(&some, &[]);
    assert_eq!(
        (
            way(&shield, &some, ahead, 2_005).0,
            way(&shield, &some, ahead, 2_006).0
        ),
        (250, 0)
    );
}

/// A ring from `time`, of which transducer 0 alone hears something.
fn ring(shield: &mut Shield<16>, config: &Config<16>, ahead: Option<u16>, time: u32) {
    for sensor in 0..16 {
        let range = ahead.filter(|_| sensor == 0).map(Range::from_mm);
        shield.hear(config, sensor, echo(range, time));
    }
}

#[test]
fn two_farther_echoes_through_the_same_cone_contradict_an_arc() {
    let config = Config::recommended();
    let after = |ranges: &[Option<u16>]| {
        let mut shield = heard(&config, &[(0, 300)]);
        for (time, range) in (6..).zip(ranges) {
            ring(&mut shield, &config, *range, time);
        }
        way(&shield, &config, mm(300, 0), 20).0
    };
    assert_eq!(after(&[]), 170);
    assert_eq!(after(&[None]), 170);
    assert_eq!(after(&[None, None]), 300);
    assert_eq!(after(&[Some(900), Some(900)]), 300);
    // An echo from there begins anew.
    assert_eq!(after(&[None, Some(300), None]), 170);
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
        assert_eq!(way(&shield, &config, mm(300, 0), later).0, 170, "{later}");
    }
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
    assert_eq!((after(600_000), after(600_001)), (170, 300));
}

/// A corner 19° beside the axis of transducer 0, 0.17 m from its face, stands in no lobe. It was heard before the ring turned.
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
    let ahead = mm(1_000, 0);
    assert_eq!(way(&shield, &config, ahead, 6).0, 772);
    shield.moved(mm(50, 0), Bearing::ZERO);
    ring(&mut shield, &config, Some(1_200), 7);
    assert_eq!(way(&shield, &config, ahead, 8).0, 722);
    shield.moved(mm(50, 0), Bearing::ZERO);
    ring(&mut shield, &config, Some(1_200), 9);
    assert_eq!(way(&shield, &config, ahead, 10).0, 1_000);
}

#[test]
fn the_farthest_arc_makes_room_for_the_newest() {
    let mut config = Config::recommended();
    let ranges = |shield: &Shield<16>| {
        let mut ranges = shield.arcs[0].map(|arc| arc.range.map_or(0, Range::as_mm));
        ranges.sort_unstable();
        ranges
    };
    let hear = |config: &Config<16>| {
        let mut shield = Shield::<16>::new();
        for (time, range) in (5..).zip([700, 900, 600, 650, 660, 690]) {
            shield.hear(config, 0, echo(Some(Range::from_mm(range)), time));
            shield.moved(mm(0, 10), Bearing::ZERO);
        }
        ranges(&shield)
    };
    assert_eq!(hear(&config), [600, 650, 660, 690]);
    for (places, kept) in [
        (0, [0, 0, 0, 690]),
        (1, [0, 0, 0, 690]),
        (2, [0, 0, 600, 690]),
    ] {
        config.shield = Some(Shielding {
            places,
            ..Shielding::nomad200()
        });
        assert_eq!(hear(&config), kept, "{places}");
    }
}

/// A whole turn in steps of 1.8°, as the base reports them: the errors of the sine do not add up.
#[test]
fn a_turn_in_many_steps_moves_nothing() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 500)]);
    for step in 0..200 {
        let turn = 65_536 * (step + 1) / 200 - 65_536 * step / 200;
        shield.moved(Displacement::ZERO, Bearing::from_turns(turn as u16));
    }
    assert_eq!(way(&shield, &config, mm(400, 0), 6).0, 372);
}

#[test]
fn what_was_heard_stays_where_it_is_while_the_robot_moves_and_turns() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 500)]);
    shield.moved(mm(100, 0), Bearing::ZERO);
    assert_eq!(way(&shield, &config, mm(400, 0), 6).0, 272);
    // A quarter to the left: what was ahead is on the right. Four degrees of a sine are 1 mm in 700.
    shield.moved(Displacement::ZERO, Bearing::from_turns(16_384));
    let right = way(&shield, &config, mm(0, -400), 6).0;
    assert!(right.abs_diff(272) <= 2, "{right}");
    assert_eq!(way(&shield, &config, mm(400, 0), 6).0, 400);
}

#[test]
fn echoes_grow_old() {
    let mut config = Config::recommended();
    let shield = heard(&config, &[(0, 500)]);
    config.shield = Some(Shielding {
        approach_mm_s: 100,
        ..Shielding::nomad200()
    });
    let ahead = |config: &Config<16>, now| way(&shield, config, mm(400, 0), now).0;
    assert_eq!((ahead(&config, 5), ahead(&config, 1_005)), (372, 272));
}

/// From the middle of an arc to either end, in radii: the chord of the lobe's half.
#[test]
fn the_spread_of_a_lobe_is_at_least_its_chord_and_at_most_half_as_much_again() {
    for turns in (0..=32_768_u16).step_by(511) {
        let half = f64::from(turns) * core::f64::consts::TAU / 65_536.0;
        let chord = 2.0 * libm::sin(half / 2.0) * 16_384.0;
        let spread = f64::from(Lobe::of(Bearing::from_turns(turns)).spread_q14);
        // The sine's error of 0.0012, twice.
        assert!(
            spread >= chord && spread <= 1.51 * chord + 60.0,
            "{turns}: {spread} {chord}"
        );
    }
}

/// A way of 250 mm ahead; body and margin are 359 mm.
fn is_passed_over(change: impl Fn(&mut Shielding, &mut Arc), parts: (i16, i16, u16, u16)) -> bool {
    let (config, now) = (Config::recommended(), Millis::from_ms(1_000));
    let mut shielding = Shielding::nomad200();
    let (x, y, turns, range) = parts;
    let (face, mut arc) = arc((x, y, turns, Some(range), 10), now);
    change(&mut shielding, &mut arc);
    let lobe = Lobe::of(shielding.half_lobe);
    let way = Way::new(&config, &shielding, lobe, mm(250, 0), 250, now);
    way.is_aside(face, &arc, u32::from(range), 250)
}

#[test]
fn an_arc_behind_aside_or_beyond_the_end_is_passed_over() {
    let passed = |parts| is_passed_over(|_, _| (), parts);
    let (left, back) = (1 << 14, 1 << 15);
    assert!(passed((-231, 0, back, 500)));
    assert!(passed((0, 231, left, 600)) && passed((0, -231, 3 * left, 600)));
    assert!(passed((231, 0, 0, 1_500)));
    // In the way, at its end, or half aside.
    for parts in [(231, 0, 0, 300), (231, 0, 0, 500), (0, 231, left, 200)] {
        assert!(!passed(parts), "{parts:?}");
    }
}

#[test]
fn of_some_arcs_nothing_is_certain() {
    let behind = |range| (-231, 0, 1 << 15, range);
    let passed = |range| is_passed_over(|_, _| (), behind(range));
    // Nearer than the ring can hear it may be anywhere; products of long ranges leave 32 bits.
    assert_eq!(
        [153, 154, 32_768, 32_769].map(passed),
        [false, true, true, false]
    );
    let comes = |shielding: &mut Shielding, _: &mut Arc| shielding.approach_mm_s = 1;
    assert!(!is_passed_over(comes, behind(500)));
    // An axis whose square has grown by an eighth, and one that has grown more.
    let axis =
        |x_q14| move |_: &mut Shielding, arc: &mut Arc| arc.axis = Direction { x_q14, y_q14: 0 };
    assert!(is_passed_over(axis(-17_377), behind(500)));
    assert!(!is_passed_over(axis(-17_378), behind(500)));
}

#[test]
fn points_are_met_up_to_sixteen_metres() {
    let (config, shielding) = (Config::recommended(), Shielding::nomad200());
    let lobe = Lobe::of(shielding.half_lobe);
    let way = Way::new(
        &config,
        &shielding,
        lobe,
        mm(250, 0),
        250,
        Millis::from_ms(0),
    );
    let until = |x, y| way.until_point(x, y, 20_000);
    assert_eq!((until(16_000, 0), until(16_001, 0)), (15_641, 20_000));
    // Touched with the side: 359² is 216² + 287² but for 56.
    assert_eq!((until(1_000, 216), until(1_000, -216)), (714, 714));
    assert_eq!((until(1_000, 358), until(1_000, 359)), (974, 20_000));
    assert_eq!(
        (until(0, 0), until(-1, 0), until(1, 0)),
        (20_000, 20_000, 0)
    );
    // The limit, wherever it is nearer.
    assert_eq!(
        (
            way.until_point(1_000, 0, 640),
            way.until_point(1_000, 0, 642)
        ),
        (640, 641)
    );
}

#[test]
fn magnitudes_are_one_less_below_zero() {
    assert_eq!(
        [0, 5, i32::MAX, -1, -5, i32::MIN].map(magnitude),
        [0, 5, 0x7fff_ffff, 0, 4, 0x7fff_ffff]
    );
}

/// speed² = 2 · deceleration · distance.
#[test]
fn who_brakes_stops_within_the_distance() {
    let mut config = Config::recommended();
    assert_eq!(braking_distance(&config), 169);
    let speed = |distance| stopping_speed(&config, distance);
    assert_eq!([-1, 0, 100, 169, 170].map(speed), [0, 0, 390, 507, 508]);
    config.robot.braking_mm_s2 = 0;
    assert_eq!(braking_distance(&config), 508 * 508 / 2, "1 is the least");
}

/// Its faces are nearer to its middle than two places that count as one.
#[test]
fn a_small_robot_keeps_its_first_echo() {
    let config = Config::touzet().for_robot(crate::robot::RobotSpec::miniature());
    let mut shield = Shield::<8>::new();
    for sensor in 0..8 {
        shield.hear(&config, sensor, echo(None, 5));
    }
    let allowed = shield.allow(&config, mm(20, 0), Millis::from_ms(6));
    assert_eq!(allowed.distance_mm, 20);
}

/// 160 mm to the left: 386 mm aside for a narrow lobe, 344 mm for a wide one.
#[test]
fn a_lobe_is_as_wide_as_it_is_said_to_be_when_a_way_is_asked_for() {
    let narrow = Config::recommended();
    let mut wide = narrow.clone();
    wide.shield = Some(Shielding {
        half_lobe: Bearing::from_turns(1 << 13),
        ..Shielding::nomad200()
    });
    for told in [&narrow, &wide] {
        let shield = heard(told, &[(4, 160)]);
        assert_eq!(way(&shield, &narrow, mm(250, 0), 6).0, 250);
        assert!(way(&shield, &wide, mm(250, 0), 6).0 < 20);
    }
}
