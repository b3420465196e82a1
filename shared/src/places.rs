//! A memory of places: where the robot was, and where it can go from there (the paper's §5.2).
//!
//! A record stands for the ground around a position. Records are linked where the robot went, where
//! they are near, or where its body would fit between them. A goal becomes a chain of sub-goals:
//! [`Places::think`] spreads the length of the way from the goal over the links, and the next
//! sub-goal is the record in sight from which the whole way is shortest. A free way whose end no
//! record covers is a *frontier*: it counts as a way to the goal as well, so that what is not known
//! yet is searched for (Yamauchi 1997, *A frontier-based approach for autonomous exploration*).
//!
//! Positions come from odometry, corrected by what is perceived at known places, in the frame of
//! the start: ±32 m. A heading that drifts is corrected by the directions of walls.
//!
//! [`Places::begin`] begins to think and [`Places::think`] does a part of it: on a chip events are
//! handled in between.

use crate::memory::SituationBytes;
use crate::points::WallDirections;
use crate::scan::Encoding;
use crate::units::{Bearing, Displacement};
use serde::{Deserialize, Serialize};

mod compass;
mod follow;
mod graph;
mod ground;
mod guess;
mod locate;
mod lost;
mod recall;
mod recent;
mod record;
mod relocate;
#[cfg(feature = "store")]
mod saved;
mod stage;
mod sub_goal;
mod wavefront;

use compass::Compass;
use graph::Graph;
pub use lost::BELIEVED;
use lost::Lost;
use recent::Recent;
use relocate::BestPosition;
pub use stage::SLICE;
use stage::Stage;
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Aim {
    /// To a position in the frame of the start.
    Position(Displacement),
    /// To where it has not been.
    Frontier,
    /// To where it has not been; when nothing is left it looks more closely, and goes where its way
    /// is narrow or short.
    Everywhere,
    /// To where the situation that it pursues was perceived or may be.
    Situation,
}

/// What a robot does at a decision, beside perceiving where it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// It is not led.
    Perceive,
    /// It pursues the situation by itself, which is not here.
    Search,
    /// It has found the situation.
    Stay,
    /// It is led.
    Lead(Aim),
}

