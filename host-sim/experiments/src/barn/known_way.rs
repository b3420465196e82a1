//! A robot that knows the field: a control of what a guard lets through.

use super::shortest;
use arena::route::length;
use arena::world::{Point, World};
use files::error::BadInput;
use sim::ring_pilot::{Perception, Policy, STEP_M};

/// Wider ways are tried in steps of so much room beside the body, m.
const ROOM_STEP_M: f64 = 0.05;
/// A wider way is this much longer than the shortest at most.
const LONGER: f64 = 1.5;
/// Distance of the points of the way, m.
const SPACING_M: f64 = 0.02;
/// A robot that moved less than this was stopped by its guard, m.
const STOPPED_M: f64 = 0.02;
/// How far ahead on the way it goes, m: when it was stopped, as the next one says.
const AHEAD_M: [f64; 4] = [STEP_M, 0.12, 0.4, 0.06];
/// And by how much it turns aside, rad: an echo is found out from elsewhere only.
const ASIDE: [f64; 13] = [
    0.0, 0.0, 0.0, 0.0, 0.6, -0.6, 1.2, -1.2, 1.6, -1.6, 2.2, -2.2, 3.1,
];

/// Follows the widest way that is not much longer than the shortest.
pub(super) struct KnownWay {
    /// Points of the way, from the start, in the ring's frame there.
    way: Vec<Point>,
    /// Decisions in a row after which it was stopped.
    stopped: usize,
}

impl KnownWay {
    /// A robot that knows this field; without a way it stands.
    ///
    /// # Errors
    /// When the world has no goal or is too large for the search.
    pub(super) fn new(world: &World) -> Result<Self, BadInput> {
        let start = world.start();
        let mut way = shortest(world, 0.0)?.unwrap_or_else(|| vec![start.position]);
        let longest_m = LONGER * length(&way);
        let mut room_m = ROOM_STEP_M;
        while let Some(wider) = shortest(world, room_m)?.filter(|way| length(way) <= longest_m) {
            way = wider;
            room_m += ROOM_STEP_M;
        }
        let back = Point::unit(start.heading);
        let in_frame = |point: Point| (point - start.position).turned_back(back);
        Ok(Self {
            way: dense(&way).into_iter().map(in_frame).collect(),
            stopped: 0,
        })
    }

    /// The point of the way that lies so far beyond the one nearest to `here`.
    fn point_ahead(&self, here: Point, ahead_m: f64) -> Point {
        let distance = |index: &usize| self.way[*index].distance(here);
        let indices = 0..self.way.len();
        let nearest = indices.min_by(|one, other| distance(one).total_cmp(&distance(other)));
        let ahead = nearest.unwrap_or(0) + libm::round(ahead_m / SPACING_M) as usize;
        self.way[ahead.min(self.way.len() - 1)]
    }
}

/// The points of a chain of lines, at most [`SPACING_M`] apart; at least its end.
fn dense(chain: &[Point]) -> Vec<Point> {
    let mut points = Vec::new();
    for ends in chain.windows(2) {
        let line = ends[1] - ends[0];
        let count = libm::ceil(line.length() / SPACING_M) as usize;
        points.extend((0..count).map(|index| ends[0] + line * (index as f64 / count as f64)));
    }
    points.extend(chain.last());
    points
}

impl Policy for KnownWay {
    fn decide(&mut self, perceived: &Perception) -> Point {
        self.stopped = match perceived.last {
            Some(last) if last.moved.length() < STOPPED_M => self.stopped + 1,
            _ => 0,
        };
        let here = perceived.pose.position;
        let way = self.point_ahead(here, AHEAD_M[self.stopped % AHEAD_M.len()]) - here;
        let way = way.turned(Point::unit(ASIDE[self.stopped % ASIDE.len()]));
        let step = way * (STEP_M / way.length().max(STEP_M));
        step.turned_back(Point::unit(perceived.pose.heading))
    }

    fn looks_for_position(&self) -> bool {
        true
    }
}
