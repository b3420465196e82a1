//! Counts the link: packing and unpacking of frames, and decisions of a node by frames.

use crate::episode::CountedEpisode;
use crate::room::SquareRoom;
use crate::stopwatch::{InstructionStats, Stopwatch};
use amp::controller::{self, Progress};
use amp::node::{FrameSink, Identity, NomadNode};
use amp::som::Grid;
use amp::units::Millis;
use amp::wire::message::{
    Clock, DeviceMessage, Dimensions, GoalSpec, HostHello, HostMessage, MAX_CHUNK, MotionCommand,
    RobotCommand, TimedEcho, TransferPart,
};
use amp::wire::{Frame, Header, PROTOCOL, Report, SCHEMA, frame};
use core::hint::black_box;
use cortex_m4::KERNELS;
use heapless::Vec;

/// Decisions by frames.
const DECISIONS: u32 = 32;

/// Counts packing the decisions of an episode.
pub fn packing(watch: &Stopwatch, episode: &CountedEpisode<'_>) -> InstructionStats {
    let mut stats = InstructionStats::default();
    for decision in &episode.decisions {
        let report = Report {
            device_ms: 123_456,
            message: DeviceMessage::Decision(*decision),
        };
        let header = Header {
            session: 7,
            seq: 4_711,
        };
        let mut frame = Frame::EMPTY;
        let (instructions, _) = watch.count(|| frame.fill(header, black_box(&report)));
        stats.add(instructions);
    }
    stats
}

/// Instructions by kind of call.
#[derive(Default)]
pub struct LinkCounts {
    /// Unpacking a scan of 16 echoes.
    pub unpack: InstructionStats,
    /// Processing a scan that completes a ring; the answer is decision, motion and Done.
    pub decision: InstructionStats,
}

/// A node with the maps of an episode, and the base that it controls.
struct LinkedBase {
    node: NomadNode,
    sent: SentFrames,
    room: SquareRoom,
    seq: u16,
    time: u32,
}

/// Counts decisions by frames, in the same room.
pub fn decisions(watch: &Stopwatch, episode: &CountedEpisode<'_>) -> LinkCounts {
    let mut counts = LinkCounts::default();
    let mut base = LinkedBase::new(episode);
    for _ in 0..DECISIONS {
        let scan = base.pack(&base.scan());
        let scan = &scan.as_bytes()[..scan.as_bytes().len() - 1];
        let (unpack, _) = watch.count(|| frame::unpack::<HostMessage<16>>(black_box(scan)));
        counts.unpack.add(unpack);
        base.sent.0.clear();
        let (decision, ()) = watch.count(|| {
            let (base, scan) = black_box((&mut base, scan));
            base.node.frame(Millis::from_ms(0), scan, &mut base.sent);
        });
        counts.decision.add(decision);
        let motion = base.sent.motion().expect("a scan brings a motion");
        base.carry_out(motion);
    }
    counts
}

impl LinkedBase {
    fn new(episode: &CountedEpisode<'_>) -> Self {
        let mut base = Self {
            node: NomadNode::new(),
            sent: SentFrames(Vec::new()),
            room: SquareRoom::new(),
            seq: 0,
            time: 0,
        };
        base.node.use_kernels(&KERNELS);
        base.node.start(
            &episode.robot.config,
            Grid::rectangle(4, 4),
            Identity::default(),
            Millis::from_ms(0),
            &mut base.sent,
        );
        base.send(&HostMessage::Hello(HostHello {
            dimensions: Dimensions {
                protocol: PROTOCOL,
                schema: SCHEMA,
                sensors: 16,
                neurons: 16,
            },
            clock: Clock::Host,
            open_space: false,
        }));
        base.upload(
            episode,
            TransferPart::Situations,
            controller::StatePart::Situations,
        );
        base.upload(
            episode,
            TransferPart::Changes,
            controller::StatePart::Changes,
        );
        base.upload(
            episode,
            TransferPart::Actions,
            controller::StatePart::Actions,
        );
        for command in [RobotCommand::Goal(GoalSpec::Avoid), RobotCommand::Seek] {
            let (at_ms, ttl_ms) = (base.time, 500);
            base.send(&HostMessage::Command {
                at_ms,
                ttl_ms,
                command,
            });
        }
        // Otherwise the echoes of the first ring would be older than the session.
        base.pass();
        base
    }

    /// Uploads a part of the episode's state to the node.
    fn upload(
        &mut self,
        episode: &CountedEpisode<'_>,
        part: TransferPart,
        of: controller::StatePart,
    ) {
        let mut offset = 0;
        loop {
            let mut piece = [0; MAX_CHUNK];
            let count = episode.robot.state.read_part(of, offset, &mut piece);
            if count == 0 {
                return;
            }
            self.send(&HostMessage::Write {
                part,
                offset: offset as u16,
                bytes: Vec::from_slice(&piece[..count]).expect("a piece fits"),
                last: false,
            });
            offset += count;
        }
    }

    fn scan(&self) -> HostMessage<16> {
        let echoes = (0..16_u8).map(|sensor| TimedEcho {
            sensor,
            range_mm: Some(self.room.range_mm(usize::from(sensor))),
            age_ms: 40 * (15 - u16::from(sensor)),
        });
        HostMessage::Scan {
            at_ms: self.time,
            echoes: echoes.collect(),
        }
    }

    fn carry_out(&mut self, motion: MotionCommand) {
        let moved = self.room.drive(motion.motion().displacement);
        self.pass();
        self.send(&HostMessage::Odometry {
            at_ms: self.time,
            motion: motion.id,
            dx_mm: moved.dx_mm,
            dy_mm: moved.dy_mm,
            turned: 0,
            progress: Progress::Ended,
        });
        self.pass();
    }

    /// Advances the time of a ring, with Alive messages.
    fn pass(&mut self) {
        for _ in 0..4 {
            self.time += 160;
            self.send(&HostMessage::Alive { at_ms: self.time });
        }
    }

    /// Packs the next frame.
    fn pack(&mut self, message: &HostMessage<16>) -> Frame {
        self.seq += 1;
        let header = Header {
            session: 7,
            seq: self.seq,
        };
        Frame::pack(header, message).expect("it fits a frame")
    }

    fn send(&mut self, message: &HostMessage<16>) {
        let frame = self.pack(message);
        let bytes = frame.as_bytes();
        self.node.frame(
            Millis::from_ms(0),
            &bytes[..bytes.len() - 1],
            &mut self.sent,
        );
        self.sent.0.clear();
    }
}

/// Frames that the node sent, copied as by a queue.
struct SentFrames(Vec<u8, 1_024>);

impl SentFrames {
    /// The motion among the frames.
    fn motion(&self) -> Option<MotionCommand> {
        let frames = self.0.split(|byte| *byte == 0);
        let mut reports = frames.filter_map(|bytes| frame::unpack::<Report<16>>(bytes).ok());
        reports.find_map(|(_, report)| match report.message {
            DeviceMessage::Motion(motion) => Some(motion),
            _ => None,
        })
    }
}

impl FrameSink for SentFrames {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.0.extend_from_slice(frame).is_ok()
    }
}
