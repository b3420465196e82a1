//! A source and its pace: everything but the clock.

use super::order::{Done, Order};
use super::pace::Pace;
use super::snapshot::{PaceNow, Snapshot};
use super::source::{Refused, Source, Stepped};
use std::time::Duration;

/// Most steps between two looks at what else there is to do.
const MAX_STEPS: u32 = 64;

/// Shortest time between two snapshots.
pub const FRAME: Duration = Duration::from_millis(100);

/// A source that is stepped at its pace. Time is handed in: what has passed on any clock since any moment.
pub struct Stage {
    source: Box<dyn Source>,
    pace: Pace,
    standing: bool,
    /// Something has changed since the latest snapshot.
    changed: bool,
    shown: Option<Duration>,
}

impl Stage {
    /// A source that goes on at a speed, simulated seconds per second; `None` = as fast as it goes, as does every source that
    /// has a time of its own.
    #[must_use]
    pub fn new(source: Box<dyn Source>, speed: Option<f64>) -> Self {
        let speed = speed.filter(|_| source.abilities().pace);
        Self {
            source,
            pace: Pace::new(speed),
            standing: false,
            changed: true,
            shown: None,
        }
    }

    /// Takes the steps that are due, as far as they are few; returns how long until there is more to do, `None` = not before
    /// the next order.
    pub fn advance(&mut self, now: Duration) -> Option<Duration> {
        let now_s = now.as_secs_f64();
        // A source that has a time of its own is waited for at each step.
        let most = if self.source.abilities().pace {
            MAX_STEPS
        } else {
            1
        };
        for _ in 0..most {
            if self.standing || self.pace.wait_s(now_s) != Some(0.0) {
                break;
            }
            self.changed = true;
            match self.source.step() {
                Stepped::Standing => {
                    self.standing = true;
                    self.pace.took(now_s, 0.0, true);
                }
                Stepped::Took { took_s, whole } => self.pace.took(now_s, took_s, whole),
            }
        }
        let next = self.pace.wait_s(now_s).filter(|_| !self.standing);
        next.map(Duration::from_secs_f64)
    }

    /// Carries out an order.
    ///
    /// # Errors
    /// Why it was not done.
    pub fn carry_out(&mut self, order: &Order) -> Result<Done, Refused> {
        self.changed = true;
        let paces = matches!(
            order,
            Order::Pause { .. } | Order::Speed { .. } | Order::Step
        );
        if paces && !self.source.abilities().pace {
            return Err("its time passes by itself".into());
        }
        match order {
            Order::Pause { paused } => self.pace.pause(*paused),
            Order::Speed { factor } => self.pace.set_speed(*factor),
            // Nothing goes on that a step could be of.
            Order::Step if self.standing => self.pace.pause(true),
            Order::Step => self.pace.single(),
            other => {
                let done = self.source.carry_out(other)?;
                self.standing = false;
                return Ok(done);
            }
        }
        Ok(Done::Well)
    }

    /// No page has steered for `silence`.
    pub fn steering_lost(&mut self, silence: Duration) {
        (self.changed, self.standing) = (true, false);
        self.source.steering_lost(silence);
    }

    /// A snapshot, when something has changed and the last one is old enough.
    pub fn show(&mut self, now: Duration) -> Option<Snapshot> {
        let early = self.shown.is_some_and(|shown| now < shown + FRAME);
        if early || !self.changed {
            return None;
        }
        (self.changed, self.shown) = (false, Some(now));
        let mut snapshot = self.source.snapshot();
        snapshot.set_pace(PaceNow {
            speed: self.pace.speed(),
            paused: self.pace.is_paused(),
            standing: self.standing,
        });
        Some(snapshot)
    }

    /// How long until the next snapshot may be shown; `None` = nothing has changed.
    #[must_use]
    pub fn until_shown(&self, now: Duration) -> Option<Duration> {
        let due = self.shown.map_or(now, |shown| shown + FRAME);
        self.changed.then(|| due.saturating_sub(now))
    }

    /// The program is about to end.
    ///
    /// # Errors
    /// What could not be brought to an end, in a sentence.
    pub fn end(&mut self) -> Result<(), String> {
        self.source.end()
    }

    /// Somebody came who has seen nothing yet.
    pub fn refresh(&mut self) {
        self.changed = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::snapshot::tests::empty;
    use crate::source::Abilities;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// Counts its steps of 0.5 s; stands after ten.
    struct Counting(Arc<AtomicU32>);

    impl Source for Counting {
        fn abilities(&self) -> Abilities {
            Abilities {
                pace: true,
                ..Abilities::default()
            }
        }

        fn step(&mut self) -> Stepped {
            if self.0.load(Ordering::Relaxed) >= 10 {
                return Stepped::Standing;
            }
            self.0.fetch_add(1, Ordering::Relaxed);
            Stepped::Took {
                took_s: 0.5,
                whole: true,
            }
        }

        fn carry_out(&mut self, order: &Order) -> Result<Done, Refused> {
            match order {
                Order::Stop => Ok(Done::Well),
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
        let mut stage = Stage::new(Box::new(Counting(Arc::clone(&steps))), Some(1.0));
        let count = || steps.load(Ordering::Relaxed);
        let at = |ms: u64| Duration::from_millis(60_000 + ms);
        assert!(stage.advance(at(0)).is_some());
        assert_eq!(count(), 1);
        stage.advance(at(300));
        assert_eq!(count(), 1);
        stage.advance(at(500));
        assert_eq!(count(), 2);
        assert_eq!(
            stage.carry_out(&Order::Speed { factor: None }),
            Ok(Done::Well)
        );
        assert_eq!(stage.advance(at(600)), None);
        assert_eq!(count(), 10);
        assert!(stage.carry_out(&Order::Explore).is_err());
        assert_eq!(stage.advance(at(700)), None);
        assert_eq!(stage.carry_out(&Order::Step), Ok(Done::Well));
        assert!(stage.show(at(800)).unwrap().now.pace.paused);
    }

    #[test]
    fn ten_snapshots_a_second_and_none_of_what_has_not_changed() {
        let source = Counting(Arc::new(AtomicU32::new(10)));
        let mut stage = Stage::new(Box::new(source), None);
        let at = Duration::from_millis;
        assert!(stage.show(at(0)).is_some());
        assert_eq!(stage.until_shown(at(10)), None);
        stage.refresh();
        assert!(stage.show(at(99)).is_none());
        assert_eq!(stage.until_shown(at(90)), Some(at(10)));
        assert!(stage.show(at(100)).is_some());
        assert!(stage.show(at(900)).is_none());
    }
}
