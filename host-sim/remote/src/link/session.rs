//! The host's end of a session: hello, requests, reports.

use super::{Deadline, LinkError, Transport};
use amp::wire::message::{FromMind, MindHello, Order, Refusal, ResetCause, Source};
use amp::wire::{Frame, FrameError, Header, Receiver, Report, ToMind, frame};
use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

/// How long an order given by hand stays valid, milliseconds.
pub(super) const ORDER_TTL_MS: u16 = 1_000;

/// The longest pause of a mind that is waited for, however long it says.
const MAX_PAUSE: Duration = Duration::from_secs(30);

/// All pauses of a mind during one attempt together.
const MAX_PAUSES: Duration = Duration::from_secs(120);

/// Most reports that are waited for because later ones have come: more than a mind can say again.
const MAX_MISSING: usize = 1_000;

/// How long an answer is waited for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Patience {
    /// After this time without a confirmation the request is sent again.
    pub attempt: Duration,
    /// How often it is sent in all.
    pub attempts: u32,
}

impl Patience {
    /// All attempts together.
    #[must_use]
    pub fn whole(self) -> Duration {
        self.attempt * self.attempts
    }
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            attempt: Duration::from_millis(500),
            attempts: 4,
        }
    }
}

/// What a request brought about.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Answer {
    /// The mind's reports between the request and its confirmation.
    pub reports: Vec<Report<16>>,
    /// Why it was not done.
    pub refusal: Option<Refusal>,
    /// Reports that were lost on the way since the last answer.
    pub missing: u32,
}

/// The host's end of a link. Opened anew for each session.
pub struct Session {
    pub(super) transport: Box<dyn Transport>,
    receiver: Receiver,
    deadline: Deadline,
    pub(super) heard: VecDeque<(Header, Report<16>)>,
    pub(super) number: u16,
    pub(super) seq: u16,
    /// Number of the mind's latest report in the session.
    pub(super) mind_seq: Option<u16>,
    /// Numbers of reports before it that have not come.
    pub(super) missing: Vec<u16>,
    /// Missing reports beyond those: they are not waited for.
    pub(super) given_up: u32,
    /// Frames that go out with the next request, and again with each repetition.
    pub(super) burst: Vec<u8>,
    pub(super) began: Instant,
    pub(super) patience: Patience,
    pub(super) hello: Option<MindHello>,
    /// The sessions it opens say that open space is expected.
    pub(super) open_space: bool,
    /// Sound frames without a known message.
    pub(super) foreign: u32,
}

impl Session {
    /// A link without a session.
    #[must_use]
    pub fn new(transport: impl Transport + 'static) -> Self {
        Self {
            transport: Box::new(transport),
            receiver: Receiver::new(),
            deadline: Deadline::default(),
            heard: VecDeque::new(),
            number: 0,
            seq: 0,
            mind_seq: None,
            missing: Vec::new(),
            given_up: 0,
            burst: Vec::new(),
            began: Instant::now(),
            patience: Patience::default(),
            hello: None,
            open_space: false,
            foreign: 0,
        }
    }

    /// Says of the sessions to come whether rings without any echo are expected in them.
    pub fn expect_open_space(&mut self, expected: bool) {
        self.open_space = expected;
    }

    /// Waits for answers so long from now on.
    pub fn set_patience(&mut self, patience: Patience) {
        self.patience = patience;
    }

    /// The bytes' way, for whoever wants to meddle with it.
    pub fn transport(&mut self) -> &mut dyn Transport {
        &mut *self.transport
    }

    /// Replaces the bytes' way; the session is gone until the next [`open`](Self::open).
    pub fn set_transport(&mut self, transport: impl Transport + 'static) {
        self.transport = Box::new(transport);
        self.receiver = Receiver::new();
        self.number = 0;
    }

    /// Number of the session; 0 = none.
    #[must_use]
    pub fn number(&self) -> u16 {
        self.number
    }

    /// The mind's hello of this session.
    #[must_use]
    pub fn hello(&self) -> Option<&MindHello> {
        self.hello.as_ref()
    }

    /// Time since the session began, milliseconds; wraps after 49.7 days.
    #[must_use]
    pub fn elapsed_ms(&self) -> u32 {
        self.began.elapsed().as_millis() as u32
    }

    /// Numbers a message and puts its frame beside those that go out with the next request.
    ///
    /// # Errors
    /// When the message fits no frame.
    pub fn put(&mut self, message: &ToMind<16>) -> Result<(), LinkError> {
        let header = Header {
            session: self.number,
            seq: self.seq,
        };
        let frame = Frame::pack(header, message).map_err(|error| LinkError::Broken {
            why: error.to_string(),
        })?;
        self.burst.extend_from_slice(frame.as_bytes());
        self.seq = self.seq.wrapping_add(1);
        Ok(())
    }

