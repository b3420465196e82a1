//! The guard ends motions short of any point, and learns from contacts how large the body is.

use super::{RingController, Robot, VirtualTurret};
use crate::controller::{Motion, Outputs};
use crate::units::Displacement;

/// A motion is not shortened by less, millimeters.
const ROUNDING_MM: u16 = 3;
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
        body_mm.saturating_add(self.body.guard_mm.unwrap_or(0))
    }

    /// As much of a way as the guard allows.
    pub(super) fn guarded(&self, way: Displacement) -> Displacement {
        if self.body.guard_mm.is_none() {
            return way;
        }
        let free_mm = self.turret.memory.free_mm(way, self.kept_free_mm());
        if free_mm < way.length_mm() {
            way.with_length(free_mm)
        } else {
            way
        }
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
mod tests {
    use super::*;

    #[test]
    fn the_least_of_three_distances_at_contacts_is_the_radius_within_limits() {
        let radii = |distances_mm: &[u16], told_mm| {
            let mut hull = Hull::NEW;
            for distance_mm in distances_mm {
                hull.touched(*distance_mm);
            }
            hull.radius_mm(told_mm)
        };
        assert_eq!(radii(&[], 200), 200);
        assert_eq!(radii(&[260, 255], 200), 200, "two are not enough");
        assert_eq!(radii(&[260, 255, 290], 200), 255);
        assert_eq!(radii(&[260, 255, 290, 250], 200), 250);
        assert_eq!(radii(&[150, 255, 290], 200), 200, "as it was told");
        assert_eq!(radii(&[260; 300], 200), 260);
        assert_eq!(radii(&[900, 1_200, 3_000], 200), 400, "things unseen");
    }
}
