//! The paper's four steps (section 2.5, Fig. 3), with every intermediate value.
//!
//! 1. find the neuron that stands for the *goal* situation;
//! 2. find the neuron of the *present* situation;
//! 3. choose a *neighbor* of it nearer to the goal: the intermediate situation;
//! 4. probe the action map with the change of situation wanted; it answers with an action.
//!
//! With [`PlannerKind::Recall`] these are the steps. The other choices ask the action map the other
//! way round: what change does each action bring, and which of the situations to come is nearest to
//! the goal (`look_ahead`).

use crate::action_map::{ActionMap, Match, Preference, Probe};
use crate::config::{AtGoal, Config, PlannerKind, Subgoal};
use crate::fixed::{Mask, Weight, Weight32, to_weight16, unit_weight};
use crate::goal::{Goal, ValueBounds};
use crate::scan::Situation;
use crate::som::Som;
use crate::units::{Bearing, Displacement};
use serde::{Deserialize, Serialize};

mod cost_surface;
mod forward_model;
mod goal_neuron;
mod look_ahead;

pub(crate) use goal_neuron::Memo;
use goal_neuron::cost;
use look_ahead::Aim;

/// Why the planner chose what it chose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Why {
    /// A neighbor nearer to the goal was aimed at.
    Neighbour,
    /// The present neuron is the goal neuron: the goal itself was aimed at.
    GoalNeuron,
    /// No neighbor is nearer to the goal than the present neuron: the goal itself was aimed at.
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
    /// No action led nearer to the goal for some time: obstacles are avoided on another course for
    /// a while.
    Wander,
}

impl core::fmt::Display for Why {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Neighbour => "neighbor",
            Self::GoalNeuron => "at the goal neuron",
            Self::NoNearerNeighbour => "no nearer neighbor",
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
    /// The last displacement, in the ring's present frame.
    pub course: Displacement,
    /// The last displacement was cut below half.
    pub cut: bool,
}

