//! Baseline: Q-learning between a map of situations and a map of actions.
//!
//! A. J. Smith, Neural Networks 15, 2002, 1107–1124. Our reading of its opening: φ is a Gaussian
//! whose width and learning rates fall; exploration is ε-greedy; k is the action neuron nearest to
//! the tried action. See [`QTwoSoms`].

use super::learning::{Experience, Learner, LearnerTraining, Reward, Values, best_of};
use amp::fixed::{Mask, Weight};
use amp::som::Update;
use amp::som::{Grid, Neighborhood, Som};
use arena::world::Point;

/// Neurons of each map.
const NEURONS: usize = 16;

/// How it is trained; tuned as the constants.
pub const TRAINING: LearnerTraining = LearnerTraining {
    far_m: 0.6,
    reward: Reward {
        fallen: 0.2,
        in_front: 4.0,
        behind: 1.5,
    },
    explores_for: 300.0,
    explores_least: 0.1,
    turns: 16,
    free_below: 0.2,
    learns_on: true,
};

/// The learner's constants; the defaults were tuned in rooms that no comparison uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QTwoSomsTuning {
    /// α of the Q rule, 0 … 1.
    pub rate: f64,
    /// γ, 0 … below 1.
    pub discount: f64,
    /// Initial learning rate of both maps; it falls as e^(−n/`fades`) over the moves (rotations
    /// counted).
    pub pull: f64,
    /// Initial width σ of φ, in grid steps; it falls with the learning rate.
    pub width: f64,
    /// Time constant of both, in moves.
    pub fades: f64,
    /// Lower limit of both, as a share of their initial value.
    pub least: f64,
}

impl Default for QTwoSomsTuning {
    fn default() -> Self {
        Self {
            rate: 0.3,
            discount: 0.8,
            pull: 0.05,
            width: 1.0,
            fades: 2_000.0,
            least: 0.02,
        }
    }
}

/// Two maps and a Q value for each pair of their neurons.
///
/// With situation winner j, action neuron k varied to u, reward r and next winner j':
///
/// ```text
/// if r + γ max Q[j', ·] > Q[j, k]:  the action map learns u around k
/// Q[m, n] ← Q[m, n] + α φ(j, m) φ(k, n) (r + γ max Q[j', ·] − Q[m, n])     for all m, n
/// the situation map learns the situation
/// ```
#[derive(Debug, Clone)]
pub struct QTwoSoms {
    tuning: QTwoSomsTuning,
    situations: Som<NEURONS, 16>,
    actions: Som<NEURONS, 2>,
    values: [[f64; NEURONS]; NEURONS],
    learned: u32,
}

impl QTwoSoms {
    /// Untrained maps: each situation neuron has an obstacle before another transducer, each action
    /// neuron a step along another axis, both in the order of a path around the grid.
    #[must_use]
    pub fn new(tuning: QTwoSomsTuning) -> Self {
        let grid = Grid::rectangle(4, 4);
        let ahead = |neuron: usize| {
            std::array::from_fn(|sensor| {
                let near = sim::ring_pilot::axis(neuron)
                    .dot(sim::ring_pilot::axis(sensor))
                    .max(0.0);
                Weight::from_num(near * 0.5)
            })
        };
        Self {
            tuning,
            situations: Som::new(grid, std::array::from_fn(ahead)),
            actions: Som::new(
                grid,
                std::array::from_fn(|n| weights(sim::ring_pilot::axis(n))),
            ),
            values: [[0.0; NEURONS]; NEURONS],
            learned: 0,
        }
    }

    fn situation_neuron(&self, situation: &Values) -> usize {
        self.situations.bmu(&situation.map(weight), Mask::ALL)
    }

    fn row(&self, neuron: usize) -> [f64; NEURONS] {
        self.values.get(neuron).copied().unwrap_or([0.0; NEURONS])
    }

    /// Factor of learning rate and width at this move.
    fn faded(&self) -> f64 {
        libm::exp(-f64::from(self.learned) / self.tuning.fades).max(self.tuning.least)
    }
}

fn weight(value: f64) -> Weight {
    Weight::from_num(value.clamp(-1.0, 1.0))
}

fn weights(action: Point) -> [Weight; 2] {
    [weight(action.x), weight(action.y)]
}

