//! The controller behind a link: frames in, frames out, the same on the chip and in the simulator.
//!
//! [`Node::frame`] takes a received frame, does what it asks for and sends the answers.
//! [`Node::tick`] lets time pass: a slice of learning, the supervision of link and ring, motions
//! renewed before they expire. Every accepted frame but a sign of life is answered with its results
//! and then [`DeviceMessage::Done`](crate::wire::DeviceMessage::Done). A body that
//! [thinks](Body::think) first answers when it has decided. When the last accepted frame is
//! repeated, its answer is sent again byte for byte, and nothing is done twice.
//!
//! When the host falls silent for longer than [`SILENCE_MS`](crate::link::SILENCE_MS) the robot
//! stops with [`StopReason::LinkLost`] and stays stopped until the host resumes it.

use crate::body::{Body, HeldRing};
use crate::config::{Config, MAX_CONFIG};
use crate::controller::{self, Event, Mode, State, StopReason};
use crate::goal::{Goal, NamedGoals};
use crate::link::Link;
use crate::som::Grid;
use crate::som::kernels::Kernels;
use crate::units::{Millis, Range};
use crate::wire::frame::Header;
use crate::wire::message::{
    Clock, Counters, DeviceCounters, LogEvent, MotionCommand, Oscillator, ResetCause, Source,
};
use flash_requests::FlashRequest;
use heapless::Vec;
use reply_cache::ReplyCache;
use transfer::StagedPart;

mod configuration;
mod flash_requests;
mod replies;
mod reply_cache;
mod requests;
mod session;
mod transfer;

/// Time to live of a motion, milliseconds: a base that hears nothing for this long stops.
pub const MOTION_TTL_MS: u16 = 500;
/// A motion under way is sent again after this time, milliseconds.
pub(crate) const RENEWAL_MS: u32 = 200;

/// Takes frames on their way to the host.
pub trait FrameSink {
    /// Takes a whole frame, zero included, or none of it.
    fn send(&mut self, frame: &[u8]) -> bool;
}

/// Identity of a node, sent in its hello.
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
    command: MotionCommand,
    sent: Millis,
}

/// A controller behind a link, for a robot with this body.
#[derive(Debug, Clone)]
pub struct Node<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B = HeldRing> {
    config: Config<SENSORS>,
    body: B,
    state: State<SENSORS, NEURONS, SAMPLES>,
    goal: Goal<SENSORS>,
    goals: NamedGoals<SENSORS>,
    flash: FlashRequest,
    identity: Identity,
    source: Source,
    link: Link,
    /// Header of the hello that opened the session.
    opened_by: Header,
    seq: u16,
    underway: Option<Underway>,
    counters: Counters,
    reply_cache: ReplyCache,
    /// The request that is answered when the body has thought.
    unanswered: Option<u16>,
    /// A stale echo was reported since the last decision.
    stale_reported: bool,
    /// The received part of an uploaded configuration or body.
    staged: Vec<u8, MAX_CONFIG>,
    staged_part: StagedPart,
}

/// The node of the Nomad 200 with the paper's sizes.
pub type NomadNode = Node<16, 16, 100>;

