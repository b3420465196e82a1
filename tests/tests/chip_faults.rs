//! Reactions of a chip to failures around it: real firmware in an emulated chip, by its own clock.

use amp::controller::{Progress, StopReason};
use amp::wire::frame::Header;
use amp::wire::message::{
    Clock, DeviceMessage, HostHello, HostMessage, ModeReport, MotionCommand, Refusal, Report,
    ResetCause, RobotCommand, Source, TimedEcho, TransferPart,
};
use rand_core::{Rng as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::time::{Duration, Instant};
use tests::chip::{EmulatedChip, SESSION, dimensions, packed};

fn scan(at_ms: u32, sensors: usize, range_mm: u16) -> HostMessage<16> {
    let echoes = (0..sensors).map(|sensor| TimedEcho {
        sensor: sensor as u8,
        range_mm: Some(range_mm + 20 * sensor as u16),
        age_ms: 0,
    });
    HostMessage::Scan {
        at_ms,
        echoes: echoes.collect(),
    }
}

fn motion(said: &[Report<16>]) -> Option<MotionCommand> {
    said.iter().find_map(|report| match report.message {
        DeviceMessage::Motion(command) => Some(command),
        _ => None,
    })
}

/// Reports that a motion was executed.
fn carry_out(chip: &mut EmulatedChip, command: &MotionCommand) {
    chip.ask(&HostMessage::Odometry {
        at_ms: chip.at_ms(),
        motion: command.id,
        dx_mm: command.dx_mm,
        dy_mm: command.dy_mm,
        turned: 0,
        progress: Progress::Ended,
    });
}

/// A ring and, if a motion follows, the report that it was executed.
fn round(chip: &mut EmulatedChip, range_mm: u16) -> Option<MotionCommand> {
    let said = chip.ask(&scan(chip.at_ms(), 16, range_mm));
    let command = motion(&said)?;
    carry_out(chip, &command);
    Some(command)
}

/// Explores and learns a little, then seeks.
fn seeking(chip: &mut EmulatedChip) {
    chip.command(RobotCommand::Explore { moves: 10, seed: 3 });
    let mut rounds = 0;
    while round(chip, 700 + 50 * (rounds % 9)).is_some() {
        rounds += 1;
    }
    assert_eq!(rounds, 10);
    chip.command(RobotCommand::Learn);
    chip.wait(|_, report| (report.message == DeviceMessage::Mode(ModeReport::Idle)).then_some(()));
    let said = chip.command(RobotCommand::Seek);
    assert!(
        said.iter()
            .any(|report| report.message == DeviceMessage::Mode(ModeReport::Seek))
    );
}

/// Waits for a stop; returns its time by the chip's clock, and the last motion before it.
fn stopped(chip: &mut EmulatedChip, why: StopReason) -> (u32, Option<MotionCommand>) {
    let mut last = None;
    chip.wait(|_, report| {
        if let DeviceMessage::Motion(command) = report.message {
            last = Some(command);
        }
        let mode = DeviceMessage::Mode(ModeReport::Stopped(why));
        (report.message == mode).then_some((report.device_ms, last))
    })
}

#[test]
fn a_silent_host_stops_the_motion_in_time() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    let said = chip.ask(&scan(chip.at_ms(), 16, 900));
    let command = motion(&said).expect("a motion");
    assert_ne!((command.dx_mm, command.dy_mm), (0, 0));
    let heard_ms = said.last().expect("done").device_ms;
    let (stopped_ms, last) = stopped(&mut chip, StopReason::LinkLost);
    let silence_ms = stopped_ms - heard_ms;
    println!("stopped after {silence_ms} ms of silence");
    assert!((300..=400).contains(&silence_ms), "{silence_ms} ms");
    let last = last.expect("a motion that stops");
    assert_eq!((last.dx_mm, last.dy_mm), (0, 0));
    // The host returns in the same session and resumes.
    assert!(motion(&chip.ask(&scan(chip.at_ms(), 16, 900))).is_none());
    chip.command(RobotCommand::Resume);
    assert!(round(&mut chip, 900).is_some());
}

