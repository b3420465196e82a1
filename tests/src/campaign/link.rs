//! A line that loses, duplicates, reorders and delays frames, between a controller and its host.
//!
//! The host sends rings, odometry, heartbeats and commands in random order; both ends use
//! [`amp::link`]. A bookkeeper with 64-bit numbers knows the right result of each frame. Clocks
//! and sequence numbers overflow.

use super::bench::{Clocks, Ready, SESSION, coded, command_message, numbered, scan};
use super::channel::{Arrival, FaultRates, LossyChannel};
use super::{CampaignVerdict, ProgressCallback, below, generator, grouped, parts};
use amp::controller::{Mode, Progress as Way, StopReason};
use amp::link::{FrameVerdict as Judged, Link};
use amp::node::FrameSink;
use amp::units::Millis;
use amp::wire::frame::{Header, unpack};
use amp::wire::message::{
    Clock, DeviceMessage, GoalSpec, HostMessage, MotionCommand, Report, RobotCommand,
};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// Frames to the controller in a full campaign.
pub const COUNT: u64 = 1_000_000;
/// Frames over one line.
const PART: u64 = 100_000;
/// Time between two frames of the host, ms.
const EVERY_MS: u64 = 20;
/// Time between two ticks of the controller, ms.
const TICK_MS: u64 = 10;
/// The base's speed, mm/s.
const SPEED_MM_S: u64 = 500;
/// The lines: 30 % lost, 10 % duplicated, a fast frame overtakes two slow ones, and a stall of up
/// to 2 s every few seconds.
const BAD: FaultRates = FaultRates {
    lost: 30,
    twice: 10,
    delay_ms: [2, 60],
    stalls: 5,
    stall_ms: 2_000,
};
/// Greatest true age of an executed motion, ms: its time to live of 500 ms plus the minimum delay.
const OLDEST_MS: u64 = 520;
/// Both clocks overflow a few seconds after the controller has learned.
const CLOCKS: Clocks = Clocks {
    device: u32::MAX - 10_000,
    host: u32::MAX - 15_000,
};

/// The bookkeeper's counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Bookkeeper {
    /// To the controller: sent, lost, duplicated, overtaken.
    sent: u64,
    lost: u64,
    repeated: u64,
    overtaken: u64,
    /// Accepted by the controller: counted and expected.
    accepted: [u64; 2],
    replayed: [u64; 2],
    expired: [u64; 2],
    /// Late, duplicated or expired frames that changed the controller's state.
    late_but_done: u64,
    /// Times the controller reported the host as lost.
    losses: u64,
    /// To the base: frames sent, motions executed.
    said: u64,
    pub(super) executed: u64,
    /// Motions executed twice, after a later one, or after their time to live.
    pub(super) stale: u64,
    /// Motions that the base refused as late or duplicated, by sequence number.
    refused: u64,
    /// Motions that the base refused for their age.
    pub(super) aged: u64,
    /// Stops, whatever their sequence number, that did not stop the controller.
    stops_refused: u64,
    /// Motions executed while the controller's stop was in transit or lost.
    taken_back: u64,
    /// Age of the oldest executed motion, ms.
    pub(super) oldest_ms: u64,
}

impl Bookkeeper {
    fn plus(mut self, other: &Self) -> Self {
        let pairs = [
            (&mut self.sent, other.sent),
            (&mut self.lost, other.lost),
            (&mut self.repeated, other.repeated),
            (&mut self.overtaken, other.overtaken),
            (&mut self.late_but_done, other.late_but_done),
            (&mut self.losses, other.losses),
            (&mut self.said, other.said),
            (&mut self.executed, other.executed),
            (&mut self.stale, other.stale),
            (&mut self.refused, other.refused),
            (&mut self.aged, other.aged),
            (&mut self.stops_refused, other.stops_refused),
            (&mut self.taken_back, other.taken_back),
        ];
        for (sum, value) in pairs {
            *sum += value;
        }
        for place in 0..2 {
            self.accepted[place] += other.accepted[place];
            self.replayed[place] += other.replayed[place];
            self.expired[place] += other.expired[place];
        }
        self.oldest_ms = self.oldest_ms.max(other.oldest_ms);
        self
    }
}

