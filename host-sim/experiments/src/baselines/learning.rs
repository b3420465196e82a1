//! What the learning baselines share: situations, rewards, exploration, and their policy.
//!
//! Reward after C. Touzet, Robotics and Autonomous Systems 22, 1997, 251–281 (abstract): +1 when
//! the sum of values falls, −1 when front or rear exceed a threshold. Front: sensors within 90° of
//! the move. Ours: −1 for a contact.

use arena::noise::Noise;
use arena::world::Point;
use sim::ring_pilot::{MotionOutcome, Perception, Policy, STEP_M, axis};
use std::f64::consts::{PI, TAU};

/// A situation: per transducer 1 = obstacle at its face, 0 = nothing within the far limit.
pub type Values = [f64; 16];

/// One move and its result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experience {
    /// Situation before the move.
    pub before: Values,
    /// Commanded move in units of a whole step (length at most 1), in the ring's frame.
    pub commanded: Point,
    /// Executed move, in the same unit.
    pub moved: Point,
    /// Situation after the move.
    pub after: Values,
    /// The reward.
    pub reward: f64,
}

impl Experience {
    /// The same experience rotated by `places` of the ring's 16 steps: ring and body are symmetric.
    #[must_use]
    pub fn rotated(&self, places: usize) -> Self {
        let turn = axis(places);
        Self {
            before: amp::scan::rotated(&self.before, places),
            commanded: self.commanded.turned(turn),
            moved: self.moved.turned(turn),
            after: amp::scan::rotated(&self.after, places),
            reward: self.reward,
        }
    }
}

/// A method that learns from moves which move is best.
pub trait Learner: Clone {
    /// The best move, in units of a whole step in the ring's frame; among equals the one nearest to
    /// `course` (a unit vector).
    fn best(&self, situation: &Values, course: Point) -> Point;

    /// Learns from one move.
    fn learn(&mut self, experience: &Experience);

    /// An exploring move; `None` = a random direction.
    fn variation(&self, _situation: &Values, _course: Point, _noise: &mut Noise) -> Option<Point> {
        None
    }

    /// Called once when exploration ends: precomputes what depends on all experiences.
    fn settle(&mut self) {}

    /// Bytes of the learned state.
    fn bytes(&self) -> usize;
}

/// The thresholds of the reward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reward {
    /// +1 when the sum of the 16 values falls by more than this.
    pub fallen: f64,
    /// −1 when the nine values in front sum to more than this.
    pub in_front: f64,
    /// −1 when the seven values behind sum to more than this.
    pub behind: f64,
}

impl Reward {
    /// The reward of a move.
    #[must_use]
    pub fn of(&self, before: &Values, moved: Point, after: &Values, touched: bool) -> f64 {
        let (mut in_front, mut behind) = (0.0, 0.0);
        for (sensor, value) in after.iter().enumerate() {
            // A sensor at exactly 90° counts as front, whatever the cosine's rounding.
            if axis(sensor).dot(moved) > -1e-9 {
                in_front += value;
            } else {
                behind += value;
            }
        }
        let sum = |values: &Values| values.iter().sum::<f64>();
        if touched || in_front > self.in_front || behind > self.behind {
            -1.0
        } else if sum(before) - sum(after) > self.fallen {
            1.0
        } else {
            0.0
        }
    }
}

/// How a learner is trained.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearnerTraining {
    /// Far limit: obstacles beyond it are not perceived, m.
    pub far_m: f64,
    /// The reward.
    pub reward: Reward,
    /// Share of exploring moves after n moves: `explores_least` + (1 − `explores_least`)
    /// e^(−n/`explores_for`).
    pub explores_for: f64,
    /// Final share of exploring moves, 0 … 1.
    pub explores_least: f64,
    /// Each move is learned in this many rotations of the ring: 1 (as executed) or 16 (all).
    pub turns: usize,
    /// While no value exceeds this, a move that does not explore keeps the heading. Below 0 =
    /// never.
    pub free_below: f64,
    /// Learning continues after exploration.
    pub learns_on: bool,
}

/// A policy that drives by a learner and trains it.
#[derive(Debug, Clone)]
pub struct LearnerDriver<L> {
    learner: L,
    training: LearnerTraining,
    noise: Noise,
    exploring: bool,
    learning: bool,
    moves: u32,
    contacts: u32,
    /// Situation in which the current move was chosen.
    before: Option<Values>,
    /// Unit vector of the last move in the ring's present frame.
    course: Point,
}

impl<L: Learner> LearnerDriver<L> {
    /// An untrained learner; `seed` fixes its exploration.
    #[must_use]
    pub fn new(learner: L, training: LearnerTraining, seed: u64) -> Self {
        Self {
            learner,
            training,
            noise: Noise::new(seed),
            exploring: true,
            learning: true,
            moves: 0,
            contacts: 0,
            before: None,
            course: Point::new(1.0, 0.0),
        }
    }

    /// Moves from which it has learned.
    #[must_use]
    pub fn moves(&self) -> u32 {
        self.moves
    }

    /// Those of them with contact.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// The learner.
    #[must_use]
    pub fn learner(&self) -> &L {
        &self.learner
    }

    /// A copy without exploration: it takes the best move only, and starts along `course` (rad).
    #[must_use]
    pub fn settled(&self, course: f64) -> Self {
        let mut settled = self.clone();
        settled.learner.settle();
        settled.exploring = false;
        settled.learning = self.training.learns_on;
        settled.before = None;
        settled.course = Point::unit(course);
        settled
    }

