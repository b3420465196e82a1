//! The simulated robot at the end of a line: bytes in, bytes out.

use super::simulated::nak;
use super::{Command, Decoder, Greeting, LaserSetup, MOST_TO_ROBOT, Packet, Simulated};

/// A robot and its line. A packet that is sound but no command is answered with NAK; what is no packet is not answered at
/// all, so that noise on the line is never taken for the answer to the next question.
#[derive(Debug, Clone)]
pub struct Line {
    robot: Simulated,
    decoder: Decoder,
    out: Vec<u8>,
}

impl Line {
    /// A line nobody has spoken on.
    #[must_use]
    pub fn new(robot: Simulated) -> Self {
        Self {
            robot,
            decoder: Decoder::new(MOST_TO_ROBOT),
            out: Vec::new(),
        }
    }

    /// The robot.
    #[must_use]
    pub fn robot(&self) -> &Simulated {
        &self.robot
    }

    /// Somebody else is at the other end: what was begun is forgotten.
    pub fn renew(&mut self) {
        self.decoder = Decoder::new(MOST_TO_ROBOT);
        self.robot.forget_question();
        self.out.clear();
    }

    /// Says what a Nomad 200 says to whoever connects over TCP.
    pub fn greet(&mut self) {
        let greeting = Greeting {
            mask: *self.robot.mask(),
            laser: LaserSetup::default(),
        };
        self.out.extend(greeting.to_bytes());
    }

    /// Takes bytes from the host.
    pub fn receive(&mut self, bytes: &[u8]) {
        let mut found = Vec::new();
        self.decoder.push(bytes, &mut found);
        self.obey(&found);
    }

    /// No byte has come for a while: an unfinished packet is given up.
    pub fn idle(&mut self) {
        let mut found = Vec::new();
        self.decoder.idle(&mut found);
        self.obey(&found);
    }

    /// Lets `ms` milliseconds of the robot's time pass.
    pub fn advance(&mut self, ms: u32) {
        for _ in 0..ms {
            self.robot.advance(1);
            if let Some(answer) = self.robot.answer() {
                self.out.extend(answer.to_bytes());
            }
        }
    }

    /// Bytes for the host.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    fn obey(&mut self, packets: &[Packet]) {
        for packet in packets {
            let answer = match Command::from_packet(packet) {
                Ok(command) => self.robot.take(&command),
                Err(_) => Some(nak()),
            };
            if let Some(answer) = answer {
                self.out.extend(answer.to_bytes());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nomad::{Group, Kind, MOST_FROM_ROBOT};
    use crate::sonar::SonarModel;
    use crate::world::World;

    fn line() -> Line {
        Line::new(Simulated::new(
            World::paper().unwrap(),
            SonarModel::Ideal,
            1,
        ))
    }

    fn kinds(line: &mut Line) -> Vec<u8> {
        let mut found = Vec::new();
        Decoder::new(MOST_FROM_ROBOT).push(&line.take(), &mut found);
        found.into_iter().map(|packet| packet.kind).collect()
    }

    #[test]
    fn sound_packets_are_answered_and_noise_is_not() {
        let mut line = line();
        line.receive(&[0x37, 0xff, 1, 0, 0, 92]);
        line.receive(&Command::GetState.to_packet().to_bytes());
        assert_eq!(kinds(&mut line), [Kind::Gs as u8]);
        let unknown = Packet {
            kind: 99,
            payload: vec![1, 2],
        };
        line.receive(&unknown.to_bytes());
        let mut short = Command::Velocity([1, 2, 3]).to_packet();
        short.payload.pop();
        line.receive(&short.to_bytes());
        assert_eq!(kinds(&mut line), [Kind::Nak as u8; 2]);
        // Half a packet is forgotten after a while, or when somebody else speaks.
        for forget in [Line::idle, Line::renew] {
            line.receive(&[1, 8, 0, 5, 100]);
            forget(&mut line);
            line.receive(&Command::Get(Group::Pose).to_packet().to_bytes());
            assert_eq!(kinds(&mut line), [Kind::GetRc as u8]);
        }
    }

    #[test]
    fn an_answer_that_waits_comes_with_time() {
        let mut line = line();
        line.receive(&Command::Relative([100, 0, 0]).to_packet().to_bytes());
        let wait = Command::WaitForStop {
            axes: [true; 3],
            timeout_s: 10,
        };
        line.receive(&wait.to_packet().to_bytes());
        assert_eq!(kinds(&mut line), [Kind::Pr as u8]);
        // 10 in: 0.254 m, up to 0.44 m/s and down again in 1.15 s.
        line.advance(1_100);
        assert!(line.take().is_empty());
        line.advance(100);
        assert_eq!(kinds(&mut line), [Kind::Ws as u8]);
    }
}
