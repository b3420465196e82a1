//! Places and the links between them.

use super::PlaceLimits;
use super::ground::Ground;
use super::record::{END_MM, Record};
use crate::memory::SituationBytes;
use crate::units::Displacement;
use heapless::Vec;

/// The longest link, millimeters.
pub(super) const LONGEST_LINK_MM: u16 = 1_200;
/// Free ways are measured where the robot is so near to a place, millimeters.
const AT_PLACE_MM: u32 = 160;
/// Places never have to stand farther apart: an open way has to end outside of its place,
/// millimeters.
const MOST_APART_MM: u16 = END_MM - 50;
/// Places that are looked at while they are thinned out, at a time.
const THINNED: usize = 8;
/// Ways that have proved blocked, at most: the oldest goes.
const BLOCKED: usize = 24;

/// Places and links; a place is told by its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Graph<const SECTORS: usize, const RECORDS: usize> {
    records: Vec<Record<SECTORS>, RECORDS>,
    /// Whether what is sought was sought in vain at a place. Beside the places: in them it would
    /// take a word of each.
    searched: [bool; RECORDS],
    blocked: Vec<Blocked, BLOCKED>,
    /// Places are to be at least so far apart, millimeters; 0 as long as there is room.
    least_mm: u16,
    /// Places before this one are.
    apart: u16,
}

/// A way that does not go, for so many decisions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Blocked {
    ends: (u16, u16),
    left: u16,
}

impl Blocked {
    const fn ends(one: u16, other: u16) -> (u16, u16) {
        if one < other {
            (one, other)
        } else {
            (other, one)
        }
    }
}

/// A place is gone: another stands for it, and the last one has its number now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Merged {
    gone: u16,
    into: u16,
    last: u16,
}

impl Merged {
    /// The number of a place now.
    pub(super) fn renumbered(self, index: u16) -> u16 {
        match index {
            index if index == self.gone => self.into,
            index if index == self.last => self.gone,
            index => index,
        }
    }
}

impl<const SECTORS: usize, const RECORDS: usize> Graph<SECTORS, RECORDS> {
    pub(super) const NEW: Self = Self {
        records: Vec::new(),
        searched: [false; RECORDS],
        blocked: Vec::new(),
        least_mm: 0,
        apart: 0,
    };

    pub(super) fn forget(&mut self) {
        self.records.clear();
        self.blocked.clear();
        (self.least_mm, self.apart) = (0, 0);
    }

    /// A place is new where no other is nearer, millimeters.
    pub(super) fn spacing_mm(&self, limits: &PlaceLimits) -> u16 {
        limits.spacing_mm.max(self.least_mm)
    }

    /// How far places are to stand apart; 0 as long as there is room.
    #[cfg(feature = "store")]
    pub(super) const fn least_mm(&self) -> u16 {
        self.least_mm
    }

    /// Places of an image stood this far apart.
    #[cfg(feature = "store")]
    pub(super) fn keep_apart(&mut self, least_mm: u16) {
        self.least_mm = least_mm.min(MOST_APART_MM);
    }

    /// Adds a place of an image, as long as there is room.
    #[cfg(feature = "store")]
    pub(super) fn restore(&mut self, record: Record<SECTORS>) {
        let _ = self.push(record);
    }

    pub(super) fn is_full(&self) -> bool {
        self.records.is_full()
    }

    /// Forgets the places from this one on.
    pub(super) fn truncate(&mut self, first: u16) {
        self.records.truncate(first.into());
        for record in &mut self.records {
            record.unlink_from(first);
        }
        // The greater number is the second one.
        self.blocked.retain(|way| way.ends.1 < first);
        self.apart = self.apart.min(first);
    }

    /// Without room for another place, places are to stand farther apart from now on. Two places
    /// of a body have no wall between them if they are nearer than its diameter, and an open way
    /// has to end outside of its place.
    fn make_room(&mut self, limits: &PlaceLimits) {
        if usize::from(self.apart) < self.records.len() {
            return;
        }
        let step_mm = limits.spacing_mm / 4;
        let diameter_mm = limits.radius_mm.saturating_mul(2);
        let most_mm = diameter_mm.saturating_sub(step_mm / 2).min(MOST_APART_MM);
        let wider_mm = self.spacing_mm(limits).saturating_add(step_mm).min(most_mm);
        if wider_mm > self.least_mm {
            (self.least_mm, self.apart) = (wider_mm, 0);
        }
    }

