//! Observes a driver: time until no obstacle is near again, and wall time per decision.

use amp::controller::{Command, Event, Outputs};
use amp::places::Aim;
use amp::turret::BodySpec;
use amp::units::{Millis, Range};
use sim::error::EpisodeError;
use sim::pilot::{InspectableController, Pilot, SimState};
use sim::robot::MAX_BEAMS;
use sim::senses::{Readings, SenseGoal};
use std::time::{Duration, Instant};

/// Goal of obstacle avoidance for every method: no echo nearer than this, mm from the faces (as the
/// preset `default`).
const CLEAR_MM: u16 = 600;

/// Observation of a driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DriverObservation {
    /// Number of times an obstacle came near.
    pub losses: u32,
    /// Time with an obstacle near, ms.
    pub lost_ms: u64,
    /// Number of decisions.
    pub decisions: u32,
    /// Wall time spent in the driver; zero unless it is measured.
    pub thought: Duration,
}

/// A driver with its observation.
#[derive(Debug)]
pub struct ObservedDriver<P> {
    driver: P,
    timed: bool,
    ranges: [Option<Range>; 16],
    /// An obstacle was near at the last decision.
    lost: bool,
    last: Millis,
    observation: DriverObservation,
}

impl<P> ObservedDriver<P> {
    /// Observes `driver`; measures its wall time if `timed`.
    pub fn new(driver: P, timed: bool) -> Self {
        Self {
            driver,
            timed,
            ranges: [None; 16],
            lost: false,
            last: Millis::from_ms(0),
            observation: DriverObservation::default(),
        }
    }

    /// The observed driver.
    pub fn driver(&self) -> &P {
        &self.driver
    }

    /// The observation since the driver's last goal.
    pub fn observation(&self) -> DriverObservation {
        self.observation
    }

    fn decided(&mut self, at: Millis) {
        let near = |range: &Option<Range>| range.is_some_and(|range| range.as_mm() < CLEAR_MM);
        let near = self.ranges.iter().any(near);
        self.observation.decisions += 1;
        if self.lost {
            self.observation.lost_ms += u64::from(at.since(self.last));
        } else {
            self.observation.losses += u32::from(near);
        }
        (self.lost, self.last) = (near, at);
    }
}

impl<P: Pilot> Pilot for ObservedDriver<P> {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match event {
            Event::Echo { sensor, range } => {
                if let Some(place) = self.ranges.get_mut(usize::from(sensor)) {
                    *place = range;
                }
            }
            Event::Command(Command::Seek(_)) => {
                (self.observation, self.lost) = (DriverObservation::default(), false)
            }
            _ => {}
        }
        let began = self.timed.then(Instant::now);
        let outputs = self.driver.handle(at, event);
        self.observation.thought += began.map_or(Duration::ZERO, |began| began.elapsed());
        if outputs.decision.is_some() {
            self.decided(at);
        }
        outputs
    }

    fn sense(&mut self, at: Millis, readings: &Readings) {
        self.driver.sense(at, readings);
    }

    fn seek_sense(&mut self, goal: Option<SenseGoal>) -> Result<(), EpisodeError> {
        self.driver.seek_sense(goal)
    }

    fn lead_to(&mut self, aim: Option<Aim>) -> Result<(), EpisodeError> {
        self.driver.lead_to(aim)
    }

    fn failure(&self) -> Option<EpisodeError> {
        self.driver.failure()
    }
}

impl<P: InspectableController> InspectableController for ObservedDriver<P> {
    fn knowledge(&mut self) -> Result<&SimState, EpisodeError> {
        self.driver.knowledge()
    }

    fn body(&mut self) -> Result<Option<BodySpec<MAX_BEAMS>>, EpisodeError> {
        self.driver.body()
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
        let mut observer = ObservedDriver::new(RingPilot::new(Stand, None), false);
        // An obstacle is near at 2 s, 3 s and 5 s; 600 mm is far enough.
        let nearest = [600, 599, 300, 700, 100, 900];
        for (second, mm) in (1..).zip(nearest) {
            let at = Millis::from_ms(second * 1_000);
            for sensor in 0..16 {
                let range = (sensor == 3).then(|| Range::from_mm(mm));
                let _ = observer.handle(at, Event::Echo { sensor, range });
            }
            let ended = Event::Odometry {
                motion: second as u16,
                moved: Displacement::ZERO,
                turned: Bearing::ZERO,
                progress: Progress::Ended,
            };
            let _ = observer.handle(at, ended);
        }
        let observation = observer.observation();
        assert_eq!(
            (
                observation.decisions,
                observation.losses,
                observation.lost_ms
            ),
            (6, 2, 3_000)
        );
    }
}
