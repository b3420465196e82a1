//! The firmware in an emulated chip, and a peer that controls every byte to it.
//!
//! The image is the one a user builds for QEMU, in its own target folder. The emulator is a child
//! process that ends with its [`EmulatedChip`].

use amp::wire::frame::{self, Header};
use amp::wire::message::{
    Clock, Counters, DeviceHello, DeviceMessage, Dimensions, HostHello, HostMessage, Refusal,
    Report, RobotCommand,
};
use amp::wire::{Frame, PROTOCOL, Receiver, SCHEMA};
use remote::link::{Machine, Qemu, Tcp, Transport, build_image};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Timeout of all waits.
pub const TIMEOUT: Duration = Duration::from_secs(20);
/// Default session of a peer.
pub const SESSION: u16 = 7;

/// The image for QEMU, built once per test program.
///
/// # Panics
/// When it cannot be built.
#[must_use]
pub fn image() -> &'static Path {
    static IMAGE: OnceLock<PathBuf> = OnceLock::new();
    IMAGE.get_or_init(|| {
        build_image(&Machine::OLIMEX_H405).unwrap_or_else(|error| panic!("{error}"))
    })
}

/// The dimensions that both ends must agree on.
#[must_use]
pub const fn dimensions() -> Dimensions {
    Dimensions {
        protocol: PROTOCOL,
        schema: SCHEMA,
        sensors: 16,
        neurons: 16,
    }
}

/// An emulated chip with the firmware.
pub struct EmulatedChip {
    line: Box<dyn Transport>,
    receiver: Receiver,
    /// Received and not yet decoded.
    left: Vec<u8>,
    session: u16,
    seq: u16,
    began: Instant,
}

impl EmulatedChip {
    /// Switches it on and waits for its hello.
    ///
    /// # Panics
    /// When QEMU is missing or does not start.
    #[must_use]
    pub fn start() -> Self {
        Self::start_on(&Machine::OLIMEX_H405, image())
    }

    /// As [`start`](Self::start), on another machine and with its image.
    ///
    /// # Panics
    /// When QEMU is missing or does not start.
    #[must_use]
    pub fn start_on(machine: &Machine, image: &Path) -> Self {
        let qemu = Qemu::start(machine, image, false).unwrap_or_else(|error| panic!("{error}"));
        let mut chip = Self::at_the_end_of(Box::new(qemu));
        chip.wait(|_, report| matches!(report.message, DeviceMessage::Hello(_)).then_some(()));
        chip
    }

    /// Connects to a running chip at `HOST:PORT`.
    ///
    /// # Panics
    /// When the connection fails.
    #[must_use]
    pub fn at(host: &str) -> Self {
        let line = Tcp::open(host).unwrap_or_else(|error| panic!("{error}"));
        Self::at_the_end_of(Box::new(line))
    }

    fn at_the_end_of(line: Box<dyn Transport>) -> Self {
        Self {
            line,
            receiver: Receiver::new(),
            left: Vec::new(),
            session: SESSION,
            seq: 0,
            began: Instant::now(),
        }
    }

    /// Switches it on and opens a session.
    ///
    /// # Panics
    /// When the chip does not answer.
    #[must_use]
    pub fn linked(clock: Clock) -> Self {
        let mut chip = Self::start();
        chip.open(SESSION, clock);
        chip
    }

    /// Opens a session.
    ///
    /// # Panics
    /// When the chip does not answer or refuses.
    pub fn open(&mut self, session: u16, clock: Clock) -> DeviceHello {
        self.session = session;
        let hello = self.packed(&HostMessage::Hello(HostHello {
            dimensions: dimensions(),
            clock,
            open_space: false,
        }));
        let until = Instant::now() + TIMEOUT;
        while Instant::now() < until {
            // A chip that is still starting does not receive it.
            self.raw(&hello);
            while let Some((header, report)) = self.next(Duration::from_millis(500)) {
                match report.message {
                    DeviceMessage::Hello(hello) if header.session == session => return hello,
                    DeviceMessage::Refusal { reason, .. } if reason != Refusal::NoSession => {
                        panic!("{reason:?}")
                    }
                    _ => {}
                }
            }
        }
        panic!("no hello in {TIMEOUT:?}");
    }

    /// Milliseconds since the start of the chip, as the host's time.
    #[must_use]
    pub fn at_ms(&self) -> u32 {
        self.began.elapsed().as_millis() as u32
    }

