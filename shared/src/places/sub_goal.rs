//! The next sub-goal on the way to a goal, or to where the robot has not been.

use super::graph::LONGEST_LINK_MM;
use super::recall::Sought;
use super::{Frontier, NOWHERE, PlaceLimits, Places, Target};
use crate::points::PointMemory;
use crate::units::Displacement;

/// The robot sees a place that is not farther than this, millimeters.
const SIGHT_MM: u16 = 2_500;
/// A place is reached within this, millimeters.
const REACHED_MM: u32 = 130;
/// What a place on the way costs, millimeters: of two ways as long the straighter is taken.
const STOP_MM: u16 = 20;
/// The frontier that the robot is led to seems so much nearer, millimeters: it stays with it.
const KEPT_MM: u16 = 300;
/// A shorter way is none, millimeters.
const LEAST_MM: u16 = 50;
/// A goal that is known is looked for on ways that are free for so long, millimeters.
const WIDE_MM: u16 = 1_000;
/// What is sought by its situation may be at a place that recalls it rather than where the robot
/// has not been: that costs so much more, millimeters.
const UNKNOWN_MM: u16 = 1_500;
/// Decisions for which a sub-goal stays while it is in sight: the robot does not turn back halfway.
const STEADY: u8 = 8;
/// A frontier that has not been reached after so many decisions is given up.
const PATIENCE: u8 = 60;

impl<const SECTORS: usize, const RECORDS: usize> Places<SECTORS, RECORDS> {
    /// The way to the next sub-goal.
    pub(super) fn next_way<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        sought: Sought<'_, SECTORS>,
    ) -> Option<Displacement> {
        let is_stuck = self.recent.is_stuck(self.here);
        let fits = |way: &Displacement| {
            way.is_shorter_than(SIGHT_MM.into())
                && points.free_mm(*way, limits.radius_mm) >= way.length_mm()
        };
        let to_goal = sought
            .position()
            .map(|goal| goal.minus(self.here))
            .filter(fits);
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
        let target = self.sub_goal(limits, points, sought)?;
        self.target = Some(target);
        Some(target.position.minus(self.here))
    }

    fn sub_goal<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        points: &PointMemory<POINTS>,
        sought: Sought<'_, SECTORS>,
    ) -> Option<Target> {
        let fits = |way: Displacement| points.free_mm(way, limits.radius_mm) >= way.length_mm();
        self.spread(limits, sought);
        let visible = self.graph.numbered().filter_map(|(index, record)| {
            let way = record.at.minus(self.here);
            let length_mm = way.length_mm();
            let cost_mm = self.wavefront.cost_mm(index)?.saturating_add(length_mm);
            // A body's centers so near to each other have no wall between them.
            let is_open = length_mm < limits.near_mm || length_mm <= SIGHT_MM && fits(way);
            (is_open && !self.is_blocked_from_here(index)).then_some((cost_mm, index))
        });
        let index = visible.min().map(|(_, index)| index);
        let Some(index) = index.or_else(|| self.nearest_reached()) else {
            // Nothing is left: everything may be tried again.
            self.graph.search_anew();
            return None;
        };
        self.follow(limits, index);
        let place = self.graph.get(index)?.at;
        let is_recalled = sought.is_situation() && self.wavefront.is_end(index);
        if is_recalled && place.minus(self.here).is_shorter_than(REACHED_MM) {
            self.graph.searched(index, false);
            return None;
        }
        let next = self.end_of(index, sought.position().unwrap_or(place))?;
        let (to_place, to_next) = (place.minus(self.here), next.minus(self.here));
        let after = self.wavefront.next(index).unwrap_or(NOWHERE);
        let is_on_way = !to_next.is_shorter_than(LEAST_MM.into())
            && !self.is_blocked_from_here(after)
            && fits(to_next.shortened(SIGHT_MM));
        let is_there = to_place.is_shorter_than(REACHED_MM);
        let (position, record) = if is_there || is_on_way {
            (next, after)
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
    fn spread(&mut self, limits: &PlaceLimits, sought: Sought<'_, SECTORS>) {
        self.begin_wave(limits, sought);
        let (graph, wavefront) = (&self.graph, &mut self.wavefront);
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

    /// Begins the wave at the goal, or at the places that it recalls, and at the frontiers.
    fn begin_wave(&mut self, limits: &PlaceLimits, sought: Sought<'_, SECTORS>) {
        let goal = sought.position();
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
            if let Some(cost_mm) = sought.cost_mm(&record.view).filter(|_| !record.is_searched) {
                wavefront.source(index, cost_mm, None);
            }
            for way in record.frontiers() {
                let frontier = Frontier { record: index, way };
                let end = record.end_of(way.into());
                let to_goal_mm = goal.map_or(0, |goal| goal.minus(end).length_mm());
                let more_mm = match is_known {
                    true if record.free.length_mm(way.into()) < WIDE_MM => continue,
                    true => to_goal_mm
                        .saturating_mul(2)
                        .saturating_add(limits.frontier_mm),
                    false if sought.is_situation() => UNKNOWN_MM,
                    false => 0,
                };
                let is_kept = self.frontier == Some(frontier);
                let cost_mm = record
                    .distance_mm(end)
                    .saturating_add(to_goal_mm)
                    .saturating_add(more_mm)
                    .saturating_sub(if is_kept { KEPT_MM } else { 0 });
                wavefront.source(index, cost_mm.max(LEAST_MM), Some(way));
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
    fn end_of(&self, index: u16, goal: Displacement) -> Option<Displacement> {
        if let Some(next) = self.wavefront.next(index) {
            return self.graph.get(next).map(|record| record.at);
        }
        match self.wavefront.way_of(index) {
            Some(way) => {
                let record = self.graph.get(index)?;
                Some(record.end_of(way.into()))
            }
            None => Some(goal),
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
