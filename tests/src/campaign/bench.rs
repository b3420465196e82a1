//! Shared by the campaigns of the link: a controller that can seek, and frames for it.

use crate::chip::{RecordedBytes, dimensions, packed};
use amp::config::Config;
use amp::node::{Identity, NomadNode};
use amp::som::Grid;
use amp::units::Millis;
use amp::wire::frame::{Header, unpack};
use amp::wire::message::{
    Clock, DeviceMessage, GoalSpec, HostHello, HostMessage, MotionCommand, Report, RobotCommand,
    TimedEcho,
};

/// The session of a bench.
pub(super) const SESSION: u16 = 7;

/// Sequence number before the first frame: the 16 bits overflow soon.
const FIRST: u16 = 65_000;

/// Random moves before the maps are learned.
const MOVES: u16 = 20;

/// The two clocks: milliseconds since some moment, modulo 2³².
#[derive(Debug, Clone, Copy)]
pub(super) struct Clocks {
    /// The device's time at time 0.
    pub(super) device: u32,
    /// The host's time at time 0.
    pub(super) host: u32,
}

impl Clocks {
    pub(super) const fn device(self, now_ms: u64) -> Millis {
        Millis::from_ms(self.device.wrapping_add(now_ms as u32))
    }

    pub(super) const fn host(self, now_ms: u64) -> u32 {
        self.host.wrapping_add(now_ms as u32)
    }
}

/// A controller that has learned and seeks free space, in session [`SESSION`] by its own clock.
#[derive(Debug, Clone)]
pub(super) struct Ready {
    pub(super) node: Box<NomadNode>,
    /// Sequence number of the latest frame to it.
    pub(super) seq: u16,
    pub(super) clocks: Clocks,
    /// Time since the start.
    pub(super) now_ms: u64,
}

impl Ready {
    /// Explores with this seed and learns, over a good line.
    ///
    /// # Panics
    /// When the controller refuses a command.
    pub(super) fn new(seed: u64, clocks: Clocks) -> Self {
        let mut ready = Self {
            node: Box::new(NomadNode::new()),
            seq: FIRST,
            clocks,
            now_ms: 0,
        };
        let now = clocks.device(0);
        let config = Config::recommended();
        let identity = Identity::default();
        let mut said = RecordedBytes::default();
        let grid = Grid::rectangle(4, 4);
        ready.node.start(&config, grid, identity, now, &mut said);
        ready.tell(&hello());
        ready.send_command(RobotCommand::Explore { moves: MOVES, seed });
        for round in 0..MOVES {
            ready.now_ms += 100;
            let scan = scan(ready.host_ms(), 700 + 50 * (round % 9));
            let command = motion(&ready.tell(&scan)).expect("a random move");
            ready.now_ms += 100;
            ready.tell(&carried_out(ready.host_ms(), command));
        }
        ready.now_ms += 100;
        ready.tell(&scan(ready.host_ms(), 900));
        ready.send_command(RobotCommand::Learn);
        let now = clocks.device(ready.now_ms);
        while ready.node.tick(now, &mut said) {}
        ready.send_command(RobotCommand::Goal(GoalSpec::Avoid));
        ready.send_command(RobotCommand::Seek);
        ready
    }

    pub(super) const fn host_ms(&self) -> u32 {
        self.clocks.host(self.now_ms)
    }

    fn send_command(&mut self, command: RobotCommand<16>) {
        let at_ms = self.host_ms();
        self.tell(&command_message(at_ms, 1_000, command));
    }

    fn tell(&mut self, message: &HostMessage<16>) -> Vec<Report<16>> {
        self.seq = self.seq.wrapping_add(1);
        let frame = numbered(self.seq, message);
        let mut said = RecordedBytes::default();
        let now = self.clocks.device(self.now_ms);
        self.node.frame(now, coded(&frame), &mut said);
        let reports = reports(&said.0);
        let refused = |report: &Report<16>| matches!(report.message, DeviceMessage::Refusal { .. });
        assert!(!reports.iter().any(refused), "{message:?}: {reports:?}");
        reports
    }
}

/// A frame of the session with its delimiter.
pub(super) fn numbered(seq: u16, message: &HostMessage<16>) -> Vec<u8> {
    let session = SESSION;
    packed(Header { session, seq }, message)
}

/// A frame without its delimiter.
pub(super) fn coded(frame: &[u8]) -> &[u8] {
    frame.split_last().map_or(frame, |(_, coded)| coded)
}

pub(super) fn reports(bytes: &[u8]) -> Vec<Report<16>> {
    let frames = bytes.split(|byte| *byte == 0);
    frames
        .filter_map(|frame| Some(unpack(frame).ok()?.1))
        .collect()
}

pub(super) fn motion(said: &[Report<16>]) -> Option<MotionCommand> {
    said.iter().find_map(|report| match report.message {
        DeviceMessage::Motion(command) => Some(command),
        _ => None,
    })
}

pub(super) fn hello() -> HostMessage<16> {
    HostMessage::Hello(HostHello {
        dimensions: dimensions(),
        clock: Clock::Device,
        open_space: false,
    })
}

pub(super) const fn command_message(
    at_ms: u32,
    ttl_ms: u16,
    command: RobotCommand<16>,
) -> HostMessage<16> {
    HostMessage::Command {
        at_ms,
        ttl_ms,
        command,
    }
}

/// A whole ring with `range_mm` ahead, and 20 mm more for each further sensor.
pub(super) fn scan(at_ms: u32, range_mm: u16) -> HostMessage<16> {
    let echoes = (0..16).map(|sensor| TimedEcho {
        sensor,
        range_mm: Some(range_mm + 20 * u16::from(sensor)),
        age_ms: 0,
    });
    HostMessage::Scan {
        at_ms,
        echoes: echoes.collect(),
    }
}

/// The report of a motion that was executed completely.
pub(super) const fn carried_out(at_ms: u32, command: MotionCommand) -> HostMessage<16> {
    HostMessage::Odometry {
        at_ms,
        motion: command.id,
        dx_mm: command.dx_mm,
        dy_mm: command.dy_mm,
        turned: 0,
        progress: amp::controller::Progress::Ended,
    }
}
