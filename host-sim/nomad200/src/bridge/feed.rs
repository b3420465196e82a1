//! The robot's state packets as the mind's events.

use crate::units::{M_PER_TENTH_INCH, TENTH_DEGREES_PER_TURN};
use crate::{PosData, State};
use amp::controller::{Event, Progress};
use amp::units::{Bearing, Displacement, Millis, Range};
use arena::sonar::{M_PER_INCH, MAX_READING_IN};
use arena::world::{Point, Pose};
use core::f64::consts::TAU;

/// While the base rolls, echoes heard within this way of each other are reported from the same place, m. The shield keeps
/// several times as much between the body and anything it has heard.
const SAME_PLACE_M: f64 = 0.015;

/// A gap between two state packets longer than this is shortened to it on the mind's clock, ms: after a pause of this
/// program, or after an answer that was lost, the mind must not believe that its ring has fallen silent or that its motion
/// is overdue. Less than the shortest time a motion is given, and a packet over a serial line takes a quarter of it.
const MAX_GAP_MS: u32 = 200;

/// Something that happened, and where the robot was then.
#[derive(Debug, Clone, Copy)]
pub(super) struct Happening {
    /// When it is told, by the mind's clock, which never goes back.
    pub(super) at: Millis,
    /// How long before that it happened, ms; never less than the truth.
    pub(super) age_ms: u32,
    /// In the robot's own frame, m.
    pub(super) place: Point,
    /// Bearing of the ring in that frame, rad.
    pub(super) ring: f64,
    pub(super) event: Event<16>,
}

/// What the mind has been told so far, and what it is to be told.
#[derive(Debug, Default)]
pub(super) struct Feed {
    now: Millis,
    /// Robot's time of the latest packet.
    board_ms: u32,
    /// Where the mind believes to be; what rounding to millimeters leaves over goes into the next report.
    reported: Point,
    bearing: Bearing,
    /// When each sonar was heard last, by the robot.
    heard_ms: [u32; 16],
    happenings: Vec<Happening>,
    /// Until when the mind has been told that time has passed.
    ticked: Millis,
}

impl Feed {
    /// From this state on.
    pub(super) fn begin(&mut self, state: &State) {
        self.board_ms = state.time_ms;
        self.reported = position(&state.pose);
        self.bearing = bearing(state.pose[3]);
        self.heard_ms = state.sonar_at.map(|place| place.sensed_ms);
    }

    /// The mind's time of the latest packet.
    pub(super) fn now(&self) -> Millis {
        self.now
    }

    /// The same for a command that is given now: what has not been told yet is told later, and so is older then.
    pub(super) fn now_for_command(&mut self) -> Millis {
        for happening in &mut self.happenings {
            happening.age_ms += self.now.since(happening.at);
            happening.at = self.now;
        }
        self.now
    }

    /// So many sonars, those heard longest ago, as bits: the next to fire.
    pub(super) fn longest_unheard(&self, count: u32) -> u16 {
        let mut sonars: Vec<_> = (0..16).collect();
        sonars.sort_by_key(|&sonar| {
            core::cmp::Reverse(self.board_ms.wrapping_sub(self.heard_ms[sonar]))
        });
        let chosen = sonars.into_iter().take(count as usize);
        chosen.fold(0, |bits, sonar| bits | 1 << sonar)
    }

    /// Takes a state packet: each new echo, with the way to where it was heard, and at the end the way to where the robot
    /// is now. `motion` is the motion it carries out or carried out last, `news` what became of it, unless it just moves.
    pub(super) fn take(&mut self, state: &State, motion: Option<u16>, news: Option<Progress>) {
        let gap_ms = state.time_ms.wrapping_sub(self.board_ms);
        self.board_ms = state.time_ms;
        let before = self.now;
        let passed = gap_ms.min(MAX_GAP_MS);
        self.now = Millis::from_ms(before.as_ms().wrapping_add(passed));
        for sensor in self.news(state) {
            let place = &state.sonar_at[sensor];
            self.heard_ms[sensor] = place.sensed_ms;
            // As old as the robot says, though the mind's clock may have gone on by less. One of a packet that was asked for
            // later may have been heard before the packet that came earlier.
            let age_ms = age_ms(state, sensor);
            let told_ms = age_ms.min(passed);
            let at = self.now.minus_ms(told_ms);
            self.go_to(at, place, motion);
            let event = Event::Echo {
                sensor: sensor as u8,
                range: range(state.sonar[sensor]),
            };
            self.push(at, age_ms - told_ms, event);
        }
        let here = PosData {
            pose: state.pose,
            ..PosData::default()
        };
        let (moved, turned) = self.way(&here);
        let still = moved == Displacement::ZERO && turned == Bearing::ZERO;
        if let Some(motion) = motion.filter(|_| !still || news.is_some()) {
            self.report(
                self.now,
                motion,
                (moved, turned),
                news.unwrap_or(Progress::Moving),
            );
        }
    }

