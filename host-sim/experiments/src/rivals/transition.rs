//! What all rivals learn from: the controller's own random moves.

use crate::baselines::learning::Values;
use arena::world::Point;
use sim::ring_pilot::axis;

/// One random move and the change of situation that it caused.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition {
    /// Situation before the move, each value in [0, 1].
    pub before: Values,
    /// Executed displacement in units of the longest step, in the ring's frame.
    pub moved: Point,
    /// Situation after the move minus that before it.
    pub change: Values,
    /// Whether a transducer still hears the same surface, as the controller decides it; the
    /// changes of the others are not learned.
    pub known: [bool; 16],
}

/// Numbers in the input of a regression: the situation and the move.
pub const INPUTS: usize = 18;

impl Transition {
    /// The same move of a ring that is turned by `places` of its 16 steps.
    #[must_use]
    pub fn rotated(&self, places: usize) -> Self {
        Self {
            before: amp::scan::rotated(&self.before, places),
            moved: self.moved.turned(axis(places)),
            change: amp::scan::rotated(&self.change, places),
            known: amp::scan::rotated(&self.known, places),
        }
    }

    /// The input of a regression of the change.
    #[must_use]
    pub fn input(&self) -> [f64; INPUTS] {
        input(&self.before, self.moved)
    }
}

/// Situation and move in one vector.
#[must_use]
pub fn input(situation: &Values, moved: Point) -> [f64; INPUTS] {
    std::array::from_fn(|i| match i {
        16 => moved.x,
        17 => moved.y,
        _ => situation[i],
    })
}

/// Each transition as it was or, of a symmetric ring, turned by all 16 ring steps.
#[must_use]
pub fn augmented(transitions: &[Transition], symmetric: bool) -> Vec<Transition> {
    let turns = if symmetric { 16 } else { 1 };
    let all = transitions.iter();
    all.flat_map(|one| (0..turns).map(|places| one.rotated(places)))
        .collect()
}

/// Transitions for the tests of all rivals.
#[cfg(test)]
pub(super) mod fixture {
    use super::*;
    use arena::noise::Noise;
    use std::f64::consts::TAU;

    /// What a step along an axis changes in these transitions.
    pub const SLOPE: f64 = 0.055;

    /// Random moves whose changes are exact cosines: a thing in front comes nearer.
    pub fn cosines(count: usize, seed: u64) -> Vec<Transition> {
        let mut noise = Noise::new(seed);
        let one = |_| {
            let before = std::array::from_fn(|_| noise.uniform_in(0.3, 0.8));
            let bearing = noise.uniform_in(0.0, TAU);
            let moved = Point::unit(bearing) * noise.uniform_in(0.0, 1.0);
            Transition {
                before,
                moved,
                change: change_of(moved),
                known: [true; 16],
            }
        };
        (0..count).map(one).collect()
    }

    /// Moves ahead and back, each within 0.05 of a whole step, in turn.
    pub fn two_clusters(count: usize) -> Vec<Transition> {
        let mut transitions = cosines(count, 9);
        for (index, one) in transitions.iter_mut().enumerate() {
            let side = if index % 2 == 0 { 1.0 } else { -1.0 };
            one.moved = one.moved * 0.05 + Point::new(side, 0.0);
            one.change = change_of(one.moved);
        }
        transitions
    }

    /// The change of such a move.
    pub fn change_of(moved: Point) -> Values {
        std::array::from_fn(|sensor| SLOPE * axis(sensor).dot(moved))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_transition_is_the_same_one_of_a_turned_ring() {
        let mut before = [0.0; 16];
        before[1] = 0.5;
        let mut known = [true; 16];
        known[15] = false;
        let one = Transition {
            before,
            moved: Point::new(1.0, 0.0),
            change: before.map(|value| -value / 2.0),
            known,
        };
        let turned = one.rotated(4);
        assert_eq!((turned.before[5], turned.change[5]), (0.5, -0.25));
        assert!(turned.moved.distance(Point::new(0.0, 1.0)) < 1e-12);
        assert_eq!(turned.known.iter().position(|known| !known), Some(3));
        assert_eq!(augmented(&[one], true)[4], turned);
        assert_eq!(augmented(&[one], false), [one]);
    }
}
