//! Distances kept from walls and from small obstacles (Fig. 5).
//!
//! A *pass* is a part of the path where the nearest surface is of one kind and within 1 m of the
//! body; its gap is the smallest distance. In the paper's figure gaps to walls look wider.

use arena::robot::COLLISION_RADIUS_M;
use arena::world::{Shape, World};
use sim::recording::Step;
use sim::statistics::mean;

/// Surfaces farther away do not count as passed, m from the body.
const PASSED_M: f64 = 1.0;

/// Gaps of passes, m, by kind of surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Gaps {
    /// Along walls.
    pub walls: Vec<f64>,
    /// Beside boxes and posts.
    pub obstacles: Vec<f64>,
}

impl Gaps {
    /// The passes of an episode; empty if the world has only one kind of surface.
    #[must_use]
    pub fn of(world: &World, steps: &[Step]) -> Self {
        let is_wall = |shape: &Shape| matches!(shape, Shape::Wall { .. } | Shape::Outline { .. });
        let only = |walls: bool| {
            let shapes = world.shapes().iter();
            let kept = shapes.filter(|shape| is_wall(shape) == walls).cloned();
            World::new(world.name(), world.start(), kept.collect())
        };
        let (Ok(walls), Ok(obstacles)) = (only(true), only(false)) else {
            return Self::default();
        };
        let mut gaps = Self::default();
        // The current pass: along a wall or not, and its smallest gap so far.
        let mut pass: Option<(bool, f64)> = None;
        for step in steps {
            let place = step.pose.position;
            let [wall, obstacle] =
                [&walls, &obstacles].map(|world| world.clearance(place) - COLLISION_RADIUS_M);
            let now =
                (wall.min(obstacle) < PASSED_M).then(|| (wall <= obstacle, wall.min(obstacle)));
            pass = match (pass, now) {
                (Some((was, least)), Some((is, gap))) if was == is => Some((is, gap.min(least))),
                (before, now) => {
                    gaps.take(before);
                    now
                }
            };
        }
        gaps.take(pass);
        gaps
    }

    fn take(&mut self, pass: Option<(bool, f64)>) {
        match pass {
            Some((true, gap)) => self.walls.push(gap.max(0.0)),
            Some((false, gap)) => self.obstacles.push(gap.max(0.0)),
            None => {}
        }
    }

    /// Mean gaps to walls and to obstacles, m; `None` unless both were passed.
    #[must_use]
    pub fn means(&self) -> Option<[f64; 2]> {
        let both = !self.walls.is_empty() && !self.obstacles.is_empty();
        both.then(|| [&self.walls, &self.obstacles].map(|gaps| mean(gaps.iter().copied())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use arena::world::{Point, Pose};

    #[test]
    fn passes_are_told_apart_by_what_is_nearest() {
        let corners = [
            (-4.0, -4.0),
            (4.0, -4.0),
            (4.0, 4.0),
            (-4.0, 4.0),
            (-4.0, -4.0),
        ];
        let shapes = vec![
            Shape::Wall {
                points: corners.map(|(x, y)| Point::new(x, y)).to_vec(),
            },
            Shape::Circle {
                center: Point::new(0.0, 2.0),
                radius: 0.2,
            },
        ];
        let world = World::new("one post", Pose::default(), shapes).expect("a world");
        let steps: Vec<Step> = [
            (0.0, -3.0),
            (0.0, -3.4),
            (0.0, 0.0),
            (0.0, 1.2),
            (0.5, 2.0),
            (2.6, 0.0),
        ]
        .into_iter()
        .map(|(x, y)| Step {
            pose: Pose::new(Point::new(x, y), 0.0),
            ..Step::default()
        })
        .collect();
        let gaps = Gaps::of(&world, &steps);
        assert_eq!((gaps.walls.len(), gaps.obstacles.len()), (1, 1));
        assert!((gaps.walls[0] - (0.6 - COLLISION_RADIUS_M)).abs() < 1e-9);
        assert!((gaps.obstacles[0] - (0.3 - COLLISION_RADIUS_M)).abs() < 1e-9);
        assert!(gaps.means().is_some() && Gaps::default().means().is_none());
    }
}
