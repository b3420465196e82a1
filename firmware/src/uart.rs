//! The serial port: moves bytes between the port and two queues, in its interrupt.
//!
//! The interrupt and the control task share two queues, each with one writer and one reader.
//! Nothing here masks an interrupt.

use core::sync::atomic::{AtomicU32, Ordering};
use heapless::spsc::{Consumer, Producer};

/// State of the port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct UartStatus {
    /// A received byte is ready.
    pub received: bool,
    /// At least one received byte was lost because the previous one had not been fetched.
    pub overrun: bool,
    /// The port can take a byte to send.
    pub can_send: bool,
}

/// A serial port.
pub trait UartPort {
    /// Reads the state.
    fn status(&mut self) -> UartStatus;
    /// Fetches the received byte and clears an overrun.
    fn receive(&mut self) -> u8;
    /// Sends a byte.
    fn send(&mut self, byte: u8);
    /// Enables or disables the interrupt that says the port can take a byte.
    fn enable_transmit_interrupt(&mut self, wanted: bool);
}

/// Errors since the start.
#[derive(Debug, Default)]
pub struct ErrorCounters {
    overruns: AtomicU32,
    queue_full: AtomicU32,
    ring_faults: AtomicU32,
}

impl ErrorCounters {
    /// All counters at zero.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            overruns: AtomicU32::new(0),
            queue_full: AtomicU32::new(0),
            ring_faults: AtomicU32::new(0),
        }
    }

    /// Received bytes that the port lost because the interrupt ran too late.
    #[must_use]
    pub fn overruns(&self) -> u32 {
        self.overruns.load(Ordering::Relaxed)
    }

    /// Received bytes that were dropped because the queue was full.
    #[must_use]
    pub fn queue_full(&self) -> u32 {
        self.queue_full.load(Ordering::Relaxed)
    }

    /// Ring firings lost to a fault of the ECHO line or to a full queue.
    #[must_use]
    pub fn ring_faults(&self) -> u32 {
        self.ring_faults.load(Ordering::Relaxed)
    }

    /// Counts one ring fault.
    pub fn count_ring_fault(&self) {
        count(&self.ring_faults);
    }
}

/// Increments a counter. Each has one writer, so load and store may be two steps.
fn count(counter: &AtomicU32) {
    counter.store(
        counter.load(Ordering::Relaxed).wrapping_add(1),
        Ordering::Relaxed,
    );
}

/// The port's end of both queues.
pub struct UartDriver<'queues> {
    received: Producer<'queues, u8>,
    to_send: Consumer<'queues, u8>,
}

impl<'queues> UartDriver<'queues> {
    /// A driver that fills `received` and empties `to_send`.
    #[must_use]
    pub const fn new(received: Producer<'queues, u8>, to_send: Consumer<'queues, u8>) -> Self {
        Self { received, to_send }
    }

    /// Moves at most one byte each way. Returns whether the control task has to run: a frame has
    /// ended, or half the queue is full.
    #[must_use]
    pub fn transfer(&mut self, port: &mut impl UartPort, errors: &ErrorCounters) -> bool {
        let status = port.status();
        if status.overrun {
            count(&errors.overruns);
        }
        let mut should_wake = false;
        if status.received || status.overrun {
            should_wake = self.enqueue_received(port.receive(), errors);
        }
        if status.can_send {
            if let Some(byte) = self.to_send.dequeue() {
                port.send(byte);
            }
            port.enable_transmit_interrupt(self.to_send.ready());
        }
        should_wake
    }

    fn enqueue_received(&mut self, byte: u8, errors: &ErrorCounters) -> bool {
        if self.received.enqueue(byte).is_err() {
            count(&errors.queue_full);
        }
        byte == 0 || self.received.len() > self.received.capacity() / 2
    }
}

/// The control task's end of the queue of bytes to send.
pub struct TxQueue<'queues> {
    to_send: Producer<'queues, u8>,
    queued: bool,
}

impl<'queues> TxQueue<'queues> {
    /// A sink for frames at the end of `to_send`.
    #[must_use]
    pub const fn new(to_send: Producer<'queues, u8>) -> Self {
        Self {
            to_send,
            queued: false,
        }
    }

