//! What stands in the action map's place: the same linear prediction, from another source.
//!
//! The planner fits a linear map to the code vectors of the action map (change of situation by
//! displacement, least squares through the origin). Code vectors that lie exactly on a linear map
//! give it back, so any linear predictor can stand in the map's place and the planner stays as it
//! is. The local fit to the nearest samples is the unweighted form of locally weighted regression
//! (C. Atkeson, A. Moore, S. Schaal, AI Review 11, 1997).

use amp::action_map::ActionMap;
use amp::config::{Config, LearnFrom};
use amp::fixed::{Mask, Weight};
use amp::memory::{Sample, from_bytes};
use amp::som::Grid;
use amp::units::Direction;
use sim::statistics::PlaneFit;
use std::f64::consts::TAU;

/// What predicts the change of situation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Slot {
    /// The action map, as it was trained.
    Trained,
    /// Nothing learned: a value rises by `gain` · [`steepest`] · cos(angle between move and
    /// sensor) with each longest step.
    Cosine {
        /// 1 = as fast as towards a wall straight ahead.
        gain: f64,
    },
    /// Least squares on all samples.
    LeastSquares {
        /// Each sample counts in all rotations of the ring.
        turned: bool,
    },
    /// Before each decision, least squares on the samples whose situation before the move was most
    /// similar to the present one.
    Nearest {
        /// Number of samples.
        count: usize,
        /// Each sample counts in all rotations of the ring.
        turned: bool,
    },
}

/// Change of each sensor's value per longest step along x and along y; a value is in [0, 1], 1 =
/// obstacle at the near limit.
pub type Slopes = [[f64; 2]; 16];

/// Change of a value by the longest step straight towards a wall: the step divided by the range of
/// distances that the values cover. It follows from the configuration alone.
#[must_use]
pub fn steepest(config: &Config<16>) -> f64 {
    let covered = config.encoding.far_mm - config.encoding.near_mm;
    f64::from(config.robot.step_mm) / f64::from(covered.max(1))
}

/// The slopes where every sensor sees a wall that moves by the cosine of the angle between move and
/// sensor, times `gain`.
#[must_use]
pub fn cosine(config: &Config<16>, gain: f64) -> Slopes {
    let rise = gain * steepest(config);
    let axes = config.robot.directions.map(unit);
    axes.map(|axis| axis.map(|part| part * rise))
}

/// An action map whose linear fit has these slopes. Its actions are the longest steps along
/// `NEURONS` evenly spaced headings.
#[must_use]
pub fn coded<const NEURONS: usize>(slopes: &Slopes, grid: Grid) -> ActionMap<NEURONS, 16> {
    let actions: [[Weight; 2]; NEURONS] = std::array::from_fn(|neuron| {
        let angle = TAU * neuron as f64 / NEURONS as f64;
        [libm::cos(angle), libm::sin(angle)].map(weight)
    });
    let changes = actions.map(|action| {
        let [x, y] = action.map(|part| part.to_num::<f64>());
        slopes.map(|[along_x, along_y]| weight(along_x * x + along_y * y))
    });
    ActionMap::new(grid, changes, actions)
}

/// The nearest weight to a value, clamped to [−1, 1].
fn weight(value: f64) -> Weight {
    Weight::from_bits((value.clamp(-1.0, 1.0) * 8_192.0).round() as i16)
}

fn unit(direction: Direction) -> [f64; 2] {
    [direction.x_q14, direction.y_q14].map(|part| f64::from(part) / 16_384.0)
}

/// A random move in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct MoveSample {
    /// Situation before it.
    before: [f64; 16],
    /// Change of situation.
    change: [f64; 16],
    /// Sensors that met the same surface before and after.
    known: Mask,
    /// Displacement in units of the longest step.
    action: [f64; 2],
}

