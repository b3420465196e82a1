//! The guard ends motions short of anything near that was heard, and learns from contacts how large
//! the body is.
//!
//! It keeps what the body's sensors hear as a [shield](crate::shield) does: wherever in a cone an
//! obstacle may stand, until later beams have seen through. Where it closes a way the robot takes a
//! detour, as phantoms are found out from elsewhere only.

use super::{Actuation, Guard, RingController, Robot, VirtualTurret};
use crate::controller::{Motion, Outputs};
use crate::points::{Beam, Lobe, Ray};
use crate::shield::{Allowed, best_detour, shortest_possible_mm};
use crate::units::{Bearing, Displacement};

/// A motion is not shortened by less, millimeters.
const ROUNDING_MM: u16 = 3;
/// A motion that would be shortened to less is not begun, millimeters.
const LEAST_MM: u16 = 10;
/// Contacts that tell the size of the body.
const CONTACTS: u8 = 3;

/// How large the body is, as its contacts tell: what it touches is as near as its radius, and what
/// is nearest ahead is usually what it touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Hull {
    /// Contacts so far, at most [`CONTACTS`].
    contacts: u8,
    /// Least distance of what was nearest ahead at a contact, millimeters.
    nearest_mm: u16,
}

impl Hull {
    pub(super) const NEW: Self = Self {
        contacts: 0,
        nearest_mm: 0,
    };

    fn touched(&mut self, nearest_mm: u16) {
        self.nearest_mm = match self.contacts {
            0 => nearest_mm,
            _ => self.nearest_mm.min(nearest_mm),
        };
        self.contacts = self.contacts.saturating_add(1).min(CONTACTS);
    }

    /// The body's radius: as it was told, or up to twice that. What it touches unseen may be
    /// anywhere, so the least of several distances counts, and a body that has touched only such
    /// things is still able to move.
    fn radius_mm(self, told_mm: u16) -> u16 {
        if self.contacts < CONTACTS {
            return told_mm;
        }
        self.nearest_mm.min(told_mm.saturating_mul(2)).max(told_mm)
    }
}

impl<const SECTORS: usize, const POINTS: usize, const RECORDS: usize>
    VirtualTurret<SECTORS, POINTS, RECORDS>
{
    /// The body has touched something on its way.
    pub(super) fn touched(&mut self) {
        if let Some(nearest_mm) = self.memory.nearest_mm(self.course) {
            self.hull.touched(nearest_mm);
        }
    }

    /// Turns a motion from the frame of the start into the one that the base is to be told.
    pub(super) fn to_base(&self, actuation: &Actuation, motion: Motion) -> Motion {
        let back = self.memory.heading().direction().mirrored();
        Motion {
            displacement: actuation.command(motion.displacement.rotated(back)),
            ..motion
        }
    }

    /// What is left of a motion. A base that rolls goes straight on: a few millimeters aside would
    /// have it stop and turn, and what it has overrun, go back.
    fn rest_of(&self, motion: Motion) -> Displacement {
        let Displacement { dx_mm, dy_mm } = motion.displacement;
        if !self.is_rolling {
            return motion.displacement;
        }
        let ahead_mm = self.course.direction().along(dx_mm.into(), dy_mm.into());
        Displacement::along(self.course, ahead_mm.max(0))
    }
}

impl<C, const SECTORS: usize, const BEAMS: usize, const POINTS: usize, const RECORDS: usize>
    Robot<'_, C, SECTORS, BEAMS, POINTS, RECORDS>
