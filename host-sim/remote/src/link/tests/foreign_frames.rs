//! Missing, incompatible and restarted controllers.

use super::opened;
use crate::link::{InProcessNode, LinkError, Session, Silent, Transport};
use amp::config::Config;
use amp::parameters::Parameter;
use amp::robot::RobotSpec;
use amp::wire::message::{Clock, DeviceMessage, Dimensions, ModeReport, Refusal};
use amp::wire::{Frame, HostMessage, PROTOCOL, Report, SCHEMA, frame};
use std::io;
use std::sync::{Arc, Mutex};
use std::time::Duration;

#[test]
fn a_silent_other_end_times_out_after_two_seconds() {
    let error = Session::new(Silent).open(1, Clock::Host).unwrap_err();
    assert_eq!(
        error,
        LinkError::Silent {
            waited: Duration::from_secs(2)
        }
    );
    assert!(error.to_string().starts_with("no answer within 2 s"));
}

/// A controller of other dimensions; it may also refuse ours.
struct Stranger<T> {
    inner: T,
    dimensions: Dimensions,
    refuses: bool,
}

impl<T: Transport> Transport for Stranger<T> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.inner.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let mut one = [0];
        let mut bytes = Vec::new();
        while self.inner.receive(&mut one, timeout)? > 0 && one != [0] {
            bytes.push(one[0]);
        }
        let Ok((header, mut report)) = frame::unpack::<Report<16>>(&bytes) else {
            return Ok(0);
        };
        if let DeviceMessage::Hello(hello) = &mut report.message {
            hello.dimensions = self.dimensions;
            if self.refuses {
                report.message = DeviceMessage::Refusal {
                    seq: 0,
                    reason: Refusal::Incompatible(self.dimensions),
                };
            }
        }
        let frame = Frame::pack(header, &report).unwrap();
        buffer[..frame.as_bytes().len()].copy_from_slice(frame.as_bytes());
        Ok(frame.as_bytes().len())
    }
}

#[test]
fn another_protocol_on_either_side_is_named_in_the_error() {
    let ours = Dimensions {
        protocol: PROTOCOL,
        schema: SCHEMA,
        sensors: 16,
        neurons: 16,
    };
    let newer = Dimensions {
        protocol: PROTOCOL + 1,
        ..ours
    };
    let older = Dimensions {
        protocol: PROTOCOL - 1,
        ..ours
    };
    let cousin = Dimensions {
        schema: !SCHEMA,
        ..ours
    };
    for (dimensions, part) in [
        (newer, "update the host-sim"),
        (older, "update the firmware"),
        (cousin, "from the same version"),
    ] {
        for refuses in [false, true] {
            let inner = InProcessNode::<16>::new(Config::recommended());
            let line = Stranger {
                inner,
                dimensions,
                refuses,
            };
            let error = Session::new(line).open(1, Clock::Host).unwrap_err();
            assert_eq!(error, LinkError::Incompatible(dimensions));
            assert!(error.to_string().contains(part), "{error}");
        }
    }
}

fn robot_of_eight() -> Config<8> {
    let sixteen = Config::recommended();
    Config {
        robot: RobotSpec::miniature(),
        enabled: sixteen.enabled,
        encoding: sixteen.encoding,
        exploration: sixteen.exploration,
        action_code: sixteen.action_code,
        learning: sixteen.learning,
        online: sixteen.online,
        planning: sixteen.planning,
        clearance_mm: sixteen.clearance_mm,
        shield: sixteen.shield,
        fault_detection: sixteen.fault_detection,
        open_space: sixteen.open_space,
    }
}

#[test]
fn the_mind_of_another_robot_is_refused() {
    let error = Session::new(InProcessNode::new(robot_of_eight()))
        .open(1, Clock::Host)
        .unwrap_err();
    let sentence = error.to_string();
    assert!(sentence.contains("8 sonars and 16 neurons"), "{sentence}");
}

/// A node that a test can reset.
#[derive(Clone)]
struct SharedNode(Arc<Mutex<InProcessNode>>);

impl Transport for SharedNode {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.lock().unwrap().send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        self.0.lock().unwrap().receive(buffer, timeout)
    }
}

#[test]
fn a_mind_that_starts_anew_is_noticed_and_found_again() {
    let shared = SharedNode(Arc::new(Mutex::new(InProcessNode::new(
        Config::recommended(),
    ))));
    let mut session = opened(shared.clone());
    shared.0.lock().unwrap().restart(Config::recommended());
    let error = session.counters().unwrap_err();
    assert!(matches!(error, LinkError::Restarted(_)), "{error}");
    assert!(error.is_transient());
    session.open(2, Clock::Host).unwrap();
    assert!(session.counters().is_ok());
}

#[test]
fn a_late_answer_of_an_earlier_session_is_ignored() {
    let shared = SharedNode(Arc::new(Mutex::new(InProcessNode::new(
        Config::recommended(),
    ))));
    let mut earlier = opened(shared.clone());
    // The response stays on the line.
    let mut other = Session::new(shared);
    earlier.queue(&HostMessage::Counters).unwrap();
    earlier.send_heartbeat(0).unwrap();
    other.open(2, Clock::Host).unwrap();
    let (value, _) = other.parameter(Parameter::Step, None).unwrap();
    assert_eq!(value, i32::from(Config::recommended().robot.step_mm));
}

#[test]
fn a_restarted_host_with_the_same_session_number_is_accepted() {
    let shared = SharedNode(Arc::new(Mutex::new(InProcessNode::new(
        Config::recommended(),
    ))));
    let mut earlier = opened(shared.clone());
    assert!(earlier.counters().is_ok());
    let mut other = Session::new(shared);
    other.open(earlier.number(), Clock::Host).unwrap();
    assert_eq!(other.number(), earlier.number());
    assert!(other.counters().is_ok());
    assert_eq!(other.mode().unwrap(), ModeReport::Idle);
}