#[test]
fn a_host_that_starts_anew_finds_the_robot_standing() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    assert!(motion(&chip.ask(&scan(chip.at_ms(), 16, 900))).is_some());
    // The host vanishes and another one opens a session before the timeout.
    chip.open(SESSION + 1, Clock::Device);
    assert!(motion(&chip.ask(&scan(chip.at_ms(), 16, 900))).is_none());
    chip.command(RobotCommand::Seek);
    assert!(round(&mut chip, 900).is_some());
    // Frames of the old session have no effect.
    let header = Header {
        session: SESSION,
        seq: 30_000,
    };
    let at_ms = chip.at_ms();
    let command = RobotCommand::Explore { moves: 5, seed: 1 };
    chip.raw(&packed(
        header,
        &HostMessage::Command {
            at_ms,
            ttl_ms: 60_000,
            command,
        },
    ));
    assert_eq!(chip.counters().wrong_session, 1);
}

#[test]
fn a_ring_that_stays_incomplete_stops_a_robot_that_stands() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    stops_without_five_transducers(&mut chip);
}

#[test]
fn transducers_that_fall_silent_stop_a_robot_that_moves() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    let command = motion(&chip.ask(&scan(chip.at_ms(), 16, 900))).expect("a motion");
    // Long enough not to be overdue before.
    let way_mm = command
        .dx_mm
        .unsigned_abs()
        .max(command.dy_mm.unsigned_abs());
    assert!(way_mm > 170, "{way_mm} mm");
    stops_without_five_transducers(&mut chip);
}

/// Five transducers are silent; the host is fine.
fn stops_without_five_transducers(chip: &mut EmulatedChip) {
    let began_ms = chip
        .ask(&HostMessage::Counters)
        .last()
        .expect("done")
        .device_ms;
    let until = Instant::now() + Duration::from_secs(5);
    let stopped_ms = loop {
        assert!(Instant::now() < until, "it never stopped");
        let said = chip.ask(&scan(chip.at_ms(), 11, 900));
        let is_stopped = |report: &&Report<16>| {
            report.message == DeviceMessage::Mode(ModeReport::Stopped(StopReason::RingIncomplete))
        };
        if let Some(report) = said.iter().find(is_stopped) {
            break report.device_ms;
        }
        // The current motion is renewed and no other starts.
        assert!(motion(&said).is_none_or(|command| command.revision == 0));
        std::thread::sleep(Duration::from_millis(20));
    };
    let took_ms = stopped_ms - began_ms;
    println!("stopped after {took_ms} ms");
    assert!((1_180..=1_480).contains(&took_ms), "{took_ms} ms");
}

/// A command with a time one minute ahead once made every later one expire.
#[test]
fn no_stop_is_refused_after_a_command_from_the_future() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    let at_ms = chip.at_ms() + 60_000;
    chip.ask(&HostMessage::Command {
        at_ms,
        ttl_ms: 1_000,
        command: RobotCommand::Resume,
    });
    assert!(motion(&chip.ask(&scan(chip.at_ms(), 16, 900))).is_some());
    let stopped = DeviceMessage::Mode(ModeReport::Stopped(StopReason::Commanded));
    let is_stopped = |said: &[Report<16>]| said.iter().any(|report| report.message == stopped);
    let said = chip.command(RobotCommand::Stop);
    assert!(is_stopped(&said), "{said:?}");
    let command = motion(&said).expect("an order to stand");
    assert_eq!((command.dx_mm, command.dy_mm), (0, 0));
    // A stop works with any time and without a session.
    for (session, ahead_ms) in [(SESSION, 3_600_000_u32.wrapping_neg()), (0, 0)] {
        chip.command(RobotCommand::Resume);
        assert!(round(&mut chip, 900).is_some());
        let header = Header {
            session,
            seq: 30_000,
        };
        let at_ms = chip.at_ms().wrapping_add(ahead_ms);
        let stop = HostMessage::Command {
            at_ms,
            ttl_ms: 0,
            command: RobotCommand::Stop,
        };
        chip.raw(&packed(header, &stop));
        chip.wait(|_, report| (report.message == stopped).then_some(()));
        chip.wait(|_, report| {
            (report.message == DeviceMessage::Done { seq: 30_000 }).then_some(())
        });
        if session == SESSION {
            chip.open(SESSION, Clock::Device);
        }
    }
    assert_eq!(chip.counters().expired, 0);
}

#[test]
fn rings_from_long_ago_move_nothing() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    for (old_ms, age_ms) in [(0, 5_000), (0, 65_535), (60_000, 0)] {
        let echoes = (0..16).map(|sensor| TimedEcho {
            sensor,
            range_mm: Some(1_500),
            age_ms,
        });
        let at_ms = chip.at_ms().wrapping_sub(old_ms);
        let said = chip.ask(&HostMessage::Scan {
            at_ms,
            echoes: echoes.collect(),
        });
        assert!(motion(&said).is_none(), "{old_ms} {age_ms}");
    }
    assert_eq!(chip.counters().stale_echoes, 48);
}

