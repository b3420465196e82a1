//! A controller at the other end of a link as the pilot of a robot.

use super::RemoteController;
use crate::link::{LinkError, Session};
use amp::controller::{Event, Outputs};
use amp::fixed::Mask;
use amp::places::Aim;
use amp::units::Millis;
use amp::wire::message::{self, Refusal, RobotCommand};
use sim::error::EpisodeError;
use sim::pilot::{AgedEcho, Pilot};
use sim::senses::{Readings, SenseGoal};
use std::borrow::BorrowMut;

impl<S: BorrowMut<Session>> Pilot for RemoteController<S> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        if self.error.is_some() {
            return Outputs::NONE;
        }
        let result = self.dispatch(at, event).and_then(|outputs| {
            let twin = self.twin.as_mut();
            twin.map_or(Ok(()), |twin| twin.follow(at, event, &outputs))?;
            Ok(outputs)
        });
        self.record_error(result)
    }

    /// Sends in one frame all echoes up to the last enabled transducer: only that one can complete
    /// the ring and cause a motion.
    fn echoes(&mut self, at: Millis, echoes: &[AgedEcho]) -> (usize, Outputs<16>) {
        if self.error.is_some() {
            return (echoes.len(), Outputs::NONE);
        }
        // Each echo of a body's sensors may shorten its motion.
        let count = match &self.robot {
            None => batch(echoes, self.enabled()),
            Some(_) => 1,
        };
        let sent = echoes.get(..count).unwrap_or(echoes);
        let result = self.send_echoes(at, sent).and_then(|outputs| {
            let twin = self.twin.as_mut();
            twin.map_or(Ok(()), |twin| twin.follow_echoes(at, sent, &outputs))?;
            Ok(outputs)
        });
        (count, self.record_error(result))
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        let Some(robot) = &self.robot else {
            return aim.map_or(Ok(()), |_| Err(EpisodeError::NoPlaces));
        };
        let command = RobotCommand::Lead(robot.led(aim));
        match self.send_command(self.last_sent, command) {
            Ok(_) => {
                if let Some(twin) = &mut self.twin {
                    twin.lead_to(aim);
                }
                Ok(())
            }
            Err(LinkError::Refused(Refusal::NoPlaces)) => Err(EpisodeError::NoPlaces),
            Err(error) => {
                self.error = Some(error.clone());
                Err(EpisodeError::from(error))
            }
        }
    }

    fn sense(&mut self, at: Millis, readings: &Readings) {
        let twin = self.twin.as_mut().filter(|_| self.error.is_none());
        if let Some(aim) = twin.and_then(|twin| twin.sense(at, readings)) {
            // What fails is recorded.
            let _ = self.lead_to(Some(aim));
        }
    }

    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        match &mut self.twin {
            Some(twin) => twin.seek_sense(goal),
            None => goal.map_or(Ok(()), |_| Err(EpisodeError::NoPlaces)),
        }
    }

    fn failure(&self) -> Option<EpisodeError> {
        self.error.clone().map(EpisodeError::from)
    }
}

/// Number of echoes for one frame.
fn batch(echoes: &[AgedEcho], enabled: Mask) -> usize {
    let counts = |echo: &AgedEcho| enabled.contains(usize::from(echo.sensor));
    let last = echoes.iter().rposition(counts);
    // Without an enabled transducer after it, each echo may complete a ring that began earlier.
    last.map_or(1, |last| last + 1).min(message::MAX_ECHOES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_ends_with_the_last_transducer_that_may_complete_the_ring() {
        let echoes: [_; 16] = std::array::from_fn(|sensor| AgedEcho::now(sensor as u8, None));
        assert_eq!(batch(&echoes, Mask::ALL), 16);
        assert_eq!(batch(&echoes, Mask::ALL.without(15)), 15);
        assert_eq!(batch(&echoes[15..], Mask::ALL.without(15)), 1);
        assert_eq!(batch(&echoes, Mask::NONE), 1);
    }
}
