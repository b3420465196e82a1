//! How far the body may go before it touches what returned an echo.

use super::{Point, PointMemory};
use crate::disc::{direction_of, until_contact};
use crate::units::{Bearing, Direction, Displacement};

impl<const POINTS: usize> PointMemory<POINTS> {
    /// Distance of the nearest point ahead, from the center, millimeters; `way` is in the frame of
    /// the start.
    #[must_use]
    pub fn nearest_mm(&self, way: Bearing) -> Option<u16> {
        let way = way.direction();
        let things = self.points.iter().filter(|point| point.is_echo());
        let ahead = things.filter(|point| {
            let Displacement { dx_mm, dy_mm } = point.at;
            way.along(dx_mm.into(), dy_mm.into()) > 0
        });
        ahead.map(|point| point.at.length_mm()).min()
    }

    /// How far a disc of `radius_mm` may go along `way`, in the frame of the start, from a position
    /// beside the robot before it touches a point; at most the way's length. Millimeters.
    #[must_use]
    pub fn free_from_mm(&self, from: Displacement, way: Displacement, radius_mm: u16) -> u16 {
        let radius_mm = radius_mm.into();
        self.until_contact_mm(way, |point, direction, free| {
            let Displacement { dx_mm, dy_mm } = point.at.minus(from);
            let place = direction.components(dx_mm.into(), dy_mm.into());
            until_contact(place, radius_mm, free)
        })
    }

    /// As [`free_from_mm`](Self::free_from_mm), where echoes came from as far as beams have told
    /// since: a beam that saw past a thing frees what is beside it.
    pub(crate) fn likely_free_mm(
        &self,
        from: Displacement,
        way: Displacement,
        radius_mm: u16,
    ) -> u16 {
        let radius_mm = radius_mm.into();
        self.until_contact_mm(way, |point, direction, free| {
            let axis = point.at.minus(from);
            (point.arc).until_likely_contact(axis, direction, radius_mm, free)
        })
    }

    /// The least of the ways until each point that returned an echo; each is given the least before
    /// it.
    pub(super) fn until_contact_mm(
        &self,
        way: Displacement,
        until: impl Fn(&Point, Direction, i32) -> i32,
    ) -> u16 {
        let length = way.length_mm();
        let direction = direction_of(way, length.into());
        let things = self.points.iter().filter(|point| point.is_echo());
        let free = things.fold(i32::from(length), |free, point| {
            until(point, direction, free)
        });
        free as u16
    }
}
