//! The control task: received bytes and passing time in, frames out. It owns the mind.
//!
//! It is not paced: it runs when a frame has come, when the clock says that time has passed, and again at once while there
//! is more to do. Learning is done in slices between events, so that an event waits for one slice at most.

use crate::line::{Faults, FrameSink};
use crate::persist::{NoFlash, Store};
use crate::safety::Alarms;
use crate::sonar_ring::Firing;
use amp::config::Config;
use amp::controller::{Mode, StopReason};
use amp::node::{Identity, NomadNode};
use amp::som::Grid;
use amp::units::Millis;
use amp::wire::Receiver;
use amp::wire::message::{Flash, FlashError, Source};
use embedded_storage::nor_flash::NorFlash;
use heapless::spsc::Consumer;

/// Starts the mind of the Nomad 200 with the recommended configuration: 16 transducers, 16 neurons to a map, a hundred
/// samples. It says hello.
pub fn start(
    mind: &mut NomadNode,
    identity: Identity,
    now: Millis,
    out: &mut impl amp::node::FrameSink,
) {
    prepare(mind, identity);
    mind.hello(now, out);
}

fn prepare(mind: &mut NomadNode, identity: Identity) {
    mind.prepare(&Config::recommended(), Grid::rectangle(4, 4), identity);
}

/// Something the log should know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogEvent {
    /// A host is there.
    Linked,
    /// It is gone.
    Unlinked,
    /// Bytes lost on the line so far, if these are more than last time.
    BytesLost(u32),
}

#[cfg(all(feature = "defmt", target_os = "none"))]
impl LogEvent {
    /// Writes it to the log, which holds off every interrupt for as long as a line takes.
    pub fn log(self) {
        match self {
            Self::Linked => defmt::info!("a host is there"),
            Self::Unlinked => defmt::warn!("no host any more"),
            Self::BytesLost(bytes) => defmt::warn!("{=u32} bytes lost so far", bytes),
        }
    }
}

/// Everything the control task works with; what outlives a loss of power lies in the flash `F`, if there is one.
pub struct Control<'parts, F = NoFlash> {
    mind: &'parts mut NomadNode,
    receiver: Receiver,
    received: Consumer<'parts, u8>,
    ring: Option<Consumer<'parts, Firing>>,
    outbox: FrameSink<'parts>,
    faults: &'parts Faults,
    store: Option<Store<F>>,
    /// Whether a request for the flash will bring a pause, once it has been announced.
    announced: Option<bool>,
    is_watchdog_patient: bool,
    /// Why the robot must not move at present.
    alarm: Option<StopReason>,
    last_run: Millis,
    known_linked: bool,
    known_lost: u32,
}

impl<'parts, F: NorFlash> Control<'parts, F> {
    /// A mind that is yet to be started, between two queues. Without a `store` nothing outlives a loss of power.
    #[must_use]
    pub fn new(
        mind: &'parts mut NomadNode,
        received: Consumer<'parts, u8>,
        outbox: FrameSink<'parts>,
        faults: &'parts Faults,
        store: Option<Store<F>>,
    ) -> Self {
        Self {
            mind,
            receiver: Receiver::new(),
            received,
            ring: None,
            outbox,
            faults,
            store,
            announced: None,
            is_watchdog_patient: false,
            alarm: None,
            last_run: Millis::from_ms(0),
            known_linked: false,
            known_lost: 0,
        }
    }

    /// The same with a ring of its own.
    #[must_use]
    pub fn with_ring(mut self, ring: Consumer<'parts, Firing>) -> Self {
        self.ring = Some(ring);
        self
    }

    /// Whether the ring is to fire: not while flash is in use, when its clock may stand still.
    #[must_use]
    pub fn wants_ring(&self) -> bool {
        self.ring.is_some() && self.mind.source() == Source::Ring && self.announced.is_none()
    }

    /// Starts the mind at the time `now` with what was saved last, if anything was. May erase a sector of flash before, for
    /// seconds.
    // Not a part of the caller's stack for good.
    #[inline(never)]
    pub fn start(&mut self, identity: Identity, now: Millis) {
        self.last_run = now;
        prepare(self.mind, identity);
        // A flash that fails does so again, and says so, when something is to be saved; what cannot be recalled is told by
        // the hello's checksums.
        if let Some(store) = &mut self.store {
            let _ = store.tidy();
            let _ = recall(self.mind, store);
        }
        self.mind.hello(now, &mut self.outbox);
    }

    /// Whether a host is there.
    #[must_use]
    pub const fn is_linked(&self) -> bool {
        self.mind.is_linked()
    }

    /// Whether the robot moves by itself at `now`: it explores or seeks, and a host has been heard lately by the clock here, whichever
    /// clock the session has.
    #[must_use]
    pub fn may_move(&self, now: Millis) -> bool {
        self.mind.has_heard_host(now)
            && matches!(
                self.mind.state().mode(),
                Mode::Explore { .. } | Mode::Seek { .. }
            )
    }

    /// Stops the robot, or ends the motion under way, as the lines of the board say. A stop lasts until the lines are looked at
    /// again.
    pub fn apply_alarms(&mut self, alarms: Alarms, low_voltage: bool, now: Millis) {
        self.alarm = if alarms.emergency_stop {
            Some(StopReason::EmergencyStop)
        } else if low_voltage {
            Some(StopReason::LowVoltage)
        } else {
            alarms.bumper_open.then_some(StopReason::BumperOpen)
        };
        self.keep_stopped(now);
        if alarms.touched {
            self.mind.touched(now, &mut self.outbox);
        }
    }