    /// Merges one place with another that is too near, if there is one among the next few.
    pub(super) fn thin_out(&mut self) -> Option<Merged> {
        for _ in 0..THINNED {
            let at = self.get(self.apart)?.at;
            let earlier = self.numbered().take(self.apart.into());
            let is_near = |(_, other): &(u16, &Record<SECTORS>)| {
                at.minus(other.at).is_shorter_than(self.least_mm.into())
            };
            let near = earlier.filter(is_near);
            let nearest = near.min_by_key(|(_, other)| other.distance_mm(at));
            match nearest {
                Some((into, _)) => return Some(self.merge(self.apart, into)),
                None => self.apart += 1,
            }
        }
        None
    }

    /// One place stands for another as well.
    fn merge(&mut self, gone: u16, into: u16) -> Merged {
        let merged = Merged {
            gone,
            into,
            last: self.records.len() as u16 - 1,
        };
        let links = self.get(gone).map(Record::links).into_iter().flatten();
        for other in links.filter(|link| *link != into) {
            self.went(other, into);
        }
        if usize::from(gone) < self.records.len() {
            self.records.swap_remove(gone.into());
            self.searched(gone, !self.is_searched(merged.last));
        }
        for record in &mut self.records {
            record.renumber(merged);
        }
        for way in &mut self.blocked {
            let (one, other) = way.ends;
            way.ends = Blocked::ends(merged.renumbered(one), merged.renumbered(other));
        }
        self.blocked.retain(|way| way.ends.0 != way.ends.1);
        merged
    }

    pub(super) fn records(&self) -> &[Record<SECTORS>] {
        &self.records
    }

    /// All places with their numbers.
    pub(super) fn numbered(&self) -> impl Iterator<Item = (u16, &Record<SECTORS>)> {
        (0_u16..).zip(&self.records)
    }

    /// So many places with their numbers, from one on.
    pub(super) fn numbered_from(
        &self,
        first: u16,
        count: u16,
    ) -> impl Iterator<Item = (u16, &Record<SECTORS>)> {
        self.numbered().skip(first.into()).take(count.into())
    }

    pub(super) fn get(&self, index: u16) -> Option<&Record<SECTORS>> {
        self.records.get(usize::from(index))
    }

    fn get_mut(&mut self, index: u16) -> Option<&mut Record<SECTORS>> {
        self.records.get_mut(usize::from(index))
    }

    /// The nearest place and its distance, millimeters.
    pub(super) fn nearest(&self, position: Displacement) -> Option<(u16, u16)> {
        let distances = self
            .numbered()
            .map(|(index, record)| (index, record.distance_mm(position)));
        distances.min_by_key(|(_, distance_mm)| *distance_mm)
    }

    /// The place at a position: a new one where no other is near and there is room.
    pub(super) fn place_at(
        &mut self,
        limits: &PlaceLimits,
        position: Displacement,
        view: &SituationBytes<SECTORS>,
    ) -> Option<u16> {
        let nearest = self.nearest(position);
        let spacing_mm = self.spacing_mm(limits);
        let is_known = nearest.is_some_and(|(_, distance_mm)| distance_mm < spacing_mm);
        if is_known {
            return nearest.map(|(index, _)| index);
        }
        if !self.push(Record::new(position, view)) {
            self.make_room(limits);
            return nearest.map(|(index, _)| index);
        }
        for record in &mut self.records {
            record.close_frontiers(position, spacing_mm);
        }
        Some(self.records.len() as u16 - 1)
    }

    /// A new place, where nothing was sought yet. False if there is no room.
    fn push(&mut self, record: Record<SECTORS>) -> bool {
        self.searched(self.records.len() as u16, true);
        self.records.push(record).is_ok()
    }

    /// What is sought was found at this place, or sought there in vain.
    pub(super) fn searched(&mut self, index: u16, is_found: bool) {
        if let Some(searched) = self.searched.get_mut(usize::from(index)) {
            *searched = !is_found;
        }
    }

