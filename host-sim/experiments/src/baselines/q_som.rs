//! Baseline: Q-learning with one self-organizing map (Q-KOHON).
//!
//! C. Touzet, Robotics and Autonomous Systems 22, 1997, 251–281, from the abstract: a map learns
//! obstacle avoidance more than 40 times faster than plain Q-learning. See [`QSom`] for our
//! reading.

use super::learning::{Experience, Learner, LearnerTraining, Reward, Values};
use amp::fixed::{Mask, Weight};
use amp::som::Update;
use amp::som::{Grid, Neighborhood, Som};
use arena::world::Point;

const NEURONS: usize = 16;
const DIMS: usize = 19;
const ACTION: usize = 16;
const VALUE: usize = 18;

/// How it is trained; tuned as the constants.
pub const TRAINING: LearnerTraining = LearnerTraining {
    far_m: 1.0,
    reward: Reward {
        fallen: 0.2,
        in_front: 2.5,
        behind: 7.0,
    },
    explores_for: 300.0,
    explores_least: 0.0,
    turns: 16,
    free_below: 0.2,
    learns_on: false,
};

/// The learner's constants; the defaults were tuned in rooms that no comparison uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QSomTuning {
    /// α of the Q rule, 0 … 1.
    pub rate: f64,
    /// γ, 0 … below 1.
    pub discount: f64,
    /// Initial learning rate of the map. After n moves (rotations counted) it is this times
    /// e^(−n/`fades`), but at least `pull_least`.
    pub pull: f64,
    /// Final learning rate of the map.
    pub pull_least: f64,
    /// Time constant of the map's learning rate, in moves.
    pub fades: f64,
    /// The neighbors' share of the learning rate.
    pub share: f64,
    /// Weight of the action's components relative to the situation's, 0 … 1.
    pub action_weight: f64,
    /// Weight of Q relative to the situation's components, 0 … 1.
    pub value_weight: f64,
}

impl Default for QSomTuning {
    fn default() -> Self {
        Self {
            rate: 0.5,
            discount: 0.5,
            pull: 0.3,
            pull_least: 0.02,
            fades: 2_000.0,
            share: 0.0,
            action_weight: 0.7,
            value_weight: 1.0,
        }
    }
}

/// A map of 16 neurons (situation, action, Q).
///
/// The move is the action of the neuron nearest to (situation, any, Q = 1), varied while exploring.
/// Then the neuron nearest to (situation, action, any) and its four neighbors are updated toward
/// (situation, action, Q + α (r + γ max Q' − Q)). Q is in units of 1/(1 − γ), which bounds it by 1.
#[derive(Debug, Clone)]
pub struct QSom {
    tuning: QSomTuning,
    map: Som<NEURONS, DIMS>,
    learned: u32,
}

impl QSom {
    /// An untrained map: each neuron has an action along another of the ring's directions.
    #[must_use]
    pub fn new(tuning: QSomTuning) -> Self {
        let nowhere = [0.0; 16];
        let row = |neuron: usize| vector(&tuning, &nowhere, sim::ring_pilot::axis(neuron), 0.0);
        Self {
            tuning,
            map: Som::new(Grid::rectangle(4, 4), std::array::from_fn(row)),
            learned: 0,
        }
    }

    fn component(&self, neuron: usize, index: usize) -> f64 {
        let row = self.map.code().get(neuron);
        row.and_then(|row| row.get(index))
            .map_or(0.0, |value| value.to_num())
    }

    /// The neuron whose action is best in this situation.
    fn answering(&self, situation: &Values) -> usize {
        let probe = vector(&self.tuning, situation, Point::default(), 1.0);
        let mask = Mask::ALL.without(ACTION).without(ACTION + 1);
        self.map.bmu(&probe, mask)
    }

    /// A neuron's Q in units of 1/(1 − γ).
    fn value(&self, neuron: usize) -> f64 {
        self.component(neuron, VALUE) / self.tuning.value_weight
    }
}

