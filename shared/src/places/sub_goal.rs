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
/// A goal that is known is looked for on ways that are free for so long, millimeters, as long as
/// any place in sight leads to it.
const WIDE_MM: u16 = 1_000;
/// What is sought by its situation may be at a place that recalls it rather than where the robot
/// has not been: that costs so much more, millimeters.
const UNKNOWN_MM: u16 = 1_500;
/// Decisions for which a sub-goal stays while it is in sight: the robot does not turn back halfway.
const STEADY: u8 = 8;
/// A frontier that has not been reached after so many decisions is given up.
const PATIENCE: u8 = 60;
/// A way on which the robot got stuck does not go for so many decisions.
const STUCK: u16 = 1_000;
/// Nor does a way, for so many, on which something stands now.
const SEEN: u16 = 300;
/// It does if the way is free but for so much, millimeters.
const NEARLY_MM: u16 = 100;

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
        if is_stuck && !self.goes_straight(ground) {
            self.lost.doubt(self.here);
            self.give_up(limits);
        }
        let target = self.target.take()?;
        let way = target.position.minus(self.here);
        let is_open = self.is_straight || way.is_shorter_than(limits.near_mm.into()) || fits(&way);
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
        let has_position = matches!(self.purpose, Purpose::Lead(Aim::Position(_)));
        self.is_cut_off |= has_position && index.is_none();
        let Some(index) = index.or_else(|| self.nearest_reached()) else {
            // Nothing is left: everything may be tried again.
            self.graph.search_anew();
            self.looks_closely |= self.purpose == Purpose::Lead(Aim::Everywhere);
            self.lost.resign(self.here);
            return None;
        };
        let target = self.sub_goal(limits, ground, sought, index)?;
        (self.target, self.is_straight) = (Some(target), false);
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
        if is_there && after != NOWHERE && self.is_obstructed(ground, to_next) {
            // With the next decision another way.
            self.graph.block(index, after, SEEN);
            return None;
        }
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

    /// Something stands on a way between places.
    fn is_obstructed<const POINTS: usize>(
        &self,
        ground: &Ground<'_, POINTS>,
        way: Displacement,
    ) -> bool {
        let likely = Ground {
            is_narrow: true,
            radius_mm: ground.radius_mm / 4 * 3,
            ..*ground
        };
        let free_mm = likely.free_mm(Displacement::ZERO, way);
        free_mm.saturating_add(NEARLY_MM) < way.length_mm()
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
            if let Some(cost_mm) = sought
                .cost_mm(&record.view)
                .filter(|_| !self.graph.is_searched(index))
            {
                wavefront.source(index, cost_mm, None);
            }
            let toward = goal.and_then(|goal| record.open_toward(goal.minus(record.at).bearing()));
            for way in record.frontiers().chain(toward) {
                let frontier = Frontier { record: index, way };
                let end = record.end_of(way.into());
                let to_goal_mm = goal.map_or(0, |goal| goal.minus(end).length_mm());
                let more_mm = match is_known {
                    true if !self.is_cut_off && record.free.length_mm(way.into()) < WIDE_MM => {
                        continue;
                    }
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

    // One copy in the program.
    #[inline(never)]
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

    /// The moves that the maps choose do not lead on: the robot goes straight to its sub-goal, or
    /// from the place where it is to the next one. Returns `false` if it has already tried that, is
    /// there, something stands in the way, or it only guesses where it is.
    fn goes_straight<const POINTS: usize>(&mut self, ground: &Ground<'_, POINTS>) -> bool {
        let may_try = !self.is_straight && self.lost.first_uncertain().is_none();
        let Some(target) = self.target.filter(|_| may_try) else {
            return false;
        };
        let after = Some(target.record)
            .filter(|record| Some(*record) == self.current)
            .and_then(|record| self.wavefront.next(record));
        let place = after.and_then(|record| Some((record, self.graph.get(record)?.at)));
        let (record, position) = place.unwrap_or((target.record, target.position));
        let way = position.minus(self.here);
        let is_there = way.is_shorter_than(REACHED_MM);
        if record == NOWHERE || is_there || self.is_obstructed(ground, way) {
            return false;
        }
        self.target = Some(Target {
            position,
            record,
            // Until it is known whether that leads on.
            left: 2 * STEADY,
        });
        self.is_straight = true;
        true
    }

    /// What the robot tries does not go.
    fn give_up(&mut self, limits: &PlaceLimits) {
        let target = self.target.take().map(|target| target.record);
        let to = target.filter(|record| *record != NOWHERE);
        match (self.current, to) {
            (Some(from), Some(to)) if from != to => self.graph.block(from, to, STUCK),
            _ => self.close_frontier(limits),
        }
    }
}
