//! The host's end of a session: hello, requests and reports.

mod receive;

use super::{Deadline, LinkError, Transport};
use amp::places::Aim;
use amp::units::Displacement;
use amp::wire::message::{DeviceHello, DeviceMessage, Refusal, RobotCommand, Source};
use amp::wire::{Frame, Header, HostMessage, Receiver, Report};
use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

/// Time to live of a command, milliseconds.
pub(super) const COMMAND_TTL_MS: u16 = 1_000;

/// Longest accepted pause of a busy controller.
const MAX_PAUSE: Duration = Duration::from_secs(30);

/// Longest sum of pauses during one attempt.
const MAX_PAUSES: Duration = Duration::from_secs(120);

/// Timeout and number of attempts of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RetryPolicy {
    /// Time without a confirmation after which the request is sent again.
    pub timeout: Duration,
    /// Number of attempts in all.
    pub attempts: u32,
}

impl RetryPolicy {
    /// Time of all attempts together.
    #[must_use]
    pub fn total_timeout(self) -> Duration {
        self.timeout * self.attempts
    }
}

impl Default for RetryPolicy {
    fn default() -> Self {
        Self {
            timeout: Duration::from_millis(500),
            attempts: 4,
        }
    }
}

/// Response to a request.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Response {
    /// Reports between the request and its confirmation.
    pub reports: Vec<Report<16>>,
    /// Why the request was refused.
    pub refusal: Option<Refusal>,
    /// Reports that were lost since the last response.
    pub missing: u32,
}

/// The host's end of a link. A new session is opened with [`open`](Self::open).
pub struct Session {
    pub(super) transport: Box<dyn Transport>,
    receiver: Receiver,
    deadline: Deadline,
    pub(super) received: VecDeque<(Header, Report<16>)>,
    pub(super) number: u16,
    pub(super) seq: u16,
    /// Number of the controller's latest report in the session.
    pub(super) controller_seq: Option<u16>,
    /// Numbers of earlier reports that have not arrived.
    pub(super) missing: Vec<u16>,
    /// Number of missing reports beyond the limit of `missing`.
    pub(super) untracked: u32,
    /// Frames to send with the next request, and with each repetition.
    pub(super) pending: Vec<u8>,
    pub(super) began: Instant,
    pub(super) retry: RetryPolicy,
    pub(super) hello: Option<DeviceHello>,
    /// New sessions announce that rings without an echo are expected.
    pub(super) open_space: bool,
    /// Valid frames with an unknown message.
    pub(super) unknown_messages: u32,
}

impl Session {
    /// A link without a session.
    #[must_use]
    pub fn new(transport: impl Transport + 'static) -> Self {
        Self {
            transport: Box::new(transport),
            receiver: Receiver::new(),
            deadline: Deadline::default(),
            received: VecDeque::new(),
            number: 0,
            seq: 0,
            controller_seq: None,
            missing: Vec::new(),
            untracked: 0,
            pending: Vec::new(),
            began: Instant::now(),
            retry: RetryPolicy::default(),
            hello: None,
            open_space: false,
            unknown_messages: 0,
        }
    }

    /// Whether later sessions announce open space: rings without any echo.
    pub fn expect_open_space(&mut self, expected: bool) {
        self.open_space = expected;
    }

    /// Sets timeout and attempts.
    pub fn set_retry_policy(&mut self, retry: RetryPolicy) {
        self.retry = retry;
    }

    /// The transport, for tests that change it.
    pub fn transport(&mut self) -> &mut dyn Transport {
        &mut *self.transport
    }

    /// Replaces the transport; the session ends until the next [`open`](Self::open).
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

    /// The controller's hello of this session.
    #[must_use]
    pub fn hello(&self) -> Option<&DeviceHello> {
        self.hello.as_ref()
    }

    /// Time since the session began, milliseconds; wraps after 49.7 days.
    #[must_use]
    pub fn elapsed_ms(&self) -> u32 {
        self.began.elapsed().as_millis() as u32
    }

    /// Numbers a message and queues its frame for the next request.
    ///
    /// # Errors
    /// When the message does not fit a frame.
    pub fn queue(&mut self, message: &HostMessage<16>) -> Result<(), LinkError> {
        let header = Header {
            session: self.number,
            seq: self.seq,
        };
        let frame = Frame::pack(header, message).map_err(|error| LinkError::Broken {
            why: error.to_string(),
        })?;
        self.pending.extend_from_slice(frame.as_bytes());
        self.seq = self.seq.wrapping_add(1);
        Ok(())
    }

