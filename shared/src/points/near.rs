//! Points for the shield: a motion ends before any place where an obstacle may stand in a sensor's
//! lobe. Only near points are kept, as many as matter to the next steps.

use super::arc::{Arc, FreeBeam};
use super::{Beam, Point, PointMemory, Ray};
use crate::disc::{until_contact, until_contact_beside};
use crate::units::{Bearing, Displacement};

/// How wide a sensor hears, for echoes that are to end motions in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Lobe {
    /// What returns an echo stands in a cone with half this opening.
    pub(crate) half: Bearing,
    /// A beam shows a cone with half this opening free.
    pub(crate) half_free: Bearing,
    /// What is farther away is not kept, millimeters.
    pub(crate) reach_mm: u32,
    /// Similar points are less than this apart, millimeters.
    pub(crate) similar_mm: u16,
    /// A beam frees nothing so near to its echo, as ranges err, millimeters.
    pub(crate) short_of_echo_mm: u16,
    /// Nor within this part of its range, one in so many.
    pub(crate) short_of_echo_part: u16,
    /// What is heard again may be anywhere in the lobe again.
    pub(crate) doubts_free: bool,
}

impl<const POINTS: usize> PointMemory<POINTS> {
    /// Takes an echo that is to end motions in time. Unlike [`hear`](PointMemory::hear) it keeps
    /// only what is near, for as long as it can: an echo similar to a kept one confirms it, and
    /// where there is no room the farthest goes. One echo alone frees nothing: it may be a stray
    /// one.
    pub(crate) fn hear_near(&mut self, lobe: &Lobe, beam: &Beam) {
        self.hear_near_along(lobe, &self.ray(beam), beam.is_echo);
    }

    /// As [`hear_near`](Self::hear_near), in the frame of the start. A beam without an echo frees
    /// what it sees.
    pub(crate) fn hear_near_along(&mut self, lobe: &Lobe, ray: &Ray, is_echo: bool) {
        // The places stand on the chord of the lobe's arc, which is nowhere farther than the arc.
        let (chord_mm, edge_mm) = lobe.half.direction().times(ray.range_mm);
        let at = ray.at(chord_mm);
        let free = FreeBeam {
            may_be_stray: true,
            ..ray.free(lobe.half_free.direction(), lobe.free_mm(chord_mm))
        };
        self.carve(&free);
        if !is_echo || !at.is_shorter_than(lobe.reach_mm) {
            return;
        }
        let point = Point::new(at, self.traveled_mm, Arc::new(ray.axis, edge_mm / 2));
        let mut others = self.points.iter_mut();
        if let Some(other) = others.find(|other| other.covers(&point, lobe.similar_mm)) {
            if lobe.doubts_free {
                other.arc.confirm();
            }
            return;
        }
        if let Err(point) = self.points.push(point) {
            let points = self.points.iter_mut();
            let farthest = points.max_by_key(|point| point.at.squared_mm2());
            if let Some(farthest) = farthest.filter(|farthest| point.is_nearer(farthest)) {
                *farthest = point;
            }
        }
    }

    /// As [`free_from_mm`](Self::free_from_mm), from here, before it touches any place where what
    /// returned an echo may stand.
    pub(crate) fn free_of_arcs_mm(&self, way: Displacement, radius_mm: u16) -> u16 {
        self.until_any_contact_mm(way, radius_mm, until_contact)
    }

    /// As [`free_of_arcs_mm`](Self::free_of_arcs_mm), for a disc that may go beside what it touches
    /// already, where it comes no nearer than some millimeters.
    pub(crate) fn free_beside_arcs_mm(&self, way: Displacement, radius_mm: u16) -> u16 {
        self.until_any_contact_mm(way, radius_mm, until_contact_beside)
    }

    fn until_any_contact_mm(
        &self,
        way: Displacement,
        radius_mm: u16,
        until: impl Fn((i32, i32), i32, i32) -> i32,
    ) -> u16 {
        let radius_mm = radius_mm.into();
        self.until_contact_mm(way, |point, direction, free| {
            (point.arc).until_contact(point.at, direction, radius_mm, free, &until)
        })
    }
}

impl Lobe {
    /// How far a beam frees its lobe whose chord is as far as this, millimeters.
    fn free_mm(&self, chord_mm: i32) -> i32 {
        let part = i32::from(self.short_of_echo_part.max(1));
        chord_mm - chord_mm / part - i32::from(self.short_of_echo_mm)
    }
}

impl Point {
    /// Whether it is no farther than another and its places are similar to those.
    fn covers(&self, other: &Self, similar_mm: u16) -> bool {
        (self.at.minus(other.at)).is_shorter_than(similar_mm.into())
            && self.arc.is_similar(&other.arc)
            && !other.is_nearer(self)
    }

    fn is_nearer(&self, other: &Self) -> bool {
        self.at.squared_mm2() < other.at.squared_mm2()
    }
}
