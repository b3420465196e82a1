//! A thousandth of the campaigns of frames, link and silence, against the firmware in an emulated chip: by its own clock, in
//! real time.

use super::bench::{carried_out, command, motion, scan};
use super::channel::{Badness, Channel};
use super::frames::{Example, examples};
use super::mutate::Damage;
use super::{Progress, Verdict, below, generator, grouped};
use crate::chip::{Chip, SESSION, packed};
use amp::controller::{Progress as Way, StopReason};
use amp::link::{Link, Verdict as Judged};
use amp::units::Millis;
use amp::wire::frame::{FrameError, Header, unpack};
use amp::wire::message::{
    Clock, Counters, FromMind, ModeReport, MotionOrder, Order, Report, ToMind,
};
use amp::wire::{Frame, Receiver};
use std::time::Duration;

/// Bytes sent without waiting for the chip.
const AHEAD: usize = 1_000;
/// Time between two frames over the bad line, ms.
const EVERY_MS: u64 = 20;
/// The bad line, both ways: an emulated one has its own delays beside these.
const BAD: Badness = Badness {
    lost: 30,
    twice: 10,
    delay_ms: [0, 60],
    stalls: 0,
    stall_ms: 0,
};
/// A host is missed after 300 ms of silence (PROTOCOL.md). A round of the control task, and what an emulator on a busy machine adds,
/// come on top, ms.
const SILENT_MS: [u32; 2] = [300, 400];

/// What the decoder of this machine makes of damaged frames: what the chip should count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Expected {
    misshapen: u32,
    damaged: u32,
    unknown: u32,
    oversized: u32,
    sound: u32,
}

/// Sends `count` damaged frames to the chip and compares what it counts with what the decoder here says of them.
///
/// # Panics
/// When there is no emulator, or the chip falls silent.
#[must_use]
pub fn frames(seed: u64, count: u64, progress: Progress<'_>) -> Verdict {
    let examples: Vec<_> = examples().into_iter().filter(|one| one.to_mind).collect();
    let mut random = generator(seed, 0);
    let mut chip = Chip::linked(Clock::Device);
    let before = chip.counters();
    let (mut expected, mut asked, mut ahead) = (Expected::default(), 1, 0);
    for _ in 0..count {
        let damage = Damage::ALL[below(&mut random, Damage::ALL.len())];
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
            chip.ask(&ToMind::Mode);
        }
        progress(1);
    }
    judge(&expected, count, asked, &before, &chip.counters())
}

