//! The ring of sonars at the chip's own pins: Polaroid 6500 ranging modules behind 4-bit multiplexers.
//!
//! | module | what it decides |
//! |---|---|
//! | [`timing`] | how long everything takes, who fires when, what a flight means |
//! | [`channel`] | what a module's pins do and when: a pure state machine |
//!
//! A [`ChannelDriver`] is a channel with its pins. It runs when its time has come or ECHO has risen, does what is due and says when
//! to come again; it never waits. What each fault of the line ends in:
//!
//! | the line | told as | the mind hears |
//! |---|---|---|
//! | rises within the window | [`FiringOutcome::Echo`] | the range |
//! | stays low | [`FiringOutcome::NoEcho`] | that nothing answered |
//! | rises before any echo can come | [`FiringOutcome::Early`] | nothing |
//! | is high before the firing | [`FiringOutcome::HeldHigh`] | nothing |
//! | has not fallen after the firing | [`FiringOutcome::NotReleased`] | nothing more |
//! | rises during the ringing, in a self-test | [`FiringOutcome::Ringing`] | nothing yet |
//! | does not, in a self-test | [`FiringOutcome::Mute`] | nothing |
//!
//! A transducer of which the mind hears nothing leaves the ring incomplete, and the robot stands until it is heard again or
//! is no longer believed. A line that is stuck low or a dead transducer does not pass the self-test at the start; later, and like a
//! multiplexer stuck at an address, they look like echoes or silence to the pins: the mind's own watch over its transducers
//! ([`amp::faults`]) is what notices them.

use crate::uart::ErrorCounters;
use amp::units::{Millis, Range};
use embedded_hal::digital::OutputPin;
use heapless::spsc::Producer;

pub mod channel;
pub mod timing;

pub use channel::{ChannelStep, EchoLine, FiringOutcome, FiringResult, PinChange, SonarChannel};
pub use timing::{Blanking, FiringOrder, SENSORS, SpeedOfSound, Timing};

/// A clock that runs in microseconds and catches the moment at which ECHO rises.
pub trait EchoCapture {
    /// Microseconds, wrapping after 71 minutes.
    fn now_us(&mut self) -> u32;
    /// Forgets what was caught; from now on the next rise is.
    fn arm(&mut self);
    /// The line as it is.
    fn echo_line(&mut self) -> EchoLine;
}

/// The pins of a module and its multiplexer.
#[derive(Debug)]
pub struct RingPins<P> {
    /// The address, lowest bit first.
    pub address: [P; 4],
    /// Starts a burst, and ends the listening when it drops.
    pub init: P,
    /// Ends the blanking early.
    pub binh: P,
    /// Would re-arm ECHO for a second echo; low for good.
    pub blnk: P,
}

/// A channel and its pins.
#[derive(Debug)]
pub struct ChannelDriver<P> {
    pins: RingPins<P>,
    channel: SonarChannel,
}

impl<P: OutputPin> ChannelDriver<P> {
    /// A driver that begins at `now_us`, all its pins low.
    ///
    /// # Errors
    /// When a pin cannot be set.
    pub fn new(
        mut pins: RingPins<P>,
        timing: Timing,
        order: FiringOrder,
        now_us: u32,
    ) -> Result<Self, P::Error> {
        pins.set_all_low()?;
        Ok(Self {
            pins,
            channel: SonarChannel::new(timing, order, now_us),
        })
    }

    /// Drops every line and begins anew at `now_us`. Modules that have passed the self-test are not tested again.
    ///
    /// # Errors
    /// When a pin cannot be set.
    pub fn restart(
        &mut self,
        timing: Timing,
        order: FiringOrder,
        now_us: u32,
    ) -> Result<(), P::Error> {
        self.channel.restart(timing, order, now_us);
        self.pins.set_all_low()
    }

    /// Does what is due. Every reading goes to `report`. Returns when to come again, microseconds, unless ECHO rises before;
    /// `None` if the order is empty.
    ///
    /// # Errors
    /// When a pin cannot be set; the channel then goes on as if it had been.
    pub fn run(
        &mut self,
        capture: &mut impl EchoCapture,
        mut report: impl FnMut(FiringResult),
    ) -> Result<Option<u32>, P::Error> {
        loop {
            let line = capture.echo_line();
            match self.channel.poll(capture.now_us(), line) {
                ChannelStep::Change(action) => {
                    if action == PinChange::Init(true) {
                        capture.arm();
                    }
                    self.pins.apply(action)?;
                }
                ChannelStep::Report(reading) => report(reading),
                ChannelStep::WaitUntil(until_us) => return Ok(Some(until_us)),
                ChannelStep::Idle => return Ok(None),
            }
        }
    }

