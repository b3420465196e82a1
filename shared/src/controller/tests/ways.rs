//! What the shield leaves of a way, and what the robot does then.

use super::*;

#[test]
fn a_shortened_motion_is_the_same_one_slower_and_never_longer() {
    let mut bench = Bench::new(Config::recommended());
    bench.config.exploration.shortest_mm = 240;
    bench.has_looked_around();
    bench.send(Event::Command(Command::Explore { moves: 20, seed: 3 }));
    let motion = bench.ring().motion.expect("a motion");
    let sensor = (motion.displacement.bearing().as_turns().wrapping_add(2_048) >> 12) as u8;
    bench.time += 40;
    let mut hear = |mm: u16| {
        bench
            .send(Event::Echo {
                sensor,
                range: Some(Range::from_mm(mm)),
            })
            .motion
    };
    let shorter = hear(260).expect("shorter");
    assert!(shorter.speed_mm_s < motion.speed_mm_s);
    assert_eq!(hear(400), None, "what has been shortened stays so");
    let stop = hear(100).expect("none of it");
    assert_eq!(
        (stop.displacement, stop.speed_mm_s),
        (Displacement::ZERO, 0)
    );
}

/// One that is deaf would contradict all that the others have heard.
#[test]
fn what_a_disabled_transducer_hears_is_nothing_to_the_shield() {
    let mut bench = Bench::new(Config::recommended());
    bench.config.enabled = Mask::ALL.without(3);
    bench.ring();
    let before = bench.state.shield.clone();
    for (sensor, is_used) in [(3, false), (4, true)] {
        let range = Some(Range::from_mm(777));
        bench.send(Event::Echo { sensor, range });
        assert_eq!(bench.state.shield != before, is_used, "{sensor}");
    }
}

/// From one place a thing in the gap between two lobes is not heard; where the robot's first way
/// leads there, it touches.
#[test]
fn the_first_move_is_a_short_one_across_the_way() {
    let across = |bench: &mut Bench, turns: u16| {
        let wanted = Displacement::along(Bearing::from_turns(turns), 250);
        let now = Millis::from_ms(bench.time);
        let aside = (bench.state.shield).step_aside(&bench.config, Mask::ALL, wanted, now);
        aside.map(|(way, allowed)| {
            (
                way.bearing()
                    .minus(Bearing::from_turns(turns))
                    .as_signed_turns(),
                allowed.distance_mm,
            )
        })
    };
    let mut bench = Bench::new(Config::recommended());
    bench.ring();
    let (turns, distance_mm) = across(&mut bench, 3_000).expect("a step aside");
    assert!((15_900..16_900).contains(&turns.unsigned_abs()), "{turns}");
    assert_eq!(distance_mm, 80);
    // Against a wall on the left: to the right, and in a corner of a narrow corridor along the way
    // at once.
    bench.y = 1_650;
    bench.state.shield.forget();
    bench.ring();
    assert!(across(&mut bench, 0).is_some_and(|(turns, _)| turns < 0));
    bench.config.shield = None;
    assert_eq!(
        across(&mut bench, 0),
        None,
        "nothing is known without a shield"
    );
    bench.config = Config::recommended();
    // Once 70 mm of way lie behind it, the robot knows a second view; after ten minutes of silence
    // it was carried.
    bench
        .state
        .shield
        .moved(Displacement::along(Bearing::ZERO, 69), Bearing::ZERO);
    assert!(across(&mut bench, 0).is_some());
    bench
        .state
        .shield
        .moved(Displacement::along(Bearing::ZERO, 1), Bearing::ZERO);
    assert_eq!(across(&mut bench, 0), None);
    bench.time += 599_000;
    bench.ring();
    assert_eq!(across(&mut bench, 0), None);
    bench.time += 600_001;
    bench.ring();
    assert!(across(&mut bench, 0).is_some());
}

/// Something straight ahead, and on either side or both: where more than half of the way is left
/// the robot keeps it.
#[test]
fn who_finds_a_way_closed_takes_a_detour() {
    let config = Config::recommended();
    let wanted = Displacement::along(Bearing::ZERO, 250);
    let taken = |things: &[(usize, u16)]| {
        let mut state = Bench::new(config.clone()).state;
        let now = Millis::from_ms(5);
        for sensor in 0..16 {
            let thing = things.iter().find(|(at, _)| *at == sensor);
            let range = thing.map(|(_, mm)| Range::from_mm(*mm));
            state.shield.hear(&config, sensor, Echo { range, at: now });
        }
        let (way, allowed) = state.shield.detour(&config, Mask::ALL, wanted, now, 0);
        (
            (way.bearing().as_signed_turns() + 4_096) >> 13,
            allowed.distance_mm,
        )
    };
    assert_eq!(taken(&[]), (0, 250));
    assert_eq!(taken(&[(0, 270)]), (0, 133));
    // Eighths of a turn to the left, and to the right.
    assert_eq!(taken(&[(15, 160)]), (2, 250));
    assert_eq!(taken(&[(1, 160)]), (-2, 250));
    // Closed on all sides.
    let all = core::array::from_fn::<_, 16, _>(|sensor| (sensor, 160));
    assert_eq!(taken(&all).0, 0);
}

/// Two phantom echoes: what is free between them lies between 251° and 266°, and the robot's
/// actions are 22.5° apart.
#[test]
fn who_finds_all_ways_closed_tries_others_until_one_is_free() {
    let mut bench = Bench::ready(Config::recommended());
    (bench.x, bench.y) = (0, 0);
    let near = Echo {
        range: Some(Range::from_mm(152)),
        at: Millis::from_ms(bench.time),
    };
    let moved = |dx_mm, dy_mm| Displacement { dx_mm, dy_mm };
    let shield = &mut bench.state.shield;
    shield.forget();
    shield.moved(moved(80, 0), Bearing::ZERO);
    shield.hear(&bench.config, 0, near);
    shield.hear(&bench.config, 7, near);
    shield.moved(moved(0, 20), Bearing::ZERO);
    bench.send(Event::Command(Command::Seek(Goal::avoiding(&bench.config))));
    let mut closed = 0;
    while bench
        .step()
        .motion
        .is_some_and(|motion| motion.displacement == Displacement::ZERO)
    {
        closed += 1;
        assert!(closed < 100, "it stands for good");
    }
    assert!(closed > 0);
}
