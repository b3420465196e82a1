//! What stops the robot by itself, and which echoes it does not use.

use super::*;

impl Bench {
    /// A robot that has just been sent on its first random move.
    fn moving() -> (Self, Motion) {
        let mut bench = Self::new(Config::recommended());
        bench.has_looked_around();
        bench.send(Event::Command(Command::Explore { moves: 5, seed: 12 }));
        let motion = bench.ring().motion.expect("a motion");
        (bench, motion)
    }

    fn at(&mut self, time: u32, event: Event<16>) -> Out {
        self.time = time;
        self.send(event)
    }

    fn is_stopped(&self, reason: StopReason) -> bool {
        self.state.mode() == &Mode::Stopped(reason)
    }

    /// The whole ring says this, `age_ms` ago.
    fn says(&mut self, range_mm: Option<u16>, age_ms: u32) -> Vec<Out> {
        let heard = self.time - age_ms;
        let echo = |sensor| Event::Echo {
            sensor,
            range: range_mm.map(Range::from_mm),
        };
        let echoes = (0..16).map(|sensor| {
            let at = Millis::from_ms(heard);
            handle(&self.config, &mut self.state, at, echo(sensor))
        });
        echoes.collect()
    }

    fn report(&mut self, time: u32, motion: u16, dx_mm: i16, progress: Progress) {
        let moved = Displacement { dx_mm, dy_mm: 0 };
        let turned = Bearing::ZERO;
        let report = Event::Odometry {
            motion,
            moved,
            turned,
            progress,
        };
        self.at(time, report);
    }
}

#[test]
fn a_ring_that_stays_incomplete_for_two_periods_stops_the_robot() {
    let mut bench = Bench::new(Config::recommended());
    bench.send(Event::Command(Command::Explore { moves: 5, seed: 3 }));
    assert!(!bench.at(1_280, Event::Tick).mode_changed);
    assert!(bench.at(1_281, Event::Tick).mode_changed);
    assert!(bench.is_stopped(StopReason::RingIncomplete));
    // After a motion it is awaited from the motion's end.
    bench.send(Event::Command(Command::Resume));
    let motion = bench.ring().motion.expect("a motion");
    bench.time += 400;
    let end = bench.time;
    bench.execute(motion);
    assert!(!bench.at(end + 1_280, Event::Tick).mode_changed);
    assert!(bench.at(end + 1_281, Event::Tick).mode_changed);
}

/// The base reports that it moves, and the ring is heard, but for one transducer.
#[test]
fn a_transducer_that_is_not_heard_for_two_periods_stops_a_moving_robot() {
    let (mut bench, motion) = Bench::moving();
    let began = bench.time;
    let stopped = (1..2_000).find(|ms| {
        let time = began + ms;
        if ms % 40 == 0 {
            let sensor = (ms / 40 % 16) as u8;
            let range = Some(Range::from_mm(1_500));
            if sensor != 9 || *ms < 640 {
                bench.at(time, Event::Echo { sensor, range });
            }
            // It still turns its wheels.
            bench.report(time, motion.id, 0, Progress::Steering);
        }
        bench.at(time, Event::Tick).mode_changed
    });
    // Transducer 9 was heard last 360 ms after the start.
    assert_eq!(stopped, Some(360 + 1_281));
    assert!(bench.is_stopped(StopReason::RingIncomplete));
}

#[test]
fn a_motion_that_does_not_end_by_its_deadline_stops_the_robot() {
    let (mut bench, motion) = Bench::moving();
    let (began, distance_mm) = (bench.time, u32::from(motion.displacement.length_mm()));
    // All the way at 508 mm/s, twice, and a second.
    assert_eq!((distance_mm, motion.speed_mm_s), (247, 508));
    let longest_ms = 2_000 * 247 / 508 + 1_000;
    for time in (began..=began + longest_ms).step_by(10) {
        bench.says_at(time);
        bench.report(time, motion.id, 0, Progress::Moving);
        assert!(!bench.at(time, Event::Tick).mode_changed);
    }
    let stop = bench.at(began + longest_ms + 1, Event::Tick);
    assert!(bench.is_stopped(StopReason::Overdue));
    let stop = stop.motion.expect("a stop");
    assert!(stop.displacement == Displacement::ZERO && stop.id != motion.id);
}

