//! The simulated robot at the end of a line: bytes in, bytes out.

use super::nserver::{self, Message, Request};
use super::simulated::nak;
use super::{Command, Decoder, Greeting, LaserSetup, MAX_TO_ROBOT, Packet, Simulated};

/// How one speaks on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// As the robot itself.
    Direct,
    /// As the original simulator's server.
    Nserver {
        /// The port that server is at, which it says to whoever connects.
        port: u16,
        /// How many times real time the robot lives, which its state says.
        speed: u32,
    },
}

/// A robot and its line. A packet that is sound but no command is answered with NAK; what is no packet is not answered at
/// all, so that noise on the line is never taken for the answer to the next question.
#[derive(Debug, Clone)]
pub struct Line {
    robot: Simulated,
    protocol: Protocol,
    decoder: Decoder,
    /// The beginning of a message, by the server's protocol.
    begun: Vec<u8>,
    out: Vec<u8>,
}

impl Line {
    /// A line nobody has spoken on.
    #[must_use]
    pub fn new(robot: Simulated, protocol: Protocol) -> Self {
        Self {
            robot,
            protocol,
            decoder: Decoder::new(MAX_TO_ROBOT),
            begun: Vec::new(),
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
        self.decoder = Decoder::new(MAX_TO_ROBOT);
        self.begun.clear();
        self.robot.forget_question();
        self.out.clear();
    }

    /// Says what a Nomad 200 says to whoever connects over TCP; its simulator's server says nothing.
    pub fn greet(&mut self) {
        let greeting = Greeting {
            mask: *self.robot.mask(),
            laser: LaserSetup::default(),
        };
        if self.protocol == Protocol::Direct {
            self.out.extend(greeting.to_bytes());
        }
    }

    /// Takes bytes from the host.
    pub fn receive(&mut self, bytes: &[u8]) {
        if self.protocol == Protocol::Direct {
            let mut found = Vec::new();
            self.decoder.push(bytes, &mut found);
            self.obey(&found);
        } else {
            self.begun.extend(bytes);
            while let Some(message) = Message::take_from(&mut self.begun) {
                self.serve(&Request::of(&message));
            }
        }
    }

    /// No byte has come for a while: an unfinished packet is given up.
    pub fn idle(&mut self) {
        let mut found = Vec::new();
        self.decoder.idle(&mut found);
        self.obey(&found);
        self.begun.clear();
    }

    /// Lets `ms` milliseconds of the robot's time pass.
    pub fn advance(&mut self, ms: u32) {
        for _ in 0..ms {
            self.robot.advance(1);
            if let Some(answer) = self.robot.answer() {
                self.say(&answer);
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
                self.say(&answer);
            }
        }
    }

    /// Sends the robot's answer in the way of the line.
    fn say(&mut self, answer: &Packet) {
        match self.protocol {
            Protocol::Direct => self.out.extend(answer.to_bytes()),
            Protocol::Nserver { speed, .. } => {
                let (state, mask) = (self.robot.state(), self.robot.mask());
                let message = nserver::answer(answer.kind, state, mask, speed);
                self.out.extend(message.to_bytes());
            }
        }
    }

    /// Does what is asked of the original simulator's server.
    fn serve(&mut self, request: &Request) {
        if let Request::Robot(command) = request {
            if let Some(answer) = self.robot.take(command) {
                self.say(&answer);
            }
            return;
        }
        if let Request::Place([x, y, steering, turret]) = *request {
            let _ = self.robot.take(&Command::DefinePosition([x, y]));
            let _ = self.robot.take(&Command::DefineAngles([steering, turret]));
        }
        let port = match self.protocol {
            Protocol::Direct => 0,
            Protocol::Nserver { port, .. } => port,
        };
        if let Some(answer) = nserver::answer_else(request, self.robot.state(), port) {
            self.out.extend(answer.to_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Group, Kind, MAX_FROM_ROBOT};
    use arena::sonar::SonarModel;
    use arena::world::World;

    fn line() -> Line {
        let world = World::paper().unwrap();
        Line::new(
            Simulated::new(world, SonarModel::Ideal, 1),
            Protocol::Direct,
        )
    }

    fn kinds(line: &mut Line) -> Vec<u8> {
        let mut found = Vec::new();
        Decoder::new(MAX_FROM_ROBOT).push(&line.take(), &mut found);
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

    #[test]
    fn the_simulators_server_speaks_of_the_same_robot() {
        let protocol = Protocol::Nserver {
            port: 7_019,
            speed: 5,
        };
        let mut line = Line { protocol, ..line() };
        line.greet();
        assert!(line.take().is_empty());
        let mut ask = |kind: u16, numbers: &[i32], ms: u32| {
            let numbers = numbers.to_vec();
            line.receive(&Message { kind, numbers }.to_bytes());
            let mut bytes = line.take();
            line.advance(ms);
            bytes.extend(line.take());
            let answer = Message::take_from(&mut bytes);
            assert!(bytes.is_empty());
            answer.map(|message| (message.kind, message.numbers))
        };
        assert_eq!(ask(102, &[1, 99], 0), Some((82, vec![7_019])));
        assert_eq!(ask(41, &[10, 20, 900, 0], 0), Some((82, vec![])));
        assert_eq!(ask(200, &[], 0).map(|(kind, _)| kind), Some(88));
        let (kind, state) = ask(13, &[100, 0, 0], 0).unwrap();
        assert_eq!((kind, state[0], state[41]), (80, 50, 1));
        let (kind, state) = ask(39, &[1, 1, 1, 9], 1_200).unwrap();
        assert_eq!((kind, &state[33..38]), (80, &[0, 10, 120, 900, 0][..]));
        assert_eq!(ask(50, &[0], 0), Some((91, vec![1])));
        assert_eq!(ask(103, &[1, 99], 0), None);
    }
}
