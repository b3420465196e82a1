//! One ranging module behind a multiplexer, as a state machine: time and the ECHO line in, pin changes and readings out.
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
//! The address changes in `Recycle` alone, and INIT is low there.
//!
//! A self-test is a firing whose BINH rises while the membrane still rings: ECHO has to rise at once. A module without supply, a
//! transducer without a contact and a dead multiplexer stay silent, which in a firing means free space.

use super::timing::{
    Blanking, FiringOrder, MAX_LATE_US, RINGING_END_US, SELF_TEST_BINH_US, Timing,
};

/// Something to be done to a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PinChange {
    /// Puts out the address of a transducer.
    Select(u8),
    /// Raises INIT, which sends the burst, or drops it, which drops ECHO. Before it is raised the capture is armed.
    Init(bool),
    /// Raises BINH, which ends the module's own blanking, or drops it.
    Binh(bool),
}

/// The ECHO line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EchoLine {
    /// It is high.
    pub high: bool,
    /// When it rose after the capture was armed, microseconds.
    pub rose_us: Option<u32>,
}

/// What came of a firing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FiringOutcome {
    /// An echo, so long after the firing, the channel's delay taken off; microseconds.
    Echo(u32),
    /// None within the window.
    NoEcho,
    /// ECHO rose before any echo can have come: not to be believed.
    Early,
    /// ECHO was high before the firing, which was left out.
    HeldHigh,
    /// ECHO has not fallen after the firing before; said in addition to that firing's own outcome.
    NotReleased,
    /// A self-test heard the membrane ring: the transducer listens from its next turn on.
    Ringing,
    /// A self-test heard nothing: its module, supply, transducer or multiplexer is dead. It is tested again in its next turn.
    Mute,
}

/// What a transducer has to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FiringResult {
    /// Transducer.
    pub sensor: u8,
    /// What came of its firing.
    pub outcome: FiringOutcome,
    /// When it fired, or should have, microseconds.
    pub fired_us: u32,
}

/// What is to be done now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelStep {
    /// This, and then to ask again.
    Change(PinChange),
    /// To take this, and then to ask again.
    Report(FiringResult),
    /// Nothing before this time, microseconds, unless ECHO rises.
    WaitUntil(u32),
    /// Nothing: the order is empty.
    Idle,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ChannelState {
    /// INIT low, until then.
    Recycle(u32),
    /// The address stands, the relays swing, until then.
    Settle(u32),
    /// Fired; BINH to be raised.
    Blank,
    /// Fired; an echo may come.
    Listen,
    /// Heard or given up: INIT is to drop, then BINH, then the outcome is told.
    LowerInit(FiringOutcome),
    LowerBinh(FiringOutcome),
    Finish(FiringOutcome),
}

/// A channel.
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
    /// ECHO need not fall any more, or has been told not to have fallen.
    released: bool,
    /// Transducers that need no self-test, or have passed it, by their bits.
    passed: u16,
}

/// Whether `now` has come to `then`; right while the two are less than 35 minutes apart.
const fn reached(now: u32, then: u32) -> bool {
    now.wrapping_sub(then) < 1 << 31
}

impl SonarChannel {
    /// A channel that begins at `now_us`, its pins all low.
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

    /// Begins anew at `now_us`, its pins all low; who has passed the self-test is not tested again.
    pub fn restart(&mut self, timing: Timing, order: FiringOrder, now_us: u32) {
        let passed = self.passed;
        *self = Self::new(timing, order, now_us);
        self.passed |= passed;
    }

    /// Whether a rise of ECHO means something.
    #[must_use]
    pub const fn is_listening(&self) -> bool {
        matches!(self.state, ChannelState::Blank | ChannelState::Listen)
    }

    /// What is to be done at `now_us`, when the line is so.
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
        // On the grid, whatever has been missed.
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
            // It rose unseen, around the firing.
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

    /// An edge so long after the firing; one before it wraps to a very long time.
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
