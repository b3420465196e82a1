//! The campaigns of frames, link and silence against the firmware in an emulated chip, in real
//! time.
//!
//! The counts are a thousandth of those against the code on the host.

use super::bench::{carried_out, command_message, motion, scan};
use super::channel::{FaultRates, LossyChannel};
use super::frames::{Example, examples};
use super::link::{Bookkeeper, LinkBase};
use super::mutate::FrameDamage;
use super::{CampaignVerdict, ProgressCallback, below, generator, grouped};
use crate::chip::{EmulatedChip, SESSION, packed};
use amp::controller::{Progress as Way, StopReason};
use amp::units::Millis;
use amp::wire::frame::{FrameError, Header, unpack};
use amp::wire::message::{
    Clock, Counters, DeviceMessage, HostMessage, ModeReport, MotionCommand, Refusal, Report,
    RobotCommand,
};
use amp::wire::{Frame, Receiver};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::{HashMap, VecDeque};
use std::time::Duration;

/// Bytes sent ahead of the chip.
const AHEAD: usize = 1_000;
/// Time between two frames over the bad line, ms.
const EVERY_MS: u64 = 20;
/// The bad line to the chip, with a stall of up to 2 s every few seconds. The emulator adds its own
/// delays.
const TO_CHIP: FaultRates = FaultRates {
    lost: 30,
    twice: 10,
    delay_ms: [0, 60],
    stalls: 12,
    stall_ms: 2_000,
};
/// The line to the base stalls more often: the chip does not time out on it.
const TO_BASE: FaultRates = FaultRates {
    stalls: 25,
    ..TO_CHIP
};
/// Bytes per millisecond on the line to the chip, as at 115 200 baud: frames after a stall do not
/// arrive at once.
const BYTES_PER_MS: u64 = 11;
/// Number of reports whose minimum delay gives the offset of the chip's clock.
const REPORTS: usize = 8;
/// Greatest true age of an executed motion, ms: time to live of 500 ms, minimum delay, and the
/// delays of a busy emulator.
const OLDEST_MS: u64 = 700;
/// Time to live of a command, ms; a command with a greater true age on arrival must not be
/// executed.
const COMMAND_TTL_MS: u16 = 300;
const OLDEST_ORDER_MS: u64 = 500;
/// A run of this many frames has enough stalls to test all of this.
const ENOUGH: u64 = 1_000;
/// Timeout of the host (PROTOCOL.md), and the tolerance for a cycle of the control task and a busy
/// emulator, ms.
const SILENT_MS: [u32; 2] = [300, 400];
/// Latest failure of the host after the start of a motion, ms. No echoes arrive meanwhile: two ring
/// periods after the last ring the chip stops for that reason.
const LONGEST_MOVE_MS: usize = 700;

/// Expected counters of the chip: what this machine's decoder does with the damaged frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct ExpectedCounters {
    malformed: u32,
    crc_errors: u32,
    unknown: u32,
    oversized: u32,
    sound: u32,
}

/// Sends `count` damaged frames to the chip and compares its counters with the decoder on this
/// machine.
///
/// # Panics
/// When there is no emulator, or the chip stops answering.
#[must_use]
pub fn frames(seed: u64, count: u64, progress: ProgressCallback<'_>) -> CampaignVerdict {
    let examples: Vec<_> = examples().into_iter().filter(|one| one.to_device).collect();
    let mut random = generator(seed, 0);
    let mut chip = EmulatedChip::linked(Clock::Device);
    let before = chip.counters();
    let (mut expected, mut asked, mut ahead) = (ExpectedCounters::default(), 1, 0);
    for _ in 0..count {
        let damage = FrameDamage::ALL[below(&mut random, FrameDamage::ALL.len())];
        let [one, other] = [(); 2].map(|()| &examples[below(&mut random, examples.len())]);
        let mut frame = one.bytes.clone();
        damage.inflict(&mut frame, &other.bytes, &mut random);
        frame.push(0);
        expect(&frame, &examples, &mut expected);
        chip.raw(&frame);
        ahead += frame.len();
        if ahead > AHEAD {
            ahead = 0;
            asked += 1;
            chip.ask(&HostMessage::Mode);
        }
        progress(1);
    }
    judge(&expected, count, asked, &before, &chip.counters())
}