/// φ between one neuron of a 4 × 4 grid and each of them.
fn nearness(neuron: usize, width: f64) -> [f64; NEURONS] {
    // The distance along one side is 0 … 3.
    let along: [f64; 4] = std::array::from_fn(|apart| {
        let apart = apart as f64;
        libm::exp(-apart * apart / (2.0 * width * width))
    });
    let near = |a: usize, b: usize| along.get(a.abs_diff(b)).copied().unwrap_or(0.0);
    std::array::from_fn(|other| near(neuron % 4, other % 4) * near(neuron / 4, other / 4))
}

impl Learner for QTwoSoms {
    fn best(&self, situation: &Values, course: Point) -> Point {
        let values = self.row(self.situation_neuron(situation));
        let unit = |row: &[amp::fixed::Weight32; 2]| {
            let [x, y] = row.map(|part| part.to_num::<f64>());
            let direction = Point::new(x, y);
            direction * (1.0 / direction.length().max(1e-6))
        };
        best_of(self.actions.code().iter().map(unit).zip(values), course)
    }

    fn learn(&mut self, experience: &Experience) {
        let commanded = weights(experience.commanded);
        let state = self.situation_neuron(&experience.before);
        let action = self.actions.bmu(&commanded, Mask::ALL);
        let next = self.row(self.situation_neuron(&experience.after));
        let most = next.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let target = experience.reward + self.tuning.discount * most;
        let faded = self.faded();
        let width = self.tuning.width * faded;
        let q16 = |value: f64| (value * 65_536.0 + 0.5) as u32;
        let rate = q16(self.tuning.pull * faded);
        let pull = Update::from_q16(Neighborhood::Gaussian, rate, q16(width));
        if target > self.row(state).get(action).copied().unwrap_or(0.0) {
            self.actions.update(action, &commanded, Mask::ALL, &pull);
        }
        let actions = nearness(action, width);
        for (row, near) in self.values.iter_mut().zip(nearness(state, width)) {
            if near == 0.0 {
                continue;
            }
            let near = self.tuning.rate * near;
            for (value, action) in row.iter_mut().zip(actions) {
                *value += near * action * (target - *value);
            }
        }
        let before = experience.before.map(weight);
        self.situations.update(state, &before, Mask::ALL, &pull);
        self.learned = self.learned.saturating_add(1);
    }

    fn bytes(&self) -> usize {
        size_of_val(self.situations.code())
            + size_of_val(self.actions.code())
            + size_of_val(&self.values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::ring_pilot::axis;

    #[test]
    fn values_and_maps_follow_the_rule_by_hand() {
        let tuning = QTwoSomsTuning {
            rate: 0.5,
            discount: 0.9,
            pull: 0.5,
            width: 1.0,
            fades: 1e12,
            least: 0.0,
        };
        let mut maps = QTwoSoms::new(tuning);
        let mut near = [0.0; 16];
        near[0] = 0.5;
        let state = maps.situation_neuron(&near);
        let commanded = axis(5) * 0.9;
        let moved = Experience {
            before: near,
            commanded,
            moved: commanded,
            after: [0.0; 16],
            reward: 1.0,
        };
        maps.learn(&moved);
        // The pair itself moves by α, a neighbor of one of the two by α e^(−1/2).
        assert!((maps.values[state][5] - 0.5).abs() < 1e-9);
        assert!((maps.values[state][6] - 0.5 * libm::exp(-0.5)).abs() < 1e-9);
        // Better than expected: the action map moves half the distance.
        let [x, y] = maps.actions.code()[5].map(|part| part.to_num::<f64>());
        assert!(Point::new(x, y).distance(axis(5) * 0.95) < 2e-3);
        let value = maps.situations.code()[state][0].to_num::<f64>();
        maps.learn(&Experience {
            reward: -1.0,
            ..moved
        });
        // Worse than expected: the action map does not change; the situation map still learns.
        let [x2, y2] = maps.actions.code()[5].map(|part| part.to_num::<f64>());
        assert_eq!([x, y], [x2, y2]);
        let closer = maps.situations.code()[state][0].to_num::<f64>();
        assert!((closer - 0.5).abs() <= (value - 0.5).abs());
    }
}
