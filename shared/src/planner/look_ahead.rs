//! One step ahead in the action map: which action leads nearest to the goal?
//!
//! The action map holds pairs of (change of situation, action). Probed with an action it answers with a change, as an
//! associative memory does with any part of its content; the present situation plus that change is the situation to come.
//! The action whose situation to come deviates least from the goal is taken.
//!
//! *The change of a direction* ([`Forward`]) is what all neurons together say of it: the linear map from action to change
//! that fits the neurons best (least squares, [`Recall by direction`](crate::action_map::Recall::Direction) turned round).
//! One neuron alone knows its own direction only, and a short action, stretched to a whole step, magnifies its noise.
//!
//! *A goal in the frame of travel* ("a wall to my right") depends on where the robot goes. First the *way* is chosen: the
//! place of the ring towards which the goal fits the present situation best, with a preference for the course. Seen along
//! that way the goal stays the same for every candidate: the look-ahead keeps the distance, the way keeps the robot going.
//!
//! Cost for 16 transducers and neurons: about 500 products for the linear map, 256 for the predictions, 256 comparisons with
//! the goal, and 256 more for the way of a goal in the frame of travel.

use super::{Plan, Planner, Why, difference};
use crate::action_map::{ActionCode, ActionMap};
use crate::config::Choice;
use crate::fixed::{Mask, Weight, coarse, unit_weight};
use crate::goal::{Frame, Goal};
use crate::scan::Situation;
use crate::som::kernels;
use crate::units::{Direction, Displacement};

/// Shares of a step that are tried along the best direction to a place, in 1/4; the whole step has been tried.
const SHORTER_Q2: [i32; 4] = [3, 2, 1, 0];

/// The linear map from displacements to changes of situation, in units of 2⁻¹³ per longest step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Forward<const SENSORS: usize> {
    along_x: [i32; SENSORS],
    along_y: [i32; SENSORS],
}

impl<const SENSORS: usize> Forward<SENSORS> {
    /// The map that fits an action map's neurons best; no change at all where their actions do not span the plane.
    #[must_use]
    pub fn of<const NEURONS: usize>(
        actions: &ActionMap<NEURONS, SENSORS>,
        code: ActionCode,
        step_mm: u16,
    ) -> Self {
        let (mut along_x, mut along_y) = ([0_i64; SENSORS], [0_i64; SENSORS]);
        let (mut xx, mut xy, mut yy) = (0_i64, 0_i64, 0_i64);
        for (action, change) in actions
            .actions()
            .code()
            .iter()
            .zip(actions.changes().code())
        {
            let [x, y] = plane(code, action.map(coarse), step_mm);
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
            for ((sum_x, sum_y), change) in along_x.iter_mut().zip(&mut along_y).zip(change) {
                let change = i64::from(coarse(*change).to_bits());
                *sum_x = sum_x.wrapping_add(x.wrapping_mul(change));
                *sum_y = sum_y.wrapping_add(y.wrapping_mul(change));
            }
        }
        let solve = Solution::of(xx, xy, yy);
        let mut forward = Self {
            along_x: [0; SENSORS],
            along_y: [0; SENSORS],
        };
        let sums = along_x.iter().zip(&along_y);
        let places = forward.along_x.iter_mut().zip(&mut forward.along_y);
        for ((x, y), (sum_x, sum_y)) in places.zip(sums) {
            (*x, *y) = solve.apply(*sum_x, *sum_y);
        }
        forward
    }

    /// The values (2⁻¹³, from 0 on but not limited to 1) after a displacement given as shares of the longest step, Q14.
    #[must_use]
    pub fn after(&self, situation: &Situation<SENSORS>, share: Direction) -> [i32; SENSORS] {
        let mut values = [0; SENSORS];
        let slopes = self.along_x.iter().zip(&self.along_y);
        for ((value, now), (x, y)) in values.iter_mut().zip(situation).zip(slopes) {
            *value = share
                .along(*x, *y)
                .wrapping_add(i32::from(now.to_bits()))
                .max(0);
        }
        values
    }
}

/// An action as a vector in units of 2⁻¹³ of the longest step.
fn plane(code: ActionCode, action: [Weight; 2], step_mm: u16) -> [i64; 2] {
    let vector = match code {
        ActionCode::Displacement => action,
        ActionCode::TurnStep => {
            ActionCode::Displacement.encode(code.decode(action, step_mm), step_mm)
        }
    };
    vector.map(|part| i64::from(part.to_bits()))
}

/// The inverse of a symmetric 2 × 2 matrix, scaled so that one 32-bit division per value is left.
struct Solution {
    xx: i64,
    xy: i64,
    yy: i64,
    determinant: i32,
    shift: u32,
}

