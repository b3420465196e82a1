//! The control task: received bytes and passing time in, frames out. It owns the mind.
//!
//! It is not paced: it runs when a frame has come, when the clock says that time has passed, and again at once while there
//! is more to do. Learning is done in slices between events, so that an event waits for one slice at most.

use crate::persist::{NoFlash, Store};
use crate::safety::Alarms;
use crate::sonar_ring::RingReading;
use crate::uart::{ErrorCounters, TxQueue};
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
    node: &mut NomadNode,
    identity: Identity,
    now: Millis,
    out: &mut impl amp::node::FrameSink,
) {
    prepare(node, identity);
    node.hello(now, out);
}

fn prepare(node: &mut NomadNode, identity: Identity) {
    node.prepare(&Config::recommended(), Grid::rectangle(4, 4), identity);
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
    node: &'parts mut NomadNode,
    receiver: Receiver,
    received: Consumer<'parts, u8>,
    ring: Option<Consumer<'parts, RingReading>>,
    tx: TxQueue<'parts>,
    errors: &'parts ErrorCounters,
    store: Option<Store<F>>,
    /// Whether a request for the flash will bring a pause, once it has been announced.
    pause_announced: Option<bool>,
    has_long_timeout: bool,
    /// Why the robot must not move at present.
    alarm: Option<StopReason>,
    last_run: Millis,
    logged_linked: bool,
    logged_losses: u32,
}

impl<'parts, F: NorFlash> Control<'parts, F> {
    /// A mind that is yet to be started, between two queues. Without a `store` nothing outlives a loss of power.
    #[must_use]
    pub fn new(
        node: &'parts mut NomadNode,
        received: Consumer<'parts, u8>,
        tx: TxQueue<'parts>,
        errors: &'parts ErrorCounters,
        store: Option<Store<F>>,
    ) -> Self {
        Self {
            node,
            receiver: Receiver::new(),
            received,
            ring: None,
            tx,
            errors,
            store,
            pause_announced: None,
            has_long_timeout: false,
            alarm: None,
            last_run: Millis::from_ms(0),
            logged_linked: false,
            logged_losses: 0,
        }
    }

    /// The same with a ring of its own.
    #[must_use]
    pub fn with_ring(mut self, ring: Consumer<'parts, RingReading>) -> Self {
        self.ring = Some(ring);
        self
    }

    /// Whether the ring is to fire: not while flash is in use, when its clock may stand still.
    #[must_use]
    pub fn needs_ring(&self) -> bool {
        self.ring.is_some() && self.node.source() == Source::Ring && self.pause_announced.is_none()
    }

    /// Starts the mind at the time `now` with what was saved last, if anything was. May erase a sector of flash before, for
    /// seconds.
    // Not a part of the caller's stack for good.
    #[inline(never)]
    pub fn start(&mut self, identity: Identity, now: Millis) {
        self.last_run = now;
        prepare(self.node, identity);
        // A flash that fails does so again, and says so, when something is to be saved; what cannot be recalled is told by
        // the hello's checksums.
        if let Some(store) = &mut self.store {
            let _ = store.ensure_free_slot();
            let _ = load_latest(self.node, store);
        }
        self.node.hello(now, &mut self.tx);
    }

    /// Whether a host is there.
    #[must_use]
    pub const fn is_linked(&self) -> bool {
        self.node.is_linked()
    }

