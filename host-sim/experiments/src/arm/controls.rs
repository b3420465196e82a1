//! Controls: other methods with the same random moves, and one that knows the geometry.

use super::body::ArmBody;
use super::inverse;
use super::least_squares::{Limit, Rows, fit, solve};
use super::{ReachGoal, Reacher, random_action};
use arena::noise::Noise;

/// Moves without progress until another posture is tried, as for the maps.
const PATIENCE: u8 = 4;
/// A posture is reached within this, as for the maps: root mean square.
const NEAR: f64 = 0.033;
/// Room beyond a region, and clearance below which moves are shorter, as for the maps.
const MARGIN: f64 = 0.03;
const SLOW: f64 = 0.2;
/// Moves that are remembered, at most.
const MAX_REMEMBERED: usize = 1_000;

/// Random moves without end.
pub(super) struct RandomMoves(pub(super) Noise);

impl<const V: usize, const A: usize> Reacher<V, A> for RandomMoves {
    fn begin(&mut self, _goal: &ReachGoal<V>) {}

    fn act(&mut self, _situation: &[f64; V]) -> [f64; A] {
        random_action(&mut self.0)
    }
}

/// The joint angles of a situation, in radians.
pub(super) fn posture<const V: usize, const A: usize>(
    body: &ArmBody,
    situation: &[f64; V],
) -> [f64; A] {
    let joints = &situation[body.view.values()..];
    std::array::from_fn(|j| {
        let [low, high] = body.joints[j].limits_deg.map(f64::to_radians);
        low + joints[j] * (high - low)
    })
}

/// Analytic inverse kinematics: goes straight to the posture that needs the fewest moves.
pub(super) struct Analytic<'b, const V: usize> {
    pub(super) body: &'b ArmBody,
    pub(super) goal: Option<ReachGoal<V>>,
}

impl<const V: usize, const A: usize> Reacher<V, A> for Analytic<'_, V> {
    fn begin(&mut self, goal: &ReachGoal<V>) {
        self.goal = Some(*goal);
    }

    fn act(&mut self, situation: &[f64; V]) -> [f64; A] {
        let now: [f64; A] = posture(self.body, situation);
        let Some(goal) = self.goal else {
            return [0.0; A];
        };
        let longest = |to: &[f64; A]| {
            let gaps = to.iter().zip(&now).map(|(a, b)| (a - b).abs());
            gaps.fold(0.0, f64::max)
        };
        let found = inverse::postures::<A>(self.body, goal.hand_m).into_iter();
        let nearest = found.min_by(|a, b| longest(a).total_cmp(&longest(b)));
        nearest.map_or([0.0; A], |to| self.body.action(&now, &to))
    }
}

/// One random move: before, action, after.
type Move<const V: usize, const A: usize> = ([f64; V], [f64; A], [f64; V]);

/// The mean posture of the k remembered situations whose hand is nearest to the target.
pub(super) struct Nearest<'b, const V: usize, const A: usize> {
    body: &'b ArmBody,
    neighbors: usize,
    moves: Vec<Move<V, A>>,
    target: [f64; A],
}

impl<'b, const V: usize, const A: usize> Nearest<'b, V, A> {
    pub(super) fn new(body: &'b ArmBody, neighbors: usize) -> Self {
        Self {
            body,
            neighbors,
            moves: Vec::new(),
            target: [0.0; A],
        }
    }
}

impl<const V: usize, const A: usize> Reacher<V, A> for Nearest<'_, V, A> {
    fn explored(&mut self, before: &[f64; V], action: &[f64; A], after: &[f64; V]) {
        self.moves.push((*before, *action, *after));
    }

    fn begin(&mut self, goal: &ReachGoal<V>) {
        let mut known: Vec<_> = self.moves.iter().map(|(.., after)| after).collect();
        known.sort_by(|a, b| goal.distance(a).total_cmp(&goal.distance(b)));
        known.truncate(self.neighbors);
        let count = known.len().max(1) as f64;
        self.target = [0.0; A];
        for situation in known {
            let angles: [f64; A] = posture(self.body, situation);
            for (sum, angle) in self.target.iter_mut().zip(angles) {
                *sum += angle / count;
            }
        }
    }

    fn act(&mut self, situation: &[f64; V]) -> [f64; A] {
        let now = posture(self.body, situation);
        self.body.action(&now, &self.target)
    }
}

/// Where a linear model of the changes is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Model {
    /// One least-squares fit to all random moves.
    Global,
    /// A fit to this many random moves from the most similar situations.
    Local(usize),
    /// The same, and every further move is remembered.
    LocalOn(usize),
    /// The geometry.
    Exact,
}

/// The planner of the maps without maps: a linear model of the raw samples, and remembered
/// situations in the place of neurons.
pub(super) struct Linear<'b, const V: usize, const A: usize> {
    body: &'b ArmBody,
    model: Model,
    moves: Vec<Move<V, A>>,
    global: Rows<V, A>,
    goal: Option<ReachGoal<V>>,
    /// The remembered situation that is pursued; `None` = the goal.
    pursued: Option<usize>,
    tried: Vec<bool>,
    least: f64,
    since: u8,
    has_begun: bool,
}

