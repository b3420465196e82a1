//! The control task: takes received bytes and the time, runs the node, and queues frames to send.
//!
//! It runs when a frame has arrived, every 10 ms, and again at once while work is left.
//! Learning is done in slices between events, so an event waits for at most one slice.

use crate::persist::{NoFlash, Store};
use crate::safety::Alarms;
use crate::sonar_ring::RingReading;
use crate::uart::{ErrorCounters, TxQueue};
use amp::body::Body;
use amp::config::Config;
use amp::controller::{Mode, StopReason};
use amp::node::{Identity, Node};
use amp::som::Grid;
use amp::units::Millis;
use amp::wire::Receiver;
use amp::wire::message::{FlashError, FlashOperation, Source};
use embedded_storage::nor_flash::NorFlash;
use heapless::spsc::Consumer;

/// The node of a robot with this body: 16 transducers, 16 neurons per map, 100 samples.
pub type RobotNode<B> = Node<16, 16, 100, B>;

/// Starts a node with the recommended configuration for the Nomad 200. Sends its Hello.
pub fn start<B: Body<16>>(
    node: &mut RobotNode<B>,
    identity: Identity,
    now: Millis,
    out: &mut impl amp::node::FrameSink,
) {
    prepare(node, identity);
    node.hello(now, out);
}

fn prepare<B: Body<16>>(node: &mut RobotNode<B>, identity: Identity) {
    node.prepare(&Config::recommended(), Grid::rectangle(4, 4), identity);
}

/// A change for the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LogEvent {
    /// A host has opened a session.
    Linked,
    /// The host has fallen silent.
    Unlinked,
    /// Total of received bytes that were lost; it has grown.
    BytesLost(u32),
}

#[cfg(all(feature = "defmt", target_os = "none"))]
impl LogEvent {
    /// Writes the event to the log. This masks every interrupt while the line is written.
    pub fn log(self) {
        match self {
            Self::Linked => defmt::info!("host connected"),
            Self::Unlinked => defmt::warn!("host lost"),
            Self::BytesLost(bytes) => defmt::warn!("{=u32} bytes lost since the start", bytes),
        }
    }
}

/// The state of the control task of a robot with the body `B`. `F` is the flash for saved images,
/// if the board has one.
pub struct Control<'parts, B, F = NoFlash> {
    node: &'parts mut RobotNode<B>,
    receiver: Receiver,
    received: Consumer<'parts, u8>,
    ring: Option<Consumer<'parts, RingReading>>,
    tx: TxQueue<'parts>,
    errors: &'parts ErrorCounters,
    store: Option<Store<F>>,
    /// Whether the flash task in progress pauses everything; `None` before that is known.
    flash_task_pauses: Option<bool>,
    has_long_timeout: bool,
    /// Why the robot must stand still at present.
    alarm: Option<StopReason>,
    last_run: Millis,
    logged_linked: bool,
    logged_losses: u32,
}

