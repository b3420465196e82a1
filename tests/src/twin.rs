//! The node on the host and the firmware in the emulated chip get the same frames and must send the
//! same bytes.

use crate::chip::{EmulatedChip, RecordedBytes, SESSION, TIMEOUT, dimensions, packed};
use amp::body::{Body, HeldRing, MountedSensors};
use amp::config::{Config, MAX_CONFIG};
use amp::controller::{Event, Outputs};
use amp::goal::Name;
use amp::units::Millis;
use amp::wire::frame::{self, Header};
use amp::wire::message::{
    Clock, DeviceMessage, GoalSpec, HostHello, HostMessage, MAX_CHUNK, ModeReport, Report,
    RobotCommand, TimedEcho, TransferPart,
};
use firmware::control::RobotNode;
use sim::episode::Body as SimulatedBody;
use sim::pilot::Pilot;
use sim::robot::AnyRobot;
use std::time::Instant;

/// Simulated time between two heartbeats.
const HEARTBEAT_MS: u32 = 250;
/// Bytes that the F405 may lag behind: its receive queue holds twice as many.
const BEHIND: usize = 256;

/// The node of a robot with this body, and the chip.
pub struct NodeTwin<B = HeldRing> {
    chip: EmulatedChip,
    local: Box<RobotNode<B>>,
    seq: u16,
    at_ms: u32,
    /// Sent by the node and not yet by the chip.
    awaited: Vec<u8>,
    compared: usize,
    /// Bytes that the chip may lag behind.
    behind: usize,
    /// Echoes are sent as whole rings, as from sonars that measure at once.
    rings: bool,
    echoes: heapless::Vec<TimedEcho, 16>,
    /// The most slices of thinking before a decision.
    longest_thought: usize,
    led_decisions: usize,
}

impl NodeTwin {
    /// A new chip and a new node.
    #[must_use]
    pub fn new(rings: bool) -> Self {
        Self::with(EmulatedChip::start(), BEHIND, rings)
    }
}

impl<const RECORDS: usize> NodeTwin<MountedSensors<16, 16, 256, RECORDS>> {
    /// A chip and a node that are told of a robot and its body.
    #[must_use]
    pub fn of_robot(chip: EmulatedChip, robot: &AnyRobot, rings: bool) -> Self {
        // A frame that arrives while the chip thinks is answered before the decision.
        let behind = if RECORDS == 0 { BEHIND } else { 0 };
        let mut twin = Self::with(chip, behind, rings);
        let config = robot.config(Config::recommended());
        twin.write(TransferPart::Config, config.to_bytes(&mut [0; MAX_CONFIG]));
        let body = robot.body();
        twin.write(TransferPart::Body, body.to_bytes(&mut [0; MAX_CONFIG]));
        twin
    }
}

impl<B: Body<16>> NodeTwin<B> {
    /// A chip that has just been started, and a new node. The chip may lag `behind` bytes behind.
    ///
    /// # Panics
    /// When the chip does not answer.
    #[must_use]
    pub fn with(chip: EmulatedChip, behind: usize, rings: bool) -> Self {
        let mut twin = Self {
            chip,
            behind,
            local: Box::new(RobotNode::new()),
            seq: 0,
            at_ms: 0,
            awaited: Vec::new(),
            compared: 0,
            rings,
            echoes: heapless::Vec::new(),
            longest_thought: 0,
            led_decisions: 0,
        };
        let hello = twin.chip.open(SESSION, Clock::Host);
        let identity = amp::node::Identity {
            build: hello.build,
            reset: hello.reset,
            oscillator: hello.oscillator,
            ring: false,
        };
        let mut said = RecordedBytes::default();
        firmware::control::start(&mut twin.local, identity, Millis::from_ms(0), &mut said);
        // The chip has answered this hello; a second one makes both number as many frames.
        let message = HostMessage::Hello(HostHello {
            dimensions: dimensions(),
            clock: Clock::Host,
            open_space: false,
        });
        let said = twin.tell_local(&message, 1);
        assert!(matches!(
            said[..],
            [Report {
                message: DeviceMessage::Hello(_),
                ..
            }]
        ));
        twin.awaited.clear();
        twin.seq = 1;
        twin
    }

    /// Bytes compared so far.
    #[must_use]
    pub const fn compared(&self) -> usize {
        self.compared
    }

