//! What is heard, kept, contradicted and allowed.

use super::*;
use crate::units::Range;
use proptest::prelude::*;
use std::vec::Vec;

mod contradictions;
mod detours;

/// An arc heard from a face at (x, y).
fn arc((x, y, turns, range, age): (i16, i16, u16, Option<u16>, u32), now: Millis) -> Arc {
    let echo = Echo {
        range: range.map(Range::from_mm),
        at: Millis::from_ms(now.as_ms().wrapping_sub(age)),
    };
    let axis = Bearing::from_turns(turns).direction();
    Arc::heard(mm(x, y), axis, echo)
}

/// Distance along x until a disc of this radius touches a point no farther back than `back`, at
/// most `limit`.
fn until_touch((x, y): (f64, f64), radius: f64, back: f64, limit: f64) -> f64 {
    if x <= back || y.abs() >= radius {
        return limit;
    }
    (x - libm::sqrt(radius * radius - y * y)).clamp(0.0, limit)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 2_000 }))]
    /// Against the same in floats, point by point: arcs that are passed over change nothing. A lobe
    /// of nearly a half circle, which no sonar has, would be less exact: the sine of a right angle
    /// is flat.
    #[test]
    fn a_way_ends_where_the_body_meets_the_first_point(
        parts in prop::collection::vec((-900_i16..900, -900_i16..900, any::<u16>(), 154_u16..3_000), 1..24),
        wanted in any::<u16>(), half_lobe in prop_oneof![Just(2_731_u16), 0_u16..11_000], limit in 0_i32..1_000,
    ) {
        let mut config = Config::recommended();
        let half_lobe = Bearing::from_turns(half_lobe);
        config.shield = Some(ShieldConfig { half_lobe, ..ShieldConfig::nomad200() });
        let shielding = config.shield.as_ref().unwrap();
        let (lobe, now) = (LobeShape::of(half_lobe), Millis::from_ms(0));
        let wanted = Displacement::along(Bearing::from_turns(wanted), 250);
        let way = StraightPath::new(&config, shielding, &lobe, wanted, 250, now);
        let angle = |direction: Direction| libm::atan2(direction.y_q14.into(), direction.x_q14.into());
        let heading = angle(way.direction);
        let radius = f64::from(config.robot.body_radius_mm + shielding.margin_mm);
        let half = angle(half_lobe.direction());
        // The sines' error of 0.0012 moves a point by some millimeters.
        let (mut least, mut most) = (f64::from(limit), f64::from(limit));
        for (x, y, turns, range) in &parts {
            let axis = angle(Bearing::from_turns(*turns).direction());
            for step in -3..=3 {
                let towards = axis + half * f64::from(step) / 3.0;
                let (x, y) = (f64::from(*x) + f64::from(*range) * libm::cos(towards), f64::from(*y) + f64::from(*range) * libm::sin(towards));
                let (cos, sin) = (libm::cos(heading), libm::sin(heading));
                let point = (x * cos + y * sin, y * cos - x * sin);
                least = least.min(until_touch(point, radius + 10.0, -10.0, f64::from(limit)) - 10.0);
                most = most.min(until_touch(point, radius - 10.0, 10.0, f64::from(limit)) + 10.0);
            }
        }
        let arcs = parts.into_iter().map(|(x, y, turns, range)| arc((x, y, turns, Some(range), 0), now));
        let arcs: Vec<_> = arcs.collect();
        let found = f64::from(way.until_any(arcs.iter(), limit));
        prop_assert!(least <= found && found <= most, "{least} {found} {most}");
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
    let allowed = |wanted| shield.allow(&config, config.enabled, wanted, Millis::from_ms(6));
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
    let distance = |config: &Config<16>, degrees| {
        shield
            .allow(config, config.enabled, to(degrees), now)
            .distance_mm
    };
    let open = [0, 61, 90, 119, 270].map(|degrees| distance(&config, degrees));
    assert!(open.iter().all(|mm| *mm >= 249), "{open:?}");
    config.enabled = Mask::ALL.without(4);
    for degrees in [61, 75, 90, 105, 119] {
        assert_eq!(distance(&config, degrees), 0, "{degrees}");
    }
    for degrees in [0, 59, 121, 180, 270] {
        assert!(distance(&config, degrees) >= 249, "{degrees}");
    }
    // A motion that was allowed before is asked about by those who hear something new.
    let guard = shield.allow_by(&config, config.enabled, to(90), now, Mask::NONE.with(3));
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
    let allowed = shield.allow(config, config.enabled, wanted, Millis::from_ms(now));
    (allowed.distance_mm, allowed.speed_mm_s)
}

