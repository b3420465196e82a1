use super::frame::{MAX_FRAME, unpack};
use super::message::{
    Clock, Counters, DeviceCounters, DeviceHello, Dimensions, FlashError, FlashOperation, GoalSpec,
    HostHello, LogEvent, ModeReport, MotionCommand, Oscillator, Refusal, ResetCause, RobotCommand,
    Source, TimedEcho, TransferPart,
};
use super::*;
use crate::config::Config;
use crate::controller::{CommandRefusal, Decision, Progress, StopReason, TransferError};
use crate::faults::SensorFault;
use crate::fixed::Weight;
use crate::goal::{Component, Goal, GoalFrame, Name};
use crate::parameters::{Parameter, ParameterError};
use crate::planner::{Plan, Why};
use crate::units::Displacement;
use core::fmt::Debug;
use heapless::Vec;
use proptest::prelude::*;
use serde::{Serialize, de::DeserializeOwned};
use std::format;
use std::string::String;

pub(crate) mod document;

const HEADER: Header = Header {
    session: 300,
    seq: 7,
};
const OURS: Dimensions = Dimensions {
    protocol: PROTOCOL,
    schema: 0x1234_5678,
    sensors: 16,
    neurons: 16,
};

fn dimensions() -> Dimensions {
    OURS
}

fn situation(first: i16) -> [Weight; 16] {
    core::array::from_fn(|i| Weight::from_bits(first - 500 * i as i16))
}

fn to_device() -> std::vec::Vec<(&'static str, HostMessage<16>)> {
    let nest = Name::new("nest").unwrap();
    let command = |command| HostMessage::Command {
        at_ms: 1_500,
        ttl_ms: 1_000,
        command,
    };
    let echoes = [Some(1_250), None].into_iter().enumerate();
    let echoes = echoes.map(|(sensor, range_mm)| TimedEcho {
        sensor: sensor as u8,
        range_mm,
        age_ms: 40,
    });
    let goal = Goal {
        frame: GoalFrame::Travel,
        progress_q16: 8_700,
        heading_hold_q16: 1_300,
        ..Goal::of(core::array::from_fn(|i| match i {
            0 => Component::at_most(Weight::from_bits(4_096)),
            12 => Component::equal(Weight::from_bits(7_000)),
            _ => Component::ANY,
        }))
    };
    std::vec![
        (
            "hello",
            HostMessage::Hello(HostHello {
                dimensions: dimensions(),
                clock: Clock::Device,
                open_space: false,
            })
        ),
        ("alive", HostMessage::Alive { at_ms: 1_400 }),
        (
            "scan",
            HostMessage::Scan {
                at_ms: 1_500,
                echoes: echoes.collect()
            }
        ),
        (
            "odometry",
            HostMessage::Odometry {
                at_ms: 1_500,
                motion: 9,
                dx_mm: -125,
                dy_mm: 60,
                turned: 65_000,
                progress: Progress::Ended,
            }
        ),
        ("goal: avoid", command(RobotCommand::Goal(GoalSpec::Avoid))),
        (
            "goal: perceived",
            command(RobotCommand::Goal(GoalSpec::Perceived))
        ),
        (
            "goal: situation",
            command(RobotCommand::Goal(GoalSpec::Situation(
                core::array::from_fn(|i| 16 * i as u8)
            )))
        ),
        (
            "goal: components",
            command(RobotCommand::Goal(GoalSpec::Components(goal)))
        ),
        (
            "explore",
            command(RobotCommand::Explore {
                moves: 100,
                seed: 0xdead_beef
            })
        ),
        ("learn", command(RobotCommand::Learn)),
        ("seek", command(RobotCommand::Seek)),
        ("stop", command(RobotCommand::Stop)),
        ("resume", command(RobotCommand::Resume)),
        ("forget", command(RobotCommand::Forget)),
        (
            "read",
            HostMessage::Read {
                part: TransferPart::Situations,
                offset: 320
            }
        ),
        (
            "write",
            HostMessage::Write {
                part: TransferPart::Actions,
                offset: 4,
                bytes: Vec::from_slice(&[0, 0, 0, 0x20]).unwrap(),
                last: false,
            }
        ),
        ("counters", HostMessage::Counters),
        (
            "parameter: read",
            HostMessage::Parameter {
                parameter: Parameter::Margin,
                value: None
            }
        ),
        (
            "parameter: set",
            HostMessage::Parameter {
                parameter: Parameter::Speed,
                value: Some(300)
            }
        ),
        ("source", HostMessage::Source(Source::Ring)),
        ("mode", HostMessage::Mode),
        (
            "goal: saved",
            command(RobotCommand::Goal(GoalSpec::Saved(nest)))
        ),
        ("flash: save", HostMessage::Flash(FlashOperation::Save)),
        ("flash: load", HostMessage::Flash(FlashOperation::Load)),
        ("flash: erase", HostMessage::Flash(FlashOperation::Erase)),
        ("save goal", HostMessage::SaveGoal { name: nest }),
        ("delete goal", HostMessage::DeleteGoal { name: nest }),
        ("list goals", HostMessage::ListGoals),
    ]
}

