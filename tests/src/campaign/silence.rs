//! A component fails while the base moves: time until the base is stopped or its motion expires.
//!
//! The control task, echoes and reports run as on the chip; the base is the simulated Nomad 200.
//! After the failure its motion has no end: only a stop or its time to live ends it. The device's
//! clock overflows. See `bridged` for trials with the bridge.

use super::bench::{Clocks, Ready, SESSION, hello, scan};
use super::bridged;
use super::wheels::Wheels;
use super::{CampaignVerdict, ProgressCallback, below, generator, grouped, parts};
use crate::chip::packed;
use amp::body::HeldRing;
use amp::wire::Receiver;
use amp::wire::frame::{Header, unpack};
use amp::wire::message::{DeviceMessage, HostMessage, Report, TimedEcho};
use arena::sonar::FIRING_ORDER;
use arena::world::{Point, Pose, Shape, World};
use firmware::control::Control;
use firmware::uart::{ErrorCounters, TxQueue};
use heapless::spsc::{Consumer, Producer, Queue};
use rayon::prelude::*;
use std::collections::VecDeque;

/// Trials of a full campaign, of each kind.
pub const COUNT: u64 = 100_000;
/// Trials with the same maps.
const PART: u64 = 500;
/// Time between two runs of the control task without a frame, ms.
const ROUND_MS: u64 = 10;
/// Between two echoes; between two reports of the base, ms.
const ECHO_MS: u64 = 40;
const REPORT_MS: u64 = 100;
/// Bytes per 100 ms: 115 200 baud, ten bits per byte.
const BYTES: u32 = 1_152;
/// Longest time from the start of the motion to the failure, and from there to a host's return, ms.
const MAX_MS: usize = 2_000;
const RETURN_MS: usize = 1_000;
/// Timeout of a trial, ms.
const GIVE_UP_MS: u64 = 20_000;
/// Observation time after the stop, ms.
const WATCHED_MS: u64 = 1_500;
/// Braking after a stop, from 508 mm/s at 762 mm/s²: 667 ms and 169 mm. Wheels that turn at 45 °/s
/// stop after 1.5 s at 30 °/s².
const BRAKING_MS: u64 = 1_510;
const CLOCKS: Clocks = Clocks {
    // Learning the maps takes 4.2 s.
    device: u32::MAX - 5_500,
    host: 77_000,
};

/// The component that fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FailedPart {
    /// The host sends nothing more; the base still receives the controller's frames.
    Host,
    /// The line, in both directions.
    Line,
    /// The host, which returns within a second in a new session.
    HostForAWhile,
    /// The controller: its chip is reset.
    Mind,
}

impl FailedPart {
    const ALL: [Self; 4] = [Self::Host, Self::Line, Self::HostForAWhile, Self::Mind];

    const fn name(self) -> &'static str {
        match self {
            Self::Host => "host silent, base still receives the controller",
            Self::Line => "line cut in both directions",
            Self::HostForAWhile => "host restarts within 1 s, in a new session",
            Self::Mind => "chip reset",
        }
    }

    /// Longest time until the stop command or the end of the motion's time to live, ms: a timeout
    /// of 300 ms or 500 ms, a cycle of the control task and two frames on the line.
    const fn max_ms(self) -> u64 {
        match self {
            Self::Host | Self::HostForAWhile => 320,
            Self::Line | Self::Mind => 520,
        }
    }

    /// Longest distance after the failure, mm: at 508 mm/s for that time, plus 169 mm of braking.
    const fn max_mm(self) -> f64 {
        match self {
            Self::Host | Self::HostForAWhile => 340.0,
            Self::Line | Self::Mind => 440.0,
        }
    }
}

/// Result of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SilenceStop {
    /// Time until the stop command, or until the motion ended or expired.
    after_ms: u64,
    /// Time until the wheels stood still.
    stood_ms: u64,
    /// Distance after the failure.
    way_mm: f64,
    moved_again: bool,
}