/// Sends `count` frames to controllers.
#[must_use]
pub fn run(seed: u64, count: u64, progress: ProgressCallback<'_>) -> CampaignVerdict {
    let one = |(part, size)| {
        let book = LinkRun::new(seed, part, size).run();
        progress(size);
        book
    };
    let books: Vec<_> = parts(count, PART).into_par_iter().map(one).collect();
    verdict(&books.iter().fold(Bookkeeper::default(), Bookkeeper::plus))
}

/// One line with its two ends.
struct LinkRun {
    mind: Ready,
    base: LinkBase,
    to_device: LossyChannel,
    to_base: LossyChannel,
    random: Xoshiro256PlusPlus,
    book: Bookkeeper,
    size: u64,
    /// By frame to the controller: whether it arrived, and whether it was the latest on arrival.
    came: Vec<[bool; 2]>,
    /// Sequence number of the latest frame that the controller should have accepted.
    latest: Option<u64>,
    delays: Delays,
}

/// Delays of the accepted frames. By the protocol's rule, the greater of two consecutive delays
/// counts, for the rest of its ten seconds and fifty more.
#[derive(Debug)]
struct Delays {
    latest_ms: u64,
    /// Index of ten seconds, and delay.
    counted: Vec<(u64, u64)>,
}

impl Delays {
    /// While the controller learned, frames had no delay.
    fn new() -> Self {
        Self {
            latest_ms: 0,
            counted: vec![(0, 0)],
        }
    }

    /// Takes a frame; returns its age.
    fn age_ms(&mut self, come: &Arrival) -> u64 {
        let delay_ms = come.at_ms - come.sent_ms;
        let slot = come.at_ms / 10_000;
        self.counted.retain(|(counted, _)| slot - counted < 6);
        self.counted.push((slot, delay_ms.max(self.latest_ms)));
        self.latest_ms = delay_ms;
        let least_ms = self.counted.iter().map(|(_, delay_ms)| *delay_ms).min();
        delay_ms.saturating_sub(least_ms.unwrap_or(0))
    }
}

impl LinkRun {
    fn new(seed: u64, part: u64, size: u64) -> Self {
        Self {
            mind: Ready::new(seed.wrapping_add(part), CLOCKS),
            base: LinkBase::new(OLDEST_MS),
            to_device: LossyChannel::new(BAD, seed, 3 * part),
            to_base: LossyChannel::new(BAD, seed, 3 * part + 1),
            random: generator(seed, 3 * part + 2),
            book: Bookkeeper::default(),
            size,
            came: vec![[false; 2]; size as usize],
            latest: None,
            delays: Delays::new(),
        }
    }

    fn run(mut self) -> Bookkeeper {
        let before = *self.mind.node.counters();
        while self.to_device.sent() < self.size
            || !self.to_device.is_empty()
            || !self.to_base.is_empty()
        {
            self.mind.now_ms += 1;
            self.advance_1_ms();
        }
        let counters = *self.mind.node.counters();
        self.book.sent = self.to_device.sent();
        self.book.lost = self.to_device.lost();
        self.book.repeated = self.to_device.repeated();
        self.book.said = self.to_base.sent();
        self.book.overtaken = count(&self.came, |came| came == [true, false]);
        self.book.accepted = [
            u64::from(counters.accepted - before.accepted),
            count(&self.came, |came| came[1]),
        ];
        self.book.replayed[0] = u64::from(counters.replayed - before.replayed);
        self.book.expired[0] = u64::from(counters.expired - before.expired);
        self.book.losses = u64::from(counters.link_losses - before.link_losses);
        self.book
    }