/// What a sound frame of another session is to the chip: a stranger or, if it is a hello, refused.
fn expect(frame: &[u8], examples: &[Example], expected: &mut Expected) {
    let mut receiver = Receiver::new();
    for &byte in frame {
        let Some(piece) = receiver.push(byte) else {
            continue;
        };
        match unpack::<ToMind<16>>(piece) {
            Err(FrameError::Shape | FrameError::TooLong) => expected.misshapen += 1,
            Err(FrameError::Crc) => expected.damaged += 1,
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
    expected: &Expected,
    count: u64,
    asked: u32,
    before: &Counters,
    after: &Counters,
) -> Verdict {
    let mut verdict = Verdict::default();
    verdict.say(format_args!(
        "{} damaged frames to the chip\n",
        grouped(count)
    ));
    let sound = |counters: &Counters| counters.strangers + counters.refused;
    let pairs = [
        (
            "no COBS",
            expected.misshapen,
            after.misshapen - before.misshapen,
        ),
        (
            "wrong CRC",
            expected.damaged,
            after.damaged - before.damaged,
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
            "sound, of another session",
            expected.sound,
            sound(after) - sound(before),
        ),
        (
            "accepted: our own questions",
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

/// Explores and learns a little, and seeks.
fn seeking(chip: &mut Chip) {
    chip.order(Order::Explore { moves: 10, seed: 3 });
    for round in 0..10 {
        let order = ring(chip, 700 + 50 * round).expect("a random move");
        let done = carried_out(chip.at_ms(), order);
        chip.ask(&done);
    }
    ring(chip, 900);
    chip.order(Order::Learn);
    chip.wait(|_, report| (report.said == FromMind::Mode(ModeReport::Idle)).then_some(()));
    chip.order(Order::Seek);
}

fn ring(chip: &mut Chip, range_mm: u16) -> Option<MotionOrder> {
    let scan = scan(chip.at_ms(), range_mm);
    motion(&chip.ask(&scan))
}

/// Sends `count` frames over a bad line both ways.
///
/// # Panics
/// When there is no emulator, or the chip falls silent.
#[must_use]
pub fn link(seed: u64, count: u64, progress: Progress<'_>) -> Verdict {
    let mut chip = Chip::linked(Clock::Device);
    seeking(&mut chip);
    let before = chip.counters();
    let first = chip.send(&ToMind::Mode).wrapping_add(1);
    chip.wait(|_, report| matches!(report.said, FromMind::Done { .. }).then_some(()));
    let [mut there, mut back] = [0, 1].map(|part| Channel::new(BAD, seed, part));
    let mut random = generator(seed, 2);
    let (mut latest, mut accepted, mut replayed) = (None, 0, 0);
    let mut base = Base::default();
    let began_ms = u64::from(chip.at_ms());
    while there.sent() < count || !there.is_empty() || !back.is_empty() {
        let now_ms = u64::from(chip.at_ms()) - began_ms;
        if there.sent() < count && now_ms >= EVERY_MS * there.sent() {
            let seq = first.wrapping_add(there.sent() as u16);
            let message = message(chip.at_ms(), base.order, &mut random);
            let session = SESSION;
            there.send(now_ms, &packed(Header { session, seq }, &message));
            progress(1);
        }
        while let Some(come) = there.come(now_ms) {
            chip.raw(&come.bytes);
            let is_new = latest.is_none_or(|latest| come.number > latest);
            (accepted, replayed) = (accepted + u32::from(is_new), replayed + u32::from(!is_new));
            latest = latest.max(Some(come.number));
        }
        while let Some((header, report)) = chip.next(Duration::from_millis(2)) {
            let frame = Frame::pack(header, &report).expect("it came in a frame");
            back.send(now_ms, frame.as_bytes());
        }
        while let Some(come) = back.come(now_ms) {
            base.hear(&come.bytes, u64::from(chip.at_ms()) as u32);
        }
    }
    let after = chip.counters_as(first.wrapping_add(count as u16));
    let mut verdict = Verdict::default();
    verdict.say(format_args!(
        "{} frames to the chip, {} from it\n",
        grouped(count),
        grouped(back.sent())
    ));
    // The question for the counters is accepted as well, and so was the one before the first.
    let pairs = [
        ("accepted", accepted + 2, after.accepted - before.accepted),
        (
            "repeated or late",
            replayed,
            after.replayed - before.replayed,
        ),
    ];
    let mut rows = Vec::from(pairs.map(|(what, here, there)| {
        verdict.require(here == there, format!("{what}: {there} instead of {here}"));
        [what.to_owned(), grouped(here.into()), grouped(there.into())]
    }));
    rows.push([
        "motions executed".to_owned(),
        String::new(),
        grouped(base.executed),
    ]);
    rows.push([
        "stale ones executed".to_owned(),
        "0".to_owned(),
        grouped(base.stale),
    ]);
    verdict.table(["what", "should be", "counted"], &rows);
    verdict.require(base.stale == 0, "a stale motion was executed");
    verdict.require(base.executed > 0, "no motion was executed");
    verdict
}

/// Rings, reports and orders in no sensible order.
fn message(
    at_ms: u32,
    order: Option<MotionOrder>,
    random: &mut rand_xoshiro::Xoshiro256PlusPlus,
) -> ToMind<16> {
    match (below(random, 20), order) {
        (0..9, _) | (9..17, None) => scan(at_ms, 500 + below(random, 1_000) as u16),
        (9..17, Some(order)) => carried_out(at_ms, order),
        (17, _) => ToMind::Alive { at_ms },
        (18, _) => command(at_ms, 1_000, Order::Seek),
        _ => command(at_ms, 1_000, Order::Resume),
    }
}

/// A base that executes what its link accepts within its time to live.
#[derive(Default)]
struct Base {
    link: Option<Link>,
    order: Option<MotionOrder>,
    /// Number of the latest motion executed, without an end.
    latest: Option<u16>,
    executed: u64,
    stale: u64,
}

impl Base {
    fn hear(&mut self, frame: &[u8], now_ms: u32) {
        let coded = frame.split_last().map_or(frame, |(_, coded)| coded);
        let Ok((header, report)) = unpack::<Report<16>>(coded) else {
            return;
        };
        let now = Millis::from_ms(now_ms);
        let link = self.link.get_or_insert_with(|| {
            let mut link = Link::new();
            let seq = header.seq.wrapping_sub(1);
            link.open(Header { seq, ..header }, Clock::Device, now);
            link
        });
        if link.accept(header) != Judged::Accept {
            return;
        }
        let said = Millis::from_ms(report.device_ms);
        link.heard(said, now);
        if let FromMind::Motion(order) = report.said
            && link.age_ms(said, now) <= u32::from(order.ttl_ms)
        {
            self.executed += 1;
            let is_late = |latest: u16| header.seq.wrapping_sub(latest) as i16 <= 0;
            self.stale += u64::from(self.latest.is_some_and(is_late));
            self.latest = Some(header.seq);
            self.order = Some(order);
        }
    }
}

/// Falls silent at `count` moments of a motion; times by the chip's clock, from the last frame it heard to its stop.
///
/// # Panics
/// When there is no emulator, or the chip does not stop at all.
#[must_use]
pub fn silence(seed: u64, count: u64, progress: Progress<'_>) -> Verdict {
    let mut chip = Chip::linked(Clock::Device);
    seeking(&mut chip);
    let mut random = generator(seed, 0);
    let mut times: Vec<_> = (0..count)
        .map(|_| {
            let took_ms = stopped_after(&mut chip, below(&mut random, 1_000) as u32);
            progress(1);
            chip.order(Order::Resume);
            took_ms
        })
        .collect();
    times.sort_unstable();
    let at = |share: usize| times.get((times.len().max(1) - 1) * share / 100).copied();
    let mut verdict = Verdict::default();
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

fn stopped_after(chip: &mut Chip, moving_ms: u32) -> u32 {
    let mut order = None;
    for range_mm in [900, 1_000, 1_100, 1_200] {
        order = order.or_else(|| ring(chip, range_mm));
    }
    let order = order.expect("a motion");
    let until_ms = chip.at_ms() + moving_ms;
    let mut heard_ms = None;
    while heard_ms.is_none() || chip.at_ms() < until_ms {
        std::thread::sleep(Duration::from_millis(u64::from(moving_ms % 50)));
        let said = chip.ask(&ToMind::Odometry {
            at_ms: chip.at_ms(),
            motion: order.id,
            dx_mm: 0,
            dy_mm: 0,
            turned: 0,
            progress: Way::Moving,
        });
        heard_ms = said.last().map(|report| report.device_ms);
    }
    let stop = FromMind::Mode(ModeReport::Stopped(StopReason::LinkLost));
    let stopped_ms = chip.wait(|_, report| (report.said == stop).then_some(report.device_ms));
    stopped_ms.wrapping_sub(heard_ms.unwrap_or(stopped_ms))
}
