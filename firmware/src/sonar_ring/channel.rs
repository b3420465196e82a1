//! One ranging module behind a multiplexer, as a state machine: time and ECHO in, pin changes out.
//!
//! ```text
//!            ┌───────────────────── recycle over ─────────────────────┐
//!            ▼                                                        │
//! Recycle ─► SELECT ─► Settle ─► INIT ─► Blank ─► BINH ─► Listen ─► INIT low
//!                        │                 │                ▲  echo, or window over
//!                        └── ECHO high: held │                │
//!                            (no firing)     └── ECHO: early ─┘
//! ```
//!
//! The address changes only in `Recycle`, when INIT is low.

use super::timing::{
    Blanking, FiringOrder, MAX_LATE_US, RINGING_END_US, SELF_TEST_BINH_US, Timing,
};

/// A change of a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PinChange {
    /// Outputs the address of a transducer.
    Select(u8),
    /// INIT high sends the burst; low makes ECHO fall. The capture is armed before it rises.
    Init(bool),
    /// BINH high ends the module's internal blanking.
    Binh(bool),
}

/// State of the ECHO line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EchoLine {
    /// The line is high.
    pub high: bool,
    /// When the line rose after the capture was armed, microseconds.
    pub rose_us: Option<u32>,
}

/// Outcome of a firing.
///
/// In a self-test BINH rises while the membrane still rings, so ECHO must rise at once. A module
/// without supply, a disconnected transducer and a dead multiplexer stay silent; in a normal
/// firing silence means free space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FiringOutcome {
    /// Time of flight, less the channel's delay, microseconds.
    Echo(u32),
    /// ECHO did not rise within the window.
    NoEcho,
    /// ECHO rose before any echo can come.
    Early,
    /// ECHO was high before the firing, which was skipped.
    HeldHigh,
    /// ECHO has not fallen after the previous firing, whose own outcome is reported apart.
    NotReleased,
    /// The self-test has passed: the transducer listens from its next turn on.
    Ringing,
    /// The self-test has failed; it is repeated in the next turn.
    Mute,
}

/// The result of a firing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FiringResult {
    /// Transducer.
    pub sensor: u8,
    /// Outcome.
    pub outcome: FiringOutcome,
    /// Time of the firing, or of the skipped firing, microseconds.
    pub fired_us: u32,
}

/// What the caller has to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelStep {
    /// Change a pin, then poll again.
    Change(PinChange),
    /// Report a result, then poll again.
    Report(FiringResult),
    /// Poll again at this time, microseconds, or when ECHO rises.
    WaitUntil(u32),
    /// Nothing: the order is empty.
    Idle,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ChannelState {
    /// INIT is low until this time.
    Recycle(u32),
    /// The address is set; the relays settle until this time.
    Settle(u32),
    /// Fired; BINH has to rise.
    Blank,
    /// Fired; an echo may come.
    Listen,
    /// The firing is over: INIT falls, then BINH, then the outcome is reported.
    LowerInit(FiringOutcome),
    LowerBinh(FiringOutcome),
    Finish(FiringOutcome),
}

/// A channel: a module and its multiplexer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SonarChannel {
    timing: Timing,
    order: FiringOrder,
    state: ChannelState,
    position: u8,
    sensor: u8,
    fired_us: u32,
    /// When the next firing is due.
    due_us: u32,
    /// ECHO has fallen since the last firing, or its failure to fall was reported.
    released: bool,
    /// Bit k set: transducer k has passed its self-test, or needs none.
    passed: u16,
}

/// Whether `now` is `then` or later; correct while they are less than 35 minutes apart.
const fn reached(now: u32, then: u32) -> bool {
    now.wrapping_sub(then) < 1 << 31
}

impl SonarChannel {
    /// A channel that starts at `now_us` with all pins low.
    #[must_use]
    pub const fn new(timing: Timing, order: FiringOrder, now_us: u32) -> Self {
        let first = timing.recycle_us.wrapping_add(timing.settle_us);
        Self {
            timing,
            order,
            state: ChannelState::Recycle(now_us.wrapping_add(timing.recycle_us)),
            position: 0,
            sensor: 0,
            fired_us: now_us,
            due_us: now_us.wrapping_add(first).wrapping_add(timing.offset_us),
            released: true,
            passed: if timing.self_test { 0 } else { u16::MAX },
        }
    }

    /// Starts again at `now_us` with all pins low. Passed self-tests are not repeated.
    pub fn restart(&mut self, timing: Timing, order: FiringOrder, now_us: u32) {
        let passed = self.passed;
        *self = Self::new(timing, order, now_us);
        self.passed |= passed;
    }

    /// Whether a rise of ECHO has a meaning.
    #[must_use]
    pub const fn is_listening(&self) -> bool {
        matches!(self.state, ChannelState::Blank | ChannelState::Listen)
    }