    /// Sends a message and waits for its confirmation; without one, or when a report was lost, it is sent again, with the
    /// same number, and the mind says again what it said.
    ///
    /// # Errors
    /// [`LinkError`]: no confirmation, a mind that started anew, a broken way. A refusal is an answer.
    pub fn request(&mut self, message: &ToMind<16>) -> Result<Answer, LinkError> {
        let seq = self.seq;
        self.put(message)?;
        let burst = std::mem::take(&mut self.burst);
        let mut reports = Vec::new();
        let mut done = false;
        for attempt in 0..self.patience.attempts {
            if attempt > 0 {
                self.send(&[0])?;
            }
            self.send(&burst)?;
            let until = Instant::now() + self.patience.attempt;
            done |= self.await_done(seq, until, &mut reports)?;
            if done && self.missing.is_empty() {
                break;
            }
        }
        // Keeps its room for the next request.
        self.burst = burst;
        self.burst.clear();
        if done {
            Ok(self.answer(seq, reports))
        } else {
            Err(self.silent())
        }
    }

    /// Puts the reports in the order they were made.
    fn answer(&mut self, seq: u16, mut numbered: Vec<(u16, Report<16>)>) -> Answer {
        let latest = self.mind_seq.unwrap_or(0);
        numbered.sort_by_key(|(number, _)| number.wrapping_sub(latest).wrapping_sub(1));
        let missing = std::mem::take(&mut self.missing).len() as u32;
        let given_up = std::mem::take(&mut self.given_up);
        let mut answer = Answer {
            missing: missing.saturating_add(given_up),
            ..Answer::default()
        };
        for (_, report) in numbered {
            match report.said {
                FromMind::Refusal { seq: refused, why } if refused == seq => {
                    answer.refusal = Some(why);
                }
                _ => answer.reports.push(report),
            }
        }
        answer
    }

    fn await_done(
        &mut self,
        seq: u16,
        mut until: Instant,
        reports: &mut Vec<(u16, Report<16>)>,
    ) -> Result<bool, LinkError> {
        let latest = until + MAX_PAUSES;
        while let Some((number, report)) = self.next_numbered(until)? {
            match report.said {
                FromMind::Done { seq: done } if done == seq => return Ok(true),
                // Of a frame before.
                FromMind::Done { .. } => {}
                // It cannot hear: nothing is repeated before it can.
                FromMind::Busy { ms } => {
                    let pause = Duration::from_millis(ms.into());
                    until = Instant::now() + pause.min(MAX_PAUSE) + self.patience.attempt;
                    until = until.min(latest);
                }
                _ => reports.push((number, report)),
            }
        }
        Ok(false)
    }

