//! The constants and the example session of PROTOCOL.md are those of the program.

use super::*;
use crate::controller::supervise::{SILENT_RINGS, SLACK_MS};
use crate::goal::MAX_NAMED_GOALS;
use crate::link::offset::{SLOT_MS, SLOTS};
use crate::node::reply_cache;
use crate::wire::frame::MAX_FRAME;
use crate::wire::message::{MAX_CHUNK, MAX_ECHOES};
use crate::wire::tests::document::{DOCUMENT, check_block};
use std::format;
use std::string::String;

/// Samples that a node's memory holds.
const fn samples<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>(
    _: &Node<SENSORS, NEURONS, SAMPLES>,
) -> usize {
    SAMPLES
}

#[test]
fn documented_constants_are_those_of_the_program() {
    let config = Config::recommended();
    let (_, section) = DOCUMENT.split_once("\n## Constants\n").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let found: Vec<_> = section
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| value"))
        .filter_map(|line| line.trim_matches(['|', ' ']).split_once(" | "))
        .map(|(value, _)| value.replace(' ', ""))
        .collect();
    let wanted = [
        format!("{MAX_FRAME}bytes"),
        format!("{MAX_CHUNK}bytes"),
        format!("{MAX_ECHOES}echoes"),
        format!("{MAX_CONFIG}bytes"),
        format!("{}bytes", reply_cache::MAX_BYTES),
        format!("{MAX_NAMED_GOALS}goals"),
        format!("{SILENCE_MS}ms"),
        format!("{MOTION_TTL_MS}ms"),
        format!("{RENEWAL_MS}ms"),
        format!("{SLACK_MS}ms"),
        format!("{}ms", SLOTS as u32 * SLOT_MS),
        format!("{SILENT_RINGS}rings"),
        format!("{}ms", 2 * config.robot.ring_period_ms),
        format!("{}ms", config.robot.steer_ms),
        format!("{}mm", config.robot.step_mm),
        format!("{}mm", config.robot.face_radius_mm),
        format!("{}samples", samples(&NomadNode::new())),
    ];
    assert_eq!(found, wanted);
    let sentences = [
        format!("has at most {MAX_FRAME} bytes"),
        format!("of more than {MAX_CHUNK} bytes"),
        format!("of more than {MAX_ECHOES} echoes"),
        format!(
            "keeps {} bytes of its latest answer",
            reply_cache::MAX_BYTES
        ),
        format!("at least every {SILENCE_MS} ms"),
        format!("time to live of {MOTION_TTL_MS} ms"),
        format!("under way every {RENEWAL_MS} ms"),
        format!("÷ speed + {SLACK_MS} ms"),
        format!("at most {MAX_NAMED_GOALS}\ngoals"),
    ];
    for sentence in sentences {
        assert!(DOCUMENT.contains(&sentence), "{sentence}");
    }
}

/// A host and a node, with a record of every frame.
struct Session {
    node: NomadNode,
    seq: u16,
    at_ms: u32,
    record: String,
}

/// Frames that are recorded as they are sent.
struct Recorder<'a> {
    record: &'a mut String,
    reports: Vec<DeviceMessage<16>>,
}

impl FrameSink for Recorder<'_> {
    fn send(&mut self, bytes: &[u8]) -> bool {
        let (_, coded) = bytes.split_last().unwrap();
        let (header, report) = frame::unpack::<Report<16>>(coded).unwrap();
        let (device_ms, said) = (report.device_ms, report.message);
        let words = format!("{device_ms} ms {said:?}");
        record(self.record, "device", bytes, header, &words);
        self.reports.push(said);
        true
    }
}

fn record(record: &mut String, from: &str, bytes: &[u8], header: Header, words: &str) {
    let hex: Vec<_> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    let Header { session, seq } = header;
    *record += &format!(
        "{from:6} {}\n       {session}, {seq}: {words}\n",
        hex.join(" ")
    );
}

impl Session {
    fn new() -> Self {
        let mut session = Self {
            node: NomadNode::new(),
            seq: 0,
            at_ms: 1_000,
            record: String::new(),
        };
        session.title("The device starts.");
        let mut out = Recorder {
            record: &mut session.record,
            reports: Vec::new(),
        };
        let identity = Identity {
            build: *b"1a2b3c4d",
            reset: ResetCause::PowerOn,
            ..Identity::default()
        };
        let grid = Grid::rectangle(4, 4);
        let config = Config::recommended();
        session
            .node
            .start(&config, grid, identity, Millis::from_ms(0), &mut out);
        session
    }

    fn title(&mut self, title: &str) {
        self.record += &format!(
            "{}# {title}\n",
            if self.record.is_empty() { "" } else { "\n" }
        );
    }

    fn send(&mut self, message: &HostMessage<16>) -> Vec<DeviceMessage<16>> {
        self.seq += 1;
        let header = Header {
            session: 300,
            seq: self.seq,
        };
        let frame = Frame::pack(header, message).unwrap();
        record(
            &mut self.record,
            "host",
            frame.as_bytes(),
            header,
            &format!("{message:?}"),
        );
        let mut out = Recorder {
            record: &mut self.record,
            reports: Vec::new(),
        };
        let (_, coded) = frame.as_bytes().split_last().unwrap();
        self.node.frame(Millis::from_ms(0), coded, &mut out);
        out.reports
    }

