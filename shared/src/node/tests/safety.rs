//! Stops that nothing can hold up, and echoes that do not move the robot.

use super::*;

const HOUR_MS: u32 = 3_600_000;

impl Rig {
    fn stop_frame(session: u16, seq: u16, at_ms: u32, ttl_ms: u16) -> Vec<u8> {
        let header = Header { session, seq };
        let stop = HostMessage::<16>::Command {
            at_ms,
            ttl_ms,
            command: RobotCommand::Stop,
        };
        let frame = Frame::pack(header, &stop).unwrap();
        frame.as_bytes().split_last().unwrap().1.to_vec()
    }

    /// The stop is obeyed: the base is told to stand, and the mode says so.
    fn is_stopped_by(&mut self, stop: &[u8]) -> Vec<DeviceMessage<16>> {
        let said = self.raw(stop);
        assert!(is_stopped(&said, StopReason::Commanded), "{said:?}");
        let command = motion(&said).expect("an order to stand");
        assert_eq!((command.dx_mm, command.dy_mm), (0, 0));
        assert!(matches!(said.last(), Some(DeviceMessage::Done { .. })));
        said
    }

    fn signs_of_life(&mut self, ms: u32) {
        for _ in 0..ms / 100 {
            self.now += 100;
            let at_ms = self.at_ms();
            self.send(HostMessage::Alive { at_ms });
        }
    }
}

/// By the device's clock, whichever the session has.
#[test]
fn a_host_is_there_for_300_ms_after_each_frame() {
    for clock in [Clock::Device, Clock::Host] {
        let rig = Rig::new(clock);
        let has_heard = |later| rig.node.has_heard_host(Millis::from_ms(rig.now + later));
        assert!(has_heard(0) && has_heard(300), "{clock:?}");
        assert!(!has_heard(301) && !has_heard(HOUR_MS), "{clock:?}");
    }
}

#[test]
fn a_stop_acts_whatever_its_time() {
    for clock in [Clock::Device, Clock::Host] {
        for (before, ahead) in [
            (60_000, 60_000_u32),
            (0, HOUR_MS.wrapping_neg()),
            (0, HOUR_MS),
            (0, 1_000_u32.wrapping_neg()),
            (0, 1 << 31),
        ] {
            let mut rig = Rig::ready(clock);
            // One command from the future comes first.
            let at_ms = rig.at_ms() + before;
            rig.send(HostMessage::Alive { at_ms });
            rig.move_on();
            rig.seq = rig.seq.wrapping_add(1);
            let stop = Rig::stop_frame(SESSION, rig.seq, rig.at_ms().wrapping_add(ahead), 0);
            rig.is_stopped_by(&stop);
            assert_eq!(rig.node.counters().expired, 0);
        }
    }
}

#[test]
fn one_frame_from_the_future_lets_other_commands_through() {
    let mut rig = Rig::ready(Clock::Device);
    rig.signs_of_life(1_000);
    let at_ms = rig.at_ms() + 60_000;
    let resume = rig.packed(&HostMessage::Command {
        at_ms,
        ttl_ms: 1_000,
        command: RobotCommand::Learn,
    });
    rig.raw(&resume);
    for _ in 0..50 {
        rig.now += 100;
        assert_eq!(refusal(&rig.command(RobotCommand::Stop)), None);
        assert_eq!(
            refusal(&rig.command(RobotCommand::Goal(GoalSpec::Avoid))),
            None
        );
    }
}

#[test]
fn a_stop_acts_though_it_is_repeated_or_late_or_of_no_session() {
    let mut rig = Rig::ready(Clock::Device);
    rig.move_on();
    rig.seq = rig.seq.wrapping_add(1);
    let stop = Rig::stop_frame(SESSION, rig.seq, rig.at_ms(), 1_000);
    rig.is_stopped_by(&stop);
    // It comes again after the robot was told to go on.
    assert_eq!(refusal(&rig.command(RobotCommand::Resume)), None);
    rig.move_on();
    rig.is_stopped_by(&stop);
    // Again, as the very last frame.
    rig.move_on();
    rig.seq = rig.seq.wrapping_add(1);
    let last = Rig::stop_frame(SESSION, rig.seq, rig.at_ms(), 1_000);
    rig.is_stopped_by(&last);
    // The order to stand is said again: the first one may have been lost.
    rig.is_stopped_by(&last);
    // And by a new one, though the robot stands.
    rig.seq = rig.seq.wrapping_add(1);
    let new = Rig::stop_frame(SESSION, rig.seq, rig.at_ms(), 1_000);
    rig.is_stopped_by(&new);
    // Of another session, or of none.
    for session in [SESSION + 1, 0] {
        rig.move_on();
        let stop = Rig::stop_frame(session, 77, rig.at_ms(), 1_000);
        let said = rig.is_stopped_by(&stop);
        assert!(said.contains(&DeviceMessage::Done { seq: 77 }));
        // And once more, after an answer to the robot's own host.
        rig.send(HostMessage::Counters);
        rig.is_stopped_by(&stop);
    }
    // And of a host that has opened none.
    let mut fresh = Small::new();
    let mut said = Said::default();
    fresh.frame(Millis::from_ms(0), &stop, &mut said);
    assert!(is_stopped(&read(&said), StopReason::Commanded));
    assert_eq!(refusal(&read(&said)), None);
}