impl MoveSample {
    /// A remembered sample, as the action map learns it.
    #[must_use]
    pub fn of(config: &Config<16>, sample: &Sample<16>) -> Self {
        let (before, known_before) = from_bytes(&sample.before);
        let (after, known_after) = from_bytes(&sample.after);
        let moved = match config.learning.learn_from {
            LearnFrom::Commanded => sample.commanded,
            LearnFrom::Executed => sample.executed,
        };
        let before = before.map(|value| value.to_num());
        let after: [f64; 16] = after.map(|value| value.to_num());
        let step = f64::from(config.robot.step_mm);
        Self {
            before,
            change: std::array::from_fn(|sensor| after[sensor] - before[sensor]),
            known: known_before.and(known_after),
            action: [moved.dx_mm, moved.dy_mm].map(|mm| f64::from(mm) / step),
        }
    }

    /// The same with the ring turned by places of the ring.
    fn turned(&self, places: usize, config: &Config<16>) -> Self {
        let from = |sensor: usize| (sensor + 16 - places) % 16;
        let turn = |values: &[f64; 16]| std::array::from_fn(|sensor| values[from(sensor)]);
        let known = (0..16).filter(|sensor| self.known.contains(from(*sensor)));
        let ([x, y], [cos, sin]) = (self.action, unit(config.robot.directions[places]));
        Self {
            before: turn(&self.before),
            change: turn(&self.change),
            known: known.fold(Mask::NONE, Mask::with),
            action: [x * cos - y * sin, x * sin + y * cos],
        }
    }

    /// Mean squared difference of the known sensors' values from a situation.
    fn distance(&self, situation: &[f64; 16]) -> f64 {
        let pairs = self.before.iter().zip(situation).enumerate();
        let known = pairs.filter(|(sensor, _)| self.known.contains(*sensor));
        let (sum, count) = known.fold((0.0, 0_u32), |(sum, count), (_, (was, is))| {
            (sum + (was - is) * (was - is), count + 1)
        });
        if count == 0 {
            f64::INFINITY
        } else {
            sum / f64::from(count)
        }
    }
}

/// The samples, each in all rotations of the ring if `turned`.
#[must_use]
pub fn pool(config: &Config<16>, samples: &[Sample<16>], turned: bool) -> Vec<MoveSample> {
    let samples = samples.iter().map(|sample| MoveSample::of(config, sample));
    let places = if turned { 16 } else { 1 };
    samples
        .flat_map(|sample| (0..places).map(move |by| sample.turned(by, config)))
        .collect()
}

/// Least squares through the origin, sensor by sensor; a sensor whose moves do not span the plane
/// does not change.
#[must_use]
pub fn fit<'a>(samples: impl Iterator<Item = &'a MoveSample> + Clone) -> Slopes {
    std::array::from_fn(|sensor| {
        let known = samples.clone().filter(|s| s.known.contains(sensor));
        let mut fit = PlaneFit::default();
        for sample in known {
            fit.add(1.0, sample.action, sample.change[sensor]);
        }
        fit.slopes().unwrap_or_default()
    })
}

/// The fit to the `count` samples nearest to a situation, the first ones on ties.
#[must_use]
pub fn nearest_fit(pool: &[MoveSample], situation: &[Weight; 16], count: usize) -> Slopes {
    let situation = situation.map(|value| value.to_num());
    let keyed = pool.iter().map(|sample| sample.distance(&situation));
    let mut keyed: Vec<_> = keyed.zip(pool).enumerate().collect();
    let by_distance = |a: &(usize, (f64, &MoveSample)), b: &(usize, (f64, &MoveSample))| {
        a.1.0.total_cmp(&b.1.0).then(a.0.cmp(&b.0))
    };
    if count < keyed.len() {
        keyed.select_nth_unstable_by(count, by_distance);
        keyed.truncate(count);
    }
    // Sums in a fixed order.
    keyed.sort_unstable_by_key(|(index, _)| *index);
    fit(keyed.iter().map(|(_, (_, sample))| *sample))
}
