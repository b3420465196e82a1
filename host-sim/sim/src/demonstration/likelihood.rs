//! How probable the demonstrated moves are under a goal, and how to make them more so.
//!
//! The planner first looks in which direction p the situation fits the goal best, with cost F(p),
//! and then takes the displacement a of least expected cost G(p, a). The model does the same with
//! probabilities: P(a) = Σ_p e^−F(p) / Σ e^−F · e^−G(p, a) / Σ e^−G(p, ·). A share of the moves,
//! [`CHANCE`], is taken to be chance, so that no single move outweighs the others.

use super::examples::{Example, Examples, MOVES, WHOLE_STEPS, direction, displacement};
use super::family::Family;
use super::parameters::{COUNT, Gradient, Parameters, RingBounds, RingGradient};
use amp::goal::{Goal, GoalFrame};

/// Strength of the prior: a weight e times as great as at the start counts as much as this loss.
/// Without it, components that the demonstrated moves do not depend on lose their weights.
const PRIOR: f64 = 0.001;
/// Share of moves that no goal explains.
const CHANCE: f64 = 0.02;
/// Directions less probable than this are left out.
const LEAST_PROBABLE: f64 = 1e-4;

/// Probabilities e^−cost, normalized.
fn softmin(costs: &[f64]) -> Vec<f64> {
    let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
    let powers: Vec<_> = costs.iter().map(|cost| libm::exp(least - cost)).collect();
    let sum: f64 = powers.iter().sum();
    powers.into_iter().map(|power| power / sum).collect()
}

/// One direction in which an example may be seen.
struct View {
    place: usize,
    /// Probability of the direction.
    probability: f64,
    /// Probabilities of the displacements.
    moves: Vec<f64>,
    /// Probability of the demonstrated displacement.
    shown: f64,
}

/// What one pass over the examples works with.
struct Work<'a> {
    /// What is asked of the ring towards each place.
    bounds: Vec<RingBounds>,
    /// Derivatives by that.
    ring: Vec<RingGradient>,
    /// Derivatives by the preferences.
    gradient: &'a mut Gradient,
}

/// A goal under way to the most probable one: gradient descent by D. Kingma and J. Ba, *Adam*, ICLR
/// 2015.
pub struct Fit {
    family: Family,
    parameters: Parameters,
    /// Where it began.
    first: Parameters,
    /// Mean negative logarithm of the probability of a demonstrated move.
    pub loss: f64,
    iterations: u32,
    mean: Gradient,
    square: Gradient,
}

impl Fit {
    pub fn new(family: Family, parameters: Parameters) -> Self {
        Self {
            family,
            first: parameters.clone(),
            parameters,
            loss: f64::INFINITY,
            iterations: 0,
            mean: [0.0; COUNT],
            square: [0.0; COUNT],
        }
    }

    /// One iteration; the steps shrink until `all` iterations are done.
    pub fn improve(&mut self, examples: &Examples, all: u32) {
        let mut gradient = self
            .parameters
            .pull_to(&self.first, PRIOR * examples.len() as f64);
        self.loss = self.loss_of(examples, &mut gradient);
        self.iterations += 1;
        let count = f64::from(self.iterations);
        let left = 1.0 - count / f64::from(all);
        let rate = 0.1 * left.max(0.0) + 0.004;
        let step = std::array::from_fn(|index| {
            let slope = gradient[index] / examples.len().max(1) as f64;
            self.mean[index] += 0.1 * (slope - self.mean[index]);
            self.square[index] += 0.01 * (slope * slope - self.square[index]);
            let mean = self.mean[index] / (1.0 - libm::pow(0.9, count));
            let square = self.square[index] / (1.0 - libm::pow(0.99, count));
            rate * mean / (square.sqrt() + 1e-6)
        });
        self.parameters.descend(&step);
    }

    /// The mean loss.
    pub fn loss_at(&self, examples: &Examples) -> f64 {
        self.loss_of(examples, &mut [0.0; COUNT])
    }

    /// The mean loss; adds the derivatives of the sum.
    pub fn loss_of(&self, examples: &Examples, gradient: &mut Gradient) -> f64 {
        let mut work = Work {
            bounds: self.parameters.towards_all(self.family),
            ring: vec![RingGradient::default(); self.family.directions()],
            gradient,
        };
        let losses = examples
            .iter()
            .map(|example| self.learn(example, &mut work));
        let loss = losses.sum::<f64>() / examples.len().max(1) as f64;
        for (place, ring) in work.ring.iter().enumerate() {
            ring.add_to(work.gradient, place);
        }
        loss
    }

