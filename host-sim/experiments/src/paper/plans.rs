//! Outcome of the plans of one episode: the algorithm of section 2.5, decision by decision.

use super::observer::{ObservedDecision, change, cosine, length};
use amp::fixed::{Mask, Weight, squared_distance};
use amp::goal::Goal;
use amp::planner::Why;
use amp::som::Som;
use sim::pilot::SimState;

/// Counts over decisions; counts of several episodes can be added.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Plans {
    /// Decisions taken while the goal was not met.
    pub unmet: u32,
    /// Of `unmet`: the subgoal was a neighbor.
    pub neighbor: u32,
    /// Of `unmet`: the present neuron was the goal neuron, or its code vector meets the goal too.
    pub at_goal_neuron: u32,
    /// Of `unmet`: neither, and no neighbor was nearer to the goal.
    pub no_nearer: u32,
    /// Of `neighbor`: its code vector was nearer to the goal, too.
    pub nearer_neighbor: u32,
    /// Of `neighbor`: that neuron was the best-matching unit after the move.
    pub at_aim: u32,
    /// Moves with a wanted change.
    pub moves: u32,
    /// Of `moves`: the situation came nearer to the wanted one, over the transducers with a wanted
    /// change.
    pub nearer: u32,
    /// Of `moves`: those values changed in the wanted direction (cosine above 0).
    pub along: u32,
    /// Moves that changed one of those transducers.
    pub changes: u32,
    /// Sum of the cosines between wanted and measured change, over `changes`.
    pub agreement: f64,
    /// Periods without the goal that ended with the goal.
    pub reached: u32,
    /// Number of decisions in those periods.
    pub reached_in: u32,
    /// Of `reached`: periods of at most ten decisions.
    pub reached_soon: u32,
    /// Periods that the end of the episode cut off.
    pub unfinished: u32,
}

impl Plans {
    /// Counts the plans of one episode.
    #[must_use]
    pub fn of(observed: &[ObservedDecision]) -> Self {
        let mut plans = Self::default();
        let mut stretch = 0;
        for (i, now) in observed.iter().enumerate() {
            if now.plan.at_goal {
                plans.end(&mut stretch);
                continue;
            }
            stretch += 1;
            plans.unmet += 1;
            let neighbor = now.plan.why == Why::Neighbor;
            plans.neighbor += u32::from(neighbor);
            plans.nearer_neighbor += u32::from(neighbor && now.aim_is_nearer);
            let there = now.plan.why == Why::GoalNeuron || now.neuron_meets_goal;
            plans.at_goal_neuron += u32::from(!neighbor && there);
            let lost = now.plan.why == Why::NoNearerNeighbor;
            plans.no_nearer += u32::from(lost && !there);
            if let Some(next) = observed.get(i + 1) {
                plans.follow(now, next);
            }
        }
        plans.unfinished += u32::from(stretch > 0);
        plans
    }

    /// The goal is met again.
    fn end(&mut self, stretch: &mut u32) {
        if *stretch > 0 {
            self.reached += 1;
            self.reached_in += *stretch;
            self.reached_soon += u32::from(*stretch <= 10);
            *stretch = 0;
        }
    }

    fn follow(&mut self, now: &ObservedDecision, next: &ObservedDecision) {
        if now.plan.why == Why::Neighbor {
            let there = next.plan.current_neuron == now.plan.subgoal_neuron;
            self.at_aim += u32::from(there);
        }
        let changed = change(&next.situation, &now.situation);
        let (mut wanted, mut measured) = (Vec::new(), Vec::new());
        for (want, change) in now.plan.wanted.iter().zip(changed) {
            if *want != Weight::ZERO {
                wanted.push(want.to_num::<f64>());
                measured.push(change);
            }
        }
        if wanted.is_empty() {
            return;
        }
        let left: Vec<f64> = wanted.iter().zip(&measured).map(|(w, m)| w - m).collect();
        self.moves += 1;
        self.nearer += u32::from(length(&left) < length(&wanted));
        if let Some(cosine) = cosine(&wanted, &measured) {
            self.changes += 1;
            self.along += u32::from(cosine > 0.0);
            self.agreement += cosine;
        }
    }

    /// The sum of both.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            unmet: self.unmet + other.unmet,
            neighbor: self.neighbor + other.neighbor,
            at_goal_neuron: self.at_goal_neuron + other.at_goal_neuron,
            no_nearer: self.no_nearer + other.no_nearer,
            nearer_neighbor: self.nearer_neighbor + other.nearer_neighbor,
            at_aim: self.at_aim + other.at_aim,
            moves: self.moves + other.moves,
            nearer: self.nearer + other.nearer,
            along: self.along + other.along,
            changes: self.changes + other.changes,
            agreement: self.agreement + other.agreement,
            reached: self.reached + other.reached,
            reached_in: self.reached_in + other.reached_in,
            reached_soon: self.reached_soon + other.reached_soon,
            unfinished: self.unfinished + other.unfinished,
        }
    }
}

