//! The body on its wheels: where it is, where its odometry believes to be, and what it touches.

use core::f64::consts::TAU;

use super::{BUMPERS, COLLISION_RADIUS_M, Executed};
use crate::noise::Noise;
use crate::world::{Point, Pose, Sweep, World, wrap_angle};

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
}

impl Chassis {
    /// One whose front looks along the pose's heading.
    pub(super) fn new(pose: Pose) -> Self {
        Self {
            position: pose.position,
            odometry: pose.position,
            front: pose.heading,
            slip: Point::new(1.0, 0.0),
        }
    }

    /// Draws what the wheels will slip from now on: of the way (as a share) and of the direction (rad).
    pub(super) fn slip(&mut self, deviation: f64, noise: &mut Noise) {
        let share = 1.0 + deviation * noise.normal();
        self.slip = Point::unit(deviation * noise.normal()) * share;
    }

    /// Rolls `way` m along `steering` (rad), as the odometry counts, up to the first touch. Returns how far it got, in m
    /// of odometry.
    pub(super) fn roll(
        &mut self,
        way: f64,
        steering: f64,
        world: &World,
        done: &mut Executed,
    ) -> f64 {
        if way == 0.0 {
            return 0.0;
        }
        let believed = Point::unit(steering) * way;
        let truth = believed.turned(self.slip);
        let sweep = world.sweep(self.position, self.position + truth, COLLISION_RADIUS_M);
        let share = share_of(&sweep, truth.length());
        self.position = self.position + truth * share;
        self.odometry = self.odometry + believed * share;
        done.travelled_m += sweep.travelled_m;
        done.min_clearance_m = done.min_clearance_m.min(sweep.min_clearance_m);
        if sweep.touched() {
            done.touched = true;
            done.bumpers |= self.bumpers_at(&sweep);
        }
        way * share
    }

    /// Adds to `done` what has happened since `before`, in the ring's frame as it was then; the ring has turned from
    /// bearing `rings[0]` to `rings[1]`.
    pub(super) fn since(&self, before: &Self, rings: [f64; 2], world: &World, done: &mut Executed) {
        if done.min_clearance_m == f64::INFINITY {
            // Nothing rolled: the gap where it stands.
            done.min_clearance_m = (world.clearance(self.position) - COLLISION_RADIUS_M).max(0.0);
        }
        let ring = Point::unit(rings[0]);
        let truth = (self.position - before.position).turned_back(ring);
        let believed = (self.odometry - before.odometry).turned_back(ring);
        (done.dx_m, done.dy_m) = (truth.x, truth.y);
        (done.odometry_dx_m, done.odometry_dy_m) = (believed.x, believed.y);
        done.turned_rad = wrap_angle(rings[1] - rings[0]);
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
        (sweep.travelled_m / length).min(1.0)
    } else {
        1.0
    }
}
