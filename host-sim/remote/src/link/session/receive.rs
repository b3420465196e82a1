//! Receives the controller's reports, each one once, and lists missing ones.

use super::Session;
use crate::link::LinkError;
use amp::wire::message::{DeviceMessage, ResetCause};
use amp::wire::{FrameError, Header, Report, frame};
use std::time::Instant;

/// Limit for the list of missing reports: more than a controller can repeat.
const MAX_MISSING: usize = 1_000;

impl Session {
    /// Waits until `until` for the next report of this session.
    ///
    /// # Errors
    /// A broken transport or a restarted controller.
    pub fn next_report(&mut self, until: Instant) -> Result<Option<Report<16>>, LinkError> {
        let next = self.next_numbered(until)?;
        Ok(next.map(|(_, report)| report))
    }

    /// The next new report and its number. A confirmation is also returned when it is repeated.
    pub(super) fn next_numbered(
        &mut self,
        until: Instant,
    ) -> Result<Option<(u16, Report<16>)>, LinkError> {
        while let Some((header, report)) = self.next(until)? {
            if header.session == self.number {
                let is_new = self.is_new(header.seq);
                match report.message {
                    // A repeated hello.
                    DeviceMessage::Hello(_) => continue,
                    DeviceMessage::Done { .. } => {}
                    _ if !is_new => continue,
                    _ => {}
                }
                return Ok(Some((header.seq, report)));
            }
            match (header.session, report.message) {
                (0, DeviceMessage::Hello(hello)) => return Err(LinkError::Restarted(hello.reset)),
                (0, DeviceMessage::Refusal { .. }) => {
                    return Err(LinkError::Restarted(ResetCause::Unknown));
                }
                // A late report of an earlier session.
                _ => {}
            }
        }
        Ok(None)
    }

    /// Whether a report of this number has not been received before.
    fn is_new(&mut self, number: u16) -> bool {
        let last = *self.controller_seq.get_or_insert(number.wrapping_sub(1));
        let ahead = number.wrapping_sub(last) as i16;
        if ahead > 0 {
            let room = MAX_MISSING.saturating_sub(self.missing.len());
            let between = (1..ahead).map(|step| last.wrapping_add(step as u16));
            self.missing.extend(between.take(room));
            let surplus = (ahead as usize - 1).saturating_sub(room);
            self.untracked = self.untracked.saturating_add(surplus as u32);
            self.controller_seq = Some(number);
            return true;
        }
        let missed = self.missing.iter().position(|missing| *missing == number);
        if let Some(place) = missed {
            self.missing.swap_remove(place);
        }
        missed.is_some()
    }

    pub(in crate::link) fn next(
        &mut self,
        until: Instant,
    ) -> Result<Option<(Header, Report<16>)>, LinkError> {
        let mut buffer = [0; 1_024];
        loop {
            if let Some(received) = self.received.pop_front() {
                return Ok(Some(received));
            }
            if !self.deadline.allows_read(until) {
                return Ok(None);
            }
            let timeout = until.saturating_duration_since(Instant::now());
            let received = self.transport.receive(&mut buffer, timeout);
            let count = received.map_err(|error| self.broken(&error))?;
            if count == 0 {
                return Ok(None);
            }
            self.decode(buffer.get(..count).unwrap_or(&buffer));
        }
    }

    fn decode(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            let Some(bytes) = self.receiver.push(byte) else {
                continue;
            };
            match frame::unpack(bytes) {
                Ok(received) => self.received.push_back(received),
                Err(FrameError::Content { .. }) => {
                    self.unknown_messages = self.unknown_messages.saturating_add(1)
                }
                // A damaged frame leaves a gap in the numbers.
                Err(FrameError::Shape | FrameError::Crc | FrameError::TooLong) => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::Silent;

    #[test]
    fn late_reports_are_new_and_repeated_ones_are_not() {
        let mut session = Session::new(Silent);
        let mut receive = |number: u16| (session.is_new(number), session.missing.clone());
        assert_eq!(receive(65_533), (true, vec![]));
        assert_eq!(receive(0), (true, vec![65_534, 65_535]));
        assert_eq!(receive(65_535), (true, vec![65_534]));
        assert_eq!(receive(65_535), (false, vec![65_534]));
        assert_eq!(receive(0), (false, vec![65_534]));
        assert_eq!(receive(1), (true, vec![65_534]));
        let said = |device_ms| Report {
            device_ms,
            message: DeviceMessage::Counters(amp::wire::message::Counters::NONE),
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
    fn a_gap_of_any_size_is_counted_in_bounded_memory() {
        let mut session = Session::new(Silent);
        for (number, listed, untracked) in [
            (0, 0, 0),
            (30_000, 1_000, 28_999),
            (30_003, 1_000, 29_001),
            // One that is listed as missing, and one that is not.
            (1_000, 999, 29_001),
            (1_001, 999, 29_001),
            (30_005, 1_000, 29_001),
        ] {
            session.is_new(number);
            let counts = (session.missing.len(), session.untracked);
            assert_eq!(counts, (listed, untracked), "{number}");
        }
        assert_eq!(session.answer(0, Vec::new()).missing, 30_001);
        assert_eq!(session.answer(0, Vec::new()).missing, 0);
    }
}