/// A day of a host whose clock runs fast or slow: every hour a command is obeyed, and a stop.
#[test]
#[cfg_attr(miri, ignore = "a day of signs of life: hours")]
fn a_clock_that_drifts_for_a_day_expires_nothing() {
    for ppm in [-200_i64, 200] {
        let mut rig = Rig::ready(Clock::Device);
        let first = rig.ahead;
        for second in 0..24_i64 * 3_600 {
            rig.now += 1_000;
            rig.ahead = first.wrapping_add((second * ppm / 1_000) as u32);
            let at_ms = rig.at_ms();
            rig.send(HostMessage::Alive { at_ms });
            if second % 3_600 == 0 {
                rig.move_on();
                assert_eq!(refusal(&rig.command(RobotCommand::Stop)), None);
            }
        }
        assert_eq!(rig.node.counters().expired, 0);
        let said = rig.send(HostMessage::Counters);
        let drift_ms = said.iter().find_map(|said| match said {
            DeviceMessage::Counters(counters) => Some(counters.clock_drift_ms),
            _ => None,
        });
        // 17.28 s a day, less the last 0.2 ms.
        let expected = -86_400 * ppm as i32 / 1_000;
        assert!((drift_ms.unwrap() - expected).abs() <= 30, "{drift_ms:?}");
    }
}

#[test]
fn a_clock_that_is_set_stops_no_stop_and_other_commands_for_a_minute_at_most() {
    for step_ms in [1_000, HOUR_MS] {
        for back in [false, true] {
            let mut rig = Rig::ready(Clock::Device);
            rig.signs_of_life(10_000);
            rig.ahead = if back {
                rig.ahead.wrapping_sub(step_ms)
            } else {
                rig.ahead.wrapping_add(step_ms)
            };
            rig.signs_of_life(200);
            rig.seq = rig.seq.wrapping_add(1);
            let stop = Rig::stop_frame(SESSION, rig.seq, rig.at_ms(), 100);
            assert!(is_stopped(&rig.raw(&stop), StopReason::Commanded));
            rig.signs_of_life(if back { 60_000 } else { 0 });
            let goal = RobotCommand::Goal(GoalSpec::Avoid);
            assert_eq!(refusal(&rig.command(goal)), None, "{step_ms} {back}");
        }
    }
}

#[test]
fn old_rings_are_counted_and_told_and_move_nothing() {
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Seek);
    // It stands for long, and hears nothing meanwhile but signs of life.
    rig.signs_of_life(1_200);
    let scan = |rig: &mut Rig, old_ms: u32, age_ms: u16| {
        let echoes = (0..16).map(|sensor| TimedEcho {
            sensor,
            range_mm: Some(1_500),
            age_ms,
        });
        let at_ms = rig.at_ms().wrapping_sub(old_ms);
        rig.send(HostMessage::Scan {
            at_ms,
            echoes: echoes.collect(),
        })
    };
    for (old_ms, age_ms) in [(0, 5_000), (0, 20_000), (0, 65_535), (60_000, 0)] {
        let said = scan(&mut rig, old_ms, age_ms);
        assert!(motion(&said).is_none(), "{old_ms} {age_ms}: {said:?}");
    }
    assert_eq!(rig.node.counters().stale_echoes, 64);
    // Told once, until a decision has been taken.
    let count = |said: &[DeviceMessage<16>]| {
        let told = |said: &&DeviceMessage<16>| {
            matches!(said, DeviceMessage::Log(LogEvent::StaleEcho { .. }))
        };
        said.iter().filter(told).count()
    };
    assert_eq!(count(&scan(&mut rig, 0, 5_000)), 0);
    assert!(motion(&scan(&mut rig, 0, 0)).is_some());
    assert_eq!(count(&scan(&mut rig, 0, 5_000)), 1);
}

