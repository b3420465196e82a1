//! The body on its wheels: true position, odometry and contacts.

use core::f64::consts::TAU;

use super::motion::Executed;
use super::servo::{RemainingDistance, ServoStride};
use crate::noise::Noise;
use crate::nomad::BUMPERS;
use crate::world::{LastWorld, Point, Pose, Sweep, World};

/// Margin for rounding, m.
const SLACK_M: f64 = 1e-6;

/// A disc on wheels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chassis {
    pub(super) position: Point,
    /// Position without slip.
    pub(super) odometry: Point,
    radius_m: f64,
    /// Bearing of the base, which never turns.
    front: f64,
    /// Complex factor from a displacement in odometry to the true one.
    slip: Point,
    /// Gaps of this size or more need not be reported, m.
    max_reported_gap_m: Option<f64>,
    free: Option<FreeDisc>,
    world: LastWorld,
}

/// A disc without surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FreeDisc {
    center: Point,
    radius_m: f64,
}

impl FreeDisc {
    /// Whether both points lie at least `margin_m` inside.
    fn contains(&self, points: [Point; 2], margin_m: f64) -> bool {
        let room = self.radius_m - margin_m;
        let is_inside = |point: Point| {
            let offset = point - self.center;
            offset.dot(offset) <= room * room
        };
        room > 0.0 && points.into_iter().all(is_inside)
    }
}

/// Straight motion along the wheels towards a goal, in odometry.
#[derive(Debug, Clone, Copy)]
pub(super) struct RollingPath {
    pub(super) goal: Point,
    /// Unit vector towards the goal.
    pub(super) wheels: Point,
    pub(super) odometry: Point,
}

impl RemainingDistance for RollingPath {
    /// Each coordinate moves towards the goal's or passes it, so neither product of the sum
    /// increases.
    fn remaining(&self) -> f64 {
        (self.goal - self.odometry).dot(self.wheels)
    }

    fn advance(&mut self, distance: f64) {
        self.odometry = self.odometry + self.wheels * distance;
    }
}

impl Chassis {
    /// A disc of this radius whose front points along the pose's heading.
    pub(super) fn new(pose: Pose, radius_m: f64) -> Self {
        Self {
            position: pose.position,
            odometry: pose.position,
            radius_m,
            front: pose.heading,
            slip: Point::new(1.0, 0.0),
            max_reported_gap_m: None,
            free: None,
            world: LastWorld::default(),
        }
    }

    /// Moves straight by the true `displacement`, up to the first contact.
    pub(super) fn sweep(&mut self, displacement: Point, world: &World) -> Sweep {
        let (from, to) = (self.position, self.position + displacement);
        let sweep = world.sweep(from, to, self.radius_m);
        self.world.is_same(world);
        self.free = (sweep.min_clearance_m > 0.0).then_some(FreeDisc {
            center: to,
            radius_m: self.radius_m + sweep.min_clearance_m,
        });
        sweep
    }

    /// Gaps of `gap_m` m or more need not be reported from now on.
    pub(super) fn limit_reported_gaps(&mut self, gap_m: f64) {
        self.max_reported_gap_m = Some(gap_m);
    }

    /// Whether a move between these points touches nothing and has no gap to report.
    ///
    /// The distance to the nearest surface changes by at most the distance moved (J. C. Hart,
    /// *Sphere tracing*, The Visual Computer 12, 1996). So one query gives a whole free disc.
    #[inline]
    fn passes_freely(&mut self, world: &World, points: [Point; 2]) -> bool {
        if self.knows_free(world, points) {
            return true;
        }
        let Some(margin) = self.free_margin_m() else {
            return false;
        };
        self.find_free_disc(world, points[0])
            .contains(points, margin)
    }

