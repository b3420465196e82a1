//! Measures how well a behavior succeeds, from the true world. The controller never sees these
//! values.

use super::metrics::Metrics;
use crate::behavior::{Behavior, WALL_RANGE_M};
use crate::senses::SenseGoal;
use arena::route::{self, route};
use arena::sonar::FACE_RADIUS_M;
use arena::world::{ConeShape, Point, Shape, World};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

/// Within this distance the robot is at the nest, m.
pub const NEST_RADIUS_M: f64 = 0.3;
/// Following counts within this distance between centers, m.
pub const FOLLOW_RANGE_M: f64 = 2.0;
/// Following is measured over this time, s.
pub const FOLLOW_TIME_S: f64 = 300.0;
/// An obstacle is passed within this distance from the center, m.
const PASSING_RANGE_M: f64 = 1.6;
/// A shorter move has no direction, m.
const MIN_MOVE_M: f64 = 0.01;

/// Measurements of one phase.
#[derive(Debug)]
pub(super) struct Measure {
    from: Option<Point>,
    heading: Option<f64>,
    errors: f64,
    steps: u32,
    /// The place to reach.
    pub nest: Point,
    at: Point,
    in_range_s: f64,
    follow_s: f64,
    /// For each shape of the world: it was ahead and has not been passed.
    in_the_way: Vec<bool>,
    passed: [u32; 2],
    /// Number of goals of a chain that were reached.
    pub reached: u32,
    /// Shortest way to where the robot was told to go, at that time, m.
    pub shortest_m: Option<f64>,
    /// Where what is sought in another modality is.
    pub sought: Option<Point>,
    /// At the end of a way the robot was at what was sought.
    pub is_found: bool,
}

impl Measure {
    pub(super) fn new(world: &World, nest: Point) -> Self {
        Self {
            from: None,
            heading: None,
            errors: 0.0,
            steps: 0,
            nest,
            at: world.start().position,
            in_range_s: 0.0,
            follow_s: 0.0,
            in_the_way: vec![false; world.shapes().len()],
            passed: [0; 2],
            reached: 0,
            shortest_m: None,
            sought: None,
            is_found: false,
        }
    }

    /// Adds a piece of the path, or a pause.
    pub(super) fn moved(&mut self, to: Point, touched: bool, took_s: f64, leader: Option<Point>) {
        self.at = to;
        let Some(leader) = leader.filter(|_| self.follow_s < FOLLOW_TIME_S) else {
            return;
        };
        self.follow_s += took_s;
        if leader.distance(to) <= FOLLOW_RANGE_M && !touched {
            self.in_range_s += took_s;
        }
    }

    /// Ends a step.
    pub(super) fn step(&mut self, world: &World, behavior: &Behavior) {
        let way = self.from.map_or(Point::default(), |from| self.at - from);
        self.from = Some(self.at);
        if way.length() > MIN_MOVE_M {
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

    /// Adds the distance error of the nearest surface in the half plane around `side`.
    fn wall(&mut self, world: &World, side: f64) {
        // One degree less than a half plane: the limit of the cone query.
        let half = ConeShape::new(FRAC_PI_2 - 0.0175);
        let view = world.view(self.at, 0.0, 20.0);
        let nearest = view.nearest_in_cone(Point::unit(side), half);
        self.errors += (nearest.min(20.0) - FACE_RADIUS_M - WALL_RANGE_M).abs();
        self.steps += 1;
    }

    /// An obstacle is ahead within 30° of the heading; it has been passed when it is abeam.
    fn passing(&mut self, world: &World, heading: f64) {
        let ahead = Point::unit(heading);
        for (shape, in_the_way) in world.shapes().iter().zip(&mut self.in_the_way) {
            let center = match shape {
                Shape::Box { center, .. } | Shape::Circle { center, .. } => *center,
                Shape::Wall { .. } | Shape::Outline { .. } => continue,
            };
            let to = (center - self.at).turned_back(ahead);
            if to.length() > 2.0 * PASSING_RANGE_M {
                *in_the_way = false;
            } else if to.x > 0.0 && to.y.abs() < to.x * libm::tan(FRAC_PI_6) {
                *in_the_way |= to.length() < PASSING_RANGE_M;
            } else if to.x <= 0.0 && *in_the_way {
                *in_the_way = false;
                if to.length() < PASSING_RANGE_M {
                    self.passed[usize::from(to.y < 0.0)] += 1;
                }
            }
        }
    }

    /// The measure of success and its unit.
    pub(super) fn success(&self, behavior: &Behavior, metrics: &Metrics) -> (f64, &'static str) {
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        match behavior {
            Behavior::Avoid => {
                let free = metrics.steps.saturating_sub(metrics.contacts);
                (
                    f64::from(free) / f64::from(metrics.steps.max(1)),
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
            Behavior::Nest { .. } | Behavior::Home { .. } => {
                (self.is_home(), "1 = within 0.3 m of the nest at the end")
            }
            Behavior::Sense { goal, .. } => {
                let unit = match goal {
                    SenseGoal::Scent | SenseGoal::Light => {
                        "1 = within 0.6 m of the source at the end"
                    }
                    SenseGoal::Floor(_) => "1 = on floor of that color at the end",
                    SenseGoal::Before(_) => "1 = within 0.6 m of where it was before, at the end",
                };
                (f64::from(u8::from(self.is_found)), unit)
            }
            Behavior::Seek(file) => match file.place_mm {
                Some(_) => (self.is_home(), "1 = within 0.3 m of the place at the end"),
                None => (
                    share(f64::from(metrics.goal_steps), f64::from(metrics.steps)),
                    "share of steps in which the goal held",
                ),
            },
            Behavior::Follow => (
                share(self.in_range_s, self.follow_s),
                "share of 300 s with the leader within 2 m and not touched",
            ),
            Behavior::Chain(parts) => (
                share(f64::from(self.reached), parts.len() as f64),
                "share of the goals reached",
            ),
        }
    }

    /// A body of this radius is told to go from here to what is sought, or to the nest.
    pub(super) fn begin_way(&mut self, world: &World, from: Point, radius_m: f64) {
        // Worlds too large to be searched have no shortest way.
        let to = self.sought.unwrap_or(self.nest);
        let path = route(world, from, to, radius_m).ok().flatten();
        self.shortest_m = path.map(|path| route::length(&path));
    }

    fn is_home(&self) -> f64 {
        f64::from(u8::from(self.at.distance(self.nest) <= NEST_RADIUS_M))
    }

    /// Whether the robot is at the nest now.
    pub(super) fn at_nest(&self) -> bool {
        self.at.distance(self.nest) <= NEST_RADIUS_M
    }
}