/// Expectation for a valid frame of another session: unknown session or, for a hello, refused.
fn expect(frame: &[u8], examples: &[Example], expected: &mut ExpectedCounters) {
    let mut receiver = Receiver::new();
    for &byte in frame {
        let Some(piece) = receiver.push(byte) else {
            continue;
        };
        match unpack::<HostMessage<16>>(piece) {
            Err(FrameError::Shape | FrameError::TooLong) => expected.malformed += 1,
            Err(FrameError::Crc) => expected.crc_errors += 1,
            Err(FrameError::Content { .. }) => expected.unknown += 1,
            Ok(_) => {
                assert!(examples.iter().any(|example| example.bytes == piece));
                expected.sound += 1;
            }
        }
    }
    expected.oversized += receiver.oversized();
}

fn judge(
    expected: &ExpectedCounters,
    count: u64,
    asked: u32,
    before: &Counters,
    after: &Counters,
) -> CampaignVerdict {
    let mut verdict = CampaignVerdict::default();
    verdict.say(format_args!(
        "{} damaged frames to the chip\n",
        grouped(count)
    ));
    let sound = |counters: &Counters| counters.wrong_session + counters.refused;
    let pairs = [
        (
            "no COBS",
            expected.malformed,
            after.malformed - before.malformed,
        ),
        (
            "wrong CRC",
            expected.crc_errors,
            after.crc_errors - before.crc_errors,
        ),
        (
            "no message",
            expected.unknown,
            after.unknown - before.unknown,
        ),
        (
            "too long",
            expected.oversized,
            after.oversized - before.oversized,
        ),
        (
            "valid, of another session",
            expected.sound,
            sound(after) - sound(before),
        ),
        (
            "accepted: our own requests",
            asked,
            after.accepted - before.accepted,
        ),
        (
            "bytes lost",
            0,
            after.device.queue_losses - before.device.queue_losses,
        ),
    ];
    let rows = pairs.map(|(what, here, there)| {
        verdict.require(here == there, format!("{what}: {there} instead of {here}"));
        [what.to_owned(), grouped(here.into()), grouped(there.into())]
    });
    verdict.table(["what", "should be", "the chip's count"], &rows);
    verdict
}

/// Explores and learns a little, then seeks.
fn seeking(chip: &mut EmulatedChip) {
    chip.command(RobotCommand::Explore { moves: 10, seed: 3 });
    for round in 0..10 {
        let command = ring(chip, 700 + 50 * round).expect("a random move");
        let done = carried_out(chip.at_ms(), command);
        chip.ask(&done);
    }
    ring(chip, 900);
    chip.command(RobotCommand::Learn);
    chip.wait(|_, report| (report.message == DeviceMessage::Mode(ModeReport::Idle)).then_some(()));
    chip.command(RobotCommand::Seek);
}

fn ring(chip: &mut EmulatedChip, range_mm: u16) -> Option<MotionCommand> {
    let scan = scan(chip.at_ms(), range_mm);
    motion(&chip.ask(&scan))
}

/// Sends `count` frames over a line that is bad in both directions.
///
/// # Panics
/// When there is no emulator, or the chip stops answering.
#[must_use]
pub fn link(seed: u64, count: u64, progress: ProgressCallback<'_>) -> CampaignVerdict {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    let before = chip.counters();
    let first = chip.send(&HostMessage::Mode).wrapping_add(1);
    let is_done = |report: &Report<16>| matches!(report.message, DeviceMessage::Done { .. });
    let device_ms = chip.wait(|_, report| is_done(&report).then_some(report.device_ms));
    let mut line = BadLine::new(&mut chip, first, device_ms, seed);
    while line.there.sent() < count || !line.there.is_empty() || !line.back.is_empty() {
        line.advance_1_ms();
        if line.there.sent() < count && line.now_ms >= EVERY_MS * line.there.sent() {
            line.send();
            progress(1);
        }
        line.deliver();
        line.hear();
    }
    // Its last answers.
    while let Some((_, report)) = line.chip.next(Duration::from_millis(300)) {
        line.note(&report);
    }
    let after = line.chip.counters_as(first.wrapping_add(count as u16));
    line.judge(count, &before, &after)
}