/// It was off, or carried elsewhere: nothing ticked. Who ticks on is stopped, whatever it is told.
#[test]
fn a_robot_that_is_sent_elsewhere_after_a_pause_waits_anew() {
    let seek = Event::Command(Command::Seek(Goal::free_of_obstacles()));
    for is_moving in [false, true] {
        let mut bench = Bench::ready(Config::recommended());
        bench.send(seek);
        if is_moving {
            assert!(bench.ring().motion.is_some());
        }
        let later = bench.time + 601_000;
        assert_eq!(bench.at(later, seek).stopped, None);
        assert!(!bench.at(later + 900, Event::Tick).mode_changed);
        // Nothing is heard and nothing ends.
        assert!(bench.at(later + 1_300, Event::Tick).mode_changed);
        // Without a command the pause counts.
        let mut bench = Bench::ready(Config::recommended());
        bench.send(seek);
        assert!(bench.at(bench.time + 601_000, Event::Tick).mode_changed);
    }
}

#[test]
fn steering_puts_the_deadline_off_for_as_long_as_it_can_take() {
    for (steers_ms, stands) in [(5_500, false), (9_000, true)] {
        let (mut bench, motion) = Bench::moving();
        let began = bench.time;
        for time in (began..=began + steers_ms).step_by(100) {
            bench.says_at(time);
            bench.report(time, motion.id, 0, Progress::Steering);
            bench.at(time, Event::Tick);
        }
        assert_eq!(bench.is_stopped(StopReason::Overdue), stands);
    }
}

impl Bench {
    fn says_at(&mut self, time: u32) {
        self.time = time;
        self.says(Some(1_500), 0);
    }
}

#[test]
fn a_motion_that_is_made_slower_may_take_as_much_longer() {
    let (mut bench, motion) = Bench::moving();
    let began = bench.time;
    // Something stands 0.5 m ahead of the way's end: it goes on slowly.
    let ahead = motion.displacement.with_length(1_000);
    let sensor = (0..16).max_by_key(|&sensor: &usize| {
        let axis = bench.config.robot.directions[sensor];
        axis.along(i32::from(ahead.dx_mm), i32::from(ahead.dy_mm))
    });
    let sensor = sensor.unwrap_or(0) as u8;
    let range = Some(Range::from_mm(240));
    let slow = bench.at(began + 40, Event::Echo { sensor, range });
    let slow = slow.motion.expect("shortened");
    assert!(slow.id == motion.id && slow.speed_mm_s < motion.speed_mm_s);
    // What is left takes longer now.
    let twice_mm = 2_000 * u32::from(slow.displacement.length_mm());
    let slower_ms = twice_mm / u32::from(slow.speed_mm_s) - twice_mm / 508;
    let longest_ms = 2_000 * 247 / 508 + 1_000 + slower_ms;
    assert!(slower_ms > 100);
    for time in (began + 41..=began + longest_ms).step_by(100) {
        bench.says_at(time);
    }
    assert!(!bench.at(began + longest_ms, Event::Tick).mode_changed);
    assert!(bench.at(began + 1 + longest_ms, Event::Tick).mode_changed);
    assert!(bench.is_stopped(StopReason::Overdue));
}

#[test]
fn echoes_older_than_two_periods_do_not_complete_a_ring() {
    let mut bench = Bench::new(Config::recommended());
    bench.send(Event::Command(Command::Explore { moves: 5, seed: 3 }));
    bench.waits(70_000);
    for age_ms in [1_281, 5_000, 20_000, 65_535] {
        let outputs = bench.says(Some(1_500), age_ms);
        assert!(outputs.iter().all(|out| out.stale_ms == Some(age_ms)));
        assert!(outputs.iter().all(|out| out.motion.is_none()));
    }
    let outputs = bench.says(Some(1_500), 1_280);
    assert!(outputs.iter().all(|out| out.stale_ms.is_none()));
    assert!(outputs[15].motion.is_some());
}

