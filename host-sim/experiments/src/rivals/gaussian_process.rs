//! Rival: one-step control by Gaussian processes.
//!
//! As PILCO's model (M. Deisenroth, C. Rasmussen, *Proc. ICML*, 2011) the change of each value is a
//! Gaussian process over situation and move with a squared-exponential kernel; a move's cost is the
//! expectation over the predicted normal distribution. Regression after C. Rasmussen, C. Williams,
//! *Gaussian Processes for Machine Learning*, 2006, chapters 2 and 5.
//!
//! All 16 changes share one kernel with a length for situations, one for moves, and the ratio of
//! noise to signal; the lengths and the ratio with the greatest marginal likelihood are searched
//! one after the other. The prior mean is linear in the move (section 2.7), by least squares; a
//! change that is unknown equals that mean.

use super::cholesky::Cholesky;
use super::goal_cost::GoalCost;
use super::policy::CostModel;
use super::transition::{Transition, augmented};
use crate::baselines::learning::Values;
use arena::noise::Noise;
use arena::world::Point;
use sim::statistics::PlaneFit;

/// Most points of the process; of more a random subset is taken.
pub const MOST_POINTS: usize = 100;
/// Most points for the search of the hyperparameters.
const SEARCH_POINTS: usize = 64;
/// Values that are tried of each hyperparameter.
const LENGTHS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];
const NOISE_RATIOS: [f64; 4] = [1e-2, 1e-1, 1.0, 10.0];
/// Rounds of the search.
const ROUNDS: usize = 2;

/// Hyperparameters of the kernel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kernel {
    /// Length for situations, in values.
    situation: f64,
    /// Length for moves, in longest steps.
    moved: f64,
    /// Variance of the noise, in units of the signal's.
    noise: f64,
}

impl Kernel {
    /// Covariance of two situations, in units of the signal's variance.
    fn situations(&self, a: &Values, b: &Values) -> f64 {
        let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
        libm::exp(-0.5 * squares / (self.situation * self.situation))
    }

    /// Covariance of two moves, likewise.
    fn moves(&self, a: Point, b: Point) -> f64 {
        let apart = (a - b) * (1.0 / self.moved);
        libm::exp(-0.5 * apart.dot(apart))
    }

    /// Of all pairs of points, with the noise; `None` if they are too alike.
    fn factor(&self, points: &[Transition]) -> Option<Cholesky> {
        Cholesky::of(points.len(), |i, j| {
            let (a, b) = (&points[i], &points[j]);
            let covariance = self.situations(&a.before, &b.before) * self.moves(a.moved, b.moved);
            covariance + if i == j { self.noise + 1e-9 } else { 0.0 }
        })
    }
}

/// Gaussian processes of the 16 changes.
pub struct GaussianProcess {
    kernel: Kernel,
    /// Change of each value per longest step along x and y: the prior mean.
    slopes: [[f64; 2]; 16],
    points: Vec<Transition>,
    /// K⁻¹ y by point.
    weights: Vec<Values>,
    factor: Cholesky,
    /// Variance of the signal.
    signal: f64,
}

impl GaussianProcess {
    /// Fits the process. `seed` draws the subset.
    #[must_use]
    pub fn fit(transitions: &[Transition], symmetric: bool, seed: u64) -> Self {
        let mut points = augmented(transitions, symmetric);
        let slopes = std::array::from_fn(|sensor| slopes(&points, sensor));
        let mut noise = Noise::new(seed);
        for i in 0..points.len().min(MOST_POINTS) {
            let other = i + noise.index(points.len() - i);
            points.swap(i, other);
        }
        points.truncate(MOST_POINTS);
        let residuals = residuals(&points, &slopes);
        let kernel = search(&points, &residuals);
        let fitted = fitted(&kernel, &points, &residuals);
        let (factor, weights, signal) = fitted.unwrap_or_else(|| {
            // Without points: the prior.
            let none = Cholesky::of(0, |_, _| 0.0);
            (none.expect("no rows"), Vec::new(), 0.0)
        });
        Self {
            kernel,
            slopes,
            points,
            weights,
            factor,
            signal,
        }
    }

    /// Mean of the situation after each of up to 16 moves, and its variance, that of each value.
    fn after(&self, situation: &Values, moves: &[Point]) -> Vec<(Values, f64)> {
        let covariances = |point: &Transition| -> [f64; 16] {
            let near = self.kernel.situations(&point.before, situation);
            std::array::from_fn(|k| match moves.get(k) {
                Some(moved) => near * self.kernel.moves(point.moved, *moved),
                None => 0.0,
            })
        };
        let covariances: Vec<_> = self.points.iter().map(covariances).collect();
        let explained = sums_of_squares(&self.factor.forward(&covariances));
        let one = |(k, moved): (usize, &Point)| {
            let prior = self.slopes.map(|[x, y]| x * moved.x + y * moved.y);
            let mut means = std::array::from_fn(|i| situation[i] + prior[i]);
            for (covariances, weights) in covariances.iter().zip(&self.weights) {
                for (mean, weight) in means.iter_mut().zip(weights) {
                    *mean += covariances[k] * weight;
                }
            }
            let unexplained = (1.0 - explained[k]).max(0.0);
            (means, self.signal * (unexplained + self.kernel.noise))
        };
        moves.iter().take(16).enumerate().map(one).collect()
    }
}

