//! A place, and the free ways around it.

use super::NOWHERE;
use super::graph::Merged;
use super::ground::Ground;
#[cfg(feature = "store")]
use super::saved::{Item, item_of};
use crate::memory::{self, SituationBytes};
#[cfg(feature = "store")]
use crate::store::RecordFields;
use crate::units::{Bearing, Displacement};

/// Directions in which free ways are noted, evenly spaced, counter-clockwise from the frame's x
/// axis.
pub(super) const WAYS: usize = 32;
/// Free ways are kept in units of so many millimeters, up to 15 of them.
const UNIT_MM: u16 = 100;
const MOST_MM: u16 = 15 * UNIT_MM;
/// What lies at the end of a free way is looked for at most this far away, millimeters.
pub(super) const END_MM: u16 = 600;
/// Places that the robot went to from here: the oldest goes.
const LINKS: usize = 6;
/// Bytes of a place when it is saved, without the view.
#[cfg(feature = "store")]
pub(super) const BYTES_BESIDE_VIEW: usize = 4 + WAYS / 2 + 4 + 4 + 2 * LINKS;

/// A place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Record<const SECTORS: usize> {
    /// From the start.
    pub(super) at: Displacement,
    pub(super) free: FreeWays,
    /// Ways whose ends no record covers, a bit for each.
    pub(super) open: u32,
    /// Ways that did not go.
    pub(super) tried: u32,
    links: [u16; LINKS],
    /// What was perceived here at first, and of sectors that were not, later.
    pub(super) view: SituationBytes<SECTORS>,
}

impl<const SECTORS: usize> Record<SECTORS> {
    /// A place where this is perceived, and of which nothing else is known.
    pub(super) const fn new(at: Displacement, view: &SituationBytes<SECTORS>) -> Self {
        Self {
            at,
            free: FreeWays::NONE,
            open: 0,
            tried: 0,
            links: [NOWHERE; LINKS],
            view: *view,
        }
    }

    /// As bytes.
    #[cfg(feature = "store")]
    pub(super) fn item(&self) -> Item {
        item_of(&[
            &self.at.dx_mm.to_le_bytes(),
            &self.at.dy_mm.to_le_bytes(),
            &self.free.0,
            &self.open.to_le_bytes(),
            &self.tried.to_le_bytes(),
            self.links.map(u16::to_le_bytes).as_flattened(),
            &self.view,
        ])
    }

    /// Undoes [`item`](Self::item); `None` for too few bytes.
    #[cfg(feature = "store")]
    pub(super) fn from_item(mut fields: RecordFields<'_>) -> Option<Self> {
        let at = Displacement {
            dx_mm: i16::from_le_bytes(fields.take()?),
            dy_mm: i16::from_le_bytes(fields.take()?),
        };
        let mut record = Self::new(at, &[memory::UNKNOWN; SECTORS]);
        record.free = FreeWays(fields.take()?);
        record.open = u32::from_le_bytes(fields.take()?);
        record.tried = u32::from_le_bytes(fields.take()?);
        for link in &mut record.links {
            *link = u16::from_le_bytes(fields.take()?);
        }
        record.view = fields.take()?;
        Some(record)
    }

    /// The robot is here again: adds what was not perceived yet. The rest stays as it was: by it
    /// the robot finds where it is.
    pub(super) fn complete(&mut self, view: &SituationBytes<SECTORS>) {
        for (kept, now) in self.view.iter_mut().zip(view) {
            if *kept == memory::UNKNOWN {
                *kept = *now;
            }
        }
    }

    pub(super) fn distance_mm(&self, position: Displacement) -> u16 {
        position.minus(self.at).length_mm()
    }

    /// Where a free way ends, or is far enough to be explored.
    pub(super) fn end_of(&self, way: usize) -> Displacement {
        let length_mm = self.free.length_mm(way).min(END_MM);
        self.at.plus(Displacement::along(
            Bearing::of_place(way, WAYS),
            length_mm.into(),
        ))
    }

    /// Ways that have not been tried and are long enough to end outside of this place are open.
    pub(super) fn open_ways(&mut self, spacing_mm: u16) {
        let is_open = |way: &usize| {
            self.tried & (1 << way) == 0
                && self.free.length_mm(*way) >= spacing_mm.saturating_add(50)
        };
        let ways = (0..WAYS).filter(is_open);
        self.open = ways.fold(0, |open, way| open | 1 << way);
    }

    /// The middle one of each run of open ways.
    pub(super) fn frontiers(&self) -> impl Iterator<Item = u8> + use<SECTORS> {
        let open = self.open;
        let begins = open & !open.rotate_left(1);
        let runs = (0..WAYS as u32).filter(move |way| begins & (1 << way) != 0);
        let middles = runs.map(move |way| {
            let length = open.rotate_right(way).trailing_ones();
            ((way + length / 2) % WAYS as u32) as u8
        });
        // Open all around: no run begins.
        middles.chain((open == u32::MAX).then_some(0))
    }