    /// The pins.
    #[must_use]
    pub fn into_pins(self) -> RingPins<P> {
        self.pins
    }
}

impl<P: OutputPin> RingPins<P> {
    fn set_all_low(&mut self) -> Result<(), P::Error> {
        self.init.set_low()?;
        self.binh.set_low()?;
        self.blnk.set_low()?;
        self.apply(PinChange::Select(0))
    }

    fn apply(&mut self, action: PinChange) -> Result<(), P::Error> {
        match action {
            PinChange::Select(sensor) => {
                for (bit, pin) in self.address.iter_mut().enumerate() {
                    pin.set_state((sensor >> bit & 1 == 1).into())?;
                }
                Ok(())
            }
            PinChange::Init(high) => self.init.set_state(high.into()),
            PinChange::Binh(high) => self.binh.set_state(high.into()),
        }
    }
}

/// What a transducer has to say to the mind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RingReading {
    /// Transducer.
    pub sensor: u8,
    /// What it heard; `None` = nothing answered.
    pub range: Option<Range>,
    /// When it fired.
    pub at: Millis,
}

/// A driver that fires while it is wanted and fills a queue.
pub struct SonarRing<'queue, P> {
    driver: ChannelDriver<P>,
    timing: Timing,
    sound: SpeedOfSound,
    firings: Producer<'queue, RingReading>,
    errors: &'queue ErrorCounters,
    runs: bool,
}

impl<'queue, P: OutputPin> SonarRing<'queue, P> {
    /// A ring at rest, in the Nomad's order. It counts in `errors` what its line spoils and what there is no room for.
    #[must_use]
    pub const fn new(
        driver: ChannelDriver<P>,
        timing: Timing,
        sound: SpeedOfSound,
        firings: Producer<'queue, RingReading>,
        errors: &'queue ErrorCounters,
    ) -> Self {
        Self {
            driver,
            timing,
            sound,
            firings,
            errors,
            runs: false,
        }
    }

    /// Whether it is to be served when ECHO rises as well: from a firing on until its end. A line that rings at other times
    /// brings no interrupt.
    #[must_use]
    pub const fn is_listening(&self) -> bool {
        self.runs && self.driver.channel.is_listening()
    }

    /// Does what is due at `now`, the time of the moment the capture's clock shows. Returns when to come again, on that
    /// clock; `None` while the ring is not wanted.
    ///
    /// # Errors
    /// When a pin cannot be set.
    pub fn serve(
        &mut self,
        capture: &mut impl EchoCapture,
        now: Millis,
        wanted: bool,
    ) -> Result<Option<u32>, P::Error> {
        let now_us = capture.now_us();
        if wanted != self.runs {
            self.runs = wanted;
            self.driver
                .restart(self.timing, FiringOrder::NOMAD, now_us)?;
        }
        if !wanted {
            return Ok(None);
        }
        let (sound, firings, errors) = (self.sound, &mut self.firings, self.errors);
        self.driver.run(capture, |reading| {
            let age_ms = now_us.wrapping_sub(reading.fired_us) / 1_000;
            let told = match reading.outcome.report(sound) {
                // No room: the mind has not looked for a second. The ring stays incomplete.
                EchoReport::Range(range) => firings.enqueue(RingReading {
                    sensor: reading.sensor,
                    range,
                    at: Millis::from_ms(now.as_ms().wrapping_sub(age_ms)),
                }),
                EchoReport::Fault => return errors.count_ring_fault(),
                EchoReport::Nothing => return,
            };
            if told.is_err() {
                errors.count_ring_fault();
            }
        })
    }
}

/// What the mind is told of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EchoReport {
    /// A range, or that nothing answered.
    Range(Option<Range>),
    /// The line was at fault: nothing.
    Fault,
    /// Nothing, and nothing is wrong.
    Nothing,
}

impl FiringOutcome {
    /// What the mind is told, at this speed of sound.
    #[must_use]
    pub fn report(self, sound: SpeedOfSound) -> EchoReport {
        match self {
            Self::Echo(flight_us) => EchoReport::Range(sound.range(flight_us)),
            Self::NoEcho => EchoReport::Range(None),
            Self::Early | Self::HeldHigh | Self::NotReleased | Self::Mute => EchoReport::Fault,
            Self::Ringing => EchoReport::Nothing,
        }
    }
}

#[cfg(test)]
mod tests;