impl Bench {
    /// Stands until then, as if the ring had been awaited from there on.
    fn waits(&mut self, time: u32) {
        self.time = time;
        self.state
            .pass_time(&self.config, Millis::from_ms(time), false);
    }
}

#[test]
fn echoes_from_before_the_motions_end_do_not_complete_a_ring() {
    let (mut bench, motion) = Bench::moving();
    bench.time += 400;
    bench.execute(motion);
    bench.waits(bench.time + 300);
    let outputs = bench.says(Some(1_500), 301);
    assert!(outputs.iter().all(|out| out.stale_ms == Some(301)));
    assert!(outputs.iter().all(|out| out.motion.is_none()));
    assert!(bench.says(Some(1_500), 300)[15].motion.is_some());
}

/// The robot was elsewhere when they were heard, or something newer is known: the shield does not
/// learn of them either.
#[test]
fn echoes_that_are_not_used_do_not_reach_the_shield() {
    let (mut bench, motion) = Bench::moving();
    bench.time += 400;
    bench.execute(motion);
    bench.waits(bench.time + 300);
    let before = bench.state.shield.clone();
    bench.says(Some(300), 301);
    assert!(bench.state.shield == before);
    // One transducer says what it heard now, then what it heard 200 ms before.
    bench.time += 300;
    let (now, sensor) = (bench.time, 3);
    let mut hear = |at, mm| {
        let range = Some(Range::from_mm(mm));
        bench.at(at, Event::Echo { sensor, range }).stale_ms
    };
    assert_eq!(hear(now, 1_200), None);
    assert_eq!(hear(now - 200, 900), Some(200));
    assert_eq!(hear(now, 1_100), None);
    let known = bench.state.scan().echoes()[3].range;
    assert_eq!(known, Some(Range::from_mm(1_100)));
}

/// Something comes nearer and nearer while the wheels are blocked.
#[test]
fn what_comes_nearer_does_not_put_the_deadline_off_for_ever() {
    let (mut bench, motion) = Bench::moving();
    let began = bench.time;
    let ahead = (0..16).max_by_key(|&sensor: &usize| {
        let axis = bench.config.robot.directions[sensor];
        axis.along(
            motion.displacement.dx_mm.into(),
            motion.displacement.dy_mm.into(),
        )
    });
    let sensor = ahead.unwrap_or(0) as u8;
    let mut shortened = 0;
    let stopped = (1..60_000).find(|ms| {
        let time = began + ms;
        if ms % 40 == 0 {
            bench.says_at(time);
            let mm = 400_u32.saturating_sub(ms / 20).max(160) as u16;
            let range = Some(Range::from_mm(mm));
            let out = bench.at(time, Event::Echo { sensor, range });
            shortened += u32::from(out.motion.is_some());
            bench.report(time, motion.id, 0, Progress::Moving);
        }
        bench.at(time, Event::Tick).mode_changed
    });
    assert!(shortened > 3, "{shortened}");
    assert!(bench.is_stopped(StopReason::Overdue));
    assert!(stopped < Some(4_000), "{stopped:?}");
}

/// The transducers that are believed are dead; one that is not hears something.
#[test]
fn what_a_transducer_hears_that_is_not_believed_is_no_echo() {
    let mut bench = Bench::new(Config {
        enabled: Mask::ALL.without(4),
        ..Config::recommended()
    });
    bench.send(Event::Command(Command::Explore { moves: 9, seed: 3 }));
    for _ in 0..8 {
        bench.time += 640;
        let sensor = 4;
        let range = Some(Range::from_mm(5_000));
        bench.send(Event::Echo { sensor, range });
        if let Some(motion) = bench.says(None, 0)[15].motion {
            bench.time += 500;
            bench.report(bench.time, motion.id, 0, Progress::Ended);
        }
    }
    assert!(bench.is_stopped(StopReason::NoEchoes));
}

