//! Random rooms: the same seed gives a bit-identical room on every machine.

use crate::geometry::{Point, Pose};
use crate::noise::Noise;
use crate::shapes::Shape;
use crate::world::World;

/// Half the side of the square room, m.
const ROOM_HALF_M: f64 = 4.0;
/// Boxes in a room.
const BOXES: usize = 12;
/// Smallest and largest half side of a box, m; the two sides are drawn independently.
const BOX_HALF_M: (f64, f64) = (0.15, 0.5);
/// Smallest distance of a box from the center, m.
const FREE_RADIUS_M: f64 = 1.0;

impl World {
    /// A room of 8 m × 8 m around the origin with 12 boxes parallel to its walls, which may
    /// overlap; the robot starts at the center and looks along x. Named `random:SEED`.
    #[must_use]
    pub fn random(seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        let mut shapes = vec![Shape::room(Point::new(ROOM_HALF_M, ROOM_HALF_M))];
        while shapes.len() <= BOXES {
            shapes.extend(random_box(&mut noise));
        }
        Self::unchecked(format!("random:{seed}"), Pose::default(), shapes)
    }
}

/// A box inside the room; `None` if it would be too near to the center.
fn random_box(noise: &mut Noise) -> Option<Shape> {
    let mut half = || noise.uniform_in(BOX_HALF_M.0, BOX_HALF_M.1);
    let half = Point::new(half(), half());
    let mut place = |half: f64| noise.uniform_in(half - ROOM_HALF_M, ROOM_HALF_M - half);
    let center = Point::new(place(half.x), place(half.y));
    let gap = |middle: f64, half: f64| (middle.abs() - half).max(0.0);
    let from_center = Point::new(gap(center.x, half.x), gap(center.y, half.y)).length();
    (from_center >= FREE_RADIUS_M).then(|| Shape::Box {
        center,
        size: half * 2.0,
        angle: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_hundred_rooms_keep_their_promises() {
        for seed in 0..200 {
            let world = World::random(seed);
            assert_eq!(world, World::random(seed));
            assert_eq!(world.name(), format!("random:{seed}"));
            assert_eq!(world.segments().count(), 52);
            assert!(world.clearance(Point::default()) >= FREE_RADIUS_M);
            assert!(!world.is_inside(Point::default()));
            let (low, high) = world.bounds();
            assert_eq!((low, high), (Point::new(-4.0, -4.0), Point::new(4.0, 4.0)));
            for shape in &world.shapes()[1..] {
                let Shape::Box { size, angle, .. } = shape else {
                    panic!("a room holds boxes only");
                };
                assert!(
                    *angle == 0.0 && (0.3..1.0).contains(&size.x) && (0.3..1.0).contains(&size.y)
                );
            }
        }
        assert_ne!(World::random(1).shapes(), World::random(2).shapes());
    }
}