/// Paths over neighbors to a goal, on a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GoalPaths {
    /// Neurons that do not represent the goal.
    pub neurons: u32,
    /// Of `neurons`: a direct neighbor's code vector is nearer to the goal.
    pub with_nearer: u32,
    /// Of `neurons`: the neighbor with the fewest grid steps to the goal neuron is nearer in its
    /// code vector.
    pub by_hops: u32,
    /// Ordered pairs of neurons: start and end.
    pub pairs: u32,
    /// Of `pairs`: a path leads over neighbors, each nearer to the end's code vector.
    pub joined: u32,
}

impl GoalPaths {
    /// Counts the paths of a situation map to a goal.
    #[must_use]
    pub fn of(state: &SimState, goal: &Goal<16>) -> Self {
        let map: &Som<16, 16> = state.situations();
        let grid = map.grid();
        let away: Vec<i64> = (0..grid.len())
            .map(|k| goal.distance(&map.code_vector(k), Mask::ALL))
            .collect();
        let goal_neuron = (0..away.len()).min_by_key(|&k| away[k]).unwrap_or(0);
        let mut goal_paths = Self::default();
        for k in (0..away.len()).filter(|&k| k != goal_neuron && away[k] > 0) {
            goal_paths.neurons += 1;
            let nearest = grid.neighbors(k).map(|n| away[n]).min();
            goal_paths.with_nearer += u32::from(nearest.is_some_and(|n| n < away[k]));
            let by_hops = grid
                .neighbors(k)
                .min_by_key(|&n| (grid.hops(n, goal_neuron), away[n], n));
            goal_paths.by_hops += u32::from(by_hops.is_some_and(|n| away[n] < away[k]));
        }
        for end in 0..away.len() {
            let starts = (0..away.len()).filter(|&start| start != end);
            goal_paths.pairs += away.len() as u32 - 1;
            goal_paths.joined += starts.filter(|&start| leads(map, start, end)).count() as u32;
        }
        goal_paths
    }

    /// The sum of both.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            neurons: self.neurons + other.neurons,
            with_nearer: self.with_nearer + other.with_nearer,
            by_hops: self.by_hops + other.by_hops,
            pairs: self.pairs + other.pairs,
            joined: self.joined + other.joined,
        }
    }
}

/// Whether greedy steps lead from `start` to `end`: each to the neighbor whose code vector is
/// nearest to that of `end`.
fn leads(map: &Som<16, 16>, start: usize, end: usize) -> bool {
    let code = map.code();
    let away = |k: usize| match (code.get(k), code.get(end)) {
        (Some(a), Some(b)) => squared_distance(a, b, Mask::ALL),
        _ => u64::MAX,
    };
    let mut at = start;
    while at != end {
        let nearest = map.grid().neighbors(at).min_by_key(|&n| (away(n), n));
        match nearest.filter(|&n| away(n) < away(at)) {
            Some(next) => at = next,
            None => return false,
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::planner::Plan;
    use amp::units::Displacement;

    fn observed(value: f64, at_goal: bool, why: Why) -> ObservedDecision {
        let all = |value: f64| [Weight::from_num(value); 16];
        ObservedDecision {
            situation: all(value),
            plan: Plan {
                goal_neuron: 0,
                current_neuron: 3,
                subgoal_neuron: 2,
                wanted: all(-0.5),
                action_neuron: 0,
                at_goal,
                recalled: true,
                action: Displacement::ZERO,
                why,
            },
            aim: all(0.0),
            aim_is_nearer: true,
            neuron_meets_goal: false,
        }
    }

    #[test]
    fn stretches_and_aims_are_counted() {
        let episode = [
            observed(0.75, false, Why::Neighbor),
            observed(0.5, false, Why::NoNearerNeighbor),
            observed(0.0, true, Why::KeepCourse),
            observed(0.25, false, Why::Neighbor),
            observed(0.5, false, Why::GoalNeuron),
        ];
        let plans = Plans::of(&episode);
        assert_eq!(
            (
                plans.unmet,
                plans.neighbor,
                plans.no_nearer,
                plans.at_goal_neuron
            ),
            (4, 2, 1, 1)
        );
        assert_eq!((plans.nearer_neighbor, plans.at_aim), (2, 0));
        assert_eq!(
            (
                plans.reached,
                plans.reached_in,
                plans.reached_soon,
                plans.unfinished
            ),
            (1, 2, 1, 1)
        );
        // Two moves in the wanted direction, one against it.
        assert_eq!(
            (plans.moves, plans.nearer, plans.along, plans.changes),
            (3, 2, 2, 3)
        );
        assert!((plans.agreement - 1.0).abs() < 1e-9);
    }
}