    /// Sends raw bytes.
    ///
    /// # Panics
    /// When the line is closed.
    pub fn raw(&mut self, bytes: &[u8]) {
        self.line.send(bytes).expect("the line to the chip");
    }

    /// The next frame with this message, including its delimiter.
    ///
    /// # Panics
    /// When the message does not fit.
    pub fn packed(&mut self, message: &HostMessage<16>) -> Vec<u8> {
        self.seq = self.seq.wrapping_add(1);
        let header = Header {
            session: self.session,
            seq: self.seq,
        };
        packed(header, message)
    }

    /// Sends a message without waiting; returns its sequence number.
    pub fn send(&mut self, message: &HostMessage<16>) -> u16 {
        let bytes = self.packed(message);
        self.raw(&bytes);
        self.seq
    }

    /// Sends a message and returns all reports up to its completion.
    pub fn ask(&mut self, message: &HostMessage<16>) -> Vec<Report<16>> {
        let number = self.send(message);
        let mut said = Vec::new();
        self.wait(|_, report| {
            let done = report.message == DeviceMessage::Done { seq: number };
            said.push(report);
            done.then_some(())
        });
        said
    }

    /// Sends a command with a time to live of one second.
    pub fn command(&mut self, command: RobotCommand<16>) -> Vec<Report<16>> {
        let at_ms = self.at_ms();
        self.ask(&HostMessage::Command {
            at_ms,
            ttl_ms: 1_000,
            command,
        })
    }

    /// Received bytes; empty after `patience`.
    ///
    /// # Panics
    /// When the line is closed.
    pub fn bytes(&mut self, patience: Duration) -> Vec<u8> {
        if self.left.is_empty() {
            self.read(patience);
        }
        std::mem::take(&mut self.left)
    }

    /// The counters, requested with frame `seq` of the session.
    pub fn counters_as(&mut self, seq: u16) -> Counters {
        self.seq = seq.wrapping_sub(1);
        self.counters()
    }

    /// The counters.
    ///
    /// # Panics
    /// When they do not arrive.
    pub fn counters(&mut self) -> Counters {
        let said = self.ask(&HostMessage::Counters);
        let counters = said.iter().rev().find_map(|report| match report.message {
            DeviceMessage::Counters(counters) => Some(counters),
            _ => None,
        });
        counters.expect("counters")
    }

    /// Waits until `what` returns a value for a report.
    ///
    /// # Panics
    /// After [`TIMEOUT`].
    pub fn wait<T>(&mut self, mut what: impl FnMut(Header, Report<16>) -> Option<T>) -> T {
        let began = Instant::now();
        while let Some(left) = TIMEOUT.checked_sub(began.elapsed()) {
            if let Some((header, report)) = self.next(left)
                && let Some(found) = what(header, report)
            {
                return found;
            }
        }
        panic!("the chip has sent no such report in {TIMEOUT:?}");
    }

    /// The next report within `patience`.
    pub fn next(&mut self, patience: Duration) -> Option<(Header, Report<16>)> {
        let began = Instant::now();
        loop {
            if let Some(found) = self.parse() {
                return Some(found);
            }
            self.read(patience.checked_sub(began.elapsed())?);
        }
    }

    fn read(&mut self, patience: Duration) {
        let mut buffer = [0; 4_096];
        let count = self.line.receive(&mut buffer, patience);
        let count = count.unwrap_or_else(|error| {
            let words = self.line.exit_message().unwrap_or_default();
            panic!("the line from the chip: {error}; {words}")
        });
        self.left.extend_from_slice(&buffer[..count]);
    }

    fn parse(&mut self) -> Option<(Header, Report<16>)> {
        let mut taken = 0;
        let mut found = None;
        for &byte in &self.left {
            taken += 1;
            if let Some(coded) = self.receiver.push(byte) {
                found = Some(frame::unpack(coded).expect("a valid frame from the chip"));
                break;
            }
        }
        self.left.drain(..taken);
        found
    }
}

/// A frame with this message, including its delimiter.
///
/// # Panics
/// When the message does not fit.
#[must_use]
pub fn packed(header: Header, message: &HostMessage<16>) -> Vec<u8> {
    let frame = Frame::pack(header, message).expect("a message that fits");
    frame.as_bytes().to_vec()
}

/// A sink that records everything a node on the host sends.
#[derive(Debug, Default)]
pub struct RecordedBytes(pub Vec<u8>);

impl amp::node::FrameSink for RecordedBytes {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.0.extend_from_slice(frame);
        true
    }
}
