//! Limits how far and how fast the robot may go, by the echoes of the ring.
//!
//! An echo means that the nearest surface within the transducer's lobe lies somewhere on an arc
//! around its face. The shield keeps the nearest of these arcs as [points](crate::points), moves
//! them along as the robot moves (odometry), and lets a displacement end where the body would come
//! within a margin of any place of an arc that no newer echo has shown free. A direction in which
//! no transducer looks is closed. The speed is such that the robot can stop within the distance
//! left, at the given deceleration.
//!
//! Time alone frees nothing, and neither does silence. The first echo from beyond an arc does not
//! either: it may be a stray one. Later ones free the places that their cone holds together with
//! half the way to the next: an edge may stand between two places.
//!
//! Points keep the bearing that the ring had at the start. Only new echoes and ways are rotated, so
//! errors of rotation do not add up.
//!
//! The shield cannot know an obstacle thinner than the gap between two lobes from the first place
//! alone. The controller's first move is therefore a short one across the way wanted. At the
//! Nomad's faces the gap is 9 cm wide; the corner of a box can stand 4.5 cm inside it, which the
//! margin covers.

use crate::config::Config;
use crate::disc::direction_of;
use crate::fixed::{Mask, isqrt};
use crate::points::{Beam, Lobe, PointMemory, Ray};
use crate::scan::Echo;
use crate::units::{Bearing, Direction, Displacement, Millis, Range};

mod config;
mod detour;

pub use config::ShieldConfig;
pub(crate) use config::shortest_possible_mm;
pub(crate) use detour::best_detour;

/// Points that it keeps, at most: four rings of 16.
const POINTS: usize = 64;

/// A motion is not shortened by less, millimeters.
const ROUNDING_MM: u16 = 3;

/// From places so far apart, across a way, all of the way is in some lobe, millimeters: wider than
/// the gap between two of the Nomad's lobes anywhere but at the body itself, narrower than the
/// distance of two lobes.
pub(crate) const SECOND_VIEW_MM: u16 = 80;

/// The points of the latest echoes, and when each transducer was heard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shield<const SENSORS: usize> {
    points: PointMemory<POINTS>,
    /// When each transducer was heard last, if ever.
    heard_at: [Millis; SENSORS],
    heard: Mask,
    /// How far the robot has moved since it knew nothing, millimeters; counted until that makes a
    /// second view.
    way_mm: u16,
}

impl<const SENSORS: usize> Default for Shield<SENSORS> {
    fn default() -> Self {
        Self::new()
    }
}

/// What is allowed of a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Allowed {
    /// Distance along the displacement, millimeters.
    pub distance_mm: u16,
    /// Speed, millimeters per second.
    pub speed_mm_s: u16,
}