    /// As [`passes_freely`](Self::passes_freely), without a query: false if not known.
    #[inline]
    fn knows_free(&mut self, world: &World, points: [Point; 2]) -> bool {
        let same = self.world.is_same(world);
        let (free, margin) = (self.free, self.free_margin_m());
        let both = free.zip(margin);
        same && both.is_some_and(|(free, margin)| free.contains(points, margin))
    }

    /// The distance from the body's center within which a surface matters, m; `None` if all do.
    fn free_margin_m(&self) -> Option<f64> {
        let gap_m = self.max_reported_gap_m?;
        Some(self.radius_m + gap_m.max(0.0) + SLACK_M)
    }

    fn find_free_disc(&mut self, world: &World, center: Point) -> FreeDisc {
        let sweep = world.sweep(center, center, 0.0);
        *self.free.insert(FreeDisc {
            center,
            radius_m: sweep.min_clearance_m,
        })
    }

    /// Draws the slip of the wheels from now on: of the distance (as a share) and of the direction
    /// (rad).
    pub(super) fn draw_slip(&mut self, deviation: f64, noise: &mut Noise) {
        let share = 1.0 + deviation * noise.normal();
        self.slip = Point::unit(deviation * noise.normal()) * share;
    }

    /// Rolls `distance` m of odometry along the unit vector `wheels`, up to the first contact.
    /// Returns the distance rolled, in m of odometry.
    pub(super) fn roll(
        &mut self,
        distance: f64,
        wheels: Point,
        world: &World,
        done: &mut Executed,
    ) -> f64 {
        if distance == 0.0 {
            return 0.0;
        }
        let counted = wheels * distance;
        let truth = counted.turned(self.slip);
        let (from, to) = (self.position, self.position + truth);
        if self.knows_free(world, [from, to]) {
            self.position = to;
            self.odometry = self.odometry + counted;
            done.traveled_m += (to - from).length();
            return distance;
        }
        let sweep = self.sweep(truth, world);
        let share = traveled_share(&sweep, truth.length());
        self.position = self.position + truth * share;
        self.odometry = self.odometry + counted * share;
        done.traveled_m += sweep.traveled_m;
        done.min_clearance_m = done.min_clearance_m.min(sweep.min_clearance_m);
        if sweep.touched() {
            done.touched = true;
            done.bumpers |= self.bumpers_at(&sweep);
        }
        distance * share
    }

    /// Applies a whole stride if no surface is near; otherwise does nothing. The result equals
    /// [`Chassis::roll`] for each step. Returns whether the stride was applied.
    #[inline]
    pub(super) fn apply_stride(
        &mut self,
        stride: &ServoStride<RollingPath>,
        world: &World,
        done: &mut Executed,
    ) -> bool {
        let from = self.position;
        let mut to = from;
        let steps = stride.distances.map(|distance| {
            let before = to;
            to = to + (stride.end.wheels * distance).turned(self.slip);
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

    /// Reports the gap at the current position if no step reported one.
    #[inline]
    pub(super) fn report_gap(&mut self, world: &World, done: &mut Executed) {
        let at = self.position;
        if done.min_clearance_m == f64::INFINITY && !self.passes_freely(world, [at, at]) {
            done.min_clearance_m = (world.clearance(at) - self.radius_m).max(0.0);
        }
    }

    /// The bumper switch pressed at the end of a sweep, as a bit.
    pub(super) fn bumpers_at(&self, sweep: &Sweep) -> u32 {
        let Some(contact) = sweep.contact else {
            return 0;
        };
        let bearing = (contact - self.position).angle() - self.front;
        let switch = libm::rint(bearing / TAU * f64::from(BUMPERS));
        // The switch number is within ±2 turns, so it fits an `i32`.
        1 << (switch as i32).rem_euclid(BUMPERS as i32)
    }
}

/// Share of a path of `length` m that a sweep traveled.
pub(super) fn traveled_share(sweep: &Sweep, length: f64) -> f64 {
    if sweep.touched() && length > 0.0 {
        (sweep.traveled_m / length).min(1.0)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests;
