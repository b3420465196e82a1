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

use super::timing::{Blanking, FiringOrder, LATEST_US, RINGING_US, RUNG_US, Timing};

/// Something to be done to a pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Puts out the address of a transducer.
    Select(u8),
    /// Raises INIT, which sends the burst, or drops it, which drops ECHO. Before it is raised the capture is armed.
    Init(bool),
    /// Raises BINH, which ends the module's own blanking, or drops it.
    Binh(bool),
}

/// The ECHO line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Line {
    /// It is high.
    pub high: bool,
    /// When it rose after the capture was armed, microseconds.
    pub rose_us: Option<u32>,
}

/// What came of a firing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// An echo, so long after the firing, the channel's delay taken off; microseconds.
    Echo(u32),
    /// None within the window.
    Silent,
    /// ECHO rose before any echo can have come: not to be believed.
    Early,
    /// ECHO was high before the firing, which was left out.
    HeldHigh,
    /// ECHO has not fallen after the firing before; said in addition to that firing's own outcome.
    NotReleased,
    /// A self-test heard the membrane ring: the transducer listens from its next turn on.
    Rings,
    /// A self-test heard nothing: its module, supply, transducer or multiplexer is dead. It is tested again in its next turn.
    Mute,
}

/// What a transducer has to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    /// Transducer.
    pub sensor: u8,
    /// What came of its firing.
    pub outcome: Outcome,
    /// When it fired, or should have, microseconds.
    pub fired_us: u32,
}

/// What is to be done now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Todo {
    /// This, and then to ask again.
    Act(Action),
    /// To take this, and then to ask again.
    Take(Reading),
    /// Nothing before this time, microseconds, unless ECHO rises.
    Wait(u32),
    /// Nothing: the order is empty.
    Rest,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// INIT low, until then.
    Recycle(u32),
    /// The address stands, the relays swing, until then.
    Settle(u32),
    /// Fired; BINH to be raised.
    Blank,
    /// Fired; an echo may come.
    Listen,
    /// Heard or given up: INIT is to drop, then BINH, then the outcome is told.
    Drop(Outcome),
    Unblank(Outcome),
    Tell(Outcome),
}

/// A channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    timing: Timing,
    order: FiringOrder,
    state: State,
    place: u8,
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