    /// Whether every queued byte has gone to the port.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.to_send.len() == 0
    }

    /// Whether a frame was queued since the last call; the caller then pends the interrupt.
    #[must_use]
    pub fn take_queued(&mut self) -> bool {
        core::mem::take(&mut self.queued)
    }
}

impl amp::node::FrameSink for TxQueue<'_> {
    /// Queues the whole frame, or nothing if it does not fit: half a frame would also corrupt
    /// the next one at the receiver.
    fn send(&mut self, frame: &[u8]) -> bool {
        if self.to_send.capacity() - self.to_send.len() < frame.len() {
            return false;
        }
        for &byte in frame {
            // Cannot fail: the queue has room, and only this task fills it.
            let _ = self.to_send.enqueue(byte);
        }
        self.queued = true;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::node::FrameSink as _;
    use heapless::spsc::Queue;
    use std::vec::Vec;

    /// A port with a list of bytes in each direction.
    #[derive(Default)]
    struct FakePort {
        incoming: Vec<u8>,
        outgoing: Vec<u8>,
        overrun: bool,
        transmit_interrupt: bool,
    }

    impl UartPort for FakePort {
        fn status(&mut self) -> UartStatus {
            UartStatus {
                received: !self.incoming.is_empty(),
                overrun: core::mem::take(&mut self.overrun),
                can_send: true,
            }
        }

        fn receive(&mut self) -> u8 {
            if self.incoming.is_empty() {
                0
            } else {
                self.incoming.remove(0)
            }
        }

        fn send(&mut self, byte: u8) {
            self.outgoing.push(byte);
        }

        fn enable_transmit_interrupt(&mut self, wanted: bool) {
            self.transmit_interrupt = wanted;
        }
    }

    #[test]
    fn received_bytes_wake_control_at_a_frame_end_or_when_half_full() {
        let (mut received, mut to_send) = (Queue::<u8, 9>::new(), Queue::<u8, 2>::new());
        let (producer, mut consumer) = received.split();
        let mut driver = UartDriver::new(producer, to_send.split().1);
        let errors = ErrorCounters::new();
        let mut port = FakePort {
            incoming: std::vec![1, 2, 0, 3, 4, 5],
            ..FakePort::default()
        };
        let wakes: Vec<bool> = (0..6)
            .map(|_| driver.transfer(&mut port, &errors))
            .collect();
        assert_eq!(wakes, [false, false, true, false, true, true]);
        let kept: Vec<u8> = core::iter::from_fn(|| consumer.dequeue()).collect();
        assert_eq!(kept, [1, 2, 0, 3, 4, 5]);
        assert!(!driver.transfer(&mut port, &errors), "nothing came");
    }

    #[test]
    fn overruns_and_a_full_queue_are_counted() {
        let (mut received, mut to_send) = (Queue::<u8, 3>::new(), Queue::<u8, 2>::new());
        let mut driver = UartDriver::new(received.split().0, to_send.split().1);
        let errors = ErrorCounters::new();
        let mut port = FakePort {
            incoming: std::vec![1; 5],
            overrun: true,
            ..FakePort::default()
        };
        for _ in 0..5 {
            let _ = driver.transfer(&mut port, &errors);
        }
        assert_eq!((errors.overruns(), errors.queue_full()), (1, 3));
    }

    #[test]
    fn a_frame_is_sent_whole_or_not_at_all() {
        let (mut received, mut to_send) = (Queue::<u8, 2>::new(), Queue::<u8, 6>::new());
        let (producer, consumer) = to_send.split();
        let errors = ErrorCounters::new();
        let mut frames = TxQueue::new(producer);
        let mut driver = UartDriver::new(received.split().0, consumer);
        let mut port = FakePort::default();
        assert!(!frames.take_queued());
        assert!(frames.send(&[1, 2, 0]) && !frames.send(&[3, 4, 0]) && frames.send(&[5, 0]));
        assert!(frames.take_queued() && !frames.take_queued());
        for left in (0..5).rev() {
            let _ = driver.transfer(&mut port, &errors);
            assert_eq!(port.transmit_interrupt, left > 0);
        }
        let _ = driver.transfer(&mut port, &errors);
        assert_eq!(port.outgoing, [1, 2, 0, 5, 0]);
    }
}