#[cfg(not(feature = "graph"))]
const _: () = assert!(size_of::<controller::NomadState>() <= 8_704);

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>> Default
    for Node<SENSORS, NEURONS, SAMPLES, B>
{
    fn default() -> Self {
        Self::new()
    }
}

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize, B: Body<SENSORS>>
    Node<SENSORS, NEURONS, SAMPLES, B>
{
    /// A node before [`start`](Self::start): no transducer is enabled, no goal is set. It is all
    /// zeros, so a static one takes no flash.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            config: Config::zeroed(),
            body: B::NEW,
            state: State::new(Grid::rectangle(1, 1)),
            goal: Goal::zeroed(),
            goals: NamedGoals::new(),
            flash: FlashRequest::NONE,
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
            reply_cache: ReplyCache::new(),
            unanswered: None,
            stale_reported: false,
            staged: Vec::new(),
            staged_part: StagedPart::Config,
        }
    }

    /// Uses CPU-specific kernels: see [`State::use_kernels`].
    pub fn use_kernels(&mut self, kernels: &'static Kernels) {
        self.state.use_kernels(kernels);
    }

    /// Begins with this configuration and maps on this grid, which should have `NEURONS` places.
    /// Sends a hello in session 0.
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

    /// The configuration.
    #[must_use]
    pub const fn config(&self) -> &Config<SENSORS> {
        &self.config
    }

    /// The robot's body.
    #[must_use]
    pub const fn body(&self) -> &B {
        &self.body
    }

    /// The controller's state.
    #[must_use]
    pub const fn state(&self) -> &State<SENSORS, NEURONS, SAMPLES> {
        &self.state
    }

    /// The counters.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The counters that the device updates.
    pub const fn device_counters(&mut self) -> &mut DeviceCounters {
        &mut self.counters.device
    }

    /// Sets the number of frames that were too long for the receiver.
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

    /// Whether a host is there and was heard within [`SILENCE_MS`](crate::link::SILENCE_MS) before
    /// `now`, by the device's clock in every session.
    #[must_use]
    pub const fn has_heard_host(&self, now: Millis) -> bool {
        self.link.has_heard(now)
    }

    /// Lets time pass. Returns whether there is more to do at once.
    pub fn tick(&mut self, now: Millis, out: &mut impl FrameSink) -> bool {
        let time = self.link.time(now);
        if self.thinks() {
            self.dispatch(time, Event::Tick, now, out);
        } else if self.link.clock() == Clock::Device {
            self.watch(time, now, out);
        }
        if self.body.is_thinking() {
            let outputs = self.body.think(&self.config, &mut self.state, time);
            self.publish(&outputs, time, now, out);
        }
        if !self.body.is_thinking() {
            self.answer_request(now, out);
        }
        self.thinks() || self.body.is_thinking()
    }

    /// Whether it stands and has something to work out, tick by tick.
    const fn thinks(&self) -> bool {
        matches!(self.state.mode(), Mode::Learn { .. } | Mode::Calibrate)
    }

    /// Supervises link, motion and ring at `time` by the session's clock, and renews the motion.
    fn watch(&mut self, time: Millis, now: Millis, out: &mut impl FrameSink) {
        if self.link.falls_silent(time) {
            add(&mut self.counters.link_losses);
            self.dispatch(time, Event::Alarm(StopReason::LinkLost), now, out);
            self.log(LogEvent::LinkLost, now, out);
        }
        if !self.thinks() {
            self.dispatch(time, Event::Tick, now, out);
        }
        self.renew_motion(time, now, out);
    }

    /// Takes an echo of the device's own ring, heard `age_ms` before `now`. Ignored while echoes
    /// come over the link.
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
            self.dispatch(at, Event::Echo { sensor, range }, now, out);
        }
    }

    /// Stops a robot that may move, for a reason found by the device.
    pub fn alarm(&mut self, reason: StopReason, now: Millis, out: &mut impl FrameSink) {
        self.dispatch(self.link.time(now), Event::Alarm(reason), now, out);
    }

    /// Ends the motion under way because a bumper of the device touched something.
    pub fn touched(&mut self, now: Millis, out: &mut impl FrameSink) {
        self.dispatch(self.link.time(now), Event::Touched, now, out);
    }

    /// Hands an event to the controller and sends its outputs. Returns why a command was refused.
    fn dispatch(
        &mut self,
        at: Millis,
        event: Event<SENSORS>,
        now: Millis,
        out: &mut impl FrameSink,
    ) -> Option<controller::CommandRefusal> {
        let outputs = self.body.handle(&self.config, &mut self.state, at, event);
        self.publish(&outputs, at, now, out);
        outputs.refusal
    }
}

/// Counts one more.
const fn add(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

#[cfg(test)]
mod tests;