impl<'parts, B: Body<16>, F: NorFlash> Control<'parts, B, F> {
    /// A control task for a node that is not started yet. Without a `store` nothing is saved.
    #[must_use]
    pub fn new(
        node: &'parts mut RobotNode<B>,
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
            flash_task_pauses: None,
            has_long_timeout: false,
            alarm: None,
            last_run: Millis::from_ms(0),
            logged_linked: false,
            logged_losses: 0,
        }
    }

    /// Adds a ring of sonars at the board's own pins.
    #[must_use]
    pub fn with_ring(mut self, ring: Consumer<'parts, RingReading>) -> Self {
        self.ring = Some(ring);
        self
    }

    /// Whether the ring must fire. Not while flash is in use: its timer may then stop.
    #[must_use]
    pub fn needs_ring(&self) -> bool {
        self.ring.is_some()
            && self.node.source() == Source::Ring
            && self.flash_task_pauses.is_none()
    }

    /// Starts the node at `now` and loads the newest saved image, if there is one. May first erase
    /// a sector of flash, which takes seconds.
    // Not inlined: its stack frame would stay part of the caller's.
    #[inline(never)]
    pub fn start(&mut self, identity: Identity, now: Millis) {
        self.last_run = now;
        prepare(self.node, identity);
        // Errors need no report here: a faulty flash fails again at the next save, and the
        // checksums in the Hello show whether an image was loaded.
        if let Some(store) = &mut self.store {
            let _ = store.ensure_free_slot();
            let _ = load_latest(self.node, store);
        }
        self.node.hello(now, &mut self.tx);
    }

    /// Whether a host is connected.
    #[must_use]
    pub const fn is_linked(&self) -> bool {
        self.node.is_linked()
    }

    /// Whether the robot may move at `now`: it explores, seeks or babbles, and a host was heard
    /// lately by the device's clock, whichever clock the session uses.
    #[must_use]
    pub fn may_move(&self, now: Millis) -> bool {
        self.node.has_heard_host(now)
            && matches!(
                self.node.state().mode(),
                Mode::Explore { .. } | Mode::Seek { .. } | Mode::Babble { .. }
            )
    }

    /// Stops the robot, or ends the motion in progress, as the safety lines require. A stop holds
    /// until the next call.
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

    /// Stops the robot if an alarm is active. After each frame: the next may complete a ring.
    fn stop_if_alarmed(&mut self, now: Millis) {
        if let Some(reason) = self.alarm {
            self.node.alarm(reason, now, &mut self.tx);
        }
    }

    /// Processes received bytes and the time. Returns whether work is left.
    // Not inlined: its stack frame would add to that of each function the caller calls.
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

    /// Whether the watchdog must get its long timeout before work continues: flash will be erased
    /// or written.
    #[must_use]
    pub fn needs_long_timeout(&self) -> bool {
        self.flash_task_pauses == Some(true)
    }

    /// Notes whether the watchdog has its long timeout.
    pub fn set_has_long_timeout(&mut self, has_long_timeout: bool) {
        self.has_long_timeout = has_long_timeout;
    }

    /// Announces the pause, waits until the announcement is sent, then does the task. Meanwhile
    /// received frames wait.
    // Not inlined: its stack frame would be part of every run.
    #[inline(never)]
    fn run_flash_task(&mut self, task: FlashOperation, now: Millis) -> bool {
        let Some(store) = &mut self.store else {
            let absent = Err(FlashError::NoFlash);
            self.node.flash_done(absent, now, &mut self.tx);
            return true;
        };
        let Some(pauses) = self.flash_task_pauses else {
            let pause_ms = store.pause_ms(task);
            self.flash_task_pauses = Some(pause_ms > 0);
            if pause_ms > 0 {
                self.node.announce_pause(pause_ms, now, &mut self.tx);
            }
            return pause_ms == 0;
        };
        if !self.tx.is_empty() || (pauses && !self.has_long_timeout) {
            return false;
        }
        let result = match task {
            FlashOperation::Save => store.save(&self.node.contents()),
            FlashOperation::Load => load_latest(self.node, store),
            FlashOperation::Erase => store.erase(),
        };
        self.flash_task_pauses = None;
        self.node.flash_done(result, now, &mut self.tx);
        true
    }

    /// Whether frames were queued since the last call.
    #[must_use]
    pub fn take_queued(&mut self) -> bool {
        self.tx.take_queued()
    }

    /// Notes the greatest depth of the stack.
    pub fn set_stack_peak(&mut self, peak_bytes: u32) {
        self.node.device_counters().stack_peak_bytes = peak_bytes;
    }

    /// The next change since the last call.
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

    /// Takes at most one queue of bytes, so that a flood cannot keep `run` from returning.
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

    /// Passes the ring's readings to the node. Faulty firings are not among them, so nothing is
    /// known of those transducers.
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

/// Replaces the node's configuration and state by the newest saved image.
fn load_latest<B: Body<16>, F: NorFlash>(
    node: &mut RobotNode<B>,
    store: &mut Store<F>,
) -> Result<(), FlashError> {
    store.load(|read, most| node.recall(read, most))
}

#[cfg(test)]
mod tests;
