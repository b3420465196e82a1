//! Steps a source at its speed; the caller passes the time.

use super::command::{CommandOutcome, PageCommand};
use super::playback_clock::PlaybackClock;
use super::snapshot::{PlaybackDto, Snapshot};
use super::source::{CommandRefused, StepOutcome, ViewSource};
use std::time::Duration;

/// Maximum number of steps per call.
const MAX_STEPS: u32 = 64;

/// Minimum time between two snapshots.
pub const FRAME: Duration = Duration::from_millis(100);

/// A source with its playback clock. Times come from any monotonic clock.
pub struct Runner {
    source: Box<dyn ViewSource>,
    clock: PlaybackClock,
    standing: bool,
    /// Something has changed since the latest snapshot.
    changed: bool,
    last_shown: Option<Duration>,
}

impl Runner {
    /// Runs a source at `speed`, simulated seconds per second; `None` = maximum. A source in real
    /// time ignores the speed.
    #[must_use]
    pub fn new(source: Box<dyn ViewSource>, speed: Option<f64>) -> Self {
        let speed = speed.filter(|_| source.abilities().pace);
        Self {
            source,
            clock: PlaybackClock::new(speed),
            standing: false,
            changed: true,
            last_shown: None,
        }
    }

    /// Takes the steps that are due, up to a limit. Returns the time until the next step; `None` =
    /// not before a command.
    pub fn advance(&mut self, now: Duration) -> Option<Duration> {
        let now_s = now.as_secs_f64();
        // A source in real time waits in each step.
        let most = if self.source.abilities().pace {
            MAX_STEPS
        } else {
            1
        };
        for _ in 0..most {
            if self.standing || self.clock.wait_s(now_s) != Some(0.0) {
                break;
            }
            self.changed = true;
            match self.source.step() {
                StepOutcome::Idle => {
                    self.standing = true;
                    self.clock.step_taken(now_s, 0.0, true);
                }
                StepOutcome::Took { took_s, whole } => self.clock.step_taken(now_s, took_s, whole),
            }
        }
        let next = self.clock.wait_s(now_s).filter(|_| !self.standing);
        next.map(Duration::from_secs_f64)
    }

    /// Executes a command.
    ///
    /// # Errors
    /// Why it was not executed.
    pub fn execute(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused> {
        self.changed = true;
        let paces = matches!(
            command,
            PageCommand::Pause { .. } | PageCommand::Speed { .. } | PageCommand::Step
        );
        if paces && !self.source.abilities().pace {
            return Err("it runs in real time".into());
        }
        match command {
            PageCommand::Pause { paused } => self.clock.pause(*paused),
            PageCommand::Speed { factor } => self.clock.set_speed(*factor),
            // An idle source has no step.
            PageCommand::Step if self.standing => self.clock.pause(true),
            PageCommand::Step => self.clock.single_step(),
            other => {
                let done = self.source.execute(other)?;
                self.standing = false;
                return Ok(done);
            }
        }
        Ok(CommandOutcome::Done)
    }

    /// Reports that no page has steered for `silence`.
    pub fn steering_lost(&mut self, silence: Duration) {
        (self.changed, self.standing) = (true, false);
        self.source.steering_lost(silence);
    }

    /// A snapshot, if something has changed and the latest one is old enough.
    pub fn show(&mut self, now: Duration) -> Option<Snapshot> {
        let early = self
            .last_shown
            .is_some_and(|last_shown| now < last_shown + FRAME);
        if early || !self.changed {
            return None;
        }
        (self.changed, self.last_shown) = (false, Some(now));
        let mut snapshot = self.source.snapshot();
        snapshot.set_playback(PlaybackDto {
            speed: self.clock.speed(),
            paused: self.clock.is_paused(),
            standing: self.standing,
        });
        Some(snapshot)
    }

    /// Time until the next snapshot; `None` = nothing has changed.
    #[must_use]
    pub fn until_shown(&self, now: Duration) -> Option<Duration> {
        let due = self.last_shown.map_or(now, |last_shown| last_shown + FRAME);
        self.changed.then(|| due.saturating_sub(now))
    }

    /// Shuts the source down.
    ///
    /// # Errors
    /// What failed, in a sentence.
    pub fn end(&mut self) -> Result<(), String> {
        self.source.end()
    }

    /// Requests a snapshot for a new viewer.
    pub fn refresh(&mut self) {
        self.changed = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshot::tests::empty;
    use crate::source::Capabilities;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Counts its steps of 0.5 s; idle after ten.
    struct Counting(Arc<AtomicU32>);

    impl ViewSource for Counting {
        fn abilities(&self) -> Capabilities {
            Capabilities {
                pace: true,
                ..Capabilities::default()
            }
        }

        fn step(&mut self) -> StepOutcome {
            if self.0.load(Ordering::Relaxed) >= 10 {
                return StepOutcome::Idle;
            }
            self.0.fetch_add(1, Ordering::Relaxed);
            StepOutcome::Took {
                took_s: 0.5,
                whole: true,
            }
        }

        fn execute(&mut self, command: &PageCommand) -> Result<CommandOutcome, CommandRefused> {
            match command {
                PageCommand::Stop => Ok(CommandOutcome::Done),
                _ => Err("no".into()),
            }
        }

        fn snapshot(&mut self) -> Snapshot {
            empty()
        }
    }

    #[test]
    fn a_source_goes_at_its_pace_and_waits_while_it_stands() {
        let steps = Arc::new(AtomicU32::new(0));
        let mut runner = Runner::new(Box::new(Counting(Arc::clone(&steps))), Some(1.0));
        let count = || steps.load(Ordering::Relaxed);
        let at = |ms: u64| Duration::from_millis(60_000 + ms);
        assert!(runner.advance(at(0)).is_some());
        assert_eq!(count(), 1);
        runner.advance(at(300));
        assert_eq!(count(), 1);
        runner.advance(at(500));
        assert_eq!(count(), 2);
        assert_eq!(
            runner.execute(&PageCommand::Speed { factor: None }),
            Ok(CommandOutcome::Done)
        );
        assert_eq!(runner.advance(at(600)), None);
        assert_eq!(count(), 10);
        assert!(runner.execute(&PageCommand::Explore).is_err());
        assert_eq!(runner.advance(at(700)), None);
        assert_eq!(runner.execute(&PageCommand::Step), Ok(CommandOutcome::Done));
        assert!(runner.show(at(800)).unwrap().now.playback.paused);
    }

    #[test]
    fn ten_snapshots_a_second_and_none_of_what_has_not_changed() {
        let source = Counting(Arc::new(AtomicU32::new(10)));
        let mut runner = Runner::new(Box::new(source), None);
        let at = Duration::from_millis;
        assert!(runner.show(at(0)).is_some());
        assert_eq!(runner.until_shown(at(10)), None);
        runner.refresh();
        assert!(runner.show(at(99)).is_none());
        assert_eq!(runner.until_shown(at(90)), Some(at(10)));
        assert!(runner.show(at(100)).is_some());
        assert!(runner.show(at(900)).is_none());
    }
}
