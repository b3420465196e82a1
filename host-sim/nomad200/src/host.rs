//! The host's end of the robot's line: sends commands and waits for answers.

use super::{
    CommandError, Decoder, Greeting, Kind, LengthError, MAX_FROM_ROBOT, NomadCommand,
    NomadReadings, Packet, StateMask,
};
use remote::link::{Deadline, Transport};
use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::time::{Duration, Instant};

/// The client library's timeout for an answer.
pub const ANSWER_TIMEOUT: Duration = Duration::from_secs(1);

/// Why a request failed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RobotError {
    /// The transport failed.
    Broken {
        /// How.
        why: String,
    },
    /// No answer.
    Silent {
        /// How long it waited.
        waited: Duration,
    },
    /// The robot does not know the command.
    Refused(Kind),
    /// An answer of the wrong length.
    Answer(Kind, LengthError),
}

impl fmt::Display for RobotError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Broken { why } => write!(f, "the line to the robot broke: {why}"),
            Self::Silent { waited } => write!(
                f,
                "the robot has not answered within {} s: is it switched on, and this its line and speed?",
                waited.as_secs_f32()
            ),
            Self::Refused(kind) => write!(f, "the robot does not know the command {kind:?}"),
            Self::Answer(kind, wrong) => CommandError::Length(*kind, *wrong).fmt(f),
        }
    }
}

impl std::error::Error for RobotError {}

impl From<io::Error> for RobotError {
    fn from(error: io::Error) -> Self {
        Self::Broken {
            why: error.to_string(),
        }
    }
}

/// A robot at the other end of a transport.
pub struct Host {
    line: Box<dyn Transport>,
    decoder: Decoder,
    deadline: Deadline,
    packets: VecDeque<Packet>,
    mask: StateMask,
    state: NomadReadings,
}

impl Host {
    /// A robot on a serial line. Its mask is known after the first `ct`.
    #[must_use]
    pub fn new(line: impl Transport + 'static) -> Self {
        Self {
            line: Box::new(line),
            decoder: Decoder::new(MAX_FROM_ROBOT),
            deadline: Deadline::default(),
            packets: VecDeque::new(),
            mask: StateMask::ALL,
            state: NomadReadings::default(),
        }
    }

    /// A robot on a TCP connection, which sends its mask first.
    ///
    /// # Errors
    /// When the greeting does not come.
    pub fn with_greeting(line: impl Transport + 'static) -> Result<Self, RobotError> {
        let mut host = Self::new(line);
        let mut greeting = Vec::new();
        let until = Instant::now() + ANSWER_TIMEOUT;
        while greeting.len() < Greeting::BYTES {
            let mut buffer = [0; Greeting::BYTES];
            let room = buffer.get_mut(greeting.len()..).unwrap_or_default();
            let count = receive(&mut *host.line, room, until)?;
            greeting.extend(room.iter().take(count));
        }
        let read = Greeting::from_bytes(&greeting);
        host.mask = read
            .map_err(|wrong| RobotError::Answer(Kind::Ct, wrong))?
            .mask;
        Ok(host)
    }

    /// Content of state packets.
    #[must_use]
    pub fn mask(&self) -> &StateMask {
        &self.mask
    }

    /// The latest readings.
    #[must_use]
    pub fn state(&self) -> &NomadReadings {
        &self.state
    }

    /// The transport, for raw bytes.
    pub fn line(&mut self) -> &mut dyn Transport {
        &mut *self.line
    }

    /// Sends a command and waits for the answer, with the library's timeout. Returns the readings.
    ///
    /// # Errors
    /// [`RobotError`].
    pub fn request(&mut self, command: &NomadCommand) -> Result<&NomadReadings, RobotError> {
        self.request_within(command, ANSWER_TIMEOUT)
    }

    /// As [`request`](Self::request), with another timeout.
    ///
    /// # Errors
    /// [`RobotError`].
    pub fn request_within(
        &mut self,
        command: &NomadCommand,
        timeout: Duration,
    ) -> Result<&NomadReadings, RobotError> {
        if let NomadCommand::Communicate(mask) = command {
            self.mask = *mask;
        }
        self.line.send(&command.to_packet().to_bytes())?;
        let until = Instant::now() + timeout;
        loop {
            let Some(packet) = self.next(until)? else {
                return Err(RobotError::Silent { waited: timeout });
            };
            let kind = command.kind();
            if packet.kind == Kind::Nak as u8 {
                return Err(RobotError::Refused(kind));
            }
            // A late answer to an earlier command is skipped.
            if packet.kind == kind as u8 {
                self.read_answer(command, &packet)
                    .map_err(|wrong| RobotError::Answer(kind, wrong))?;
                return Ok(&self.state);
            }
        }
    }

    fn read_answer(&mut self, command: &NomadCommand, packet: &Packet) -> Result<(), LengthError> {
        match command {
            NomadCommand::Get(group) => self.state.take_group(*group, &self.mask, &packet.payload),
            // Three values of a calibration.
            NomadCommand::ConfigureCompass(_) => Ok(()),
            _ => self.state.take_payload(&self.mask, &packet.payload),
        }
    }

    /// The next packet, or `None` at the time `until`.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn next(&mut self, until: Instant) -> Result<Option<Packet>, RobotError> {
        let mut buffer = [0; 1_024];
        loop {
            if let Some(packet) = self.packets.pop_front() {
                return Ok(Some(packet));
            }
            if !self.deadline.allows_read(until) {
                return Ok(None);
            }
            let count = match receive(&mut *self.line, &mut buffer, until) {
                Ok(count) => count,
                Err(RobotError::Silent { .. }) => return Ok(None),
                Err(error) => return Err(error),
            };
            let mut found = Vec::new();
            self.decoder
                .push(buffer.get(..count).unwrap_or(&[]), &mut found);
            self.packets.extend(found);
        }
    }
}

/// Reads at least one byte, or times out.
fn receive(
    line: &mut dyn Transport,
    buffer: &mut [u8],
    until: Instant,
) -> Result<usize, RobotError> {
    let timeout = until.saturating_duration_since(Instant::now());
    match line.receive(buffer, timeout)? {
        0 => Err(RobotError::Silent {
            waited: ANSWER_TIMEOUT,
        }),
        count => Ok(count),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use remote::link::Flood;

    #[test]
    fn a_robot_that_sends_only_other_answers_times_out() {
        let report = Packet::new(Kind::Ct, vec![0; 80]).to_bytes();
        let mut host = Host::new(Flood::of(move || report.clone()));
        for timeout in [Duration::from_millis(100), ANSWER_TIMEOUT] {
            let began = Instant::now();
            let answer = host.request_within(&NomadCommand::GetState, timeout).err();
            let took = began.elapsed();
            assert_eq!(answer, Some(RobotError::Silent { waited: timeout }));
            assert!(took < timeout + Duration::from_millis(500), "{took:?}");
        }
    }
}