    /// Sends a message and waits for its confirmation. Without one, or when a report was lost, the
    /// message is sent again with the same number; the controller repeats its reports.
    ///
    /// # Errors
    /// [`LinkError`]: no confirmation, a restarted controller, a broken transport. A refusal is a
    /// response.
    pub fn request(&mut self, message: &HostMessage<16>) -> Result<Response, LinkError> {
        let seq = self.seq;
        self.queue(message)?;
        let pending = std::mem::take(&mut self.pending);
        let mut reports = Vec::new();
        let mut done = false;
        for attempt in 0..self.retry.attempts {
            if attempt > 0 {
                self.send(&[0])?;
            }
            self.send(&pending)?;
            let until = Instant::now() + self.retry.timeout;
            done |= self.await_done(seq, until, &mut reports)?;
            if done && self.missing.is_empty() {
                break;
            }
        }
        // Keeps the allocation for the next request.
        self.pending = pending;
        self.pending.clear();
        if done {
            Ok(self.answer(seq, reports))
        } else {
            Err(self.no_answer())
        }
    }

    /// Sorts the reports by number.
    fn answer(&mut self, seq: u16, mut numbered: Vec<(u16, Report<16>)>) -> Response {
        let latest = self.controller_seq.unwrap_or(0);
        numbered.sort_by_key(|(number, _)| number.wrapping_sub(latest).wrapping_sub(1));
        let missing = std::mem::take(&mut self.missing).len() as u32;
        let untracked = std::mem::take(&mut self.untracked);
        let mut answer = Response {
            missing: missing.saturating_add(untracked),
            ..Response::default()
        };
        for (_, report) in numbered {
            match report.message {
                DeviceMessage::Refusal {
                    seq: refused,
                    reason,
                } if refused == seq => {
                    answer.refusal = Some(reason);
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
            match report.message {
                DeviceMessage::Done { seq: done } if done == seq => return Ok(true),
                // Confirms an earlier frame.
                DeviceMessage::Done { .. } => {}
                // The controller cannot receive now, so a repetition would be lost.
                DeviceMessage::Busy { ms } => {
                    let pause = Duration::from_millis(ms.into());
                    until = Instant::now() + pause.min(MAX_PAUSE) + self.retry.timeout;
                    until = until.min(latest);
                }
                _ => reports.push((number, report)),
            }
        }
        Ok(false)
    }

    /// As [`request`](Self::request), for a message that may be executed twice: repeats it while
    /// reports are lost, and returns a refusal as an error.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn query(&mut self, message: &HostMessage<16>) -> Result<Vec<Report<16>>, LinkError> {
        let mut reports = 0;
        for _ in 0..self.retry.attempts {
            let answer = self.request(message)?;
            if let Some(why) = answer.refusal {
                return Err(LinkError::Refused(why));
            }
            if answer.missing == 0 {
                return Ok(answer.reports);
            }
            reports = answer.missing;
        }
        Err(LinkError::ReportsLost { reports })
    }

    /// Sends a command that is valid for a second.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn command(
        &mut self,
        at_ms: u32,
        command: RobotCommand<16>,
    ) -> Result<Vec<Report<16>>, LinkError> {
        self.query(&HostMessage::Command {
            at_ms,
            ttl_ms: COMMAND_TTL_MS,
            command,
        })
    }

    /// Whether the controller has a memory of places: one without it refuses to be led home. From
    /// then on nothing leads it.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn has_places(&mut self) -> Result<bool, LinkError> {
        let home = Aim::Position(Displacement::ZERO);
        match self.command(0, RobotCommand::Lead(Some(home))) {
            Ok(_) => self.command(0, RobotCommand::Lead(None)).map(|_| true),
            Err(LinkError::Refused(Refusal::NoPlaces)) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Switches to the controller's own sonars. Returns false if it has none; then it waits for
    /// echoes over the link.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn use_own_ring(&mut self) -> Result<bool, LinkError> {
        match self.query(&HostMessage::Source(Source::Ring)) {
            Ok(_) => Ok(true),
            Err(LinkError::Refused(Refusal::NoRing)) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Sends a heartbeat of the time `at_ms` since the session began.
    ///
    /// # Errors
    /// A broken transport.
    pub fn send_heartbeat(&mut self, at_ms: u32) -> Result<(), LinkError> {
        self.queue(&HostMessage::Alive { at_ms })?;
        let pending = std::mem::take(&mut self.pending);
        self.send(&pending)
    }

    pub(super) fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let sent = self.transport.send(bytes);
        sent.map_err(|error| self.broken(&error))
    }

    fn broken(&mut self, error: &io::Error) -> LinkError {
        let why = match self.transport.exit_message() {
            Some(words) => format!("{error}; {words}"),
            None => error.to_string(),
        };
        LinkError::Broken { why }
    }

    pub(super) fn no_answer(&self) -> LinkError {
        LinkError::Silent {
            waited: self.retry.total_timeout(),
        }
    }
}