fn from_device() -> std::vec::Vec<(&'static str, DeviceMessage<16>)> {
    let moved = |dx_mm, dy_mm| Displacement { dx_mm, dy_mm };
    let plan = Plan {
        goal_neuron: 3,
        current_neuron: 12,
        subgoal_neuron: 8,
        wanted: situation(-100),
        action_neuron: 5,
        at_goal: false,
        recalled: true,
        action: moved(-200, 150),
        why: Why::Neighbor,
    };
    let decision = |plan| {
        DeviceMessage::Decision(Decision {
            situation: situation(8_192),
            plan,
            wanted: moved(-200, 150),
            allowed: moved(-40, 30),
            at_goal: false,
        })
    };
    let counters = Counters {
        accepted: 1_000,
        crc_errors: 2,
        sent: 3_000,
        device: DeviceCounters {
            stack_peak_bytes: 3_100,
            ticks: 70_000,
            ..DeviceCounters::default()
        },
        ..Counters::default()
    };
    let refused = |reason| DeviceMessage::Refusal { seq: 6, reason };
    let spec = Parameter::Speed.spec();
    std::vec![
        (
            "hello",
            DeviceMessage::Hello(DeviceHello {
                dimensions: dimensions(),
                samples: 100,
                build: *b"1a2b3c4d",
                reset: ResetCause::StackOverflow,
                oscillator: Oscillator::Internal,
                config_crc: 1,
                maps_crc: 0xffff_ffff,
                memory_crc: 0,
            })
        ),
        (
            "motion",
            DeviceMessage::Motion(MotionCommand {
                id: 10,
                revision: 1,
                dx_mm: -40,
                dy_mm: 30,
                speed_mm_s: 250,
                ttl_ms: 500,
            })
        ),
        ("decision: random move", decision(None)),
        ("decision: plan", decision(Some(plan))),
        (
            "mode: explore",
            DeviceMessage::Mode(ModeReport::Explore { left: 99 })
        ),
        (
            "mode: stopped",
            DeviceMessage::Mode(ModeReport::Stopped(StopReason::LinkLost))
        ),
        ("counters", DeviceMessage::Counters(counters)),
        (
            "refusal: incompatible",
            refused(Refusal::Incompatible(dimensions()))
        ),
        ("refusal: no session", refused(Refusal::NoSession)),
        (
            "refusal: expired",
            refused(Refusal::Expired { age_ms: 1_200 })
        ),
        (
            "refusal: command",
            refused(Refusal::Command(CommandRefusal::InvalidMoveCount {
                max: 100
            }))
        ),
        (
            "refusal: parameter",
            refused(Refusal::Parameter(ParameterError::OutOfRange(spec)))
        ),
        (
            "refusal: transfer",
            refused(Refusal::Transfer(TransferError::OutOfBounds))
        ),
        (
            "chunk",
            DeviceMessage::Chunk {
                part: TransferPart::Memory,
                offset: 160,
                total: 4_000,
                bytes: Vec::from_slice(&[1, 2, 3]).unwrap(),
            }
        ),
        (
            "parameter",
            DeviceMessage::Parameter {
                parameter: Parameter::Speed,
                value: 508,
                spec
            }
        ),
        ("log", DeviceMessage::Log(LogEvent::LinkLost)),
        (
            "log: a transducer",
            DeviceMessage::Log(LogEvent::SensorDisabled {
                sensor: 3,
                fault: SensorFault::Dead,
            }),
        ),
        ("done", DeviceMessage::Done { seq: 6 }),
        ("busy", DeviceMessage::Busy { ms: 4_850 }),
        (
            "goal",
            DeviceMessage::Goal {
                name: Name::new("nest").unwrap(),
                goal: Goal::of([Component::at_most(Weight::from_bits(4_096)); 16]),
            }
        ),
        ("refusal: flash", refused(Refusal::Flash(FlashError::Empty))),
        ("refusal: no such goal", refused(Refusal::NoSuchGoal)),
        ("refusal: goal name", refused(Refusal::InvalidGoalName)),
    ]
}

