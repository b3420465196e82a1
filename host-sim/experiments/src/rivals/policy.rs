//! Chooses moves as the controller's look-ahead does, by another model of what a move changes.
//!
//! The same 16 headings, travel sensor, preference for progress, shorter steps near a place,
//! wandering when a place comes no nearer, and inhibition after a move that was cut.

use super::goal_cost::{GoalCost, number, q16};
use crate::baselines::learning::Values;
use amp::config::{Config, Wander};
use amp::goal::{Goal, GoalFrame};
use arena::world::Point;
use sim::ring_pilot::{Perception, Policy, STEP_M, axis};
use std::f64::consts::PI;
use std::sync::Arc;

/// A model that was learned from transitions, as costs of moves.
pub trait CostModel: Send + Sync {
    /// The expected cost of each move from a situation, less what its progress gains. Moves in
    /// units of the longest step, in the ring's frame.
    fn costs(&self, situation: &Values, moves: &[Point], goal: &GoalCost) -> Vec<f64>;

    /// Numbers that a decision needs.
    fn numbers(&self) -> usize;
}

/// Shares of a step to try along the best heading, as the controller does.
const SHORTER: [f64; 4] = [0.75, 0.5, 0.25, 0.0];
/// A place comes nearer when its cost falls by this share.
const NEARER: f64 = 0.02;
/// Five sixteenths of a turn: the course of a robot that begins to wander.
const NEXT_COURSE: usize = 5;

/// How the search for a place goes.
#[derive(Debug, Clone, Copy, Default)]
struct Search {
    /// Least cost since the last wandering.
    nearest: Option<f64>,
    /// Decisions since it was reached.
    since: u8,
    /// Decisions for which the robot still wanders.
    left: u8,
}

impl Search {
    /// Counts a decision at this cost; true when the robot begins to wander with it.
    fn is_stuck(&mut self, cost: f64, wander: Wander) -> bool {
        if self.left > 0 {
            self.left -= 1;
            if self.left == 0 {
                *self = Self::default();
            }
            return false;
        }
        if self
            .nearest
            .is_none_or(|nearest| cost < nearest * (1.0 - NEARER))
        {
            (self.nearest, self.since) = (Some(cost), 0);
            return false;
        }
        self.since = self.since.saturating_add(1);
        let stuck = self.since > wander.patience && wander.moves > 0;
        if stuck {
            self.left = wander.moves;
        }
        stuck
    }
}

/// A policy that pursues a goal by a model.
#[derive(Clone)]
pub struct ModelPolicy {
    model: Arc<dyn CostModel>,
    config: Config<16>,
    goal: Goal<16>,
    /// Unit vector of the last move in the ring's present frame; zero before the first.
    course: Point,
    /// Decisions for which each heading stays inhibited.
    inhibited: [u8; 16],
    search: Search,
}

impl ModelPolicy {
    /// Pursues `goal` by `model`; `course` is the direction of the last random move.
    #[must_use]
    pub fn new(
        model: Arc<dyn CostModel>,
        config: &Config<16>,
        goal: Goal<16>,
        course: Point,
    ) -> Self {
        Self {
            model,
            config: config.clone(),
            goal,
            course: unit(course),
            inhibited: [0; 16],
            search: Search::default(),
        }
    }

    /// What the last motion tells: the course, and a heading to inhibit.
    fn take_last(&mut self, perceived: &Perception) {
        for left in &mut self.inhibited {
            *left = left.saturating_sub(1);
        }
        let Some(last) = perceived.last else { return };
        let wanted_m = last.wanted.length();
        if wanted_m > 1e-6 {
            self.course = unit(last.wanted);
        }
        if last.moved.length() < wanted_m / 2.0 {
            let heading = nearest_heading(last.wanted);
            self.inhibited[heading] = self.config.planning.inhibition;
        }
        let turned = f64::from(perceived.turned.as_signed_turns()) * PI / 32_768.0;
        self.course = self.course.turned_back(Point::unit(turned));
    }

    /// The goal of this decision: that of obstacle avoidance while the robot wanders.
    fn current_goal(&mut self, situation: &Values) -> Goal<16> {
        let is_place = self.goal.progress_q16 == 0 && self.goal.frame == GoalFrame::Ring;
        let Some(wander) = self.config.planning.wander.filter(|_| is_place) else {
            return self.goal;
        };
        let cost = GoalCost::new(&self.goal, 0, Point::default()).of(situation);
        let weights = self.goal.components.iter().map(|c| f64::from(c.weight));
        if cost <= weights.sum::<f64>() * number(self.goal.tolerance).powi(2) {
            self.search = Search::default();
        } else if self.search.is_stuck(cost, wander) {
            self.course = self.course.turned(axis(NEXT_COURSE));
        }
        if self.search.left > 0 {
            Goal::avoiding(&self.config)
        } else {
            self.goal
        }
    }

    /// The place of the ring towards which a goal in the frame of travel fits the situation best.
    fn travel_place(&self, goal: &Goal<16>, situation: &Values) -> usize {
        if goal.frame == GoalFrame::Ring {
            return 0;
        }
        let hold = q16(goal.heading_hold_q16);
        let score = |place: usize| {
            let cost = GoalCost::new(goal, place, Point::default()).of(situation);
            cost - hold * axis(place).dot(self.course)
        };
        least((0..16).map(score)).map_or(0, |(place, _)| place)
    }