/// The base reports that it moves, and does not; then the ring becomes silent.
#[test]
fn blocked_wheels_and_silence_stop_the_robot() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    let said = chip.ask(&scan(chip.at_ms(), 16, 900));
    let command = motion(&said).expect("a motion");
    let began_ms = said.last().expect("done").device_ms;
    let overdue = DeviceMessage::Mode(ModeReport::Stopped(StopReason::Overdue));
    let stopped_ms = loop {
        let mut said = chip.ask(&HostMessage::Odometry {
            at_ms: chip.at_ms(),
            motion: command.id,
            dx_mm: 0,
            dy_mm: 0,
            turned: 0,
            progress: Progress::Moving,
        });
        said.extend(chip.ask(&scan(chip.at_ms(), 16, 900)));
        if let Some(report) = said.iter().find(|report| report.message == overdue) {
            break report.device_ms;
        }
        let waited_ms = said.last().expect("done").device_ms - began_ms;
        assert!(waited_ms < 5_000, "it never stopped");
        std::thread::sleep(Duration::from_millis(50));
    };
    // At most 250 mm, at 508 mm/s or less near an obstacle.
    let took_ms = stopped_ms - began_ms;
    assert!((500..2_000).contains(&took_ms), "{took_ms} ms");
    chip.command(RobotCommand::Resume);
    let nothing = DeviceMessage::Mode(ModeReport::Stopped(StopReason::NoEchoes));
    let mut moves = 0;
    let stopped = (0..4).any(|_| {
        let echoes = (0..16).map(|sensor| TimedEcho {
            sensor,
            range_mm: None,
            age_ms: 0,
        });
        let said = chip.ask(&HostMessage::Scan {
            at_ms: chip.at_ms(),
            echoes: echoes.collect(),
        });
        if let Some(command) = motion(&said) {
            moves += 1;
            carry_out(&mut chip, &command);
        }
        said.iter().any(|report| report.message == nothing)
    });
    assert!(stopped && moves == 2, "{moves} moves");
}

/// Kinds of damage, and the counter that each increases.
#[derive(Default)]
struct FloodCounters {
    damaged: u32,
    unshaped: u32,
    oversized: u32,
    replayed: u32,
}

#[test]
fn ten_thousand_bad_frames_are_counted_and_do_nothing() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut below = |bound: usize| (generator.next_u64() % bound as u64) as usize;
    let good = chip.packed(&HostMessage::Read {
        part: TransferPart::Actions,
        offset: 0,
    });
    chip.raw(&good);
    chip.wait(|_, report| matches!(report.message, DeviceMessage::Done { .. }).then_some(()));
    let dangerous = |chip: &mut EmulatedChip| {
        let command = RobotCommand::Explore { moves: 5, seed: 1 };
        let at_ms = chip.at_ms();
        chip.packed(&HostMessage::Command {
            at_ms,
            ttl_ms: 60_000,
            command,
        })
    };
    let before = chip.counters();
    let mut expected = FloodCounters::default();
    for number in 0..10_000 {
        let bytes = match number % 5 {
            // Bits flipped in a frame with a command to move. The delimiter stays, and no new one
            // appears.
            0 => {
                let mut frame = dangerous(&mut chip);
                let middle = 1 + below(frame.len() - 2);
                frame[middle] = if frame[middle] == 1 {
                    2
                } else {
                    frame[middle] ^ 1
                };
                frame
            }
            // Truncated.
            1 => {
                let frame = dangerous(&mut chip);
                let kept = 1 + below(frame.len() - 3);
                [&frame[..kept], &[0]].concat()
            }
            // Longer than any frame.
            2 => {
                let length = 256 + below(100);
                expected.oversized += 1;
                [vec![7; length], vec![0]].concat()
            }
            // The first accepted frame again.
            3 => {
                expected.replayed += 1;
                good.clone()
            }
            // Noise.
            _ => {
                let length = 1 + below(60);
                let noise = (0..length).map(|_| 1 + below(255) as u8);
                noise.chain([0]).collect()
            }
        };
        if !matches!(number % 5, 2 | 3) {
            classify(&bytes, &mut expected);
        }
        chip.raw(&bytes);
        if number % 50 == 49 {
            // Paced by the emulated line, so that no count comes from a full queue.
            let at_ms = chip.at_ms();
            chip.ask(&HostMessage::Scan {
                at_ms,
                echoes: heapless::Vec::new(),
            });
        }
    }
    let after = chip.counters();
    assert_eq!(after.device.queue_losses, before.device.queue_losses);
    let counted = [
        after.crc_errors - before.crc_errors,
        after.malformed - before.malformed,
        after.oversized - before.oversized,
        after.replayed - before.replayed,
        after.unknown - before.unknown,
        after.wrong_session - before.wrong_session,
        after.accepted - before.accepted,
    ];
    let wanted = [
        expected.damaged,
        expected.unshaped,
        expected.oversized,
        expected.replayed,
        0,
        0,
        201,
    ];
    println!("damaged, malformed, oversized, replayed, unknown, strangers, accepted: {counted:?}");
    assert_eq!(counted, wanted);
    // The next valid frame works.
    seeking(&mut chip);
}

