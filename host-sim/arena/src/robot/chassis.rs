//! The body on its wheels: where it is, where its odometry believes to be, and what it touches.

use core::f64::consts::TAU;

use super::motion::Executed;
use super::servo::{ServoStride, TravelLeft};
use crate::noise::Noise;
use crate::nomad::{BUMPERS, COLLISION_RADIUS_M};
use crate::world::{LastWorld, Point, Pose, Sweep, World};

/// Far above any rounding, m.
const SLACK_M: f64 = 1e-6;

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
    /// Gaps of this size or more are not wanted, m.
    gaps_below_m: Option<f64>,
    free: Option<FreeDisc>,
    world: LastWorld,
}

/// A disc in which no surface lies.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FreeDisc {
    center: Point,
    radius_m: f64,
}

impl FreeDisc {
    /// Whether each of these places lies at least `margin_m` inside.
    fn holds(&self, places: [Point; 2], margin_m: f64) -> bool {
        let room = self.radius_m - margin_m;
        let inside = |place: Point| {
            let offset = place - self.center;
            offset.dot(offset) <= room * room
        };
        room > 0.0 && places.into_iter().all(inside)
    }
}

/// A way along the wheels towards a goal, as the odometry has it.
#[derive(Debug, Clone, Copy)]
pub(super) struct RollingWay {
    pub(super) goal: Point,
    /// Unit vector towards the goal.
    pub(super) wheels: Point,
    pub(super) odometry: Point,
}

impl TravelLeft for RollingWay {
    /// Each coordinate nears the goal's or passes it, so neither product grows, and neither does
    /// their sum.
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
            gaps_below_m: None,
            free: None,
            world: LastWorld::default(),
        }
    }

    /// Moves straight by `way`, the truth, up to the first touch.
    pub(super) fn sweep(&mut self, way: Point, world: &World) -> Sweep {
        let (from, to) = (self.position, self.position + way);
        let sweep = world.sweep(from, to, COLLISION_RADIUS_M);
        self.world.is_same(world);
        self.free = (sweep.min_clearance_m > 0.0).then_some(FreeDisc {
            center: to,
            radius_m: COLLISION_RADIUS_M + sweep.min_clearance_m,
        });
        sweep
    }

    /// From now on gaps of `gap_m` m or more are not wanted.
    pub(super) fn tell_gaps_below(&mut self, gap_m: f64) {
        self.gaps_below_m = Some(gap_m);
    }

    /// Whether nothing is touched and no gap is wanted between these places.
    ///
    /// The distance to the nearest surface changes by no more than the way gone (J. C. Hart,
    /// *Sphere tracing*, The Visual Computer 12, 1996), so one look holds for a whole disc.
    #[inline]
    fn passes_freely(&mut self, world: &World, places: [Point; 2]) -> bool {
        let Some(wanted) = self.gaps_below_m else {
            return false;
        };
        let margin = COLLISION_RADIUS_M + wanted.max(0.0) + SLACK_M;
        let same = self.world.is_same(world);
        let holds = |free: FreeDisc| same && free.holds(places, margin);
        self.free.is_some_and(holds) || self.find_free(world, places[0]).holds(places, margin)
    }

    fn find_free(&mut self, world: &World, center: Point) -> FreeDisc {
        let here = world.sweep(center, center, 0.0);
        *self.free.insert(FreeDisc {
            center,
            radius_m: here.min_clearance_m,
        })
    }

    /// Draws the slip of the wheels from now on: of the way (as a share) and of the direction
    /// (rad).
    pub(super) fn slip(&mut self, deviation: f64, noise: &mut Noise) {
        let share = 1.0 + deviation * noise.normal();
        self.slip = Point::unit(deviation * noise.normal()) * share;
    }

    /// Rolls `way` m along the unit vector `wheels`, as the odometry counts, up to the first touch.
    /// Returns how far it got, in m of odometry.
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

    /// Takes a whole stride along a line if no surface is near, with the results of
    /// [`Chassis::roll`] for each step; otherwise does nothing. Returns whether it did.
    #[inline]
    pub(super) fn take(
        &mut self,
        stride: &ServoStride<RollingWay>,
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
        if !self.passes_freely(world, [from, to]) {
            return false;
        }
        self.position = to;
        self.odometry = stride.end.odometry;
        for length in steps.map(Point::length) {
            done.traveled_m += length;
        }
        true
    }

    /// Reports the gap where it stands, if none was reported on the way.
    #[inline]
    pub(super) fn tell_gap(&mut self, world: &World, done: &mut Executed) {
        let at = self.position;
        if done.min_clearance_m == f64::INFINITY && !self.passes_freely(world, [at, at]) {
            done.min_clearance_m = (world.clearance(at) - COLLISION_RADIUS_M).max(0.0);
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

#[cfg(test)]
mod tests;
