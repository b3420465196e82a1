use super::*;
use crate::persist::{self, sim::SimFlash};
use amp::body::HeldRing;
use amp::parameters::Parameter;
use amp::units::Range;
use amp::wire::frame::{Header, unpack};
use amp::wire::message::{
    Clock, Counters, Dimensions, HostHello, ModeReport, Oscillator, Refusal, ResetCause,
    RobotCommand, TimedEcho,
};
use amp::wire::{DeviceMessage, Frame, HostMessage, PROTOCOL, Report, SCHEMA};
use heapless::spsc::{Producer, Queue};
use std::boxed::Box;
use std::vec::Vec;

/// A control task between two queues; the test holds their other ends.
struct ControlBench<F = Sectors> {
    control: Control<'static, HeldRing, F>,
    incoming: Producer<'static, u8>,
    outgoing: Consumer<'static, u8>,
    seq: u16,
}

fn leak<T>(value: T) -> &'static mut T {
    Box::leak(Box::new(value))
}

type Sectors = SimFlash<{ 12 + 8_256 }>;

fn bench() -> ControlBench {
    bench_with_flash(Sectors::new(1))
}

fn bench_with_flash(flash: Sectors) -> ControlBench {
    bench_with_store(Some(Store::mount(flash, 8_256)))
}

fn bench_with_store<F: NorFlash>(store: Option<Store<F>>) -> ControlBench<F> {
    let received = leak(Queue::<u8, 512>::new());
    let to_send = leak(Queue::<u8, 2048>::new());
    let node = leak(RobotNode::new());
    let errors = leak(ErrorCounters::new());
    let (incoming, received) = received.split();
    let (to_send, outgoing) = to_send.split();
    ControlBench {
        control: Control::new(node, received, TxQueue::new(to_send), errors, store),
        incoming,
        outgoing,
        seq: 0,
    }
}

impl<F: NorFlash> ControlBench<F> {
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

    fn send_request(&mut self, message: &HostMessage<16>) {
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
        self.send_request(&HostMessage::Hello(HostHello {
            dimensions,
            clock,
            open_space: false,
        }));
    }

    /// The reports sent since the last call.
    fn take_reports(&mut self) -> Vec<DeviceMessage<16>> {
        let mut receiver = Receiver::new();
        let mut reports = Vec::new();
        while let Some(byte) = self.outgoing.dequeue() {
            if let Some(frame) = receiver.push(byte) {
                let (_, report) = unpack::<Report<16>>(frame).expect("a sound frame");
                reports.push(report.message);
            }
        }
        reports
    }

    fn counters(&mut self, now_ms: u32) -> Counters {
        self.send_request(&HostMessage::Counters);
        assert!(!self.control.run(Millis::from_ms(now_ms)));
        let reports = self.take_reports();
        let counters = reports.iter().find_map(|report| match report {
            DeviceMessage::Counters(counters) => Some(*counters),
            _ => None,
        });
        counters.expect("the counters")
    }
}

#[test]
fn a_start_sends_a_hello_with_build_and_reset_cause() {
    let mut bench = bench();
    bench.start();
    assert!(bench.control.take_queued() && !bench.control.take_queued());
    let [DeviceMessage::Hello(hello)] = bench.take_reports()[..] else {
        panic!("a hello");
    };
    assert_eq!(
        (&hello.build, hello.reset),
        (b"testtest", ResetCause::Panic)
    );
}

#[test]
fn frames_are_answered_and_device_counters_reported() {
    let mut bench = bench();
    bench.start();
    bench.open();
    assert!(!bench.control.run(Millis::from_ms(7)));
    assert!(bench.control.is_linked());
    assert_eq!(bench.control.next_log_event(), Some(LogEvent::Linked));
    assert_eq!(bench.control.next_log_event(), None);
    bench.take_reports();
    bench.control.set_stack_peak(1_234);
    let counters = bench.counters(30);
    assert_eq!(counters.accepted, 2);
    assert_eq!(counters.device.stack_peak_bytes, 1_234);
    assert_eq!(counters.device.ticks, 2);
    assert_eq!(counters.device.longest_tick_ms, 23);
}

#[test]
fn a_silent_host_is_a_log_event() {
    let mut bench = bench();
    bench.start();
    bench.open();
    assert!(!bench.control.run(Millis::from_ms(0)));
    assert_eq!(bench.control.next_log_event(), Some(LogEvent::Linked));
    assert!(!bench.control.run(Millis::from_ms(1_000)));
    assert_eq!(bench.control.next_log_event(), Some(LogEvent::Unlinked));
}