impl CostModel for GaussianProcess {
    fn costs(&self, situation: &Values, moves: &[Point], goal: &GoalCost) -> Vec<f64> {
        let after = self.after(situation, moves);
        let cost = |((means, variance), moved): ((Values, f64), &Point)| {
            goal.expected(&means, &[variance; 16]) - goal.progress(*moved)
        };
        after.into_iter().zip(moves).map(cost).collect()
    }

    fn numbers(&self) -> usize {
        let points = self.points.len();
        // Inputs, weights, the triangle, and the slopes.
        points * (18 + 16) + points * (points + 1) / 2 + 32
    }
}

/// Least squares of one change by the moves.
fn slopes(points: &[Transition], sensor: usize) -> [f64; 2] {
    let mut fit = PlaneFit::default();
    for point in points.iter().filter(|point| point.known[sensor]) {
        let Point { x, y } = point.moved;
        fit.add(1.0, [x, y], point.change[sensor]);
    }
    fit.slopes().unwrap_or_default()
}

/// What the prior mean leaves of each change, by point; 0 where it is unknown.
fn residuals(points: &[Transition], slopes: &[[f64; 2]; 16]) -> Vec<Values> {
    let of_point = |point: &Transition| -> Values {
        let residual = |sensor: usize| {
            let [x, y] = slopes[sensor];
            let prior = x * point.moved.x + y * point.moved.y;
            let known = point.known[sensor];
            if known {
                point.change[sensor] - prior
            } else {
                0.0
            }
        };
        std::array::from_fn(residual)
    };
    points.iter().map(of_point).collect()
}

/// Sum of squares of each column.
fn sums_of_squares(rows: &[Values]) -> Values {
    let mut sums = [0.0; 16];
    for row in rows {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += value * value;
        }
    }
    sums
}

/// A fitted kernel: its factor, K⁻¹ y by point, and the best variance of the signal.
type Fitted = (Cholesky, Vec<Values>, f64);

fn fitted(kernel: &Kernel, points: &[Transition], residuals: &[Values]) -> Option<Fitted> {
    if points.is_empty() {
        return None;
    }
    let factor = kernel.factor(points)?;
    let weights = factor.solve(residuals);
    let explained: f64 = sums_of_squares(&factor.forward(residuals)).iter().sum();
    let signal = explained / (16 * points.len()) as f64;
    Some((factor, weights, signal.max(1e-12)))
}

/// The hyperparameters of greatest marginal likelihood.
fn search(points: &[Transition], residuals: &[Values]) -> Kernel {
    let count = points.len().min(SEARCH_POINTS);
    let (points, residuals) = (&points[..count], &residuals[..count]);
    let likelihood = |kernel: &Kernel| {
        let fitted = fitted(kernel, points, residuals);
        fitted.map_or(f64::NEG_INFINITY, |(factor, _, signal)| {
            // The variance of the signal is the best one, so yᵀ K⁻¹ y is constant.
            -8.0 * (factor.log_determinant() + count as f64 * libm::log(signal))
        })
    };
    let mut best = Kernel {
        situation: 1.0,
        moved: 1.0,
        noise: 0.1,
    };
    let mut most = likelihood(&best);
    let mut keep = |best: &mut Kernel, candidate: Kernel| {
        let found = likelihood(&candidate);
        if found > most {
            (*best, most) = (candidate, found);
        }
    };
    for _ in 0..ROUNDS {
        for situation in LENGTHS {
            let candidate = Kernel { situation, ..best };
            keep(&mut best, candidate);
        }
        for moved in LENGTHS {
            let candidate = Kernel { moved, ..best };
            keep(&mut best, candidate);
        }
        for noise in NOISE_RATIOS {
            let candidate = Kernel { noise, ..best };
            keep(&mut best, candidate);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::cosines;
    use super::*;

    /// A change that no line fits: it falls with the square of the move, and with a value.
    fn curved(count: usize, seed: u64) -> Vec<Transition> {
        let mut transitions = cosines(count, seed);
        for one in &mut transitions {
            one.change = change(&one.before, one.moved);
        }
        transitions
    }

    fn change(before: &Values, moved: Point) -> Values {
        [-0.1 * moved.dot(moved) * before[0]; 16]
    }

    #[test]
    fn it_interpolates_a_curve_and_knows_where_it_was() {
        let transitions = curved(150, 1);
        let process = GaussianProcess::fit(&transitions, false, 1);
        let (mut squares, mut changes) = (0.0, 0.0);
        for one in curved(50, 2) {
            let (means, _) = process.after(&one.before, &[one.moved])[0];
            squares += (means[4] - one.before[4] - one.change[4]).powi(2);
            changes += one.change[4].powi(2);
        }
        // Moves in all directions: no line explains any of it.
        assert!(squares < 0.08 * changes, "{squares} {changes}");
        let seen = transitions[0];
        let variance = |situation: &Values| process.after(situation, &[seen.moved])[0].1;
        assert!(variance(&[5.0; 16]) > 3.0 * variance(&seen.before));
    }

    #[test]
    fn far_from_all_points_the_prior_mean_is_left() {
        let process = GaussianProcess::fit(&cosines(20, 3), true, 1);
        let (means, _) = process.after(&[0.5; 16], &[Point::new(1.0, 0.0)])[0];
        assert!((means[0] - 0.555).abs() < 1e-3 && (means[8] - 0.445).abs() < 1e-3);
        assert_eq!(process.points.len(), MOST_POINTS);
    }

    #[test]
    fn without_points_nothing_changes() {
        let process = GaussianProcess::fit(&[], true, 1);
        let after = process.after(&[0.5; 16], &[Point::new(1.0, 0.0)]);
        assert_eq!(after, [([0.5; 16], 0.0)]);
    }
}