    /// As [`request`](Self::request) for a message that may well be carried out twice: asks anew while part of the answer
    /// was lost, and takes a refusal for an error.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn ask(&mut self, message: &ToMind<16>) -> Result<Vec<Report<16>>, LinkError> {
        let mut reports = 0;
        for _ in 0..self.patience.attempts {
            let answer = self.request(message)?;
            if let Some(why) = answer.refusal {
                return Err(LinkError::Refused(why));
            }
            if answer.missing == 0 {
                return Ok(answer.reports);
            }
            reports = answer.missing;
        }
        Err(LinkError::Lost { reports })
    }

    /// Gives an order, valid for a second.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn order(&mut self, at_ms: u32, order: Order<16>) -> Result<Vec<Report<16>>, LinkError> {
        self.ask(&ToMind::Command {
            at_ms,
            ttl_ms: ORDER_TTL_MS,
            order,
        })
    }

    /// Has the mind listen to sonars of its own. Returns whether it has any: one that has none waits for echoes over the link.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn use_own_ring(&mut self) -> Result<bool, LinkError> {
        match self.ask(&ToMind::Source(Source::Ring)) {
            Ok(_) => Ok(true),
            Err(LinkError::Refused(Refusal::NoRing)) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Says that the host is there, `at_ms` after the session began.
    ///
    /// # Errors
    /// A broken way.
    pub fn alive(&mut self, at_ms: u32) -> Result<(), LinkError> {
        self.put(&ToMind::Alive { at_ms })?;
        let burst = std::mem::take(&mut self.burst);
        self.send(&burst)
    }

    /// Waits until `until` for the mind's next report in this session.
    ///
    /// # Errors
    /// A broken way, a mind that started anew.
    pub fn next_report(&mut self, until: Instant) -> Result<Option<Report<16>>, LinkError> {
        let next = self.next_numbered(until)?;
        Ok(next.map(|(_, report)| report))
    }

    /// The next report that has not come before, and its number; a confirmation also when it came before.
    fn next_numbered(&mut self, until: Instant) -> Result<Option<(u16, Report<16>)>, LinkError> {
        while let Some((header, report)) = self.next(until)? {
            if header.session == self.number {
                let is_news = self.is_news(header.seq);
                match report.said {
                    // Our hello had been repeated.
                    FromMind::Hello(_) => continue,
                    FromMind::Done { .. } => {}
                    _ if !is_news => continue,
                    _ => {}
                }
                return Ok(Some((header.seq, report)));
            }
            match (header.session, report.said) {
                (0, FromMind::Hello(hello)) => return Err(LinkError::Restarted(hello.reset)),
                (0, FromMind::Refusal { .. }) => {
                    return Err(LinkError::Restarted(ResetCause::Unknown));
                }
                // A late answer of a session before.
                _ => {}
            }
        }
        Ok(None)
    }

    /// Whether the report of this number has not come before.
    fn is_news(&mut self, number: u16) -> bool {
        let last = *self.mind_seq.get_or_insert(number.wrapping_sub(1));
        let ahead = number.wrapping_sub(last) as i16;
        if ahead > 0 {
            let room = MAX_MISSING.saturating_sub(self.missing.len());
            let between = (1..ahead).map(|step| last.wrapping_add(step as u16));
            self.missing.extend(between.take(room));
            let surplus = (ahead as usize - 1).saturating_sub(room);
            self.given_up = self.given_up.saturating_add(surplus as u32);
            self.mind_seq = Some(number);
            return true;
        }
        let missed = self.missing.iter().position(|missing| *missing == number);
        if let Some(place) = missed {
            self.missing.swap_remove(place);
        }
        missed.is_some()
    }

    pub(super) fn next(
        &mut self,
        until: Instant,
    ) -> Result<Option<(Header, Report<16>)>, LinkError> {
        let mut buffer = [0; 1_024];
        loop {
            if let Some(heard) = self.heard.pop_front() {
                return Ok(Some(heard));
            }
            if !self.deadline.allows_read(until) {
                return Ok(None);
            }
            let patience = until.saturating_duration_since(Instant::now());
            let received = self.transport.receive(&mut buffer, patience);
            let count = received.map_err(|error| self.broken(&error))?;
            if count == 0 {
                return Ok(None);
            }
            self.take(buffer.get(..count).unwrap_or(&buffer));
        }
    }

    fn take(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let Some(bytes) = self.receiver.push(byte) else {
                continue;
            };
            match frame::unpack(bytes) {
                Ok(heard) => self.heard.push_back(heard),
                Err(FrameError::Content { .. }) => self.foreign = self.foreign.saturating_add(1),
                // Missed by its number when the next one comes.
                Err(FrameError::Shape | FrameError::Crc | FrameError::TooLong) => {}
            }
        }
    }

    pub(super) fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let sent = self.transport.send(bytes);
        sent.map_err(|error| self.broken(&error))
    }

    fn broken(&mut self, error: &io::Error) -> LinkError {
        let why = match self.transport.last_words() {
            Some(words) => format!("{error}; {words}"),
            None => error.to_string(),
        };
        LinkError::Broken { why }
    }

    pub(super) fn silent(&self) -> LinkError {
        LinkError::Silent {
            waited: self.patience.whole(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::Silent;

    #[test]
    fn reports_that_come_late_are_news_and_those_that_come_again_are_not() {
        let mut session = Session::new(Silent);
        let mut hear = |number: u16| (session.is_news(number), session.missing.clone());
        assert_eq!(hear(65_533), (true, vec![]));
        assert_eq!(hear(0), (true, vec![65_534, 65_535]));
        assert_eq!(hear(65_535), (true, vec![65_534]));
        assert_eq!(hear(65_535), (false, vec![65_534]));
        assert_eq!(hear(0), (false, vec![65_534]));
        assert_eq!(hear(1), (true, vec![65_534]));
        let said = |device_ms| Report {
            device_ms,
            said: FromMind::Counters(amp::wire::message::Counters::NONE),
        };
        let numbered = vec![(1, said(4)), (65_535, said(2)), (0, said(3))];
        let answer = session.answer(7, numbered);
        assert_eq!(answer.missing, 1);
        let order: Vec<_> = answer
            .reports
            .iter()
            .map(|report| report.device_ms)
            .collect();
        assert_eq!(order, [2, 3, 4]);
        assert!(session.missing.is_empty());
    }

    #[test]
    fn a_gap_of_any_size_is_counted_and_takes_little_room() {
        let mut session = Session::new(Silent);
        for (number, kept, given_up) in [
            (0, 0, 0),
            (30_000, 1_000, 28_999),
            (30_003, 1_000, 29_001),
            // One that is waited for, and one that is not.
            (1_000, 999, 29_001),
            (1_001, 999, 29_001),
            (30_005, 1_000, 29_001),
        ] {
            session.is_news(number);
            let counts = (session.missing.len(), session.given_up);
            assert_eq!(counts, (kept, given_up), "{number}");
        }
        assert_eq!(session.answer(0, Vec::new()).missing, 30_001);
        assert_eq!(session.answer(0, Vec::new()).missing, 0);
    }
}