    /// Negative logarithm of the probability of an example; adds its derivatives.
    fn learn(&self, example: &Example, work: &mut Work<'_>) -> f64 {
        let views = self.views(example, &work.bounds);
        let joint: f64 = views.iter().map(|view| view.probability * view.shown).sum();
        let probability = joint * (1.0 - CHANCE) + CHANCE / MOVES as f64;
        // Share of the probability that comes from the goal.
        let by_goal = joint * (1.0 - CHANCE) / probability;
        for view in &views {
            let responsible = view.probability * view.shown * (1.0 - CHANCE) / probability;
            self.add_view(example, view, responsible, by_goal, work);
        }
        -libm::log(probability)
    }

    /// The directions in which an example is seen, without the least probable ones.
    fn views(&self, example: &Example, bounds: &[RingBounds]) -> Vec<View> {
        let costs: Vec<_> = (0..self.family.directions())
            .map(|place| self.cost_of_place(example, place, &bounds[place]))
            .collect();
        let mut views = Vec::new();
        for (place, probability) in softmin(&costs).into_iter().enumerate() {
            if probability >= LEAST_PROBABLE {
                let moves = softmin(&self.costs_of_moves(example, place, &bounds[place]));
                let shown = example.share_of_shown(&moves);
                views.push(View {
                    place,
                    probability,
                    moves,
                    shown,
                });
            }
        }
        views
    }

    fn cost_of_place(&self, example: &Example, place: usize, bounds: &RingBounds) -> f64 {
        let cost = bounds.cost(&example.values);
        cost - self.parameters.heading_hold * self.holding(example, place)
    }

    /// Cosine between a direction and the course; 0 where it does not count.
    fn holding(&self, example: &Example, place: usize) -> f64 {
        match (self.family.frame, example.course) {
            (GoalFrame::Travel, Some(course)) => libm::cos(direction(place) - course),
            _ => 0.0,
        }
    }

    /// Costs of the displacements that could have been made. The planner takes the direction of
    /// the best whole step, and a shorter one only where that is better: the length of a whole
    /// step tells nothing.
    fn costs_of_moves(&self, example: &Example, place: usize, bounds: &RingBounds) -> Vec<f64> {
        let count = if self.family.stands && !example.is_whole() {
            MOVES
        } else {
            WHOLE_STEPS
        };
        let after = example.after.iter().take(count).enumerate();
        let cost = |(index, after): (usize, &[f64; 16])| {
            let progress = self.progress(example, place, index);
            bounds.cost(after) - self.parameters.progress * progress
        };
        after.map(cost).collect()
    }

    /// Cosine between a displacement and what counts as progress; 0 for goals that have none.
    fn progress(&self, example: &Example, place: usize, index: usize) -> f64 {
        let ahead = match self.family.frame {
            GoalFrame::Ring => example.course,
            GoalFrame::Travel => Some(direction(place)),
        };
        match ahead {
            Some(ahead) if !self.family.stands => libm::cos(displacement(index).1 - ahead),
            _ => 0.0,
        }
    }

    /// Adds the derivatives by way of one direction: a cost should be lower as far as the
    /// demonstration has it more often than the model.
    fn add_view(
        &self,
        example: &Example,
        view: &View,
        responsible: f64,
        by_goal: f64,
        work: &mut Work<'_>,
    ) {
        let parameters = &self.parameters;
        let place = view.place;
        let factor = responsible - view.probability * by_goal;
        let (bounds, ring) = (&work.bounds[place], &mut work.ring[place]);
        bounds.add_cost(ring, &example.values, factor);
        parameters.add_heading_hold(work.gradient, factor * self.holding(example, place));
        for (index, probability) in view.moves.iter().enumerate() {
            let is_shown = example.shown.iter().filter(|(shown, _)| *shown == index);
            let share: f64 = is_shown.map(|(_, share)| share).sum();
            let wanted = responsible * share * probability / view.shown.max(1e-300);
            let factor = wanted - responsible * probability;
            if factor.abs() > 1e-9 {
                bounds.add_cost(ring, &example.after[index], factor);
                let progress = self.progress(example, place, index);
                parameters.add_progress(work.gradient, factor * progress);
            }
        }
    }

    /// The goal. It holds up to the deviation that half of the demonstrated situations have.
    pub fn goal(&self, examples: &Examples) -> Goal<16> {
        let weights: f64 = self.parameters.weights.iter().sum();
        let bounds = self.parameters.towards_all(self.family);
        let deviation = |example: &Example| {
            let costs = bounds.iter().map(|bounds| bounds.cost(&example.values));
            costs.fold(f64::INFINITY, f64::min) / weights
        };
        let mut deviations: Vec<_> = examples.iter().map(deviation).collect();
        deviations.sort_unstable_by(f64::total_cmp);
        let median = deviations.get(examples.len() / 2).copied();
        self.parameters.goal(self.family, median.unwrap_or(0.0))
    }
}
