//! Smith's method for an arm: Q-learning between a map of targets and a map of postures.
//!
//! A. J. Smith, "Applications of the self-organising map to reinforcement learning", Neural
//! Networks 15, 2002, 1107–1124; our reading, with one decision per target. With target neuron j,
//! posture neuron k varied to u, and the reward r = −(distance of the hand from the target):
//!
//! ```text
//! if r > Q[j, k]:  the posture map learns u around k
//! Q[m, n] ← Q[m, n] + α φ(j, m) φ(k, n) (r − Q[m, n])     for all m, n
//! the target map learns the target
//! ```

use super::body::{ArmBody, distance};
use super::{ReachGoal, Reacher};
use arena::noise::Noise;

/// Neurons along each side of both maps.
const SIDE: usize = 6;
const NEURONS: usize = SIDE * SIDE;
/// α of the Q rule.
const RATE: f64 = 0.5;
/// Learning rate of the maps, and its lower limit.
const MAP_RATE: [f64; 2] = [0.5, 0.05];
/// Width of φ in grid steps, and its lower limit.
const WIDTH: [f64; 2] = [2.0, 0.3];
/// Share of random neurons, and its lower limit.
const EXPLORES: [f64; 2] = [1.0, 0.1];
/// Greatest variation of a posture, in units of the range of each joint, and its lower limit.
const VARIES: [f64; 2] = [0.3, 0.02];

/// Two maps and a value for each pair of their neurons.
pub(super) struct QArm<'b, const A: usize> {
    body: &'b ArmBody,
    /// Tries for each random move of the other methods.
    times: u32,
    tries: u32,
    noise: Noise,
    targets: Vec<[f64; 2]>,
    postures: Vec<[f64; A]>,
    values: Vec<[f64; NEURONS]>,
    posture: [f64; A],
}

impl<'b, const A: usize> QArm<'b, A> {
    pub(super) fn new(body: &'b ArmBody, times: u32, seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        let postures = (0..NEURONS).map(|_| std::array::from_fn(|_| noise.uniform()));
        let postures = postures.collect();
        let at = |k: usize| [k % SIDE, k / SIDE].map(|i| (i as f64 + 0.5) / SIDE as f64);
        Self {
            body,
            times,
            tries: 0,
            targets: (0..NEURONS).map(at).collect(),
            postures,
            // Worse than any distance: each pair is tried.
            values: vec![[-2.0; NEURONS]; NEURONS],
            posture: body.middle(),
            noise,
        }
    }

    fn neuron(&self, target: [f64; 2]) -> usize {
        let squared = |k: &usize| {
            let [x, y] = self.targets[*k];
            (x - target[0]) * (x - target[0]) + (y - target[1]) * (y - target[1])
        };
        let nearest = (0..NEURONS).min_by(|a, b| squared(a).total_cmp(&squared(b)));
        nearest.unwrap_or(0)
    }

    fn best(&self, neuron: usize) -> usize {
        let row = &self.values[neuron];
        let best = (0..NEURONS).max_by(|a, b| row[*a].total_cmp(&row[*b]));
        best.unwrap_or(0)
    }

    /// Joint angles of a posture given in shares of the ranges, radians.
    fn angles(&self, shares: &[f64; A]) -> [f64; A] {
        std::array::from_fn(|j| {
            let [low, high] = self.body.joints[j].limits_deg.map(f64::to_radians);
            low + shares[j] * (high - low)
        })
    }

    /// One try: a random reachable target, a varied posture, the distance.
    fn attempt(&mut self, progress: f64) {
        let faded = |[start, end]: [f64; 2]| start * libm::pow(end / start, progress);
        let goal: [f64; A] = self.body.random_posture(&mut self.noise);
        let target_m = self.body.hand_m(&goal);
        let [x, y, _] = self.body.seen(target_m);
        let state = self.neuron([x, y]);
        let explores = self.noise.chance(faded(EXPLORES));
        let any = self.noise.index(NEURONS);
        let action = if explores { any } else { self.best(state) };
        let most = faded(VARIES);
        let varied: [f64; A] = std::array::from_fn(|j| {
            let by = self.noise.uniform_in(-most, most);
            (self.postures[action][j] + by).clamp(0.0, 1.0)
        });
        let hand_m = self.body.hand_m(&self.angles(&varied));
        let reward = -distance(hand_m, target_m) / self.body.reach_m();
        let width = faded(WIDTH);
        let (near_state, near_action) = (nearness(state, width), nearness(action, width));
        let rate = faded(MAP_RATE);
        if reward > self.values[state][action] {
            for (code, near) in self.postures.iter_mut().zip(&near_action) {
                for (part, wanted) in code.iter_mut().zip(&varied) {
                    *part += rate * near * (wanted - *part);
                }
            }
        }
        for (row, near) in self.values.iter_mut().zip(&near_state) {
            if *near < 1e-3 {
                continue;
            }
            for (value, other) in row.iter_mut().zip(&near_action) {
                *value += RATE * near * other * (reward - *value);
            }
        }
        for (code, near) in self.targets.iter_mut().zip(&near_state) {
            for (part, wanted) in code.iter_mut().zip([x, y]) {
                *part += 0.1 * rate * near * (wanted - *part);
            }
        }
    }
}

/// φ between one neuron and each of them.
fn nearness(neuron: usize, width: f64) -> [f64; NEURONS] {
    let along: [f64; SIDE] = std::array::from_fn(|apart| {
        let apart = apart as f64;
        libm::exp(-apart * apart / (2.0 * width * width))
    });
    std::array::from_fn(|other| {
        let (x, y) = (neuron % SIDE, neuron / SIDE);
        along[x.abs_diff(other % SIDE)] * along[y.abs_diff(other / SIDE)]
    })
}

impl<const V: usize, const A: usize> Reacher<V, A> for QArm<'_, A> {
    fn explored(&mut self, _before: &[f64; V], _action: &[f64; A], _after: &[f64; V]) {
        self.tries += self.times;
    }

    fn learn(&mut self) {
        let last = f64::from(self.tries.max(2) - 1);
        for number in 0..self.tries {
            self.attempt(f64::from(number) / last);
        }
    }

    fn begin(&mut self, goal: &ReachGoal<V>) {
        let state = self.neuron([goal.values[0], goal.values[1]]);
        let best = self.best(state);
        self.posture = self.angles(&self.postures[best]);
    }

    fn act(&mut self, situation: &[f64; V]) -> [f64; A] {
        let now = super::controls::posture(self.body, situation);
        self.body.action(&now, &self.posture)
    }
}