/// The decoder's result for these bytes; other tests check the decoder itself.
fn classify(bytes: &[u8], expected: &mut FloodCounters) {
    let (_, coded) = bytes.split_last().expect("a frame");
    match amp::wire::frame::unpack::<HostMessage<16>>(coded) {
        Ok(_) => panic!("a damaged frame was accepted: {coded:?}"),
        Err(amp::wire::FrameError::Crc) => expected.damaged += 1,
        Err(_) => expected.unshaped += 1,
    }
}

#[test]
fn a_flood_does_not_keep_time_from_passing() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    let before = chip.counters();
    let began = Instant::now();
    // More than the line transfers in three seconds, at once: requests for long answers, and
    // repeated frames.
    let replay = chip.packed(&HostMessage::Source(Source::Link));
    let mut flood = Vec::new();
    while flood.len() < 64_000 {
        flood.extend(chip.packed(&HostMessage::Counters));
        flood.extend_from_slice(&replay);
    }
    chip.raw(&flood);
    let after = chip.counters();
    let rate = flood.len() as f64 / began.elapsed().as_secs_f64();
    println!(
        "{rate:.0} bytes/s; longest time between two control ticks {} ms; {} bytes lost, {} frames dropped",
        after.device.longest_tick_ms,
        after.device.queue_losses - before.device.queue_losses,
        after.dropped - before.dropped
    );
    assert!(after.replayed > before.replayed + 100);
    // 10 ms by the chip's own work, some more where the computer pauses the emulator; a chip that
    // reads until the line is silent needs 295 ms.
    let longest = after.device.longest_tick_ms;
    assert!(longest <= 150, "{longest} ms");
    // The robot still obeys commands.
    chip.command(RobotCommand::Stop);
    chip.command(RobotCommand::Resume);
    assert!(round(&mut chip, 900).is_some());
}

#[test]
fn another_protocol_is_refused_by_the_chip() {
    let mut chip = EmulatedChip::start();
    let mut theirs = dimensions();
    theirs.protocol += 1;
    chip.send(&HostMessage::Hello(HostHello {
        dimensions: theirs,
        clock: Clock::Device,
        open_space: false,
    }));
    let why = chip.wait(|_, report| match report.message {
        DeviceMessage::Refusal { reason, .. } => Some(reason),
        _ => None,
    });
    assert_eq!(why, Refusal::Incompatible(dimensions()));
    // Nothing else is executed for it either.
    chip.send(&HostMessage::Counters);
    let why = chip.wait(|_, report| match report.message {
        DeviceMessage::Refusal { reason, .. } => Some(reason),
        _ => None,
    });
    assert_eq!(why, Refusal::NoSession);
}

#[test]
fn crashes_are_reported_after_the_reset_and_nothing_moves() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    assert!(motion(&chip.ask(&scan(chip.at_ms(), 16, 900))).is_some());
    for (word, cause) in [
        ("!overflow", ResetCause::StackOverflow),
        ("!guard", ResetCause::StackOverflow),
        ("!panic", ResetCause::Panic),
        ("!fault", ResetCause::HardFault),
    ] {
        chip.raw(format!("\0{word}\0").as_bytes());
        let hello = chip.wait(|header, report| match report.message {
            DeviceMessage::Hello(hello) if header.session == 0 => Some(hello),
            _ => None,
        });
        assert_eq!(hello.reset, cause, "{word}");
        // Rings cause no motion, before and after a new session.
        chip.send(&scan(chip.at_ms(), 16, 900));
        let hello = chip.open(SESSION + 1, Clock::Device);
        assert_eq!(hello.reset, cause);
        assert!(motion(&chip.ask(&scan(chip.at_ms(), 16, 900))).is_none());
        assert_eq!(
            chip.counters().link_losses,
            0,
            "the counters start anew: statics are intact"
        );
        seeking(&mut chip);
    }
}