/// A base that reports that it moves, but does not, and a ring that falls silent.
#[test]
fn a_motion_with_blocked_wheels_is_not_renewed_for_ever() {
    let mut rig = Rig::ready(Clock::Device);
    rig.command(RobotCommand::Seek);
    rig.now += 200;
    let command = motion(&rig.ring(900)).unwrap();
    let began = rig.now;
    let stopped = loop {
        rig.now += 10;
        assert!(rig.now - began < 12_000, "it never stops");
        if rig.now.is_multiple_of(100) {
            rig.ring(900);
        }
        let at_ms = rig.at_ms();
        rig.send(HostMessage::Odometry {
            at_ms,
            motion: command.id,
            dx_mm: 0,
            dy_mm: 0,
            turned: 0,
            progress: Progress::Moving,
        });
        let (_, said) = rig.tick();
        if is_stopped(&said, StopReason::Overdue) {
            break rig.now - began;
        }
    };
    // At most 250 mm, at 508 mm/s or somewhat less near an obstacle.
    assert!((1_000..2_300).contains(&stopped), "{stopped} ms");
}

#[test]
fn a_session_that_expects_open_space_goes_on_in_silence() {
    for open_space in [false, true] {
        let mut rig = Rig::new(Clock::Host);
        let dimensions = Small::dimensions();
        let hello = HostHello {
            dimensions,
            clock: Clock::Host,
            open_space,
        };
        rig.send(HostMessage::Hello(hello));
        rig.command(RobotCommand::Explore { moves: 9, seed: 3 });
        let mut moves = 0;
        for _ in 0..9 {
            rig.now += 300;
            let echoes = (0..16).map(|sensor| TimedEcho {
                sensor,
                range_mm: None,
                age_ms: 0,
            });
            let at_ms = rig.at_ms();
            let said = rig.send(HostMessage::Scan {
                at_ms,
                echoes: echoes.collect(),
            });
            let moving = |command: &MotionCommand| (command.dx_mm, command.dy_mm) != (0, 0);
            let Some(command) = motion(&said).filter(moving) else {
                assert!(is_stopped(&said, StopReason::NoEchoes));
                break;
            };
            moves += 1;
            rig.now += 200;
            rig.carried_out(command);
        }
        assert_eq!(moves, if open_space { 9 } else { 2 });
    }
}

#[test]
fn the_device_stops_the_robot_and_ends_a_motion() {
    let mut rig = Rig::ready(Clock::Device);
    for reason in [StopReason::EmergencyStop, StopReason::LowVoltage] {
        rig.move_on();
        let mut said = Said::default();
        rig.node.alarm(reason, Millis::from_ms(rig.now), &mut said);
        assert!(is_stopped(&read(&said), reason));
        // As long as it lasts, going on comes to nothing.
        rig.command(RobotCommand::Resume);
        let mut said = Said::default();
        rig.node.alarm(reason, Millis::from_ms(rig.now), &mut said);
        assert!(is_stopped(&read(&said), reason));
    }
    rig.move_on();
    let mut said = Said::default();
    rig.node.touched(Millis::from_ms(rig.now), &mut said);
    let command = motion(&read(&said)).expect("an order to stand");
    assert_eq!((command.dx_mm, command.dy_mm), (0, 0));
    rig.now += 200;
    assert!(motion(&rig.ring(900)).is_some());
}

/// Such values would put the deadlines off for ever; whether silence is free space is said by the
/// hello alone.
#[test]
fn a_configuration_that_nobody_could_supervise_is_refused() {
    let write = |change: &dyn Fn(&mut Config<16>)| {
        let mut rig = Rig::new(Clock::Device);
        let mut config = Config::recommended();
        change(&mut config);
        let mut buffer = [0; MAX_CONFIG];
        let bytes = config.to_bytes(&mut buffer);
        let pieces: Vec<_> = bytes.chunks(160).collect();
        let mut refused = None;
        for (number, piece) in pieces.iter().enumerate() {
            refused = refusal(&rig.send(HostMessage::Write {
                part: TransferPart::Config,
                offset: 160 * number as u16,
                bytes: heapless::Vec::from_slice(piece).unwrap(),
                last: number + 1 == pieces.len(),
            }));
        }
        (refused, rig.node.state().expects_open_space())
    };
    assert_eq!(write(&|config| config.open_space = true), (None, false));
    let robots: [&dyn Fn(&mut Config<16>); 5] = [
        &|config| config.robot.ring_period_ms = 0,
        &|config| config.robot.ring_period_ms = 10_001,
        &|config| config.robot.steer_ms = 10_001,
        &|config| config.robot.speed_mm_s = 9,
        &|config| config.robot.braking_mm_s2 = 0,
    ];
    for change in robots {
        assert_eq!(write(change).0, Some(Refusal::Config));
    }
}

/// PROTOCOL.md promises these to every host.
#[test]
fn the_times_of_the_protocol_are_what_they_are_said_to_be() {
    assert_eq!((MOTION_TTL_MS, RENEWAL_MS, SILENCE_MS), (500, 200, 300));
}