fn vector(tuning: &QSomTuning, situation: &Values, action: Point, value: f64) -> [Weight; DIMS] {
    std::array::from_fn(|index| {
        let component = match index {
            ACTION => action.x * tuning.action_weight,
            17 => action.y * tuning.action_weight,
            VALUE => value * tuning.value_weight,
            sensor => situation.get(sensor).copied().unwrap_or(0.0),
        };
        Weight::from_num(component.clamp(-1.0, 1.0))
    })
}

impl Learner for QSom {
    fn best(&self, situation: &Values, course: Point) -> Point {
        let neuron = self.answering(situation);
        let action = Point::new(
            self.component(neuron, ACTION),
            self.component(neuron, ACTION + 1),
        );
        let length = action.length();
        if length > 1e-3 {
            action * (1.0 / length)
        } else {
            course
        }
    }

    fn learn(&mut self, experience: &Experience) {
        let QSomTuning { rate, discount, .. } = self.tuning;
        let probe = vector(&self.tuning, &experience.before, experience.commanded, 0.0);
        let winner = self.map.bmu(&probe, Mask::ALL.without(VALUE));
        let most = self.value(self.answering(&experience.after));
        let value = self.value(winner);
        let target = experience.reward * (1.0 - discount) + discount * most;
        let value = value + rate * (target - value);
        let fading = libm::exp(-f64::from(self.learned) / self.tuning.fades);
        let pull = (self.tuning.pull * fading).max(self.tuning.pull_least);
        let q16 = |value: f64| (value * 65_536.0 + 0.5) as u32;
        let pull = Update::from_q16(Neighborhood::Direct, q16(pull), q16(self.tuning.share));
        let lesson = vector(
            &self.tuning,
            &experience.before,
            experience.commanded,
            value,
        );
        self.map.update(winner, &lesson, Mask::ALL, &pull);
        self.learned = self.learned.saturating_add(1);
    }

    fn bytes(&self) -> usize {
        size_of_val(self.map.code())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::ring_pilot::axis;

    const TUNING: QSomTuning = QSomTuning {
        rate: 1.0,
        discount: 0.5,
        pull: 1.0,
        pull_least: 0.5,
        fades: 1e9,
        share: 0.0,
        action_weight: 1.0,
        value_weight: 1.0,
    };

    #[test]
    fn a_rewarded_move_is_chosen_again_and_a_punished_one_is_not() {
        let mut map = QSom::new(TUNING);
        let (mut near, free) = ([0.0; 16], [0.0; 16]);
        near[2] = 1.0;
        let moved = |heading: usize, reward: f64| Experience {
            before: near,
            commanded: axis(heading),
            moved: axis(heading),
            after: free,
            reward,
        };
        map.learn(&moved(10, 1.0));
        // With both rates 1 the neuron becomes the experience: Q = 1 · (1 − γ) + γ · 0.
        let winner = map.answering(&near);
        assert_eq!(winner, 10);
        assert!((map.value(winner) - 0.5).abs() < 1e-3);
        assert!(map.best(&near, axis(0)).distance(axis(10)) < 1e-2);
        map.learn(&moved(10, -1.0));
        assert!((map.value(10) + 0.5).abs() < 1e-3);
        map.learn(&moved(9, 1.0));
        assert!(map.best(&near, axis(0)).distance(axis(9)) < 1e-2);
    }

    #[test]
    fn values_stay_within_their_bound() {
        let mut map = QSom::new(TUNING);
        let here = [0.3; 16];
        let moved = Experience {
            before: here,
            commanded: axis(3),
            moved: axis(3),
            after: here,
            reward: 1.0,
        };
        (0..50).for_each(|_| map.learn(&moved));
        // A constant reward of 1 has the value 1/(1 − γ): 1 in the map's unit.
        assert!((map.value(map.answering(&here)) - 1.0).abs() < 1e-2);
    }
}
