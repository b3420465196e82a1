//! Arms instead of a mobile base: the same idea, a couple of maps and goals as situations, for the
//! systems of the paper's sections 4 and 5.3.
//!
//! [`reach`] is the arm of Coiton et al., with a second goal from the same memory,
//! and the arms of Smith in the plane;
//! [`pointing`] is an eye and an arm.

pub mod body;
mod controls;
mod inverse;
mod least_squares;
mod maps;
mod method;
pub mod pictures;
pub mod pointing;
mod q_arm;
pub mod reach;
pub mod region;

use arena::noise::Noise;

/// What a method is asked for: the sensed values of the target, and what is to be avoided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReachGoal<const V: usize> {
    /// The wanted values; the first [`sensed`](Self::sensed) count.
    pub values: [f64; V],
    /// Number of values that are sensed of the hand; the others are joint angles.
    pub sensed: usize,
    /// The hand at the target, m; only methods that know the geometry read it.
    pub hand_m: [f64; 3],
    /// A region that the hand must not enter.
    pub avoided: Option<region::Region>,
}

impl<const V: usize> ReachGoal<V> {
    /// Distance of a situation from the goal, in units of the values.
    fn distance(&self, situation: &[f64; V]) -> f64 {
        let pairs = situation.iter().zip(&self.values).take(self.sensed);
        pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }
}

/// A method that moves an arm; actions are in units of the longest move.
trait Reacher<const V: usize, const A: usize> {
    /// A random move of the exploration.
    fn explored(&mut self, _before: &[f64; V], _action: &[f64; A], _after: &[f64; V]) {}
    /// The exploration is over.
    fn learn(&mut self) {}
    /// A new goal.
    fn begin(&mut self, goal: &ReachGoal<V>);
    /// The next action.
    fn act(&mut self, situation: &[f64; V]) -> [f64; A];
    /// A move on the way to a goal.
    fn moved(&mut self, _before: &[f64; V], _action: &[f64; A], _after: &[f64; V]) {}
}

/// A random action.
fn random_action<const A: usize>(noise: &mut Noise) -> [f64; A] {
    std::array::from_fn(|_| noise.uniform_in(-1.0, 1.0))
}