impl<const SENSORS: usize, const NEURONS: usize> Planner<'_, SENSORS, NEURONS> {
    /// The decision for one situation and one goal: the paper's steps 1 and 2, then 3 and 4 or the
    /// look-ahead.
    #[must_use]
    pub fn plan(&self, situation: &Situation<SENSORS>, goal: &Goal<SENSORS>) -> Plan<SENSORS> {
        let mut nothing = Memo::NONE;
        self.plan_next(situation, goal, &mut nothing)
    }

    /// The same after another decision, whose searches warm-start this one's and never change it.
    pub(crate) fn plan_next(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        last: &mut Memo,
    ) -> Plan<SENSORS> {
        let travel = self.travel_sensor_from(last.travel(), situation, goal);
        let mut asked = [ValueBounds::ANYTHING; SENSORS];
        for (slot, asked) in asked.iter_mut().zip(goal.asked(travel, self.enabled)) {
            *slot = asked;
        }
        // Steps 1 and 2.
        let goal_neuron = last.goal_neuron(self, travel, &asked);
        let current = self.current_neuron(situation);
        // Steps 3 and 4, or the look-ahead in their place.
        match self.config.planning.planner {
            PlannerKind::Recall => {
                let goal = goal.towards(travel);
                self.recall(situation, &goal, &asked, [goal_neuron, current])
            }
            PlannerKind::BestNeuron | PlannerKind::BestHeading => {
                let aim = Aim::new(self, goal, &asked, travel);
                self.look_ahead(situation, &aim, [goal_neuron, current])
            }
        }
    }

    /// Step 2: the best-matching unit of the situation.
    fn current_neuron(&self, situation: &Situation<SENSORS>) -> usize {
        let search = || self.situations.bmu(situation, self.enabled);
        self.current.unwrap_or_else(search)
    }

    /// Step 3: the neighbor of the current neuron that is nearest to the goal, and why it or
    /// another neuron is aimed at.
    #[inline(never)]
    fn subgoal(
        &self,
        current: usize,
        goal_neuron: usize,
        asked: &[ValueBounds; SENSORS],
    ) -> (usize, Why) {
        let grid = self.situations.grid();
        let by_hops = match self.config.planning.subgoal {
            Subgoal::Goal => return (goal_neuron, Why::GoalDirectly),
            _ if current == goal_neuron => return (goal_neuron, Why::GoalNeuron),
            Subgoal::FewestHops => true,
            Subgoal::NearestCode => false,
        };
        let cost = |neuron: usize| cost(self.situations, neuron, asked, i64::MAX);
        let hops = |neuron: usize| {
            if by_hops {
                grid.hops(neuron, goal_neuron)
            } else {
                0
            }
        };
        let neighbors = grid.neighbors(current);
        match neighbors.min_by_key(|&k| (hops(k), cost(k), k)) {
            Some(nearest) if by_hops || cost(nearest) < cost(current) => (nearest, Why::Neighbour),
            _ => (goal_neuron, Why::NoNearerNeighbour),
        }
    }

    /// Steps 3 and 4: what the action map recalls for the change that leads to the subgoal.
    #[inline(never)]
    fn recall(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        asked: &[ValueBounds; SENSORS],
        [goal_neuron, current]: [usize; 2],
    ) -> Plan<SENSORS> {
        let (subgoal, why) = self.subgoal(current, goal_neuron, asked);
        let aim = (why == Why::Neighbour).then_some(subgoal);
        let wanted = self.change_wanted(situation, goal, current, aim);
        let answer = self.answer(&wanted);
        let at_goal = goal.holds(situation, self.enabled, self.config.planning.tolerance);
        let (action, why) = match at_goal {
            true => self.at_goal(),
            false => (self.recalled(&answer), why),
        };
        Plan {
            goal_neuron: goal_neuron as u8,
            current_neuron: current as u8,
            intermediate_neuron: subgoal as u8,
            wanted,
            action_neuron: answer.neuron as u8,
            at_goal,
            recalled: !at_goal,
            action,
            why,
        }
    }

    /// The change from the situation to the neuron aimed at, or to the goal itself.
    fn change_wanted(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        current: usize,
        aim: Option<usize>,
    ) -> [Weight; SENSORS] {
        let planning = &self.config.planning;
        let code = |neuron: usize| self.situations.code().get(neuron);
        let target = aim.and_then(code);
        let start = code(current).filter(|_| !planning.from_measured);
        let mut wanted = [Weight::ZERO; SENSORS];
        for (sensor, (change, value)) in wanted.iter_mut().zip(situation).enumerate() {
            let component = goal.components.get(sensor).copied();
            let met = component.map_or(*value, |component| component.nearest(*value));
            if planning.unmet_only && met == *value {
                continue;
            }
            let part = |code: &[Weight32; SENSORS]| code.get(sensor).copied().map(to_weight16);
            let to = target.and_then(part).unwrap_or(met);
            let from = start.and_then(part).unwrap_or(*value);
            *change = less(to, from);
        }
        wanted
    }

    /// Step 4: what the action map answers to a change wanted.
    fn answer(&self, wanted: &[Weight; SENSORS]) -> Match<NEURONS> {
        let planning = &self.config.planning;
        let (code, step) = (self.config.action_code, self.config.robot.step_mm);
        let preference = (planning.straight_q8 > 0).then(|| Preference {
            code: code.encode(self.course, step),
            weight_q8: planning.straight_q8,
        });
        let probe = Probe {
            recall: planning.recall,
            preference,
        };
        let mut answer = Match::none();
        self.actions
            .matches(wanted, self.enabled, probe, self.allowed, &mut answer);
        answer
    }

    /// The displacement that an answer stands for.
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

    /// The goal asks for no change, so nothing is recalled: the robot goes on as it went, or, where
    /// it could not, on a course turned by a part of the ring that comes by every place in turn.
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

/// More than the cost of anything that may be chosen; a sum with one is no overflow.
const FAR: i64 = i64::MAX / 2;

/// The index of least cost and its cost, the lowest on ties; `count` where none costs less than
/// [`FAR`]. A cost that reaches the limit may be more than that: after a good first guess most need
/// not be summed to the end.
fn cheapest(count: usize, first: usize, cost: impl Fn(usize, i64) -> i64) -> (usize, i64) {
    let (mut best, mut least) = (count, FAR);
    for index in core::iter::once(first).chain(0..count) {
        let limit = least.wrapping_add(i64::from(index < best));
        if index < count && index != best {
            let cost = cost(index, limit);
            if cost < limit {
                (best, least) = (index, cost);
            }
        }
    }
    (best, least)
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
fn less(to: Weight, from: Weight) -> Weight {
    unit_weight(i32::from(to.to_bits()).wrapping_sub(i32::from(from.to_bits())))
}

#[cfg(test)]
mod tests;