    /// Stops the robot if it must not move. After each frame: the next one may complete a ring.
    fn keep_stopped(&mut self, now: Millis) {
        if let Some(reason) = self.alarm {
            self.mind.alarm(reason, now, &mut self.outbox);
        }
    }

    /// Deals with what was received and with the time that has passed. True: there is more to do at once.
    // Not a part of the caller's stack, where it would add to that of each task it calls.
    #[inline(never)]
    #[must_use]
    pub fn run(&mut self, now: Millis) -> bool {
        self.count(now);
        if let Some(task) = self.mind.flash_task() {
            return self.serve_flash(task, now);
        }
        let more_bytes = self.drain(now);
        self.hear_ring(now);
        let more_work = self.mind.tick(now, &mut self.outbox);
        more_bytes || more_work
    }

    /// Whether the watchdog has to bear a pause before this goes on: an erasure, or an image that is written as slowly as may be.
    #[must_use]
    pub fn wants_patience(&self) -> bool {
        self.announced == Some(true)
    }

    /// Says whether the watchdog bears a pause.
    pub fn note_patience(&mut self, patient: bool) {
        self.is_watchdog_patient = patient;
    }

    /// Announces the pause, lets the announcement go out, and does it. Frames wait meanwhile.
    // Not a part of every run's stack.
    #[inline(never)]
    fn serve_flash(&mut self, task: Flash, now: Millis) -> bool {
        let Some(store) = &mut self.store else {
            let absent = Err(FlashError::Absent);
            self.mind.flash_done(absent, now, &mut self.outbox);
            return true;
        };
        let Some(pauses) = self.announced else {
            let pause_ms = store.pause_ms(task);
            self.announced = Some(pause_ms > 0);
            if pause_ms > 0 {
                self.mind.announce_pause(pause_ms, now, &mut self.outbox);
            }
            return pause_ms == 0;
        };
        if !self.outbox.is_empty() || (pauses && !self.is_watchdog_patient) {
            return false;
        }
        let result = match task {
            Flash::Save => store.save(&self.mind.contents()),
            Flash::Recall => recall(self.mind, store),
            Flash::Erase => store.erase(),
        };
        self.announced = None;
        self.mind.flash_done(result, now, &mut self.outbox);
        true
    }

    /// Whether frames were queued since this was asked last.
    #[must_use]
    pub fn take_sent(&mut self) -> bool {
        self.outbox.take_sent()
    }

    /// Notes how deep the stack has been.
    pub fn note_stack(&mut self, peak_bytes: u32) {
        self.mind.device_counters().stack_peak_bytes = peak_bytes;
    }

    /// One thing that has changed since this was asked last.
    pub fn news(&mut self) -> Option<LogEvent> {
        let (linked, lost) = (
            self.is_linked(),
            self.faults.overruns().wrapping_add(self.faults.lost()),
        );
        if linked != self.known_linked {
            self.known_linked = linked;
            return Some(if linked {
                LogEvent::Linked
            } else {
                LogEvent::Unlinked
            });
        }
        if lost != self.known_lost {
            self.known_lost = lost;
            return Some(LogEvent::BytesLost(lost));
        }
        None
    }

    /// Takes no more bytes than the queue holds, so that a flood of them cannot keep time from passing.
    fn drain(&mut self, now: Millis) -> bool {
        for _ in 0..self.received.capacity() {
            let Some(byte) = self.received.dequeue() else {
                return false;
            };
            if let Some(frame) = self.receiver.push(byte) {
                #[cfg(feature = "crash-test")]
                crate::crash_test::run_if_requested(frame);
                self.mind.frame(now, frame, &mut self.outbox);
                self.keep_stopped(now);
                if self.mind.flash_task().is_some() {
                    return true;
                }
            }
        }
        self.received.ready()
    }

    /// Hands on what the ring has heard. What its line has spoilt is not among it, and nothing is known of those
    /// transducers.
    fn hear_ring(&mut self, now: Millis) {
        let Some(ring) = &mut self.ring else { return };
        for _ in 0..ring.capacity() {
            let Some(Firing { sensor, range, at }) = ring.dequeue() else {
                return;
            };
            self.mind
                .ring_echo(sensor, range, now.since(at), now, &mut self.outbox);
        }
    }

    fn count(&mut self, now: Millis) {
        let waited_ms = now.since(self.last_run);
        self.last_run = now;
        self.mind.set_oversized(self.receiver.oversized());
        let counters = self.mind.device_counters();
        counters.overruns = self.faults.overruns();
        counters.queue_losses = self.faults.lost();
        counters.ring_faults = self.faults.spoilt();
        counters.ticks = counters.ticks.wrapping_add(1);
        counters.longest_tick_ms = counters.longest_tick_ms.max(waited_ms);
    }
}

/// Replaces what the mind knows by what was saved last.
fn recall<F: NorFlash>(mind: &mut NomadNode, store: &mut Store<F>) -> Result<(), FlashError> {
    store.recall(|read, most| mind.recall(read, most))
}

#[cfg(test)]
mod tests;
