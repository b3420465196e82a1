//! A state that survives a reset: saved by the chip into its flash and recalled at the start.
//!
//! The emulator's flash is two sectors of memory that a reset does not clear.

use amp::controller::{Decision, Progress};
use amp::goal::Name;
use amp::wire::message::{
    Clock, DeviceHello, DeviceMessage, FlashError, FlashOperation, GoalSpec, HostMessage,
    ModeReport, MotionCommand, Refusal, Report, ResetCause, RobotCommand, TimedEcho,
};
use std::time::{Duration, Instant};
use tests::chip::{EmulatedChip, SESSION, TIMEOUT};

fn find<T>(reports: &[Report<16>], pick: impl Fn(&DeviceMessage<16>) -> Option<T>) -> Option<T> {
    reports.iter().find_map(|report| pick(&report.message))
}

fn refusal(reports: &[Report<16>]) -> Option<Refusal> {
    find(reports, |message| match message {
        DeviceMessage::Refusal { reason, .. } => Some(*reason),
        _ => None,
    })
}

/// Sends a ring that differs by `number` and executes the motion that follows; by the host's clock,
/// so that equal rounds send equal bytes.
fn round(chip: &mut EmulatedChip, number: u32) -> Option<Decision<16>> {
    let at_ms = 1_000 + 200 * number;
    let echoes = (0..16_u8).map(|sensor| TimedEcho {
        sensor,
        range_mm: Some(
            500 + 100 * (number % 7) as u16 + 40 * u16::from((sensor + number as u8) % 16),
        ),
        age_ms: 0,
    });
    let reports = chip.ask(&HostMessage::Scan {
        at_ms,
        echoes: echoes.collect(),
    });
    let command: MotionCommand = find(&reports, |message| match message {
        DeviceMessage::Motion(command) => Some(*command),
        _ => None,
    })?;
    let _ = chip.ask(&HostMessage::Odometry {
        at_ms: at_ms + 100,
        motion: command.id,
        dx_mm: command.dx_mm,
        dy_mm: command.dy_mm,
        turned: 0,
        progress: Progress::Ended,
    });
    find(&reports, |message| match message {
        DeviceMessage::Decision(decision) => Some(*decision),
        _ => None,
    })
}

/// Seeks for some rounds in a new session, from the present state.
fn seek(chip: &mut EmulatedChip, session: u16, goal: GoalSpec<16>) -> Vec<Decision<16>> {
    chip.open(session, Clock::Host);
    for command in [RobotCommand::Goal(goal), RobotCommand::Seek] {
        let reports = chip.ask(&HostMessage::Command {
            at_ms: 1_000,
            ttl_ms: 60_000,
            command,
        });
        assert_eq!(refusal(&reports), None);
    }
    (1..=40).map_while(|number| round(chip, number)).collect()
}

fn sums(hello: &DeviceHello) -> [u32; 3] {
    [hello.config_crc, hello.maps_crc, hello.memory_crc]
}

/// Crashes the chip; returns the hello of its next start.
fn reset(chip: &mut EmulatedChip) -> DeviceHello {
    chip.raw(b"\0!panic\0");
    let hello = chip.wait(|header, report| match report.message {
        DeviceMessage::Hello(hello) if header.session == 0 => Some(hello),
        _ => None,
    });
    assert_eq!(hello.reset, ResetCause::Panic);
    hello
}

fn flash(chip: &mut EmulatedChip, what: FlashOperation) -> Vec<Report<16>> {
    let reports = chip.ask(&HostMessage::Flash(what));
    println!(
        "{what:?}: {:?}",
        reports
            .iter()
            .map(|report| &report.message)
            .collect::<Vec<_>>()
    );
    reports
}

#[test]
fn what_was_learned_is_known_after_a_reset_and_sought_with_at_once() {
    let mut chip = EmulatedChip::linked(Clock::Device);
    let fresh = chip.open(SESSION + 1, Clock::Device);
    assert_eq!(
        refusal(&flash(&mut chip, FlashOperation::Load)),
        Some(Refusal::Flash(FlashError::Empty))
    );
    learn(&mut chip);
    // Saves the present goal under a name.
    let nest = Name::new("nest").expect("a name");
    let at_ms = chip.at_ms();
    let command = RobotCommand::Goal(GoalSpec::Situation(std::array::from_fn(|i| 10 * i as u8)));
    let _ = chip.ask(&HostMessage::Command {
        at_ms,
        ttl_ms: 1_000,
        command,
    });
    let _ = chip.ask(&HostMessage::SaveGoal { name: nest });
    let known = chip.open(SESSION + 2, Clock::Device);
    assert_ne!(sums(&known), sums(&fresh));
    let reports = flash(&mut chip, FlashOperation::Save);
    assert!(
        matches!(reports[0].message, DeviceMessage::Busy { .. }) && refusal(&reports).is_none()
    );
    assert_eq!(refusal(&flash(&mut chip, FlashOperation::Load)), None);
    let before = seek(&mut chip, SESSION + 3, GoalSpec::Saved(nest));
    assert_eq!(before.len(), 40);
    // Learning has continued: without the flash the state would differ.
    let changed = chip.open(SESSION + 4, Clock::Device);
    assert_ne!(sums(&changed), sums(&known));
    assert_eq!(sums(&reset(&mut chip)), sums(&known));
    assert_eq!(seek(&mut chip, SESSION + 5, GoalSpec::Saved(nest)), before);
    // A second image goes into the other sector, and is the newer one.
    chip.command(RobotCommand::Stop);
    let second = chip.open(SESSION + 6, Clock::Device);
    assert_ne!(sums(&second), sums(&known));
    assert_eq!(refusal(&flash(&mut chip, FlashOperation::Save)), None);
    assert_eq!(sums(&reset(&mut chip)), sums(&second));
    // Now every start and save erases the older one's sector.
    for number in 7..9 {
        chip.open(SESSION + number, Clock::Device);
        let reports = flash(&mut chip, FlashOperation::Save);
        assert_eq!(refusal(&reports), None);
    }
    // Recalled at the start and saved since; checked once per second of a clock that a busy machine
    // slows down.
    let patience = Instant::now() + TIMEOUT;
    let mut peak = 0;
    while peak == 0 && Instant::now() < patience {
        std::thread::sleep(Duration::from_millis(200));
        peak = chip.counters().device.stack_peak_bytes;
    }
    println!("peak of the stack {peak} bytes");
    assert!((200..=4_096).contains(&peak), "{peak}");
    assert_eq!(sums(&reset(&mut chip)), sums(&second));
    chip.open(SESSION + 9, Clock::Device);
    assert_eq!(refusal(&flash(&mut chip, FlashOperation::Erase)), None);
    assert_eq!(sums(&reset(&mut chip)), sums(&fresh));
}

fn learn(chip: &mut EmulatedChip) {
    chip.open(SESSION + 20, Clock::Host);
    let explore = RobotCommand::Explore { moves: 20, seed: 3 };
    let command = |at_ms, command| HostMessage::Command {
        at_ms,
        ttl_ms: 60_000,
        command,
    };
    let _ = chip.ask(&command(1_000, explore));
    assert_eq!(
        (1..=100).map_while(|number| round(chip, number)).count(),
        20
    );
    let _ = chip.ask(&command(30_000, RobotCommand::Learn));
    chip.wait(|_, report| (report.message == DeviceMessage::Mode(ModeReport::Idle)).then_some(()));
    chip.open(SESSION + 21, Clock::Device);
}