/// Body 269, margin 90, faces at 231: the robot may come so far that 128 of the range are left,
/// speed² = 2 · 762 · distance.
#[test]
fn the_way_ends_at_the_margin_and_the_speed_with_it() {
    let config = Config::recommended();
    let wanted = mm(400, 0);
    let ahead = |range: u16| way(&heard(&config, &[(0, range)]), &config, wanted, 6);
    assert_eq!(ahead(500), (372, 508));
    assert_eq!(ahead(700), (400, 508));
    assert_eq!(ahead(200), (69, 324));
    // Nearer than the ring can hear, anything may touch already.
    assert_eq!((ahead(153).0, ahead(154).0), (0, 24));
    assert_eq!(
        way(&heard(&config, &[(8, 0)]), &config, wanted, 6).0,
        400,
        "behind"
    );
    let mut short = config.clone();
    short.shield = Some(ShieldConfig {
        least_mm: 40,
        ..ShieldConfig::nomad200()
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
    some.enabled = Mask::ALL.without(8);
    let shield = heard(&some, &[]);
    assert_eq!(
        (
            way(&shield, &some, ahead, 2_005).0,
            way(&shield, &some, ahead, 2_006).0
        ),
        (250, 0)
    );
}

/// The robot drove through the middle of an arc that it had heard from afar: what is left of it is
/// far aside.
#[test]
fn an_arc_is_as_far_as_its_points_that_still_count() {
    let (config, lobe) = (
        Config::recommended(),
        LobeShape::of(Bearing::from_turns(2_731)),
    );
    let mut arc = arc((-3_000, 0, 0, Some(3_000), 0), Millis::from_ms(5));
    let distance = |arc: &Arc| 2 * isqrt(arc.half_distance_squared(&lobe, 0).into());
    assert_eq!(distance(&arc), 0);
    for point in [1, 2, 3, 4, 5] {
        (0..3).for_each(|_| arc.contradict(point));
    }
    // 3 m · sin 15° aside, 3 m · (1 - cos 15°) behind.
    assert!(distance(&arc).abs_diff(783) <= 5, "{}", distance(&arc));
    assert_eq!(distance(&Arc::NONE), 2 * 65_535);
    // It makes room for a corner, and not the corner for what is heard next.
    let mut shield = heard(&config, &[]);
    for (slot, moved) in (0..4).zip([0, 5, 10, 15]) {
        arc.face = mm(-3_000, moved);
        shield.arcs[0][slot] = arc;
    }
    for (time, range) in [(6, 500), (7, 2_500), (8, 2_600)] {
        shield.hear(&config, 0, echo(Some(Range::from_mm(range)), time));
        shield.moved(mm(0, 3), Bearing::ZERO);
    }
    let kept = shield.arcs[0].iter().filter_map(|arc| arc.range);
    assert!(kept.clone().any(|range| range == Range::from_mm(500)));
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
        config.shield = Some(ShieldConfig {
            places,
            ..ShieldConfig::nomad200()
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

/// A near wall behind the robot, as transducer 0 hears it while the ring turns: each time from
/// another direction.
#[test]
fn what_a_turned_ring_hears_of_a_wall_replaces_nothing_elsewhere() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 500)]);
    let mut turned = 0_u16;
    for (places, time) in [6, 7, 8, 9, 10].into_iter().zip(6..) {
        let turn = (places << 12) - turned;
        shield.moved(Displacement::ZERO, Bearing::from_turns(turn));
        turned += turn;
        shield.hear(&config, 0, echo(Some(Range::from_mm(200)), time));
    }
    shield.moved(
        Displacement::ZERO,
        Bearing::ZERO.minus(Bearing::from_turns(turned)),
    );
    assert_eq!(way(&shield, &config, mm(400, 0), 20).0, 372);
    assert!(way(&shield, &config, mm(-400, 0), 20).0 < 100);
}

#[test]
fn what_was_heard_stays_where_it_is_while_the_robot_moves_and_turns() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 500)]);
    shield.moved(mm(100, 0), Bearing::ZERO);
    assert_eq!(way(&shield, &config, mm(400, 0), 6).0, 272);
    // A quarter to the left: what was ahead is on the right. Four degrees of a sine are 1 mm in
    // 700.
    shield.moved(Displacement::ZERO, Bearing::from_turns(16_384));
    let right = way(&shield, &config, mm(0, -400), 6).0;
    assert!(right.abs_diff(272) <= 2, "{right}");
    assert_eq!(way(&shield, &config, mm(400, 0), 6).0, 400);
    // What is told of the turned ring's way is turned as well.
    shield.moved(mm(0, -50), Bearing::ZERO);
    let right = way(&shield, &config, mm(0, -400), 6).0;
    assert!(right.abs_diff(222) <= 2, "{right}");
}

