//! Controls for the table of robots: rules without maps, behind the same virtual turret.
//!
//! Each expects of every move how it changes the ranges, and avoids obstacles by picking the move
//! after which the least is nearer than a clearance. They differ in where the expectation is from.

use arena::noise::Noise;
use arena::world::Point;
use sim::ring_pilot::{Perception, Policy, STEP_M, axis};
use sim::statistics::PlaneFit;
use std::f64::consts::TAU;

/// Where a rule's expectation is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Geometry written down: a range shrinks by the cosine of the angle to the move.
    Cosine,
    /// Random moves: each range is linear in the move, fitted by least squares.
    LeastSquares,
    /// The same by least absolute deviations.
    Robust,
    /// Random moves: the mean of the five most similar ones.
    Nearest,
}

impl Control {
    /// Whether it learns from random moves.
    #[must_use]
    pub const fn learns(self) -> bool {
        !matches!(self, Self::Cosine)
    }
}

/// Moves to choose from.
const HEADINGS: usize = 32;
/// Random moves that [`Control::Nearest`] averages.
const NEIGHBORS: usize = 5;
/// Rounds of reweighting for least absolute deviations.
const ROUNDS: usize = 12;
/// Deviations below this weigh equally, m.
const LEAST_DEVIATION_M: f64 = 0.01;
/// Weight of keeping the course, m²: it decides only between free moves.
const COURSE_WEIGHT: f64 = 1e-4;

/// Ranges of all sectors, m; `None` = unknown.
type Ranges = [Option<f64>; 16];

/// A random move and what it changed.
#[derive(Debug, Clone, Copy)]
struct Sample {
    before: Ranges,
    after: Ranges,
    moved: Point,
}

impl Sample {
    fn change(&self, sector: usize) -> Option<f64> {
        Some(self.after[sector]? - self.before[sector]?)
    }
}

/// Avoids obstacles by expected changes.
#[derive(Debug, Clone)]
pub struct ControlPolicy {
    control: Control,
    clearance_m: f64,
    step_m: f64,
    course: Point,
    /// Random moves under way.
    random: Option<Noise>,
    last: Option<Ranges>,
    samples: Vec<Sample>,
    /// Change of each range by a step along each heading, m.
    expected: Vec<[f64; 16]>,
}

impl ControlPolicy {
    /// A rule that keeps `clearance_m` from obstacles by steps of `step_m`. One that
    /// [learns](Control::learns) first moves at random.
    #[must_use]
    pub fn new(control: Control, clearance_m: f64, step_m: f64, seed: u64) -> Self {
        let cosine = |move_: Point| std::array::from_fn(|sector| -axis(sector).dot(move_));
        Self {
            control,
            clearance_m,
            step_m: step_m.min(STEP_M),
            course: Point::new(1.0, 0.0),
            random: control.learns().then(|| Noise::new(seed)),
            last: None,
            samples: Vec::new(),
            expected: moves(step_m).map(cosine).collect(),
        }
    }

    /// Ends the random moves and learns from them.
    #[must_use]
    pub fn learned(mut self) -> Self {
        self.random = None;
        let effects: [[f64; 2]; 16] = match self.control {
            Control::Cosine => return self,
            Control::Nearest => {
                let nearest = |move_| std::array::from_fn(|sector| self.nearest(sector, move_));
                self.expected = moves(self.step_m).map(nearest).collect();
                return self;
            }
            Control::LeastSquares => std::array::from_fn(|sector| self.fit(sector, 1)),
            Control::Robust => std::array::from_fn(|sector| self.fit(sector, ROUNDS)),
        };
        let linear = |move_: Point| effects.map(|[x, y]| x * move_.x + y * move_.y);
        self.expected = moves(self.step_m).map(linear).collect();
        self
    }

    /// Change of a range per meter moved along x and y.
    fn fit(&self, sector: usize, rounds: usize) -> [f64; 2] {
        let mut effect = [0.0; 2];
        for round in 0..rounds {
            let mut fit = PlaneFit::default();
            for sample in &self.samples {
                let Some(change) = sample.change(sector) else {
                    continue;
                };
                let (x, y) = (sample.moved.x, sample.moved.y);
                let off = (change - effect[0] * x - effect[1] * y).abs();
                let weight = if round == 0 {
                    1.0
                } else {
                    1.0 / off.max(LEAST_DEVIATION_M)
                };
                fit.add(weight, [x, y], change);
            }
            let Some(slopes) = fit.slopes() else {
                return [0.0; 2];
            };
            effect = slopes;
        }
        effect
    }

