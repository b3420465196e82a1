//! Baseline: lazy Q-learning; stores the moves and computes values from the memory, without a map.
//!
//! J. Sheppard, S. Salzberg, Artificial Intelligence Review 11, 1997, 343–370; C. Touzet,
//! International Journal of Advanced Robotic Systems 1(1), 2004. From the abstracts: all moves are
//! random, then the memory is swept until no value changes. See [`QLazy`].

use super::learning::{Experience, Learner, LearnerTraining, Reward, Values, best_of, headings};
use super::rotation::RotatableRing;
use arena::noise::Noise;
use arena::world::Point;

/// Largest number of neighbors in a mean.
const MAX_NEIGHBORS: usize = 8;
/// Largest number of sweeps, and the change at which they end.
const SWEEPS: u32 = 500;
const SETTLED: f64 = 1e-3;
/// ε: limits the weight of a neighbor at distance 0.
const NEAR: f64 = 1e-3;

/// How it is trained; tuned as the constants.
pub const TRAINING: LearnerTraining = LearnerTraining {
    far_m: 1.5,
    reward: Reward {
        fallen: 0.1,
        in_front: 1.0,
        behind: 2.5,
    },
    explores_for: 1e9,
    explores_least: 1.0,
    turns: 1,
    free_below: 0.4,
    learns_on: false,
};

/// The learner's constants; the defaults were tuned in rooms that no comparison uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QLazyTuning {
    /// k, 1 … 8.
    pub neighbors: usize,
    /// γ, 0 … below 1.
    pub discount: f64,
    /// λ, the weight of an action relative to the situation's components.
    pub action_weight: f64,
    /// Each sample counts in this many rotations of the ring: 1 or 16.
    pub turns: usize,
}

impl Default for QLazyTuning {
    fn default() -> Self {
        Self {
            neighbors: 4,
            discount: 0.0,
            action_weight: 0.5,
            turns: 16,
        }
    }
}

/// A memory of moves and their values.
///
/// ```text
/// Q_i ← r_i + γ max Q̂(s'_i, a)
/// Q̂(s, a) = mean of the k nearest Q_i, weighted by 1/(d² + ε)
/// d² = |s − s_i|² + λ² |a − a_i|²
/// ```
///
/// The robot takes the action with the greatest Q̂ among the 16 transducer axes.
#[derive(Debug, Clone)]
pub struct QLazy {
    tuning: QLazyTuning,
    memory: Vec<Experience>,
    /// The situation before each move, for the search.
    before: Vec<RotatableRing>,
    values: Vec<f64>,
}

/// The nearest samples found so far: squared distance and index, nearest first.
#[derive(Debug, Clone, Copy)]
struct NearestSamples {
    found: [(f64, usize); MAX_NEIGHBORS],
    wanted: usize,
}

impl NearestSamples {
    fn new(wanted: usize) -> Self {
        Self {
            found: [(f64::INFINITY, 0); MAX_NEIGHBORS],
            wanted: wanted.clamp(1, MAX_NEIGHBORS),
        }
    }

    /// Samples farther than this are not accepted.
    fn limit(&self) -> f64 {
        self.found.get(self.wanted - 1).map_or(0.0, |last| last.0)
    }

    /// Inserts a sample if it is near enough; returns whether it was.
    fn offer(&mut self, distance: f64, index: usize) -> bool {
        if distance >= self.limit() {
            return false;
        }
        let mut held = (distance, index);
        for place in self.found.iter_mut().take(self.wanted) {
            if held.0 < place.0 {
                std::mem::swap(place, &mut held);
            }
        }
        true
    }

    /// The weighted mean of the values; 0 without samples.
    fn mean(&self, values: &[f64]) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (distance, index) in self.found.iter().take(self.wanted) {
            if distance.is_finite() {
                let weight = 1.0 / (distance + NEAR);
                sum += weight * values.get(*index).copied().unwrap_or(0.0);
                weights += weight;
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }
}

impl QLazy {
    /// An empty memory.
    #[must_use]
    pub fn new(tuning: QLazyTuning) -> Self {
        Self {
            tuning,
            memory: Vec::new(),
            before: Vec::new(),
            values: Vec::new(),
        }
    }

