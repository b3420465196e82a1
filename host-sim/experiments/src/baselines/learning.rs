//! What the learning baselines share: situations, rewards, exploration, and a policy that lets a [`Learner`] drive.
//!
//! The reinforcement is that of C. Touzet, *Neural reinforcement learning for behavior synthesis*, Robotics and Autonomous
//! Systems 22, 1997, 251–281, as generally known (only the abstract was at hand): +1 when the sum of all values has fallen
//! by more than a threshold, −1 when those in front or those behind sum above theirs, else 0. The Khepera's front is its
//! way of driving: our ring, held in the world, counts as in front what looks within a quarter turn of the move. Our
//! addition: −1 for a touch, which the Nomad's bumpers report.

use arena::noise::Noise;
use arena::world::Point;
use sim::ring_pilot::{MotionOutcome, Perception, Policy, STEP_M, axis};
use std::f64::consts::{PI, TAU};

/// A situation: per transducer 1 = something at its face, 0 = nothing within the far limit.
pub type Values = [f64; 16];

/// One move and what came of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experience {
    /// What was perceived before.
    pub before: Values,
    /// What was asked for, in whole steps (length at most 1) in the ring's frame.
    pub asked: Point,
    /// What was carried out, in the same unit.
    pub moved: Point,
    /// What was perceived afterwards.
    pub after: Values,
    /// The reinforcement.
    pub reward: f64,
}

impl Experience {
    /// The same with the ring turned by `places` of its 16 places: ring and body are symmetric.
    #[must_use]
    pub fn turned(&self, places: usize) -> Self {
        let turn = axis(places);
        Self {
            before: amp::scan::rotated(&self.before, places),
            asked: self.asked.turned(turn),
            moved: self.moved.turned(turn),
            after: amp::scan::rotated(&self.after, places),
            reward: self.reward,
        }
    }
}

/// Something that learns from moves which move is best.
pub trait Learner: Clone {
    /// The move it thinks best, in whole steps in the ring's frame; where several are equally good, that nearest to
    /// `course` (a unit vector).
    fn best(&self, situation: &Values, course: Point) -> Point;

    /// Learns from one move.
    fn learn(&mut self, experience: &Experience);

    /// A move to find out more, `None` = any direction.
    fn variation(&self, _situation: &Values, _course: Point, _noise: &mut Noise) -> Option<Point> {
        None
    }

    /// Exploring is over: what is to be worked out from all experiences, now is the time.
    fn settle(&mut self) {}

    /// Bytes of what it has learned.
    fn bytes(&self) -> usize;
}

/// The thresholds of the reinforcement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reward {
    /// +1 when the sum of the 16 values has fallen by more than this.
    pub fallen: f64,
    /// −1 when the nine values in front sum above this.
    pub in_front: f64,
    /// −1 when the seven values behind sum above this.
    pub behind: f64,
}

impl Reward {
    /// The reinforcement of a move.
    #[must_use]
    pub fn of(&self, before: &Values, moved: Point, after: &Values, touched: bool) -> f64 {
        let (mut in_front, mut behind) = (0.0, 0.0);
        for (sensor, value) in after.iter().enumerate() {
            // A quarter turn to either side still is in front, whatever the cosine's rounding.
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

/// How a learner is taught.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schooling {
    /// What is farther than this is not perceived, m.
    pub far_m: f64,
    /// The reinforcement.
    pub reward: Reward,
    /// Share of exploring moves after n moves: `explores_least` + (1 − `explores_least`) e^(−n/`explores_for`).
    pub explores_for: f64,
    /// Share of exploring moves in the end, 0 … 1.
    pub explores_least: f64,
    /// Each move is taught turned by so many of the ring's places as well, 1 (as it was) or 16 (all).
    pub turns: usize,
    /// Unless it explores, it keeps its course while no value is above this, as the mind does while its goal holds; below
    /// 0 = it never does.
    pub free_below: f64,
    /// It goes on learning from what it does when exploring is over.
    pub learns_on: bool,
}

/// A learner that drives.
#[derive(Debug, Clone)]
pub struct Trainee<L> {
    learner: L,
    schooling: Schooling,
    noise: Noise,
    exploring: bool,
    learning: bool,
    moves: u32,
    contacts: u32,
    /// What was perceived when the move under way was decided.
    before: Option<Values>,
    /// Unit vector of the last move in the ring's present frame.
    course: Point,
}

impl<L: Learner> Trainee<L> {
    /// A trainee that knows nothing; `seed` fixes its exploration.
    #[must_use]
    pub fn new(learner: L, schooling: Schooling, seed: u64) -> Self {
        Self {
            learner,
            schooling,
            noise: Noise::new(seed),
            exploring: true,
            learning: true,
            moves: 0,
            contacts: 0,
            before: None,
            course: Point::new(1.0, 0.0),
        }
    }

    /// Moves it has learned from.
    #[must_use]
    pub fn moves(&self) -> u32 {
        self.moves
    }

    /// Those of them that touched something.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// What has learned.
    #[must_use]
    pub fn learner(&self) -> &L {
        &self.learner
    }

    /// The same, done with exploring: from now on it only does what it thinks best, and starts along `course` (rad).
    #[must_use]
    pub fn settled(&self, course: f64) -> Self {
        let mut settled = self.clone();
        settled.learner.settle();
        settled.exploring = false;
        settled.learning = self.schooling.learns_on;
        settled.before = None;
        settled.course = Point::unit(course);
        settled
    }

    fn perceive(&self, perceived: &Perception) -> Values {
        std::array::from_fn(|sensor| {
            (1.0 - perceived.range_m(sensor) / self.schooling.far_m).max(0.0)
        })
    }

    fn learn(&mut self, before: &Values, done: &MotionOutcome, after: &Values) {
        let steps = 1.0 / STEP_M;
        let experience = Experience {
            before: *before,
            asked: done.wanted * steps,
            moved: done.moved * steps,
            after: *after,
            reward: self
                .schooling
                .reward
                .of(before, done.wanted, after, done.touched),
        };
        self.moves += 1;
        self.contacts += u32::from(done.touched);
        for turn in 0..self.schooling.turns {
            self.learner
                .learn(&experience.turned(turn * 16 / self.schooling.turns));
        }
    }

    fn explores(&mut self) -> bool {
        let Schooling {
            explores_for,
            explores_least,
            ..
        } = self.schooling;
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
            .all(|value| *value <= self.schooling.free_below)
        {
            self.course
        } else {
            self.learner.best(situation, self.course)
        }
    }
}

impl<L: Learner> Policy for Trainee<L> {
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

/// The candidate of greatest value; among equals that nearest to `course`.
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
        // From 16 · 0.2 to 16 · 0.1 is a fall of 1.6.
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
            asked: Point::new(1.0, 0.0),
            moved: Point::new(0.0, 0.5),
            after: [0.0; 16],
            reward: 1.0,
        };
        let turned = experience.turned(4);
        assert_eq!(turned.before[5], 0.5);
        assert!(turned.asked.distance(Point::new(0.0, 1.0)) < 1e-12);
        assert!(turned.moved.distance(Point::new(-0.5, 0.0)) < 1e-12);
        assert_eq!(experience.turned(0), experience);
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
