//! How well each behavior goes, by the world as it is: the mind never sees any of this.

use super::metrics::Metrics;
use crate::behavior::{Behavior, WALL_RANGE_M};
use arena::sonar::FACE_RADIUS_M;
use arena::world::{ConeShape, Point, Shape, View, World};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

/// At the nest means within this distance, m.
pub const NEST_M: f64 = 0.3;
/// A leader is kept within this distance between centers, m.
pub const KEPT_M: f64 = 2.0;
/// Time over which following is judged, s.
pub const FOLLOWED_S: f64 = 300.0;
/// A thing nearer than this may be in the way or is being passed, m from the center.
const MET_M: f64 = 1.6;
/// Way too short to have a direction, m.
const STILL_M: f64 = 0.01;

/// What is measured of one phase.
#[derive(Debug)]
pub(super) struct Measure {
    view: View,
    from: Option<Point>,
    heading: Option<f64>,
    errors: f64,
    steps: u32,
    /// The place to come to.
    pub nest: Point,
    at: Point,
    kept_s: f64,
    followed_s: f64,
    /// Of each thing in the world: it stands in the way.
    in_the_way: Vec<bool>,
    passed: [u32; 2],
    /// Parts of a chain reached.
    pub reached: u32,
}

impl Measure {
    pub(super) fn new(world: &World, nest: Point) -> Self {
        Self {
            view: View::default(),
            from: None,
            heading: None,
            errors: 0.0,
            steps: 0,
            nest,
            at: world.start().position,
            kept_s: 0.0,
            followed_s: 0.0,
            in_the_way: vec![false; world.shapes().len()],
            passed: [0; 2],
            reached: 0,
        }
    }

    /// A piece of the way, or of standing.
    pub(super) fn moved(&mut self, to: Point, touched: bool, took_s: f64, leader: Option<Point>) {
        self.at = to;
        let Some(leader) = leader.filter(|_| self.followed_s < FOLLOWED_S) else {
            return;
        };
        self.followed_s += took_s;
        if leader.distance(to) <= KEPT_M && !touched {
            self.kept_s += took_s;
        }
    }

    /// A step has ended.
    pub(super) fn step(&mut self, world: &World, behavior: &Behavior) {
        let way = self.from.map_or(Point::default(), |from| self.at - from);
        self.from = Some(self.at);
        if way.length() > STILL_M {
            self.heading = Some(way.angle());
        }
        let Some(heading) = self.heading else { return };
        match behavior {
            Behavior::WallLeft => self.wall(world, heading + FRAC_PI_2),
            Behavior::WallRight => self.wall(world, heading - FRAC_PI_2),
            Behavior::AvoidRight => self.passing(world, heading),
            _ => {}
        }
    }

    /// Adds the distance error: nearest surface in the half plane around `side`, from the faces' circle.
    fn wall(&mut self, world: &World, side: f64) {
        // A half plane but for one degree, where the cone query has its limit.
        let half = ConeShape::new(FRAC_PI_2 - 0.0175);
        self.view.build(world, self.at, 0.0, 20.0);
        let nearest = self.view.nearest_in_cone(Point::unit(side), 0.0, half);
        self.errors += (nearest.min(20.0) - FACE_RADIUS_M - WALL_RANGE_M).abs();
        self.steps += 1;
    }

    /// A box or post is in the way when it is met within 30° of the way; it has been passed once it lies abeam.
    fn passing(&mut self, world: &World, heading: f64) {
        let ahead = Point::unit(heading);
        for (shape, in_the_way) in world.shapes().iter().zip(&mut self.in_the_way) {
            let center = match shape {
                Shape::Box { center, .. } | Shape::Circle { center, .. } => *center,
                Shape::Wall { .. } | Shape::Outline { .. } => continue,
            };
            let to = (center - self.at).turned_back(ahead);
            if to.length() > 2.0 * MET_M {
                *in_the_way = false;
            } else if to.x > 0.0 && to.y.abs() < to.x * libm::tan(FRAC_PI_6) {
                *in_the_way |= to.length() < MET_M;
            } else if to.x <= 0.0 && *in_the_way {
                *in_the_way = false;
                if to.length() < MET_M {
                    self.passed[usize::from(to.y < 0.0)] += 1;
                }
            }
        }
    }

    /// How well it went, and in which unit.
    pub(super) fn success(&self, behavior: &Behavior, tally: &Metrics) -> (f64, &'static str) {
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        match behavior {
            Behavior::Avoid => {
                let free = tally.steps.saturating_sub(tally.contacts);
                (
                    f64::from(free) / f64::from(tally.steps.max(1)),
                    "share of steps without contact",
                )
            }
            Behavior::AvoidRight => {
                let [left, right] = self.passed.map(f64::from);
                (
                    share(left, left + right),
                    "share of obstacles passed on the robot's left",
                )
            }
            Behavior::WallLeft | Behavior::WallRight => (
                share(self.errors, f64::from(self.steps)),
                "m of mean absolute distance error",
            ),
            Behavior::Nest => (self.is_home(), "1 = within 0.3 m of the nest at the end"),
            Behavior::Seek(file) => match file.place_mm {
                Some(_) => (self.is_home(), "1 = within 0.3 m of the place at the end"),
                None => (
                    share(f64::from(tally.goal_steps), f64::from(tally.steps)),
                    "share of steps in which the goal held",
                ),
            },
            Behavior::Follow => (
                share(self.kept_s, self.followed_s),
                "share of 300 s with the leader within 2 m and not touched",
            ),
            Behavior::Chain(parts) => (
                share(f64::from(self.reached), parts.len() as f64),
                "share of the goals reached",
            ),
        }
    }

    fn is_home(&self) -> f64 {
        f64::from(u8::from(self.at.distance(self.nest) <= NEST_M))
    }

    /// Goes on after a change of behavior.
    pub(super) fn at_nest(&self) -> bool {
        self.at.distance(self.nest) <= NEST_M
    }
}