    /// Mean change of a range by the random moves most similar to `move_`, m.
    fn nearest(&self, sector: usize, move_: Point) -> f64 {
        let changes = self.samples.iter().filter_map(|sample| {
            let change = sample.change(sector)?;
            Some((sample.moved.distance(move_), change))
        });
        let mut changes: Vec<_> = changes.collect();
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        changes.truncate(NEIGHBORS);
        changes.iter().map(|(_, change)| change).sum::<f64>() / changes.len().max(1) as f64
    }

    /// How much would be nearer than the clearance, m², and how much the course would change.
    fn cost(&self, ranges: &Ranges, changes: &[f64; 16], heading: Point) -> f64 {
        let gaps = ranges.iter().zip(changes).filter_map(|(range, change)| {
            let short = self.clearance_m - ((*range)? + change);
            Some(short.max(0.0).powi(2))
        });
        gaps.sum::<f64>() + COURSE_WEIGHT * (1.0 - heading.dot(self.course))
    }
}

impl Policy for ControlPolicy {
    fn decide(&mut self, perceived: &Perception) -> Point {
        let ranges = std::array::from_fn(|sector| {
            let range = perceived.range_m(sector);
            range.is_finite().then_some(range)
        });
        if let Some(noise) = &mut self.random {
            if let (Some(before), Some(last)) = (self.last, perceived.last) {
                self.samples.push(Sample {
                    before,
                    after: ranges,
                    moved: last.moved,
                });
            }
            self.last = Some(ranges);
            let heading = Point::unit(noise.uniform_in(0.0, TAU));
            return heading * noise.uniform_in(0.0, self.step_m);
        }
        let unit = 1.0 / self.step_m;
        let costs = moves(self.step_m)
            .zip(&self.expected)
            .map(|(move_, changes)| {
                let heading = move_ * unit;
                (self.cost(&ranges, changes, heading), heading)
            });
        if let Some((_, heading)) = costs.min_by(|a, b| a.0.total_cmp(&b.0)) {
            self.course = heading;
        }
        self.course * self.step_m
    }
}

/// A step along each heading.
fn moves(step_m: f64) -> impl Iterator<Item = Point> {
    (0..HEADINGS).map(move |i| Point::unit(TAU * i as f64 / HEADINGS as f64) * step_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room whose walls are flat from everywhere: ranges change by exact cosines, some wrongly.
    fn taught(control: Control, share_wrong: f64) -> ControlPolicy {
        let mut policy = ControlPolicy::new(control, 0.6, 0.25, 1);
        let mut noise = Noise::new(2);
        for _ in 0..300 {
            let moved = Point::unit(noise.uniform_in(0.0, TAU)) * noise.uniform_in(0.1, 0.25);
            let before = [Some(2.0); 16];
            let after = std::array::from_fn(|sector| {
                let exact = 2.0 - axis(sector).dot(moved);
                Some(if noise.chance(share_wrong) {
                    5.0
                } else {
                    exact
                })
            });
            policy.samples.push(Sample {
                before,
                after,
                moved,
            });
        }
        policy.learned()
    }

    fn worst_error_m(control: Control, share_wrong: f64) -> f64 {
        let written = ControlPolicy::new(Control::Cosine, 0.6, 0.25, 1).expected;
        let learned = taught(control, share_wrong).expected;
        let pairs = written.iter().flatten().zip(learned.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn each_control_learns_the_cosine() {
        for (control, most_m) in [
            (Control::LeastSquares, 1e-9),
            (Control::Robust, 1e-9),
            (Control::Nearest, 0.08),
        ] {
            let error_m = worst_error_m(control, 0.0);
            assert!(error_m < most_m, "{control:?}: {error_m}");
        }
    }

    #[test]
    fn only_the_robust_fit_stands_wrong_readings() {
        let errors_m = [Control::Robust, Control::LeastSquares].map(|c| worst_error_m(c, 0.1));
        assert!(errors_m[0] < 0.01 && errors_m[1] > 0.1, "{errors_m:?}");
    }
}
