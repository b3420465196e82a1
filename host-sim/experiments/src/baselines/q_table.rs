//! Baseline: Q-learning with a table (C. Watkins, P. Dayan, Machine Learning 8, 1992, 279–292).
//!
//! States as in Touzet 1997: values thresholded to eight bits, here one per pair of neighboring
//! sonars, so 256 situations. 16 actions: a whole step along each transducer's axis.

use super::learning::{Experience, Learner, LearnerTraining, Reward, Values, best_of, headings};
use arena::world::Point;
use std::f64::consts::TAU;

const STATES: usize = 256;
const ACTIONS: usize = 16;

/// How it is trained; tuned as the constants.
pub const TRAINING: LearnerTraining = LearnerTraining {
    far_m: 0.6,
    reward: Reward {
        fallen: 0.4,
        in_front: 2.5,
        behind: 2.5,
    },
    explores_for: 300.0,
    explores_least: 0.1,
    turns: 16,
    free_below: 0.2,
    learns_on: true,
};

/// The learner's constants; the defaults were tuned in rooms that no comparison uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QTableTuning {
    /// A bit is set when one of its two values exceeds this.
    pub threshold: f64,
    /// α, 0 … 1.
    pub rate: f64,
    /// γ, 0 … 1.
    pub discount: f64,
}

impl Default for QTableTuning {
    fn default() -> Self {
        Self {
            threshold: 0.2,
            rate: 0.1,
            discount: 0.0,
        }
    }
}

/// A table of Q values: `Q(s, a) ← Q(s, a) + α (r + γ max Q(s', ·) − Q(s, a))`.
#[derive(Debug, Clone)]
pub struct QTable {
    tuning: QTableTuning,
    values: Vec<[f32; ACTIONS]>,
}

impl QTable {
    /// All zero.
    #[must_use]
    pub fn new(tuning: QTableTuning) -> Self {
        Self {
            tuning,
            values: vec![[0.0; ACTIONS]; STATES],
        }
    }

    fn state(&self, situation: &Values) -> usize {
        let pairs = situation.chunks_exact(2).enumerate();
        let bit = |(bit, pair): (usize, &[f64])| {
            usize::from(pair.iter().any(|value| *value > self.tuning.threshold)) << bit
        };
        pairs.map(bit).sum()
    }

    fn row(&self, state: usize) -> [f32; ACTIONS] {
        self.values.get(state).copied().unwrap_or([0.0; ACTIONS])
    }
}

fn action(commanded: Point) -> usize {
    let place = libm::rint(commanded.angle() / TAU * ACTIONS as f64);
    place.rem_euclid(ACTIONS as f64) as usize % ACTIONS
}

impl Learner for QTable {
    fn best(&self, situation: &Values, course: Point) -> Point {
        let values = self.row(self.state(situation)).map(f64::from);
        best_of(headings().into_iter().zip(values), course)
    }

    fn learn(&mut self, experience: &Experience) {
        let next = self.row(self.state(&experience.after));
        let most = next.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let target = experience.reward + self.tuning.discount * f64::from(most);
        let (state, rate) = (self.state(&experience.before), self.tuning.rate);
        let row = self.values.get_mut(state);
        if let Some(value) = row.and_then(|row| row.get_mut(action(experience.commanded))) {
            *value += (rate * (target - f64::from(*value))) as f32;
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::ring_pilot::axis;

    const TUNING: QTableTuning = QTableTuning {
        threshold: 0.5,
        rate: 0.5,
        discount: 0.9,
    };

    fn moved(before: Values, heading: usize, reward: f64, after: Values) -> Experience {
        Experience {
            before,
            commanded: axis(heading),
            moved: axis(heading),
            after,
            reward,
        }
    }

    #[test]
    fn values_follow_the_rule_by_hand() {
        let mut table = QTable::new(TUNING);
        let (free, mut near) = ([0.0; 16], [0.0; 16]);
        near[5] = 0.6;
        assert_eq!((table.state(&free), table.state(&near)), (0, 4));
        table.learn(&moved(near, 13, 1.0, free));
        assert_eq!(table.row(4)[13], 0.5);
        // 0 + 0.5 · (0 + 0.9 · 0.5) = 0.225 for the approach.
        table.learn(&moved(free, 5, 0.0, near));
        assert!((table.row(0)[5] - 0.225).abs() < 1e-6);
        // 0.5 + 0.5 · (1 + 0.9 · 0.225 − 0.5) = 0.85125.
        table.learn(&moved(near, 13, 1.0, free));
        assert!((table.row(4)[13] - 0.851_25).abs() < 1e-6);
        assert!(table.best(&near, axis(0)).distance(axis(13)) < 1e-12);
    }

    /// A corridor of three situations with the reward at its end: the values are γ², γ and 1.
    #[test]
    fn values_converge_to_the_discounted_reward() {
        let mut table = QTable::new(TUNING);
        let place = |sensor: usize| {
            let mut values = [0.0; 16];
            values[sensor] = 1.0;
            values
        };
        for _ in 0..60 {
            table.learn(&moved(place(0), 0, 0.0, place(4)));
            table.learn(&moved(place(4), 0, 0.0, place(8)));
            table.learn(&moved(place(8), 0, 1.0, place(12)));
        }
        for (sensor, expected) in [(0, 0.81), (4, 0.9), (8, 1.0)] {
            let value = table.row(table.state(&place(sensor)))[0];
            assert!((value - expected).abs() < 1e-4, "{sensor}: {value}");
        }
    }
}