    fn perceive(&self, perceived: &Perception) -> Values {
        std::array::from_fn(|sensor| {
            (1.0 - perceived.range_m(sensor) / self.training.far_m).max(0.0)
        })
    }

    fn learn(&mut self, before: &Values, done: &MotionOutcome, after: &Values) {
        let steps = 1.0 / STEP_M;
        let experience = Experience {
            before: *before,
            commanded: done.wanted * steps,
            moved: done.moved * steps,
            after: *after,
            reward: self
                .training
                .reward
                .of(before, done.wanted, after, done.touched),
        };
        self.moves += 1;
        self.contacts += u32::from(done.touched);
        for turn in 0..self.training.turns {
            self.learner
                .learn(&experience.rotated(turn * 16 / self.training.turns));
        }
    }

    fn explores(&mut self) -> bool {
        let LearnerTraining {
            explores_for,
            explores_least,
            ..
        } = self.training;
        let fading = libm::exp(-f64::from(self.moves) / explores_for);
        let share = explores_least + (1.0 - explores_least) * fading;
        self.exploring && self.noise.chance(share)
    }

    fn choose(&mut self, situation: &Values) -> Point {
        if self.explores() {
            let varied = self
                .learner
                .variation(situation, self.course, &mut self.noise);
            varied.unwrap_or_else(|| Point::unit(self.noise.uniform_in(0.0, TAU)))
        } else if situation
            .iter()
            .all(|value| *value <= self.training.free_below)
        {
            self.course
        } else {
            self.learner.best(situation, self.course)
        }
    }
}

impl<L: Learner> Policy for LearnerDriver<L> {
    fn decide(&mut self, perceived: &Perception) -> Point {
        let situation = self.perceive(perceived);
        if let (true, Some(before), Some(done)) = (self.learning, self.before, &perceived.last) {
            self.learn(&before, done, &situation);
        }
        let turned = f64::from(perceived.turned.as_signed_turns()) * PI / 32_768.0;
        self.course = self.course.turned_back(Point::unit(turned));
        let step = self.choose(&situation);
        let length = step.length();
        if length > 1e-6 {
            self.course = step * (1.0 / length);
        }
        self.before = Some(situation);
        step * STEP_M
    }

    fn bytes(&self) -> usize {
        self.learner.bytes()
    }
}

/// The candidate with the greatest value; among equals the one nearest to `course`.
pub(super) fn best_of(candidates: impl Iterator<Item = (Point, f64)>, course: Point) -> Point {
    let better = |(best, most): (Point, f64), (move_, value): (Point, f64)| {
        let nearer = move_.dot(course) > best.dot(course);
        if value > most || (value == most && nearer) {
            (move_, value)
        } else {
            (best, most)
        }
    };
    candidates.reduce(better).map_or(course, |(best, _)| best)
}

/// The 16 moves of a whole step along the transducers' axes.
pub(super) fn headings() -> [Point; 16] {
    std::array::from_fn(axis)
}

#[cfg(test)]
mod tests {
    use super::*;

    const REWARD: Reward = Reward {
        fallen: 0.5,
        in_front: 3.0,
        behind: 2.0,
    };

    #[test]
    fn reinforcement_by_hand() {
        let ahead = Point::new(1.0, 0.0);
        let quiet = [0.1; 16];
        let of = |before: &Values, after: &Values| REWARD.of(before, ahead, after, false);
        assert_eq!(of(&quiet, &quiet), 0.0);
        // From 16 · 0.2 to 16 · 0.1 the sum falls by 1.6.
        assert_eq!(of(&[0.2; 16], &quiet), 1.0);
        assert_eq!(REWARD.of(&[0.2; 16], ahead, &quiet, true), -1.0);
        // Nine in front of 0.34 are 3.06, seven behind 2.38; of 0.29 they are 2.61 and 2.03.
        let mut front = [0.0; 16];
        (0..16)
            .filter(|i| !(5..12).contains(i))
            .for_each(|i| front[i] = 0.34);
        assert_eq!(of(&[1.0; 16], &front), -1.0);
        let mut rear = [0.0; 16];
        rear[5..12].fill(0.29);
        assert_eq!(of(&[1.0; 16], &rear), -1.0);
        rear[5..12].fill(0.28);
        assert_eq!(of(&[1.0; 16], &rear), 1.0);
    }

    #[test]
    fn a_turned_experience_is_the_same_one_seen_from_elsewhere() {
        let mut before = [0.0; 16];
        before[1] = 0.5;
        let experience = Experience {
            before,
            commanded: Point::new(1.0, 0.0),
            moved: Point::new(0.0, 0.5),
            after: [0.0; 16],
            reward: 1.0,
        };
        let turned = experience.rotated(4);
        assert_eq!(turned.before[5], 0.5);
        assert!(turned.commanded.distance(Point::new(0.0, 1.0)) < 1e-12);
        assert!(turned.moved.distance(Point::new(-0.5, 0.0)) < 1e-12);
        assert_eq!(experience.rotated(0), experience);
    }

    #[test]
    fn among_equals_the_course_is_kept() {
        let course = Point::unit(1.6);
        let flat = headings().map(|heading| (heading, 0.0));
        assert!(best_of(flat.into_iter(), course).distance(axis(4)) < 1e-12);
        let one = headings().map(|heading| (heading, -heading.x));
        assert!(best_of(one.into_iter(), course).distance(axis(8)) < 1e-12);
    }
}
