//! The paper's four steps (section 2.5, Fig. 3), with every intermediate value.
//!
//! 1. find the neuron that stands for the *goal* situation;
//! 2. find the neuron of the *present* situation;
//! 3. choose a *neighbour* of it nearer to the goal: the intermediate situation;
//! 4. probe the action map with the change of situation wanted; it answers with an action.
//!
//! With [`Choice::Recall`] these are the steps. The other choices ask the action map the other way round: what change does
//! each action bring, and which of the situations to come is nearest to the goal (`look_ahead`).

use crate::action_map::{ActionMap, Match, Preference, Probe};
use crate::config::{AtGoal, Choice, Config, Intermediate};
use crate::fixed::{Fine, Mask, Weight, coarse, unit_weight};
use crate::goal::{Goal, Heaviest, heaviest};
use crate::scan::Situation;
use crate::som::Som;
use crate::units::{Bearing, Displacement};
use serde::{Deserialize, Serialize};

mod forward;
mod landscape;
mod look_ahead;

/// Why the planner chose what it chose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Why {
    /// A neighbour nearer to the goal was aimed at.
    Neighbour,
    /// The present neuron is the goal neuron: the goal itself was aimed at.
    GoalNeuron,
    /// No neighbour is nearer to the goal than the present neuron: the goal itself was aimed at.
    NoNearerNeighbour,
    /// The choice was to aim at the goal itself.
    GoalDirectly,
    /// The goal holds: the last displacement goes on.
    KeepCourse,
    /// The goal holds, but the last move on this course was cut short: another course.
    TurnCourse,
    /// The goal holds: straight ahead.
    StraightAhead,
    /// The situation this action leads to is nearest to the goal.
    LookAhead,
    /// No action leads nearer to the goal than standing still.
    Stay,
    /// No action led nearer to the goal for some time: obstacles are avoided on another course for a while.
    Wander,
}

impl core::fmt::Display for Why {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Neighbour => "neighbour",
            Self::GoalNeuron => "at the goal neuron",
            Self::NoNearerNeighbour => "no nearer neighbour",
            Self::GoalDirectly => "goal directly",
            Self::KeepCourse => "keep course",
            Self::TurnCourse => "turn course",
            Self::StraightAhead => "straight ahead",
            Self::LookAhead => "look-ahead",
            Self::Stay => "stay",
            Self::Wander => "wander",
        })
    }
}

/// One decision with all its intermediate values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[repr(align(4))]
pub struct Plan<const SENSORS: usize> {
    /// Neuron that stands for the goal.
    pub goal_neuron: u8,
    /// Best-matching unit of the present situation.
    pub current_neuron: u8,
    /// Neuron aimed at.
    pub intermediate_neuron: u8,
    /// Change of situation wanted: the probe of the action map.
    #[serde(with = "crate::arrays")]
    pub wanted: [Weight; SENSORS],
    /// Neuron of the action map that answered.
    pub action_neuron: u8,
    /// The goal holds.
    pub at_goal: bool,
    /// The action is the one the action map recalled, not what is done at the goal.
    pub recalled: bool,
    /// The move asked for, in the ring's frame, before the shield.
    pub action: Displacement,
    /// Why.
    pub why: Why,
}

/// The neuron that stands for a goal, to start from when it is sought again: it and the place of the ring are looked at
/// first, and most others soon drop out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GoalNeuron {
    /// The neuron.
    pub neuron: u8,
    /// Place of the ring towards which the goal was pursued.
    pub place: u8,
    /// The goal's component that weighs most, if the deviation is known.
    pub heaviest: u8,
    /// Transducers that were believed.
    pub believed: Mask,
    /// Its deviation from the goal, if the goal is the same and no neuron but the planner's `current` one has changed since;
    /// in units of 2⁻²⁶ · weight.
    pub deviation: Option<i64>,
}

impl GoalNeuron {
    /// Any; nothing is known.
    pub const UNKNOWN: Self = Self {
        neuron: 0,
        place: 0,
        heaviest: 0,
        believed: Mask::NONE,
        deviation: None,
    };
}

/// The maps and the moment a plan is made of.
#[derive(Debug, Clone, Copy)]
pub struct Planner<'a, const SENSORS: usize, const NEURONS: usize> {
    /// The configuration.
    pub config: &'a Config<SENSORS>,
    /// The map of situations.
    pub situations: &'a Som<NEURONS, SENSORS>,
    /// The map of changes and actions.
    pub actions: &'a ActionMap<NEURONS, SENSORS>,
    /// Transducers that are used.
    pub enabled: Mask,
    /// Action neurons that may answer.
    pub allowed: Mask,
    /// Best-matching unit of the situation, if it is known already.
    pub current: Option<usize>,
    /// The neuron that stood for the goal last time, or any.
    pub likely: GoalNeuron,
    /// The last displacement, in the ring's present frame.
    pub course: Displacement,
    /// The last displacement was cut below half.
    pub cut: bool,
}