impl<const SENSORS: usize> Shield<SENSORS> {
    /// Nothing heard yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            points: PointMemory::new(),
            heard_at: [Millis::from_ms(0); SENSORS],
            heard: Mask::NONE,
            way_mm: 0,
        }
    }

    /// Forgets everything heard.
    pub fn forget(&mut self) {
        self.points.restart();
        self.heard = Mask::NONE;
        self.way_mm = 0;
    }

    /// Whether all that is known was heard from one place: a thing may stand unheard in the gap
    /// between two lobes.
    pub(crate) const fn has_one_view(&self) -> bool {
        // The distance arrives in whole millimeters.
        self.way_mm < SECOND_VIEW_MM - 10
    }

    /// Takes an echo of a transducer: it frees what lies before it, and becomes a point itself. If
    /// one is heard that was silent for long the robot may have been carried: nothing else is
    /// known any more.
    #[inline(never)]
    pub fn hear(&mut self, config: &Config<SENSORS>, sensor: usize, echo: Echo) {
        let (Some(limits), Some(axis)) = (&config.shield, config.robot.directions.get(sensor))
        else {
            return;
        };
        if self.since_heard(sensor, echo.at) > Some(limits.forget_ms) {
            self.forget();
        }
        if let Some(at) = self.heard_at.get_mut(sensor) {
            *at = echo.at;
            self.heard = self.heard.with(sensor);
        }
        let Some(range) = echo.range else { return };
        let (x_mm, y_mm) = axis.times(i32::from(config.robot.face_radius_mm));
        let mount = Displacement::saturating(x_mm, y_mm);
        let beam = Beam {
            mount,
            axis: mount.bearing(),
            range: Range::from_mm(shortest_possible_mm(
                range.as_mm(),
                limits.least_range_mm,
                limits.margin_mm,
            )),
            is_echo: true,
        };
        self.points.hear_near(&limits.lobe(config), &beam);
    }

    /// Takes a reading for the guard of a body whose sensors stand anywhere, in the frame that ways
    /// are told in.
    pub(crate) fn hear_along(&mut self, lobe: &Lobe, ray: &Ray, is_echo: bool) {
        self.points.hear_near_along(lobe, ray, is_echo);
    }

    /// A sonar of such a body heard nothing along `ray`; `half` as [`Lobe::half_free`].
    pub(crate) fn hear_nothing(&mut self, half: Bearing, ray: &Ray) {
        self.points.hear_nothing(half, ray, true);
    }

    /// How far a disc of `radius_mm` may go along `way` for the guard of such a body, millimeters.
    pub(crate) fn free_mm(&self, way: Displacement, radius_mm: u16) -> u16 {
        self.points.free_beside_arcs_mm(way, radius_mm)
    }

    /// All that was heard stands this much farther to the left.
    pub(crate) fn turn_frame(&mut self, turn: Bearing) {
        self.points.turn_frame(turn);
    }

    /// Time since a transducer was heard, milliseconds; `None` = never heard.
    fn since_heard(&self, sensor: usize, now: Millis) -> Option<u32> {
        let at = self.heard_at.get(sensor)?;
        self.heard.contains(sensor).then(|| now.after(*at))
    }

    /// The robot has moved and then its ring has turned: the points keep their place in the world.
    pub fn moved(&mut self, by: Displacement, turned: Bearing) {
        if self.has_one_view() {
            self.way_mm = self.way_mm.saturating_add(by.length_mm());
        }
        self.points.carry(by, turned);
    }

    /// How far and how fast the robot may go along `wanted`, by everything heard lately.
    #[must_use]
    pub fn allow(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
        wanted: Displacement,
        now: Millis,
    ) -> Allowed {
        let Some(limits) = &config.shield else {
            return Allowed {
                distance_mm: wanted.length_mm(),
                speed_mm_s: config.robot.speed_mm_s,
            };
        };
        let way = direction_of(wanted, wanted.length_mm().into());
        let is_closed =
            wanted != Displacement::ZERO && self.is_closed(config, limits, enabled, way, now);
        if is_closed {
            limits.allowed(config, wanted, 0)
        } else {
            self.allow_by_points(config, limits, wanted)
        }
    }

    /// What is left of a motion that was allowed, by everything heard since; `None` = all of it.
    #[must_use]
    #[inline(never)]
    pub fn shorten(&self, config: &Config<SENSORS>, wanted: Displacement) -> Option<Allowed> {
        let allowed = self.allow_by_points(config, config.shield.as_ref()?, wanted);
        // The same way, rounded anew, may be a little shorter.
        let shorter = wanted.length_mm().saturating_sub(allowed.distance_mm);
        (shorter > ROUNDING_MM).then_some(allowed)
    }

    fn allow_by_points(
        &self,
        config: &Config<SENSORS>,
        limits: &ShieldConfig,
        wanted: Displacement,
    ) -> Allowed {
        let far_mm = i32::from(wanted.length_mm()) + braking_distance(config);
        let far_mm = far_mm.min(i16::MAX.into()) as u16;
        let free_mm = if wanted == Displacement::ZERO {
            // A robot that stands meets nothing.
            far_mm
        } else {
            let way = wanted.rotated(self.points.heading().direction());
            let reach_mm = config.robot.body_radius_mm.saturating_add(limits.margin_mm);
            self.points
                .free_of_arcs_mm(way.with_length(far_mm), reach_mm)
        };
        limits.allowed(config, wanted, free_mm.into())
    }

    /// Whether a way leads where a transducer looks that was not heard lately, or through the
    /// sector of a disabled one, where a post stays unheard. That sector reaches to 30° from its
    /// axis, beyond those of the neighbors in a ring of 16: the robot is wider than the gap.
    fn is_closed(
        &self,
        config: &Config<SENSORS>,
        limits: &ShieldConfig,
        enabled: Mask,
        way: Direction,
        now: Millis,
    ) -> bool {
        const COS_45_Q14: i32 = 11_585;
        const COS_30_Q14: i32 = 14_189;
        let mut ring = config.robot.directions.iter().enumerate();
        ring.any(|(sensor, axis)| {
            let cosine = way.along(axis.x_q14.into(), axis.y_q14.into());
            if enabled.contains(sensor) {
                let since = self.since_heard(sensor, now);
                cosine > COS_45_Q14 && since.is_none_or(|ms| ms > limits.fresh_ms)
            } else {
                cosine > COS_30_Q14
            }
        })
    }
}

/// Distance in which the robot stops from its highest speed, millimeters.
fn braking_distance<const SENSORS: usize>(config: &Config<SENSORS>) -> i32 {
    let speed = i32::from(config.robot.speed_mm_s);
    speed.saturating_mul(speed) / (2 * i32::from(config.robot.braking_mm_s2.max(1)))
}

/// The highest speed from which the robot stops within `distance`, at most its limit.
fn stopping_speed<const SENSORS: usize>(config: &Config<SENSORS>, distance: i32) -> u16 {
    let squared = 2 * i64::from(distance) * i64::from(config.robot.braking_mm_s2);
    let limit = config.robot.speed_mm_s;
    if squared >= i64::from(limit) * i64::from(limit) {
        return limit;
    }
    isqrt(squared.max(0).unsigned_abs()) as u16
}

#[cfg(test)]
mod tests;
