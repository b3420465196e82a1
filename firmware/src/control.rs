//! The control task: received bytes and passing time in, frames out. It owns the mind.
//!
//! It is not paced: it runs when a frame has come, when the clock says that time has passed, and again at once while there
//! is more to do. Learning is done in slices between events, so that an event waits for one slice at most.

use crate::line::{Faults, Outbox};
use crate::sonar_ring::{Firing, Heard};
use amp::config::Config;
use amp::node::{Identity, NomadNode};
use amp::som::Grid;
use amp::units::Millis;
use amp::wire::Receiver;
use amp::wire::message::Source;
use heapless::spsc::Consumer;

/// Starts the mind of the Nomad 200 with the recommended configuration: 16 transducers, 16 neurons to a map, a hundred
/// samples. It says hello.
pub fn start(
    mind: &mut NomadNode,
    identity: Identity,
    now: Millis,
    out: &mut impl amp::node::Outbox,
) {
    let config = Config::recommended();
    mind.start(&config, Grid::rectangle(4, 4), identity, now, out);
}

/// Something the log should know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum News {
    /// A host is there.
    Linked,
    /// It is gone.
    Unlinked,
    /// Bytes lost on the line so far, if these are more than last time.
    BytesLost(u32),
}

#[cfg(target_os = "none")]
impl News {
    /// Writes it to the log, which holds off every interrupt for as long as a line takes.
    pub fn log(self) {
        match self {
            Self::Linked => defmt::info!("a host is there"),
            Self::Unlinked => defmt::warn!("no host any more"),
            Self::BytesLost(bytes) => defmt::warn!("{=u32} bytes lost so far", bytes),
        }
    }
}

/// Everything the control task works with.
pub struct Control<'parts> {
    mind: &'parts mut NomadNode,
    receiver: Receiver,
    received: Consumer<'parts, u8>,
    ring: Option<Consumer<'parts, Firing>>,
    outbox: Outbox<'parts>,
    faults: &'parts Faults,
    last_run: Millis,
    known_linked: bool,
    known_lost: u32,
}