/// Runs `count` trials of each kind.
///
/// # Panics
/// When a trained controller does not move its base.
#[must_use]
pub fn run(seed: u64, count: u64, progress: ProgressCallback<'_>) -> CampaignVerdict {
    let mut verdict = CampaignVerdict::default();
    verdict.say(format_args!(
        "{} failures each while the base moves; time from the failure to the stop command or the end of its motion, ms; time until its wheels stand, ms; distance until then, mm\n",
        grouped(count)
    ));
    let hall = hall();
    let mut rows = Vec::new();
    for (kind, gone) in (0..).zip(FailedPart::ALL) {
        let trials = |(part, size): (u64, u64)| {
            let ready = Ready::new(seed.wrapping_add(part), CLOCKS);
            let first = (kind * count) + part * PART;
            let trials =
                (first..first + size).map(|trial| try_it(&ready, &hall, gone, seed, trial));
            let trials: Vec<_> = trials.collect();
            progress(size);
            trials
        };
        let all: Vec<_> = parts(count, PART)
            .into_par_iter()
            .flat_map_iter(trials)
            .collect();
        rows.push(judge(&mut verdict, gone, &all));
    }
    let heads = [
        "failure",
        "p50",
        "p99",
        "most",
        "allowed",
        "wheels stand, most",
        "distance mm, most",
        "allowed",
        "moved again",
    ];
    verdict.table(heads, &rows);
    bridged::run(&mut verdict, seed, count);
    verdict
}

/// So wide that no wall stops anything.
fn hall() -> World {
    let walls = Shape::room(Point::new(1_000.0, 1_000.0));
    World::new("hall", Pose::default(), vec![walls]).expect("a world")
}

fn judge(verdict: &mut CampaignVerdict, gone: FailedPart, all: &[SilenceStop]) -> [String; 9] {
    let mut times: Vec<_> = all.iter().map(|stopped| stopped.after_ms).collect();
    times.sort_unstable();
    let at = |share: usize| times.get((times.len().max(1) - 1) * share / 100).copied();
    let [median, rare, most] = [50, 99, 100].map(|share| at(share).unwrap_or(0));
    let again = all.iter().filter(|stopped| stopped.moved_again).count();
    let stood = all.iter().map(|stopped| stopped.stood_ms).max();
    let stood = stood.unwrap_or(0);
    let way_mm = all.iter().map(|stopped| stopped.way_mm).fold(0.0, f64::max);
    let name = gone.name();
    let is_short = way_mm <= gone.max_mm();
    verdict.require(is_short, format!("{name}: {way_mm:.0} mm"));
    let allowed_ms = gone.max_ms() + BRAKING_MS;
    verdict.require(
        stood <= allowed_ms,
        format!("{name}: stood after {stood} ms"),
    );
    verdict.require(most <= gone.max_ms(), format!("{name}: {most} ms"));
    verdict.require(again == 0, format!("{name}: moved again"));
    [
        name.to_owned(),
        median.to_string(),
        rare.to_string(),
        most.to_string(),
        gone.max_ms().to_string(),
        stood.to_string(),
        format!("{way_mm:.0}"),
        gone.max_mm().to_string(),
        again.to_string(),
    ]
}

fn try_it(ready: &Ready, hall: &World, gone: FailedPart, seed: u64, trial: u64) -> SilenceStop {
    let mut random = generator(seed, trial);
    let mut node = ready.node.clone();
    let (mut received, mut to_send) = (Queue::<u8, 512>::new(), Queue::<u8, 2_048>::new());
    let errors = ErrorCounters::new();
    let (producer, consumer) = received.split();
    let (to_send, outgoing) = to_send.split();
    let control = Control::new(&mut node, consumer, TxQueue::new(to_send), &errors, None);
    let wheels = Wheels::new(hall, trial);
    let mut scene = SilenceScene::new(ready, control, wheels, producer, outgoing);
    // At a random time between cycles, echoes and reports.
    scene.now_ms += below(&mut random, 200) as u64;
    scene.set_off();
    for _ in 0..below(&mut random, MAX_MS) {
        scene.advance_1_ms();
    }
    while !scene.wheels.is_ordered() {
        scene.advance_1_ms();
    }
    scene.is_gone(gone);
    scene.wheels.extend_without_end();
    let returns_after_ms = below(&mut random, RETURN_MS) as u64;
    watch_stop(&mut scene, gone, returns_after_ms)
}

