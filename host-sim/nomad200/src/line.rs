//! The simulated robot behind a line: bytes in, bytes out.

use super::nserver::{self, Request, ServerMessage};
use super::simulated::nak;
use super::{Decoder, Greeting, LaserSetup, MAX_TO_ROBOT, NomadCommand, Packet, SimulatedNomad};

/// Protocol of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Protocol {
    /// The robot's own.
    Direct,
    /// That of the original simulator's server.
    Nserver {
        /// Port of the robot, which the server sends to a client.
        port: u16,
        /// Factor of simulated to real time, which the state reports.
        speed: u32,
    },
}

/// A robot and its line. A valid packet with an unknown command is answered with NAK. Anything else
/// is not answered, so noise never looks like an answer.
#[derive(Debug, Clone)]
pub struct RobotLine {
    robot: SimulatedNomad,
    protocol: Protocol,
    decoder: Decoder,
    /// The beginning of an incomplete server message.
    partial: Vec<u8>,
    out: Vec<u8>,
}

impl RobotLine {
    /// A line without any traffic yet.
    #[must_use]
    pub fn new(robot: SimulatedNomad, protocol: Protocol) -> Self {
        Self {
            robot,
            protocol,
            decoder: Decoder::new(MAX_TO_ROBOT),
            partial: Vec::new(),
            out: Vec::new(),
        }
    }

    /// The robot.
    #[must_use]
    pub fn robot(&self) -> &SimulatedNomad {
        &self.robot
    }

    /// Resets the line for another host.
    pub fn reset(&mut self) {
        self.decoder = Decoder::new(MAX_TO_ROBOT);
        self.partial.clear();
        self.robot.cancel_answer();
        self.out.clear();
    }

    /// Sends the greeting of a Nomad 200; the simulator's server has none.
    pub fn greet(&mut self) {
        let greeting = Greeting {
            mask: *self.robot.mask(),
            laser: LaserSetup::default(),
        };
        if self.protocol == Protocol::Direct {
            self.out.extend(greeting.to_bytes());
        }
    }

    /// Handles bytes from the host.
    pub fn receive(&mut self, bytes: &[u8]) {
        if self.protocol == Protocol::Direct {
            let mut found = Vec::new();
            self.decoder.push(bytes, &mut found);
            self.execute(&found);
        } else {
            self.partial.extend(bytes);
            while let Some(message) = ServerMessage::take_from(&mut self.partial) {
                self.serve(&Request::of(&message));
            }
        }
    }

    /// Discards an incomplete packet after a silence.
    pub fn idle(&mut self) {
        let mut found = Vec::new();
        self.decoder.idle(&mut found);
        self.execute(&found);
        self.partial.clear();
    }

    /// Advances the robot's time by `ms` milliseconds.
    pub fn advance(&mut self, ms: u32) {
        for _ in 0..ms {
            self.robot.advance(1);
            if let Some(answer) = self.robot.answer() {
                self.send(&answer);
            }
        }
    }

    /// Takes the bytes for the host.
    pub fn take(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.out)
    }

    fn execute(&mut self, packets: &[Packet]) {
        for packet in packets {
            let answer = match NomadCommand::from_packet(packet) {
                Ok(command) => self.robot.execute(&command),
                Err(_) => Some(nak()),
            };
            if let Some(answer) = answer {
                self.send(&answer);
            }
        }
    }

    /// Encodes the robot's answer in the line's protocol.
    fn send(&mut self, answer: &Packet) {
        match self.protocol {
            Protocol::Direct => self.out.extend(answer.to_bytes()),
            Protocol::Nserver { speed, .. } => {
                let (state, mask) = (self.robot.state(), self.robot.mask());
                let message = nserver::answer(answer.kind, state, mask, speed);
                self.out.extend(message.to_bytes());
            }
        }
    }

    /// Handles a request to the original simulator's server.
    fn serve(&mut self, request: &Request) {
        if let Request::Robot(command) = request {
            if let Some(answer) = self.robot.execute(command) {
                self.send(&answer);
            }
            return;
        }
        if let Request::Place([x, y, steering, turret]) = *request {
            let _ = self.robot.execute(&NomadCommand::DefinePosition([x, y]));
            let _ = self
                .robot
                .execute(&NomadCommand::DefineAngles([steering, turret]));
        }
        let port = match self.protocol {
            Protocol::Direct => 0,
            Protocol::Nserver { port, .. } => port,
        };
        if let Some(answer) = nserver::answer_request(request, self.robot.state(), port) {
            self.out.extend(answer.to_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, MAX_FROM_ROBOT, ReadingGroup};
    use arena::sonar::SonarModel;
    use arena::world::World;

    fn line() -> RobotLine {
        let world = World::paper().unwrap();
        RobotLine::new(
            SimulatedNomad::new(world, SonarModel::Ideal, 1),
            Protocol::Direct,
        )
    }

    fn kinds(line: &mut RobotLine) -> Vec<u8> {
        let mut found = Vec::new();
        Decoder::new(MAX_FROM_ROBOT).push(&line.take(), &mut found);
        found.into_iter().map(|packet| packet.kind).collect()
    }

    #[test]
    fn sound_packets_are_answered_and_noise_is_not() {
        let mut line = line();
        line.receive(&[0x37, 0xff, 1, 0, 0, 92]);
        line.receive(&NomadCommand::GetState.to_packet().to_bytes());
        assert_eq!(kinds(&mut line), [Kind::Gs as u8]);
        let unknown = Packet {
            kind: 99,
            payload: vec![1, 2],
        };
        line.receive(&unknown.to_bytes());
        let mut short = NomadCommand::Velocity([1, 2, 3]).to_packet();
        short.payload.pop();
        line.receive(&short.to_bytes());
        assert_eq!(kinds(&mut line), [Kind::Nak as u8; 2]);
        // Half a packet is discarded after a silence, or for another host.
        for discard in [RobotLine::idle, RobotLine::reset] {
            line.receive(&[1, 8, 0, 5, 100]);
            discard(&mut line);
            line.receive(&NomadCommand::Get(ReadingGroup::Pose).to_packet().to_bytes());
            assert_eq!(kinds(&mut line), [Kind::GetRc as u8]);
        }
    }

    #[test]
    fn an_answer_that_waits_comes_with_time() {
        let mut line = line();
        line.receive(&NomadCommand::Relative([100, 0, 0]).to_packet().to_bytes());
        let wait = NomadCommand::WaitForStop {
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
    fn the_simulators_server_reports_the_same_robot() {
        let protocol = Protocol::Nserver {
            port: 7_019,
            speed: 5,
        };
        let mut line = RobotLine { protocol, ..line() };
        line.greet();
        assert!(line.take().is_empty());
        let mut ask = |kind: u16, numbers: &[i32], ms: u32| {
            let numbers = numbers.to_vec();
            line.receive(&ServerMessage { kind, numbers }.to_bytes());
            let mut bytes = line.take();
            line.advance(ms);
            bytes.extend(line.take());
            let answer = ServerMessage::take_from(&mut bytes);
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