    /// The most slices of thinking before a decision.
    #[must_use]
    pub const fn longest_thought(&self) -> usize {
        self.longest_thought
    }

    /// Decisions for which its places led it.
    #[must_use]
    pub const fn led_decisions(&self) -> usize {
        self.led_decisions
    }

    /// The node on the host.
    #[must_use]
    pub fn local(&self) -> &RobotNode<B> {
        &self.local
    }

    /// Sends a command to both.
    pub fn command(&mut self, command: RobotCommand<16>) {
        let at_ms = self.at_ms;
        self.send(&HostMessage::Command {
            at_ms,
            ttl_ms: 1_000,
            command,
        });
        self.settle(0);
    }

    /// Drives both until they change their mode.
    ///
    /// # Panics
    /// When they differ.
    pub fn finish(&mut self, body: &mut SimulatedBody<'_>) {
        while !body.advance(self).mode_changed {}
    }

    /// Drives both for so many decisions.
    ///
    /// # Panics
    /// When they differ or stop.
    pub fn decide(&mut self, body: &mut SimulatedBody<'_>, count: usize) {
        let mut decisions = 0;
        while decisions < count {
            let result = body.advance(self);
            decisions += usize::from(result.decision.is_some());
            assert!(!result.mode_changed, "it stopped");
        }
    }

    /// Lets both learn.
    ///
    /// # Panics
    /// When they differ.
    pub fn learn(&mut self) {
        self.command(RobotCommand::Learn);
        self.think();
    }

    /// Lets both work out what they have begun to.
    ///
    /// # Panics
    /// When they differ.
    pub fn think(&mut self) {
        let mut said = RecordedBytes::default();
        while self.local.tick(Millis::from_ms(0), &mut said) {}
        assert_eq!(
            reports(&said.0).last().map(|report| report.message.clone()),
            Some(DeviceMessage::Mode(ModeReport::Idle))
        );
        self.awaited.extend(said.0);
        self.settle(0);
    }

    /// Writes a part to both.
    pub fn write(&mut self, part: TransferPart, bytes: &[u8]) {
        let mut offset = 0;
        let pieces = bytes.chunks(MAX_CHUNK).peekable();
        let count = pieces.len();
        for (number, piece) in pieces.enumerate() {
            let bytes = piece.iter().copied().collect();
            self.send(&HostMessage::Write {
                part,
                offset,
                bytes,
                last: number + 1 == count,
            });
            self.settle(0);
            offset += piece.len() as u16;
        }
    }

    /// Saves the goal of both under a name.
    pub fn save_goal(&mut self, name: Name) {
        self.send(&HostMessage::SaveGoal { name });
        self.settle(0);
    }

    /// Lets both seek a goal.
    pub fn seek(&mut self, goal: GoalSpec<16>) {
        self.command(RobotCommand::Goal(goal));
        self.command(RobotCommand::Seek);
    }

    /// Compares the state of both; returns the bytes.
    pub fn compare_knowledge(&mut self) -> usize {
        let before = self.compared;
        for part in [
            TransferPart::Config,
            TransferPart::Situations,
            TransferPart::Changes,
            TransferPart::Actions,
            TransferPart::Memory,
            TransferPart::Body,
            TransferPart::Places,
        ] {
            let mut offset = 0;
            loop {
                let said = self.send(&HostMessage::Read { part, offset });
                let Some(DeviceMessage::Chunk { total, bytes, .. }) =
                    said.first().map(|report| &report.message)
                else {
                    panic!("{said:?}");
                };
                offset += bytes.len() as u16;
                self.settle(self.behind);
                if offset >= *total {
                    break;
                }
            }
        }
        self.settle(0);
        self.compared - before
    }

    /// The checksums of maps and memory in the hello of both. Opens a new session.
    ///
    /// # Panics
    /// When they differ.
    pub fn checksums(&mut self) -> [u32; 2] {
        let said = self.send(&HostMessage::Hello(HostHello {
            dimensions: dimensions(),
            clock: Clock::Host,
            open_space: false,
        }));
        self.settle(0);
        let hello = said.iter().find_map(|report| match report.message {
            DeviceMessage::Hello(hello) => Some([hello.maps_crc, hello.memory_crc]),
            _ => None,
        });
        hello.expect("a hello")
    }

    /// Peak of the chip's stack, bytes.
    pub fn stack_peak_bytes(&mut self) -> u32 {
        self.chip.counters_as(self.seq + 1).device.stack_peak_bytes
    }

