use super::*;
use crate::persist::{self, sim::SimFlash};
use amp::parameters::Parameter;
use amp::units::Range;
use amp::wire::frame::{Header, unpack};
use amp::wire::message::{
    Clock, Counters, Dimensions, Heard, HostHello, ModeReport, Order, Oscillator, Refusal,
    ResetCause,
};
use amp::wire::{Frame, FromMind, PROTOCOL, Report, SCHEMA, ToMind};
use heapless::spsc::{Producer, Queue};
use std::boxed::Box;
use std::vec::Vec;

/// A control task between two queues whose far ends the test holds.
struct Bench<F = Sectors> {
    control: Control<'static, F>,
    incoming: Producer<'static, u8>,
    outgoing: Consumer<'static, u8>,
    seq: u16,
}

fn forever<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

type Sectors = SimFlash<{ 12 + persist::SLOT_BYTES as usize }>;

fn bench() -> Bench {
    bench_with(Sectors::new(1))
}

fn bench_with(flash: Sectors) -> Bench {
    bench_on(Some(Store::mount(flash, persist::SLOT_BYTES)))
}

fn bench_on<F: NorFlash>(store: Option<Store<F>>) -> Bench<F> {
    let received = forever(Queue::<u8, 512>::new());
    let to_send = forever(Queue::<u8, 2048>::new());
    let mind = forever(NomadNode::new());
    let faults = forever(Faults::new());
    let (incoming, received) = received.split();
    let (to_send, outgoing) = to_send.split();
    Bench {
        control: Control::new(mind, received, FrameSink::new(to_send), faults, store),
        incoming,
        outgoing,
        seq: 0,
    }
}

impl<F: NorFlash> Bench<F> {
    fn start(&mut self) {
        let identity = Identity {
            build: *b"testtest",
            reset: ResetCause::Panic,
            oscillator: Oscillator::Unknown,
            ring: false,
        };
        self.control.start(identity, Millis::from_ms(0));
    }

    /// Generation of the newest image.
    fn generation(&self) -> u32 {
        let store = self.control.store.as_ref().expect("a store");
        store.generation()
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
        self.open_by(Clock::Device);
    }