    /// The move for a situation, in units of the longest step.
    pub fn choose(&mut self, situation: &Values) -> Point {
        let goal = self.current_goal(situation);
        let place = self.travel_place(&goal, situation);
        let preferred = match goal.frame {
            GoalFrame::Ring => self.course,
            GoalFrame::Travel => axis(place),
        };
        let cost = GoalCost::new(&goal, place, preferred);
        let headings: Vec<_> = (0..16).filter(|k| self.inhibited[*k] == 0).collect();
        let moves: Vec<_> = headings.iter().map(|k| axis(*k)).collect();
        let costs = self.model.costs(situation, &moves, &cost);
        let Some((best, mut lowest)) = least(costs.into_iter()) else {
            return Point::default();
        };
        let (heading, mut share) = (moves[best], 1.0);
        if goal.progress_q16 == 0 {
            let shorter = SHORTER.map(|share| heading * share);
            let costs = self.model.costs(situation, &shorter, &cost);
            for (shorter, cost) in SHORTER.into_iter().zip(costs) {
                if cost <= lowest {
                    (share, lowest) = (shorter, cost);
                }
            }
        }
        heading * share
    }
}

impl Policy for ModelPolicy {
    fn decide(&mut self, perceived: &Perception) -> Point {
        self.take_last(perceived);
        let encoding = self.config.encoding;
        let situation = perceived.ranges.map(|range| number(encoding.value(range)));
        self.choose(&situation) * STEP_M
    }
}

/// The index of the least value and the value, the lowest index on ties.
fn least(values: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    values.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The heading nearest to a direction.
fn nearest_heading(direction: Point) -> usize {
    least((0..16).map(|k| -axis(k).dot(direction))).map_or(0, |(heading, _)| heading)
}

fn unit(vector: Point) -> Point {
    let length = vector.length();
    if length > 1e-9 {
        vector * (1.0 / length)
    } else {
        Point::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::change_of;
    use super::*;
    use amp::action_map::ActionMap;
    use amp::fixed::{Mask, Weight};
    use amp::goal::Side;
    use amp::planner::Planner;
    use amp::som::{Grid, Som};
    use amp::units::{Displacement, Range};
    use arena::noise::Noise;

    /// Values change by cosines.
    struct Cosines;

    impl CostModel for Cosines {
        fn costs(&self, situation: &Values, moves: &[Point], goal: &GoalCost) -> Vec<f64> {
            let cost = |moved: &Point| {
                let change = change_of(*moved);
                goal.of(&std::array::from_fn(|i| situation[i] + change[i])) - goal.progress(*moved)
            };
            moves.iter().map(cost).collect()
        }

        fn numbers(&self) -> usize {
            0
        }
    }

    /// An action map that says the same.
    fn map() -> ActionMap<16, 16> {
        let weight = |value: f64| Weight::from_num(value);
        ActionMap::new(
            Grid::rectangle(4, 4),
            std::array::from_fn(|k| change_of(axis(k)).map(weight)),
            std::array::from_fn(|k| [weight(axis(k).x), weight(axis(k).y)]),
        )
    }

    /// Shares of decisions that equal those of the controller's planner, by goal.
    #[test]
    fn with_the_same_model_it_decides_as_the_controllers_planner() {
        let config = Config::recommended();
        let (actions, situations) = (map(), Som::zeroed(Grid::rectangle(4, 4)));
        let mut noise = Noise::new(7);
        let place: [Weight; 16] = std::array::from_fn(|_| Weight::from_num(noise.uniform()));
        let goals = [
            Goal::avoiding(&config),
            Goal::wall(Side::Right, Range::from_mm(600), &config),
            Goal::perceived(&place),
        ];
        for goal in goals {
            let mut same = 0;
            for _ in 0..500 {
                let mut value = || Weight::from_num(noise.uniform_in(0.0, 0.99));
                let situation = std::array::from_fn(|_| value());
                let heading = noise.index(16);
                let course = Displacement {
                    dx_mm: libm::round(axis(heading).x * 250.0) as i16,
                    dy_mm: libm::round(axis(heading).y * 250.0) as i16,
                };
                let planner = Planner {
                    config: &config,
                    situations: &situations,
                    actions: &actions,
                    enabled: Mask::ALL,
                    allowed: Mask::ALL,
                    current: None,
                    course,
                    cut: false,
                };
                let theirs = planner.plan(&situation, &goal).action;
                let model = Arc::new(Cosines);
                let mut policy = ModelPolicy::new(model, &config, goal, axis(heading));
                let ours = policy.choose(&situation.map(number)) * 250.0;
                let theirs = Point::new(f64::from(theirs.dx_mm), f64::from(theirs.dy_mm));
                same += u32::from(ours.distance(theirs) < 2.0);
            }
            assert!(same >= 490, "{same} of 500");
        }
    }

    #[test]
    fn a_heading_that_was_cut_is_inhibited() {
        let config = Config::recommended();
        let goal = Goal::avoiding(&config);
        let mut policy = ModelPolicy::new(Arc::new(Cosines), &config, goal, axis(0));
        assert!(policy.choose(&[0.5; 16]).distance(axis(0)) < 1e-9);
        policy.inhibited[0] = 1;
        assert!(policy.choose(&[0.5; 16]).distance(axis(0)) > 0.3);
    }

    #[test]
    fn a_place_that_comes_no_nearer_makes_it_wander() {
        let config = Config::recommended();
        let place = Goal::perceived(&[Weight::from_num(0.9); 16]);
        let mut policy = ModelPolicy::new(Arc::new(Cosines), &config, place, axis(0));
        let still = [0.2; 16];
        let patience = config.planning.wander.map_or(0, |wander| wander.patience);
        for _ in 0..=patience {
            assert_eq!(policy.current_goal(&still), place);
        }
        assert_eq!(policy.current_goal(&still), Goal::avoiding(&config));
    }
}
