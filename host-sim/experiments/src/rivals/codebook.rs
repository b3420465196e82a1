//! Code vectors in the slot of the action map: a change of situation and the move that caused it.
//!
//! Other quantizers find at most as many of them as the map has neurons. A place that is left over
//! becomes zero: no change by no move, which adds nothing to the planner's linear fit.

use super::transition::Transition;
use crate::baselines::learning::Values;
use amp::controller::{StatePart, TransferError};
use amp::fixed::Weight32;
use arena::noise::Noise;
use arena::world::Point;
use sim::pilot::SimState;

/// Most code vectors: the neurons of the action map.
pub const UNITS: usize = 16;
/// Presentations per random move, as the maps' epochs.
const EPOCHS: usize = 100;

/// A code vector.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CodeVector {
    /// Change of each value.
    pub change: Values,
    /// The move, in longest steps.
    pub moved: Point,
}

impl CodeVector {
    /// That of a transition; a change that is unknown is 0.
    #[must_use]
    pub fn of(sample: &Transition) -> Self {
        let change = |i: usize| {
            if sample.known[i] {
                sample.change[i]
            } else {
                0.0
            }
        };
        Self {
            change: std::array::from_fn(change),
            moved: sample.moved,
        }
    }

    /// Squared distance from a transition: of the known changes and of the move, as in the action
    /// map.
    #[must_use]
    pub fn squared_distance(&self, sample: &Transition) -> f64 {
        let apart = self.moved - sample.moved;
        let square = |i: usize| {
            let off = self.change[i] - sample.change[i];
            if sample.known[i] { off * off } else { 0.0 }
        };
        (0..16).map(square).sum::<f64>() + apart.dot(apart)
    }

    /// Moves towards a transition by this share of the way.
    pub fn approach(&mut self, sample: &Transition, rate: f64) {
        for i in (0..16).filter(|i| sample.known[*i]) {
            self.change[i] += rate * (sample.change[i] - self.change[i]);
        }
        self.moved = self.moved + (sample.moved - self.moved) * rate;
    }

    /// The middle between this and another one.
    #[must_use]
    pub fn middle(&self, other: &Self) -> Self {
        Self {
            change: std::array::from_fn(|i| 0.5 * (self.change[i] + other.change[i])),
            moved: (self.moved + other.moved) * 0.5,
        }
    }
}

/// Presents transitions in random order, 100 times as many as there are, each turned by a random
/// number of ring steps if the ring is symmetric.
pub fn present(
    transitions: &[Transition],
    symmetric: bool,
    noise: &mut Noise,
    mut learn: impl FnMut(&Transition),
) {
    for _ in 0..EPOCHS * transitions.len() {
        let places = if symmetric { noise.index(16) } else { 0 };
        let sample = &transitions[noise.index(transitions.len())];
        learn(&sample.rotated(places));
    }
}

/// The indices of the nearest and the second nearest of at least two code vectors.
#[must_use]
pub fn nearest_two<'a>(
    codes: impl Iterator<Item = &'a CodeVector>,
    sample: &Transition,
) -> [usize; 2] {
    let (mut best, mut second) = ((0, f64::INFINITY), (0, f64::INFINITY));
    for (index, code) in codes.enumerate() {
        let distance = code.squared_distance(sample);
        if distance < best.1 {
            (best, second) = ((index, distance), best);
        } else if distance < second.1 {
            second = (index, distance);
        }
    }
    [best.0, second.0]
}

/// Replaces the code vectors of a controller's action map.
///
/// # Errors
/// When the controller is busy.
pub fn replace_action_map(state: &mut SimState, codes: &[CodeVector]) -> Result<(), TransferError> {
    let filled = |k: usize| codes.get(k).copied().unwrap_or_default();
    let (mut changes, mut actions) = (Vec::new(), Vec::new());
    for code in (0..UNITS).map(filled) {
        changes.extend(code.change.map(bytes).as_flattened());
        actions.extend([code.moved.x, code.moved.y].map(bytes).as_flattened());
    }
    state.write_part(StatePart::Changes, 0, &changes)?;
    state.write_part(StatePart::Actions, 0, &actions)
}

/// A component as the map's bytes, clamped to [−1, 1].
fn bytes(value: f64) -> [u8; 4] {
    let component = Weight32::saturating_from_num(value.clamp(-1.0, 1.0));
    component.to_bits().to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::super::transition::fixture::cosines;
    use super::*;
    use amp::som::Grid;

    #[test]
    fn a_code_vector_that_approaches_a_sample_comes_to_it() {
        let mut sample = cosines(1, 1)[0];
        sample.known[2] = false;
        let mut code = CodeVector::default();
        code.approach(&sample, 1.0);
        assert!(code.squared_distance(&sample) < 1e-20);
        assert_eq!((code.change[2], code), (0.0, CodeVector::of(&sample)));
        let half = CodeVector::default().middle(&code);
        assert_eq!(half.moved, sample.moved * 0.5);
    }

    #[test]
    fn nearest_is_found_before_second_nearest() {
        let samples = cosines(3, 2);
        let codes: Vec<_> = samples.iter().map(CodeVector::of).collect();
        for (index, sample) in samples.iter().enumerate() {
            let [first, second] = nearest_two(codes.iter(), sample);
            assert_eq!(first, index);
            let third = 3 - first - second;
            let distance = |k: usize| codes[k].squared_distance(sample);
            assert!(distance(second) <= distance(third));
        }
    }

    #[test]
    fn the_action_map_holds_the_code_vectors_and_zeros() {
        let codes: Vec<_> = cosines(3, 3).iter().map(CodeVector::of).collect();
        let mut state = SimState::new(Grid::rectangle(4, 4));
        replace_action_map(&mut state, &codes).expect("it is idle");
        let map = state.actions();
        for (k, code) in codes.iter().enumerate() {
            for (i, change) in map.changes().code_vector(k).into_iter().enumerate() {
                assert!((change.to_num::<f64>() - code.change[i]).abs() < 2e-4);
            }
            let [x, _] = map.actions().code_vector(k);
            assert!((x.to_num::<f64>() - code.moved.x).abs() < 2e-4);
        }
        assert_eq!(
            map.actions().code_vector(3).map(|part| part.to_bits()),
            [0; 2]
        );
    }
}
