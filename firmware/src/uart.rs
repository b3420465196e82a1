//! The serial line: how the interrupt moves bytes between the port and two queues.
//!
//! The interrupt and the control task share nothing but two queues with one writer and one reader each. Nothing here
//! holds off an interrupt, so a byte waits for no more than the few instructions of another byte.

use core::sync::atomic::{AtomicU32, Ordering};
use heapless::spsc::{Consumer, Producer};

/// What the port has to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct UartStatus {
    /// A byte lies ready.
    pub received: bool,
    /// A later byte came before the one that lies ready was fetched, and is lost.
    pub overrun: bool,
    /// The port takes a byte.
    pub can_send: bool,
}

/// A serial port.
pub trait UartPort {
    /// What there is to do.
    fn status(&mut self) -> UartStatus;
    /// Fetches the byte that lies ready; this also ends an overrun.
    fn receive(&mut self) -> u8;
    /// Sends a byte.
    fn send(&mut self, byte: u8);
    /// Whether to raise an interrupt when the port takes a byte.
    fn enable_transmit_interrupt(&mut self, wanted: bool);
}

/// What went wrong on the line since the start.
#[derive(Debug, Default)]
pub struct ErrorCounters {
    overruns: AtomicU32,
    queue_full: AtomicU32,
    ring_faults: AtomicU32,
}

impl ErrorCounters {
    /// Nothing went wrong.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            overruns: AtomicU32::new(0),
            queue_full: AtomicU32::new(0),
            ring_faults: AtomicU32::new(0),
        }
    }

    /// Bytes the port lost because the interrupt came too late.
    #[must_use]
    pub fn overruns(&self) -> u32 {
        self.overruns.load(Ordering::Relaxed)
    }

    /// Bytes received for which the queue had no room.
    #[must_use]
    pub fn queue_full(&self) -> u32 {
        self.queue_full.load(Ordering::Relaxed)
    }

    /// Firings of the ring that its ECHO line spoilt or that nobody took.
    #[must_use]
    pub fn ring_faults(&self) -> u32 {
        self.ring_faults.load(Ordering::Relaxed)
    }

    /// One more of them.
    pub fn count_ring_fault(&self) {
        count(&self.ring_faults);
    }
}

/// One more; each counter has one writer, so reading and writing need not be one step.
fn count(counter: &AtomicU32) {
    counter.store(
        counter.load(Ordering::Relaxed).wrapping_add(1),
        Ordering::Relaxed,
    );
}

/// The interrupt's side.
pub struct UartDriver<'queues> {
    received: Producer<'queues, u8>,
    to_send: Consumer<'queues, u8>,
}

impl<'queues> UartDriver<'queues> {
    /// A line that fills one queue and empties the other.
    #[must_use]
    pub const fn new(received: Producer<'queues, u8>, to_send: Consumer<'queues, u8>) -> Self {
        Self { received, to_send }
    }

    /// Moves at most one byte each way. True: somebody should look at what was received, because a frame has ended or
    /// half the queue is full.
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

/// The control task's side of what is to be sent.
pub struct TxQueue<'queues> {
    to_send: Producer<'queues, u8>,
    queued: bool,
}

impl<'queues> TxQueue<'queues> {
    /// An outbox that fills the queue which the interrupt empties.
    #[must_use]
    pub const fn new(to_send: Producer<'queues, u8>) -> Self {
        Self {
            to_send,
            queued: false,
        }
    }

    /// Whether everything sent has gone to the port.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.to_send.len() == 0
    }

    /// Whether anything was sent since this was asked last: the interrupt has to be told.
    #[must_use]
    pub fn take_queued(&mut self) -> bool {
        core::mem::take(&mut self.queued)
    }
}

impl amp::node::FrameSink for TxQueue<'_> {
    /// Queues a whole frame or, if there is no room for all of it, nothing: half a frame would cost the receiver the
    /// next one as well.
    fn send(&mut self, frame: &[u8]) -> bool {
        if self.to_send.capacity() - self.to_send.len() < frame.len() {
            return false;
        }
        for &byte in frame {
            // There is room: this task alone fills the queue.
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

    /// A port whose wires are two lists.
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
