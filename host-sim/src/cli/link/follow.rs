//! Listening to a mind while keeping its link alive.

use crate::cli::remote::named;
use amp::wire::message::{Clock, FromMind};
use amp::wire::{Report, ToMind};
use files::error::BadInput;
use remote::link::{
    Address, Emulation, LinkError, Session, connect, describe, fresh_number, next_number,
};
use std::io::{self, Write};
use std::time::{Duration, Instant};

/// Time between two signs of life: a mind bears three times as long a silence.
const ALIVE: Duration = Duration::from_millis(100);

/// Signs of life between two questions whether the mind is still there.
const CHECK: u32 = 20;

/// Time between two attempts to reach a mind that was lost.
const AGAIN: Duration = Duration::from_secs(1);

/// Why listening ended.
#[derive(Debug)]
pub(super) enum Trouble {
    /// The link failed.
    Link(LinkError),
    /// A file could not be read or written.
    Input(BadInput),
    /// Standard output could not be written.
    Output(io::Error),
}

impl From<LinkError> for Trouble {
    fn from(error: LinkError) -> Self {
        Self::Link(error)
    }
}

impl From<BadInput> for Trouble {
    fn from(error: BadInput) -> Self {
        Self::Input(error)
    }
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Prints a report, at once.
pub(super) fn print(report: &Report<16>, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{}", describe(report))?;
    out.flush()
}

/// Prints what the mind says until `until`, or until `over` says so.
pub(super) fn follow(
    session: &mut Session,
    until: Option<Instant>,
    out: &mut impl Write,
    mut over: impl FnMut(&FromMind<16>) -> bool,
) -> Result<(), Trouble> {
    let mut count = 0_u32;
    loop {
        let now = Instant::now();
        if until.is_some_and(|until| now >= until) {
            return Ok(());
        }
        session.send_heartbeat(session.elapsed_ms())?;
        let pause = now + ALIVE;
        let pause = until.map_or(pause, |until| until.min(pause));
        while let Some(report) = session.next_report(pause)? {
            print(&report, out)?;
            if over(&report.said) {
                return Ok(());
            }
        }
        count = count.wrapping_add(1);
        // Signs of life are not answered: a mind that is gone would never be missed.
        if count.is_multiple_of(CHECK) && check(session, out, &mut over)? {
            return Ok(());
        }
    }
}

fn check(
    session: &mut Session,
    out: &mut impl Write,
    over: &mut impl FnMut(&FromMind<16>) -> bool,
) -> Result<bool, Trouble> {
    let mut is_over = false;
    let answer = session.request(&ToMind::Counters)?;
    for report in &answer.reports {
        if !matches!(report.said, FromMind::Counters(_)) {
            print(report, out)?;
            is_over |= over(&report.said);
        }
    }
    if answer.missing > 0 {
        eprintln!("{} reports were lost on the way", answer.missing);
    }
    Ok(is_over)
}

/// Prints what the mind says until `until`; reaches for it again when it is lost.
pub(super) fn monitor(
    session: &mut Session,
    address: &Address,
    emulation: &Emulation,
    until: Option<Instant>,
    out: &mut impl Write,
) -> Result<(), Trouble> {
    loop {
        let error = match follow(session, until, out, |_| false) {
            Err(Trouble::Link(error)) if error.is_transient() => error,
            other => return other,
        };
        eprintln!("{}; trying again", named(address, &error));
        let mut broken = matches!(error, LinkError::Broken { .. });
        while let Err(error) = reach(session, address, emulation, broken) {
            if !error.is_transient() {
                return Err(error.into());
            }
            broken = true;
            let pause = Instant::now() + AGAIN;
            if until.is_some_and(|until| pause >= until) {
                return Err(error.into());
            }
            std::thread::sleep(AGAIN);
        }
        eprintln!("{address}: the mind is there again");
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
