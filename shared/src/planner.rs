//! Selects an action in the paper's four steps (section 2.5, Fig. 3); never learns or moves.
//!
//! Steps: goal neuron, current neuron, subgoal (a neighbor of the current neuron nearer to the
//! goal), and the action that the action map recalls for the change towards the subgoal. The other
//! [`PlannerKind`]s replace the last two steps by a search one step ahead (`look_ahead`).

use crate::action_map::{ActionMap, Match, Preference, Probe};
use crate::config::{AtGoal, Config, PlannerKind, Subgoal};
use crate::fixed::{Mask, Selection, Weight, Weight32, to_weight16, unit_weight};
use crate::goal::{Goal, ValueBounds};
use crate::scan::Situation;
use crate::som::Som;
use crate::units::{Bearing, Displacement};
use serde::{Deserialize, Serialize};

mod cost_surface;
mod forward_model;
mod goal_neuron;
mod look_ahead;

pub(crate) use goal_neuron::SearchCache;
use goal_neuron::cost;
use look_ahead::GoalView;

/// The reason for the selected action.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Why {
    /// The subgoal is a neighbor nearer to the goal.
    #[serde(alias = "Neighbor")]
    Neighbor,
    /// The current neuron is the goal neuron: the target is the goal itself.
    GoalNeuron,
    /// No neighbor is nearer to the goal than the current neuron: the target is the goal itself.
    #[serde(alias = "NoNearerNeighbor")]
    NoNearerNeighbor,
    /// The configuration makes the goal itself the target.
    GoalDirectly,
    /// The goal holds: the last displacement is repeated.
    KeepCourse,
    /// The goal holds, but the last move on this course was cut short: the course turns.
    TurnCourse,
    /// The goal holds: straight ahead.
    StraightAhead,
    /// The expected situation after this action is nearest to the goal.
    LookAhead,
    /// No action leads nearer to the goal than standing still.
    Stay,
    /// No action led nearer to the goal for some time: the robot avoids obstacles on another course
    /// for a limited time.
    Wander,
}

impl core::fmt::Display for Why {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Neighbor => "neighbor",
            Self::GoalNeuron => "at the goal neuron",
            Self::NoNearerNeighbor => "no nearer neighbor",
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
    /// Best-matching unit of the current situation.
    pub current_neuron: u8,
    /// Neuron of the subgoal.
    #[serde(alias = "subgoal_neuron")]
    pub subgoal_neuron: u8,
    /// Wanted change of situation: the probe of the action map.
    #[serde(with = "crate::arrays")]
    pub wanted: [Weight; SENSORS],
    /// Best-matching neuron of the action map.
    pub action_neuron: u8,
    /// The goal holds.
    pub at_goal: bool,
    /// The action comes from the action map, not from the rule for a goal that holds.
    pub recalled: bool,
    /// The requested move in the ring's frame, before the shield.
    pub action: Displacement,
    /// Reason for the action.
    pub why: Why,
}

/// The inputs of one decision: configuration, maps and robot state.
///
/// `S` selects neurons: [`WideMask`](crate::fixed::WideMask) for more than 32.
#[derive(Debug, Clone, Copy)]
pub struct Planner<'a, const SENSORS: usize, const NEURONS: usize, S = Mask> {
    /// The configuration.
    pub config: &'a Config<SENSORS>,
    /// The map of situations.
    pub situations: &'a Som<NEURONS, SENSORS>,
    /// The map of changes and actions.
    pub actions: &'a ActionMap<NEURONS, SENSORS>,
    /// Enabled transducers.
    pub enabled: Mask,
    /// Action neurons that are not inhibited.
    pub allowed: S,
    /// Best-matching unit of the situation; `None` = not searched yet.
    pub current: Option<usize>,
    /// The last displacement, in the ring's current frame.
    pub course: Displacement,
    /// The last displacement was cut below half.
    pub cut: bool,
}

