//! The controller's time follows that of the messages: heartbeats in long silences.

use super::super::{LinkError, Session};
use super::RemoteController;
use amp::controller::{Outputs, Progress};
use amp::units::Millis;
use amp::wire::HostMessage;
use std::borrow::BorrowMut;

/// Interval of heartbeats in simulated time, milliseconds: half of the allowed silence, so that one
/// may be lost.
const HEARTBEAT_MS: u32 = amp::link::SILENCE_MS / 2;

/// Most heartbeats in a row that the controller does not confirm.
const UNCONFIRMED: u32 = 32;

impl<S: BorrowMut<Session>> RemoteController<S> {
    /// Advances the controller's time. Every message does so; a message of its own is needed only
    /// after a silence.
    pub(super) fn tick(&mut self, at: Millis) -> Result<Outputs<16>, LinkError> {
        if !(HEARTBEAT_MS..1 << 31).contains(&at.since(self.last_sent)) {
            return Ok(Outputs::NONE);
        }
        // A heartbeat is not answered, but its outcome is needed: so this sends odometry without
        // motion.
        let message = HostMessage::Odometry {
            at_ms: at.as_ms(),
            motion: self.motion.map_or(0, |(id, _)| id),
            dx_mm: 0,
            dy_mm: 0,
            turned: 0,
            progress: Progress::Moving,
        };
        self.send(at, &message)
    }

    /// Queues heartbeats for the time until `at`.
    pub(super) fn queue_heartbeats(&mut self, at: Millis) -> Result<(), LinkError> {
        let mut gap_ms = at.since(self.last_sent);
        // A time before the latest one looks like a large gap.
        for number in 1_u32.. {
            if !(HEARTBEAT_MS + 1..1 << 31).contains(&gap_ms) {
                break;
            }
            self.last_sent = Millis::from_ms(self.last_sent.as_ms().wrapping_add(HEARTBEAT_MS));
            let at_ms = self.last_sent.as_ms();
            let session = self.session.borrow_mut();
            session.queue(&HostMessage::Alive { at_ms })?;
            // A chip does not take ten minutes of them at once.
            if number.is_multiple_of(UNCONFIRMED) {
                let answer = session.request(&HostMessage::Counters)?;
                self.outputs(&answer)?;
            }
            gap_ms = at.since(self.last_sent);
        }
        self.last_sent = at;
        Ok(())
    }
}
