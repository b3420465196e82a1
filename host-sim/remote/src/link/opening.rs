//! How a session begins.

use super::{LinkError, Session};
use amp::wire::message::{Clock, Dimensions, FromMind, HostHello, MindHello, Refusal};
use amp::wire::{PROTOCOL, SCHEMA, ToMind};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// What both ends have to agree on, as this program has it.
const OURS: Dimensions = Dimensions {
    protocol: PROTOCOL,
    schema: SCHEMA,
    sensors: 16,
    neurons: 16,
};

/// A number for a session, most likely unlike that of the one before: from the clock, never 0.
#[must_use]
pub fn fresh_number() -> u16 {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    (now.as_micros() as u16).max(1)
}

/// Number of the session after `number`.
#[must_use]
pub fn next_number(number: u16) -> u16 {
    number.wrapping_add(1).max(1)
}

impl Session {
    /// Opens session `number`, or the next one if the mind has that one open already. A robot that moves stops.
    ///
    /// # Errors
    /// [`LinkError`]: no answer, an incompatible one, a broken way.
    pub fn open(&mut self, number: u16, clock: Clock) -> Result<MindHello, LinkError> {
        let foreign = self.foreign;
        let mut opening = self.begin(number.max(1), clock)?;
        let mut due = 0_u16;
        for _ in 0..self.patience.attempts {
            self.send(&opening)?;
            due = due.saturating_add(1);
            match self.await_hello(&opening, &mut due)? {
                Some(hello) if self.mind_seq.is_some_and(|seq| seq <= due) => {
                    self.hello = Some(hello);
                    return Ok(hello);
                }
                // It has said more in this session than we know of: the session is an older one's.
                Some(_) => {
                    opening = self.begin(next_number(self.number), clock)?;
                    due = 0;
                }
                None => {}
            }
        }
        Err(if self.foreign > foreign {
            LinkError::Foreign
        } else {
            self.silent()
        })
    }

    /// Begins session `number` on this side and returns the frame that opens it.
    fn begin(&mut self, number: u16, clock: Clock) -> Result<Vec<u8>, LinkError> {
        (self.number, self.seq) = (number, 0);
        (self.mind_seq, self.missing, self.given_up) = (None, Vec::new(), 0);
        self.hello = None;
        self.heard.clear();
        self.burst.clear();
        self.began = Instant::now();
        // A zero first: whatever half a frame the mind has heard ends here.
        self.burst.push(0);
        self.put(&ToMind::Hello(HostHello {
            dimensions: OURS,
            clock,
            open_space: self.open_space,
        }))?;
        Ok(std::mem::take(&mut self.burst))
    }

    /// Waits for the hello; `due` counts what the mind should have said in this session until then.
    fn await_hello(
        &mut self,
        opening: &[u8],
        due: &mut u16,
    ) -> Result<Option<MindHello>, LinkError> {
        let until = Instant::now() + self.patience.attempt;
        while let Some((header, report)) = self.next(until)? {
            match report.said {
                FromMind::Hello(hello) if header.session == self.number => {
                    self.mind_seq = Some(header.seq);
                    return match hello.dimensions {
                        OURS => Ok(Some(hello)),
                        theirs => Err(LinkError::Incompatible(theirs)),
                    };
                }
                // It has just started: what was said to it before is lost.
                FromMind::Hello(_) if header.session == 0 => {
                    self.send(opening)?;
                    *due = due.saturating_add(1);
                }
                FromMind::Refusal {
                    why: Refusal::Incompatible(theirs),
                    ..
                } => return Err(LinkError::Incompatible(theirs)),
                // What it says of itself, as that it has long heard nothing.
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
    use crate::link::{Flood, Patience};
    use std::time::Duration;

    #[test]
    fn what_a_mind_should_have_said_is_counted_to_an_end() {
        let mut session = Session::new(Flood::of(frames(1, 1)));
        session.number = 1;
        session.set_patience(Patience {
            attempt: Duration::from_millis(20),
            attempts: 1,
        });
        let mut due = u16::MAX - 1;
        let hello = session.await_hello(&[], &mut due);
        assert_eq!(hello.map(|hello| hello.is_some()), Ok(false));
        assert_eq!(due, u16::MAX);
    }
}
