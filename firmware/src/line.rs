//! The serial line: how the interrupt moves bytes between the port and two queues.
//!
//! The interrupt and the control task share nothing but two queues with one writer and one reader each. Nothing here
//! holds off an interrupt, so a byte waits for no more than the few instructions of another byte.

use core::sync::atomic::{AtomicU32, Ordering};
use heapless::spsc::{Consumer, Producer};

/// What the port has to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Status {
    /// A byte lies ready.
    pub received: bool,
    /// A later byte came before the one that lies ready was fetched, and is lost.
    pub overrun: bool,
    /// The port takes a byte.
    pub can_send: bool,
}

/// A serial port.
pub trait Port {
    /// What there is to do.
    fn status(&mut self) -> Status;
    /// Fetches the byte that lies ready; this also ends an overrun.
    fn receive(&mut self) -> u8;
    /// Sends a byte.
    fn send(&mut self, byte: u8);
    /// Whether to raise an interrupt when the port takes a byte.
    fn call_to_send(&mut self, wanted: bool);
}

/// What went wrong on the line since the start.
#[derive(Debug, Default)]
pub struct Faults {
    overruns: AtomicU32,
    lost: AtomicU32,
    spoilt: AtomicU32,
}

impl Faults {
    /// Nothing went wrong.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            overruns: AtomicU32::new(0),
            lost: AtomicU32::new(0),
            spoilt: AtomicU32::new(0),
        }
    }

    /// Bytes the port lost because the interrupt came too late.
    #[must_use]
    pub fn overruns(&self) -> u32 {
        self.overruns.load(Ordering::Relaxed)
    }

    /// Bytes received for which the queue had no room.
    #[must_use]
    pub fn lost(&self) -> u32 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Firings of the ring that its ECHO line spoilt or that nobody took.
    #[must_use]
    pub fn spoilt(&self) -> u32 {
        self.spoilt.load(Ordering::Relaxed)
    }

    /// One more of them.
    pub fn spoil(&self) {
        count(&self.spoilt);
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
pub struct Line<'queues> {
    received: Producer<'queues, u8>,
    to_send: Consumer<'queues, u8>,
}

impl<'queues> Line<'queues> {
    /// A line that fills one queue and empties the other.
    #[must_use]
    pub const fn new(received: Producer<'queues, u8>, to_send: Consumer<'queues, u8>) -> Self {
        Self { received, to_send }
    }

    /// Moves at most one byte each way. True: somebody should look at what was received, because a frame has ended or
    /// half the queue is full.
    #[must_use]
    pub fn serve(&mut self, port: &mut impl Port, faults: &Faults) -> bool {
        let status = port.status();
        if status.overrun {
            count(&faults.overruns);
        }
        let mut look = false;
        if status.received || status.overrun {
            look = self.keep(port.receive(), faults);
        }
        if status.can_send {
            if let Some(byte) = self.to_send.dequeue() {
                port.send(byte);
            }
            port.call_to_send(self.to_send.ready());
        }
        look
    }

    fn keep(&mut self, byte: u8, faults: &Faults) -> bool {
        if self.received.enqueue(byte).is_err() {
            count(&faults.lost);
        }
        byte == 0 || self.received.len() > self.received.capacity() / 2
    }
}

/// The control task's side of what is to be sent.
pub struct FrameSink<'queues> {
    to_send: Producer<'queues, u8>,
    sent: bool,
}

impl<'queues> FrameSink<'queues> {
    /// An outbox that fills the queue which the interrupt empties.
    #[must_use]
    pub const fn new(to_send: Producer<'queues, u8>) -> Self {
        Self {
            to_send,
            sent: false,
        }
    }

    /// Whether everything sent has gone to the port.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.to_send.len() == 0
    }

    /// Whether anything was sent since this was asked last: the interrupt has to be told.
    #[must_use]
    pub fn take_sent(&mut self) -> bool {
        core::mem::take(&mut self.sent)
    }
}

impl amp::node::FrameSink for FrameSink<'_> {
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
        self.sent = true;
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
    struct Wires {
        incoming: Vec<u8>,
        outgoing: Vec<u8>,
        overrun: bool,
        calling: bool,
    }

    impl Port for Wires {
        fn status(&mut self) -> Status {
            Status {
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

        fn call_to_send(&mut self, wanted: bool) {
            self.calling = wanted;
        }
    }

    #[test]
    fn received_bytes_call_for_a_look_at_a_frames_end_or_when_half_full() {
        let (mut received, mut to_send) = (Queue::<u8, 9>::new(), Queue::<u8, 2>::new());
        let (producer, mut consumer) = received.split();
        let mut line = Line::new(producer, to_send.split().1);
        let faults = Faults::new();
        let mut wires = Wires {
            incoming: std::vec![1, 2, 0, 3, 4, 5],
            ..Wires::default()
        };
        let looks: Vec<bool> = (0..6).map(|_| line.serve(&mut wires, &faults)).collect();
        assert_eq!(looks, [false, false, true, false, true, true]);
        let kept: Vec<u8> = core::iter::from_fn(|| consumer.dequeue()).collect();
        assert_eq!(kept, [1, 2, 0, 3, 4, 5]);
        assert!(!line.serve(&mut wires, &faults), "nothing came");
    }

    #[test]
    fn what_finds_no_room_and_what_comes_too_fast_is_counted() {
        let (mut received, mut to_send) = (Queue::<u8, 3>::new(), Queue::<u8, 2>::new());
        let mut line = Line::new(received.split().0, to_send.split().1);
        let faults = Faults::new();
        let mut wires = Wires {
            incoming: std::vec![1; 5],
            overrun: true,
            ..Wires::default()
        };
        for _ in 0..5 {
            let _ = line.serve(&mut wires, &faults);
        }
        assert_eq!((faults.overruns(), faults.lost()), (1, 3));
    }

    #[test]
    fn a_frame_is_sent_whole_or_not_at_all() {
        let (mut received, mut to_send) = (Queue::<u8, 2>::new(), Queue::<u8, 6>::new());
        let (producer, consumer) = to_send.split();
        let faults = Faults::new();
        let mut outbox = FrameSink::new(producer);
        let mut line = Line::new(received.split().0, consumer);
        let mut wires = Wires::default();
        assert!(!outbox.take_sent());
        assert!(outbox.send(&[1, 2, 0]) && !outbox.send(&[3, 4, 0]) && outbox.send(&[5, 0]));
        assert!(outbox.take_sent() && !outbox.take_sent());
        for left in (0..5).rev() {
            let _ = line.serve(&mut wires, &faults);
            assert_eq!(wires.calling, left > 0);
        }
        let _ = line.serve(&mut wires, &faults);
        assert_eq!(wires.outgoing, [1, 2, 0, 5, 0]);
    }
}
