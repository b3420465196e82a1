//! The ring of sonars at the chip's own pins: Polaroid 6500 ranging modules behind 4-bit multiplexers.
//!
//! | module | what it decides |
//! |---|---|
//! | [`timing`] | how long everything takes, who fires when, what a flight means |
//! | [`channel`] | what a module's pins do and when: a pure state machine |
//!
//! A [`Driver`] is a channel with its pins. It runs when its time has come or ECHO has risen, does what is due and says when
//! to come again; it never waits. What each fault of the line ends in:
//!
//! | the line | told as | the mind hears |
//! |---|---|---|
//! | rises within the window | [`Outcome::Echo`] | the range |
//! | stays low | [`Outcome::Silent`] | that nothing answered |
//! | rises before any echo can come | [`Outcome::Early`] | nothing |
//! | is high before the firing | [`Outcome::HeldHigh`] | nothing |
//! | has not fallen after the firing | [`Outcome::NotReleased`] | nothing more |
//! | rises during the ringing, in a self-test | [`Outcome::Rings`] | nothing yet |
//! | does not, in a self-test | [`Outcome::Mute`] | nothing |
//!
//! A transducer of which the mind hears nothing leaves the ring incomplete, and the robot stands until it is heard again or
//! is no longer believed. A line that is stuck low or a dead transducer does not pass the self-test at the start; later, and like a
//! multiplexer stuck at an address, they look like echoes or silence to the pins: the mind's own watch over its transducers
//! ([`amp::faults`]) is what notices them.

use crate::line::Faults;
use amp::units::{Millis, Range};
use embedded_hal::digital::OutputPin;
use heapless::spsc::Producer;

pub mod channel;
pub mod timing;

pub use channel::{Action, Channel, Line, Outcome, Reading, Todo};
pub use timing::{Blanking, FiringOrder, SENSORS, Sound, Timing};

/// A clock that runs in microseconds and catches the moment at which ECHO rises.
pub trait Capture {
    /// Microseconds, wrapping after 71 minutes.
    fn now_us(&mut self) -> u32;
    /// Forgets what was caught; from now on the next rise is.
    fn arm(&mut self);
    /// The line as it is.
    fn line(&mut self) -> Line;
}

/// The pins of a module and its multiplexer.
#[derive(Debug)]
pub struct Pins<P> {
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
pub struct Driver<P> {
    pins: Pins<P>,
    channel: Channel,
}

impl<P: OutputPin> Driver<P> {
    /// A driver that begins at `now_us`, all its pins low.
    ///
    /// # Errors
    /// When a pin cannot be set.
    pub fn new(
        mut pins: Pins<P>,
        timing: Timing,
        order: FiringOrder,
        now_us: u32,
    ) -> Result<Self, P::Error> {
        pins.rest()?;
        Ok(Self {
            pins,
            channel: Channel::new(timing, order, now_us),
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
        self.pins.rest()
    }

    /// Does what is due. Every reading goes to `take`. Returns when to come again, microseconds, unless ECHO rises before;
    /// `None` if the order is empty.
    ///
    /// # Errors
    /// When a pin cannot be set; the channel then goes on as if it had been.
    pub fn run(
        &mut self,
        capture: &mut impl Capture,
        mut take: impl FnMut(Reading),
    ) -> Result<Option<u32>, P::Error> {
        loop {
            let line = capture.line();
            match self.channel.poll(capture.now_us(), line) {
                Todo::Act(action) => {
                    if action == Action::Init(true) {
                        capture.arm();
                    }
                    self.pins.act(action)?;
                }
                Todo::Take(reading) => take(reading),
                Todo::Wait(until_us) => return Ok(Some(until_us)),
                Todo::Rest => return Ok(None),
            }
        }
    }

    /// The pins.
    #[must_use]
    pub fn release(self) -> Pins<P> {
        self.pins
    }
}

impl<P: OutputPin> Pins<P> {
    fn rest(&mut self) -> Result<(), P::Error> {
        self.init.set_low()?;
        self.binh.set_low()?;
        self.blnk.set_low()?;
        self.act(Action::Select(0))
    }

    fn act(&mut self, action: Action) -> Result<(), P::Error> {
        match action {
            Action::Select(sensor) => {
                for (bit, pin) in self.address.iter_mut().enumerate() {
                    pin.set_state((sensor >> bit & 1 == 1).into())?;
                }
                Ok(())
            }
            Action::Init(high) => self.init.set_state(high.into()),
            Action::Binh(high) => self.binh.set_state(high.into()),
        }
    }
}

/// What a transducer has to say to the mind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Firing {
    /// Transducer.
    pub sensor: u8,
    /// What it heard; `None` = nothing answered.
    pub range: Option<Range>,
    /// When it fired.
    pub at: Millis,
}

/// A driver that fires while it is wanted and fills a queue.
pub struct Ring<'queue, P> {
    driver: Driver<P>,
    timing: Timing,
    sound: Sound,
    firings: Producer<'queue, Firing>,
    faults: &'queue Faults,
    runs: bool,
}

impl<'queue, P: OutputPin> Ring<'queue, P> {
    /// A ring at rest, in the Nomad's order. It counts in `faults` what its line spoils and what there is no room for.
    #[must_use]
    pub const fn new(
        driver: Driver<P>,
        timing: Timing,
        sound: Sound,
        firings: Producer<'queue, Firing>,
        faults: &'queue Faults,
    ) -> Self {
        Self {
            driver,
            timing,
            sound,
            firings,
            faults,
            runs: false,
        }
    }

    /// Whether it is to be served when ECHO rises as well: from a firing on until its end. A line that rings at other times
    /// brings no interrupt.
    #[must_use]
    pub const fn listens(&self) -> bool {
        self.runs && self.driver.channel.listens()
    }

    /// Does what is due at `now`, the time of the moment the capture's clock shows. Returns when to come again, on that
    /// clock; `None` while the ring is not wanted.
    ///
    /// # Errors
    /// When a pin cannot be set.
    pub fn serve(
        &mut self,
        capture: &mut impl Capture,
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
        let (sound, firings, faults) = (self.sound, &mut self.firings, self.faults);
        self.driver.run(capture, |reading| {
            let age_ms = now_us.wrapping_sub(reading.fired_us) / 1_000;
            let told = match reading.outcome.heard(sound) {
                // No room: the mind has not looked for a second. The ring stays incomplete.
                Heard::Range(range) => firings.enqueue(Firing {
                    sensor: reading.sensor,
                    range,
                    at: Millis::from_ms(now.as_ms().wrapping_sub(age_ms)),
                }),
                Heard::Fault => return faults.spoil(),
                Heard::Nothing => return,
            };
            if told.is_err() {
                faults.spoil();
            }
        })
    }
}

/// What the mind is told of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard {
    /// A range, or that nothing answered.
    Range(Option<Range>),
    /// The line was at fault: nothing.
    Fault,
    /// Nothing, and nothing is wrong.
    Nothing,
}

impl Outcome {
    /// What the mind is told, at this speed of sound.
    #[must_use]
    pub fn heard(self, sound: Sound) -> Heard {
        match self {
            Self::Echo(flight_us) => Heard::Range(sound.range(flight_us)),
            Self::Silent => Heard::Range(None),
            Self::Early | Self::HeldHigh | Self::NotReleased | Self::Mute => Heard::Fault,
            Self::Rings => Heard::Nothing,
        }
    }
}

#[cfg(test)]
mod tests;