/// Lag of the chip's clock behind this machine's. A busy emulator loses a tenth of its ticks and
/// more, but the protocol needs equal rates: host and base use the chip's time.
#[derive(Default)]
struct Behind {
    latest_ms: u32,
    some_ms: VecDeque<u32>,
}

impl Behind {
    fn hear(&mut self, here_ms: u32, device_ms: u32) {
        self.latest_ms = here_ms.wrapping_sub(device_ms);
        self.some_ms.push_back(self.latest_ms);
        if self.some_ms.len() > REPORTS {
            self.some_ms.pop_front();
        }
    }

    /// Without the delay of the reports.
    fn ms(&self) -> u32 {
        self.some_ms.iter().copied().min().unwrap_or(0)
    }
}

/// A command in transit through the chip.
#[derive(Debug, Clone, Copy)]
struct Given {
    age_ms: u64,
    behind_ms: u32,
    is_refused: bool,
}

/// The host and base behind a bad line to the chip.
struct BadLine<'a> {
    chip: &'a mut EmulatedChip,
    /// Sequence number of the first frame.
    first: u16,
    behind: Behind,
    /// Time of the chip and of the host at the start; the latest time since then.
    began_ms: [u32; 2],
    now_ms: u64,
    there: LossyChannel,
    back: LossyChannel,
    random: Xoshiro256PlusPlus,
    base: LinkBase,
    book: Bookkeeper,
    /// Time at which the line to the chip is free again.
    free_ms: u64,
    /// The latest frame that reached the chip; number of frames in order and out of order.
    latest: Option<u64>,
    accepted: u32,
    replayed: u32,
    /// Commands without a final report, by sequence number.
    given: HashMap<u16, Given>,
    /// Commands that were too old on arrival, and those of them that were executed.
    late: u64,
    obeyed: u64,
}

impl<'a> BadLine<'a> {
    /// `device_ms` is the chip's reported time.
    fn new(chip: &'a mut EmulatedChip, first: u16, device_ms: u32, seed: u64) -> Self {
        let mut behind = Behind::default();
        let here_ms = chip.at_ms();
        behind.hear(here_ms, device_ms);
        Self {
            chip,
            first,
            behind,
            began_ms: [device_ms, here_ms],
            now_ms: 0,
            there: LossyChannel::new(TO_CHIP, seed, 0),
            back: LossyChannel::new(TO_BASE, seed, 1),
            random: generator(seed, 2),
            base: LinkBase::new(OLDEST_MS),
            book: Bookkeeper::default(),
            free_ms: 0,
            latest: None,
            accepted: 0,
            replayed: 0,
            given: HashMap::new(),
            late: 0,
            obeyed: 0,
        }
    }

    /// The host's time, at the rate of the chip's.
    fn at_ms(&self) -> u32 {
        self.began_ms[1].wrapping_add(self.now_ms as u32)
    }

    /// Advances the time and the base.
    fn advance_1_ms(&mut self) {
        let device_ms = self.chip.at_ms().wrapping_sub(self.behind.ms());
        let since_ms = device_ms.wrapping_sub(self.began_ms[0]).cast_signed();
        // Monotonic.
        let now_ms = u64::try_from(since_ms).unwrap_or(0).max(self.now_ms);
        for ms in self.now_ms..now_ms {
            self.base.advance_1_ms(ms);
        }
        self.now_ms = now_ms;
    }

