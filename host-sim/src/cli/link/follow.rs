//! Prints the messages of a remote controller while it keeps the link alive.

use crate::cli::remote::named;
use amp::wire::message::{Clock, DeviceMessage};
use amp::wire::{HostMessage, Report};
use files::error::BadInput;
use remote::link::{
    Address, Emulation, LinkError, Session, connect, describe, fresh_number, next_number,
};
use std::io::{self, Write};
use std::time::{Duration, Instant};

/// Time between two heartbeats, a third of the controller's timeout.
const HEARTBEAT: Duration = Duration::from_millis(100);

/// Heartbeats between two checks that the controller still answers.
const CHECK: u32 = 20;

/// Time between two attempts to reconnect.
const RECONNECT: Duration = Duration::from_secs(1);

/// Why following ended.
#[derive(Debug)]
pub(super) enum FollowError {
    /// The link failed.
    Link(LinkError),
    /// A file could not be read or written.
    Input(BadInput),
    /// Standard output could not be written.
    Output(io::Error),
}

impl From<LinkError> for FollowError {
    fn from(error: LinkError) -> Self {
        Self::Link(error)
    }
}

impl From<BadInput> for FollowError {
    fn from(error: BadInput) -> Self {
        Self::Input(error)
    }
}

impl From<io::Error> for FollowError {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Prints a report and flushes it.
pub(super) fn print(report: &Report<16>, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{}", describe(report))?;
    out.flush()
}

/// Prints the controller's messages until `until`, or until `over` returns true.
pub(super) fn follow(
    session: &mut Session,
    until: Option<Instant>,
    out: &mut impl Write,
    mut over: impl FnMut(&DeviceMessage<16>) -> bool,
) -> Result<(), FollowError> {
    let mut count = 0_u32;
    loop {
        let now = Instant::now();
        if until.is_some_and(|until| now >= until) {
            return Ok(());
        }
        session.send_heartbeat(session.elapsed_ms())?;
        let pause = now + HEARTBEAT;
        let pause = until.map_or(pause, |until| until.min(pause));
        while let Some(report) = session.next_report(pause)? {
            print(&report, out)?;
            if over(&report.message) {
                return Ok(());
            }
        }
        count = count.wrapping_add(1);
        // Heartbeats have no answer: without this request a lost controller would go unnoticed.
        if count.is_multiple_of(CHECK) && check(session, out, &mut over)? {
            return Ok(());
        }
    }
}

fn check(
    session: &mut Session,
    out: &mut impl Write,
    over: &mut impl FnMut(&DeviceMessage<16>) -> bool,
) -> Result<bool, FollowError> {
    let mut is_over = false;
    let answer = session.request(&HostMessage::Counters)?;
    for report in &answer.reports {
        if !matches!(report.message, DeviceMessage::Counters(_)) {
            print(report, out)?;
            is_over |= over(&report.message);
        }
    }
    if answer.missing > 0 {
        eprintln!("{} reports were lost", answer.missing);
    }
    Ok(is_over)
}

/// Prints the controller's messages until `until`; reconnects when the link is lost.
pub(super) fn monitor(
    session: &mut Session,
    address: &Address,
    emulation: &Emulation,
    until: Option<Instant>,
    out: &mut impl Write,
) -> Result<(), FollowError> {
    loop {
        let error = match follow(session, until, out, |_| false) {
            Err(FollowError::Link(error)) if error.is_transient() => error,
            other => return other,
        };
        eprintln!("{}; trying again", named(address, &error));
        let mut broken = matches!(error, LinkError::Broken { .. });
        while let Err(error) = reach(session, address, emulation, broken) {
            if !error.is_transient() {
                return Err(error.into());
            }
            broken = true;
            let pause = Instant::now() + RECONNECT;
            if until.is_some_and(|until| pause >= until) {
                return Err(error.into());
            }
            std::thread::sleep(RECONNECT);
        }
        eprintln!("{address}: reconnected");
    }
}

fn reach(
    session: &mut Session,
    address: &Address,
    emulation: &Emulation,
    broken: bool,
) -> Result<(), LinkError> {
    let number = if broken {
        session.set_transport(connect(address, emulation)?);
        fresh_number()
    } else {
        next_number(session.number())
    };
    session.open(number, Clock::Device).map(drop)
}