    /// The open way nearest to a bearing; of two as near the one to the left.
    pub(super) fn open_toward(&self, bearing: Bearing) -> Option<u8> {
        let nearest = way_along(bearing);
        // Ways to the left of the nearest one count from the lowest bit, those to the right from
        // the highest.
        let open = self.open.rotate_right(nearest as u32);
        let (left, right) = (
            open.trailing_zeros() as usize,
            open.leading_zeros() as usize + 1,
        );
        let way = if left <= right {
            nearest + left
        } else {
            nearest + WAYS - right
        };
        (open != 0).then_some((way % WAYS) as u8)
    }

    /// A place covers the ends of these ways.
    pub(super) fn close_frontiers(&mut self, position: Displacement, spacing_mm: u16) {
        // Most places are far from these ends, which are as far as that to within rounding.
        let reach_mm = u32::from(END_MM) + u32::from(spacing_mm) + 10;
        if !position.minus(self.at).is_shorter_than(reach_mm) {
            return;
        }
        let open = self.open;
        for way in (0..WAYS).filter(|way| open & (1 << way) != 0) {
            let end = self.end_of(way);
            if position.minus(end).is_shorter_than(spacing_mm.into()) {
                self.open &= !(1 << way);
            }
        }
    }

    /// The robot went there from here.
    pub(super) fn link(&mut self, to: u16) {
        if !self.was_gone_to(to) {
            self.links.rotate_right(1);
            if let Some(newest) = self.links.first_mut() {
                *newest = to;
            }
        }
    }

    /// Places that the robot went to from here.
    pub(super) fn links(&self) -> impl Iterator<Item = u16> + use<SECTORS> {
        self.links.into_iter().filter(|link| *link != NOWHERE)
    }

    /// Two places have become one.
    pub(super) fn renumber(&mut self, merged: Merged) {
        for link in self.links.iter_mut().filter(|link| **link != NOWHERE) {
            *link = merged.renumbered(*link);
        }
    }

    /// The places from this one on are gone.
    pub(super) fn unlink_from(&mut self, first: u16) {
        for link in self.links.iter_mut().filter(|link| **link >= first) {
            *link = NOWHERE;
        }
    }

    pub(super) fn was_gone_to(&self, to: u16) -> bool {
        self.links.contains(&to)
    }
}

/// How far the body may go in each direction, four bits each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FreeWays([u8; WAYS / 2]);

impl FreeWays {
    const NONE: Self = Self([0; WAYS / 2]);

    /// Measures one of the ways from a position beside the robot.
    pub(super) fn measure<const POINTS: usize>(
        &mut self,
        ground: &Ground<'_, POINTS>,
        from: Displacement,
        way: usize,
    ) {
        let along = Displacement::along(Bearing::of_place(way, WAYS), MOST_MM.into());
        let units = (ground.free_mm(from, along) / UNIT_MM).min(15) as u8;
        if let Some(pair) = self.0.get_mut(way / 2) {
            *pair = if way.is_multiple_of(2) {
                *pair & 0xF0 | units
            } else {
                *pair & 0x0F | units << 4
            };
        }
    }

    pub(super) fn length_mm(&self, way: usize) -> u16 {
        let pair = self.0.get(way / 2).copied().unwrap_or(0);
        let units = if way.is_multiple_of(2) {
            pair & 15
        } else {
            pair >> 4
        };
        u16::from(units) * UNIT_MM
    }

    /// How far the body may go about along this way.
    pub(super) fn reach_mm(&self, way: Displacement) -> u16 {
        self.length_mm(way_along(way.bearing()))
    }
}

/// The way nearest to a bearing.
fn way_along(bearing: Bearing) -> usize {
    let steps = bearing.as_turns().wrapping_add(1 << 10) >> 11;
    usize::from(steps) % WAYS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_hundred_fifty_six_places_take_14_kib() {
        assert_eq!(size_of::<Record<16>>(), 56);
    }

    #[test]
    fn the_middle_of_each_run_of_open_ways_is_a_frontier() {
        let frontiers = |open: u32| {
            let record = Record {
                open,
                ..Record::<16>::new(Displacement::ZERO, &[0; 16])
            };
            std::vec::Vec::from_iter(record.frontiers())
        };
        assert_eq!(frontiers(0), [0_u8; 0]);
        assert_eq!(frontiers(0b0111_1100), [4]);
        assert_eq!(frontiers(0b1_0000_0111), [1, 8]);
        // A run that goes on past way 31.
        assert_eq!(frontiers(0xC000_0007), [0]);
        assert_eq!(frontiers(u32::MAX), [0]);
    }

    #[test]
    fn the_open_way_nearest_to_a_bearing_leads_toward_it() {
        let toward = |open: u32, way: usize| {
            let record = Record {
                open,
                ..Record::<16>::new(Displacement::ZERO, &[0; 16])
            };
            record.open_toward(Bearing::of_place(way, WAYS))
        };
        assert_eq!(toward(0, 5), None);
        assert_eq!(toward(1 << 5, 5), Some(5));
        assert_eq!(toward(1 << 5, 21), Some(5));
        let two = 1 << 3 | 1 << 30;
        assert_eq!(
            [1, 0, 31, 16, 17].map(|way| toward(two, way)),
            [3, 30, 30, 3, 30].map(Some)
        );
        assert_eq!(toward(1 << 2 | 1 << 6, 4), Some(6), "as near: to the left");
        assert_eq!(toward(u32::MAX, 17), Some(17));
    }
}
