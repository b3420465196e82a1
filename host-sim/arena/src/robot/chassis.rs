//! The body on its wheels: where it is, where its odometry believes to be, and what it touches.

use core::f64::consts::TAU;

use super::servo::{Stride, Way};
use super::{BUMPERS, COLLISION_RADIUS_M, Executed};
use crate::noise::Noise;
use crate::world::{Clearing, Point, Pose, Sweep, World};

/// A disc that rolls along its wheels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chassis {
    pub(super) position: Point,
    /// Where it would be without slip.
    pub(super) odometry: Point,
    /// Bearing of the base itself: fixed.
    front: f64,
    /// Complex factor from odometry to truth.
    slip: Point,
    clearing: Clearing,
}

/// A way along the wheels towards a goal, as the odometry has it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) goal: Point,
    /// Unit vector towards the goal.
    pub(super) wheels: Point,
    pub(super) odometry: Point,
}

impl Way for Line {
    /// Each coordinate nears the goal's or passes it, so neither product grows, and neither does their sum.
    fn left(&self) -> f64 {
        (self.goal - self.odometry).dot(self.wheels)
    }

    fn go(&mut self, way: f64) {
        self.odometry = self.odometry + self.wheels * way;
    }
}

impl Chassis {
    /// One whose front looks along the pose's heading.
    pub(super) fn new(pose: Pose) -> Self {
        Self {
            position: pose.position,
            odometry: pose.position,
            front: pose.heading,
            slip: Point::new(1.0, 0.0),
            clearing: Clearing::default(),
        }
    }

    /// Moves straight by `way`, the truth, up to the first touch.
    pub(super) fn sweep(&mut self, way: Point, world: &World) -> Sweep {
        let (from, to) = (self.position, self.position + way);
        self.clearing.sweep(world, from, to, COLLISION_RADIUS_M)
    }

    /// Gaps from here on need not be told, m.
    pub(super) fn tell_gaps_below(&mut self, gap_m: f64) {
        self.clearing.tell_below(gap_m);
    }

    /// Draws what the wheels will slip from now on: of the way (as a share) and of the direction (rad).
    pub(super) fn slip(&mut self, deviation: f64, noise: &mut Noise) {
        let share = 1.0 + deviation * noise.normal();
        self.slip = Point::unit(deviation * noise.normal()) * share;
    }

    /// Rolls `way` m along the unit vector `wheels`, as the odometry counts, up to the first touch. Returns how far it got,
    /// in m of odometry.
    pub(super) fn roll(
        &mut self,
        way: f64,
        wheels: Point,
        world: &World,
        done: &mut Executed,
    ) -> f64 {
        if way == 0.0 {
            return 0.0;
        }
        let believed = wheels * way;
        let truth = believed.turned(self.slip);
        let sweep = self.sweep(truth, world);
        let share = share_of(&sweep, truth.length());
        self.position = self.position + truth * share;
        self.odometry = self.odometry + believed * share;
        done.traveled_m += sweep.traveled_m;
        done.min_clearance_m = done.min_clearance_m.min(sweep.min_clearance_m);
        if sweep.touched() {
            done.touched = true;
            done.bumpers |= self.bumpers_at(&sweep);
        }
        way * share
    }

    /// Takes a stride along a line, as [`Chassis::roll`] its steps, if nothing can be near; does nothing if something may.
    #[inline]
    pub(super) fn take(
        &mut self,
        stride: &Stride<Line>,
        world: &World,
        done: &mut Executed,
    ) -> bool {
        let from = self.position;
        let mut to = from;
        let steps = stride.ways.map(|way| {
            let before = to;
            to = to + (stride.end.wheels * way).turned(self.slip);
            to - before
        });
        let clearing = &mut self.clearing;
        if !clearing.is_far_on_look(world, from, to, COLLISION_RADIUS_M) {
            return false;
        }
        self.position = to;
        self.odometry = stride.end.odometry;
        for length in steps.map(Point::length) {
            done.traveled_m += length;
        }
        true
    }

    /// Tells the gap where it stands, if none was told on the way.
    #[inline]
    pub(super) fn tell_gap(&mut self, world: &World, done: &mut Executed) {
        let at = self.position;
        if done.min_clearance_m == f64::INFINITY
            && !self.clearing.is_far(world, at, at, COLLISION_RADIUS_M)
        {
            let clearance = self.clearing.clearance(world, at);
            done.min_clearance_m = (clearance - COLLISION_RADIUS_M).max(0.0);
        }
    }

    /// The switch pressed at the end of a sweep, as a bit.
    pub(super) fn bumpers_at(&self, sweep: &Sweep) -> u32 {
        let Some(contact) = sweep.contact else {
            return 0;
        };
        let bearing = (contact - self.position).angle() - self.front;
        let switch = libm::rint(bearing / TAU * f64::from(BUMPERS));
        // A whole number of switches from the front, within ±2 turns.
        1 << (switch as i32).rem_euclid(BUMPERS as i32)
    }
}

/// Share of a way of `length` m that a sweep went.
pub(super) fn share_of(sweep: &Sweep, length: f64) -> f64 {
    if sweep.touched() && length > 0.0 {
        (sweep.traveled_m / length).min(1.0)
    } else {
        1.0
    }
}
