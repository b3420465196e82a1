use super::*;

/// A robot at x (0.1 in), its turret a quarter turn to the left, at `ms`.
fn at(x: i32, ms: u32) -> PosData {
    PosData {
        pose: [x, 0, 0, 900],
        sensed_ms: ms,
        ..PosData::default()
    }
}

fn state(x: i32, ms: u32, heard: &[(usize, i32, u32)]) -> State {
    let mut state = State {
        pose: at(x, 0).pose,
        time_ms: ms,
        sonar: [50; 16],
        ..State::default()
    };
    for &(sensor, x, ms) in heard {
        state.sonar_at[sensor] = at(x, ms);
    }
    state
}

#[test]
fn echoes_come_in_the_order_they_were_heard_with_the_way_between() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 1_000, &[]));
    // Rolling along x is to the right of the ring: 100 units are 254 mm.
    let mut now = state(100, 1_100, &[(2, 50, 1_080), (0, 0, 1_040)]);
    now.sonar[2] = 255;
    feed.take(&now, Some(7), Some(Progress::Ended));
    let told: Vec<_> = feed
        .hand_over()
        .iter()
        .map(|h| (h.at.as_ms(), h.event))
        .collect();
    let odometry = |dy_mm, progress| Event::Odometry {
        motion: 7,
        moved: Displacement { dx_mm: 0, dy_mm },
        turned: Bearing::ZERO,
        progress,
    };
    let echo = |sensor, range| Event::Echo { sensor, range };
    assert_eq!(
        told,
        [
            (40, echo(0, Some(Range::from_mm(1_270)))),
            (80, odometry(-127, Progress::Moving)),
            (80, echo(2, None)),
            (100, odometry(-127, Progress::Ended)),
        ]
    );
    // The same packet again says nothing new.
    feed.take(&now, Some(7), None);
    assert!(feed.hand_over().is_empty());
}

#[test]
fn what_rounding_leaves_over_is_reported_later() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 0, &[]));
    let mut sum = 0;
    for x in 1..=100 {
        feed.take(&state(x, 40 * x as u32, &[]), Some(1), None);
        for happening in feed.hand_over() {
            if let Event::Odometry { moved, .. } = happening.event {
                sum += i32::from(moved.dy_mm);
            }
        }
    }
    assert_eq!(sum, -254);
}

#[test]
fn a_turret_that_was_turned_is_reported() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 0, &[]));
    let mut turned = state(0, 40, &[]);
    turned.pose[3] = 1_800;
    feed.take(&turned, Some(1), None);
    let told = feed.hand_over();
    let [
        Happening {
            event: Event::Odometry { turned, .. },
            ..
        },
    ] = told[..]
    else {
        panic!("{told:?}");
    };
    assert_eq!(turned.as_turns(), 16_384);
}

#[test]
fn a_pause_of_this_program_is_none_of_the_ring() {
    let mut feed = Feed::default();
    feed.begin(&state(0, 1_000, &[]));
    feed.take(
        &state(0, 61_000, &[(3, 0, 60_900), (4, 0, 2_000)]),
        None,
        None,
    );
    let told = feed.hand_over();
    let times: Vec<_> = told.iter().map(|happening| happening.at.as_ms()).collect();
    assert_eq!((times, feed.now().as_ms()), (vec![0, 540], 640));
}

#[test]
fn the_sonars_asked_for_are_those_heard_longest_ago() {
    let mut feed = Feed::default();
    let mut old = state(0, 10_000, &[]);
    for sensor in 0..16 {
        old.sonar_at[sensor] = at(0, 9_000 + 40 * sensor as u32);
    }
    feed.begin(&old);
    assert_eq!(feed.longest_unheard(4), 0b1111);
    assert_eq!(feed.longest_unheard(16), u16::MAX);
}
