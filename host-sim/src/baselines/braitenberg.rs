//! A hand-written avoider in the manner of V. Braitenberg, *Vehicles*, MIT Press 1984: each sonar
//! pushes the course away from what it hears, the stronger the nearer; speed is constant.
//!
//! The yardstick for distance and coverage: it learns nothing and is tuned by hand.

use crate::pilot::Pilot;
use amp::controller::{Decision, Event, Motion, Outputs};
use amp::fixed::{Mask, Weight};
use amp::scan::{Echo, Scan};
use amp::units::{Bearing, Displacement, Millis};

/// The yardstick's constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuning {
    /// Step per decision, metres.
    pub step_m: f64,
    /// What is farther than this is not heard, metres.
    pub far_m: f64,
    /// Weight of the push against the course.
    pub push: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            step_m: 0.25,
            far_m: 0.9,
            push: 2.0,
        }
    }
}

/// A Braitenberg vehicle with a ring of 16 sonars.
#[derive(Debug, Clone)]
pub struct Braitenberg {
    tuning: Tuning,
    scan: Scan<16>,
    standing: bool,
    motion: u16,
    /// Unit vector of the course in the ring's frame.
    course: [f64; 2],
}

impl Braitenberg {
    /// A vehicle that starts along the ring's x axis.
    #[must_use]
    pub fn new(tuning: Tuning) -> Self {
        Self {
            tuning,
            scan: Scan::default(),
            standing: true,
            motion: 0,
            course: [1.0, 0.0],
        }
    }

    /// Course and pushes added up. Only what lies ahead (within a quarter turn of the course) pushes,
    /// so a wall along the side does not drive the robot away from its course.
    fn next_course(&self) -> [f64; 2] {
        let mut sum = self.course;
        for (sensor, echo) in self.scan.echoes().iter().enumerate() {
            let Some(range) = echo.range else { continue };
            let nearness = 1.0 - f64::from(range.as_mm()) / (self.tuning.far_m * 1e3);
            let (sin, cos) = libm::sincos(sensor as f64 * std::f64::consts::TAU / 16.0);
            let ahead = cos * self.course[0] + sin * self.course[1];
            if nearness > 0.0 && ahead > -0.1 {
                let push = self.tuning.push * nearness * nearness * (0.2 + ahead.max(0.0));
                sum = [sum[0] - push * cos, sum[1] - push * sin];
            }
        }
        let length = (sum[0] * sum[0] + sum[1] * sum[1]).sqrt();
        if length > 1e-6 {
            [sum[0] / length, sum[1] / length]
        } else {
            [-self.course[1], self.course[0]]
        }
    }

    fn decide(&mut self) -> Outputs<16> {
        self.course = self.next_course();
        let millimeters = |part: f64| libm::round(part * self.tuning.step_m * 1e3) as i32;
        let wanted =
            Displacement::saturating(millimeters(self.course[0]), millimeters(self.course[1]));
        self.motion = self.motion.wrapping_add(1);
        self.standing = false;
        self.scan.renew();
        Outputs {
            motion: Some(Motion {
                id: self.motion,
                displacement: wanted,
                speed_mm_s: 508,
            }),
            decision: Some(Decision {
                situation: [Weight::ZERO; 16],
                plan: None,
                wanted,
                allowed: wanted,
                at_goal: false,
            }),
            ..Outputs::NONE
        }
    }

    /// The ring has turned: the course stays where it is in the world.
    fn turn(&mut self, turned: Bearing) {
        let angle = -f64::from(turned.as_signed_turns()) * std::f64::consts::PI / 32_768.0;
        let (sin, cos) = libm::sincos(angle);
        let [x, y] = self.course;
        self.course = [x * cos - y * sin, x * sin + y * cos];
    }
}

impl Pilot for Braitenberg {
    fn handle(&mut self, at: Millis, event: Event<16>) -> Outputs<16> {
        match event {
            Event::Echo { sensor, range } => {
                self.scan.hear(usize::from(sensor), Echo { range, at });
                if self.standing && self.scan.is_complete(Mask::ALL) {
                    self.decide()
                } else {
                    Outputs::NONE
                }
            }
            Event::Odometry {
                turned, progress, ..
            } => {
                self.turn(turned);
                if progress != amp::controller::Progress::Moving && !self.standing {
                    self.standing = true;
                    self.scan.renew();
                }
                Outputs::NONE
            }
            Event::Command(_) | Event::Tick | Event::Alarm(_) => Outputs::NONE,
        }
    }
}