impl Solution {
    /// Sums of squares of up to 1024 actions in units of 2⁻²⁶.
    fn of(xx: i64, xy: i64, yy: i64) -> Self {
        // 2⁻¹³ is fine enough, and the products stay below 2⁴⁸.
        let (xx, xy, yy) = (xx >> 13, xy >> 13, yy >> 13);
        let determinant = (xx * yy - xy * xy).max(0);
        let shift = (64 - determinant.leading_zeros()).saturating_sub(15);
        Self {
            xx,
            xy,
            yy,
            determinant: (determinant >> shift) as i32,
            shift,
        }
    }

    /// Both slopes from both sums of products (2⁻²⁶), each within ±2 per step.
    fn apply(&self, sum_x: i64, sum_y: i64) -> (i32, i32) {
        let (sum_x, sum_y) = (sum_x >> 10, sum_y >> 10);
        let slope = |numerator: i64| {
            let scaled = numerator.wrapping_shl(10).wrapping_shr(self.shift);
            let scaled = scaled.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
            let slope = scaled.checked_div(self.determinant).unwrap_or(0);
            slope.clamp(-(1 << 14), 1 << 14)
        };
        (
            slope(
                self.yy
                    .wrapping_mul(sum_x)
                    .wrapping_sub(self.xy.wrapping_mul(sum_y)),
            ),
            slope(
                self.xx
                    .wrapping_mul(sum_y)
                    .wrapping_sub(self.xy.wrapping_mul(sum_x)),
            ),
        )
    }
}

/// An action and what it leads to.
#[derive(Debug, Clone, Copy)]
struct Candidate<const SENSORS: usize> {
    /// Unit vector, in the ring's frame.
    direction: Direction,
    /// Share of the longest step, in 1/4.
    share_q2: i32,
    values: [i32; SENSORS],
    score: i64,
}

/// A goal as it is looked at while a decision is taken.
struct Aim<'a, const SENSORS: usize> {
    goal: &'a Goal<SENSORS>,
    /// Place of the ring to which it is turned.
    place: usize,
    /// Direction in which going on is preferred; zero = none.
    way: Direction,
    mask: Mask,
}

impl<const SENSORS: usize> Aim<'_, SENSORS> {
    fn score(&self, values: &[i32; SENSORS], direction: Direction, share_q2: i32) -> i64 {
        let going = weighted(self.goal.going_q16, cosine_q14(direction, self.way));
        self.goal
            .deviation(values, self.place, self.mask)
            .wrapping_sub(going.wrapping_mul(i64::from(share_q2)) >> 2)
    }
}

/// A weight in Q16 times a cosine in Q14, in units of 2⁻²⁶.
fn weighted(weight_q16: u16, cosine_q14: i32) -> i64 {
    i64::from(weight_q16).wrapping_mul(i64::from(cosine_q14)) >> 4
}

fn cosine_q14(a: Direction, b: Direction) -> i32 {
    a.along(i32::from(b.x_q14), i32::from(b.y_q14))
}

/// The unit vector along a displacement; zero for none.
fn unit(displacement: Displacement) -> Direction {
    let length = i32::from(displacement.length_mm());
    let part = |mm: i16| (i32::from(mm) << 14).checked_div(length).unwrap_or(0);
    Direction {
        x_q14: part(displacement.dx_mm).clamp(-(1 << 14), 1 << 14) as i16,
        y_q14: part(displacement.dy_mm).clamp(-(1 << 14), 1 << 14) as i16,
    }
}

/// A part of a unit vector, in 1/4.
fn part(direction: Direction, share_q2: i32) -> Direction {
    let scaled = |q14: i16| (i32::from(q14).wrapping_mul(share_q2) >> 2) as i16;
    Direction {
        x_q14: scaled(direction.x_q14),
        y_q14: scaled(direction.y_q14),
    }
}

