//! What is heard, kept, freed and allowed.

use super::*;
use proptest::prelude::*;

mod detours;
mod memory;

/// Distance along x until a disc of this radius touches a place no farther back than `back`, at
/// most `limit`.
fn until_touch((x, y): (f64, f64), radius: f64, back: f64, limit: f64) -> f64 {
    if x <= back || y.abs() >= radius {
        return limit;
    }
    (x - libm::sqrt(radius * radius - y * y)).clamp(0.0, limit)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 2_000 }))]
    /// Against the same in floats, place by place; the robot has turned and moved since.
    #[test]
    fn a_way_ends_where_the_body_meets_the_first_place(
        sensor in 0_usize..16, range in 200_u16..1_000, turned in any::<u16>(),
        (dx_mm, dy_mm) in (-300_i16..300, -300_i16..300), wanted in any::<u16>(),
    ) {
        let config = Config::recommended();
        let mut shield = Shield::<16>::new();
        shield.hear(&config, sensor, echo(Some(Range::from_mm(range)), 5));
        shield.moved(mm(dx_mm, dy_mm), Bearing::from_turns(turned));
        let angle = |turns: f64| turns / 65_536.0 * core::f64::consts::TAU;
        let axis = angle(sensor as f64 * 4_096.0);
        // The ring has turned: what is wanted is told in its frame.
        let way = angle(f64::from(wanted) + f64::from(turned));
        let (cos, sin) = (libm::cos(way), libm::sin(way));
        let range = f64::from(range);
        let half_lobe = angle(2_731.0);
        let (chord, edge) = (range * libm::cos(half_lobe), range * libm::sin(half_lobe));
        let until = |radius: f64, back: f64| {
            (-2..=2).fold(250.0, |least: f64, place| {
                let aside = edge * f64::from(place) * 0.5;
                let x = (231.0 + chord) * libm::cos(axis) - aside * libm::sin(axis) - f64::from(dx_mm);
                let y = (231.0 + chord) * libm::sin(axis) + aside * libm::cos(axis) - f64::from(dy_mm);
                least.min(until_touch((x * cos + y * sin, y * cos - x * sin), radius, back, 250.0))
            })
        };
        let wanted = Displacement::along(Bearing::from_turns(wanted), 250);
        let limits = config.shield.as_ref().unwrap();
        let found = f64::from(shield.allow_by_points(&config, limits, wanted).distance_mm);
        // Places are kept to within 4 mm a step; less than 10 mm is not begun.
        let (least, most) = (until(359.0 + 12.0, -12.0) - 12.0, until(359.0 - 12.0, 12.0) + 12.0);
        prop_assert!(least <= found.max(10.0) && found <= most, "{least} {found} {most}");
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
    // A motion that was allowed before goes on.
    assert_eq!(shield.shorten(&config, to(90)), None);
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

/// Body 269, margin 90, faces at 231: the robot may come so far that 128 of the range are left, less
/// the 3.4 % by which the chord of a lobe of ±15° is nearer; speed² = 2 · 762 · distance.
#[test]
fn the_way_ends_at_the_margin_and_the_speed_with_it() {
    let config = Config::recommended();
    let wanted = mm(400, 0);
    let ahead = |range: u16| way(&heard(&config, &[(0, range)]), &config, wanted, 6);
    assert_eq!(ahead(500), (355, 508));
    assert_eq!(ahead(700), (400, 508));
    assert_eq!(ahead(200), (65, 314));
    // Nearer than the ring can hear, anything may touch already.
    assert_eq!((ahead(153).0, ahead(154).0), (0, 21));
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
    assert_eq!((begun(wanted, 160), begun(wanted, 200)), (0, 65));
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

/// A whole turn in steps of 1.8°, as the base reports them: the errors of the sine do not add up.
#[test]
fn a_turn_in_many_steps_moves_nothing() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 500)]);
    for step in 0..200 {
        let turn = 65_536 * (step + 1) / 200 - 65_536 * step / 200;
        shield.moved(Displacement::ZERO, Bearing::from_turns(turn as u16));
    }
    assert_eq!(way(&shield, &config, mm(400, 0), 6).0, 355);
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
    assert_eq!(way(&shield, &config, mm(400, 0), 20).0, 355);
    assert!(way(&shield, &config, mm(-400, 0), 20).0 < 100);
}

#[test]
fn what_was_heard_stays_where_it_is_while_the_robot_moves_and_turns() {
    let config = Config::recommended();
    let mut shield = heard(&config, &[(0, 500)]);
    shield.moved(mm(100, 0), Bearing::ZERO);
    assert_eq!(way(&shield, &config, mm(400, 0), 6).0, 255);
    // A quarter to the left: what was ahead is on the right. Four degrees of a sine are 1 mm in
    // 700.
    shield.moved(Displacement::ZERO, Bearing::from_turns(16_384));
    let right = way(&shield, &config, mm(0, -400), 6).0;
    assert!(right.abs_diff(255) <= 2, "{right}");
    assert_eq!(way(&shield, &config, mm(400, 0), 6).0, 400);
    // What is told of the turned ring's way is turned as well.
    shield.moved(mm(0, -50), Bearing::ZERO);
    let right = way(&shield, &config, mm(0, -400), 6).0;
    assert!(right.abs_diff(205) <= 2, "{right}");
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

/// 160 mm to the left: 391 mm aside, and 276 mm ahead of that at the edge of a wide lobe.
#[test]
fn a_lobe_is_as_wide_as_it_is_said_to_be() {
    let (narrow, wide) = (Config::recommended(), wide());
    let ahead = |config: &Config<16>| way(&heard(config, &[(4, 160)]), config, mm(250, 0), 6).0;
    assert_eq!(ahead(&narrow), 250);
    assert!(ahead(&wide) < 100, "{}", ahead(&wide));
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