    /// Advances by one millisecond.
    fn advance_1_ms(&mut self) {
        let now_ms = self.mind.now_ms;
        if now_ms.is_multiple_of(EVERY_MS) && self.to_device.sent() < self.size {
            let message = self.message();
            self.mind.seq = self.mind.seq.wrapping_add(1);
            self.to_device
                .send(now_ms, &numbered(self.mind.seq, &message));
        }
        while let Some(come) = self.to_device.next_arrival(now_ms) {
            self.deliver(&come);
        }
        if now_ms.is_multiple_of(TICK_MS) {
            let now = CLOCKS.device(now_ms);
            let mut said = RecordingSink::new(now_ms, &mut self.to_base, &mut self.base);
            while self.mind.node.tick(now, &mut said) {}
        }
        while let Some(come) = self.to_base.next_arrival(now_ms) {
            // The base has another clock.
            let here = CLOCKS.device(now_ms).as_ms().wrapping_add(123_456_789);
            let here = Millis::from_ms(here);
            self.base.hear(&come, now_ms, here, &mut self.book);
        }
        self.base.advance_1_ms(now_ms);
    }

    fn message(&mut self) -> HostMessage<16> {
        let at_ms = self.mind.host_ms();
        let random = &mut self.random;
        match below(random, 100) {
            0..45 => scan(at_ms, 500 + below(random, 1_000) as u16),
            45..85 => self.base.report(at_ms),
            85..92 => HostMessage::Alive { at_ms },
            _ => {
                let command = match below(random, 20) {
                    0..7 => RobotCommand::Seek,
                    7..14 => RobotCommand::Resume,
                    14..18 => RobotCommand::Stop,
                    _ => RobotCommand::Goal(GoalSpec::Avoid),
                };
                // Some times to live are shorter than a slow frame's delay.
                command_message(at_ms, 20 + below(random, 60) as u16, command)
            }
        }
    }

    /// Delivers a frame to the controller, and compares the effect with the expected one.
    fn deliver(&mut self, come: &Arrival) {
        let is_new = self.latest.is_none_or(|latest| come.number > latest);
        let message = unpack::<HostMessage<16>>(coded(&come.bytes)).map(|(_, message)| message);
        let (ttl_ms, is_stop) = match message {
            Ok(HostMessage::Command {
                ttl_ms, command, ..
            }) => (Some(ttl_ms), command == RobotCommand::Stop),
            _ => (None, false),
        };
        let mut may_act = is_new || is_stop;
        let [came, accepted] = &mut self.came[come.number as usize];
        *came = true;
        if is_new {
            *accepted = true;
            self.latest = Some(come.number);
            let age_ms = self.delays.age_ms(come);
            if let Some(ttl_ms) = ttl_ms.filter(|_| !is_stop) {
                may_act = age_ms <= u64::from(ttl_ms);
                self.book.expired[1] += u64::from(!may_act);
            }
        } else {
            self.book.replayed[1] += 1;
        }
        let before = (!may_act).then(|| self.mind.node.state().clone());
        let mut said = RecordingSink::new(come.at_ms, &mut self.to_base, &mut self.base);
        let now = CLOCKS.device(come.at_ms);
        self.mind.node.frame(now, coded(&come.bytes), &mut said);
        let changed = before.is_some_and(|before| before != *self.mind.node.state());
        self.book.late_but_done += u64::from(changed);
        let stopped = Mode::Stopped(StopReason::Commanded);
        let obeyed = !is_stop || *self.mind.node.state().mode() == stopped;
        self.book.stops_refused += u64::from(!obeyed);
    }
}

fn count(came: &[[bool; 2]], is: impl Fn([bool; 2]) -> bool) -> u64 {
    came.iter().filter(|came| is(**came)).count() as u64
}

/// Sends the controller's frames over the line and records them.
struct RecordingSink<'a> {
    now_ms: u64,
    line: &'a mut LossyChannel,
    base: &'a mut LinkBase,
}

impl<'a> RecordingSink<'a> {
    fn new(now_ms: u64, line: &'a mut LossyChannel, base: &'a mut LinkBase) -> Self {
        Self { now_ms, line, base }
    }
}

impl FrameSink for RecordingSink<'_> {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.line.send(self.now_ms, frame);
        self.base.is_on_its_way(frame);
        true
    }
}

