//! Rivals: one-step control and model-predictive control by a linear model.
//!
//! Δ = A s + B a + c by ridge regression (A. Hoerl, R. Kennard, *Technometrics* 12, 1970), and
//! control by receding horizon (J. B. Rawlings, D. Q. Mayne, *Model Predictive Control*, 2009,
//! chapter 1): the best of a set of move sequences is found, and its first move is made.
//!
//! A sequence is a first move, and then one heading that is held, near that of the first move.

use super::cholesky::Cholesky;
use super::goal_cost::GoalCost;
use super::policy::CostModel;
use super::transition::{INPUTS, Transition, augmented, input};
use crate::baselines::learning::Values;
use arena::world::Point;
use sim::ring_pilot::axis;

/// Moves in a sequence: of two and four, the better in rooms that no table uses.
pub const HORIZON: usize = 2;
/// Ring steps from the first heading to the second.
const TURNS: [usize; 5] = [14, 15, 0, 1, 2];
/// Ridge: adds this to the diagonal of the normal equations.
const RIDGE: f64 = 0.1;
/// Coefficients of a line: the input's, and a constant.
const COEFFICIENTS: usize = INPUTS + 1;

/// The linear model.
#[derive(Debug, Clone)]
pub struct LinearMpc {
    /// By coefficient, for each transducer.
    columns: [Values; COEFFICIENTS],
    horizon: usize,
}

impl LinearMpc {
    /// Fits the model and looks `horizon` moves ahead.
    #[must_use]
    pub fn fit(transitions: &[Transition], symmetric: bool, horizon: usize) -> Self {
        let rows = augmented(transitions, symmetric);
        let lines: [_; 16] = std::array::from_fn(|sensor| ridge(&rows, sensor));
        Self {
            columns: std::array::from_fn(|i| lines.map(|line| line[i])),
            horizon: horizon.max(1),
        }
    }

    /// The change of a situation by a move.
    #[must_use]
    pub fn change(&self, situation: &Values, moved: Point) -> Values {
        let mut change = [0.0; 16];
        let input = with_constant(situation, moved);
        for (column, input) in self.columns.iter().zip(input) {
            for (change, factor) in change.iter_mut().zip(column) {
                *change += factor * input;
            }
        }
        change
    }

    /// The situation after a move.
    fn after(&self, situation: &Values, moved: Point) -> Values {
        let change = self.change(situation, moved);
        std::array::from_fn(|i| (situation[i] + change[i]).clamp(0.0, 1.0))
    }

    /// The cost of going on with a move to the end of the horizon.
    fn cost_to_go(&self, situation: &Values, moved: Point, goal: &GoalCost) -> f64 {
        let (mut now, mut cost) = (*situation, 0.0);
        for _ in 1..self.horizon {
            now = self.after(&now, moved);
            cost += goal.of(&now) - goal.progress(moved);
        }
        cost
    }
}

impl CostModel for LinearMpc {
    fn costs(&self, situation: &Values, moves: &[Point], goal: &GoalCost) -> Vec<f64> {
        let best = |first: &Point| {
            let next = self.after(situation, *first);
            let second = TURNS.map(|turn| first.turned(axis(turn)));
            let costs = second.map(|second| self.cost_to_go(&next, second, goal));
            let to_go = costs.into_iter().fold(f64::INFINITY, f64::min);
            (goal.of(&next) - goal.progress(*first) + to_go) / self.horizon as f64
        };
        moves.iter().map(best).collect()
    }

    fn numbers(&self) -> usize {
        16 * COEFFICIENTS
    }
}

fn with_constant(situation: &Values, moved: Point) -> [f64; COEFFICIENTS] {
    let input = input(situation, moved);
    std::array::from_fn(|i| input.get(i).copied().unwrap_or(1.0))
}

/// The line of one transducer.
fn ridge(rows: &[Transition], sensor: usize) -> [f64; COEFFICIENTS] {
    let mut products = [[0.0; COEFFICIENTS]; COEFFICIENTS];
    let mut sums = [[0.0]; COEFFICIENTS];
    for row in rows.iter().filter(|row| row.known[sensor]) {
        let input = with_constant(&row.before, row.moved);
        for (i, value) in input.iter().enumerate() {
            for (product, other) in products[i].iter_mut().zip(&input[..=i]) {
                *product += value * other;
            }
            sums[i][0] += value * row.change[sensor];
        }
    }
    let matrix = |i: usize, j: usize| products[i][j] + if i == j { RIDGE } else { 0.0 };
    let solved = Cholesky::of(COEFFICIENTS, matrix).map(|factor| factor.solve(&sums));
    let solved = solved.unwrap_or_default();
    std::array::from_fn(|i| solved.get(i).map_or(0.0, |[factor]| *factor))
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::{change_of, cosines};
    use super::*;
    use amp::config::Config;
    use amp::goal::Goal;

    #[test]
    fn it_fits_a_linear_world() {
        let model = LinearMpc::fit(&cosines(300, 1), false, 1);
        let moved = Point::unit(0.7);
        let found = model.change(&[0.5; 16], moved);
        for (found, exact) in found.into_iter().zip(change_of(moved)) {
            assert!((found - exact).abs() < 5e-4, "{found} {exact}");
        }
    }

    #[test]
    fn unknown_changes_are_not_learned() {
        let mut transitions = cosines(300, 2);
        for wrong in transitions.iter_mut().step_by(2) {
            (wrong.change[3], wrong.known[3]) = (1.0, false);
        }
        let found = LinearMpc::fit(&transitions, false, 1).change(&[0.5; 16], axis(3));
        assert!((found[3] - change_of(axis(3))[3]).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn a_longer_horizon_turns_away_earlier() {
        let config = Config::recommended();
        let goal = Goal::avoiding(&config);
        let cost = GoalCost::new(&goal, 0, axis(0));
        // A wall ahead: 0.6 m are a value of 0.867, and each step adds 0.055.
        let mut situation = [0.2; 16];
        situation[0] = 0.80;
        let chosen = |horizon: usize| {
            let model = LinearMpc::fit(&cosines(300, 1), true, horizon);
            let moves: [Point; 16] = std::array::from_fn(axis);
            let costs = model.costs(&situation, &moves, &cost);
            (0..16).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))
        };
        assert_eq!(chosen(1), Some(0));
        assert_ne!(chosen(HORIZON), Some(0));
    }
}