impl<const SENSORS: usize, const NEURONS: usize> Planner<'_, SENSORS, NEURONS> {
    /// Place of the ring towards which a goal in the frame of travel fits the situation best, the course preferred; 0
    /// for other goals.
    pub fn way(&self, situation: &Situation<SENSORS>, goal: &Goal<SENSORS>) -> usize {
        if goal.frame == Frame::Ring || !self.config.robot.symmetric {
            return 0;
        }
        let course = unit(self.course);
        let values = situation.map(|value| i32::from(value.to_bits()));
        let directions = self.config.robot.directions.iter().enumerate();
        let deviations = directions.map(|(place, direction)| {
            let steady = weighted(goal.steady_q16, cosine_q14(*direction, course));
            goal.deviation(&values, place, self.config.believed) - steady
        });
        let best = deviations
            .enumerate()
            .min_by_key(|(_, deviation)| *deviation);
        best.map_or(0, |(place, _)| place)
    }

    /// The action that leads nearest to the goal on the way towards `place`.
    pub(super) fn look_ahead(
        &self,
        situation: &Situation<SENSORS>,
        goal: &Goal<SENSORS>,
        place: usize,
    ) -> Plan<SENSORS> {
        let config = self.config;
        let mask = config.believed;
        let turned = goal.towards(place);
        let travels = goal.frame == Frame::Travel && config.robot.symmetric;
        let ahead = config.robot.directions.get(place).copied();
        let aim = Aim {
            goal,
            place,
            way: ahead.filter(|_| travels).unwrap_or(unit(self.course)),
            mask,
        };
        let forward = Forward::of(self.actions, config.action_code, config.robot.step_mm);
        let best = self.best(situation, &aim, &forward);
        let goal_scores = self.goal_scores(&turned);
        let now = goal.deviation(&situation.map(|v| i32::from(v.to_bits())), place, mask);
        let to_come = best.values.map(unit_weight);
        let mut plan = Plan {
            goal_neuron: kernels::least(&goal_scores) as u8,
            current_neuron: self.situations.winner(situation, mask) as u8,
            intermediate_neuron: self.situations.winner(&to_come, mask) as u8,
            wanted: difference(&to_come, situation),
            action_neuron: self.neuron_of(best.direction) as u8,
            at_goal: goal.is_met_by(now, mask)
                || turned.holds(situation, mask, config.planning.tolerance),
            recalled: true,
            action: Displacement::ZERO,
            why: Why::Stay,
        };
        if best.share_q2 > 0 {
            let step = i32::from(config.robot.step_mm);
            let (x, y) = part(best.direction, best.share_q2).times(step);
            plan.action = Displacement::saturating(x, y);
            plan.why = Why::LookAhead;
        }
        plan
    }

    /// The best candidate that is not inhibited; to a place also a shorter one, or none.
    fn best(
        &self,
        situation: &Situation<SENSORS>,
        aim: &Aim<'_, SENSORS>,
        forward: &Forward<SENSORS>,
    ) -> Candidate<SENSORS> {
        let try_out = |direction: Direction, share_q2: i32| {
            let values = forward.after(situation, part(direction, share_q2));
            Candidate {
                direction,
                share_q2,
                score: aim.score(&values, direction, share_q2),
                values,
            }
        };
        let mut best: Option<Candidate<SENSORS>> = None;
        let mut take = |candidate: Candidate<SENSORS>| {
            if best.is_none_or(|best| candidate.score < best.score) {
                best = Some(candidate);
            }
        };
        match self.config.planning.choice {
            Choice::Neurons => (0..NEURONS)
                .filter(|neuron| self.allowed.contains(*neuron))
                .filter_map(|neuron| self.own_candidate(situation, aim, neuron))
                .for_each(&mut take),
            Choice::Recall | Choice::Headings => self
                .config
                .robot
                .directions
                .iter()
                .filter(|direction| self.is_allowed(**direction))
                .for_each(|direction| take(try_out(*direction, 4))),
        }
        // Where every action is inhibited the robot waits for the first to come back.
        let mut best = best.unwrap_or_else(|| try_out(Direction::default(), 0));
        if aim.goal.going_q16 == 0 {
            for share_q2 in SHORTER_Q2 {
                let shorter = try_out(best.direction, share_q2);
                if shorter.score <= best.score {
                    best = shorter;
                }
            }
        }
        best
    }

    /// A neuron's own action, brought to a whole step; none for an action too short to have a direction.
    fn own_candidate(
        &self,
        situation: &Situation<SENSORS>,
        aim: &Aim<'_, SENSORS>,
        neuron: usize,
    ) -> Option<Candidate<SENSORS>> {
        let step = i32::from(self.config.robot.step_mm);
        let code = self.actions.actions().code_vector(neuron);
        let action = self
            .config
            .action_code
            .decode(code, self.config.robot.step_mm);
        let length = i32::from(action.length_mm());
        if length < step / 4 {
            return None;
        }
        let direction = unit(action);
        let mut values = [0; SENSORS];
        let change = self.actions.changes().code_vector(neuron);
        for ((value, now), change) in values.iter_mut().zip(situation).zip(&change) {
            let stretched = i32::from(change.to_bits()).wrapping_mul(step) / length.max(1);
            *value = stretched.wrapping_add(i32::from(now.to_bits())).max(0);
        }
        Some(Candidate {
            direction,
            share_q2: 4,
            score: aim.score(&values, direction, 4),
            values,
        })
    }

    /// The neuron whose action goes farthest in a direction: the one that answers for it.
    fn neuron_of(&self, direction: Direction) -> usize {
        let code = [direction.x_q14 >> 1, direction.y_q14 >> 1].map(Weight::from_bits);
        let along = self.actions.actions().projections(&code, Mask::ALL);
        kernels::greatest(&along, Mask::ALL)
    }

    fn is_allowed(&self, direction: Direction) -> bool {
        self.allowed == Mask::ALL || self.allowed.contains(self.neuron_of(direction))
    }
}
