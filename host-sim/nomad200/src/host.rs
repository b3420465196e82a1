//! A host's end of the robot's line: asks, and waits for the answer.

use super::{
    Command, Decoder, Greeting, Kind, MAX_FROM_ROBOT, Mask, NoCommand, Packet, State, WrongLength,
};
use remote::link::{Deadline, Transport};
use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::time::{Duration, Instant};

/// How long the client library waits for an answer.
pub const PATIENCE: Duration = Duration::from_secs(1);

/// Why a robot could not be asked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RobotError {
    /// The line broke.
    Broken {
        /// How.
        why: String,
    },
    /// No answer came.
    Silent {
        /// How long it was waited for.
        waited: Duration,
    },
    /// The robot does not know the command.
    Refused(Kind),
    /// The answer is not as long as it should be.
    Answer(Kind, WrongLength),
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
            Self::Answer(kind, wrong) => NoCommand::Length(*kind, *wrong).fmt(f),
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

/// A robot at the other end of a line.
pub struct Host {
    line: Box<dyn Transport>,
    decoder: Decoder,
    deadline: Deadline,
    found: VecDeque<Packet>,
    mask: Mask,
    state: State,
}

impl Host {
    /// A robot at a serial line. Nothing is said yet; what its mask is shows after the first `ct`.
    #[must_use]
    pub fn new(line: impl Transport + 'static) -> Self {
        Self {
            line: Box::new(line),
            decoder: Decoder::new(MAX_FROM_ROBOT),
            deadline: Deadline::default(),
            found: VecDeque::new(),
            mask: Mask::ALL,
            state: State::default(),
        }
    }

    /// A robot at a TCP connection, which greets with its mask.
    ///
    /// # Errors
    /// When the greeting does not come.
    pub fn greeted(line: impl Transport + 'static) -> Result<Self, RobotError> {
        let mut host = Self::new(line);
        let mut greeting = Vec::new();
        let until = Instant::now() + PATIENCE;
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

    /// What state packets hold at present.
    #[must_use]
    pub fn mask(&self) -> &Mask {
        &self.mask
    }

    /// The readings so far.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The line itself, for whoever wants to say something else.
    pub fn line(&mut self) -> &mut dyn Transport {
        &mut *self.line
    }

    /// Asks and waits for the answer as long as the client library does; returns the readings after it.
    ///
    /// # Errors
    /// [`RobotError`].
    pub fn ask(&mut self, command: &Command) -> Result<&State, RobotError> {
        self.ask_within(command, PATIENCE)
    }

    /// As [`ask`](Self::ask) for questions whose answer takes its time.
    ///
    /// # Errors
    /// [`RobotError`].
    pub fn ask_within(
        &mut self,
        command: &Command,
        patience: Duration,
    ) -> Result<&State, RobotError> {
        if let Command::Communicate(mask) = command {
            self.mask = *mask;
        }
        self.line.send(&command.to_packet().to_bytes())?;
        let until = Instant::now() + patience;
        loop {
            let Some(packet) = self.next(until)? else {
                return Err(RobotError::Silent { waited: patience });
            };
            let kind = command.kind();
            if packet.kind == Kind::Nak as u8 {
                return Err(RobotError::Refused(kind));
            }
            // A late answer to an earlier question is none to this one.
            if packet.kind == kind as u8 {
                self.take(command, &packet)
                    .map_err(|wrong| RobotError::Answer(kind, wrong))?;
                return Ok(&self.state);
            }
        }
    }

    fn take(&mut self, command: &Command, packet: &Packet) -> Result<(), WrongLength> {
        match command {
            Command::Get(group) => self.state.take_group(*group, &self.mask, &packet.payload),
            // Three marks of a calibration.
            Command::ConfigureCompass(_) => Ok(()),
            _ => self.state.take_payload(&self.mask, &packet.payload),
        }
    }

    /// The next packet that comes until then.
    ///
    /// # Errors
    /// A broken line.
    pub fn next(&mut self, until: Instant) -> Result<Option<Packet>, RobotError> {
        let mut buffer = [0; 1_024];
        loop {
            if let Some(packet) = self.found.pop_front() {
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
            self.found.extend(found);
        }
    }
}

/// At least one byte, or silence.
fn receive(
    line: &mut dyn Transport,
    buffer: &mut [u8],
    until: Instant,
) -> Result<usize, RobotError> {
    let patience = until.saturating_duration_since(Instant::now());
    match line.receive(buffer, patience)? {
        0 => Err(RobotError::Silent { waited: PATIENCE }),
        count => Ok(count),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use remote::link::Flood;

    #[test]
    fn a_robot_that_never_stops_answering_something_else_is_given_up() {
        let report = Packet::new(Kind::Ct, vec![0; 80]).to_bytes();
        let mut host = Host::new(Flood::of(move || report.clone()));
        for patience in [Duration::from_millis(100), PATIENCE] {
            let began = Instant::now();
            let answer = host.ask_within(&Command::GetState, patience).err();
            let took = began.elapsed();
            assert_eq!(answer, Some(RobotError::Silent { waited: patience }));
            assert!(took < patience + Duration::from_millis(500), "{took:?}");
        }
    }
}