#[test]
fn three_rings_without_any_echo_stop_the_robot() {
    let silent = |open_space: bool| {
        let mut bench = Bench::new(Config::recommended());
        bench.state.expect_open_space(open_space);
        bench.send(Event::Command(Command::Explore { moves: 9, seed: 3 }));
        let mut moves = 0;
        for _ in 0..8 {
            bench.time += 640;
            let outputs = bench.says(None, 0);
            if let Some(motion) = outputs[15].motion {
                moves += u32::from(motion.displacement != Displacement::ZERO);
                bench.time += 500;
                bench.report(bench.time, motion.id, 0, Progress::Ended);
            }
        }
        (moves, bench)
    };
    let (moves, mut bench) = silent(false);
    assert!(moves == 2 && bench.is_stopped(StopReason::NoEchoes));
    // One echo of one transducer is enough to go on, and then it is counted anew.
    bench.send(Event::Command(Command::Resume));
    for _ in 0..5 {
        bench.time += 640;
        let sensor = 4;
        let range = Some(Range::from_mm(5_000));
        bench.send(Event::Echo { sensor, range });
        let motion = bench.says(None, 0)[15].motion.expect("a motion");
        bench.time += 500;
        bench.report(bench.time, motion.id, 0, Progress::Ended);
    }
    let (moves, bench) = silent(true);
    assert!(moves == 8 && !bench.is_stopped(StopReason::NoEchoes));
}

/// What was heard before the order to go on is no echo of the rings after it.
#[test]
fn an_echo_while_the_robot_stands_breaks_no_silence() {
    let mut bench = Bench::new(Config::recommended());
    let range = Some(Range::from_mm(5_000));
    bench.send(Event::Echo { sensor: 4, range });
    bench.send(Event::Command(Command::Explore { moves: 9, seed: 3 }));
    for ring in 1..=3 {
        bench.time += 640;
        let outputs = bench.says(None, 0);
        assert_eq!(outputs[15].stopped.is_some(), ring == 3, "ring {ring}");
        if let Some(motion) = outputs[15].motion {
            bench.time += 500;
            bench.report(bench.time, motion.id, 0, Progress::Ended);
        }
    }
    assert!(bench.is_stopped(StopReason::NoEchoes));
}

#[test]
fn a_touch_ends_the_motion_and_the_next_ring_decides() {
    let (mut bench, motion) = Bench::moving();
    bench.report(bench.time + 200, motion.id, 40, Progress::Moving);
    let out = bench.at(bench.time + 10, Event::Touched);
    let stop = out.motion.expect("a stop");
    assert!(stop.displacement == Displacement::ZERO && stop.id == motion.id + 1);
    assert!(!bench.state.is_moving() && !out.mode_changed);
    // A report of the old motion changes nothing, and a robot that stands cannot be touched.
    bench.report(bench.time + 50, motion.id, 5, Progress::Ended);
    assert_eq!(bench.send(Event::Touched), Out::NONE);
    assert!(bench.ring().motion.is_some());
    assert_eq!(bench.state.memory().samples().len(), 1);
    assert_eq!(bench.state.memory().samples()[0].executed.dx_mm, 45);
}

#[test]
fn a_clock_that_is_set_back_lets_the_ring_begin_anew() {
    let mut bench = Bench::new(Config::recommended());
    bench.time = 3_600_000;
    bench.send(Event::Command(Command::Explore { moves: 5, seed: 3 }));
    assert!(!bench.at(100, Event::Tick).mode_changed);
    assert!(bench.says(Some(1_500), 0)[15].motion.is_some());
    // A little back is nothing.
    let began = bench.time;
    assert!(!bench.at(began - 100, Event::Tick).mode_changed);
    assert!(bench.at(began + 5_000, Event::Tick).mode_changed);
    assert!(bench.is_stopped(StopReason::Overdue));
}