    fn tell_local(&mut self, message: &HostMessage<16>, seq: u16) -> Vec<Report<16>> {
        let bytes = packed(
            Header {
                session: SESSION,
                seq,
            },
            message,
        );
        let mut said = RecordedBytes::default();
        let (_, coded) = bytes.split_last().expect("a frame");
        self.local.frame(Millis::from_ms(0), coded, &mut said);
        let mut slices = 0;
        while self.local.body().is_thinking() {
            let _ = self.local.tick(Millis::from_ms(0), &mut said);
            slices += 1;
        }
        self.longest_thought = self.longest_thought.max(slices);
        self.led_decisions += usize::from(slices > 0 && self.local.state().is_led());
        let reports = reports(&said.0);
        self.awaited.extend(said.0);
        reports
    }

    /// Sends to both; returns the reports of the node.
    fn send(&mut self, message: &HostMessage<16>) -> Vec<Report<16>> {
        self.seq = self.seq.wrapping_add(1);
        self.chip.raw(&packed(
            Header {
                session: SESSION,
                seq: self.seq,
            },
            message,
        ));
        self.tell_local(message, self.seq)
    }

    /// Compares the chip's bytes until at most `behind` are missing.
    fn settle(&mut self, behind: usize) {
        let began = Instant::now();
        while self.awaited.len() > behind {
            let heard = self.chip.bytes(TIMEOUT.saturating_sub(began.elapsed()));
            assert!(
                !heard.is_empty(),
                "the chip is silent; awaited: {:?}",
                reports(&self.awaited)
            );
            assert!(
                heard.len() <= self.awaited.len(),
                "the chip sends more: {:?}",
                reports(&heard)
            );
            let expected: Vec<_> = self.awaited.drain(..heard.len()).collect();
            assert!(
                heard == expected,
                "chip: {heard:02x?}\nhere: {expected:02x?}"
            );
            self.compared += heard.len();
        }
    }

    /// Sends heartbeats up to `at_ms`: simulated time may jump.
    fn heartbeats_until(&mut self, at_ms: u32) -> Vec<Report<16>> {
        let mut said = Vec::new();
        while at_ms.saturating_sub(self.at_ms) > HEARTBEAT_MS {
            self.at_ms += HEARTBEAT_MS;
            said.extend(self.send(&HostMessage::Alive { at_ms: self.at_ms }));
        }
        self.at_ms = at_ms;
        said
    }
}

impl<B: Body<16>> Pilot for NodeTwin<B> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        let at_ms = at.as_ms();
        let _ = self.heartbeats_until(at_ms);
        let message = match event {
            Event::Echo { sensor, range } => {
                let heard = TimedEcho {
                    sensor,
                    range_mm: range.map(amp::units::Range::as_mm),
                    age_ms: 0,
                };
                let _ = self.echoes.push(heard);
                if self.rings && !self.echoes.is_full() {
                    return Outputs::NONE;
                }
                let echoes = std::mem::take(&mut self.echoes);
                HostMessage::Scan { at_ms, echoes }
            }
            Event::Odometry {
                motion,
                moved,
                turned,
                progress,
            } => HostMessage::Odometry {
                at_ms,
                motion,
                dx_mm: moved.dx_mm,
                dy_mm: moved.dy_mm,
                turned: turned.as_turns(),
                progress,
            },
            Event::Command(_) | Event::Tick | Event::Alarm(_) | Event::Touched => {
                return Outputs::NONE;
            }
        };
        let said = self.send(&message);
        self.settle(self.behind);
        outputs(&said)
    }
}

fn outputs(said: &[Report<16>]) -> Outputs<16> {
    let mut outputs = Outputs::NONE;
    for report in said {
        match &report.message {
            DeviceMessage::Motion(command) => outputs.motion = Some(command.motion()),
            DeviceMessage::Decision(decision) => outputs.decision = Some(*decision),
            DeviceMessage::Mode(_) => outputs.mode_changed = true,
            _ => {}
        }
    }
    outputs
}

fn reports(bytes: &[u8]) -> Vec<Report<16>> {
    let frames = bytes
        .split(|byte| *byte == 0)
        .filter(|frame| !frame.is_empty());
    frames
        .filter_map(|frame| Some(frame::unpack(frame).ok()?.1))
        .collect()
}