    /// Sends rings, reports and commands in random order.
    fn send(&mut self) {
        let at_ms = self.at_ms();
        let random = &mut self.random;
        let message = match below(random, 20) {
            0..9 => scan(at_ms, 1_500 + below(random, 500) as u16),
            9..16 => self.base.report(at_ms),
            16 => HostMessage::Alive { at_ms },
            17 => command_message(at_ms, COMMAND_TTL_MS, RobotCommand::Seek),
            _ => command_message(at_ms, COMMAND_TTL_MS, RobotCommand::Resume),
        };
        let header = Header {
            session: SESSION,
            seq: self.first.wrapping_add(self.there.sent() as u16),
        };
        self.there.send(self.now_ms, &packed(header, &message));
    }

    /// Writes arrived frames to the chip.
    fn deliver(&mut self) {
        while self.now_ms >= self.free_ms
            && let Some(come) = self.there.next_arrival(self.now_ms)
        {
            self.free_ms = self.now_ms + come.bytes.len() as u64 / BYTES_PER_MS;
            self.chip.raw(&come.bytes);
            if self.latest.is_some_and(|latest| come.number <= latest) {
                self.replayed += 1;
                continue;
            }
            self.latest = Some(come.number);
            self.accepted += 1;
            let coded = come.bytes.split_last().map_or(&[][..], |(_, coded)| coded);
            if let Ok((header, HostMessage::Command { .. })) = unpack::<HostMessage<16>>(coded) {
                let command = Given {
                    age_ms: self.now_ms - come.sent_ms,
                    behind_ms: self.behind.ms(),
                    is_refused: false,
                };
                self.given.insert(header.seq, command);
            }
        }
    }

    /// Sends the chip's frames to the base.
    fn hear(&mut self) {
        while let Some((header, report)) = self.chip.next(Duration::from_millis(2)) {
            self.note(&report);
            self.advance_1_ms();
            let frame = Frame::pack(header, &report).expect("it came in a frame");
            self.base.is_on_its_way(frame.as_bytes());
            self.back.send(self.now_ms, frame.as_bytes());
        }
        while let Some(come) = self.back.next_arrival(self.now_ms) {
            let here = Millis::from_ms(self.at_ms());
            self.base.hear(&come, self.now_ms, here, &mut self.book);
        }
    }

    /// Looks for the result of a command.
    fn note(&mut self, report: &Report<16>) {
        self.behind.hear(self.chip.at_ms(), report.device_ms);
        match report.message {
            DeviceMessage::Refusal {
                seq,
                reason: Refusal::Expired { .. },
            } => {
                if let Some(command) = self.given.get_mut(&seq) {
                    command.is_refused = true;
                }
            }
            DeviceMessage::Done { seq } => {
                let Some(command) = self.given.remove(&seq) else {
                    return;
                };
                // The chip cannot count ticks that its clock has lost meanwhile.
                let lost_ms = self.behind.latest_ms.saturating_sub(command.behind_ms);
                if command.age_ms.saturating_sub(lost_ms.into()) > OLDEST_ORDER_MS {
                    self.late += 1;
                    self.obeyed += u64::from(!command.is_refused);
                }
            }
            _ => {}
        }
    }