impl<const SENSORS: usize, const NEURONS: usize, S: Selection> Planner<'_, SENSORS, NEURONS, S> {
    /// The decision for one situation and one goal.
    #[must_use]
    pub fn plan(&self, situation: &Situation<SENSORS>, goal: &Goal<SENSORS>) -> Plan<SENSORS> {
        let mut cache = SearchCache::NONE;
        self.plan_next(situation, goal, &mut cache)
    }

    /// As [`plan`](Self::plan). The cache warm-starts the searches and never changes the result.
    pub(crate) fn plan_next(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        cache: &mut SearchCache,
    ) -> Plan<SENSORS> {
        let travel = self.travel_sensor_from(cache.travel(), situation, goal);
        let mut bounds = [ValueBounds::default(); SENSORS];
        for (sensor, slot) in bounds.iter_mut().enumerate() {
            *slot = goal.asked_of(sensor, travel, self.enabled);
        }
        // Step 1: goal neuron.
        let goal_neuron = cache.goal_neuron(self, travel, &bounds);
        // Step 2: current neuron.
        let current = self.current_neuron(situation);
        // Steps 3 and 4: subgoal and action, or the look-ahead in their place.
        match self.config.planning.planner {
            PlannerKind::Recall => {
                let goal = goal.towards(travel);
                self.plan_by_recall(situation, &goal, &bounds, [goal_neuron, current])
            }
            _ => {
                let view = GoalView::new(self, goal, &bounds, travel);
                self.plan_by_look_ahead(situation, &view, [goal_neuron, current])
            }
        }
    }

    /// Step 2: the best-matching unit of the situation.
    fn current_neuron(&self, situation: &Situation<SENSORS>) -> usize {
        let search = || self.situations.bmu(situation, self.enabled);
        self.current.unwrap_or_else(search)
    }

    /// Step 3: the subgoal and the reason for it: the neighbor of the current neuron nearest to
    /// the goal, or the goal neuron.
    #[inline(never)]
    fn subgoal(
        &self,
        current: usize,
        goal_neuron: usize,
        bounds: &[ValueBounds; SENSORS],
    ) -> (usize, Why) {
        let grid = self.situations.grid();
        let by_hops = match self.config.planning.subgoal {
            Subgoal::Goal => return (goal_neuron, Why::GoalDirectly),
            _ if current == goal_neuron => return (goal_neuron, Why::GoalNeuron),
            Subgoal::FewestHops => true,
            Subgoal::NearestCode => false,
        };
        let cost = |neuron: usize| cost(self.situations, neuron, bounds, i64::MAX);
        let hops = |neuron: usize| {
            if by_hops {
                grid.hops(neuron, goal_neuron)
            } else {
                0
            }
        };
        let neighbors = grid.neighbors(current);
        match neighbors.min_by_key(|&k| (hops(k), cost(k), k)) {
            Some(nearest) if by_hops || cost(nearest) < cost(current) => (nearest, Why::Neighbor),
            _ => (goal_neuron, Why::NoNearerNeighbor),
        }
    }

    /// Steps 3 and 4: the action that the action map recalls for the change to the subgoal.
    #[inline(never)]
    fn plan_by_recall(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        bounds: &[ValueBounds; SENSORS],
        [goal_neuron, current]: [usize; 2],
    ) -> Plan<SENSORS> {
        let (subgoal, why) = self.subgoal(current, goal_neuron, bounds);
        let subgoal_neuron = (why == Why::Neighbor).then_some(subgoal);
        let wanted = self.wanted_change(situation, goal, current, subgoal_neuron);
        let answer = self.best_match(&wanted);
        let at_goal = goal.holds(situation, self.enabled, self.config.planning.tolerance);
        let (action, why) = match at_goal {
            true => self.action_at_goal(),
            false => (self.action(&answer), why),
        };
        Plan {
            goal_neuron: goal_neuron as u8,
            current_neuron: current as u8,
            subgoal_neuron: subgoal as u8,
            wanted,
            action_neuron: answer.neuron as u8,
            at_goal,
            recalled: !at_goal,
            action,
            why,
        }
    }

    /// The change from the situation to the subgoal, or to the goal itself without one.
    fn wanted_change(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        current: usize,
        subgoal_neuron: Option<usize>,
    ) -> [Weight; SENSORS] {
        let planning = &self.config.planning;
        let code = |neuron: usize| self.situations.code().get(neuron);
        let target = subgoal_neuron.and_then(code);
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
            *change = clamped_difference(to, from);
        }
        wanted
    }

    /// Step 4, search: the neuron of the action map that best matches the wanted change.
    fn best_match(&self, wanted: &[Weight; SENSORS]) -> Match<NEURONS> {
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

    /// Step 4, decode: the displacement of the match.
    #[inline(never)]
    fn action(&self, found: &Match<NEURONS>) -> Displacement {
        let step = self.config.robot.step_mm;
        let planning = &self.config.planning;
        let decode = |code| self.config.action_code.decode(code, step);
        let mut action = decode(self.actions.actions().code_vector(found.neuron));
        if planning.together && !self.cut {
            let mean = decode(self.actions.together(found, self.allowed));
            // Matches that cancel out have no direction: the best one decides.
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

    /// The action where the goal holds: the last course, or, after a cut move, the course turned by
    /// [`NEXT_COURSE`]. Repeated turns visit every sensor direction of the ring.
    fn action_at_goal(&self) -> (Displacement, Why) {
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

/// Above the cost of any candidate; adding such a cost cannot overflow.
const MAX_COST: i64 = i64::MAX / 2;

/// The index of least cost and its cost, the lowest index on ties; `count` where no cost is below
/// [`MAX_COST`]. `cost(index, limit)` may stop summing at `limit`: a good `first` saves work.
fn argmin(count: usize, first: usize, cost: impl Fn(usize, i64) -> i64) -> (usize, i64) {
    let (mut best, mut least) = (count, MAX_COST);
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
        *value = clamped_difference(*value, *start);
    }
    change
}

/// `to − from`, clamped to [−1, 1].
fn clamped_difference(to: Weight, from: Weight) -> Weight {
    unit_weight(i32::from(to.to_bits()).wrapping_sub(i32::from(from.to_bits())))
}

#[cfg(test)]
mod tests;
