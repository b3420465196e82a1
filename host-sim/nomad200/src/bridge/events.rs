//! Converts the robot's state packets into events of the controller.

use crate::units::{M_PER_TENTH_INCH, TENTH_DEGREES_PER_TURN};
use crate::{NomadReadings, PosData};
use amp::controller::{Event, Progress};
use amp::units::{Bearing, Displacement, Millis, Range};
use arena::sonar::{M_PER_INCH, MAX_READING_IN};
use arena::world::{Point, Pose};
use core::f64::consts::TAU;

/// Echoes within this distance of each other are reported from one position while the base rolls,
/// m. The shield keeps several times as much clearance.
const SAME_PLACE_M: f64 = 0.015;

/// Longer gaps between two state packets are shortened to this on the controller's clock, ms.
/// Otherwise a pause or a lost answer would look like a silent ring or an overdue motion. It is
/// less than the shortest time of a motion; a packet over a serial line takes a quarter of it.
const MAX_GAP_MS: u32 = 200;

/// An event and the robot's pose at that time.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimedEvent {
    /// When it is delivered, by the controller's clock, which never runs back.
    pub(super) at: Millis,
    /// Age at the delivery, ms; never less than the true age.
    pub(super) age_ms: u32,
    /// Position in the robot's own frame, m.
    pub(super) place: Point,
    /// Bearing of the ring in that frame, rad.
    pub(super) ring: f64,
    pub(super) event: Event<16>,
}

/// Reports the differences between state packets, and queues the events.
#[derive(Debug, Default)]
pub(super) struct EventQueue {
    now: Millis,
    /// The robot's time of the latest packet.
    board_ms: u32,
    /// The position reported so far. The next report contains what rounding left over.
    reported: Point,
    bearing: Bearing,
    /// The robot's time of the latest echo of each sonar.
    sensed_ms: [u32; 16],
    events: Vec<TimedEvent>,
    /// Time of the latest tick.
    ticked: Millis,
}

impl EventQueue {
    /// Starts from this state.
    pub(super) fn begin(&mut self, state: &NomadReadings) {
        self.board_ms = state.time_ms;
        self.reported = position(&state.pose);
        self.bearing = bearing(state.pose[3]);
        self.sensed_ms = state.sonar_at.map(|place| place.sensed_ms);
    }

    /// The controller's time of the latest packet.
    pub(super) fn now(&self) -> Millis {
        self.now
    }

    /// The time for a command that is given now. Queued events are moved to this time and become
    /// older.
    pub(super) fn now_for_command(&mut self) -> Millis {
        for event in &mut self.events {
            event.age_ms += self.now.since(event.at);
            event.at = self.now;
        }
        self.now
    }

    /// The `count` sonars with the oldest echoes, as bits: the next ones to fire.
    pub(super) fn oldest_sonars(&self, count: u32) -> u16 {
        let mut sonars: Vec<_> = (0..16).collect();
        sonars.sort_by_key(|&sonar| {
            core::cmp::Reverse(self.board_ms.wrapping_sub(self.sensed_ms[sonar]))
        });
        let chosen = sonars.into_iter().take(count as usize);
        chosen.fold(0, |bits, sonar| bits | 1 << sonar)
    }

    /// Adds a state packet: each new echo, with odometry to where it was sensed, then odometry to
    /// the current pose. `motion` is the current or last motion, `progress` its progress unless it
    /// just moves.
    pub(super) fn add_state(
        &mut self,
        state: &NomadReadings,
        motion: Option<u16>,
        progress: Option<Progress>,
    ) {
        let elapsed_ms = self.advance_clock(state.time_ms);
        for sensor in self.new_echoes(state) {
            self.add_echo(state, sensor, elapsed_ms, motion);
        }
        let pose_now = PosData {
            pose: state.pose,
            ..PosData::default()
        };
        let (moved, turned) = self.displacement_to(&pose_now);
        let has_moved = moved != Displacement::ZERO || turned != Bearing::ZERO;
        if let Some(motion) = motion.filter(|_| has_moved || progress.is_some()) {
            let progress = progress.unwrap_or(Progress::Moving);
            self.report(self.now, motion, (moved, turned), progress);
        }
    }

    /// Advances the controller's clock to a packet with this time; returns by how much, ms.
    fn advance_clock(&mut self, board_ms: u32) -> u32 {
        let gap_ms = board_ms.wrapping_sub(self.board_ms);
        self.board_ms = board_ms;
        let elapsed_ms = gap_ms.min(MAX_GAP_MS);
        self.now = Millis::from_ms(self.now.as_ms().wrapping_add(elapsed_ms));
        elapsed_ms
    }