/// Observes the stop after the failure; a host that is gone for a while returns after this time.
fn watch_stop(
    scene: &mut SilenceScene<'_>,
    gone: FailedPart,
    returns_after_ms: u64,
) -> SilenceStop {
    let (began_ms, began_mm) = (scene.now_ms, scene.wheels.way_mm());
    let returns_ms = began_ms + returns_after_ms;
    let (mut after_ms, mut stood_ms) = (None, None);
    let mut stood_mm = f64::INFINITY;
    while stood_ms.is_none_or(|stood| scene.now_ms < began_ms + stood + WATCHED_MS) {
        let passed_ms = scene.now_ms - began_ms;
        if passed_ms > GIVE_UP_MS {
            break;
        }
        if !scene.wheels.is_ordered() {
            after_ms = after_ms.or(Some(passed_ms));
        }
        if after_ms.is_some() && !scene.wheels.is_moving() && stood_ms.is_none() {
            stood_ms = Some(passed_ms);
            stood_mm = scene.wheels.way_mm();
        }
        if gone == FailedPart::HostForAWhile && scene.now_ms == returns_ms {
            scene.comes_back();
        }
        scene.advance_1_ms();
    }
    SilenceStop {
        after_ms: after_ms.unwrap_or(u64::MAX),
        stood_ms: stood_ms.unwrap_or(u64::MAX),
        way_mm: scene.wheels.way_mm() - began_mm,
        moved_again: scene.wheels.way_mm() > stood_mm + 1.0,
    }
}

/// A chip, a host and a base with a line between them.
struct SilenceScene<'a> {
    control: Control<'a, HeldRing>,
    incoming: Producer<'a, u8>,
    outgoing: Consumer<'a, u8>,
    /// Bytes on the line to the chip, and the line's capacity left in both directions, hundredths
    /// of bytes.
    to_chip: VecDeque<u8>,
    credit: [u32; 2],
    receiver: Receiver,
    session: u16,
    seq: u16,
    now_ms: u64,
    slot: usize,
    host_is_there: bool,
    chip_is_there: bool,
    base_hears: bool,
    wheels: Wheels<'a>,
}

impl<'a> SilenceScene<'a> {
    fn new(
        ready: &Ready,
        control: Control<'a, HeldRing>,
        wheels: Wheels<'a>,
        incoming: Producer<'a, u8>,
        outgoing: Consumer<'a, u8>,
    ) -> Self {
        Self {
            control,
            incoming,
            outgoing,
            to_chip: VecDeque::new(),
            credit: [0; 2],
            receiver: Receiver::new(),
            session: SESSION,
            seq: ready.seq,
            now_ms: ready.now_ms,
            slot: 0,
            host_is_there: true,
            chip_is_there: true,
            base_hears: true,
            wheels,
        }
    }

    /// Sends a whole ring and starts the motion that follows.
    fn set_off(&mut self) {
        self.say(|at_ms| scan(at_ms, 900));
        let until_ms = self.now_ms + 1_000;
        while !self.wheels.is_ordered() {
            assert!(self.now_ms < until_ms, "no motion");
            self.advance_1_ms();
        }
    }

    fn is_gone(&mut self, gone: FailedPart) {
        match gone {
            FailedPart::Host | FailedPart::HostForAWhile => self.host_is_there = false,
            FailedPart::Line => {
                (self.host_is_there, self.base_hears) = (false, false);
                self.to_chip.clear();
            }
            FailedPart::Mind => self.chip_is_there = false,
        }
    }

    fn comes_back(&mut self) {
        self.session += 1;
        self.seq = 0;
        self.say(|_| hello());
        self.host_is_there = true;
    }

    fn say(&mut self, message: impl FnOnce(u32) -> HostMessage<16>) {
        self.seq = self.seq.wrapping_add(1);
        let message = message(CLOCKS.host(self.now_ms));
        let header = Header {
            session: self.session,
            seq: self.seq,
        };
        self.to_chip.extend(packed(header, &message));
    }