where
    C: RingController<SECTORS>,
{
    /// Radius of the disc that motions keep free: the body and the guard's margin, millimeters.
    pub(super) fn kept_free_mm(&self) -> u16 {
        let body_mm = self.turret.hull.radius_mm(self.config.robot.body_radius_mm);
        let margin_mm = self.body.guard.map_or(0, |guard| guard.margin_mm.get());
        body_mm.saturating_add(margin_mm)
    }

    /// Keeps a reading for the guard: an echo, or how far a sensor sees free space.
    pub(super) fn hear_near(&mut self, ray: &Ray, beam: &Beam) {
        let Some(guard) = self.body.guard else {
            return;
        };
        let lobe = self.lobe(&guard);
        let shield = self.controller.shield();
        // After the start, and when it was set down elsewhere.
        if self.turret.memory.is_empty() {
            shield.forget();
        }
        let margin_mm = guard.margin_mm.get();
        let range_mm = shortest_possible_mm(beam.range.as_mm(), guard.least_range_mm, margin_mm);
        shield.hear_along(&lobe, &ray.with_range(range_mm), beam.is_echo);
    }

    /// A sonar heard nothing along `ray`. For robots that look for a position: elsewhere echoes
    /// that go astray on smooth walls free too much.
    pub(super) fn hear_nothing(&mut self, ray: &Ray) {
        (self.turret.memory).hear_nothing(self.body.points.half_cone, ray, false);
        if let Some(guard) = self.body.guard {
            let half = self.lobe(&guard).half_free;
            self.controller.shield().hear_nothing(half, ray);
        }
    }

    /// What the body may meet on its next steps stands in the sensors' cones.
    fn lobe(&self, guard: &Guard) -> Lobe {
        let robot = &self.config.robot;
        let half = self.body.points.half_cone.as_turns();
        Lobe {
            half: Bearing::from_turns(half),
            // As far as to a quarter of the way to the next of the five places. The margin covers
            // what stands farther, up to 27 mm at 1 m.
            half_free: Bearing::from_turns(half - half / 8),
            reach_mm: 3 * u32::from(robot.step_mm)
                + u32::from(robot.body_radius_mm)
                + u32::from(guard.margin_mm.get()),
            similar_mm: self.body.points.short_of_echo_mm.saturating_mul(2),
            // Two deviations: what a beam frees wrongly its own echo closes.
            short_of_echo_mm: self.body.points.short_of_echo_mm,
            short_of_echo_part: 64,
            doubts_free: false,
        }
    }

    /// As much of a way as the guard allows.
    pub(super) fn guarded(&mut self, way: Displacement) -> Displacement {
        if self.body.guard.is_none() {
            return way;
        }
        let radius_mm = self.kept_free_mm();
        let free_mm = self.controller.shield().free_mm(way, radius_mm);
        if free_mm >= way.length_mm() {
            way
        } else if free_mm < LEAST_MM {
            Displacement::ZERO
        } else {
            way.with_length(free_mm)
        }
    }

    /// As much of a way as the guard allows, or of a detour where that is little. Random moves take
    /// none.
    pub(super) fn guarded_or_detour(&mut self, wanted: Displacement) -> Displacement {
        if self.body.guard.is_none() || !self.controller.pursues_goal() {
            return self.guarded(wanted);
        }
        let speed_mm_s = self.config.robot.speed_mm_s;
        let closed = self.turret.closed;
        let (way, allowed) = best_detour(wanted, closed, |way| Allowed {
            distance_mm: self.guarded(way).length_mm(),
            speed_mm_s,
        });
        let is_closed = allowed.distance_mm == 0;
        self.turret.closed = if is_closed { closed.wrapping_add(1) } else { 0 };
        self.guarded(way)
    }

    /// Orders what is left of the motion under way if the guard now allows less than was ordered.
    pub(super) fn shorten(&mut self) -> Outputs<SECTORS> {
        let Some(under_way) = self.turret.motion else {
            return Outputs::NONE;
        };
        let rest = self.turret.rest_of(under_way);
        let displacement = self.guarded(rest);
        // Without an obstacle the order stands, whatever course the base takes. A way that is over
        // by the odometry ends now.
        if displacement == rest && rest != Displacement::ZERO {
            return Outputs::NONE;
        }
        let (ordered_mm, left_mm) = (under_way.displacement.length_mm(), displacement.length_mm());
        if ordered_mm.saturating_sub(left_mm) <= ROUNDING_MM {
            return Outputs::NONE;
        }
        let motion = Motion {
            displacement,
            ..under_way
        };
        self.turret.motion = Some(motion);
        Outputs {
            motion: Some(self.turret.to_base(&self.body.actuation, motion)),
            ..Outputs::NONE
        }
    }
}

#[cfg(test)]
mod tests;
