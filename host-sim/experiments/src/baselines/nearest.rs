//! Baseline: the lazy memory without maps; the nearest sample supplies the move.
//!
//! C. Touzet, *Modeling and simulation of elementary robot behaviors using associative memories*,
//! International Journal of Advanced Robotic Systems 3(2), 2006, section 2.2, argues that samples
//! alone are too few. Same random moves and goal as the controller.

use super::learning::{Experience, Learner, LearnerTraining, Reward, Values};
use super::rotation::RotatableRing;
use arena::noise::Noise;
use arena::world::Point;

/// Which part of a sample is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleKey {
    /// The direction of its change of situation with the wanted change.
    Change,
    /// Its situations before and after with the present and the wanted situation.
    Pair,
}

/// Far limit: obstacles beyond it are not perceived, m.
pub const FAR_M: f64 = 1.5;

/// Random moves only, without reward; the heading is kept while the goal is met. `far_m`: far
/// limit.
#[must_use]
pub const fn training(tuning: &NearestTuning, far_m: f64) -> LearnerTraining {
    LearnerTraining {
        far_m,
        reward: Reward {
            fallen: 0.0,
            in_front: 0.0,
            behind: 0.0,
        },
        explores_for: 1.0,
        explores_least: 1.0,
        turns: 1,
        free_below: tuning.goal,
        learns_on: false,
    }
}

/// The method's constants; the defaults were tuned in rooms that no comparison uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestTuning {
    /// Which part of a sample is compared.
    pub key: SampleKey,
    /// The goal is met when no value exceeds this.
    pub goal: f64,
    /// Each sample counts in this many rotations of the ring: 1 or 16.
    pub turns: usize,
}

impl NearestTuning {
    /// Compares the direction of the change.
    pub const CHANGE: Self = Self {
        key: SampleKey::Change,
        goal: 0.6,
        turns: 16,
    };

    /// Compares the pair of situations.
    pub const PAIR: Self = Self {
        key: SampleKey::Pair,
        goal: 0.2,
        turns: 16,
    };
}

/// The stored samples.
#[derive(Debug, Clone)]
pub struct NearestSample {
    tuning: NearestTuning,
    samples: Vec<StoredSample>,
}

/// The compared parts of an experience.
#[derive(Debug, Clone)]
struct StoredSample {
    before: RotatableRing,
    after: RotatableRing,
    /// Change of situation, normalized to length 1; 0 where nothing changed.
    change: RotatableRing,
    moved: Point,
}

impl NearestSample {
    /// An empty memory.
    #[must_use]
    pub fn new(tuning: NearestTuning) -> Self {
        Self {
            tuning,
            samples: Vec::new(),
        }
    }

    /// Distance of a sample, rotated by `places`, from the wanted one.
    fn mismatch(&self, now: &Values, wanted: &Values, sample: &StoredSample, places: usize) -> f64 {
        match self.tuning.key {
            SampleKey::Pair => {
                sample.before.squared_distance(now, places)
                    + sample.after.squared_distance(wanted, places)
            }
            SampleKey::Change => {
                let commanded: Values = std::array::from_fn(|i| wanted[i] - now[i]);
                -sample.change.product(&commanded, places)
            }
        }
    }
}

impl Learner for NearestSample {
    fn best(&self, situation: &Values, course: Point) -> Point {
        let goal = self.tuning.goal;
        let wanted = situation.map(|value| value.min(goal));
        let mut best = (f64::INFINITY, course);
        for sample in &self.samples {
            for turn in 0..self.tuning.turns {
                let places = turn * 16 / self.tuning.turns;
                let mismatch = self.mismatch(situation, &wanted, sample, places);
                if mismatch < best.0 {
                    best = (mismatch, sample.moved.turned(sim::ring_pilot::axis(places)));
                }
            }
        }
        // Moves are whole steps, as those of the controller.
        let length = best.1.length();
        if length > 1e-3 {
            best.1 * (1.0 / length)
        } else {
            course
        }
    }

    fn learn(&mut self, experience: &Experience) {
        let Experience { before, after, .. } = experience;
        let change: Values = std::array::from_fn(|i| after[i] - before[i]);
        let length = change.iter().map(|part| part * part).sum::<f64>().sqrt();
        // A sample without change has no direction.
        let scale = if length > 1e-6 { 1.0 / length } else { 0.0 };
        self.samples.push(StoredSample {
            before: RotatableRing::new(before),
            after: RotatableRing::new(after),
            change: RotatableRing::new(&change.map(|part| part * scale)),
            moved: experience.moved,
        });
    }

    fn variation(&self, _: &Values, _: Point, noise: &mut Noise) -> Option<Point> {
        let direction = Point::unit(noise.uniform_in(0.0, std::f64::consts::TAU));
        Some(direction * noise.uniform())
    }

    fn bytes(&self) -> usize {
        // Two situations and a displacement; the other fields are caches.
        self.samples.len() * (2 * size_of::<Values>() + size_of::<Point>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::ring_pilot::axis;

    fn value(sensor: usize, value: f64) -> Values {
        let mut values = [0.0; 16];
        values[sensor] = value;
        values
    }

    /// Toward what sensor 0 perceives, and away from it.
    fn trained(key: SampleKey, turns: usize) -> NearestSample {
        let mut nearest = NearestSample::new(NearestTuning {
            key,
            goal: 0.2,
            turns,
        });
        for (heading, before, after) in [(0, 0.4, 0.6), (8, 0.7, 0.5)] {
            nearest.learn(&Experience {
                before: value(0, before),
                commanded: axis(heading),
                moved: axis(heading) * 0.5,
                after: value(0, after),
                reward: 0.0,
            });
        }
        nearest
    }

    #[test]
    fn the_sample_whose_change_is_wanted_is_repeated() {
        for key in [SampleKey::Change, SampleKey::Pair] {
            let plain = trained(key, 1);
            assert!(plain.best(&value(0, 0.8), axis(0)).distance(axis(8)) < 1e-9);
            let turned = trained(key, 16);
            assert!(turned.best(&value(3, 0.8), axis(0)).distance(axis(11)) < 1e-9);
        }
    }
}