    /// What has happened since the last call, and at the end that time has passed, if it has: a mind in this process knows
    /// no other clock.
    pub(super) fn hand_over(&mut self) -> Vec<Happening> {
        if self.ticked != self.now {
            self.ticked = self.now;
            self.push(self.now, 0, Event::Tick);
        }
        std::mem::take(&mut self.happenings)
    }

    /// Sonars that have been heard since the last packet, in the order of their firing.
    fn news(&self, state: &State) -> Vec<usize> {
        let is_new = |sensor: &usize| state.sonar_at[*sensor].sensed_ms != self.heard_ms[*sensor];
        let mut sensors: Vec<_> = (0..16).filter(is_new).collect();
        sensors.sort_by_key(|&sensor| core::cmp::Reverse(age_ms(state, sensor)));
        sensors
    }

    /// Reports the way to a place, unless it is as good as where the mind believes to be.
    fn go_to(&mut self, at: Millis, place: &PosData, motion: Option<u16>) {
        let far = position(&place.pose).distance(self.reported) >= SAME_PLACE_M;
        if let Some(motion) = motion.filter(|_| far) {
            let way = self.way(place);
            self.report(at, motion, way, Progress::Moving);
        }
    }

    /// The way to a place in whole millimeters of the ring's frame, and the ring's turn.
    fn way(&self, place: &PosData) -> (Displacement, Bearing) {
        let ring = Point::unit(radians(self.bearing));
        let way = (position(&place.pose) - self.reported).turned_back(ring) * 1e3;
        let moved = Displacement::saturating(libm::rint(way.x) as i32, libm::rint(way.y) as i32);
        (moved, bearing(place.pose[3]).minus(self.bearing))
    }

    fn report(
        &mut self,
        at: Millis,
        motion: u16,
        (moved, turned): (Displacement, Bearing),
        progress: Progress,
    ) {
        let mm = Point::new(f64::from(moved.dx_mm), f64::from(moved.dy_mm));
        let way = (mm * 1e-3).turned(Point::unit(radians(self.bearing)));
        self.reported = self.reported + way;
        self.bearing = self.bearing.plus(turned);
        if turned == Bearing::ZERO && self.adds(at, motion, moved, progress) {
            return;
        }
        self.push(
            at,
            0,
            Event::Odometry {
                motion,
                moved,
                turned,
                progress,
            },
        );
    }

    /// Adds a way to the report before, if that says the same and nothing has happened since: a mind at a slow line is told
    /// once of many packets.
    fn adds(&mut self, at: Millis, motion: u16, moved: Displacement, progress: Progress) -> bool {
        let place = self.reported;
        let Some(last) = self.happenings.last_mut() else {
            return false;
        };
        match &mut last.event {
            Event::Odometry {
                motion: last_motion,
                moved: last_moved,
                turned: Bearing::ZERO,
                progress: last_progress @ (Progress::Moving | Progress::Steering),
            } if (*last_motion, *last_progress) == (motion, progress) => {
                *last_moved = last_moved.plus(moved);
                (last.at, last.place) = (at, place);
                true
            }
            _ => false,
        }
    }

    fn push(&mut self, at: Millis, age_ms: u32, event: Event<16>) {
        self.happenings.push(Happening {
            at,
            age_ms,
            place: self.reported,
            ring: radians(self.bearing),
            event,
        });
    }
}

/// How long before the packet a sonar was heard, ms; one that is said to be heard after it was heard just now.
fn age_ms(state: &State, sensor: usize) -> u32 {
    let age_ms = state.time_ms.wrapping_sub(state.sonar_at[sensor].sensed_ms);
    if age_ms < 1 << 31 { age_ms } else { 0 }
}

/// Where a reported pose is, m.
pub(super) fn position(pose: &[i32; 4]) -> Point {
    Point::new(f64::from(pose[0]), f64::from(pose[1])) * M_PER_TENTH_INCH
}

/// Where the robot is by a packet, and where its ring looks.
pub(super) fn pose(state: &State) -> Pose {
    posed(&state.pose)
}

/// Where the robot was when something was sensed.
pub(super) fn pose_of(place: &PosData) -> Pose {
    posed(&place.pose)
}

fn posed(pose: &[i32; 4]) -> Pose {
    Pose::new(position(pose), radians(bearing(pose[3])))
}

/// Whole inches, 255 = nothing heard; m.
pub(super) fn range_m(inches: u8) -> Option<f64> {
    (inches < MAX_READING_IN).then(|| f64::from(inches) * M_PER_INCH)
}

/// The same as the mind hears it.
fn range(inches: u8) -> Option<Range> {
    // At most 6452 mm.
    range_m(inches).map(|range_m| Range::from_mm((range_m * 1e3) as u16))
}

fn bearing(tenth_degrees: i32) -> Bearing {
    let turn = i64::from(TENTH_DEGREES_PER_TURN);
    let turns = i64::from(tenth_degrees.rem_euclid(TENTH_DEGREES_PER_TURN)) * 65_536;
    // Below 65 536: the angle is below a turn.
    Bearing::from_turns((turns / turn) as u16)
}

fn radians(bearing: Bearing) -> f64 {
    f64::from(bearing.as_turns()) / 65_536.0 * TAU
}

#[cfg(test)]
mod tests;