    /// Adds an echo, at most `elapsed_ms` before the packet by the controller's clock. The rest of
    /// its age by the robot's clock is sent with it, so the age is the robot's even if the
    /// controller's clock advanced by less. A packet with other sonars may bring an older echo
    /// later.
    fn add_echo(
        &mut self,
        state: &NomadReadings,
        sensor: usize,
        elapsed_ms: u32,
        motion: Option<u16>,
    ) {
        let origin = &state.sonar_at[sensor];
        self.sensed_ms[sensor] = origin.sensed_ms;
        let age_ms = age_ms(state, sensor);
        let backdated_ms = age_ms.min(elapsed_ms);
        let at = self.now.minus_ms(backdated_ms);
        self.report_position(at, origin, motion);
        let event = Event::Echo {
            sensor: sensor as u8,
            range: range(state.sonar[sensor]),
        };
        self.push(at, age_ms - backdated_ms, event);
    }

    /// Takes the queued events, with a tick at the end if time has passed: a controller in this
    /// process has no other clock.
    pub(super) fn take_events(&mut self) -> Vec<TimedEvent> {
        if self.ticked != self.now {
            self.ticked = self.now;
            self.push(self.now, 0, Event::Tick);
        }
        std::mem::take(&mut self.events)
    }

    /// Sonars with a new echo, in the order of firing.
    fn new_echoes(&self, state: &NomadReadings) -> Vec<usize> {
        let is_new = |sensor: &usize| state.sonar_at[*sensor].sensed_ms != self.sensed_ms[*sensor];
        let mut sensors: Vec<_> = (0..16).filter(is_new).collect();
        sensors.sort_by_key(|&sensor| core::cmp::Reverse(age_ms(state, sensor)));
        sensors
    }

    /// Reports odometry to a position, unless it is near the last reported one.
    fn report_position(&mut self, at: Millis, place: &PosData, motion: Option<u16>) {
        let far = position(&place.pose).distance(self.reported) >= SAME_PLACE_M;
        if let Some(motion) = motion.filter(|_| far) {
            let displacement = self.displacement_to(place);
            self.report(at, motion, displacement, Progress::Moving);
        }
    }

    /// Displacement to a position in whole millimeters of the ring's frame, and the ring's turn.
    fn displacement_to(&self, place: &PosData) -> (Displacement, Bearing) {
        let ring = Point::unit(radians(self.bearing));
        let mm = (position(&place.pose) - self.reported).turned_back(ring) * 1e3;
        let moved = Displacement::saturating(libm::rint(mm.x) as i32, libm::rint(mm.y) as i32);
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
        let displacement_m = (mm * 1e-3).turned(Point::unit(radians(self.bearing)));
        self.reported = self.reported + displacement_m;
        self.bearing = self.bearing.plus(turned);
        if turned == Bearing::ZERO && self.merge(at, motion, moved, progress) {
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

    /// Adds a displacement to the last event if that is a report of the same motion and progress.
    /// So a controller on a slow line receives one report for many packets.
    fn merge(&mut self, at: Millis, motion: u16, moved: Displacement, progress: Progress) -> bool {
        let place = self.reported;
        let Some(last) = self.events.last_mut() else {
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
        self.events.push(TimedEvent {
            at,
            age_ms,
            place: self.reported,
            ring: radians(self.bearing),
            event,
        });
    }
}

/// Age of a sonar's echo at the packet, ms. An echo from the future counts as new.
fn age_ms(state: &NomadReadings, sensor: usize) -> u32 {
    let age_ms = state.time_ms.wrapping_sub(state.sonar_at[sensor].sensed_ms);
    if age_ms < 1 << 31 { age_ms } else { 0 }
}

/// Position in a reported pose, m.
pub(super) fn position(pose: &[i32; 4]) -> Point {
    Point::new(f64::from(pose[0]), f64::from(pose[1])) * M_PER_TENTH_INCH
}

/// Position of the robot and heading of its ring in a packet.
pub(super) fn pose(state: &NomadReadings) -> Pose {
    to_pose(&state.pose)
}

/// The same at the time of a reading.
pub(super) fn pose_of(place: &PosData) -> Pose {
    to_pose(&place.pose)
}

fn to_pose(pose: &[i32; 4]) -> Pose {
    Pose::new(position(pose), radians(bearing(pose[3])))
}

/// Converts whole inches to meters; 255 = no echo.
pub(super) fn range_m(inches: u8) -> Option<f64> {
    (inches < MAX_READING_IN).then(|| f64::from(inches) * M_PER_INCH)
}

/// The range in the controller's unit.
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