impl<'parts> Control<'parts> {
    /// A mind that is yet to be started, between two queues.
    #[must_use]
    pub const fn new(
        mind: &'parts mut NomadNode,
        received: Consumer<'parts, u8>,
        outbox: Outbox<'parts>,
        faults: &'parts Faults,
    ) -> Self {
        Self {
            mind,
            receiver: Receiver::new(),
            received,
            ring: None,
            outbox,
            faults,
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

    /// Whether the ring is to fire.
    #[must_use]
    pub fn wants_ring(&self) -> bool {
        self.ring.is_some() && self.mind.source() == Source::Ring
    }

    /// Starts the mind at the time `now`.
    pub fn start(&mut self, identity: Identity, now: Millis) {
        self.last_run = now;
        start(self.mind, identity, now, &mut self.outbox);
    }

    /// Whether a host is there.
    #[must_use]
    pub const fn is_linked(&self) -> bool {
        self.mind.is_linked()
    }

    /// Deals with what was received and with the time that has passed. True: there is more to do at once.
    #[must_use]
    pub fn run(&mut self, now: Millis) -> bool {
        self.count(now);
        let more_bytes = self.drain(now);
        self.hear_ring(now);
        let more_work = self.mind.tick(now, &mut self.outbox);
        more_bytes || more_work
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
    pub fn news(&mut self) -> Option<News> {
        let (linked, lost) = (
            self.is_linked(),
            self.faults.overruns().wrapping_add(self.faults.lost()),
        );
        if linked != self.known_linked {
            self.known_linked = linked;
            return Some(if linked { News::Linked } else { News::Unlinked });
        }
        if lost != self.known_lost {
            self.known_lost = lost;
            return Some(News::BytesLost(lost));
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
                #[cfg(feature = "qemu")]
                crate::provoke::heed(frame);
                self.mind.frame(now, frame, &mut self.outbox);
            }
        }
        self.received.ready()
    }

    /// Hands on what the ring has heard; what the line spoilt is counted, and nothing is known of that transducer.
    fn hear_ring(&mut self, now: Millis) {
        let Some(ring) = &mut self.ring else { return };
        for _ in 0..ring.capacity() {
            let Some(firing) = ring.dequeue() else { return };
            match firing.heard {
                Heard::Range(range) => {
                    let age_ms = now.since(firing.at);
                    self.mind
                        .ring_echo(firing.sensor, range, age_ms, now, &mut self.outbox);
                }
                Heard::Fault => self.faults.spoil(),
            }
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

#[cfg(test)]
mod tests {
    use super::*;
    use amp::wire::frame::{Header, unpack};
    use amp::wire::message::{Clock, Counters, Dimensions, HostHello, ResetCause};
    use amp::wire::{Frame, FromMind, PROTOCOL, Report, SCHEMA, ToMind};
    use heapless::spsc::{Producer, Queue};
    use std::boxed::Box;
    use std::vec::Vec;

    /// A control task between two queues whose far ends the test holds.
    struct Bench {
        control: Control<'static>,
        incoming: Producer<'static, u8>,
        outgoing: Consumer<'static, u8>,
        seq: u16,
    }

    fn forever<T>(value: T) -> &'static mut T {
        Box::leak(Box::new(value))
    }

    fn bench() -> Bench {
        let received = forever(Queue::<u8, 512>::new());
        let to_send = forever(Queue::<u8, 2048>::new());
        let mind = forever(NomadNode::new());
        let faults = forever(Faults::new());
        let (incoming, received) = received.split();
        let (to_send, outgoing) = to_send.split();
        Bench {
            control: Control::new(mind, received, Outbox::new(to_send), faults),
            incoming,
            outgoing,
            seq: 0,
        }
    }

    impl Bench {
        fn start(&mut self) {
            let identity = Identity {
                build: *b"testtest",
                reset: ResetCause::Panic,
                ring: false,
            };
            self.control.start(identity, Millis::from_ms(0));
        }

        fn receive(&mut self, bytes: &[u8]) {
            for &byte in bytes {
                self.incoming.enqueue(byte).expect("room in the queue");
            }
        }

        fn ask(&mut self, message: &ToMind<16>) {
            self.seq += 1;
            let header = Header {
                session: 3,
                seq: self.seq,
            };
            let frame = Frame::pack(header, message).expect("a short message");
            self.receive(frame.as_bytes());
        }

        fn open(&mut self) {
            let dimensions = Dimensions {
                protocol: PROTOCOL,
                schema: SCHEMA,
                sensors: 16,
                neurons: 16,
            };
            self.ask(&ToMind::Hello(HostHello {
                dimensions,
                clock: Clock::Device,
            }));
        }

        /// What was said since this was asked last.
        fn said(&mut self) -> Vec<FromMind<16>> {
            let mut receiver = Receiver::new();
            let mut said = Vec::new();
            while let Some(byte) = self.outgoing.dequeue() {
                if let Some(frame) = receiver.push(byte) {
                    let (_, report) = unpack::<Report<16>>(frame).expect("a sound frame");
                    said.push(report.said);
                }
            }
            said
        }

        fn counters(&mut self, now_ms: u32) -> Counters {
            self.ask(&ToMind::Counters);
            assert!(!self.control.run(Millis::from_ms(now_ms)));
            let said = self.said();
            let counters = said.iter().find_map(|said| match said {
                FromMind::Counters(counters) => Some(*counters),
                _ => None,
            });
            counters.expect("the counters")
        }
    }

    #[test]
    fn a_start_says_who_and_why() {
        let mut bench = bench();
        bench.start();
        assert!(bench.control.take_sent() && !bench.control.take_sent());
        let [FromMind::Hello(hello)] = bench.said()[..] else {
            panic!("a hello");
        };
        assert_eq!(
            (&hello.build, hello.reset),
            (b"testtest", ResetCause::Panic)
        );
    }

    #[test]
    fn frames_are_answered_and_what_the_device_counts_is_told() {
        let mut bench = bench();
        bench.start();
        bench.open();
        assert!(!bench.control.run(Millis::from_ms(7)));
        assert!(bench.control.is_linked());
        assert_eq!(bench.control.news(), Some(News::Linked));
        assert_eq!(bench.control.news(), None);
        bench.said();
        bench.control.note_stack(1_234);
        let counters = bench.counters(30);
        assert_eq!(counters.accepted, 2);
        assert_eq!(counters.device.stack_peak_bytes, 1_234);
        assert_eq!(counters.device.ticks, 2);
        assert_eq!(counters.device.longest_tick_ms, 23);
    }

    #[test]
    fn a_host_that_falls_silent_is_news() {
        let mut bench = bench();
        bench.start();
        bench.open();
        assert!(!bench.control.run(Millis::from_ms(0)));
        assert_eq!(bench.control.news(), Some(News::Linked));
        assert!(!bench.control.run(Millis::from_ms(1_000)));
        assert_eq!(bench.control.news(), Some(News::Unlinked));
    }

    #[test]
    fn garbage_is_counted_and_the_next_frame_is_heard() {
        let mut bench = bench();
        bench.start();
        bench.open();
        bench.receive(&[7; 300]);
        bench.receive(&[0, 3, 1, 2, 0]);
        assert!(!bench.control.run(Millis::from_ms(1)));
        let counters = bench.counters(2);
        // The hello and the question; what was too long; what was no frame.
        let counted = (counters.accepted, counters.oversized, counters.misshapen);
        assert_eq!(counted, (2, 1, 1));
    }

    #[test]
    fn a_full_queue_is_emptied_in_one_run() {
        let mut bench = bench();
        bench.start();
        let room = bench.incoming.capacity();
        for _ in 0..room {
            bench.incoming.enqueue(0).expect("room in the queue");
        }
        assert!(!bench.control.run(Millis::from_ms(1)));
        assert!(bench.incoming.is_empty());
    }
}