impl<const SENSORS: usize, const NEURONS: usize> Planner<'_, SENSORS, NEURONS> {
    /// The decision for one situation and one goal.
    #[must_use]
    pub fn plan(&self, situation: &Situation<SENSORS>, goal: &Goal<SENSORS>) -> Plan<SENSORS> {
        let way = self.way(situation, goal);
        self.plan_on_way(situation, goal, way).0
    }

    /// The same on the [`way`](Self::way) towards a place of the ring; and the neuron that stands for the goal.
    #[must_use]
    pub fn plan_on_way(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        way: usize,
    ) -> (Plan<SENSORS>, GoalNeuron) {
        let first = self.heaviest(goal);
        let heaviest = Heaviest::from(&goal.components, way, self.enabled, first);
        let planning = &self.config.planning;
        let own = (planning.choice == Choice::Recall
            && planning.intermediate == Intermediate::NearestCode)
            .then_some(self.current)
            .flatten()
            .map(|current| self.distance(current, &heaviest, i64::MAX));
        let (neuron, deviation) = self.goal_neuron(&heaviest, way, own);
        let found = GoalNeuron {
            neuron: neuron as u8,
            place: way as u8,
            heaviest: first as u8,
            believed: self.enabled,
            deviation: Some(deviation),
        };
        let plan = match planning.choice {
            Choice::Recall if way == 0 => self.recall(situation, goal, &heaviest, neuron, own),
            Choice::Recall => self.recall(situation, &goal.towards(way), &heaviest, neuron, own),
            Choice::Neurons | Choice::Headings => self.look_ahead(situation, goal, way, neuron),
        };
        (plan, found)
    }

    /// The goal's component that weighs most; not looked for again for the same goal.
    fn heaviest(&self, goal: &Goal<SENSORS>) -> usize {
        match self.likely.deviation {
            Some(_) => usize::from(self.likely.heaviest),
            None => heaviest(&goal.components),
        }
    }

    /// The paper's four steps.
    #[inline(never)]
    fn recall(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        asked: &Heaviest<'_, SENSORS>,
        goal_neuron: usize,
        own: Option<i64>,
    ) -> Plan<SENSORS> {
        let planning = &self.config.planning;
        let mask = self.enabled;
        let current = self.current(situation);
        let (aim, why) = self.aim(current, goal_neuron, asked, own);
        let aimed = match why {
            Why::Neighbour => self.situations.code().get(aim),
            _ => None,
        };
        let own = match planning.from_measured {
            true => None,
            false => self.situations.code().get(current),
        };
        let mut wanted = [Weight::ZERO; SENSORS];
        let (unmet_only, tolerance) = (planning.unmet_only, planning.tolerance);
        let tolerant = tolerance >= Weight::ZERO;
        let mut at_goal = tolerant || mask.indices(SENSORS).next().is_none();
        let ring = situation.iter().zip(&goal.components);
        // Mostly all is as asked, which is seen sooner by itself.
        let is_met = || {
            ring.clone()
                .all(|(value, component)| component.holds(*value))
        };
        let changes = match unmet_only && is_met() {
            true => &mut [][..],
            false => &mut wanted,
        };
        for (sensor, (change, (value, component))) in changes.iter_mut().zip(ring).enumerate() {
            let value = *value;
            if unmet_only && component.holds(value) {
                continue;
            }
            let met = component.nearest(value);
            if unmet_only && met == value {
                continue;
            }
            at_goal &= !mask.contains(sensor) || value.abs_diff(met) <= tolerance;
            let part = |row: &[Fine; SENSORS]| row.get(sensor).copied().map(coarse);
            let target = aimed.and_then(part).unwrap_or(met);
            let from = own.and_then(part).unwrap_or(value);
            *change = less(target, from);
        }
        let preference = (planning.straight_q8 > 0).then(|| Preference {
            code: self
                .config
                .action_code
                .encode(self.course, self.config.robot.step_mm),
            weight_q8: planning.straight_q8,
        });
        let probe = Probe {
            recall: planning.recall,
            preference,
        };
        let mut found = Match::none();
        self.actions
            .matches(&wanted, mask, probe, self.allowed, &mut found);
        let (action, why) = if at_goal {
            self.at_goal()
        } else {
            (self.recalled(&found), why)
        };
        Plan {
            goal_neuron: goal_neuron as u8,
            current_neuron: current as u8,
            intermediate_neuron: aim as u8,
            wanted,
            action_neuron: found.neuron as u8,
            at_goal,
            recalled: !at_goal,
            action,
            why,
        }
    }

    /// Best-matching unit of the situation.
    fn current(&self, situation: &Situation<SENSORS>) -> usize {
        let search = || self.situations.winner(situation, self.enabled);
        self.current.unwrap_or_else(search)
    }

    /// The neuron whose code vector deviates least from what is asked, the lowest on ties. Most drop out before all their
    /// components have been looked at. `own` is the current neuron's deviation, if it is known already.
    #[inline(never)]
    fn goal_neuron(
        &self,
        asked: &Heaviest<'_, SENSORS>,
        place: usize,
        own: Option<i64>,
    ) -> (usize, i64) {
        let code = self.situations.code();
        let likely = self.likely;
        let mut nearest = usize::from(likely.neuron);
        let same = usize::from(likely.place) == place && likely.believed == self.enabled;
        if let Some(least) = likely.deviation.filter(|_| same) {
            let Some(changed) = self.current else {
                return (nearest, least);
            };
            let limit = least.saturating_add(i64::from(changed <= nearest));
            let deviation = own.unwrap_or_else(|| self.distance(changed, asked, limit));
            if deviation < limit {
                return (changed, deviation);
            }
            if changed != nearest {
                return (nearest, least);
            }
        }
        let mut least = self.distance(nearest, asked, i64::MAX);
        for (neuron, row) in code.iter().enumerate() {
            // Of two as near the lower counts.
            let limit = least.saturating_add(i64::from(neuron < nearest));
            if limit == 0 {
                break;
            }
            let distance = asked.missed_by(row, limit);
            if distance < limit {
                (nearest, least) = (neuron, distance);
            }
        }
        (nearest, least)
    }

    /// How far neuron `k` deviates from what is asked, in units of 2⁻²⁶ · weight; what reaches `limit` may be more.
    fn distance(&self, k: usize, asked: &Heaviest<'_, SENSORS>, limit: i64) -> i64 {
        let row = self.situations.code().get(k);
        row.map_or(i64::MAX, |row| asked.missed_by(row, limit))
    }

    /// Step 3: which neuron to aim at, and why.
    #[inline(never)]
    fn aim(
        &self,
        current: usize,
        goal: usize,
        asked: &Heaviest<'_, SENSORS>,
        own: Option<i64>,
    ) -> (usize, Why) {
        let grid = self.situations.grid();
        let hops = match self.config.planning.intermediate {
            Intermediate::Goal => return (goal, Why::GoalDirectly),
            _ if current == goal => return (goal, Why::GoalNeuron),
            Intermediate::FewestHops => true,
            Intermediate::NearestCode => false,
        };
        let far = |k: usize, limit: i64| self.distance(k, asked, limit);
        let own = if hops {
            i64::MAX
        } else {
            own.unwrap_or_else(|| far(current, i64::MAX))
        };
        if own == 0 {
            return (goal, Why::NoNearerNeighbour);
        }
        let mut nearest = None;
        let mut least = (usize::MAX, own, 0);
        for k in grid.neighbours(current) {
            let steps = if hops { grid.hops(k, goal) } else { 0 };
            let limit = if steps < least.0 {
                own
            } else {
                least.1.saturating_add(1)
            };
            let key = (steps, far(k, limit), k);
            if key < least && (hops || key.1 < own) {
                (nearest, least) = (Some(k), key);
            }
        }
        nearest.map_or((goal, Why::NoNearerNeighbour), |k| (k, Why::Neighbour))
    }

    #[inline(never)]
    fn recalled(&self, found: &Match<NEURONS>) -> Displacement {
        let step = self.config.robot.step_mm;
        let planning = &self.config.planning;
        let decode = |code| self.config.action_code.decode(code, step);
        let mut action = decode(self.actions.actions().code_vector(found.neuron));
        if planning.together && !self.cut {
            let mean = decode(self.actions.together(found, self.allowed));
            // Answers that cancel out say nothing: the best one decides.
            if mean.length_mm() >= step / 8 {
                action = mean;
            }
        }
        let inertia = (u32::from(planning.inertia_q8) * u32::from(step)) >> 8;
        if inertia > 0 {
            let kept = self.course.with_length(inertia as u16);
            action = action.with_length(step).plus(kept);
        }
        if planning.full_steps || action.length_mm() > step {
            action.with_length(step)
        } else {
            action
        }
    }

    /// The goal asks for no change, so nothing is recalled: the robot goes on as it went, or, where it
    /// could not, on a course turned by a part of the ring that comes by every place in turn.
    fn at_goal(&self) -> (Displacement, Why) {
        let step = self.config.robot.step_mm;
        let course = self.course.with_length(step);
        let keeps = self.config.planning.at_goal == AtGoal::KeepCourse;
        match (keeps && course != Displacement::ZERO, self.cut) {
            (true, false) => (course, Why::KeepCourse),
            (true, true) => (course.rotated(NEXT_COURSE.direction()), Why::TurnCourse),
            (false, _) => {
                let ahead = Displacement::saturating(i32::from(step), 0);
                (ahead, Why::StraightAhead)
            }
        }
    }
}

/// Five sixteenths of a turn: 112.5°.
pub(crate) const NEXT_COURSE: Bearing = Bearing::from_turns(5 << 12);

/// Component by component `to − from`, clamped to [−1, 1].
#[must_use]
pub fn difference<const SENSORS: usize>(
    to: &[Weight; SENSORS],
    from: &[Weight; SENSORS],
) -> [Weight; SENSORS] {
    let mut change = *to;
    for (value, start) in change.iter_mut().zip(from) {
        *value = less(*value, *start);
    }
    change
}

/// `to − from`, clamped to [−1, 1].
#[inline(always)]
fn less(to: Weight, from: Weight) -> Weight {
    unit_weight(i32::from(to.to_bits()).wrapping_sub(i32::from(from.to_bits())))
}

#[cfg(test)]
mod tests;
