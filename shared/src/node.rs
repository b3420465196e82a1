//! The mind behind a link: frames in, frames out. The same function of its inputs on the chip and in the simulator.
//!
//! A [`Node`] owns the robot's state and configuration; it is all zeros until [`Node::start`]. [`Node::frame`] takes a
//! received frame, does what it asks for and sends the answers; [`Node::tick`] lets time pass: a slice of learning, the
//! watch over link and ring, motions renewed before they expire. Every accepted frame but a sign of life is answered with
//! whatever it brought about and, at the end, with [`FromMind::Done`], so that a host knows when to go on. A frame that is
//! lost costs its sender a repetition: the last one accepted is answered again, byte for byte, but never done again.
//!
//! When the host falls silent for longer than [`SILENCE_MS`](crate::link::SILENCE_MS) the robot stops with
//! [`StopReason::LinkLost`] and stays so until it is told to resume.

use crate::config::Config;
use crate::controller::{self, Command, Event, Mode, NomadState, Outputs, State, StopReason};
use crate::goal::{Goal, KeptGoals};
use crate::link::{Link, Verdict};
use crate::som::Grid;
use crate::som::kernels::Kernels;
use crate::units::{Millis, Range};
use crate::wire::frame::{self, Frame, FrameError, Header};
use crate::wire::message::{
    Clock, Counters, DeviceCounters, Dimensions, FromMind, HostHello, MindHello, ModeReport,
    MotionOrder, Notice, Order, Oscillator, Refusal, Report, ResetCause, Source, ToMind,
};
use crate::wire::{PROTOCOL, SCHEMA};
use heapless::Vec;
use keeping::FlashTask;
use kept::Kept;

mod keeping;
mod kept;
mod pieces;
mod requests;

/// Time to live of a motion, milliseconds: a base that hears nothing for this long stops.
pub const MOTION_TTL_MS: u16 = 500;
/// A motion under way is sent again after this time, milliseconds.
pub const RENEWAL_MS: u32 = 200;
/// Most bytes of a configuration in postcard's form.
pub const MAX_CONFIG: usize = 384;

/// Takes frames on their way out.
pub trait FrameSink {
    /// Takes a whole frame, zero included, or none of it.
    fn send(&mut self, frame: &[u8]) -> bool;
}

/// Who a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Identity {
    /// Build of the program.
    pub build: [u8; 8],
    /// Why it started.
    pub reset: ResetCause,
    /// What clocks the processor.
    pub oscillator: Oscillator,
    /// Whether the program has a ring of its own.
    pub ring: bool,
}

/// The latest motion sent.
#[derive(Debug, Clone, Copy)]
struct Underway {
    order: MotionOrder,
    sent: Millis,
}

/// A mind behind a link.
#[derive(Debug, Clone)]
pub struct Node<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize> {
    config: Config<SENSORS>,
    state: State<SENSORS, NEURONS, SAMPLES>,
    goal: Goal<SENSORS>,
    goals: KeptGoals<SENSORS>,
    flash: FlashTask,
    identity: Identity,
    source: Source,
    link: Link,
    /// Header of the hello that opened the session.
    opened_by: Header,
    seq: u16,
    underway: Option<Underway>,
    counters: Counters,
    kept: Kept,
    /// A stale echo was reported since the last decision.
    stale_reported: bool,
    /// A configuration on its way in.
    staged: Vec<u8, MAX_CONFIG>,
}

/// The node of the Nomad 200 with the paper's sizes.
pub type NomadNode = Node<16, 16, 100>;

