//! Looks over a driver's shoulder: how long it takes until nothing is near again, and how long it thinks.

use amp::controller::{Command, Event, Outputs};
use amp::units::{Millis, Range};
use sim::error::EpisodeError;
use sim::pilot::{InspectableController, Pilot, SimState};
use std::time::{Duration, Instant};

/// The goal situation of obstacle avoidance for every method: nothing heard nearer than this, mm from the faces (what the
/// preset `default` asks for).
const CLEAR_MM: u16 = 600;

/// What was seen of a driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Seen {
    /// Times that something came near.
    pub losses: u32,
    /// Time in which something was near, ms.
    pub lost_ms: u64,
    /// Decisions.
    pub decisions: u32,
    /// Wall time spent inside the driver; zero unless it is timed.
    pub thought: Duration,
}

/// A driver that is watched.
#[derive(Debug)]
pub struct Watched<P> {
    driver: P,
    timed: bool,
    ranges: [Option<Range>; 16],
    /// Something was near at the last decision, which was then.
    lost: bool,
    last: Millis,
    seen: Seen,
}

impl<P> Watched<P> {
    /// Watches `driver`; with a clock in hand if `timed`.
    pub fn new(driver: P, timed: bool) -> Self {
        Self {
            driver,
            timed,
            ranges: [None; 16],
            lost: false,
            last: Millis::from_ms(0),
            seen: Seen::default(),
        }
    }

    /// The driver.
    pub fn driver(&self) -> &P {
        &self.driver
    }

    /// What was seen since it was last given a goal.
    pub fn seen(&self) -> Seen {
        self.seen
    }

    fn decided(&mut self, at: Millis) {
        let near = |range: &Option<Range>| range.is_some_and(|range| range.as_mm() < CLEAR_MM);
        let near = self.ranges.iter().any(near);
        self.seen.decisions += 1;
        if self.lost {
            self.seen.lost_ms += u64::from(at.since(self.last));
        } else {
            self.seen.losses += u32::from(near);
        }
        (self.lost, self.last) = (near, at);
    }
}

impl<P: Pilot> Pilot for Watched<P> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match event {
            Event::Echo { sensor, range } => {
                if let Some(place) = self.ranges.get_mut(usize::from(sensor)) {
                    *place = range;
                }
            }
            Event::Command(Command::Seek(_)) => (self.seen, self.lost) = (Seen::default(), false),
            _ => {}
        }
        let began = self.timed.then(Instant::now);
        let outputs = self.driver.handle(at, event);
        self.seen.thought += began.map_or(Duration::ZERO, |began| began.elapsed());
        if outputs.decision.is_some() {
            self.decided(at);
        }
        outputs
    }

    fn failure(&self) -> Option<EpisodeError> {
        self.driver.failure()
    }
}

impl<P: InspectableController> InspectableController for Watched<P> {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.driver.knowledge()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::controller::Progress;
    use amp::units::{Bearing, Displacement};
    use arena::world::Point;
    use sim::ring_pilot::{Perception, Policy, RingPilot};

    struct Stand;

    impl Policy for Stand {
        fn decide(&mut self, _: &Perception) -> Point {
            Point::default()
        }
    }

    #[test]
    fn the_time_until_nothing_is_near_is_counted_from_decision_to_decision() {
        let mut watched = Watched::new(RingPilot::new(Stand, None), false);
        // Something is near at 2 s, 3 s and 5 s; 600 mm away is far enough.
        let nearest = [600, 599, 300, 700, 100, 900];
        for (second, mm) in (1..).zip(nearest) {
            let at = Millis::from_ms(second * 1_000);
            for sensor in 0..16 {
                let range = (sensor == 3).then(|| Range::from_mm(mm));
                let _ = watched.handle(at, Event::Echo { sensor, range });
            }
            let ended = Event::Odometry {
                motion: second as u16,
                moved: Displacement::ZERO,
                turned: Bearing::ZERO,
                progress: Progress::Ended,
            };
            let _ = watched.handle(at, ended);
        }
        let seen = watched.seen();
        assert_eq!((seen.decisions, seen.losses, seen.lost_ms), (6, 2, 3_000));
    }
}
