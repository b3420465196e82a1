//! The next sub-goal on the way to a goal, or to where the robot has not been.

use super::graph::LONGEST_LINK_MM;
use super::ground::Ground;
use super::recall::Sought;
use super::record::Record;
use super::stage::{Candidate, NO_CANDIDATE, Stage};
use super::{Aim, Frontier, NOWHERE, PlaceLimits, Places, Purpose, Target};
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
    /// The way to the goal, if the robot sees it, or to the sub-goal that it is on the way to.
    pub(super) fn known_way<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        ground: &Ground<'_, POINTS>,
        sought: Sought<'_, SECTORS>,
    ) -> Option<Displacement> {
        let is_stuck = self.recent.is_stuck(self.here);
        let fits = |way: &Displacement| way.is_shorter_than(SIGHT_MM.into()) && ground.fits(*way);
        let to_goal = sought
            .position()
            .map(|goal| goal.minus(self.here))
            .filter(fits);
        if to_goal.is_some() {
            (self.frontier, self.target) = (None, None);
            return to_goal;
        }
        if is_stuck {
            self.lost.doubt();
            self.give_up(limits);
        }
        let target = self.target.take()?;
        let way = target.position.minus(self.here);
        let is_open = way.is_shorter_than(limits.near_mm.into()) || fits(&way);
        if target.left == 0 || way.is_shorter_than(REACHED_MM) || !is_open {
            return None;
        }
        let left = target.left - 1;
        self.target = Some(Target { left, ..target });
        Some(way)
    }

    /// The way to a new sub-goal, if this is the best place in sight.
    pub(super) fn new_way<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        ground: &Ground<'_, POINTS>,
        sought: Sought<'_, SECTORS>,
        (_, best): Candidate,
    ) -> Option<Displacement> {
        let index = (best != NOWHERE).then_some(best);
        let Some(index) = index.or_else(|| self.nearest_reached()) else {
            // Nothing is left: everything may be tried again.
            self.graph.search_anew();
            self.looks_closely |= self.purpose == Purpose::Lead(Aim::Everywhere);
            self.lost.resign();
            return None;
        };
        let target = self.sub_goal(limits, ground, sought, index)?;
        self.target = Some(target);
        Some(target.position.minus(self.here))
    }

    /// Looks for the best place in sight, at so many places; the best is known of those before.
    pub(super) fn look<const POINTS: usize>(
        &self,
        limits: &PlaceLimits,
        ground: &Ground<'_, POINTS>,
        (first, mut best): (u16, Candidate),
        steps: u16,
    ) -> Stage {
        for (index, record) in self.graph.numbered_from(first, steps) {
            let way = record.at.minus(self.here);
            let length_mm = way.length_mm();
            let Some(to_goal_mm) = self.wavefront.cost_mm(index) else {
                continue;
            };
            let candidate = (to_goal_mm.saturating_add(length_mm), index);
            // A body's centers so near to each other have no wall between them.
            let is_open =
                || length_mm < limits.near_mm || length_mm <= SIGHT_MM && ground.fits(way);
            if candidate < best && !self.is_blocked_from_here(index) && is_open() {
                best = candidate;
            }
        }
        Stage::Sight(first.saturating_add(steps), best)
    }

    /// The sub-goal of a way that goes by this place.
    fn sub_goal<const POINTS: usize>(
        &mut self,
        limits: &PlaceLimits,
        ground: &Ground<'_, POINTS>,
        sought: Sought<'_, SECTORS>,
        index: u16,
    ) -> Option<Target> {
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
            && ground.fits(to_next.shortened(SIGHT_MM));
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

    /// Spreads the costs of the ways to the goal and to the frontiers, from so many places on.
    pub(super) fn spread(&mut self, limits: &PlaceLimits, steps: u16) -> Stage {
        let (graph, wavefront) = (&self.graph, &mut self.wavefront);
        for _ in 0..steps {
            let Some((from, cost_mm)) = wavefront.nearest() else {
                return Stage::Sight(0, NO_CANDIDATE);
            };
            let Some(origin) = graph.get(from) else {
                continue;
            };
            for (index, record) in graph.numbered() {
                let way = record.at.minus(origin.at);
                if !way.is_shorter_than(u32::from(LONGEST_LINK_MM) + 1) {
                    continue;
                }
                let through_mm = cost_mm.saturating_add(way.length_mm() + STOP_MM);
                if wavefront.improves(index, through_mm) && graph.is_linked(limits, index, from) {
                    wavefront.reach(index, through_mm, from);
                }
            }
        }
        Stage::Wave
    }

    /// Begins the wave at so many places: at the goal, or at those that it recalls, and at the
    /// frontiers.
    pub(super) fn begin_wave(
        &mut self,
        limits: &PlaceLimits,
        sought: Sought<'_, SECTORS>,
        first: u16,
        steps: u16,
    ) -> Stage {
        let goal = sought.position();
        let (graph, wavefront) = (&self.graph, &mut self.wavefront);
        let is_near = |goal: Displacement, record: &Record<SECTORS>| {
            goal.minus(record.at).is_shorter_than(limits.near_mm.into())
        };
        let is_known = goal.is_some_and(|goal| graph.records().iter().any(|r| is_near(goal, r)));
        for (index, record) in graph.numbered_from(first, steps) {
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
            let toward = goal.and_then(|goal| record.open_toward(goal.minus(record.at).bearing()));
            for way in record.frontiers().chain(toward) {
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
        let next = first.saturating_add(steps);
        if usize::from(next) < graph.records().len() {
            Stage::Sources(next)
        } else {
            Stage::Wave
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