    fn judge(&self, count: u64, before: &Counters, after: &Counters) -> CampaignVerdict {
        let mut verdict = CampaignVerdict::default();
        verdict.say(format_args!(
            "{} frames to the chip, {} from it\n",
            grouped(count),
            grouped(self.back.sent())
        ));
        // The request for the counters is accepted as well, and so was the frame before the first.
        let pairs = [
            (
                "accepted",
                self.accepted + 2,
                after.accepted - before.accepted,
            ),
            (
                "duplicate or late",
                self.replayed,
                after.replayed - before.replayed,
            ),
            (
                "bytes lost",
                0,
                after.device.queue_losses - before.device.queue_losses,
            ),
        ];
        let mut rows = Vec::from(pairs.map(|(what, here, there)| {
            verdict.require(here == there, format!("{what}: {there} instead of {here}"));
            [what.to_owned(), grouped(here.into()), grouped(there.into())]
        }));
        let expired = u64::from(after.expired - before.expired);
        let mut row = |what: &str, wanted: &str, number: u64| {
            rows.push([what.to_owned(), wanted.to_owned(), grouped(number)]);
        };
        row("commands refused by the chip for their age", "", expired);
        row("commands surely too old", "", self.late);
        row("such commands not refused", "0", self.obeyed);
        row("motions executed", "", self.book.executed);
        row(
            "motions refused by the base for their age",
            "",
            self.book.aged,
        );
        row(
            "age of the oldest executed motion, ms",
            "",
            self.book.oldest_ms,
        );
        row("stale motions executed", "0", self.book.stale);
        verdict.table(["what", "should be", "counted"], &rows);
        verdict.require(self.book.stale == 0, "a stale motion was executed");
        verdict.require(self.obeyed == 0, "the chip executed an old command");
        let tried = [self.book.executed, self.book.aged, self.late];
        let is_enough = count < ENOUGH || !tried.contains(&0);
        verdict.require(is_enough, "not everything was tested");
        verdict
    }
}

/// The host goes silent `count` times during a motion; measures the chip's time from the last frame
/// to its stop.
///
/// # Panics
/// When there is no emulator, or the chip does not stop, or for another reason.
#[must_use]
pub fn silence(seed: u64, count: u64, progress: ProgressCallback<'_>) -> CampaignVerdict {
    let mut chip = EmulatedChip::linked(Clock::Device);
    seeking(&mut chip);
    let mut random = generator(seed, 0);
    let mut times: Vec<_> = (0..count)
        .map(|_| {
            let moving_ms = below(&mut random, LONGEST_MOVE_MS) as u32;
            let took_ms = stopped_after(&mut chip, moving_ms);
            progress(1);
            chip.command(RobotCommand::Resume);
            took_ms
        })
        .collect();
    times.sort_unstable();
    let at = |share: usize| times.get((times.len().max(1) - 1) * share / 100).copied();
    let mut verdict = CampaignVerdict::default();
    let row = [50, 99, 100].map(|share| at(share).unwrap_or(0).to_string());
    verdict.say(format_args!(
        "{} moments; from the last frame heard to the stop, ms by the chip's clock\n",
        grouped(count)
    ));
    verdict.table(["p50", "p99", "most"], &[row]);
    let most = times.last().copied().unwrap_or(0);
    verdict.require(most <= SILENT_MS[1], format!("{most} ms"));
    let least = times.first().copied().unwrap_or(0);
    verdict.require(least >= SILENT_MS[0], format!("after {least} ms already"));
    verdict
}

fn stopped_after(chip: &mut EmulatedChip, moving_ms: u32) -> u32 {
    let mut command = None;
    for range_mm in [900, 1_000, 1_100, 1_200] {
        command = command.or_else(|| ring(chip, range_mm));
    }
    let command = command.expect("a motion");
    let until_ms = chip.at_ms() + moving_ms;
    let mut heard_ms = None;
    while heard_ms.is_none() || chip.at_ms() < until_ms {
        std::thread::sleep(Duration::from_millis(u64::from(moving_ms % 50)));
        let said = chip.ask(&HostMessage::Odometry {
            at_ms: chip.at_ms(),
            motion: command.id,
            dx_mm: 0,
            dy_mm: 0,
            turned: 0,
            progress: Way::Moving,
        });
        heard_ms = said.last().map(|report| report.device_ms);
    }
    let (why, stopped_ms) = chip.wait(|_, report| match report.message {
        DeviceMessage::Mode(ModeReport::Stopped(why)) => Some((why, report.device_ms)),
        _ => None,
    });
    assert_eq!(why, StopReason::LinkLost, "after {moving_ms} ms");
    stopped_ms.wrapping_sub(heard_ms.unwrap_or(stopped_ms))
}