const _: () = assert!(size_of::<NomadState>() <= 8_704);

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize> Default
    for Node<SENSORS, NEURONS, SAMPLES>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    Node<SENSORS, NEURONS, SAMPLES>
{
    /// A node that has not been started: it believes no transducer and knows no goal. It is all zeros, so that a static
    /// one takes no room in a program's image.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            config: Config::zeroed(),
            state: State::new(Grid::rectangle(1, 1)),
            goal: Goal::zeroed(),
            goals: KeptGoals::new(),
            flash: FlashTask::NONE,
            identity: Identity {
                build: [0; 8],
                reset: ResetCause::Unknown,
                oscillator: Oscillator::Unknown,
                ring: false,
            },
            source: Source::Link,
            link: Link::new(),
            opened_by: Header { session: 0, seq: 0 },
            seq: 0,
            underway: None,
            counters: Counters::NONE,
            kept: Kept::new(),
            stale_reported: false,
            staged: Vec::new(),
        }
    }

    /// Uses CPU-specific kernels: see [`State::use_kernels`].
    pub fn use_kernels(&mut self, kernels: &'static Kernels) {
        self.state.use_kernels(kernels);
    }

    /// Begins with this configuration and maps on this grid, which should have `NEURONS` places: says hello to whoever
    /// listens, in session 0.
    pub fn start(
        &mut self,
        config: &Config<SENSORS>,
        grid: Grid,
        identity: Identity,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        self.prepare(config, grid, identity);
        self.hello(now, out);
    }

    /// The first half of [`start`](Self::start), for whoever has something to recall before the hello.
    pub fn prepare(&mut self, config: &Config<SENSORS>, grid: Grid, identity: Identity) {
        self.config.clone_from(config);
        self.state.set_grid(grid);
        self.identity = identity;
        self.goal = Goal::avoiding(&self.config);
    }

    /// What it was told.
    #[must_use]
    pub const fn config(&self) -> &Config<SENSORS> {
        &self.config
    }

    /// What it knows.
    #[must_use]
    pub const fn state(&self) -> &State<SENSORS, NEURONS, SAMPLES> {
        &self.state
    }

    /// What it has counted.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// What the device counts, to be kept up to date by it.
    pub const fn device_counters(&mut self) -> &mut DeviceCounters {
        &mut self.counters.device
    }

    /// Counts frames that were too long for the receiver.
    pub const fn set_oversized(&mut self, frames: u32) {
        self.counters.oversized = frames;
    }

    /// Where echoes come from.
    #[must_use]
    pub const fn source(&self) -> Source {
        self.source
    }

    /// Whether a host is there.
    #[must_use]
    pub const fn is_linked(&self) -> bool {
        self.link.is_alive()
    }

    /// Whether a host is there and was heard within [`SILENCE_MS`](crate::link::SILENCE_MS) before `now`, by the device's clock whichever clock the
    /// session has.
    #[must_use]
    pub const fn has_heard_host(&self, now: Millis) -> bool {
        self.link.has_heard(now)
    }

    /// Takes a received frame, without its zero, at `now` by the device's clock.
    pub fn frame(&mut self, now: Millis, frame: &[u8], out: &mut impl FrameSink) {
        let counters = &mut self.counters;
        match frame::unpack::<ToMind<SENSORS>>(frame) {
            Ok((header, ref message)) => self.message(header, message, now, out),
            Err(FrameError::Shape | FrameError::TooLong) => add(&mut counters.misshapen),
            Err(FrameError::Crc) => add(&mut counters.damaged),
            Err(FrameError::Content { .. }) => add(&mut counters.unknown),
        }
    }

    fn message(
        &mut self,
        header: Header,
        message: &ToMind<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        if let ToMind::Hello(hello) = *message {
            return self.open(header, hello, now, out);
        }
        let verdict = self.link.accept(header);
        if verdict == Verdict::Accept {
            add(&mut self.counters.accepted);
            self.kept.begin();
        }
        // A stop acts whatever its session, number and time. Where it is the last frame once more, its answer is said again as it
        // was, which holds the order to stand.
        let is_stop = matches!(
            message,
            ToMind::Command {
                order: Order::Stop,
                ..
            }
        );
        let is_answered = verdict == Verdict::Replayed { last: true }
            && matches!(self.state.mode(), Mode::Stopped(_))
            && self.kept.frames().next().is_some();
        if is_stop && !is_answered {
            self.stop(now, out);
        }
        match verdict {
            Verdict::Accept => self.request(header.seq, message, now, out),
            Verdict::Replayed { last } => {
                add(&mut self.counters.replayed);
                if last && !matches!(message, ToMind::Alive { .. }) {
                    self.say_again(header.seq, now, out);
                } else if is_stop {
                    self.done(header.seq, now, out);
                }
            }
            Verdict::NoSession | Verdict::Stranger if is_stop => {
                add(&mut self.counters.strangers);
                self.done(header.seq, now, out);
            }
            Verdict::NoSession => {
                add(&mut self.counters.strangers);
                self.refuse(header.seq, Refusal::NoSession, now, out);
            }
            Verdict::Stranger => add(&mut self.counters.strangers),
        }
    }

    /// Stops the robot, by the time of the session's clock.
    fn stop(&mut self, now: Millis, out: &mut impl FrameSink) {
        let stop = Event::Command(Command::Stop);
        self.happen(self.link.time(now), stop, now, out);
    }

    fn open(&mut self, header: Header, hello: HostHello, now: Millis, out: &mut impl FrameSink) {
        let ours = Self::dimensions();
        if hello.dimensions != ours || header.session == 0 {
            return self.refuse(header.seq, Refusal::Incompatible(ours), now, out);
        }
        let is_repeated = header == self.opened_by
            && header.seq == self.link.seq()
            && hello.clock == self.link.clock()
            && hello.open_space == self.config.open_space;
        if is_repeated {
            // Its answer was lost.
            return self.hello(now, out);
        }
        // Whatever moves does so for a host that is gone.
        let gone = Event::Alarm(StopReason::LinkLost);
        self.happen(self.link.time(now), gone, now, out);
        add(&mut self.counters.accepted);
        self.link.open(header, hello.clock, now);
        self.opened_by = header;
        self.config.open_space = hello.open_space;
        self.source = Source::Link;
        self.seq = 0;
        self.kept.clear();
        self.hello(now, out);
    }

    const fn dimensions() -> Dimensions {
        Dimensions {
            protocol: PROTOCOL,
            schema: SCHEMA,
            sensors: SENSORS as u8,
            neurons: NEURONS as u8,
        }
    }

    /// Says hello: the second half of [`start`](Self::start).
    pub fn hello(&mut self, now: Millis, out: &mut impl FrameSink) {
        let hello = MindHello {
            dimensions: Self::dimensions(),
            samples: SAMPLES as u16,
            build: self.identity.build,
            reset: self.identity.reset,
            oscillator: self.identity.oscillator,
            config_crc: self.config_crc(),
            maps_crc: self.maps_crc(),
            memory_crc: self.memory_crc(),
        };
        self.say(FromMind::Hello(hello), now, out);
    }

    /// Lets time pass. Returns whether there is more to do at once.
    pub fn tick(&mut self, now: Millis, out: &mut impl FrameSink) -> bool {
        let time = self.link.time(now);
        if matches!(self.state.mode(), Mode::Learn { .. }) {
            self.happen(time, Event::Tick, now, out);
        } else if self.link.clock() == Clock::Device {
            self.watch(time, now, out);
        }
        matches!(self.state.mode(), Mode::Learn { .. })
    }

    /// What has to happen with time, at `time` by the session's clock.
    fn watch(&mut self, time: Millis, now: Millis, out: &mut impl FrameSink) {
        if self.link.falls_silent(time) {
            add(&mut self.counters.link_losses);
            self.happen(time, Event::Alarm(StopReason::LinkLost), now, out);
            self.note(Notice::LinkLost, now, out);
        }
        if !matches!(self.state.mode(), Mode::Learn { .. }) {
            self.happen(time, Event::Tick, now, out);
        }
        self.renew_motion(time, now, out);
    }

    /// Takes what a transducer of the chip's own ring heard, `age_ms` before `now`. Ignored while echoes come over the link.
    pub fn ring_echo(
        &mut self,
        sensor: u8,
        range: Option<Range>,
        age_ms: u32,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        if self.source == Source::Ring {
            let time = self.link.time(now).as_ms();
            let at = Millis::from_ms(time.wrapping_sub(age_ms));
            self.happen(at, Event::Echo { sensor, range }, now, out);
        }
    }

    /// Stops a robot that may move, for a reason the device has found.
    pub fn alarm(&mut self, reason: StopReason, now: Millis, out: &mut impl FrameSink) {
        self.happen(self.link.time(now), Event::Alarm(reason), now, out);
    }

    /// Ends the motion under way: a bumper of the device touched something.
    pub fn touched(&mut self, now: Millis, out: &mut impl FrameSink) {
        self.happen(self.link.time(now), Event::Touched, now, out);
    }

    fn renew_motion(&mut self, time: Millis, now: Millis, out: &mut impl FrameSink) {
        let moving = self.state.is_moving();
        if let Some(underway) = self.underway.filter(|_| moving)
            && time.since(underway.sent) >= RENEWAL_MS
        {
            self.underway = Some(Underway {
                sent: time,
                ..underway
            });
            self.order(underway.order, now, out);
        }
    }

    /// Hands an event to the mind and says what comes of it. Returns why a command was refused.
    fn happen(
        &mut self,
        at: Millis,
        event: Event<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Option<controller::Refusal> {
        let outputs = controller::handle(&self.config, &mut self.state, at, event);
        self.tell(&outputs, at, now, out);
        outputs.refusal
    }

    // Not a part of the stack of what the mind does.
    #[inline(never)]
    fn tell(
        &mut self,
        outputs: &Outputs<SENSORS>,
        at: Millis,
        now: Millis,
        out: &mut impl FrameSink,
    ) {
        if outputs.motion.is_some() || outputs.mode_changed {
            self.kept.overtake();
        }
        if let Some(verdict) = outputs.verdict {
            self.note(verdict.into(), now, out);
        }
        if let Some(age_ms) = outputs.stale_ms {
            self.count_stale(age_ms, now, out);
        }
        if let Some(decision) = outputs.decision {
            self.stale_reported = false;
            self.say(FromMind::Decision(decision), now, out);
        }
        if let Some(motion) = outputs.motion {
            let revision = match self.underway {
                Some(underway) if underway.order.id == motion.id => {
                    underway.order.revision.wrapping_add(1)
                }
                _ => 0,
            };
            let order = MotionOrder {
                id: motion.id,
                revision,
                dx_mm: motion.displacement.dx_mm,
                dy_mm: motion.displacement.dy_mm,
                speed_mm_s: motion.speed_mm_s,
                ttl_ms: MOTION_TTL_MS,
            };
            self.underway = Some(Underway { order, sent: at });
            self.order(order, now, out);
        }
        if outputs.mode_changed {
            let mode = ModeReport::from(self.state.mode());
            self.say(FromMind::Mode(mode), now, out);
        }
    }

    /// Counts a stale echo; reports the first one since the last decision.
    fn count_stale(&mut self, age_ms: u32, now: Millis, out: &mut impl FrameSink) {
        add(&mut self.counters.stale_echoes);
        if !core::mem::replace(&mut self.stale_reported, true) {
            self.note(Notice::StaleEcho { age_ms }, now, out);
        }
    }

    // These four lie apart: what they say is no part of the stack of what the mind does.
    #[inline(never)]
    fn order(&mut self, order: MotionOrder, now: Millis, out: &mut impl FrameSink) {
        self.say(FromMind::Motion(order), now, out);
    }

    #[inline(never)]
    fn refuse(&mut self, seq: u16, why: Refusal, now: Millis, out: &mut impl FrameSink) {
        add(&mut self.counters.refused);
        self.say(FromMind::Refusal { seq, why }, now, out);
    }

    #[inline(never)]
    fn done(&mut self, seq: u16, now: Millis, out: &mut impl FrameSink) {
        self.say(FromMind::Done { seq }, now, out);
    }

    #[inline(never)]
    fn note(&mut self, notice: Notice, now: Millis, out: &mut impl FrameSink) {
        self.say(FromMind::Log(notice), now, out);
    }

    // One copy of it in a program.
    #[inline(never)]
    fn say(&mut self, said: FromMind<SENSORS>, now: Millis, out: &mut impl FrameSink) {
        self.seq = self.seq.wrapping_add(1);
        let header = Header {
            session: self.link.session(),
            seq: self.seq,
        };
        let report = Report {
            device_ms: self.link.time(now).as_ms(),
            said,
        };
        let mut frame = Frame::EMPTY;
        let sent = frame.fill(header, &report).is_ok() && {
            self.kept.keep(frame.as_bytes());
            out.send(frame.as_bytes())
        };
        self.counters.count_sent(sent);
    }

    /// Sends the answer to the last frame once more, as it was; only confirms it if too much was said to be kept.
    fn say_again(&mut self, seq: u16, now: Millis, out: &mut impl FrameSink) {
        let mut frames = 0_u32;
        for frame in self.kept.frames() {
            self.counters.count_sent(out.send(frame));
            add(&mut frames);
        }
        if frames == 0 {
            self.done(seq, now, out);
        }
    }
}

impl Counters {
    /// One more frame that was taken, or not.
    const fn count_sent(&mut self, taken: bool) {
        let counter = if taken {
            &mut self.sent
        } else {
            &mut self.dropped
        };
        add(counter);
    }
}

/// Counts one more.
const fn add(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

#[cfg(test)]
mod tests;
