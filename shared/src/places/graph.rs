//! Places and the links between them.

use super::PlaceLimits;
use super::record::{FreeWays, Record, WAYS};
use crate::points::PointMemory;
use crate::units::Displacement;
use heapless::Vec;

/// The longest link, millimeters.
pub(super) const LONGEST_LINK_MM: u16 = 1_200;
/// Free ways are measured where the robot is so near to a place, millimeters.
const AT_PLACE_MM: u32 = 160;
/// Links that have proved blocked, at most: the oldest goes.
const BLOCKED: usize = 32;

/// Places and links; a place is told by its number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Graph<const RECORDS: usize> {
    records: Vec<Record, RECORDS>,
    blocked: Vec<(u16, u16), BLOCKED>,
}

impl<const RECORDS: usize> Graph<RECORDS> {
    pub(super) const NEW: Self = Self {
        records: Vec::new(),
        blocked: Vec::new(),
    };

    pub(super) fn forget(&mut self) {
        self.records.clear();
        self.blocked.clear();
    }

    pub(super) fn records(&self) -> &[Record] {
        &self.records
    }

    /// All places with their numbers.
    pub(super) fn numbered(&self) -> impl Iterator<Item = (u16, &Record)> {
        (0_u16..).zip(&self.records)
    }

    pub(super) fn get(&self, index: u16) -> Option<&Record> {
        self.records.get(usize::from(index))
    }

    fn get_mut(&mut self, index: u16) -> Option<&mut Record> {
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
    pub(super) fn place_at(&mut self, limits: &PlaceLimits, position: Displacement) -> Option<u16> {
        let nearest = self.nearest(position);
        let is_known = nearest.is_some_and(|(_, distance_mm)| distance_mm < limits.spacing_mm);
        if is_known || self.records.push(Record::at(position)).is_err() {
            return nearest.map(|(index, _)| index);
        }
        for record in &mut self.records {
            record.close_frontiers(position, limits.spacing_mm);
        }
        Some(self.records.len() as u16 - 1)
    }

    /// Measures the free ways around a place, if the robot is there.
    pub(super) fn look_around<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        index: u16,
        here: Displacement,
    ) {
        let Some(record) = self.get_mut(index) else {
            return;
        };
        let offset = record.at.minus(here);
        if offset.is_shorter_than(AT_PLACE_MM) {
            record.free = FreeWays::around(points, offset, limits.radius_mm);
            self.find_frontiers(limits, index);
        }
    }

    /// Marks the free ways of a place whose ends no place covers.
    fn find_frontiers(&mut self, limits: &PlaceLimits, index: u16) {
        let Some(record) = self.get(index) else {
            return;
        };
        let mut open = 0_u32;
        for way in (0..WAYS).filter(|way| record.may_open(*way, limits.spacing_mm)) {
            let end = record.end_of(way);
            let covers = |other: &Record| other.distance_mm(end) < limits.spacing_mm;
            if !self.records.iter().any(covers) {
                open |= 1 << way;
            }
        }
        if let Some(record) = self.get_mut(index) {
            record.open = open;
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
            self.blocked.retain(|pair| *pair != (one, other));
        }
    }

    /// The way from one place to the other does not go.
    pub(super) fn block(&mut self, from: u16, to: u16) {
        for (one, other) in [(from, to), (to, from)] {
            if let Some(record) = self.get_mut(one) {
                record.unlink(other);
            }
            if self.blocked.is_full() {
                self.blocked.remove(0);
            }
            // There is room.
            let _ = self.blocked.push((one, other));
        }
    }

    pub(super) fn is_blocked(&self, from: u16, to: u16) -> bool {
        self.blocked.contains(&(from, to))
    }

    /// Whether the robot may go from one place to the other: it did, they are near, or its body
    /// fits between them as seen from both.
    pub(super) fn is_linked(&self, limits: &PlaceLimits, from: u16, to: u16) -> bool {
        let (Some(one), Some(other)) = (self.get(from), self.get(to)) else {
            return false;
        };
        let way = other.at.minus(one.at);
        let length_mm = way.length_mm();
        if length_mm > LONGEST_LINK_MM || one.was_gone_to(to) {
            return length_mm <= LONGEST_LINK_MM;
        }
        if self.is_blocked(from, to) {
            return false;
        }
        length_mm < limits.near_mm
            || (one.free.reach_mm(way) >= length_mm
                && other.free.reach_mm(one.at.minus(other.at)) + 100 >= length_mm)
    }
}