impl Channel {
    /// A channel that begins at `now_us`, its pins all low.
    #[must_use]
    pub const fn new(timing: Timing, order: FiringOrder, now_us: u32) -> Self {
        let first = timing.recycle_us.wrapping_add(timing.settle_us);
        Self {
            timing,
            order,
            state: State::Recycle(now_us.wrapping_add(timing.recycle_us)),
            place: 0,
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
    pub const fn listens(&self) -> bool {
        matches!(self.state, State::Blank | State::Listen)
    }

    /// What is to be done at `now_us`, when the line is so.
    pub fn poll(&mut self, now_us: u32, line: Line) -> Todo {
        match self.state {
            State::Recycle(until) if !reached(now_us, until) => Todo::Wait(until),
            State::Recycle(_) => self.select(now_us, line),
            State::Settle(until) if !reached(now_us, until) => Todo::Wait(until),
            State::Settle(_) if !reached(now_us, self.due_us) => Todo::Wait(self.due_us),
            State::Settle(_) => self.fire(now_us, line),
            State::Blank => self.blank(now_us, line),
            State::Listen => self.listen(now_us, line),
            State::Drop(outcome) => {
                self.state = State::Unblank(outcome);
                Todo::Act(Action::Init(false))
            }
            State::Unblank(outcome) => {
                self.state = State::Tell(outcome);
                Todo::Act(Action::Binh(false))
            }
            State::Tell(outcome) => {
                self.state = State::Recycle(now_us.wrapping_add(self.timing.recycle_us));
                Todo::Take(self.reading(outcome))
            }
        }
    }

    /// Whether this firing is a self-test.
    fn tests(&self) -> bool {
        self.passed & self.bit() == 0
    }

    fn bit(&self) -> u16 {
        1_u16.checked_shl(self.sensor.into()).unwrap_or(0)
    }

    fn reading(&self, outcome: Outcome) -> Reading {
        Reading {
            sensor: self.sensor,
            outcome,
            fired_us: self.fired_us,
        }
    }

    fn select(&mut self, now_us: u32, line: Line) -> Todo {
        if line.high && !self.released {
            self.released = true;
            return Todo::Take(self.reading(Outcome::NotReleased));
        }
        let Some((sensor, next)) = self.order.at(self.place) else {
            return Todo::Rest;
        };
        (self.sensor, self.place) = (sensor, next);
        self.state = State::Settle(now_us.wrapping_add(self.timing.settle_us));
        Todo::Act(Action::Select(sensor))
    }

    fn fire(&mut self, now_us: u32, line: Line) -> Todo {
        let late_us = now_us.wrapping_sub(self.due_us);
        // On the grid, whatever has been missed.
        let slots = (late_us / self.timing.slot_us()).wrapping_add(1);
        let next_us = slots.wrapping_mul(self.timing.slot_us());
        self.due_us = self.due_us.wrapping_add(next_us);
        if late_us > LATEST_US {
            return Todo::Wait(self.due_us);
        }
        self.fired_us = now_us;
        if line.high {
            self.state = State::Recycle(now_us.wrapping_add(self.timing.recycle_us));
            return Todo::Take(self.reading(Outcome::HeldHigh));
        }
        self.released = false;
        self.state = State::Blank;
        Todo::Act(Action::Init(true))
    }

    fn blank(&mut self, now_us: u32, line: Line) -> Todo {
        let us = match self.timing.blanking {
            _ if self.tests() => RINGING_US,
            Blanking::Until(us) => us,
            Blanking::Internal => {
                self.state = State::Listen;
                return self.listen(now_us, line);
            }
        };
        if line.high || line.rose_us.is_some() {
            return self.listen(now_us, line);
        }
        let until = self.fired_us.wrapping_add(us);
        if !reached(now_us, until) {
            return Todo::Wait(until);
        }
        self.state = State::Listen;
        Todo::Act(Action::Binh(true))
    }

    fn listen(&mut self, now_us: u32, line: Line) -> Todo {
        if self.tests() {
            return self.listen_for_ringing(now_us, line);
        }
        let until = self.fired_us.wrapping_add(self.timing.window_us);
        let outcome = match line.rose_us {
            Some(rose_us) => self.judge(rose_us.wrapping_sub(self.fired_us)),
            // It rose unseen, around the firing.
            None if line.high => Outcome::Early,
            None if reached(now_us, until) => Outcome::Silent,
            None => return Todo::Wait(until),
        };
        self.state = State::Drop(outcome);
        self.poll(now_us, line)
    }

    fn listen_for_ringing(&mut self, now_us: u32, line: Line) -> Todo {
        let until = self.fired_us.wrapping_add(RUNG_US);
        let rings = RINGING_US..=RUNG_US;
        let outcome = match line.rose_us.map(|us| us.wrapping_sub(self.fired_us)) {
            Some(us) if rings.contains(&us) => Outcome::Rings,
            Some(us) if us > RUNG_US && us < 1 << 31 => Outcome::Mute,
            Some(_) => Outcome::Early,
            None if line.high => Outcome::Early,
            None if reached(now_us, until) => Outcome::Mute,
            None => return Todo::Wait(until),
        };
        if outcome == Outcome::Rings {
            self.passed |= self.bit();
        }
        self.state = State::Drop(outcome);
        self.poll(now_us, line)
    }

    /// An edge so long after the firing; one before it wraps to a very long time.
    fn judge(&self, flight_us: u32) -> Outcome {
        if flight_us > 1 << 31 || flight_us < self.timing.blanking.us() {
            return Outcome::Early;
        }
        if flight_us > self.timing.window_us {
            return Outcome::Silent;
        }
        Outcome::Echo(flight_us.saturating_sub(self.timing.delay_us.into()))
    }
}
