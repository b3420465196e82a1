//! The paper's four steps (section 2.5, Fig. 3), with every intermediate value.
//!
//! 1. find the neuron that stands for the *goal* situation;
//! 2. find the neuron of the *present* situation;
//! 3. choose a *neighbour* of it nearer to the goal: the intermediate situation;
//! 4. probe the action map with the change of situation wanted; it answers with an action.
//!
//! With [`Choice::Recall`] these are the steps. The other choices ask the action map the other way round: what change does
//! each action bring, and which of the situations to come is nearest to the goal (`look_ahead`).

use crate::action_map::{ActionMap, Answer, Preference, Probe};
use crate::config::{AtGoal, Choice, Config, Intermediate};
use crate::fixed::{Mask, Weight, coarse, unit_weight};
use crate::goal::Goal;
use crate::scan::Situation;
use crate::som::{Som, kernels};
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

/// The maps and the moment a plan is made of.
#[derive(Debug, Clone, Copy)]
pub struct Planner<'a, const SENSORS: usize, const NEURONS: usize> {
    /// The configuration.
    pub config: &'a Config<SENSORS>,
    /// The map of situations.
    pub situations: &'a Som<NEURONS, SENSORS>,
    /// The map of changes and actions.
    pub actions: &'a ActionMap<NEURONS, SENSORS>,
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
    /// The decision for one situation and one goal.
    #[must_use]
    pub fn plan(&self, situation: &Situation<SENSORS>, goal: &Goal<SENSORS>) -> Plan<SENSORS> {
        self.plan_on_way(situation, goal, self.way(situation, goal))
    }

    /// The same on the [`way`](Self::way) towards a place of the ring.
    #[must_use]
    pub fn plan_on_way(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        way: usize,
    ) -> Plan<SENSORS> {
        match self.config.planning.choice {
            Choice::Recall => self.recall(situation, &goal.towards(way)),
            Choice::Neurons | Choice::Headings => self.look_ahead(situation, goal, way),
        }
    }

    /// The paper's four steps.
    #[inline(never)]
    fn recall(&self, situation: &Situation<SENSORS>, goal: &Goal<SENSORS>) -> Plan<SENSORS> {
        let planning = &self.config.planning;
        let mask = self.config.believed;
        let goal_scores = self.goal_scores(goal);
        let goal_neuron = kernels::least(&goal_scores);
        let current = self.current(situation);
        let (aim, why) = self.aim(current, goal_neuron, &goal_scores);
        let target = match why {
            Why::Neighbour => self.situations.code_vector(aim),
            _ => goal.nearest(situation),
        };
        let from = if planning.from_measured {
            *situation
        } else {
            self.situations.code_vector(current)
        };
        let mut wanted = difference(&target, &from);
        if planning.unmet_only {
            let met = goal.nearest(situation);
            for ((change, met), value) in wanted.iter_mut().zip(&met).zip(situation) {
                if met == value {
                    *change = Weight::ZERO;
                }
            }
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
        let answer = self.actions.recall(&wanted, mask, probe, self.allowed);
        let plan = Plan {
            goal_neuron: goal_neuron as u8,
            current_neuron: current as u8,
            intermediate_neuron: aim as u8,
            wanted,
            action_neuron: answer.neuron as u8,
            at_goal: goal.holds(situation, mask, planning.tolerance),
            recalled: true,
            action: self.recalled(&answer),
            why,
        };
        if plan.at_goal {
            self.at_goal(plan)
        } else {
            plan
        }
    }

    /// Best-matching unit of the situation.
    fn current(&self, situation: &Situation<SENSORS>) -> usize {
        let search = || self.situations.winner(situation, self.config.believed);
        self.current.unwrap_or_else(search)
    }

    /// [`Goal::distance`] of every code vector, transducer by transducer.
    #[inline(never)]
    fn goal_scores(&self, goal: &Goal<SENSORS>) -> [i64; NEURONS] {
        let mut scores = [0_i64; NEURONS];
        for (sensor, component) in goal.components.iter().enumerate() {
            if !self.config.believed.contains(sensor) || component.weight == 0 {
                continue;
            }
            for (score, row) in scores.iter_mut().zip(self.situations.code()) {
                let value = row.get(sensor).copied().map_or(Weight::ZERO, coarse);
                // Most lie within: nothing to multiply.
                if value < component.low || value > component.high {
                    *score = score.wrapping_add(component.deviation(value));
                }
            }
        }
        scores
    }

    /// Step 3: which neuron to aim at, and why.
    #[inline(never)]
    fn aim(&self, current: usize, goal: usize, goal_scores: &[i64; NEURONS]) -> (usize, Why) {
        let grid = self.situations.grid();
        let far = |k: usize| goal_scores.get(k).copied().unwrap_or(i64::MAX);
        let hops = match self.config.planning.intermediate {
            Intermediate::Goal => return (goal, Why::GoalDirectly),
            _ if current == goal => return (goal, Why::GoalNeuron),
            Intermediate::FewestHops => true,
            Intermediate::NearestCode => false,
        };
        let mut nearest = None;
        let mut least = (usize::MAX, i64::MAX, usize::MAX);
        for k in grid.neighbours(current) {
            let key = (if hops { grid.hops(k, goal) } else { 0 }, far(k), k);
            if key < least && (hops || far(k) < far(current)) {
                (nearest, least) = (Some(k), key);
            }
        }
        nearest.map_or((goal, Why::NoNearerNeighbour), |k| (k, Why::Neighbour))
    }

    #[inline(never)]
    fn recalled(&self, answer: &Answer) -> Displacement {
        let step = self.config.robot.step_mm;
        let planning = &self.config.planning;
        let decode = |code| self.config.action_code.decode(code, step);
        let mut action = decode(answer.alone);
        if planning.together && !self.cut {
            let mean = decode(answer.together);
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
    fn at_goal(&self, plan: Plan<SENSORS>) -> Plan<SENSORS> {
        let step = self.config.robot.step_mm;
        let ahead = Displacement::saturating(i32::from(step), 0);
        let course = self.course.with_length(step);
        let keeps = self.config.planning.at_goal == AtGoal::KeepCourse;
        let (action, why) = match (keeps && course != Displacement::ZERO, self.cut) {
            (true, false) => (course, Why::KeepCourse),
            (true, true) => (course.rotated(NEXT_COURSE.direction()), Why::TurnCourse),
            (false, _) => (ahead, Why::StraightAhead),
        };
        Plan {
            action,
            why,
            recalled: false,
            ..plan
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
        *value = unit_weight(i32::from(value.to_bits()).wrapping_sub(i32::from(start.to_bits())));
    }
    change
}