    /// Whether what is sought was sought at this place in vain.
    pub(super) fn is_searched(&self, index: u16) -> bool {
        self.searched.get(usize::from(index)) == Some(&true)
    }

    /// What is sought may be anywhere.
    pub(super) fn search_anew(&mut self) {
        self.searched = [false; RECORDS];
    }

    /// Adds what is perceived to a place, if the robot is there; returns whether it is.
    pub(super) fn complete(
        &mut self,
        index: u16,
        here: Displacement,
        view: &SituationBytes<SECTORS>,
    ) -> bool {
        let record = self.get_mut(index);
        let record = record.filter(|record| record.at.minus(here).is_shorter_than(AT_PLACE_MM));
        let is_there = record.is_some();
        if let Some(record) = record {
            record.complete(view);
        }
        is_there
    }

    /// Measures a free way around a place, from a robot that is there.
    pub(super) fn measure<const POINTS: usize>(
        &mut self,
        ground: &Ground<'_, POINTS>,
        index: u16,
        here: Displacement,
        way: usize,
    ) {
        if let Some(record) = self.get_mut(index) {
            let offset = record.at.minus(here);
            record.free.measure(ground, offset, way);
        }
    }

    /// Marks the free ways of a place whose ends no place covers.
    pub(super) fn find_frontiers(&mut self, limits: &PlaceLimits, index: u16) {
        let spacing_mm = self.spacing_mm(limits);
        let Some(record) = self.records.get_mut(usize::from(index)) else {
            return;
        };
        record.open_ways(spacing_mm);
        let mut record = *record;
        for other in &self.records {
            record.close_frontiers(other.at, spacing_mm);
        }
        if let Some(kept) = self.get_mut(index) {
            kept.open = record.open;
        }
    }

    /// A way has been tried and does not go.
    pub(super) fn close_frontier(&mut self, limits: &PlaceLimits, index: u16, way: u8) {
        if let Some(record) = self.get_mut(index) {
            record.tried |= 1 << way;
            self.find_frontiers(limits, index);
        }
    }

    /// The robot has gone from one place to the other.
    pub(super) fn went(&mut self, from: u16, to: u16) {
        for (one, other) in [(from, to), (to, from)] {
            if let Some(record) = self.get_mut(one) {
                record.link(other);
            }
        }
        let ends = Blocked::ends(from, to);
        self.blocked.retain(|way| way.ends != ends);
    }

    /// The way from one place to the other does not go, for so many decisions: what stands in it
    /// may be gone then.
    pub(super) fn block(&mut self, from: u16, to: u16, decisions: u16) {
        let ends = Blocked::ends(from, to);
        self.blocked.retain(|way| way.ends != ends);
        if self.blocked.is_full() {
            self.blocked.remove(0);
        }
        // There is room.
        let _ = self.blocked.push(Blocked {
            ends,
            left: decisions,
        });
    }

    /// Another decision: ways that were blocked for long enough may go again.
    pub(super) fn pass_decision(&mut self) {
        self.blocked.retain_mut(|way| {
            way.left = way.left.saturating_sub(1);
            way.left > 0
        });
    }

    /// Blocked ways, from the place with the lesser number to the other.
    pub(super) fn blocked(&self) -> impl Iterator<Item = (u16, u16)> {
        self.blocked.iter().map(|way| way.ends)
    }

    pub(super) fn is_blocked(&self, from: u16, to: u16) -> bool {
        let ends = Blocked::ends(from, to);
        self.blocked.iter().any(|way| way.ends == ends)
    }

    /// Whether the robot may go from one place to the other: it did, they are near, or its body
    /// fits between them as seen from both.
    pub(super) fn is_linked(&self, limits: &PlaceLimits, from: u16, to: u16) -> bool {
        let (Some(one), Some(other)) = (self.get(from), self.get(to)) else {
            return false;
        };
        let way = other.at.minus(one.at);
        let length_mm = way.length_mm();
        let is_open = || {
            one.was_gone_to(to)
                || length_mm < limits.near_mm
                || (one.free.reach_mm(way) >= length_mm
                    && other.free.reach_mm(one.at.minus(other.at)) + 100 >= length_mm)
        };
        length_mm <= LONGEST_LINK_MM && is_open() && !self.is_blocked(from, to)
    }
}
