//! Limits how far and how fast the robot may go, by the echoes of the ring.
//!
//! An echo means that the nearest surface within the transducer's lobe lies somewhere on an arc
//! around its face. The shield keeps some arcs of every transducer, moves them along as the robot
//! moves (odometry), and lets a displacement end where the body would come within a margin of the
//! part of any arc that lies most in the way. A direction that no echo covers is closed. The speed
//! is such that the robot can stop within the distance left, at the given deceleration.
//!
//! Arcs are stored by bearing, not by transducer: as the ring turns, its echoes of a near wall
//! replace no arcs of other bearings.
//!
//! An arc does not expire. Each of its points stays until newer echoes contradict it: they come
//! from farther away through a cone that contains the point. Silence from another direction or from
//! a turned ring contradicts nothing: a corner may have moved from the lobe into the gap beside it.
//!
//! Arcs keep the bearing that the ring had at the start. Only new echoes and ways are rotated, so
//! errors of rotation do not add up.
//!
//! The shield cannot know an obstacle thinner than the gap between two lobes from the first place
//! alone. The controller's first move is therefore a short one across the way wanted. At the
//! Nomad's faces the gap is 9 cm wide; the corner of a box can stand 4.5 cm inside it, which the
//! margin covers.

use crate::config::Config;
use crate::fixed::{Mask, isqrt};
use crate::scan::Echo;
use crate::units::{Bearing, Direction, Displacement, Millis};
use arc::{Arc, LobeShape};
use cone::Cone;
use path::StraightPath;

mod arc;
mod cone;
mod config;
mod detour;
mod path;

pub use config::ShieldConfig;

/// Arcs kept per place of the ring, at most.
pub(crate) const ARCS_PER_SENSOR: usize = 4;

/// A motion is not shortened by less, millimeters.
const ROUNDING_MM: u16 = 3;

/// From places so far apart, across a way, all of the way is in some lobe, millimeters: wider than
/// the gap between two of the Nomad's lobes anywhere but at the body itself, narrower than the
/// distance of two lobes.
pub(crate) const SECOND_VIEW_MM: u16 = 80;