impl<'b, const V: usize, const A: usize> Linear<'b, V, A> {
    pub(super) fn new(body: &'b ArmBody, model: Model) -> Self {
        Self {
            body,
            model,
            moves: Vec::new(),
            global: [[0.0; V]; A],
            goal: None,
            pursued: None,
            tried: Vec::new(),
            least: f64::INFINITY,
            since: 0,
            has_begun: false,
        }
    }

    fn rows(&self, situation: &[f64; V]) -> Rows<V, A> {
        match self.model {
            Model::Global => self.global,
            Model::Local(count) | Model::LocalOn(count) => {
                let mut near: Vec<_> = (self.moves.iter())
                    .map(|taken| (squared(&taken.0, situation), taken))
                    .collect();
                if count < near.len() {
                    near.select_nth_unstable_by(count, |a, b| a.0.total_cmp(&b.0));
                    near.truncate(count);
                    // The order of the sums must not depend on the selection's.
                    near.sort_by(|a, b| a.0.total_cmp(&b.0));
                }
                fit(near.into_iter().map(|(_, taken)| change(taken)))
            }
            Model::Exact => self.exact(situation),
        }
    }

    /// Central differences of the true kinematics.
    fn exact(&self, situation: &[f64; V]) -> Rows<V, A> {
        const SMALL: f64 = 1e-4;
        let now: [f64; A] = posture(self.body, situation);
        let step = self.body.step_deg.to_radians();
        std::array::from_fn(|j| {
            let [before, after]: [[f64; V]; 2] = [-SMALL, SMALL].map(|by| {
                let mut angles = now;
                angles[j] += by * step;
                self.body.situation(&angles)
            });
            std::array::from_fn(|v| (after[v] - before[v]) / (2.0 * SMALL))
        })
    }

    fn next(&self, goal: &ReachGoal<V>) -> Option<usize> {
        let clear = |situation: &[f64; V]| {
            let sensed = &situation[..goal.sensed];
            (goal.avoided).is_none_or(|region| region.clearance(sensed) > MARGIN)
        };
        let all = self.moves.iter().map(|(.., after)| after).enumerate();
        let untried = all.filter(|(index, after)| !self.tried[*index] && clear(after));
        let nearest =
            untried.min_by(|(_, a), (_, b)| goal.distance(a).total_cmp(&goal.distance(b)));
        nearest.map(|(index, _)| index)
    }

    fn pursue(&mut self, next: Option<usize>) {
        if let Some(index) = next {
            self.tried[index] = true;
        }
        (self.pursued, self.least, self.since) = (next, f64::INFINITY, 0);
    }

    /// As `Seek` of `amp::couple`.
    fn choose(&mut self, goal: &ReachGoal<V>, situation: &[f64; V]) {
        if !self.has_begun {
            self.has_begun = true;
            let nearer = self
                .next(goal)
                .filter(|index| goal.distance(&self.moves[*index].2) < goal.distance(situation));
            return self.pursue(nearer);
        }
        let deviation = match self.pursued {
            None => goal.distance(situation).powi(2),
            Some(index) => squared(&self.moves[index].2, situation),
        };
        if deviation < self.least * 0.875 {
            (self.least, self.since) = (deviation, 0);
        } else {
            self.since += 1;
        }
        let is_stuck = self.since >= PATIENCE;
        if self.pursued.is_some() {
            if is_stuck || deviation <= NEAR * NEAR * V as f64 {
                self.pursue(None);
            }
        } else if is_stuck {
            let next = self.next(goal);
            if next.is_none() {
                self.tried.fill(false);
            }
            self.pursue(next);
        }
    }
}

fn change<const V: usize, const A: usize>(taken: &Move<V, A>) -> ([f64; A], [f64; V]) {
    let (before, action, after) = taken;
    (*action, std::array::from_fn(|v| after[v] - before[v]))
}

fn squared<const V: usize>(a: &[f64; V], b: &[f64; V]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

impl<const V: usize, const A: usize> Reacher<V, A> for Linear<'_, V, A> {
    fn explored(&mut self, before: &[f64; V], action: &[f64; A], after: &[f64; V]) {
        self.moves.push((*before, *action, *after));
    }

    fn learn(&mut self) {
        self.global = fit(self.moves.iter().map(change));
    }

    fn begin(&mut self, goal: &ReachGoal<V>) {
        self.goal = Some(*goal);
        self.tried = vec![false; self.moves.len()];
        self.has_begun = false;
    }

    fn act(&mut self, situation: &[f64; V]) -> [f64; A] {
        let Some(goal) = self.goal else {
            return [0.0; A];
        };
        self.choose(&goal, situation);
        let bounds = std::array::from_fn(|v| match self.pursued {
            Some(index) => [self.moves[index].2[v]; 2],
            None if v < goal.sensed => [goal.values[v]; 2],
            None => [0.01, 0.99],
        });
        let sensed = &situation[..goal.sensed];
        let limit = goal.avoided.map(|region| {
            let clearance = region.clearance(sensed);
            Limit {
                normal: region.normal(sensed),
                least: MARGIN - clearance,
                longest: (clearance / SLOW).clamp(0.2, 1.0),
            }
        });
        solve(&self.rows(situation), situation, &bounds, limit.as_ref())
    }

    fn moved(&mut self, before: &[f64; V], action: &[f64; A], after: &[f64; V]) {
        if matches!(self.model, Model::LocalOn(_)) && self.moves.len() < MAX_REMEMBERED {
            self.moves.push((*before, *action, *after));
            self.tried.push(true);
        }
    }
}