    /// The next step at `now_us`, with ECHO in the state `line`.
    pub fn poll(&mut self, now_us: u32, line: EchoLine) -> ChannelStep {
        match self.state {
            ChannelState::Recycle(until) if !reached(now_us, until) => {
                ChannelStep::WaitUntil(until)
            }
            ChannelState::Recycle(_) => self.select(now_us, line),
            ChannelState::Settle(until) if !reached(now_us, until) => ChannelStep::WaitUntil(until),
            ChannelState::Settle(_) if !reached(now_us, self.due_us) => {
                ChannelStep::WaitUntil(self.due_us)
            }
            ChannelState::Settle(_) => self.fire(now_us, line),
            ChannelState::Blank => self.blank(now_us, line),
            ChannelState::Listen => self.listen(now_us, line),
            ChannelState::LowerInit(outcome) => {
                self.state = ChannelState::LowerBinh(outcome);
                ChannelStep::Change(PinChange::Init(false))
            }
            ChannelState::LowerBinh(outcome) => {
                self.state = ChannelState::Finish(outcome);
                ChannelStep::Change(PinChange::Binh(false))
            }
            ChannelState::Finish(outcome) => {
                self.state = ChannelState::Recycle(now_us.wrapping_add(self.timing.recycle_us));
                ChannelStep::Report(self.reading(outcome))
            }
        }
    }

    /// Whether this firing is a self-test.
    fn is_self_test(&self) -> bool {
        self.passed & self.bit() == 0
    }

    fn bit(&self) -> u16 {
        1_u16.checked_shl(self.sensor.into()).unwrap_or(0)
    }

    fn reading(&self, outcome: FiringOutcome) -> FiringResult {
        FiringResult {
            sensor: self.sensor,
            outcome,
            fired_us: self.fired_us,
        }
    }

    fn select(&mut self, now_us: u32, line: EchoLine) -> ChannelStep {
        if line.high && !self.released {
            self.released = true;
            return ChannelStep::Report(self.reading(FiringOutcome::NotReleased));
        }
        let Some((sensor, next)) = self.order.at(self.position) else {
            return ChannelStep::Idle;
        };
        (self.sensor, self.position) = (sensor, next);
        self.state = ChannelState::Settle(now_us.wrapping_add(self.timing.settle_us));
        ChannelStep::Change(PinChange::Select(sensor))
    }

    fn fire(&mut self, now_us: u32, line: EchoLine) -> ChannelStep {
        let late_us = now_us.wrapping_sub(self.due_us);
        // The firings keep to the grid of slots, however many were missed.
        let slots = (late_us / self.timing.slot_us()).wrapping_add(1);
        let next_us = slots.wrapping_mul(self.timing.slot_us());
        self.due_us = self.due_us.wrapping_add(next_us);
        if late_us > MAX_LATE_US {
            return ChannelStep::WaitUntil(self.due_us);
        }
        self.fired_us = now_us;
        if line.high {
            self.state = ChannelState::Recycle(now_us.wrapping_add(self.timing.recycle_us));
            return ChannelStep::Report(self.reading(FiringOutcome::HeldHigh));
        }
        self.released = false;
        self.state = ChannelState::Blank;
        ChannelStep::Change(PinChange::Init(true))
    }

    fn blank(&mut self, now_us: u32, line: EchoLine) -> ChannelStep {
        let us = match self.timing.blanking {
            _ if self.is_self_test() => SELF_TEST_BINH_US,
            Blanking::Until(us) => us,
            Blanking::Internal => {
                self.state = ChannelState::Listen;
                return self.listen(now_us, line);
            }
        };
        if line.high || line.rose_us.is_some() {
            return self.listen(now_us, line);
        }
        let until = self.fired_us.wrapping_add(us);
        if !reached(now_us, until) {
            return ChannelStep::WaitUntil(until);
        }
        self.state = ChannelState::Listen;
        ChannelStep::Change(PinChange::Binh(true))
    }

    fn listen(&mut self, now_us: u32, line: EchoLine) -> ChannelStep {
        if self.is_self_test() {
            return self.listen_for_ringing(now_us, line);
        }
        let until = self.fired_us.wrapping_add(self.timing.window_us);
        let outcome = match line.rose_us {
            Some(rose_us) => self.classify(rose_us.wrapping_sub(self.fired_us)),
            // The rise was not captured: it came around the time of the firing.
            None if line.high => FiringOutcome::Early,
            None if reached(now_us, until) => FiringOutcome::NoEcho,
            None => return ChannelStep::WaitUntil(until),
        };
        self.state = ChannelState::LowerInit(outcome);
        self.poll(now_us, line)
    }

    fn listen_for_ringing(&mut self, now_us: u32, line: EchoLine) -> ChannelStep {
        let until = self.fired_us.wrapping_add(RINGING_END_US);
        let rings = SELF_TEST_BINH_US..=RINGING_END_US;
        let outcome = match line.rose_us.map(|us| us.wrapping_sub(self.fired_us)) {
            Some(us) if rings.contains(&us) => FiringOutcome::Ringing,
            Some(us) if us > RINGING_END_US && us < 1 << 31 => FiringOutcome::Mute,
            Some(_) => FiringOutcome::Early,
            None if line.high => FiringOutcome::Early,
            None if reached(now_us, until) => FiringOutcome::Mute,
            None => return ChannelStep::WaitUntil(until),
        };
        if outcome == FiringOutcome::Ringing {
            self.passed |= self.bit();
        }
        self.state = ChannelState::LowerInit(outcome);
        self.poll(now_us, line)
    }

    /// The outcome of a rise at `flight_us`. A rise before the firing wraps to a very long time.
    fn classify(&self, flight_us: u32) -> FiringOutcome {
        if flight_us > 1 << 31 || flight_us < self.timing.blanking.us() {
            return FiringOutcome::Early;
        }
        if flight_us > self.timing.window_us {
            return FiringOutcome::NoEcho;
        }
        FiringOutcome::Echo(flight_us.saturating_sub(self.timing.delay_us.into()))
    }
}