    fn command(&mut self, command: RobotCommand<16>) -> Vec<DeviceMessage<16>> {
        self.at_ms += 100;
        let (at_ms, ttl_ms) = (self.at_ms, 1_000);
        self.send(&HostMessage::Command {
            at_ms,
            ttl_ms,
            command,
        })
    }

    /// A whole ring in one frame; transducer 5 hears nothing.
    fn scan(&mut self, nearest_mm: u16) -> MotionCommand {
        self.at_ms += 100;
        let echoes = (0..16_u8).map(|sensor| TimedEcho {
            sensor,
            range_mm: (sensor != 5).then(|| nearest_mm + 90 * u16::from(sensor)),
            age_ms: 0,
        });
        let said = self.send(&HostMessage::Scan {
            at_ms: self.at_ms,
            echoes: echoes.collect(),
        });
        motion(&said).unwrap_or(MotionCommand {
            id: 0,
            revision: 0,
            dx_mm: 0,
            dy_mm: 0,
            speed_mm_s: 0,
            ttl_ms: 0,
        })
    }

    fn odometry(&mut self, motion: u16, dx_mm: i16, dy_mm: i16, progress: Progress) {
        self.at_ms += 150;
        self.send(&HostMessage::Odometry {
            at_ms: self.at_ms,
            motion,
            dx_mm,
            dy_mm,
            turned: 0,
            progress,
        });
    }
}

fn session() -> String {
    let mut s = Session::new();
    s.title("The host opens a session. No Done.");
    s.send(&HostMessage::Hello(HostHello {
        dimensions: NomadNode::dimensions(),
        clock: Clock::Host,
        open_space: false,
    }));
    s.title("One random move.");
    s.command(RobotCommand::Explore { moves: 1, seed: 9 });
    s.title("A whole ring: the decision, the motion, Done.");
    let command = s.scan(700);
    assert_ne!((command.dx_mm, command.dy_mm), (0, 0));
    s.title("Halfway.");
    let (dx, dy) = (command.dx_mm / 2, command.dy_mm / 2);
    s.odometry(command.id, dx, dy, Progress::Moving);
    s.title("A sign of life without an answer of its own: the motion is renewed after 200 ms.");
    s.at_ms += 100;
    s.send(&HostMessage::Alive { at_ms: s.at_ms });
    s.title("The rest of the way. The motion has ended.");
    s.odometry(
        command.id,
        command.dx_mm - dx,
        command.dy_mm - dy,
        Progress::Ended,
    );
    s.title("The ring after the move completes the sample.");
    s.scan(650);
    s.title("The maps are made. The mode becomes Idle when they are.");
    s.command(RobotCommand::Learn);
    let mut out = Recorder {
        record: &mut s.record,
        reports: Vec::new(),
    };
    let mut ticks = 0..10_000;
    assert!(ticks.any(|_| !s.node.tick(Millis::from_ms(0), &mut out)));
    s.title("A goal, and towards it.");
    s.command(RobotCommand::Goal(GoalSpec::Avoid));
    s.command(RobotCommand::Seek);
    s.scan(500);
    s.title("Stop: the base stands, the mode says why.");
    s.command(RobotCommand::Stop);
    s.record
}

#[test]
#[cfg_attr(miri, ignore = "it writes or compares a file, after a hundred epochs")]
fn the_documented_session_is_what_is_sent() {
    check_block("session", &session());
}

/// The device takes 160 bytes and answers; 161 are no message, and their number is not used.
#[test]
fn a_write_beyond_the_limit_gets_no_answer() {
    let mut rig = Rig::new(Clock::Device);
    let mut write = |seq: u16, bytes: &[u8]| {
        let header = Header {
            session: SESSION,
            seq,
        };
        let (write, actions, offset, last) = (6_u8, 3_u8, 0_u16, false);
        let frame = Frame::pack(header, &(write, actions, offset, bytes, last)).unwrap();
        rig.raw(frame.as_bytes().split_last().unwrap().1)
    };
    assert!(write(2, &[0; 161]).is_empty());
    let said = write(2, &[0; 160]);
    // Sound, though it reaches beyond the part's 128 bytes.
    assert!(matches!(
        said[..],
        [
            DeviceMessage::Refusal { seq: 2, .. },
            DeviceMessage::Done { seq: 2 }
        ]
    ));
    assert_eq!(
        (rig.node.counters().unknown, rig.node.counters().replayed),
        (1, 0)
    );
}

/// The next round waits for the end of a motion to where the base stands.
#[test]
fn a_motion_of_no_length_has_to_be_reported_as_well() {
    for is_reported in [true, false] {
        let mut rig = Rig::ready(Clock::Device);
        rig.command(RobotCommand::Seek);
        rig.now += 200;
        // So near that the shield allows no way at all.
        let command = motion(&rig.ring(0)).unwrap();
        assert_eq!((command.dx_mm, command.dy_mm), (0, 0));
        let began = rig.now;
        if is_reported {
            rig.carried_out(command);
        }
        rig.now += 200;
        assert_eq!(motion(&rig.ring(0)).is_some(), is_reported);
        for after_ms in [400, 600, 800, 1_000, 1_001] {
            rig.now = began + after_ms;
            let at_ms = rig.at_ms();
            rig.send(HostMessage::Alive { at_ms });
            let stopped = is_stopped(&rig.tick().1, StopReason::Overdue);
            assert_eq!(stopped, !is_reported && after_ms == 1_001, "{after_ms}");
        }
    }
}