    /// Whether the robot moves by itself at `now`: it explores or seeks, and a host has been heard lately by the clock here, whichever
    /// clock the session has.
    #[must_use]
    pub fn may_move(&self, now: Millis) -> bool {
        self.node.has_heard_host(now)
            && matches!(
                self.node.state().mode(),
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
        self.stop_if_alarmed(now);
        if alarms.touched {
            self.node.touched(now, &mut self.tx);
        }
    }

    /// Stops the robot if it must not move. After each frame: the next one may complete a ring.
    fn stop_if_alarmed(&mut self, now: Millis) {
        if let Some(reason) = self.alarm {
            self.node.alarm(reason, now, &mut self.tx);
        }
    }

    /// Deals with what was received and with the time that has passed. True: there is more to do at once.
    // Not a part of the caller's stack, where it would add to that of each task it calls.
    #[inline(never)]
    #[must_use]
    pub fn run(&mut self, now: Millis) -> bool {
        self.update_counters(now);
        if let Some(task) = self.node.flash_task() {
            return self.run_flash_task(task, now);
        }
        let more_bytes = self.receive_bytes(now);
        self.receive_ring(now);
        let more_work = self.node.tick(now, &mut self.tx);
        more_bytes || more_work
    }

    /// Whether the watchdog has to bear a pause before this goes on: an erasure, or an image that is written as slowly as may be.
    #[must_use]
    pub fn needs_long_timeout(&self) -> bool {
        self.pause_announced == Some(true)
    }

    /// Says whether the watchdog bears a pause.
    pub fn set_has_long_timeout(&mut self, patient: bool) {
        self.has_long_timeout = patient;
    }

    /// Announces the pause, lets the announcement go out, and does it. Frames wait meanwhile.
    // Not a part of every run's stack.
    #[inline(never)]
    fn run_flash_task(&mut self, task: Flash, now: Millis) -> bool {
        let Some(store) = &mut self.store else {
            let absent = Err(FlashError::Absent);
            self.node.flash_done(absent, now, &mut self.tx);
            return true;
        };
        let Some(pauses) = self.pause_announced else {
            let pause_ms = store.pause_ms(task);
            self.pause_announced = Some(pause_ms > 0);
            if pause_ms > 0 {
                self.node.announce_pause(pause_ms, now, &mut self.tx);
            }
            return pause_ms == 0;
        };
        if !self.tx.is_empty() || (pauses && !self.has_long_timeout) {
            return false;
        }
        let result = match task {
            Flash::Save => store.save(&self.node.contents()),
            Flash::Recall => load_latest(self.node, store),
            Flash::Erase => store.erase(),
        };
        self.pause_announced = None;
        self.node.flash_done(result, now, &mut self.tx);
        true
    }

    /// Whether frames were queued since this was asked last.
    #[must_use]
    pub fn take_queued(&mut self) -> bool {
        self.tx.take_queued()
    }

    /// Notes how deep the stack has been.
    pub fn set_stack_peak(&mut self, peak_bytes: u32) {
        self.node.device_counters().stack_peak_bytes = peak_bytes;
    }

    /// One thing that has changed since this was asked last.
    pub fn next_log_event(&mut self) -> Option<LogEvent> {
        let (linked, lost) = (
            self.is_linked(),
            self.errors
                .overruns()
                .wrapping_add(self.errors.queue_full()),
        );
        if linked != self.logged_linked {
            self.logged_linked = linked;
            return Some(if linked {
                LogEvent::Linked
            } else {
                LogEvent::Unlinked
            });
        }
        if lost != self.logged_losses {
            self.logged_losses = lost;
            return Some(LogEvent::BytesLost(lost));
        }
        None
    }

    /// Takes no more bytes than the queue holds, so that a flood of them cannot keep time from passing.
    fn receive_bytes(&mut self, now: Millis) -> bool {
        for _ in 0..self.received.capacity() {
            let Some(byte) = self.received.dequeue() else {
                return false;
            };
            if let Some(frame) = self.receiver.push(byte) {
                #[cfg(feature = "crash-test")]
                crate::crash_test::run_if_requested(frame);
                self.node.frame(now, frame, &mut self.tx);
                self.stop_if_alarmed(now);
                if self.node.flash_task().is_some() {
                    return true;
                }
            }
        }
        self.received.ready()
    }

    /// Hands on what the ring has heard. What its line has spoilt is not among it, and nothing is known of those
    /// transducers.
    fn receive_ring(&mut self, now: Millis) {
        let Some(ring) = &mut self.ring else { return };
        for _ in 0..ring.capacity() {
            let Some(RingReading { sensor, range, at }) = ring.dequeue() else {
                return;
            };
            self.node
                .ring_echo(sensor, range, now.since(at), now, &mut self.tx);
        }
    }

    fn update_counters(&mut self, now: Millis) {
        let waited_ms = now.since(self.last_run);
        self.last_run = now;
        self.node.set_oversized(self.receiver.oversized());
        let counters = self.node.device_counters();
        counters.overruns = self.errors.overruns();
        counters.queue_losses = self.errors.queue_full();
        counters.ring_faults = self.errors.ring_faults();
        counters.ticks = counters.ticks.wrapping_add(1);
        counters.longest_tick_ms = counters.longest_tick_ms.max(waited_ms);
    }
}

/// Replaces what the mind knows by what was saved last.
fn load_latest<F: NorFlash>(node: &mut NomadNode, store: &mut Store<F>) -> Result<(), FlashError> {
    store.load(|read, most| node.recall(read, most))
}

#[cfg(test)]
mod tests;
