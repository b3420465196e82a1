//! A demonstration in numbers: what each step was, and what each displacement would have led to.

use super::{Demonstration, STANDING, ShownStep};
use crate::statistics::PlaneFit;
use amp::action_map::ActionMap;
use amp::units::Displacement;
use std::f64::consts::TAU;

/// Displacements: 16 headings at the whole step, standing, and 16 each at 3/4, 1/2 and 1/4.
pub const MOVES: usize = 65;
/// Those of a goal with progress.
pub const WHOLE_STEPS: usize = 16;

/// One demonstrated step, in numbers.
#[derive(Debug, Clone)]
pub struct Example {
    /// The situation; NaN = unknown.
    pub values: [f64; 16],
    /// The situation expected after each displacement.
    pub after: Vec<[f64; 16]>,
    /// Place of the ring along which the robot went; where it stood, its course.
    pub went: usize,
    /// Length of the displacement, as a share of the step.
    pub length: f64,
    /// Direction of the course, radians.
    pub course: Option<f64>,
    /// The demonstrated displacement as shares of the two nearest ones.
    pub shown: [(usize, f64); 2],
}

/// All steps of a demonstration.
pub struct Examples(Vec<Example>);

impl Examples {
    pub fn new(demonstrations: &[Demonstration<'_>]) -> Self {
        let examples = demonstrations.iter().flat_map(|one| {
            let (slopes, step_mm) = (slopes(one.actions), f64::from(one.step_mm));
            let example = move |step: &ShownStep| Example::new(step, &slopes, step_mm);
            one.shown.iter().map(example)
        });
        Self(examples.collect())
    }

    /// One example in `number`, from the first on.
    pub fn every(&self, number: usize) -> Self {
        Self(self.0.iter().step_by(number).cloned().collect())
    }

    pub fn len(&self) -> usize {
        self.0.len()
    }

    pub fn iter(&self) -> std::slice::Iter<'_, Example> {
        self.0.iter()
    }
}

/// Change of each value per whole step along x and along y: least squares over the neurons, as the
/// planner has it.
fn slopes(actions: &ActionMap<16, 16>) -> [[f64; 2]; 16] {
    let mut fits = [PlaneFit::default(); 16];
    for neuron in 0..16 {
        let action = (actions.actions().code_vector(neuron)).map(|part| part.to_num());
        for (fit, change) in fits.iter_mut().zip(actions.changes().code_vector(neuron)) {
            fit.add(1.0, action, change.to_num());
        }
    }
    fits.map(|fit| fit.slopes().unwrap_or_default())
}

/// Direction of a place of the ring, radians.
pub fn direction(place: usize) -> f64 {
    place as f64 * TAU / 16.0
}

/// Share of a step and direction of a displacement.
pub fn displacement(index: usize) -> (f64, f64) {
    match index {
        0..WHOLE_STEPS => (1.0, direction(index)),
        WHOLE_STEPS => (0.0, 0.0),
        _ => {
            let (shorter, place) = ((index - 1) / 16, (index - 1) % 16);
            (1.0 - 0.25 * shorter as f64, direction(place))
        }
    }
}

impl Example {
    fn new(step: &ShownStep, slopes: &[[f64; 2]; 16], step_mm: f64) -> Self {
        let values: [f64; 16] = std::array::from_fn(|sensor| {
            let value = step.situation[sensor].to_num::<f64>();
            if step.known.contains(sensor) {
                value
            } else {
                f64::NAN
            }
        });
        let expected = |index| {
            let (share, angle) = displacement(index);
            let (x, y) = (share * libm::cos(angle), share * libm::sin(angle));
            std::array::from_fn(|sensor| {
                let value = values[sensor] + x * slopes[sensor][0] + y * slopes[sensor][1];
                // `max` would replace an unknown value.
                if value < 0.0 { 0.0 } else { value }
            })
        };
        let length = f64::from(step.moved.length_mm()) / step_mm;
        let way = if length < STANDING {
            step.course
        } else {
            step.moved
        };
        Self {
            values,
            after: (0..MOVES).map(expected).collect(),
            went: libm::rint(turns(way) * 16.0) as usize % 16,
            length,
            course: (step.course != Displacement::ZERO).then(|| turns(step.course) * TAU),
            shown: nearest_displacements(length, turns(way)),
        }
    }

    /// The robot made a whole step.
    pub fn is_whole(&self) -> bool {
        self.shown.iter().all(|(index, _)| *index < WHOLE_STEPS)
    }

    /// Probability of the demonstrated displacement among those of these probabilities.
    pub fn share_of_shown(&self, probabilities: &[f64]) -> f64 {
        let shares = self
            .shown
            .iter()
            .map(|(index, share)| share * probabilities.get(*index).copied().unwrap_or(0.0));
        shares.sum()
    }
}

/// Direction of a displacement in turns, from 0 to below 1.
fn turns(moved: Displacement) -> f64 {
    f64::from(moved.bearing().as_turns()) / 65_536.0
}

/// The two nearest displacements to one of this length (a share of the step) and direction (turns).
fn nearest_displacements(length: f64, turns: f64) -> [(usize, f64); 2] {
    let quarters = libm::rint(length * 4.0).clamp(0.0, 4.0) as usize;
    let first = match quarters {
        0 => return [(WHOLE_STEPS, 1.0), (WHOLE_STEPS, 0.0)],
        4 => 0,
        _ => 1 + 16 * (4 - quarters),
    };
    let place = libm::floor(turns * 16.0);
    let beyond = turns * 16.0 - place;
    let index = |place: usize| first + place % 16;
    [
        (index(place as usize), 1.0 - beyond),
        (index(place as usize + 1), beyond),
    ]
}
