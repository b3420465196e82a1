//! Baseline: random moves without end, as in the controller's exploration.

use arena::noise::Noise;
use arena::world::Point;
use sim::ring_pilot::{Perception, Policy, STEP_M};
use std::f64::consts::TAU;

/// A robot that moves at random; bearing and length are uniform.
#[derive(Debug, Clone)]
pub struct RandomMoves(Noise);

impl RandomMoves {
    /// A robot whose moves are fixed by `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(Noise::new(seed))
    }
}

impl Policy for RandomMoves {
    fn decide(&mut self, _: &Perception) -> Point {
        let bearing = self.0.uniform_in(0.0, TAU);
        Point::unit(bearing) * self.0.uniform_in(0.0, STEP_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amp::units::Bearing;
    use arena::world::Pose;

    #[test]
    fn moves_have_no_direction_and_half_the_step_on_average() {
        let perceived = Perception {
            ranges: [None; 16],
            pose: Pose::default(),
            turned: Bearing::ZERO,
            last: None,
        };
        let mut moves = RandomMoves::new(3);
        let (mut sum, mut distance) = (Point::default(), 0.0);
        for _ in 0..10_000 {
            let step = moves.decide(&perceived);
            assert!(step.length() <= STEP_M);
            sum = sum + step;
            distance += step.length();
        }
        // Four standard errors: 0.144 m / 2 per component and 0.072 m, over a hundred.
        assert!(sum.length() / 1e4 < 4.0 * 1.5e-3 && (distance / 1e4 - 0.125).abs() < 4.0 * 7.3e-4);
    }
}