/// Packs, unpacks and compares; returns the frame in hexadecimal.
fn there_and_back<M: Serialize + DeserializeOwned + PartialEq + Debug>(message: &M) -> String {
    let frame = Frame::pack(HEADER, message).unwrap();
    let bytes = frame.as_bytes();
    assert!(bytes.len() <= MAX_FRAME);
    let (&zero, rest) = bytes.split_last().unwrap();
    assert!(zero == 0 && !rest.contains(&0));
    let back: (Header, M) = unpack(rest).unwrap();
    assert_eq!((back.0, &back.1), (HEADER, message));
    let words = bytes.iter().map(|byte| format!("{byte:02x}"));
    words.collect::<std::vec::Vec<_>>().join(" ")
}

/// The examples of PROTOCOL.md are what the program sends, every message of both directions among
/// them.
#[test]
fn the_documented_examples_are_what_is_sent() {
    let to = to_device().into_iter();
    let to = to.map(|(name, message)| format!("to device, {name}\n{}\n", there_and_back(&message)));
    let from = from_device().into_iter().map(|(name, message)| {
        let report = Report {
            device_ms: 1_520,
            message,
        };
        format!("from device, {name}\n{}\n", there_and_back(&report))
    });
    let examples: String = to.chain(from).collect();
    document::check_block("hex", &examples);
}

/// PROTOCOL.md holds the grammar that both ends compare, and names version and checksum.
#[test]
fn the_documented_grammar_is_the_one_compared() {
    let text = include_str!("../../PROTOCOL.md");
    assert!(text.contains(include_str!("schema.txt")));
    assert!(
        text.contains(&format!("`{SCHEMA:#010x}`")),
        "{SCHEMA:#010x}"
    );
    assert!(text.contains(&format!("schema {SCHEMA} is {SCHEMA:#010x}")));
    assert!(text.contains(&format!("version is {PROTOCOL}")));
    assert_eq!(CRC.checksum(b"123456789"), 0xcbf4_3926);
}

/// Whole frames of the greatest numbers fit.
#[test]
fn the_longest_messages_fit_a_frame() {
    let far = Displacement {
        dx_mm: i16::MIN,
        dy_mm: i16::MIN,
    };
    let extremes = [Weight::MIN; 16];
    let plan = Plan {
        goal_neuron: u8::MAX,
        current_neuron: u8::MAX,
        subgoal_neuron: u8::MAX,
        wanted: extremes,
        action_neuron: u8::MAX,
        at_goal: true,
        recalled: true,
        action: far,
        why: Why::StraightAhead,
    };
    let decision = Decision {
        situation: extremes,
        plan: Some(plan),
        wanted: far,
        allowed: far,
        at_goal: true,
    };
    let report = |message| Report {
        device_ms: u32::MAX,
        message,
    };
    let heard = TimedEcho {
        sensor: 255,
        range_mm: Some(u16::MAX),
        age_ms: u16::MAX,
    };
    let component = Component {
        low: Weight::MIN,
        high: Weight::MIN,
        weight: 255,
    };
    let goal = Goal {
        frame: GoalFrame::Travel,
        progress_q16: u16::MAX,
        heading_hold_q16: u16::MAX,
        cap: Weight::MIN,
        tolerance: Weight::MIN,
        ..Goal::of([component; 16])
    };
    let piece = Vec::from_slice(&[255; message::MAX_CHUNK]).unwrap();
    there_and_back(&report(DeviceMessage::<16>::Decision(decision)));
    there_and_back(&report(DeviceMessage::<16>::Chunk {
        part: TransferPart::Memory,
        offset: u16::MAX,
        total: u16::MAX,
        bytes: piece.clone(),
    }));
    there_and_back(&HostMessage::<16>::Write {
        part: TransferPart::Memory,
        offset: u16::MAX,
        bytes: piece,
        last: true,
    });
    there_and_back(&HostMessage::<16>::Scan {
        at_ms: u32::MAX,
        echoes: core::iter::repeat_n(heard, message::MAX_ECHOES).collect(),
    });
    there_and_back(&HostMessage::<16>::Command {
        at_ms: u32::MAX,
        ttl_ms: u16::MAX,
        command: RobotCommand::Goal(GoalSpec::Components(goal)),
    });
    let name = Name::new("twelve-chars").unwrap();
    there_and_back(&report(DeviceMessage::<16>::Goal { name, goal }));
    let mut config = [0; crate::config::MAX_CONFIG];
    assert!(postcard::to_slice(&Config::recommended(), &mut config).is_ok());
}

