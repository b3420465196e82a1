//! A memory of places: where the robot was, and where it can go from there (the paper's §5.2).
//!
//! A record stands for the ground around a position. Records are linked where the robot went, where
//! they are near, or where its body would fit between them. A goal becomes a chain of sub-goals:
//! [`Places::lead`] spreads the length of the way from the goal over the links, and the next
//! sub-goal is the record in sight from which the whole way is shortest. A free way whose end no
//! record covers is a *frontier*: it counts as a way to the goal as well, so that what is not known
//! yet is searched for (Yamauchi 1997, *A frontier-based approach for autonomous exploration*).
//!
//! Positions come from odometry, corrected by what is perceived at known places, in the frame of
//! the start: ±32 m.

use crate::goal::Goal;
use crate::memory::SituationBytes;
use crate::points::PointMemory;
use crate::units::Displacement;

mod graph;
mod locate;
mod recall;
mod recent;
mod record;
mod sub_goal;
mod wavefront;

use graph::Graph;
use recall::{Sought, compared};
use recent::Recent;
use wavefront::Wavefront;

/// What places are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlaceLimits {
    /// A place is new where no other is nearer, millimeters.
    pub spacing_mm: u16,
    /// Nearer places are linked whatever stands between them, millimeters.
    pub near_mm: u16,
    /// Radius of the body and the room it keeps, millimeters.
    pub radius_mm: u16,
    /// What a frontier costs more than a way that is known, once the goal is known, beside twice
    /// its distance to the goal, millimeters.
    pub frontier_mm: u16,
}

impl PlaceLimits {
    /// For a body of the Nomad's size, in rooms.
    pub const NOMAD: Self = Self {
        spacing_mm: 350,
        near_mm: 450,
        radius_mm: 290,
        frontier_mm: 1_000,
    };

    /// For a body of this radius.
    #[must_use]
    pub const fn of_body(radius_mm: u16) -> Self {
        Self {
            radius_mm: radius_mm.saturating_add(20),
            ..Self::NOMAD
        }
    }
}

/// Where the robot is to be led.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// To a position in the frame of the start.
    Position(Displacement),
    /// To where it has not been.
    Frontier,
    /// To where the situation that it pursues was perceived or may be.
    Situation,
}

/// The way to the next place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leg {
    /// From where the robot is.
    pub way: Displacement,
    /// Room that the way leaves beside the body, millimeters.
    pub room_mm: u16,
    /// It ends where the robot is to be led.
    pub is_last: bool,
}

impl Leg {
    /// The end of a way.
    pub(crate) const HERE: Self = Self {
        is_last: true,
        ..Self::ZERO
    };
    /// All zeros, for a robot that is not led.
    pub(crate) const ZERO: Self = Self {
        way: Displacement::ZERO,
        room_mm: 0,
        is_last: false,
    };
}

/// A sub-goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Target {
    position: Displacement,
    /// The place that it is; [`NOWHERE`] for the end of an open way and for the goal.
    record: u16,
    /// For so many decisions it stays the sub-goal.
    left: u8,
}

/// A way that the robot has not gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Frontier {
    record: u16,
    way: u8,
}

/// A robot keeps as much room as its way leaves, millimeters.
const ROOMS_MM: [u16; 4] = [400, 250, 150, 75];
/// No place.
const NOWHERE: u16 = u16::MAX;

/// Places, at most `RECORDS` of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Places<const SECTORS: usize, const RECORDS: usize> {
    graph: Graph<SECTORS, RECORDS>,
    /// Where the robot is, from the start.
    here: Displacement,
    /// The record of where it is.
    current: Option<u16>,
    /// The frontier that it is led to, and decisions since.
    frontier: Option<Frontier>,
    frontier_age: u8,
    target: Option<Target>,
    /// Where the situation that it seeks was found.
    found: Option<Displacement>,
    recent: Recent,
    wavefront: Wavefront<RECORDS>,
}

impl<const SECTORS: usize, const RECORDS: usize> Default for Places<SECTORS, RECORDS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// None yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            graph: Graph::NEW,
            here: Displacement::ZERO,
            current: None,
            frontier: None,
            frontier_age: 0,
            target: None,
            found: None,
            recent: Recent::NEW,
            wavefront: Wavefront::NEW,
        }
    }

    /// Forgets all, and starts anew from here; in place.
    pub fn forget(&mut self) {
        self.graph.forget();
        (self.here, self.current) = (Displacement::ZERO, None);
        (self.frontier, self.frontier_age) = (None, 0);
        (self.target, self.found, self.recent) = (None, None, Recent::NEW);
    }

    /// From now on something else is sought.
    pub fn seek_anew(&mut self) {
        self.graph.search_anew();
        (self.frontier, self.frontier_age) = (None, 0);
        (self.target, self.found) = (None, None);
    }

    /// Where the robot is, from the start.
    #[must_use]
    pub const fn here(&self) -> Displacement {
        self.here
    }

    /// Positions of the places, in the order in which they were found.
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Displacement> {
        self.graph.records().iter().map(|record| record.at)
    }

    /// The robot has moved, in the frame of the start.
    pub fn moved(&mut self, moved: Displacement) {
        self.here = self.here.plus(moved);
    }

    /// Takes what the robot, which stands, has around it, and what it perceives in the frame of
    /// the start.
    pub fn perceive<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        view: SituationBytes<SECTORS>,
    ) {
        if let Some(merged) = self.graph.thin_out(limits) {
            self.current = self.current.map(|place| merged.renumbered(place));
            // What they were to lead to is looked for anew.
            (self.frontier, self.target) = (None, None);
        }
        let Some(index) = self.graph.place_at(limits, self.here, &view) else {
            return;
        };
        self.graph
            .look_around(limits, points, index, self.here, &view);
        if let Some(before) = self.current.filter(|before| *before != index) {
            self.graph.went(before, index);
        }
        self.current = Some(index);
    }

    /// The situation that it seeks is found here, or sought here in vain.
    pub fn searched(&mut self, is_found: bool) {
        if let Some(current) = self.current {
            self.graph.searched(current, is_found);
        }
    }

    /// The next sub-goal on the way; `None` where there is none: nothing is known yet, everything
    /// has been visited, or the robot is where the situation may be found. `goal` is the situation
    /// that [`Aim::Situation`] means.
    pub fn lead<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        aim: Aim,
        goal: &Goal<SECTORS>,
    ) -> Option<Leg> {
        let compared = compared(goal);
        let sought = match aim {
            Aim::Position(position) => Sought::Position(position),
            Aim::Frontier => Sought::Nothing,
            Aim::Situation => Sought::Situation(&compared),
        };
        let way = self.next_way(limits, points, sought)?;
        let fits = |room_mm: &u16| {
            let radius_mm = limits.radius_mm.saturating_add(*room_mm);
            points.free_mm(way, radius_mm) >= way.length_mm()
        };
        let room_mm = ROOMS_MM.into_iter().find(fits).unwrap_or(0);
        let is_last = aim == Aim::Position(self.here.plus(way));
        Some(Leg {
            way,
            room_mm,
            is_last,
        })
    }
}

#[cfg(test)]
mod tests;