    fn open_by(&mut self, clock: Clock) {
        let dimensions = Dimensions {
            protocol: PROTOCOL,
            schema: SCHEMA,
            sensors: 16,
            neurons: 16,
        };
        self.ask(&ToMind::Hello(HostHello {
            dimensions,
            clock,
            open_space: false,
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
    assert_eq!(bench.control.news(), Some(LogEvent::Linked));
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
    assert_eq!(bench.control.news(), Some(LogEvent::Linked));
    assert!(!bench.control.run(Millis::from_ms(1_000)));
    assert_eq!(bench.control.news(), Some(LogEvent::Unlinked));
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

/// Runs until nothing is to be done at once; the interrupt takes whatever is queued, the watchdog is as patient as is wanted.
fn settle(bench: &mut Bench, now_ms: u32) -> Vec<FromMind<16>> {
    let mut said = Vec::new();
    for _ in 0..10 {
        let wanted = bench.control.wants_patience();
        bench.control.note_patience(wanted);
        let more = bench.control.run(Millis::from_ms(now_ms));
        said.extend(bench.said());
        if !more && bench.control.mind.flash_task().is_none() {
            break;
        }
    }
    said
}

fn config_crc(bench: &mut Bench) -> u32 {
    bench.start();
    let [FromMind::Hello(hello)] = bench.said()[..] else {
        panic!("a hello");
    };
    hello.config_crc
}

#[test]
fn what_was_saved_is_there_after_the_next_start() {
    let mut bench = bench();
    let fresh = config_crc(&mut bench);
    bench.open();
    bench.ask(&ToMind::Parameter {
        parameter: Parameter::Far,
        value: Some(1_300),
    });
    bench.ask(&ToMind::Flash(Flash::Save));
    // Behind it in the queue: has to wait.
    bench.ask(&ToMind::Mode);
    let said = settle(&mut bench, 5);
    let tail = said.split_at(said.len() - 4).1;
    assert_eq!(
        tail,
        [
            FromMind::Busy {
                ms: persist::WRITE_MS
            },
            FromMind::Done { seq: 3 },
            FromMind::Mode(ModeReport::Idle),
            FromMind::Done { seq: 4 },
        ]
    );
    let mut next = bench_with(bench.control.store.expect("a store").into_flash());
    let saved = config_crc(&mut next);
    assert_ne!(saved, fresh);
    // Erased, and recalled: there is nothing.
    next.open();
    next.ask(&ToMind::Flash(Flash::Erase));
    next.ask(&ToMind::Flash(Flash::Recall));
    let said = settle(&mut next, 9);
    assert!(said.contains(&FromMind::Busy {
        ms: 2 * persist::ERASE_MS
    }));
    let why = Refusal::Flash(FlashError::Empty);
    assert!(
        said.contains(&FromMind::Refusal { seq: 3, why }),
        "{said:?}"
    );
    let mut last = bench_with(next.control.store.expect("a store").into_flash());
    assert_eq!(config_crc(&mut last), fresh);
}

#[test]
fn a_pause_waits_for_its_announcement_and_for_the_watchdog() {
    let mut bench = bench();
    bench.start();
    bench.open();
    bench.ask(&ToMind::Flash(Flash::Save));
    assert!(bench.control.run(Millis::from_ms(0)) && !bench.control.wants_patience());
    assert!(!bench.control.run(Millis::from_ms(0)) && bench.control.wants_patience());
    let _ = bench.said();
    // Writing alone may take longer than an impatient watchdog bears.
    assert!(!bench.control.run(Millis::from_ms(0)));
    assert_eq!(bench.generation(), 0);
    let _ = settle(&mut bench, 1);
    assert_eq!(bench.generation(), 1);
    // The sector takes one image: the next one goes into the other, which has to be erased.
    bench.ask(&ToMind::Flash(Flash::Save));
    assert!(bench.control.run(Millis::from_ms(2)) && !bench.control.wants_patience());
    for patient in [false, true] {
        // Nothing happens while the announcement waits in the queue.
        bench.control.note_patience(patient);
        assert!(!bench.control.run(Millis::from_ms(3)));
        assert!(bench.control.wants_patience());
    }
    let pause_ms = persist::WRITE_MS + persist::ERASE_MS;
    let said = bench.said();
    assert_eq!(said.last(), Some(&FromMind::Busy { ms: pause_ms }));
    bench.control.note_patience(false);
    assert!(!bench.control.run(Millis::from_ms(4)));
    assert_eq!(bench.generation(), 1);
    bench.control.note_patience(true);
    assert!(bench.control.run(Millis::from_ms(5)));
    assert_eq!(bench.said(), [FromMind::Done { seq: 3 }]);
    assert!(bench.generation() == 2 && !bench.control.wants_patience());
}

/// The ring's queue, whose near end the control task holds; the session takes its scans from there.
fn ringed(bench: Bench) -> (Bench, Producer<'static, Firing>) {
    let queue = forever(Queue::<Firing, 16>::new());
    let (near, far) = queue.split();
    let mut bench = Bench {
        control: bench.control.with_ring(far),
        ..bench
    };
    let identity = Identity {
        build: *b"testtest",
        reset: ResetCause::Panic,
        oscillator: Oscillator::Unknown,
        ring: true,
    };
    bench.control.start(identity, Millis::from_ms(0));
    bench.open();
    let _ = bench.control.run(Millis::from_ms(1));
    (bench, near)
}

/// These transducers hear something 2 m away.
fn fire(near: &mut Producer<'static, Firing>, transducers: core::ops::Range<u8>, at_ms: u32) {
    for sensor in transducers {
        let firing = Firing {
            sensor,
            range: Some(Range::from_mm(2_000)),
            at: Millis::from_ms(at_ms),
        };
        assert!(near.enqueue(firing).is_ok());
    }
}

/// The motion that was ordered, along and across.
fn motion(said: &[FromMind<16>]) -> Option<(i16, i16)> {
    said.iter().find_map(|said| match said {
        FromMind::Motion(order) => Some((order.dx_mm, order.dy_mm)),
        _ => None,
    })
}

fn listen(bench: &mut Bench, source: Source, now_ms: u32) {
    bench.ask(&ToMind::Source(source));
    let _ = bench.control.run(Millis::from_ms(now_ms));
}

#[test]
fn the_ring_fires_when_its_session_listens_to_it() {
    let (mut bench, _near) = ringed(bench());
    assert!(!bench.control.wants_ring());
    listen(&mut bench, Source::Ring, 2);
    assert!(bench.control.wants_ring());
    listen(&mut bench, Source::Link, 3);
    assert!(!bench.control.wants_ring());
}

/// A robot that explores moves when its ring is whole; what the ring heard before it was listened to does not count.
#[test]
fn what_the_ring_hears_reaches_the_mind_with_its_age() {
    let (mut bench, mut near) = ringed(bench());
    fire(&mut near, 0..15, 2);
    listen(&mut bench, Source::Link, 3);
    listen(&mut bench, Source::Ring, 4);
    bench.ask(&ToMind::Command {
        at_ms: 5,
        ttl_ms: 1_000,
        order: Order::Explore { moves: 3, seed: 1 },
    });
    let _ = bench.control.run(Millis::from_ms(5));
    bench.said();
    let last = Firing {
        sensor: 15,
        range: None,
        at: Millis::from_ms(6),
    };
    assert!(near.enqueue(last).is_ok());
    let _ = bench.control.run(Millis::from_ms(6));
    assert_eq!(motion(&bench.said()), None, "the others are unheard");
    fire(&mut near, 0..15, 7);
    let _ = bench.control.run(Millis::from_ms(40));
    assert!(motion(&bench.said()).is_some());
}

/// An erasure stops the ring's clock.
#[test]
fn the_ring_rests_while_flash_is_in_use() {
    let (mut bench, _near) = ringed(bench());
    listen(&mut bench, Source::Ring, 2);
    bench.ask(&ToMind::Flash(Flash::Save));
    let _ = bench.control.run(Millis::from_ms(3));
    let _ = bench.control.run(Millis::from_ms(4));
    assert!(!bench.control.wants_ring());
    for ms in 5..20 {
        bench.said();
        bench.control.note_patience(true);
        let _ = bench.control.run(Millis::from_ms(ms));
    }
    assert!(bench.control.wants_ring());
}

#[test]
fn a_board_without_flash_refuses_at_once_and_goes_on() {
    let mut bench = bench_on::<NoFlash>(None);
    bench.start();
    bench.open();
    assert!(!bench.control.run(Millis::from_ms(1)));
    let _ = bench.said();
    for task in [Flash::Save, Flash::Recall, Flash::Erase] {
        bench.ask(&ToMind::Flash(task));
        while bench.control.run(Millis::from_ms(2)) {}
        let said = bench.said();
        let absent = Refusal::Flash(FlashError::Absent);
        assert!(
            matches!(said[..], [FromMind::Refusal { why, .. }, FromMind::Done { .. }] if why == absent),
            "{task:?}: {said:?}"
        );
    }
}

/// A bench that explores for a linked host.
fn exploring() -> Bench {
    let bench = exploring_by(Clock::Device);
    assert!(bench.control.may_move(Millis::from_ms(2)));
    bench
}

fn exploring_by(clock: Clock) -> Bench {
    let mut bench = bench();
    bench.start();
    bench.open_by(clock);
    let _ = bench.control.run(Millis::from_ms(1));
    assert!(bench.control.is_linked() && !bench.control.may_move(Millis::from_ms(1)));
    bench.ask(&ToMind::Command {
        at_ms: 1,
        ttl_ms: 1_000,
        order: Order::Explore { moves: 10, seed: 1 },
    });
    let _ = bench.control.run(Millis::from_ms(2));
    let _ = bench.said();
    bench
}

/// In a session by the host's clock, as a bridge has one, the host is not lost while it is silent.
#[test]
fn the_motors_have_a_permit_only_while_the_host_is_heard_whichever_clock_counts() {
    for clock in [Clock::Device, Clock::Host] {
        let mut bench = exploring_by(clock);
        let permit_at = |bench: &mut Bench, ms: u32| {
            let _ = bench.control.run(Millis::from_ms(ms));
            bench.control.may_move(Millis::from_ms(ms))
        };
        // Last heard at 2 ms.
        assert!(permit_at(&mut bench, 302), "{clock:?}");
        assert!(!permit_at(&mut bench, 303), "{clock:?}");
        bench.ask(&ToMind::Alive { at_ms: 3 });
        // Who is lost has to resume; who was silent by the clock here alone has not.
        assert_eq!(permit_at(&mut bench, 600), clock == Clock::Host);
        assert!(!permit_at(&mut bench, 901), "{clock:?}");
    }
}

/// An order to go on and a whole ring come at once, before the lines are looked at again.
#[test]
fn nothing_moves_while_the_emergency_stop_is_open() {
    let open = Alarms {
        emergency_stop: true,
        ..Alarms::default()
    };
    for (alarms, moves) in [(Alarms::default(), true), (open, false)] {
        let mut bench = exploring();
        bench.ask(&ToMind::Command {
            at_ms: 2,
            ttl_ms: 1_000,
            order: Order::Stop,
        });
        let _ = bench.control.run(Millis::from_ms(3));
        let _ = bench.said();
        bench
            .control
            .apply_alarms(alarms, false, Millis::from_ms(4));
        bench.ask(&ToMind::Command {
            at_ms: 4,
            ttl_ms: 1_000,
            order: Order::Resume,
        });
        let echo = |sensor| Heard {
            sensor,
            range_mm: Some(1_500),
            age_ms: 0,
        };
        bench.ask(&ToMind::Scan {
            at_ms: 4,
            echoes: (0..16).map(echo).collect(),
        });
        let _ = bench.control.run(Millis::from_ms(4));
        let said = bench.said();
        let is_motion = |said: &FromMind<16>| matches!(said, FromMind::Motion(_));
        assert_eq!(said.iter().any(is_motion), moves, "{said:?}");
        assert_eq!(bench.control.may_move(Millis::from_ms(5)), moves);
    }
}

#[test]
fn alarms_of_the_lines_stop_the_robot_and_say_why() {
    let stop = Alarms {
        emergency_stop: true,
        ..Alarms::default()
    };
    let held = Alarms {
        bumper_open: true,
        ..Alarms::default()
    };
    for (alarms, low_voltage, reason) in [
        (held, false, StopReason::BumperOpen),
        (stop, false, StopReason::EmergencyStop),
        (Alarms::default(), true, StopReason::LowVoltage),
    ] {
        let mut bench = exploring();
        let now = Millis::from_ms(10);
        bench.control.apply_alarms(Alarms::default(), false, now);
        assert!(bench.control.may_move(now));
        bench.control.apply_alarms(alarms, low_voltage, now);
        assert!(!bench.control.may_move(now));
        let said = bench.said();
        let mode = FromMind::Mode(ModeReport::Stopped(reason));
        assert!(said.contains(&mode), "{said:?}");
    }
}

#[test]
fn a_touch_ends_the_motion_under_way_and_nothing_else() {
    let (mut bench, mut near) = ringed(bench());
    listen(&mut bench, Source::Ring, 2);
    bench.ask(&ToMind::Command {
        at_ms: 3,
        ttl_ms: 1_000,
        order: Order::Explore { moves: 10, seed: 1 },
    });
    let _ = bench.control.run(Millis::from_ms(3));
    let touched = Alarms {
        touched: true,
        ..Alarms::default()
    };
    let touch = |bench: &mut Bench| {
        let now = Millis::from_ms(60);
        let _ = bench.said();
        bench.control.apply_alarms(touched, false, now);
        assert!(bench.control.may_move(now));
        motion(&bench.said())
    };
    assert_eq!(touch(&mut bench), None, "it stands");
    // The queue has no room for all sixteen.
    fire(&mut near, 0..8, 4);
    let _ = bench.control.run(Millis::from_ms(30));
    fire(&mut near, 8..16, 4);
    let _ = bench.control.run(Millis::from_ms(50));
    let ordered = motion(&bench.said()).expect("a motion");
    assert_ne!(ordered, (0, 0));
    let now = Millis::from_ms(55);
    bench.control.apply_alarms(Alarms::default(), false, now);
    assert_eq!(motion(&bench.said()), None, "nothing was touched");
    assert_eq!(touch(&mut bench), Some((0, 0)));
    assert_eq!(touch(&mut bench), None, "it stands again");
}