/// The base: its link, its motion, and the record of the frames to it.
#[derive(Default)]
pub(super) struct LinkBase {
    /// Greatest true age of an executed motion, ms.
    oldest_ms: u64,
    link: Option<Link>,
    command: Option<MotionCommand>,
    /// End of the motion unless it is renewed, ms.
    until_ms: u64,
    /// Executed and not yet reported, µm; the whole motion, µm.
    unreported_um: u64,
    executed_um: u64,
    /// Sequence numbers of the frames sent, without overflow, in order.
    numbers: Vec<i64>,
    /// The controller's latest stop.
    latest_stop: i64,
    /// Sequence number of the latest executed motion.
    latest: Option<i64>,
}

impl LinkBase {
    pub(super) fn new(oldest_ms: u64) -> Self {
        Self {
            oldest_ms,
            ..Self::default()
        }
    }

    /// Must be called for every frame, in the order of sending.
    pub(super) fn is_on_its_way(&mut self, frame: &[u8]) {
        let Ok((header, report)) = unpack::<Report<16>>(coded(frame)) else {
            return;
        };
        let last = self.numbers.last().copied();
        let number = last.map_or(i64::from(header.seq), |last| {
            last + i64::from(header.seq.wrapping_sub(last as u16) as i16)
        });
        self.numbers.push(number);
        if matches!(report.message, DeviceMessage::Motion(command) if is_stop(command)) {
            self.latest_stop = self.latest_stop.max(number);
        }
    }

    /// Processes a frame; `here` is its own time.
    pub(super) fn hear(
        &mut self,
        come: &Arrival,
        now_ms: u64,
        here: Millis,
        book: &mut Bookkeeper,
    ) {
        let Ok((header, report)) = unpack::<Report<16>>(coded(&come.bytes)) else {
            return;
        };
        let said = Millis::from_ms(report.device_ms);
        let true_age_ms = now_ms - come.sent_ms;
        let link = self.link.get_or_insert_with(|| opened(header));
        if link.accept(header) != Judged::Accept {
            book.refused += u64::from(matches!(report.message, DeviceMessage::Motion(_)));
            return;
        }
        link.heard(said, here);
        let age_ms = link.age_ms(said, here);
        let DeviceMessage::Motion(command) = report.message else {
            return;
        };
        if age_ms > u32::from(command.ttl_ms) {
            book.aged += 1;
            return;
        }
        let number = self.numbers[come.number as usize];
        let is_late = self.latest.is_some_and(|latest| number <= latest);
        book.stale += u64::from(is_late || true_age_ms > self.oldest_ms);
        book.executed += 1;
        book.taken_back += u64::from(!is_stop(command) && number < self.latest_stop);
        book.oldest_ms = book.oldest_ms.max(true_age_ms);
        self.latest = Some(number);
        let left_ms = u64::from(command.ttl_ms) - u64::from(age_ms);
        self.execute(command, now_ms + left_ms);
    }

    fn execute(&mut self, command: MotionCommand, until_ms: u64) {
        let is_renewal = self
            .command
            .is_some_and(|old| (old.id, old.revision) == (command.id, command.revision));
        if !is_renewal {
            self.executed_um = 0;
            self.unreported_um = 0;
        }
        self.command = Some(command);
        self.until_ms = until_ms;
    }

    /// Advances the motion by one millisecond.
    pub(super) fn advance_1_ms(&mut self, now_ms: u64) {
        if self.is_moving(now_ms) {
            self.executed_um += SPEED_MM_S;
            self.unreported_um += SPEED_MM_S;
        }
    }

    fn is_moving(&self, now_ms: u64) -> bool {
        self.command.is_some_and(|command| {
            let way_um = 1_000 * u64::from(command.motion().displacement.length_mm());
            now_ms < self.until_ms && self.executed_um < way_um
        })
    }

