//! A displacement that keeps its bearing in the world while the ring turns.

use crate::units::div_round;
use crate::units::{Bearing, Displacement};

/// Fractions of a millimeter.
const FINE: i32 = 16;

/// A displacement that keeps its bearing in the world while the ring turns.
///
/// It is stored in the frame of its creation and rotated once when it is read. Each rotation
/// rounds; the many small ones of a turning ring would add up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tracked {
    /// Along x and y, in 1/16 mm; products with a unit vector fit 32 bits up to 4 m.
    way: (i32, i32),
    /// How far the ring has turned since its creation.
    turned: Bearing,
}

impl Tracked {
    /// None at all.
    pub const ZERO: Self = Self {
        way: (0, 0),
        turned: Bearing::ZERO,
    };

    /// Created in the ring's present frame.
    #[must_use]
    pub fn new(way: Displacement) -> Self {
        Self {
            way: to_weight32(way),
            turned: Bearing::ZERO,
        }
    }

    /// What it is in the ring's present frame.
    #[must_use]
    pub fn now(&self) -> Displacement {
        let (x, y) = turned_by(Bearing::ZERO.minus(self.turned), self.way);
        Displacement::saturating(div_round(x, FINE), div_round(y, FINE))
    }

    /// The robot has moved and then its ring has turned: what is left of it.
    pub fn go(&mut self, moved: Displacement, turned: Bearing) {
        let (x, y) = self.way;
        let (dx, dy) = turned_by(self.turned, to_weight32(moved));
        self.way = (x.wrapping_sub(dx), y.wrapping_sub(dy));
        self.turn(turned);
    }

    /// The ring has turned.
    pub fn turn(&mut self, turned: Bearing) {
        self.turned = self.turned.plus(turned);
    }
}

fn to_weight32(way: Displacement) -> (i32, i32) {
    (FINE * i32::from(way.dx_mm), FINE * i32::from(way.dy_mm))
}

fn turned_by(angle: Bearing, (x, y): (i32, i32)) -> (i32, i32) {
    if angle == Bearing::ZERO {
        return (x, y);
    }
    angle.direction().rotate(x, y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn way(dx_mm: i16, dy_mm: i16) -> Displacement {
        Displacement { dx_mm, dy_mm }
    }

    #[test]
    fn a_turn_in_many_steps_is_one_turn() {
        let mut tracked = Tracked::new(way(-50, -50));
        // 135° to the right, as a base reports it that turns at up to 45 °/s.
        for _ in 0..64 {
            let right = Bearing::ZERO.minus(Bearing::from_turns(384));
            tracked.go(Displacement::ZERO, right);
        }
        assert_eq!(tracked.now(), way(71, 0));
    }

    /// Each millimeter leads 0.17 mm aside: rounded by itself, it would lead nowhere aside.
    #[test]
    fn millimeters_one_by_one_are_as_many_at_once() {
        let mut tracked = Tracked::new(way(1_000, 0));
        tracked.turn(Bearing::from_turns(1_820));
        for _ in 0..90 {
            tracked.go(way(1, 0), Bearing::ZERO);
        }
        tracked.turn(Bearing::ZERO.minus(Bearing::from_turns(1_820)));
        let now = tracked.now();
        assert!((910..=913).contains(&now.dx_mm), "{now:?}");
        assert!((-18..=-14).contains(&now.dy_mm), "{now:?}");
    }

    #[test]
    fn what_was_gone_is_taken_off_before_the_ring_turns() {
        let mut tracked = Tracked::new(way(100, 0));
        let left = Bearing::from_turns(1 << 14);
        tracked.go(way(30, 0), left);
        assert_eq!(tracked.now(), way(0, -70));
        tracked.go(way(0, -50), Bearing::ZERO);
        assert_eq!(tracked.now(), way(0, -20));
        tracked.turn(left);
        assert_eq!(tracked.now(), way(-20, 0));
    }
}