#[test]
fn echoes_grow_old() {
    let mut config = Config::recommended();
    let shield = heard(&config, &[(0, 500)]);
    config.shield = Some(ShieldConfig {
        approach_mm_s: 100,
        ..ShieldConfig::nomad200()
    });
    let ahead = |config: &Config<16>, now| way(&shield, config, mm(400, 0), now).0;
    assert_eq!((ahead(&config, 5), ahead(&config, 1_005)), (372, 272));
}

#[test]
fn a_point_is_met_where_the_body_touches_it() {
    let (config, shielding) = (Config::recommended(), ShieldConfig::nomad200());
    let lobe = LobeShape::of(shielding.half_lobe);
    let way = StraightPath::new(
        &config,
        &shielding,
        &lobe,
        mm(250, 0),
        250,
        Millis::from_ms(0),
    );
    let until = |x, y| way.until_point((x, y), 20_000);
    assert_eq!(until(16_000, 0), 15_641);
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
            way.until_point((1_000, 0), 640),
            way.until_point((1_000, 0), 642)
        ),
        (640, 641)
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
    let allowed = shield.allow(&config, config.enabled, mm(20, 0), Millis::from_ms(6));
    assert_eq!(allowed.distance_mm, 20);
}

/// Lobes of a quarter turn.
fn wide() -> Config<16> {
    let mut config = Config::recommended();
    config.shield = Some(ShieldConfig {
        half_lobe: Bearing::from_turns(1 << 13),
        ..ShieldConfig::nomad200()
    });
    config
}

/// 160 mm to the left: 386 mm aside for a narrow lobe, 344 mm for a wide one.
#[test]
fn a_lobe_is_as_wide_as_it_is_said_to_be_when_a_way_is_asked_for() {
    let (narrow, wide) = (Config::recommended(), wide());
    for told in [&narrow, &wide] {
        let shield = heard(told, &[(4, 160)]);
        assert_eq!(way(&shield, &narrow, mm(250, 0), 6).0, 250);
        assert!(way(&shield, &wide, mm(250, 0), 6).0 < 20);
    }
}

#[test]
fn another_lobe_counts_from_the_next_echo_on() {
    let (narrow, wide) = (Config::recommended(), wide());
    let mut shield = heard(&wide, &[]);
    shield.forget();
    for sensor in 0..16 {
        shield.hear(&narrow, sensor, echo(None, 5));
    }
    assert_eq!(shield, heard(&narrow, &[]));
}

/// A ring that hears nothing nearer than the body reaches: its shortest reading may be anything
/// nearer.
#[test]
fn the_shortest_reading_is_not_passed_over_by_a_small_body() {
    let mut config = Config::recommended();
    config.robot.body_radius_mm = 28;
    config.robot.face_radius_mm = 27;
    config.robot.speed_mm_s = 100;
    let shielding = ShieldConfig {
        margin_mm: 10,
        ..ShieldConfig::nomad200()
    };
    config.shield = Some(shielding);
    let shield = heard(&config, &[(0, 153)]);
    assert_eq!(way(&shield, &config, mm(20, 0), 6).0, 0);
    // A wall at 154 mm is farther than 20 mm and the margin.
    let shield = heard(&config, &[(0, 154)]);
    assert_eq!(way(&shield, &config, mm(20, 0), 6).0, 20);
}
