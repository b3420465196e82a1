//! The ring of sonars at the chip's own pins: Polaroid 6500 ranging modules behind multiplexers.
//!
//! | module | what it decides |
//! |---|---|
//! | [`timing`] | durations, firing order, range of a flight time |
//! | [`channel`] | pin changes of a module over time, as a pure state machine |
//!
//! | ECHO | outcome | reported to the node |
//! |---|---|---|
//! | rises within the window | [`FiringOutcome::Echo`] | the range |
//! | stays low | [`FiringOutcome::NoEcho`] | that nothing answered |
//! | rises before any echo can come | [`FiringOutcome::Early`] | – |
//! | is high before the firing | [`FiringOutcome::HeldHigh`] | – |
//! | has not fallen after the firing | [`FiringOutcome::NotReleased`] | – |
//! | rises during the ringing, in a self-test | [`FiringOutcome::Ringing`] | – |
//! | stays low, in a self-test | [`FiringOutcome::Mute`] | – |
//!
//! A transducer that reports nothing leaves the ring incomplete: the robot stands until it reports
//! again or is disabled. The self-test at the start finds a line stuck low and a dead transducer.
//! Later these look like silence, and a stuck multiplexer looks like echoes; [`amp::faults`]
//! detects them.

use crate::uart::ErrorCounters;
use amp::units::{Millis, Range};
use embedded_hal::digital::OutputPin;
use heapless::spsc::Producer;

pub mod channel;
pub mod timing;

pub use channel::{ChannelStep, EchoLine, FiringOutcome, FiringResult, PinChange, SonarChannel};
pub use timing::{Blanking, FiringOrder, SENSORS, SpeedOfSound, Timing};

/// A microsecond clock that captures the time at which ECHO rises.
pub trait EchoCapture {
    /// Time, microseconds; wraps after 71 minutes.
    fn now_us(&mut self) -> u32;
    /// Forgets the captured time and waits for the next rise.
    fn arm(&mut self);
    /// State of the ECHO line.
    fn echo_line(&mut self) -> EchoLine;
}

/// The pins of a module and its multiplexer.
#[derive(Debug)]
pub struct RingPins<P> {
    /// The address, lowest bit first.
    pub address: [P; 4],
    /// High: sends the burst and listens. Low: ends listening.
    pub init: P,
    /// High: ends the module's internal blanking.
    pub binh: P,
    /// Stays low. High would re-arm ECHO for a second echo.
    pub blnk: P,
}

/// A channel and its pins.
#[derive(Debug)]
pub struct ChannelDriver<P> {
    pins: RingPins<P>,
    channel: SonarChannel,
}

impl<P: OutputPin> ChannelDriver<P> {
    /// A driver that starts at `now_us` with all pins low.
    ///
    /// # Errors
    /// A pin cannot be set.
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

    /// Sets all pins low and starts again at `now_us`. Passed self-tests are not repeated.
    ///
    /// # Errors
    /// A pin cannot be set.
    pub fn restart(
        &mut self,
        timing: Timing,
        order: FiringOrder,
        now_us: u32,
    ) -> Result<(), P::Error> {
        self.channel.restart(timing, order, now_us);
        self.pins.set_all_low()
    }

    /// Does what is due, without waiting, and passes each result to `report`. Returns the time of
    /// the next call, microseconds, or earlier if ECHO rises; `None` if the order is empty.
    ///
    /// # Errors
    /// A pin cannot be set; the channel's state has advanced nevertheless.
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

    /// Returns the pins.
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

/// A reading for the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RingReading {
    /// Transducer.
    pub sensor: u8,
    /// Range; `None` = nothing answered.
    pub range: Option<Range>,
    /// Time of the firing.
    pub at: Millis,
}

/// A channel driver that fires on request and queues its readings.
pub struct SonarRing<'queue, P> {
    driver: ChannelDriver<P>,
    timing: Timing,
    sound: SpeedOfSound,
    readings: Producer<'queue, RingReading>,
    errors: &'queue ErrorCounters,
    runs: bool,
}

impl<'queue, P: OutputPin> SonarRing<'queue, P> {
    /// A resting ring in the Nomad's order. `errors` counts line faults and dropped readings.
    #[must_use]
    pub const fn new(
        driver: ChannelDriver<P>,
        timing: Timing,
        sound: SpeedOfSound,
        readings: Producer<'queue, RingReading>,
        errors: &'queue ErrorCounters,
    ) -> Self {
        Self {
            driver,
            timing,
            sound,
            readings,
            errors,
            runs: false,
        }
    }

    /// Whether a rise of ECHO must call `serve`: only between a firing and its end. So a line that
    /// oscillates at other times causes no interrupts.
    #[must_use]
    pub const fn is_listening(&self) -> bool {
        self.runs && self.driver.channel.is_listening()
    }

    /// Does what is due at `now`, the device's time at the moment of the call. Returns the time of
    /// the next call on the capture's clock; `None` while the ring is not wanted.
    ///
    /// # Errors
    /// A pin cannot be set.
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
        let (sound, readings, errors) = (self.sound, &mut self.readings, self.errors);
        self.driver.run(capture, |reading| {
            let age_ms = now_us.wrapping_sub(reading.fired_us) / 1_000;
            let queued = match reading.outcome.report(sound) {
                // The queue is full if the node has not run for 1 s: the ring stays incomplete.
                EchoReport::Range(range) => readings.enqueue(RingReading {
                    sensor: reading.sensor,
                    range,
                    at: Millis::from_ms(now.as_ms().wrapping_sub(age_ms)),
                }),
                EchoReport::Fault => return errors.count_ring_fault(),
                EchoReport::Nothing => return,
            };
            if queued.is_err() {
                errors.count_ring_fault();
            }
        })
    }
}

/// What a firing reports to the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EchoReport {
    /// A range; `None` = nothing answered.
    Range(Option<Range>),
    /// Nothing: a line fault, to be counted.
    Fault,
    /// Nothing: a passed self-test.
    Nothing,
}

impl FiringOutcome {
    /// The report, at this speed of sound.
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
