//! The couple of maps of `amp` as a method.

use super::{ReachGoal, Reacher};
use amp::couple::{Avoided, Couple, CoupleConfig, CoupleGoal, CoupleSample, Seek};
use amp::fixed::Weight;
use amp::goal::Component;

/// Room for so many random moves.
const MEMORY: usize = 1_000;

/// Limits of the joint values that are asked for: what lies beyond cannot be.
const JOINT_VALUES: [f64; 2] = [0.01, 0.99];

/// A couple of maps.
pub(super) struct Maps<const V: usize, const A: usize, const N: usize> {
    config: CoupleConfig,
    couple: Box<Couple<V, A, N, MEMORY>>,
    seek: Seek<N>,
    goal: CoupleGoal<V>,
    learns_on: bool,
    /// Neuron pursued by the last action.
    pub(super) subgoal: Option<usize>,
}

impl<const V: usize, const A: usize, const N: usize> Maps<V, A, N> {
    /// Maps of `columns` × `N / columns` neurons; `learns_on` while reaching.
    pub(super) fn new(columns: u16, learns_on: bool, seed: u64) -> Self {
        let rows = u16::try_from(N).unwrap_or(u16::MAX) / columns.max(1);
        let config = CoupleConfig::of_grid(columns, rows);
        Self {
            config,
            couple: Box::new(Couple::new(&config, seed)),
            seek: Seek::new(),
            goal: CoupleGoal::of([Component::ANY; V]),
            learns_on,
            subgoal: None,
        }
    }
}

fn weights<const N: usize>(values: &[f64; N]) -> [Weight; N] {
    values.map(weight)
}

fn weight(value: f64) -> Weight {
    Weight::from_num(value.clamp(-1.0, 1.0))
}

fn sample<const V: usize, const A: usize>(
    before: &[f64; V],
    action: &[f64; A],
    after: &[f64; V],
) -> CoupleSample<V, A> {
    CoupleSample {
        before: weights(before),
        action: weights(action),
        after: weights(after),
    }
}

/// The goal as intervals: the sensed values equal the target's, the joints keep off their limits.
fn intervals<const V: usize>(goal: &ReachGoal<V>) -> CoupleGoal<V> {
    let [low, high] = JOINT_VALUES.map(weight);
    let component = |index: usize| match goal.values.get(index) {
        Some(value) if index < goal.sensed => Component::equal(weight(*value)),
        _ => Component {
            low,
            high,
            weight: 1,
        },
    };
    let avoided = goal.avoided.map(|region| Avoided {
        components: std::array::from_fn(|index| match region.center.get(index) {
            Some(value) if index < goal.sensed => Component::equal(weight(*value)),
            _ => Component::ANY,
        }),
        distance: weight(region.radius),
    });
    CoupleGoal {
        avoided,
        ..CoupleGoal::of(std::array::from_fn(component))
    }
}

impl<const V: usize, const A: usize, const N: usize> Reacher<V, A> for Maps<V, A, N> {
    fn explored(&mut self, before: &[f64; V], action: &[f64; A], after: &[f64; V]) {
        self.couple.remember(sample(before, action, after));
    }

    fn learn(&mut self) {
        while !self.couple.learn(&self.config) {}
    }

    fn begin(&mut self, goal: &ReachGoal<V>) {
        self.goal = intervals(goal);
        self.seek = Seek::new();
    }

    fn act(&mut self, situation: &[f64; V]) -> [f64; A] {
        let situation = weights(situation);
        let plan = (self.couple).plan(&self.config, &situation, &self.goal, &mut self.seek);
        self.subgoal = plan.subgoal_neuron;
        plan.action.map(|share| share.to_num())
    }

    fn moved(&mut self, before: &[f64; V], action: &[f64; A], after: &[f64; V]) {
        if self.learns_on {
            let sample = sample(before, action, after);
            self.couple.correct(&self.config, &sample);
        }
    }
}