    /// Advances by one millisecond.
    fn advance_1_ms(&mut self) {
        self.now_ms += 1;
        if self.host_is_there {
            self.host();
        }
        let look = self.move_bytes();
        if self.chip_is_there && (look || self.now_ms.is_multiple_of(ROUND_MS)) {
            while self.control.run(CLOCKS.device(self.now_ms)) {}
        }
        self.wheels.advance_1_ms(self.now_ms);
    }

    fn host(&mut self) {
        if self.now_ms.is_multiple_of(ECHO_MS) {
            let sensor = FIRING_ORDER[self.slot % FIRING_ORDER.len()] as u8;
            self.slot += 1;
            let heard = TimedEcho {
                sensor,
                range_mm: Some(900 + 20 * u16::from(sensor)),
                age_ms: 0,
            };
            let echoes = core::iter::once(heard).collect();
            self.say(|at_ms| HostMessage::Scan { at_ms, echoes });
        }
        if self.now_ms.is_multiple_of(REPORT_MS) {
            let report = self.wheels.report(CLOCKS.host(self.now_ms));
            self.say(|_| report);
        }
    }

    /// Transfers the bytes of one millisecond; returns whether a frame has reached the chip.
    fn move_bytes(&mut self) -> bool {
        let mut look = false;
        let [to_chip, from_chip] = &mut self.credit;
        *to_chip = (*to_chip + BYTES).min(2 * BYTES);
        *from_chip = (*from_chip + BYTES).min(2 * BYTES);
        while *to_chip >= 100
            && let Some(byte) = self.to_chip.pop_front()
        {
            *to_chip -= 100;
            // A failed chip receives nothing.
            if self.chip_is_there {
                look |= byte == 0;
                let _ = self.incoming.enqueue(byte);
            }
        }
        while self.chip_is_there
            && *from_chip >= 100
            && let Some(byte) = self.outgoing.dequeue()
        {
            *from_chip -= 100;
            if self.base_hears
                && let Some(frame) = self.receiver.push(byte)
                && let Ok((_, report)) = unpack::<Report<16>>(frame)
                && let DeviceMessage::Motion(order) = report.message
            {
                self.wheels.execute(order, self.now_ms);
            }
        }
        look
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_whose_link_is_well_does_not_stop() {
        let ready = Ready::new(3, CLOCKS);
        let mut node = ready.node.clone();
        let (mut received, mut to_send) = (Queue::<u8, 512>::new(), Queue::<u8, 2_048>::new());
        let errors = ErrorCounters::new();
        let (producer, consumer) = received.split();
        let (to_send, outgoing) = to_send.split();
        let control = Control::new(&mut node, consumer, TxQueue::new(to_send), &errors, None);
        let hall = hall();
        let wheels = Wheels::new(&hall, 1);
        let mut scene = SilenceScene::new(&ready, control, wheels, producer, outgoing);
        scene.set_off();
        let mut moving_ms = 0;
        for _ in 0..20_000 {
            scene.advance_1_ms();
            moving_ms += u64::from(scene.wheels.is_ordered());
        }
        // The remaining time is spent waiting for whole rings.
        assert!(moving_ms > 6_000, "{moving_ms} ms");
        assert!(scene.wheels.way_mm() > 700.0);
    }

    #[test]
    fn one_trial_that_takes_too_long_is_found() {
        let slow = SilenceStop {
            after_ms: 321,
            stood_ms: 900,
            way_mm: 300.0,
            moved_again: false,
        };
        let mut verdict = CampaignVerdict::default();
        let _ = judge(&mut verdict, FailedPart::Line, &[slow]);
        assert!(verdict.broken.is_empty());
        let _ = judge(&mut verdict, FailedPart::Host, &[slow]);
        assert_eq!(verdict.broken.len(), 1);
        let far = SilenceStop {
            way_mm: 441.0,
            stood_ms: 2_031,
            after_ms: 521,
            ..slow
        };
        let _ = judge(&mut verdict, FailedPart::Mind, &[far]);
        assert_eq!(verdict.broken.len(), 4);
    }
}