/// The way to the next place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leg {
    /// From where the robot is.
    pub way: Displacement,
    /// Room that the way leaves beside the body, millimeters.
    pub room_mm: u16,
    /// It leads to where the robot has not been, on the way to a position.
    pub is_new: bool,
    /// The moves that the maps chose have not led on: the robot goes straight.
    pub is_straight: bool,
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
        is_new: false,
        is_straight: false,
        is_last: false,
    };

    /// How far the robot goes at once: what the maps chose, but not past the end. Where a new way
    /// leaves room and their move goes along it, it goes straight on, two and a half steps: there
    /// are no places yet by which it would correct its position. Where their moves did not lead on
    /// it goes straight as well.
    pub(crate) fn stride(self, chosen: Displacement, step_mm: u16) -> Displacement {
        let aside = self.way.bearing().minus(chosen.bearing()).as_signed_turns();
        let is_along = chosen != Displacement::ZERO && aside.unsigned_abs() <= ALONG;
        if self.is_new && self.room_mm > 0 && is_along {
            self.way.shortened(step_mm.saturating_mul(5) / 2)
        } else if self.is_straight {
            self.way.shortened(step_mm)
        } else {
            chosen.shortened(self.way.length_mm())
        }
    }
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
/// A move goes along a way within this angle: 45°.
const ALONG: u16 = 1 << 13;
/// A place is new where no other is nearer while the robot looks for a position, millimeters.
const CLOSE_MM: u16 = 250;
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
    /// It goes to the sub-goal straight, if it has one.
    is_straight: bool,
    /// Nothing was left where it had not been: it looks more closely.
    looks_closely: bool,
    /// No place in sight leads to the goal, although it is known: narrow ways count as well.
    is_cut_off: bool,
    /// Places before this one have been looked at for shorter open ways.
    reopened: u16,
    /// Where the situation that it seeks was found.
    found: Option<Displacement>,
    recent: Recent,
    wavefront: Wavefront<RECORDS>,
    /// What it thinks about: what it perceives here, and what for; all zeros at first.
    view: SituationBytes<SECTORS>,
    encoding: Encoding,
    purpose: Purpose,
    stage: Stage,
    /// Its heading does not drift.
    has_compass: bool,
    compass: Compass,
    /// Walls heard here.
    walls: WallDirections,
    /// Since the compass heard walls.
    traveled_mm: u16,
    /// Since the position was corrected.
    unlocated_mm: u16,
    /// What the heading is to be corrected by.
    turn: Bearing,
    best: BestPosition,
    lost: Lost,
    /// What it has found.
    leg: Leg,
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
            is_straight: false,
            looks_closely: false,
            is_cut_off: false,
            reopened: 0,
            found: None,
            recent: Recent::NEW,
            wavefront: Wavefront::NEW,
            view: [0; SECTORS],
            encoding: Encoding {
                near_mm: 0,
                far_mm: 0,
            },
            has_compass: false,
            compass: Compass::NEW,
            walls: WallDirections::NONE,
            traveled_mm: 0,
            unlocated_mm: 0,
            turn: Bearing::ZERO,
            best: BestPosition::ZERO,
            lost: Lost::NOT,
            purpose: Purpose::Lead(Aim::Position(Displacement::ZERO)),
            stage: Stage::Done,
            leg: Leg::ZERO,
        }
    }

    /// Forgets all, and starts anew from here; in place.
    // One copy in the program.
    #[inline(never)]
    pub fn forget(&mut self) {
        self.graph.forget();
        (self.here, self.current) = (Displacement::ZERO, None);
        (self.frontier, self.frontier_age) = (None, 0);
        (self.target, self.found, self.recent) = (None, None, Recent::NEW);
        (self.looks_closely, self.is_cut_off, self.reopened) = (false, false, 0);
        self.stage = Stage::Done;
        (self.compass, self.traveled_mm) = (Compass::NEW, 0);
        self.lost.end();
    }

    /// The heading of the odometry is that of a compass, or of a turret that is held: it does not
    /// drift.
    pub const fn trust_heading(&mut self, has_compass: bool) {
        self.has_compass = has_compass;
    }

    /// By how much the robot faces farther to the left than was thought, since it was asked last.
    pub const fn take_turn(&mut self) -> Bearing {
        core::mem::replace(&mut self.turn, Bearing::ZERO)
    }

    /// From now on something else is sought.
    pub fn seek_anew(&mut self) {
        self.graph.search_anew();
        (self.frontier, self.frontier_age) = (None, 0);
        (self.target, self.found, self.is_cut_off) = (None, None, false);
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

    /// Pairs of places between which the robot went and the way is not blocked, each once. A number
    /// counts [`positions`](Self::positions).
    pub fn links(&self) -> impl Iterator<Item = (u16, u16)> {
        let graph = &self.graph;
        graph.numbered().flat_map(move |(from, record)| {
            let open = record
                .links()
                .filter(move |to| !graph.is_blocked(from, *to));
            let ends = open.filter_map(move |to| Some((to, graph.get(to)?)));
            // A place forgets its oldest links: the other one may still have this one.
            ends.filter(move |(to, other)| from < *to || !other.was_gone_to(from))
                .map(move |(to, _)| (from, to))
        })
    }

    /// Pairs of places between which the way has proved blocked lately, each once, as of
    /// [`links`](Self::links).
    pub fn blocked(&self) -> impl Iterator<Item = (u16, u16)> {
        self.graph.blocked()
    }

    /// Frontiers: the place from which each open way leads, and where it ends, from the start.
    pub fn frontiers(&self) -> impl Iterator<Item = (u16, Displacement)> {
        self.graph.numbered().flat_map(|(index, record)| {
            let ways = record.frontiers();
            ways.map(move |way| (index, record.end_of(way.into())))
        })
    }

    /// The way on which [`think`](Self::think) led with this aim the last time, from the start: the
    /// next sub-goal, the places after it, and the goal or the end of an open way.
    pub fn plan(&self, aim: Aim) -> impl Iterator<Item = Displacement> {
        let goal = match aim {
            Aim::Position(position) => Some(position),
            Aim::Frontier | Aim::Everywhere | Aim::Situation => None,
        };
        let place = |index: u16| self.graph.get(index);
        let target = self.target;
        let first = target
            .map(|target| target.record)
            .filter(|first| place(*first).is_some());
        let end = match (first, target) {
            (Some(first), _) => {
                let (last, way) = self.wavefront.end_of_way(first);
                let open = way.and_then(|way| Some(place(last)?.end_of(way.into())));
                open.or(goal)
            }
            (None, Some(target)) => Some(target.position),
            // It sees the goal.
            (None, None) => goal,
        };
        let next = |index: &u16| self.wavefront.next(*index);
        // No way is longer than all places.
        let indices = core::iter::successors(first, next).take(RECORDS);
        indices.filter_map(place).map(|record| record.at).chain(end)
    }

    /// The robot has moved, in the frame of the start.
    pub fn moved(&mut self, moved: Displacement) {
        self.here = self.here.plus(moved);
        self.traveled_mm = self.traveled_mm.saturating_add(moved.length_mm());
        self.unlocated_mm = self.unlocated_mm.saturating_add(moved.length_mm());
        self.lost.moved(moved.length_mm());
    }
}

#[cfg(test)]
mod tests;