#[test]
fn frames_that_are_too_long_or_empty_are_no_frames() {
    let mut receiver = Receiver::new();
    let mut feed = |bytes: &[u8]| -> std::vec::Vec<usize> {
        let mut ended = std::vec::Vec::new();
        for &byte in bytes {
            ended.extend(receiver.push(byte).map(<[u8]>::len));
        }
        ended
    };
    assert_eq!(feed(&[0, 0, 1, 2, 0, 0, 3, 0]), [2, 1]);
    assert_eq!(feed(&[&[1; 255][..], &[0]].concat()), [255]);
    assert_eq!(feed(&[&[1; 256][..], &[0, 5, 0]].concat()), [1]);
    assert_eq!(feed(&[&[1; 5_000][..], &[0, 5, 5, 0]].concat()), [2]);
    assert_eq!(receiver.oversized(), 2);
}

proptest! {
    #[test]
    fn any_bytes_are_a_frame_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let _ = unpack::<HostMessage<16>>(&bytes);
        let _ = unpack::<Report<16>>(&bytes);
    }

    /// Sound frames with any content, so that the decoder behind the CRC meets everything.
    #[test]
    fn any_content_is_a_message_or_an_error(content in prop::collection::vec(any::<u8>(), 0..=240)) {
        #[derive(Serialize)]
        struct Raw(#[serde(serialize_with = "raw")] std::vec::Vec<u8>);
        fn raw<S: serde::Serializer>(bytes: &[u8], out: S) -> Result<S::Ok, S::Error> {
            use serde::ser::SerializeTuple as _;
            let mut tuple = out.serialize_tuple(bytes.len())?;
            bytes.iter().try_for_each(|byte| tuple.serialize_element(byte))?;
            tuple.end()
        }
        let frame = Frame::pack(HEADER, &Raw(content)).unwrap();
        let (_, coded) = frame.as_bytes().split_last().unwrap();
        match unpack::<HostMessage<16>>(coded) {
            Ok((header, message)) => prop_assert!(header == HEADER && Frame::pack(header, &message).is_ok()),
            Err(error) => prop_assert_eq!(error, FrameError::Content { header: HEADER }),
        }
    }

    #[test]
    fn a_damaged_frame_is_never_a_message(which in 0_usize..28, bits in prop::collection::vec(0_usize..2_048, 1..9)) {
        let (_, message) = to_device().swap_remove(which);
        let frame = Frame::pack(HEADER, &message).unwrap();
        let (_, coded) = frame.as_bytes().split_last().unwrap();
        let mut damaged = coded.to_vec();
        for bit in bits {
            let bit = bit % (8 * damaged.len());
            damaged[bit / 8] ^= 1 << (bit % 8);
        }
        let read = unpack::<HostMessage<16>>(&damaged);
        prop_assert!(damaged == coded || read.is_err(), "{:?}", read);
    }
}

#[test]
fn what_does_not_fit_a_frame_is_not_sent() {
    // One byte more than a frame's body, less the header's three.
    let long = [255_u8; frame::MAX_BODY - 2];
    let words = (&long[..200], &long[200..]);
    assert_eq!(Frame::pack(HEADER, &words), Err(FrameError::TooLong));
}

#[test]
fn errors_of_frames_have_words() {
    let content = FrameError::Content { header: HEADER };
    let errors = [
        FrameError::Shape,
        FrameError::Crc,
        content,
        FrameError::TooLong,
    ];
    let words = errors.map(|error| format!("{error}"));
    assert_eq!(words[..3], ["no frame", "wrong CRC", "an unknown message"]);
    assert_eq!(words[3], "the message does not fit into a frame");
}

#[test]
fn a_receiver_takes_the_longest_frame_and_counts_longer_ones() {
    let mut receiver = Receiver::default();
    let mut length = |bytes: usize| {
        for _ in 0..bytes {
            assert_eq!(receiver.push(7), None);
        }
        receiver.push(0).map(<[u8]>::len)
    };
    assert_eq!(
        (length(0), length(1), length(255)),
        (None, Some(1), Some(255))
    );
    assert_eq!(
        (length(256), length(1_000), length(2)),
        (None, None, Some(2))
    );
    assert_eq!((receiver.oversized(), frame::MAX_BODY), (2, 250));
}

#[test]
fn errors_have_words_of_their_own() {
    let words = [
        FlashError::NoFlash,
        FlashError::Empty,
        FlashError::OtherVersion,
        FlashError::Failed,
    ];
    let words = words.map(|error| format!("{error}"));
    assert!(words[0].contains("nothing to save to") && words[1].contains("nothing was saved"));
    assert!(words[2].contains("another version") && words[3].contains("erased"));
}