    /// Its motion since the last report.
    pub(super) fn report(&mut self, at_ms: u32) -> HostMessage<16> {
        let command = self.command;
        let moved_mm = (self.unreported_um / 1_000) as u16;
        self.unreported_um %= 1_000;
        let moved = command.map(|command| command.motion().displacement.with_length(moved_mm));
        let way_mm = command.map_or(0, |command| command.motion().displacement.length_mm());
        let is_done = self.executed_um >= 1_000 * u64::from(way_mm);
        HostMessage::Odometry {
            at_ms,
            motion: command.map_or(0, |command| command.id),
            dx_mm: moved.map_or(0, |moved| moved.dx_mm),
            dy_mm: moved.map_or(0, |moved| moved.dy_mm),
            turned: 0,
            progress: if is_done { Way::Ended } else { Way::Moving },
        }
    }
}

const fn is_stop(command: MotionCommand) -> bool {
    command.dx_mm == 0 && command.dy_mm == 0
}

/// The link of a base after its first frame.
fn opened(first: Header) -> Link {
    let mut link = Link::new();
    let before = Header {
        session: SESSION,
        seq: first.seq.wrapping_sub(1),
    };
    link.open(before, Clock::Device, Millis::from_ms(0));
    link
}

fn verdict(book: &Bookkeeper) -> CampaignVerdict {
    let mut verdict = CampaignVerdict::default();
    verdict.say(format_args!(
        "{} frames to the controller and {} from it; {} % lost, {} % of the others duplicated, {} to {} ms in transit, {} in 1000 meet a stall of up to {} ms\n",
        grouped(book.sent),
        grouped(book.said),
        BAD.lost,
        BAD.twice,
        BAD.delay_ms[0],
        BAD.delay_ms[1],
        BAD.stalls,
        BAD.stall_ms
    ));
    verdict.table(["what", "number"], &rows(book));
    let unaccepted = book.sent - book.accepted[0];
    verdict.say(format_args!(
        "\nsent minus accepted: {}; lost and overtaken, by the bookkeeper: {}",
        grouped(unaccepted),
        grouped(book.lost + book.overtaken)
    ));
    check(&mut verdict, book);
    verdict
}

fn rows(book: &Bookkeeper) -> Vec<[String; 2]> {
    let row = |what: &str, number| [what.to_owned(), grouped(number)];
    vec![
        row("lost in transit to the controller", book.lost),
        row("overtaken by a later one", book.overtaken),
        row("duplicated", book.repeated),
        row("accepted by the controller", book.accepted[0]),
        row(
            "duplicate or late, by the controller's count",
            book.replayed[0],
        ),
        row(
            "commands past their time to live, by the controller's count",
            book.expired[0],
        ),
        row(
            "such frames that changed the controller's state",
            book.late_but_done,
        ),
        row(
            "times the controller reported the host as lost",
            book.losses,
        ),
        row("motions and renewals executed by the base", book.executed),
        row("refused by the base as late or repeated", book.refused),
        row("refused by the base for their age", book.aged),
        row("stops that did not stop the controller", book.stops_refused),
        row("**stale motions executed**", book.stale),
        row("age of the oldest executed motion, ms", book.oldest_ms),
        row(
            "executed while the controller's stop was in transit or lost",
            book.taken_back,
        ),
    ]
}

fn check(verdict: &mut CampaignVerdict, book: &Bookkeeper) {
    verdict.require(
        book.sent - book.accepted[0] == book.lost + book.overtaken,
        "the count of lost frames is not exact",
    );
    for (what, [counted, right]) in [
        ("accepted", book.accepted),
        ("repeated", book.replayed),
        ("expired", book.expired),
    ] {
        let broken = format!("{what}: {counted} counted, {right} were");
        verdict.require(counted == right, broken);
    }
    verdict.require(book.late_but_done == 0, "a late frame had an effect");
    verdict.require(book.stale == 0, "a stale motion was executed");
    verdict.require(book.stops_refused == 0, "a stop was refused");
    let enough = book.executed > 0 && book.replayed[1] > 0 && book.expired[1] > 0 && book.aged > 0;
    verdict.require(enough, "nothing was tested");
}
