//! A memory of places: where the robot was, and where it can go from there (the paper's §5.2).
//!
//! A record stands for the ground around a position. Records are linked where the robot went, where
//! they are near, or where its body would fit between them. A goal becomes a chain of sub-goals:
//! [`Places::lead`] spreads the length of the way from the goal over the links, and the next
//! sub-goal is the record in sight from which the whole way is shortest. A free way whose end no
//! record covers is a *frontier*: it counts as a way to the goal as well, so that what is not known
//! yet is searched for (Yamauchi 1997, *A frontier-based approach for autonomous exploration*).
//!
//! Positions come from odometry, in the frame of the start: ±32 m.

use crate::points::PointMemory;
use crate::units::Displacement;

mod graph;
mod recent;
mod record;
mod wavefront;

use graph::{Graph, LONGEST_LINK_MM};
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
    /// What a frontier costs more than a way that is known, once the goal is known, millimeters.
    pub frontier_mm: u16,
}

impl PlaceLimits {
    /// For a body of the Nomad's size, in rooms.
    pub const NOMAD: Self = Self {
        spacing_mm: 350,
        near_mm: 450,
        radius_mm: 290,
        frontier_mm: 4_000,
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

/// The robot sees a place that is not farther than this, millimeters.
const SIGHT_MM: u16 = 1_600;
/// A place is reached within this, millimeters.
const REACHED_MM: u32 = 130;
/// What a place on the way costs, millimeters: of two ways as long the straighter is taken.
const STOP_MM: u16 = 20;
/// The frontier that the robot is led to seems so much nearer, millimeters: it stays with it.
const KEPT_MM: u16 = 300;
const LEAST_MM: u16 = 50;
/// Decisions for which a sub-goal stays while it is in sight: the robot does not turn back halfway.
const STEADY: u8 = 8;
/// A robot keeps as much room as its way leaves, millimeters.
const ROOMS_MM: [u16; 4] = [400, 250, 150, 75];
/// A frontier that has not been reached after so many decisions is given up.
const PATIENCE: u8 = 60;
/// No place.
const NOWHERE: u16 = u16::MAX;

/// Places, at most `RECORDS` of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Places<const RECORDS: usize> {
    graph: Graph<RECORDS>,
    /// Where the robot is, from the start.
    here: Displacement,
    /// The record of where it is.
    current: Option<u16>,
    /// The frontier that it is led to, and decisions since.
    frontier: Option<Frontier>,
    frontier_age: u8,
    target: Option<Target>,
    recent: Recent,
    wavefront: Wavefront<RECORDS>,
}

impl<const RECORDS: usize> Default for Places<RECORDS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const RECORDS: usize> Places<RECORDS> {
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
            recent: Recent::NEW,
            wavefront: Wavefront::NEW,
        }
    }

    /// Forgets all, and starts anew from here; in place.
    pub fn forget(&mut self) {
        self.graph.forget();
        (self.here, self.current) = (Displacement::ZERO, None);
        (self.frontier, self.frontier_age) = (None, 0);
        (self.target, self.recent) = (None, Recent::NEW);
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

    /// Takes what the robot, which stands, has around it.
    pub fn perceive<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
    ) {
        let Some(index) = self.graph.place_at(limits, self.here) else {
            return;
        };
        self.graph.look_around(limits, points, index, self.here);
        if let Some(before) = self.current.filter(|before| *before != index) {
            self.graph.went(before, index);
        }
        self.current = Some(index);
    }

    /// The next sub-goal on the way; `None` where there is none: nothing is known yet, or
    /// everything has been visited.
    pub fn lead<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        aim: Aim,
    ) -> Option<Leg> {
        let way = self.next_way(limits, points, aim)?;
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

    fn next_way<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        aim: Aim,
    ) -> Option<Displacement> {
        let goal = match aim {
            Aim::Position(position) => Some(position),
            Aim::Frontier => None,
        };
        let is_stuck = self.recent.is_stuck(self.here);
        let fits = |way: &Displacement| {
            way.is_shorter_than(SIGHT_MM.into())
                && points.free_mm(*way, limits.radius_mm) >= way.length_mm()
        };
        let to_goal = goal.map(|goal| goal.minus(self.here)).filter(fits);
        if to_goal.is_some() {
            (self.frontier, self.target) = (None, None);
            return to_goal;
        }
        if is_stuck {
            self.give_up(limits);
        }
        if let Some(target) = self.target.take() {
            let way = target.position.minus(self.here);
            let is_open = way.is_shorter_than(limits.near_mm.into()) || fits(&way);
            if target.left > 0 && !way.is_shorter_than(REACHED_MM) && is_open {
                let left = target.left - 1;
                self.target = Some(Target { left, ..target });
                return Some(way);
            }
        }
        let target = self.sub_goal(limits, points, goal)?;
        self.target = Some(target);
        Some(target.position.minus(self.here))
    }

    fn sub_goal<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        goal: Option<Displacement>,
    ) -> Option<Target> {
        let fits = |way: Displacement| points.free_mm(way, limits.radius_mm) >= way.length_mm();
        self.spread(limits, goal);
        let visible = self.graph.numbered().filter_map(|(index, record)| {
            let way = record.at.minus(self.here);
            let length_mm = way.length_mm();
            let cost_mm = self.wavefront.cost_mm(index)?.saturating_add(length_mm);
            // A body's centers so near to each other have no wall between them.
            let is_open = length_mm < limits.near_mm || length_mm <= SIGHT_MM && fits(way);
            (is_open && !self.is_blocked_from_here(index)).then_some((cost_mm, index))
        });
        let index = visible.min().map(|(_, index)| index);
        let index = index.or_else(|| self.nearest_reached())?;
        self.follow(limits, index);
        let place = self.graph.get(index)?.at;
        let next = self.end_of(index, goal)?;
        let (to_place, to_next) = (place.minus(self.here), next.minus(self.here));
        let is_on_way = !to_next.is_shorter_than(50) && fits(to_next.shortened(SIGHT_MM));
        let is_there = to_place.is_shorter_than(REACHED_MM);
        let (position, record) = if is_there || is_on_way {
            (next, self.wavefront.next(index).unwrap_or(NOWHERE))
        } else {
            (place, index)
        };
        Some(Target {
            position,
            record,
            left: STEADY,
        })
    }

    /// The nearest place from which there is a way.
    fn nearest_reached(&self) -> Option<u16> {
        let reached = self.graph.numbered();
        let reached = reached.filter(|(index, _)| self.wavefront.cost_mm(*index).is_some());
        let nearest = reached.min_by_key(|(_, record)| record.distance_mm(self.here));
        nearest.map(|(index, _)| index)
    }

    /// Spreads the costs of the ways to the goal and to the frontiers over all places.
    fn spread(&mut self, limits: &PlaceLimits, goal: Option<Displacement>) {
        let (graph, wavefront) = (&self.graph, &mut self.wavefront);
        wavefront.begin();
        let nearest = goal.and_then(|goal| graph.nearest(goal));
        let is_known = nearest.is_some_and(|(_, distance_mm)| distance_mm < limits.near_mm);
        for (index, record) in graph.numbered() {
            if let Some(goal) = goal {
                let way = goal.minus(record.at);
                let length_mm = way.length_mm();
                if length_mm < limits.near_mm || record.free.reach_mm(way) >= length_mm {
                    wavefront.source(index, length_mm, None);
                }
            }
            for way in record.frontiers() {
                let frontier = Frontier { record: index, way };
                let end = record.end_of(way.into());
                let to_goal_mm = goal.map_or(0, |goal| goal.minus(end).length_mm());
                let more_mm = if is_known { limits.frontier_mm } else { 0 };
                let is_kept = self.frontier == Some(frontier);
                let cost_mm = record
                    .distance_mm(end)
                    .saturating_add(to_goal_mm)
                    .saturating_add(more_mm)
                    .saturating_sub(if is_kept { KEPT_MM } else { 0 });
                wavefront.source(index, cost_mm.max(LEAST_MM), Some(way));
            }
        }
        while let Some((from, cost_mm)) = wavefront.nearest() {
            let Some(origin) = graph.get(from) else {
                break;
            };
            for (index, record) in graph.numbered() {
                let length_mm = record.distance_mm(origin.at);
                let through_mm = cost_mm.saturating_add(length_mm).saturating_add(STOP_MM);
                if length_mm <= LONGEST_LINK_MM
                    && wavefront.improves(index, through_mm)
                    && graph.is_linked(limits, index, from)
                {
                    wavefront.reach(index, through_mm, from);
                }
            }
        }
    }

    fn is_blocked_from_here(&self, to: u16) -> bool {
        let from = self.current.filter(|from| *from != to);
        from.is_some_and(|from| self.graph.is_blocked(from, to))
    }

    /// The way goes on from this record: notes the frontier that it ends at, and gives up one that
    /// is not reached.
    fn follow(&mut self, limits: &PlaceLimits, index: u16) {
        let (record, way) = self.wavefront.end_of_way(index);
        let frontier = way.map(|way| Frontier { record, way });
        if frontier != self.frontier {
            (self.frontier, self.frontier_age) = (frontier, 0);
        }
        self.frontier_age = self.frontier_age.saturating_add(1);
        if self.frontier_age > PATIENCE {
            self.close_frontier(limits);
        }
    }

    /// What comes after a record on the way.
    fn end_of(&self, index: u16, goal: Option<Displacement>) -> Option<Displacement> {
        if let Some(next) = self.wavefront.next(index) {
            return self.graph.get(next).map(|record| record.at);
        }
        match self.wavefront.way_of(index) {
            Some(way) => {
                let record = self.graph.get(index)?;
                Some(record.end_of(way.into()))
            }
            None => goal,
        }
    }

    fn close_frontier(&mut self, limits: &PlaceLimits) {
        if let Some(Frontier { record, way }) = self.frontier.take() {
            self.graph.close_frontier(limits, record, way);
        }
    }

    /// What the robot tries does not go.
    fn give_up(&mut self, limits: &PlaceLimits) {
        let target = self.target.take().map(|target| target.record);
        let to = target.filter(|record| *record != NOWHERE);
        match (self.current, to) {
            (Some(from), Some(to)) if from != to => self.graph.block(from, to),
            _ => self.close_frontier(limits),
        }
    }
}

#[cfg(test)]
mod tests;