    /// For each of the 16 actions, the nearest samples in this situation.
    fn neighbors(&self, situation: &Values) -> [NearestSamples; 16] {
        let actions = headings();
        let weight = self.tuning.action_weight * self.tuning.action_weight;
        let mut nearest = [NearestSamples::new(self.tuning.neighbors); 16];
        let mut farthest = f64::INFINITY;
        for turn in 0..self.tuning.turns {
            let places = turn * 16 / self.tuning.turns;
            let direction = sim::ring_pilot::axis(places);
            for (index, (sample, before)) in self.memory.iter().zip(&self.before).enumerate() {
                let apart = before.squared_distance(situation, places);
                if apart >= farthest {
                    continue;
                }
                let taken = sample.commanded.turned(direction);
                let mut changed = false;
                for (nearest, action) in nearest.iter_mut().zip(&actions) {
                    let difference = *action - taken;
                    changed |= nearest.offer(apart + weight * difference.dot(difference), index);
                }
                if changed {
                    farthest = nearest
                        .iter()
                        .map(NearestSamples::limit)
                        .fold(0.0, f64::max);
                }
            }
        }
        nearest
    }
}

impl Learner for QLazy {
    fn best(&self, situation: &Values, course: Point) -> Point {
        let neighbors = self.neighbors(situation);
        let values = neighbors.iter().map(|found| found.mean(&self.values));
        best_of(headings().into_iter().zip(values), course)
    }

    fn learn(&mut self, experience: &Experience) {
        self.memory.push(*experience);
        self.before.push(RotatableRing::new(&experience.before));
        self.values.push(experience.reward);
    }

    /// Samples are random: values do not exist before the sweeps.
    fn variation(&self, _: &Values, _: Point, noise: &mut Noise) -> Option<Point> {
        let direction = Point::unit(noise.uniform_in(0.0, std::f64::consts::TAU));
        Some(direction * noise.uniform())
    }

    fn settle(&mut self) {
        let after = self.memory.iter();
        let neighbors: Vec<_> = after.map(|move_| self.neighbors(&move_.after)).collect();
        for _ in 0..SWEEPS {
            let mut change = 0.0_f64;
            for (index, (sample, found)) in self.memory.iter().zip(&neighbors).enumerate() {
                let all = found.iter().map(|found| found.mean(&self.values));
                let most = all.fold(f64::NEG_INFINITY, f64::max);
                let value = sample.reward + self.tuning.discount * most;
                if let Some(place) = self.values.get_mut(index) {
                    change = change.max((value - *place).abs());
                    *place = value;
                }
            }
            if change < SETTLED {
                break;
            }
        }
    }

    fn bytes(&self) -> usize {
        self.memory.len() * (size_of::<Experience>() + size_of::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::ring_pilot::axis;

    fn place(sensor: usize) -> Values {
        let mut values = [0.0; 16];
        values[sensor] = 1.0;
        values
    }

    fn moved(before: usize, heading: usize, reward: f64, after: usize) -> Experience {
        Experience {
            before: place(before),
            commanded: axis(heading),
            moved: axis(heading),
            after: place(after),
            reward,
        }
    }

    #[test]
    fn the_memory_is_swept_to_the_discounted_reward() {
        let mut lazy = QLazy::new(QLazyTuning {
            neighbors: 1,
            discount: 0.9,
            action_weight: 0.1,
            turns: 1,
        });
        // Three situations in a row with a reward at the third, and back to the first.
        for experience in [
            moved(0, 3, 0.0, 4),
            moved(4, 3, 0.0, 8),
            moved(8, 3, 1.0, 0),
        ] {
            lazy.learn(&experience);
        }
        lazy.settle();
        let last = 1.0 / (1.0 - 0.9_f64.powi(3));
        for (value, expected) in lazy.values.iter().zip([0.81 * last, 0.9 * last, last]) {
            assert!((value - expected).abs() < 0.02, "{value} {expected}");
        }
    }

    #[test]
    fn what_was_good_is_done_again_also_turned() {
        let mut lazy = QLazy::new(QLazyTuning {
            neighbors: 1,
            discount: 0.0,
            action_weight: 1.0,
            turns: 16,
        });
        // Every direction was tried in one situation; one of them was good.
        for heading in 0..16 {
            let reward = if heading == 8 { 1.0 } else { -1.0 };
            lazy.learn(&moved(0, heading, reward, 4));
        }
        lazy.settle();
        assert!(lazy.best(&place(0), axis(0)).distance(axis(8)) < 1e-9);
        assert!(lazy.best(&place(5), axis(5)).distance(axis(13)) < 1e-9);
    }
}
