//! Peers that never stop sending valid frames.

use super::opened;
use crate::link::{Flood, InProcessNode, LinkError, RetryPolicy, Session};
use amp::config::Config;
use amp::wire::message::{Clock, Counters, DeviceMessage};
use amp::wire::{Frame, Header, HostMessage, Report};
use std::time::{Duration, Instant};

const RETRY: RetryPolicy = RetryPolicy {
    timeout: Duration::from_millis(50),
    attempts: 3,
};

/// Valid frames of a session; each number is `step` more than the one before.
pub(in crate::link) fn frames(session: u16, step: u16) -> impl FnMut() -> Vec<u8> + Send {
    let mut seq = 0_u16;
    move || {
        seq = seq.wrapping_add(step);
        let report: Report<16> = Report {
            device_ms: 0,
            message: DeviceMessage::Counters(Counters::NONE),
        };
        let frame = Frame::pack(Header { session, seq }, &report).unwrap();
        frame.as_bytes().to_vec()
    }
}

/// An open session 1 whose controller is replaced by a sender of these frames.
fn flooded(session: u16, step: u16) -> Session {
    let mut open = opened(InProcessNode::new(Config::recommended()));
    open.transport = Box::new(Flood::of(frames(session, step)));
    open.set_retry_policy(RETRY);
    open
}

/// Frames of another session, a repeated one of this session, and new ones of this session.
const FLOODS: [(u16, u16); 3] = [(9, 1), (1, 0), (1, 1)];

#[test]
fn no_wait_outlasts_its_attempts_however_much_is_sent() {
    let waited = RETRY.total_timeout();
    let silent = Some(LinkError::Silent { waited });
    for (session, step) in FLOODS {
        let name = format!("session {session}, step {step}");
        let end = |what: fn(&mut Session) -> Option<LinkError>| {
            let mut session = flooded(session, step);
            what(&mut session)
        };
        let opening = end(|session| session.open(1, Clock::Host).err());
        assert_eq!(opening, silent, "{name}");
        let request = end(|session| session.request(&HostMessage::Counters).err());
        assert_eq!(request, silent, "{name}");
        let asking = end(|session| session.query(&HostMessage::Counters).err());
        assert_eq!(asking, silent, "{name}");
        let counting = end(|session| session.counters().err());
        assert_eq!(counting, silent, "{name}");
        let listening = end(|session| {
            let until = Instant::now() + RETRY.total_timeout();
            loop {
                match session.next_report(until) {
                    Ok(Some(_)) => {}
                    other => return other.err(),
                }
            }
        });
        assert_eq!(listening, None, "{name}");
    }
}