/// The arcs of the latest echoes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shield<const SENSORS: usize> {
    /// Of each place of the unturned ring those that look nearest its way, in no order.
    arcs: [[Arc; ARCS_PER_SENSOR]; SENSORS],
    /// Which transducer heard each arc.
    heard_by: [[u8; ARCS_PER_SENSOR]; SENSORS],
    /// When each transducer was heard last, if ever.
    heard_at: [Millis; SENSORS],
    heard: Mask,
    /// How far the ring has turned from the shield's frame.
    turned: Bearing,
    /// The lobe of the last echo.
    lobe: Option<LobeShape>,
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
            arcs: [[Arc::NONE; ARCS_PER_SENSOR]; SENSORS],
            heard_by: [[0; ARCS_PER_SENSOR]; SENSORS],
            heard_at: [Millis::from_ms(0); SENSORS],
            heard: Mask::NONE,
            turned: Bearing::ZERO,
            lobe: None,
            way_mm: 0,
        }
    }

    /// Forgets everything heard.
    pub fn forget(&mut self) {
        self.arcs.as_flattened_mut().fill(Arc::NONE);
        self.heard = Mask::NONE;
        self.turned = Bearing::ZERO;
        self.way_mm = 0;
    }

    /// Whether all that is known was heard from one place: a thing may stand unheard in the gap
    /// between two lobes.
    pub(crate) const fn has_one_view(&self) -> bool {
        // The distance arrives in whole millimeters.
        self.way_mm < SECOND_VIEW_MM - 10
    }

    /// Takes an echo of a transducer: it counts against the arcs it contradicts, and becomes an arc
    /// itself. At its place of the ring it replaces the arc whose valid points are farthest.
    #[inline(never)]
    pub fn hear(&mut self, config: &Config<SENSORS>, sensor: usize, echo: Echo) {
        let (Some(limits), Some(axis)) = (&config.shield, config.robot.directions.get(sensor))
        else {
            return;
        };
        let axis = self.in_frame(*axis);
        let (x_mm, y_mm) = axis.times(i32::from(config.robot.face_radius_mm));
        let cone = Cone::new(Displacement::saturating(x_mm, y_mm), axis, echo);
        self.drop_if_silent(limits, sensor, echo.at);
        let place = self.place_of(config, sensor, axis);
        if self.lobe.is_none_or(|lobe| lobe.half != limits.half_lobe) {
            self.lobe = Some(LobeShape::of(limits.half_lobe));
        }
        let Some(lobe) = &self.lobe else { return };
        let arcs = self.arcs.as_flattened_mut().iter_mut();
        for arc in arcs.filter(|arc| cone.looks_along(arc)) {
            cone.look(limits, lobe, arc);
        }
        if echo.range.is_none() {
            return;
        }
        let kept = usize::from(limits.places).clamp(1, ARCS_PER_SENSOR);
        let arcs = self.arcs.get_mut(place).into_iter().flatten();
        let heard_by = self.heard_by.get_mut(place).into_iter().flatten();
        let (mut farthest, mut most) = (None, 0);
        for slot in arcs.zip(heard_by).take(kept) {
            let distance = slot.0.half_distance_squared(lobe, most);
            if distance >= most {
                (farthest, most) = (Some(slot), distance);
            }
        }
        if let Some((arc, by)) = farthest {
            // A ring has at most 32 transducers.
            (*arc, *by) = (Arc::heard(cone.face, cone.axis, echo), sensor as u8);
        }
    }

    /// Drops the arcs of a transducer that was silent for long.
    fn drop_if_silent(&mut self, limits: &ShieldConfig, sensor: usize, now: Millis) {
        let is_silent = self.since_heard(sensor, now) > Some(limits.forget_ms);
        if let Some(at) = self.heard_at.get_mut(sensor) {
            *at = now;
            self.heard = self.heard.with(sensor);
        }
        if is_silent {
            let heard_by = self.heard_by.as_flattened().iter();
            for (arc, by) in self.arcs.as_flattened_mut().iter_mut().zip(heard_by) {
                if usize::from(*by) == sensor {
                    *arc = Arc::NONE;
                }
            }
            self.way_mm = 0;
        }
    }

    /// Time since a transducer was heard, milliseconds; `None` = never heard.
    fn since_heard(&self, sensor: usize, now: Millis) -> Option<u32> {
        let at = self.heard_at.get(sensor)?;
        self.heard.contains(sensor).then(|| now.after(*at))
    }

    /// The place of the unturned ring that looks nearest this way: the transducer's own while the
    /// ring is not turned.
    fn place_of(&self, config: &Config<SENSORS>, sensor: usize, axis: Direction) -> usize {
        if self.turned == Bearing::ZERO {
            return sensor;
        }
        let (x, y) = (i32::from(axis.x_q14), i32::from(axis.y_q14));
        let places = config.robot.directions.iter().enumerate();
        let nearest = places.max_by_key(|(_, direction)| direction.along(x, y));
        nearest.map_or(sensor, |(place, _)| place)
    }

    /// The robot has moved and then its ring has turned: the arcs keep their place in the world.
    pub fn moved(&mut self, by: Displacement, turned: Bearing) {
        if by != Displacement::ZERO {
            let by = self.way_in_frame(by);
            if self.has_one_view() {
                self.way_mm = self.way_mm.saturating_add(by.length_mm());
            }
            if self.heard != Mask::NONE {
                for arc in self.arcs.as_flattened_mut() {
                    arc.face = arc.face.minus(by);
                }
            }
        }
        self.turned = self.turned.plus(turned);
    }

    /// A way in the ring's frame, in the shield's.
    fn way_in_frame(&self, way: Displacement) -> Displacement {
        if self.turned == Bearing::ZERO {
            return way;
        }
        way.rotated(self.turned.direction())
    }

    /// A direction in the ring's frame, in the shield's.
    fn in_frame(&self, axis: Direction) -> Direction {
        if self.turned == Bearing::ZERO {
            return axis;
        }
        let (x, y) = (self.turned.direction()).rotate(axis.x_q14.into(), axis.y_q14.into());
        Direction {
            x_q14: x as i16,
            y_q14: y as i16,
        }
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
        self.allow_by(config, enabled, wanted, now, Mask::ALL)
    }

    /// As [`allow`](Self::allow), by what the transducers in `among` heard: enough for a motion
    /// that the others have allowed already.
    #[must_use]
    pub fn allow_by(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
        wanted: Displacement,
        now: Millis,
        among: Mask,
    ) -> Allowed {
        let length = wanted.length_mm();
        let Some(limits) = &config.shield else {
            return Allowed {
                distance_mm: length,
                speed_mm_s: config.robot.speed_mm_s,
            };
        };
        let length = i32::from(length);
        let new;
        let lobe = match &self.lobe {
            Some(lobe) if lobe.half == limits.half_lobe => lobe,
            _ => {
                new = LobeShape::of(limits.half_lobe);
                &new
            }
        };
        let mut path = StraightPath::new(config, limits, lobe, wanted, length, now);
        path.direction = self.in_frame(path.direction);
        let free = self.free_distance(
            config,
            enabled,
            &path,
            length.saturating_add(braking_distance(config)),
            among,
        );
        let distance = free.min(length);
        let begun = distance >= i32::from(limits.least_mm).min(length);
        Allowed {
            distance_mm: if begun { distance as u16 } else { 0 },
            speed_mm_s: stopping_speed(config, free),
        }
    }

    /// What is left of a motion that was allowed, by what a transducer has just heard and heard
    /// before; `None` = all of it.
    #[must_use]
    #[inline(never)]
    pub fn shorten(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
        wanted: Displacement,
        now: Millis,
        sensor: usize,
    ) -> Option<Allowed> {
        config.shield.as_ref()?;
        let length = wanted.length_mm();
        let heard = Mask::NONE.with(sensor);
        let allowed = self.allow_by(config, enabled, wanted, now, heard);
        // The same way, rounded anew, may be a little shorter.
        let shorter = length.saturating_sub(allowed.distance_mm);
        (shorter > ROUNDING_MM).then_some(allowed)
    }

    /// Distance along the way until something heard comes within the margin, at most `limit`.
    fn free_distance(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
        path: &StraightPath<'_>,
        limit: i32,
        among: Mask,
    ) -> i32 {
        // A robot that stands meets nothing.
        if path.direction == Direction::default() {
            return limit;
        }
        if !enabled.and(among).covers(SENSORS) {
            return self.free_by_some(config, enabled, path, limit, among);
        }
        let mut axes = config.robot.directions.iter().enumerate();
        if axes.any(|(sensor, axis)| self.is_stale(path, sensor, *axis)) {
            return 0;
        }
        path.until_any(self.arcs.as_flattened().iter(), limit)
    }

    /// The same for some of the transducers. Apart, so that it costs nothing for all of them.
    #[inline(never)]
    fn free_by_some(
        &self,
        config: &Config<SENSORS>,
        enabled: Mask,
        path: &StraightPath<'_>,
        limit: i32,
        among: Mask,
    ) -> i32 {
        if among == Mask::ALL && path.is_blind(config, enabled) {
            return 0;
        }
        let asked = enabled.and(among);
        let axis = |sensor: usize| config.robot.directions.get(sensor);
        let is_stale =
            |sensor: usize| axis(sensor).is_some_and(|axis| self.is_stale(path, sensor, *axis));
        if asked.indices(SENSORS).any(is_stale) {
            return 0;
        }
        let arcs = self.arcs.as_flattened().iter();
        let arcs = arcs.zip(self.heard_by.as_flattened());
        let theirs = arcs.filter(|(_, by)| asked.contains(usize::from(**by)));
        path.until_any(theirs.map(|(arc, _)| arc), limit)
    }

    /// Whether the transducer looks where the robot would go and was not heard lately.
    fn is_stale(&self, path: &StraightPath<'_>, sensor: usize, axis: Direction) -> bool {
        path.is_covered_by(axis)
            && self
                .since_heard(sensor, path.now)
                .is_none_or(|ms| ms > path.limits.fresh_ms)
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
