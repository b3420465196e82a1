//! Opens a session, as it is or with a configuration and a body.

use super::{Fingerprint, Knowledge, LinkError, Session};
use amp::config::{Config, MAX_CONFIG};
use amp::wire::message::{
    Clock, DeviceHello, DeviceMessage, Dimensions, HostHello, Refusal, RobotCommand, TransferPart,
};
use amp::wire::{HostMessage, PROTOCOL, SCHEMA};
use sim::robot::ToldRobot;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Protocol and dimensions of this program.
const LOCAL: Dimensions = Dimensions {
    protocol: PROTOCOL,
    schema: SCHEMA,
    sensors: 16,
    neurons: 16,
};

/// A session number from the clock, never 0; it most likely differs from the one before.
#[must_use]
pub fn fresh_number() -> u16 {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    (now.as_micros() as u16).max(1)
}

/// The session number after `number`.
#[must_use]
pub fn next_number(number: u16) -> u16 {
    number.wrapping_add(1).max(1)
}

impl Session {
    /// Opens session `number` and the next one with this configuration and robot (`None` = a ring
    /// on a held turret) and without knowledge; returns the fingerprints before and after.
    pub(super) fn open_fresh(
        &mut self,
        number: u16,
        config: &Config<16>,
        robot: Option<&ToldRobot>,
    ) -> Result<(Fingerprint, Fingerprint), LinkError> {
        let fresh = Fingerprint::fresh(config)?;
        self.expect_open_space(config.open_space);
        let found = Fingerprint::from(&self.open(number, Clock::Host)?);
        // A learning controller accepts no configuration.
        self.command(0, RobotCommand::Stop)?;
        self.write_part(TransferPart::Config, &Knowledge::encode_config(config)?)?;
        let mut buffer = [0; MAX_CONFIG];
        let body = robot.map_or(&[][..], |robot| robot.body.to_bytes(&mut buffer));
        self.write_part(TransferPart::Body, body)?;
        self.command(0, RobotCommand::Forget)?;
        // It knows already whether its places, if it has any, lead it.
        if robot.is_some_and(|robot| !robot.is_led) {
            self.command(0, RobotCommand::Lead(None))?;
        }
        let hello = self.open(next_number(self.number()), Clock::Host)?;
        match Fingerprint::from(&hello).differences(&fresh).first() {
            Some(what) => Err(LinkError::Mismatch { what }),
            None => Ok((found, fresh)),
        }
    }

    /// Opens session `number`, or the next one if the controller already has that session. A moving
    /// robot stops.
    ///
    /// # Errors
    /// [`LinkError`]: no answer, an incompatible controller, a broken transport.
    pub fn open(&mut self, number: u16, clock: Clock) -> Result<DeviceHello, LinkError> {
        let unknown_messages = self.unknown_messages;
        let mut opening = self.begin(number.max(1), clock)?;
        let mut due = 0_u16;
        for _ in 0..self.retry.attempts {
            self.send(&opening)?;
            due = due.saturating_add(1);
            match self.await_hello(&opening, &mut due)? {
                Some(hello) if self.controller_seq.is_some_and(|seq| seq <= due) => {
                    self.hello = Some(hello);
                    return Ok(hello);
                }
                // The controller has sent more reports than this session requested: the session is
                // an old one.
                Some(_) => {
                    opening = self.begin(next_number(self.number), clock)?;
                    due = 0;
                }
                None => {}
            }
        }
        Err(if self.unknown_messages > unknown_messages {
            LinkError::UnknownMessages
        } else {
            self.no_answer()
        })
    }

    /// Begins session `number` on this side and returns the frame that opens it.
    fn begin(&mut self, number: u16, clock: Clock) -> Result<Vec<u8>, LinkError> {
        (self.number, self.seq) = (number, 0);
        (self.controller_seq, self.missing, self.untracked) = (None, Vec::new(), 0);
        self.hello = None;
        self.received.clear();
        self.pending.clear();
        self.began = Instant::now();
        // A zero ends any half frame in the controller's receiver.
        self.pending.push(0);
        self.queue(&HostMessage::Hello(HostHello {
            dimensions: LOCAL,
            clock,
            open_space: self.open_space,
        }))?;
        Ok(std::mem::take(&mut self.pending))
    }

    /// Waits for the hello. `due` counts the reports that the controller should have sent in this
    /// session.
    fn await_hello(
        &mut self,
        opening: &[u8],
        due: &mut u16,
    ) -> Result<Option<DeviceHello>, LinkError> {
        let until = Instant::now() + self.retry.timeout;
        while let Some((header, report)) = self.next(until)? {
            match report.message {
                DeviceMessage::Hello(hello) if header.session == self.number => {
                    self.controller_seq = Some(header.seq);
                    return match hello.dimensions {
                        LOCAL => Ok(Some(hello)),
                        theirs => Err(LinkError::Incompatible(theirs)),
                    };
                }
                // The controller has just started, so the frame before was lost.
                DeviceMessage::Hello(_) if header.session == 0 => {
                    self.send(opening)?;
                    *due = due.saturating_add(1);
                }
                DeviceMessage::Refusal {
                    reason: Refusal::Incompatible(theirs),
                    ..
                } => return Err(LinkError::Incompatible(theirs)),
                // A report that no request caused, such as the loss of the link.
                _ => *due = due.saturating_add(u16::from(header.session == self.number)),
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::tests::floods::frames;
    use crate::link::{Flood, RetryPolicy};
    use std::time::Duration;

    #[test]
    fn the_count_of_due_reports_saturates() {
        let mut session = Session::new(Flood::of(frames(1, 1)));
        session.number = 1;
        session.set_retry_policy(RetryPolicy {
            timeout: Duration::from_millis(20),
            attempts: 1,
        });
        let mut due = u16::MAX - 1;
        let hello = session.await_hello(&[], &mut due);
        assert_eq!(hello.map(|hello| hello.is_some()), Ok(false));
        assert_eq!(due, u16::MAX);
    }
}