#[test]
fn garbage_is_counted_and_the_next_frame_accepted() {
    let mut bench = bench();
    bench.start();
    bench.open();
    bench.receive(&[7; 300]);
    bench.receive(&[0, 3, 1, 2, 0]);
    assert!(!bench.control.run(Millis::from_ms(1)));
    let counters = bench.counters(2);
    // The Hello and the request; the oversized frame; the malformed one.
    let counted = (counters.accepted, counters.oversized, counters.malformed);
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

/// Runs until no work is left. Every queued byte is sent, and timeout requests are granted.
fn settle(bench: &mut ControlBench, now_ms: u32) -> Vec<DeviceMessage<16>> {
    let mut reports = Vec::new();
    for _ in 0..10 {
        let requested = bench.control.needs_long_timeout();
        bench.control.set_has_long_timeout(requested);
        let more = bench.control.run(Millis::from_ms(now_ms));
        reports.extend(bench.take_reports());
        if !more && bench.control.node.flash_task().is_none() {
            break;
        }
    }
    reports
}

fn config_crc(bench: &mut ControlBench) -> u32 {
    bench.start();
    let [DeviceMessage::Hello(hello)] = bench.take_reports()[..] else {
        panic!("a hello");
    };
    hello.config_crc
}

#[test]
fn a_saved_image_is_loaded_at_the_next_start() {
    let mut bench = bench();
    let fresh = config_crc(&mut bench);
    bench.open();
    bench.send_request(&HostMessage::Parameter {
        parameter: Parameter::Far,
        value: Some(1_300),
    });
    bench.send_request(&HostMessage::Flash(FlashOperation::Save));
    // Waits in the queue behind the save.
    bench.send_request(&HostMessage::Mode);
    let reports = settle(&mut bench, 5);
    let tail = reports.split_at(reports.len() - 4).1;
    assert_eq!(
        tail,
        [
            DeviceMessage::Busy { ms: 207 },
            DeviceMessage::Done { seq: 3 },
            DeviceMessage::Mode(ModeReport::Idle),
            DeviceMessage::Done { seq: 4 },
        ]
    );
    let mut next = bench_with_flash(bench.control.store.expect("a store").into_flash());
    let saved = config_crc(&mut next);
    assert_ne!(saved, fresh);
    // After the erasure there is nothing to load.
    next.open();
    next.send_request(&HostMessage::Flash(FlashOperation::Erase));
    next.send_request(&HostMessage::Flash(FlashOperation::Load));
    let reports = settle(&mut next, 9);
    assert!(reports.contains(&DeviceMessage::Busy {
        ms: 2 * persist::ERASE_MS
    }));
    let reason = Refusal::Flash(FlashError::Empty);
    assert!(
        reports.contains(&DeviceMessage::Refusal { seq: 3, reason }),
        "{reports:?}"
    );
    let mut last = bench_with_flash(next.control.store.expect("a store").into_flash());
    assert_eq!(config_crc(&mut last), fresh);
}

#[test]
fn a_pause_waits_for_its_announcement_and_for_the_watchdog() {
    let mut bench = bench();
    bench.start();
    bench.open();
    bench.send_request(&HostMessage::Flash(FlashOperation::Save));
    assert!(bench.control.run(Millis::from_ms(0)) && !bench.control.needs_long_timeout());
    assert!(!bench.control.run(Millis::from_ms(0)) && bench.control.needs_long_timeout());
    let _ = bench.take_reports();
    // Writing alone may exceed the normal timeout.
    assert!(!bench.control.run(Millis::from_ms(0)));
    assert_eq!(bench.generation(), 0);
    let _ = settle(&mut bench, 1);
    assert_eq!(bench.generation(), 1);
    // The sector holds one image: the next save erases the other sector.
    bench.send_request(&HostMessage::Flash(FlashOperation::Save));
    assert!(bench.control.run(Millis::from_ms(2)) && !bench.control.needs_long_timeout());
    for has_long_timeout in [false, true] {
        // Nothing happens until the announcement is sent.
        bench.control.set_has_long_timeout(has_long_timeout);
        assert!(!bench.control.run(Millis::from_ms(3)));
        assert!(bench.control.needs_long_timeout());
    }
    let pause_ms = 207 + persist::ERASE_MS;
    let reports = bench.take_reports();
    assert_eq!(reports.last(), Some(&DeviceMessage::Busy { ms: pause_ms }));
    bench.control.set_has_long_timeout(false);
    assert!(!bench.control.run(Millis::from_ms(4)));
    assert_eq!(bench.generation(), 1);
    bench.control.set_has_long_timeout(true);
    assert!(bench.control.run(Millis::from_ms(5)));
    assert_eq!(bench.take_reports(), [DeviceMessage::Done { seq: 3 }]);
    assert!(bench.generation() == 2 && !bench.control.needs_long_timeout());
}

/// A bench with a ring of its own, and the ring's end of the queue. The session uses the ring.
fn ringed(bench: ControlBench) -> (ControlBench, Producer<'static, RingReading>) {
    let queue = leak(Queue::<RingReading, 16>::new());
    let (near, far) = queue.split();
    let mut bench = ControlBench {
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

/// Readings of 2 m from these transducers.
fn fire(near: &mut Producer<'static, RingReading>, transducers: core::ops::Range<u8>, at_ms: u32) {
    for sensor in transducers {
        let firing = RingReading {
            sensor,
            range: Some(Range::from_mm(2_000)),
            at: Millis::from_ms(at_ms),
        };
        assert!(near.enqueue(firing).is_ok());
    }
}

/// The commanded displacement, dx and dy.
fn motion(reports: &[DeviceMessage<16>]) -> Option<(i16, i16)> {
    reports.iter().find_map(|report| match report {
        DeviceMessage::Motion(command) => Some((command.dx_mm, command.dy_mm)),
        _ => None,
    })
}

fn listen(bench: &mut ControlBench, source: Source, now_ms: u32) {
    bench.send_request(&HostMessage::Source(source));
    let _ = bench.control.run(Millis::from_ms(now_ms));
}

#[test]
fn the_ring_fires_when_it_is_the_source() {
    let (mut bench, _near) = ringed(bench());
    assert!(!bench.control.needs_ring());
    listen(&mut bench, Source::Ring, 2);
    assert!(bench.control.needs_ring());
    listen(&mut bench, Source::Link, 3);
    assert!(!bench.control.needs_ring());
}

/// An exploring robot moves when its ring is complete. Readings from before the source was
/// chosen do not count.
#[test]
fn ring_readings_reach_the_node_with_their_age() {
    let (mut bench, mut near) = ringed(bench());
    fire(&mut near, 0..15, 2);
    listen(&mut bench, Source::Link, 3);
    listen(&mut bench, Source::Ring, 4);
    bench.send_request(&HostMessage::Command {
        at_ms: 5,
        ttl_ms: 1_000,
        command: RobotCommand::Explore { moves: 3, seed: 1 },
    });
    let _ = bench.control.run(Millis::from_ms(5));
    bench.take_reports();
    let last = RingReading {
        sensor: 15,
        range: None,
        at: Millis::from_ms(6),
    };
    assert!(near.enqueue(last).is_ok());
    let _ = bench.control.run(Millis::from_ms(6));
    assert_eq!(
        motion(&bench.take_reports()),
        None,
        "the others are unheard"
    );
    fire(&mut near, 0..15, 7);
    let _ = bench.control.run(Millis::from_ms(40));
    assert!(motion(&bench.take_reports()).is_some());
}

/// An erasure stops the ring's timer.
#[test]
fn the_ring_rests_while_flash_is_in_use() {
    let (mut bench, _near) = ringed(bench());
    listen(&mut bench, Source::Ring, 2);
    bench.send_request(&HostMessage::Flash(FlashOperation::Save));
    let _ = bench.control.run(Millis::from_ms(3));
    let _ = bench.control.run(Millis::from_ms(4));
    assert!(!bench.control.needs_ring());
    for ms in 5..20 {
        bench.take_reports();
        bench.control.set_has_long_timeout(true);
        let _ = bench.control.run(Millis::from_ms(ms));
    }
    assert!(bench.control.needs_ring());
}

#[test]
fn a_board_without_flash_refuses_at_once_and_continues() {
    let mut bench = bench_with_store::<NoFlash>(None);
    bench.start();
    bench.open();
    assert!(!bench.control.run(Millis::from_ms(1)));
    let _ = bench.take_reports();
    for task in [
        FlashOperation::Save,
        FlashOperation::Load,
        FlashOperation::Erase,
    ] {
        bench.send_request(&HostMessage::Flash(task));
        while bench.control.run(Millis::from_ms(2)) {}
        let reports = bench.take_reports();
        let absent = Refusal::Flash(FlashError::NoFlash);
        assert!(
            matches!(reports[..], [DeviceMessage::Refusal { reason, .. }, DeviceMessage::Done { .. }] if reason == absent),
            "{task:?}: {reports:?}"
        );
    }
}

/// A bench that explores with a connected host.
fn exploring() -> ControlBench {
    let bench = exploring_by(Clock::Device);
    assert!(bench.control.may_move(Millis::from_ms(2)));
    bench
}

fn exploring_by(clock: Clock) -> ControlBench {
    let mut bench = bench();
    bench.start();
    bench.open_by(clock);
    let _ = bench.control.run(Millis::from_ms(1));
    assert!(bench.control.is_linked() && !bench.control.may_move(Millis::from_ms(1)));
    bench.send_request(&HostMessage::Command {
        at_ms: 1,
        ttl_ms: 1_000,
        command: RobotCommand::Explore { moves: 10, seed: 1 },
    });
    let _ = bench.control.run(Millis::from_ms(2));
    let _ = bench.take_reports();
    bench
}

/// In a session by the host's clock, as in a bridge, a silent host is not lost.
#[test]
fn the_permit_requires_a_recently_heard_host_with_either_clock() {
    for clock in [Clock::Device, Clock::Host] {
        let mut bench = exploring_by(clock);
        let permit_at = |bench: &mut ControlBench, ms: u32| {
            let _ = bench.control.run(Millis::from_ms(ms));
            bench.control.may_move(Millis::from_ms(ms))
        };
        // The host was last heard at 2 ms.
        assert!(permit_at(&mut bench, 302), "{clock:?}");
        assert!(!permit_at(&mut bench, 303), "{clock:?}");
        bench.send_request(&HostMessage::Alive { at_ms: 3 });
        // By the device's clock the host is lost and must resume; by the host's clock it is not.
        assert_eq!(permit_at(&mut bench, 600), clock == Clock::Host);
        assert!(!permit_at(&mut bench, 901), "{clock:?}");
    }
}

/// A Resume and a complete ring arrive together, before the safety lines are read again.
#[test]
fn nothing_moves_while_the_emergency_stop_is_open() {
    let open = Alarms {
        emergency_stop: true,
        ..Alarms::default()
    };
    for (alarms, moves) in [(Alarms::default(), true), (open, false)] {
        let mut bench = exploring();
        bench.send_request(&HostMessage::Command {
            at_ms: 2,
            ttl_ms: 1_000,
            command: RobotCommand::Stop,
        });
        let _ = bench.control.run(Millis::from_ms(3));
        let _ = bench.take_reports();
        bench
            .control
            .apply_alarms(alarms, false, Millis::from_ms(4));
        bench.send_request(&HostMessage::Command {
            at_ms: 4,
            ttl_ms: 1_000,
            command: RobotCommand::Resume,
        });
        let echo = |sensor| TimedEcho {
            sensor,
            range_mm: Some(1_500),
            age_ms: 0,
        };
        bench.send_request(&HostMessage::Scan {
            at_ms: 4,
            echoes: (0..16).map(echo).collect(),
        });
        let _ = bench.control.run(Millis::from_ms(4));
        let reports = bench.take_reports();
        let is_motion = |report: &DeviceMessage<16>| matches!(report, DeviceMessage::Motion(_));
        assert_eq!(reports.iter().any(is_motion), moves, "{reports:?}");
        assert_eq!(bench.control.may_move(Millis::from_ms(5)), moves);
    }
}

#[test]
fn alarms_stop_the_robot_and_report_the_reason() {
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
        let reports = bench.take_reports();
        let mode = DeviceMessage::Mode(ModeReport::Stopped(reason));
        assert!(reports.contains(&mode), "{reports:?}");
    }
}

#[test]
fn a_touch_ends_the_motion_under_way_and_nothing_else() {
    let (mut bench, mut near) = ringed(bench());
    listen(&mut bench, Source::Ring, 2);
    bench.send_request(&HostMessage::Command {
        at_ms: 3,
        ttl_ms: 1_000,
        command: RobotCommand::Explore { moves: 10, seed: 1 },
    });
    let _ = bench.control.run(Millis::from_ms(3));
    let touched = Alarms {
        touched: true,
        ..Alarms::default()
    };
    let touch = |bench: &mut ControlBench| {
        let now = Millis::from_ms(60);
        let _ = bench.take_reports();
        bench.control.apply_alarms(touched, false, now);
        assert!(bench.control.may_move(now));
        motion(&bench.take_reports())
    };
    assert_eq!(touch(&mut bench), None, "it stands");
    // The queue has no room for all sixteen.
    fire(&mut near, 0..8, 4);
    let _ = bench.control.run(Millis::from_ms(30));
    fire(&mut near, 8..16, 4);
    let _ = bench.control.run(Millis::from_ms(50));
    let ordered = motion(&bench.take_reports()).expect("a motion");
    assert_ne!(ordered, (0, 0));
    let now = Millis::from_ms(55);
    bench.control.apply_alarms(Alarms::default(), false, now);
    assert_eq!(motion(&bench.take_reports()), None, "nothing was touched");
    assert_eq!(touch(&mut bench), Some((0, 0)));
    assert_eq!(touch(&mut bench), None, "it stands again");
}