/// The detector is part of the robot: through the documented function alone a dead transducer is
/// disabled.
#[test]
fn the_controller_disables_a_dead_transducer_and_says_so() {
    let mut bench = Bench::new(Config::recommended());
    assert!(bench.config.fault_detection);
    bench.send(Event::Command(Command::Explore { moves: 5, seed: 3 }));
    bench.time += 640;
    let mut verdicts = Vec::new();
    for _ in 0..2 {
        for sensor in 0..16 {
            let range = Some(Range::from_mm(900)).filter(|_| sensor != 6);
            verdicts.extend(bench.send(Event::Echo { sensor, range }).verdict);
        }
        // It looks at another place.
        bench.report(bench.time, 0, 300, Progress::Moving);
    }
    let disabled = crate::faults::SensorVerdict {
        sensor: 6,
        fault: Some(crate::faults::SensorFault::Unheard),
    };
    assert!(verdicts.contains(&disabled), "{verdicts:?}");
    assert_eq!(bench.state.enabled(&bench.config), Mask::ALL.without(6));
    assert_eq!(bench.config.enabled, Mask::ALL);
    bench.state.trust(Mask::ALL);
    assert_eq!(bench.state.enabled(&bench.config), Mask::ALL);
}

/// Each report is of a turn too small to turn a short way of whole millimeters.
#[test]
fn a_way_that_is_shortened_while_the_ring_turns_keeps_its_bearing() {
    let mut config = Config::recommended();
    config.exploration.shortest_mm = 100;
    let mut bench = Bench::new(config);
    bench.has_looked_around();
    bench.send(Event::Command(Command::Explore { moves: 9, seed: 7 }));
    let way = bench.ring().motion.expect("a motion").displacement;
    let mut turned = Bearing::ZERO;
    let shortened = (1..=400).find_map(|report| {
        let step = Bearing::from_turns(40);
        turned = turned.plus(step);
        let motion = bench.state.motion_id;
        bench.send(Event::Odometry {
            motion,
            moved: Displacement::ZERO,
            turned: step,
            progress: Progress::Steering,
        });
        let back = way.rotated(Bearing::ZERO.minus(turned).direction());
        let ahead = (0..16).max_by_key(|sensor| {
            let axis = bench.config.robot.directions[*sensor];
            axis.along(back.dx_mm.into(), back.dy_mm.into())
        });
        let range = (report > 200).then_some(Range::from_mm(180));
        let sensor = ahead.unwrap_or(0) as u8;
        let out = bench.send(Event::Echo { sensor, range });
        out.motion.map(|motion| (motion.displacement, back))
    });
    let (left, back) = shortened.expect("something near ahead");
    let (length, whole) = (left.length_mm(), back.length_mm());
    assert!(length > 20 && length < whole, "{left:?} of {back:?}");
    let same = back.with_length(length);
    let (dx, dy) = (
        left.dx_mm.abs_diff(same.dx_mm),
        left.dy_mm.abs_diff(same.dy_mm),
    );
    assert!(dx <= 2 && dy <= 2, "{left:?} of {back:?}");
}

/// A base that brakes rolls on. What is near behind it is no reason to turn its wheels and go back.
#[test]
fn a_way_that_was_overrun_is_not_gone_back() {
    let (mut bench, motion) = Bench::moving();
    let way = motion.displacement;
    bench.send(Event::Odometry {
        motion: motion.id,
        moved: way.with_length(way.length_mm() + 60),
        turned: Bearing::ZERO,
        progress: Progress::Moving,
    });
    let behind = (0..16).min_by_key(|&sensor: &usize| {
        let axis = bench.config.robot.directions[sensor];
        axis.along(way.dx_mm.into(), way.dy_mm.into())
    });
    let sensor = behind.unwrap_or(0) as u8;
    let range = Some(Range::from_mm(160));
    let out = bench.send(Event::Echo { sensor, range });
    let stand = out.motion.expect("an order to stand");
    assert_eq!(stand.displacement, Displacement::ZERO);
    assert_eq!(stand.id, motion.id);
}
